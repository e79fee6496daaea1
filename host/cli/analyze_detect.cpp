// raycube analyze detect: maps of how like a target each pixel is.
#include <algorithm>
#include <memory>
#include <ostream>

#include <fmt/format.h>

#include "host/analysis/detection.h"
#include "host/base/error.h"
#include "host/base/text.h"
#include "host/cli/analyze_kit.h"
#include "host/cli/analyze_verbs.h"
#include "host/cli/services.h"

namespace raycube::cli {
namespace {

struct DetectRequest : AnalyzeRequest {
  std::vector<std::string> targets, detectors, background, without;
  double shrink = 0;
};

/// Pixels whose mean and covariance are the background's; empty: all.
analysis::Chooses background_of(const DetectRequest& request, const analysis::Cube& cube) {
  std::vector<analysis::Region> in, out;
  for (const std::string& text : request.background) in.push_back(analysis::read_region(text, cube));
  for (const std::string& text : request.without) out.push_back(analysis::read_region(text, cube));
  if (in.empty() && out.empty()) return {};
  return [in, out](std::int64_t line, std::int64_t sample) {
    const auto holds = [&](const analysis::Region& region) { return region.holds(line, sample); };
    return (in.empty() || std::any_of(in.begin(), in.end(), holds)) && std::none_of(out.begin(), out.end(), holds);
  };
}

/// Score of each layer that is most like a target, and where it is: the highest, of angles the lowest.
struct Peak {
  double score = -HUGE_VAL;
  std::int64_t line = 0, sample = 0;
};

int detect(const DetectRequest& request, Invocation& invocation) {
  const run::Services services = services_of(invocation);
  const analysis::Cube cube = open_cube(invocation, request.cube, request.bands);
  AnalysisFolder folder(invocation, request, "detect");
  const std::vector<std::string> names =
      request.detectors.empty() ? std::vector<std::string>{"ace"} : request.detectors;
  const auto targets = analysis::read_spectra(request.targets, cube, ShownPass(services, "targets", cube));
  const analysis::Moments background =
      analysis::moments_of(cube, ShownPass(services, "background", cube), background_of(request, cube));
  const analysis::Detection detection(names, targets, background, request.shrink);
  analysis::MapFiles maps(folder.set(), "detect", cube, detection.layers(), "Scores of detectors of " + cube.path());
  const auto of_angle = [&](std::size_t layer) { return detection.layers()[layer].starts_with("sam "); };
  std::vector<std::vector<Peak>> peak(analysis::kMostParts, std::vector<Peak>(detection.layers().size()));
  analysis::for_each_part(cube, ShownPass(services, "detect", cube),
                          [&](std::size_t part, const analysis::Pixels& pixels) {
                            std::vector<double> scores;
                            detection.score(pixels, scores);
                            for (std::size_t i = 0; i < scores.size(); ++i) {
                              Peak& best = peak[part][i % detection.layers().size()];
                              const auto p = static_cast<std::int64_t>(i / detection.layers().size());
                              const std::size_t layer = i % detection.layers().size();
                              const double sign = of_angle(layer) ? -1 : 1;
                              if (sign * scores[i] > best.score)
                                best = {sign * scores[i], pixels.first_line + p / pixels.samples, p % pixels.samples};
                            }
                            maps.write(pixels, scores);
                          });
  maps.finish();

  std::string text = fmt::format("background of {}, {}\n", base::counted(background.count(), "pixel"),
                                 base::counted(static_cast<std::size_t>(cube.bands()), "band"));
  for (std::size_t k = 0; k < detection.layers().size(); ++k) {
    Peak best;
    for (const auto& part : peak)
      if (part[k].score > best.score) best = part[k];
    const char* const which = of_angle(k) ? "lowest" : "highest";
    if (of_angle(k)) best.score = -best.score;
    folder.numbers()["layers"].push_back(
        {{"layer", detection.layers()[k]}, {which, best.score}, {"line", best.line}, {"sample", best.sample}});
    text += fmt::format("{}: {} {:.6g} at line {}, sample {}\n", detection.layers()[k], which, best.score, best.line,
                        best.sample);
  }
  folder.numbers()["background"] = {{"pixels", background.count()}, {"shrink", request.shrink}};
  folder.numbers()["background"]["mean"] = list_of(background.mean());
  for (const analysis::NamedSpectrum& target : targets)
    folder.numbers()["targets"].push_back(
        {{"name", target.name}, {"from", target.source}, {"spectrum", list_of(target.value)}});
  return folder.finish(cube, text);
}

}  // namespace

Verb verb_analyze_detect() {
  auto o = std::make_shared<DetectRequest>();
  Verb verb("detect", "Map how like a target each pixel is: matched filter, ACE, CEM, SAM, RX");
  verb.description =
      "detect.img and detect.tif have a layer for each detector and target. mf: 1 for a whole pixel of target. ace: 0 "
      "to "
      "1; ace_signed has the matched filter's sign. cem: 1 for a whole pixel. sam: angle, rad, 0 for the target's own "
      "direction. rx: distance from the background, in its own covariance; no target. Formulas: docs/analysis.md.\n\n"
      "Mean and covariance are of the whole image unless --background names regions; --without leaves regions out, "
      "targets for one. A covariance of fewer pixels than bands cannot be inverted: choose bands, or --shrink it "
      "towards "
      "the mean variance.\n\n"
      "A target is a region's mean, in the cube's unit, or a reflectance from a file, which asks for a cube of "
      "reflectance (raycube analyze reflectance).";
  verb.examples = {"raycube analyze detect reflectance.img --target green=green_wood.csv --detector ace --detector sam",
                   "raycube analyze detect cube.img --target panel=10:12,40:42 --without panel=8:14,38:44",
                   "raycube analyze detect cube.img --detector rx"};
  verb.common = kOutput | kThreads;
  verb.output_default = "detect";
  verb.add_options = [o](base::OptionTable& table) {
    add_cube_options(table, *o);
    table.texts("--target", "NAME=WHAT", "What is looked for: FILE.csv, FILE.sli@NAME, or a region of the cube",
                o->targets);
    table
        .texts("--detector", "NAME", fmt::format("Detectors: {}", fmt::join(analysis::detector_names(), ", ")),
               o->detectors)
        .default_text = "ace";
    table.texts("--background", "NAME=WHAT", "Regions whose mean and covariance are the background's", o->background);
    table.texts("--without", "NAME=WHAT", "Regions that are left out of it", o->without);
    table.number("--shrink", "", 0, 1, "Share of the mean variance in the covariance", o->shrink);
  };
  verb.run = [o](Invocation& invocation) { return detect(*o, invocation); };
  return verb;
}

}  // namespace raycube::cli
