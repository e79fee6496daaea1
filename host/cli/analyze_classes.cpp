// raycube analyze kmeans | classify: maps of classes, found or taught.
#include <cmath>
#include <cstdlib>
#include <memory>
#include <ostream>

#include <fmt/format.h>

#include "host/analysis/gaussian_classes.h"
#include "host/analysis/k_means.h"
#include "host/analysis/statistics.h"
#include "host/base/error.h"
#include "host/cli/analyze_kit.h"
#include "host/cli/analyze_verbs.h"
#include "host/cli/services.h"

namespace raycube::cli {
namespace {

struct KMeansRequest : AnalyzeRequest {
  analysis::KMeansOptions options;
  double least_change_percent = 0;
};

std::vector<std::string> numbered(int classes) {
  std::vector<std::string> out;
  for (int k = 1; k <= classes; ++k) out.push_back("class " + std::to_string(k));
  return out;
}

int k_means(const KMeansRequest& request, Invocation& invocation) {
  const run::Services services = services_of(invocation);
  const analysis::Cube cube = open_cube(invocation, request.cube, request.bands);
  analysis::KMeansOptions options = request.options;
  options.least_change = request.least_change_percent / 100;
  options.seed = invocation.common.seed.value_or(1);
  AnalysisFolder folder(invocation, request, "kmeans");
  const std::vector<std::string> names = numbered(options.classes);
  analysis::MapFiles map =
      analysis::MapFiles::of_classes(folder.set(), "kmeans", cube, names, "Classes of " + cube.path() + " by k-means");
  const analysis::KMeans found = analysis::k_means(cube, options, {services.threads});
  analysis::for_each_part(cube, ShownPass(services, "map", cube), [&](std::size_t, const analysis::Pixels& pixels) {
    const auto first = found.number.begin() + pixels.first_line * pixels.samples;
    map.write(pixels, std::vector<double>(first, first + static_cast<std::ptrdiff_t>(pixels.count())));
  });
  map.finish();

  const bool settled = found.changed <= options.least_change;
  if (!settled)
    services.log.warning(
        fmt::format("{:.3g} % of the pixels still changed their class in round {}; more rounds: "
                    "--rounds",
                    100 * found.changed, found.rounds));
  std::string text =
      fmt::format("{} rounds, {:.3g} % of the pixels changed in the last\n", found.rounds, 100 * found.changed);
  std::vector<std::vector<double>> centers;
  for (std::size_t k = 0; k < names.size(); ++k) {
    centers.push_back(list_of(found.center.row(static_cast<Eigen::Index>(k))));
    folder.numbers()["classes"].push_back({{"name", names[k]}, {"pixels", found.count[k]}, {"center", centers.back()}});
    text += fmt::format("{}: {} pixels\n", names[k], found.count[k]);
    if (found.count[k] == 0) services.log.warning(names[k] + ": no pixel is nearest to its centre; it stays empty");
  }
  folder.numbers()["rounds"] = found.rounds, folder.numbers()["changed"] = found.changed;
  folder.numbers()["rms_apart"] = found.rms_apart;
  write_spectra_table(folder.table("centers.csv"), cube, names, centers);
  return folder.finish(cube, text);
}

struct ClassifyRequest : AnalyzeRequest {
  std::vector<std::string> truth, priors;
  std::string truth_classes;
  double shrink = 0;
};

std::vector<double> priors_of(const ClassifyRequest& request, const std::vector<std::string>& names) {
  if (request.priors.empty()) return {};
  std::vector<double> out(names.size(), -1);
  for (const std::string& text : request.priors) {
    const auto equals = text.find('=');
    std::size_t k = 0;
    while (k < names.size() && names[k] != text.substr(0, equals)) ++k;
    char* end = nullptr;
    const double share = equals == std::string::npos ? -1 : std::strtod(text.c_str() + equals + 1, &end);
    if (k == names.size() || !(share > 0) || !std::isfinite(share) || *end != '\0')
      throw base::Error(base::Fault::input, fmt::format("prior \"{}\": give CLASS=SHARE, above 0; the classes are {}",
                                                        text, fmt::join(names, ", ")));
    out[k] = share;
  }
  for (std::size_t k = 0; k < names.size(); ++k)
    if (out[k] < 0) throw base::Error(base::Fault::input, "class \"" + names[k] + "\" has no --prior, others have");
  return out;
}

std::string confusion_text(const analysis::Confusion& confusion) {
  std::string text = fmt::format("{:<20}", "truth \\ map");
  for (const std::string& name : confusion.names) text += fmt::format(" {:>12}", name);
  text += fmt::format(" {:>12}\n", "none");
  for (std::size_t i = 0; i < confusion.count.size(); ++i) {
    text += fmt::format("{:<20}", confusion.names[i]);
    for (const std::uint64_t n : confusion.count[i]) text += fmt::format(" {:>12}", n);
    text += "\n";
  }
  return text + fmt::format("accuracy {:.4f}, kappa {:.4f}\n", confusion.accuracy(), confusion.kappa());
}

int classify(const ClassifyRequest& request, Invocation& invocation) {
  const run::Services services = services_of(invocation);
  const analysis::Cube cube = open_cube(invocation, request.cube, request.bands);
  const std::vector<analysis::Region> regions = regions_of(request, cube);
  if (regions.size() < 2)
    throw base::Error(base::Fault::input, "classes are taught by two regions or more: --region NAME=WHAT, --classes");
  AnalyzeRequest of_truth = request;
  of_truth.regions = request.truth, of_truth.classes = request.truth_classes;
  const std::vector<analysis::Region> truth = regions_of(of_truth, cube);
  std::vector<std::string> names;
  for (const analysis::Region& region : regions) names.push_back(region.name());
  analysis::ConfusionCount counted(names, truth);
  AnalysisFolder folder(invocation, request, "classify");
  const auto moments = analysis::region_moments(cube, regions, ShownPass(services, "classes", cube));
  const analysis::GaussianClasses classes(names, moments, priors_of(request, names), request.shrink);
  analysis::MapFiles map = analysis::MapFiles::of_classes(folder.set(), "classify", cube, names,
                                                          "Classes of " + cube.path() + " by maximum likelihood");
  std::vector<std::vector<std::uint64_t>> part(analysis::kMostParts, std::vector<std::uint64_t>(names.size() + 1, 0));
  analysis::for_each_part(cube, ShownPass(services, "map", cube),
                          [&](std::size_t number, const analysis::Pixels& pixels) {
                            std::vector<double> found;
                            classes.classify(pixels, found);
                            for (const double k : found) ++part[number][static_cast<std::size_t>(k)];
                            counted.add(number, pixels, found);
                            map.write(pixels, found);
                          });
  map.finish();

  std::string text;
  for (std::size_t k = 0; k < names.size(); ++k) {
    std::uint64_t pixels = 0;
    for (const auto& one : part) pixels += one[k + 1];
    folder.numbers()["classes"].push_back({{"name", names[k]},
                                           {"taught_by", moments[k].count()},
                                           {"pixels", pixels},
                                           {"mean", list_of(moments[k].mean())}});
    text += fmt::format("{}: taught by {} pixels, {} in the map\n", names[k], moments[k].count(), pixels);
  }
  folder.numbers()["shrink"] = request.shrink;
  if (!truth.empty()) {
    const analysis::Confusion confusion = counted.result();
    if (confusion.total() == 0)
      throw base::Error(base::Fault::input, "no pixel of the truth has finite numbers that are not ignored");
    folder.numbers()["confusion"] = {{"names", names},
                                     {"count", confusion.count},
                                     {"accuracy", confusion.accuracy()},
                                     {"kappa", confusion.kappa()},
                                     {"producer", confusion.producer()},
                                     {"user", confusion.user()}};
    text += confusion_text(confusion);
  }
  return folder.finish(cube, text);
}

}  // namespace

Verb verb_analyze_kmeans() {
  auto o = std::make_shared<KMeansRequest>();
  Verb verb("kmeans", "Find classes of pixels by k-means");
  verb.description =
      "Lloyd's rounds until no more than --change of the pixels change their class. Centres start along the mean, from "
      "one standard deviation of each band below it to one above (--start spread), or at pixels drawn by how far they "
      "are from those before (plusplus, --seed). kmeans.img and kmeans.tif are maps of classes, centers.csv has their "
      "means. Takes some 90 bytes of memory a pixel; float32 cubes in BIP are looked at where they lie, others read "
      "anew "
      "each round.";
  verb.examples = {"raycube analyze kmeans cube.img --count 5",
                   "raycube analyze kmeans cube.img --start plusplus --seed 7"};
  verb.common = kOutput | kThreads | kSeed;
  verb.output_default = "kmeans";
  verb.add_options = [o](base::OptionTable& table) {
    add_cube_options(table, *o);
    table.integer("--count", "", 1, 1000, "Classes", o->options.classes);
    table.choice("--start", {"spread", "plusplus"}, "Where centres start", o->options.start);
    table.number("--change", "%", 0, 100, "Ends when no larger share of pixels changes its class",
                 o->least_change_percent);
    table.integer("--rounds", "", 1, 100000, "Rounds at most", o->options.most_rounds);
  };
  verb.run = [o](Invocation& invocation) { return k_means(*o, invocation); };
  return verb;
}

Verb verb_analyze_classify() {
  auto o = std::make_shared<ClassifyRequest>();
  Verb verb("classify", "Classes by Gaussian maximum likelihood, taught by regions");
  verb.description =
      "Each --region (or class of --classes) teaches a mean and a covariance; a pixel belongs to the class whose "
      "probability density, times its prior, is highest. A class of fewer pixels than bands has no covariance that can "
      "be inverted, and is refused: choose bands, or --shrink it towards its mean variance. classify.img and "
      "classify.tif are maps of classes. With --truth or --truth-classes a confusion matrix (rows: truth), accuracy, "
      "Cohen's kappa, producer's and user's accuracies are told; names must be the classes'.";
  verb.examples = {
      "raycube analyze classify cube.img --region grass=0:20,0:20 --region sand=30:50,0:20 --truth grass=0:20,30:50",
      "raycube analyze classify cube.img --classes training.img --truth-classes truth.img --shrink 0.01"};
  verb.common = kOutput | kThreads;
  verb.output_default = "classify";
  verb.add_options = [o](base::OptionTable& table) {
    add_cube_options(table, *o);
    add_region_options(table, *o, "that teaches a class");
    table.texts("--truth", "NAME=WHAT", "Where a class really is, as --region", o->truth);
    table.text("--truth-classes", "FILE", "A raster of what the classes really are", o->truth_classes);
    table.texts("--prior", "CLASS=SHARE", "How often a class comes", o->priors).default_text = "all alike";
    table.number("--shrink", "", 0, 1, "Share of the mean variance in each covariance", o->shrink);
  };
  verb.run = [o](Invocation& invocation) { return classify(*o, invocation); };
  return verb;
}

}  // namespace raycube::cli
