// raycube analyze register | scorecard: two cubes of one scene, or of one kind of scene.
#include <algorithm>
#include <memory>
#include <ostream>

#include <fmt/format.h>

#include "host/analysis/likeness.h"
#include "host/analysis/registration.h"
#include "host/base/error.h"
#include "host/cli/analyze_kit.h"
#include "host/cli/analyze_verbs.h"
#include "host/cli/services.h"

namespace raycube::cli {
namespace {

struct RegisterRequest : AnalyzeRequest {
  std::string other, other_bands;
  int factor = 1, other_factor = 1, reach = 8, block = 64;
};

/// Mean of the bands that take part.
analysis::Picture picture_of(const analysis::Cube& cube, int factor, const analysis::Pass& pass) {
  analysis::Picture out{static_cast<std::size_t>(cube.samples()), static_cast<std::size_t>(cube.lines()), {}};
  out.value.resize(cube.pixels());
  analysis::for_each_part(cube, pass, [&](std::size_t, const analysis::Pixels& pixels) {
    const auto first = static_cast<std::size_t>(pixels.first_line * pixels.samples);
    for (std::size_t p = 0; p < pixels.count(); ++p) {
      double sum = 0;
      for (std::size_t b = 0; b < pixels.bands; ++b) sum += pixels.at(p)[b];
      out.value[first + p] = pixels.counts[p] ? sum / static_cast<double>(pixels.bands) : NAN;
    }
  });
  return factor > 1 ? analysis::averaged(out, static_cast<std::size_t>(factor)) : out;
}

nlohmann::ordered_json json_of(const analysis::Shift& shift) {
  return {{"found", shift.found},
          {"samples", shift.samples},
          {"lines", shift.lines},
          {"samples_error", shift.samples_error},
          {"lines_error", shift.lines_error},
          {"correlation", shift.correlation}};
}

int register_cubes(const RegisterRequest& request, Invocation& invocation) {
  if (request.other.empty()) throw base::Error(base::Fault::input, "give the second cube: --other CUBE");
  const run::Services services = services_of(invocation);
  const analysis::Cube cube = open_cube(invocation, request.cube, request.bands);
  const analysis::Cube other =
      open_cube(invocation, request.other,
                request.other_bands.empty() ? request.bands : analysis::BandChoice{request.other_bands, ""});
  AnalysisFolder folder(invocation, request, "register");
  const analysis::Picture first = picture_of(cube, request.factor, ShownPass(services, "first", cube)),
                          second = picture_of(other, request.other_factor, ShownPass(services, "second", other));
  const auto side = static_cast<std::size_t>(request.block);
  const analysis::Shift whole = analysis::shift_of(first, second, 0, 0, first.samples, first.lines, request.reach);
  if (!whole.found)
    throw base::Error(base::Fault::input,
                      fmt::format("{} and {}: no shift within {} pixels makes them alike; a larger --reach, other "
                                  "--bands, or --factor for pixels of other sizes",
                                  cube.path(), other.path(), request.reach));
  products::CsvWriter table(folder.table("register.csv"), {"sample", "line", "shift_samples", "shift_lines",
                                                           "error_samples", "error_lines", "correlation"});
  double worst = 0;
  int count = 0;
  folder.numbers()["blocks"] = nlohmann::json::array();
  for (std::size_t top = 0; top + side <= first.lines; top += side)
    for (std::size_t left = 0; left + side <= first.samples; left += side) {
      const analysis::Shift here = analysis::shift_of(first, second, left, top, side, side, request.reach);
      if (!here.found) continue;
      const double x = static_cast<double>(left) + 0.5 * static_cast<double>(side - 1),
                   y = static_cast<double>(top) + 0.5 * static_cast<double>(side - 1);
      table.add(x).add(y).add(here.samples).add(here.lines).add(here.samples_error).add(here.lines_error);
      table.add(here.correlation).end_row();
      nlohmann::ordered_json json = json_of(here);
      json["sample"] = x, json["line"] = y;
      folder.numbers()["blocks"].push_back(json);
      worst = std::max(worst, std::hypot(here.samples - whole.samples, here.lines - whole.lines)), ++count;
    }
  table.finish();
  folder.numbers()["whole"] = json_of(whole), folder.numbers()["other"] = other.path();
  folder.numbers()["worst_block_px"] = worst;
  return folder.finish(
      cube, fmt::format("the second lies {:.4f} +- {:.4f} samples and {:.4f} +- {:.4f} lines further; correlation "
                        "{:.5f}\n{} blocks of {} pixels are up to {:.3f} pixels from that\n",
                        whole.samples, whole.samples_error, whole.lines, whole.lines_error, whole.correlation, count,
                        request.block, worst));
}

struct ScorecardRequest : AnalyzeRequest {
  std::string other;
  int count = 4;
};

int scorecard(const ScorecardRequest& request, Invocation& invocation) {
  if (request.other.empty()) throw base::Error(base::Fault::input, "give the second cube: --other CUBE");
  const run::Services services = services_of(invocation);
  const analysis::Cube cube = open_cube(invocation, request.cube, request.bands),
                       other = open_cube(invocation, request.other, request.bands);
  analysis::require_same_bands(cube, other);
  AnalysisFolder folder(invocation, request, "scorecard");
  const auto moments = [&](const analysis::Cube& of) {
    const analysis::Moments found = analysis::moments_of(of, ShownPass(services, "covariance", of));
    if (found.count() < 2)
      throw base::Error(base::Fault::input, of.path() + ": two pixels or more must be finite and not ignored");
    return found;
  };
  const analysis::Moments first = moments(cube), second = moments(other);
  const analysis::SortedBands sorted(cube, ShownPass(services, "distributions", cube)),
      other_sorted(other, ShownPass(services, "distributions", other));
  const auto scores = analysis::likeness(first, sorted, second, other_sorted, static_cast<std::size_t>(request.count));
  products::CsvWriter table(folder.table("scorecard.csv"), {"metric", "unit", "value", "where_alike"});
  std::string text;
  for (const analysis::Score& score : scores) {
    table.add(std::string_view(score.name))
        .add(std::string_view(score.unit))
        .add(score.value)
        .add(score.alike)
        .end_row();
    folder.numbers()["scores"].push_back(
        {{"metric", score.name}, {"unit", score.unit}, {"value", score.value}, {"where_alike", score.alike}});
    text +=
        fmt::format("{:<62} {:>12.5g} {:<4} ({:g} where alike)\n", score.name, score.value, score.unit, score.alike);
  }
  table.finish();
  folder.numbers()["other"] = other.path();
  for (const auto* of : {&first, &second})
    folder.numbers()["means"].push_back(list_of(of->mean())),
        folder.numbers()["deviations"].push_back(list_of(of->covariance().diagonal().cwiseSqrt()));
  return folder.finish(cube, text);
}

}  // namespace

Verb verb_analyze_register() {
  auto o = std::make_shared<RegisterRequest>();
  Verb verb("register", "How far two images of one scene are shifted against each other, to parts of a pixel");
  verb.description =
      "The mean of the bands that take part is compared: whole pixels by correlation within --reach, then least "
      "squares "
      "of shift, gain and offset, with standard errors; for the whole image, and for blocks of --block pixels, which "
      "tell "
      "of turns, scales and keystone. Where pixels are of other sizes, --factor and --other-factor average them to "
      "one. "
      "Bands of one cube against others of it: give it twice, with --bands and --other-bands.";
  verb.examples = {"raycube analyze register spectir.img --bands 40 --other wasp.img --other-bands 1 --other-factor 10",
                   "raycube analyze register cube.img --bands 20 --other cube.img --other-bands 300"};
  verb.common = kOutput | kThreads;
  verb.output_default = "register";
  verb.add_options = [o](base::OptionTable& table) {
    add_cube_options(table, *o);
    table.text("--other", "CUBE", "The second image", o->other);
    table.text("--other-bands", "LIST", "Its bands", o->other_bands).default_text = "as the first's";
    table.integer("--factor", "px", 1, 1000, "Pixels of the first that are averaged to one, along each side",
                  o->factor);
    table.integer("--other-factor", "px", 1, 1000, "Pixels of the second", o->other_factor);
    table.integer("--reach", "px", 0, 200, "Largest shift that is looked for", o->reach);
    table.integer("--block", "px", 16, 100000, "Side of the blocks", o->block);
  };
  verb.run = [o](Invocation& invocation) { return register_cubes(*o, invocation); };
  return verb;
}

Verb verb_analyze_scorecard() {
  auto o = std::make_shared<ScorecardRequest>();
  Verb verb("scorecard", "How alike two cubes are: means, spreads, distributions, eigenstructure");
  verb.description =
      "For a real and a simulated cube of one kind of scene, which need not be of one size: rms difference of the "
      "bands' "
      "means, angle between the mean spectra, ratio of the standard deviations, Kolmogorov and Smirnov's distance of "
      "the "
      "distributions (of up to 100 000 pixels each), angles between the spaces of the first eigenvectors, shares of "
      "the "
      "eigenvalues. MTF, detection and classes have verbs of their own.";
  verb.examples = {"raycube analyze scorecard real.img --other simulated.img"};
  verb.common = kOutput | kThreads;
  verb.output_default = "scorecard";
  verb.add_options = [o](base::OptionTable& table) {
    add_cube_options(table, *o);
    table.text("--other", "CUBE", "The second cube, of the same bands", o->other);
    table.integer("--count", "", 1, 100, "Eigenvectors that are compared", o->count);
  };
  verb.run = [o](Invocation& invocation) { return scorecard(*o, invocation); };
  return verb;
}

}  // namespace raycube::cli
