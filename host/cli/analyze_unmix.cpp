// raycube analyze unmix: shares of endmembers in each pixel.
#include <memory>
#include <ostream>

#include <fmt/format.h>

#include "host/analysis/statistics.h"
#include "host/analysis/unmixing.h"
#include "host/base/error.h"
#include "host/cli/analyze_kit.h"
#include "host/cli/analyze_verbs.h"
#include "host/cli/services.h"
#include "host/products/cube_statistics.h"

namespace raycube::cli {
namespace {

struct UnmixRequest : AnalyzeRequest {
  std::vector<std::string> endmembers;
  std::string constraint = "full";
};

/// Means of the layers over regions, and over the image.
class Means {
 public:
  Means(const std::vector<analysis::Region>& regions, std::size_t layers)
      : regions_(regions),
        layers_(layers),
        part_(analysis::kMostParts, std::vector(regions.size(), std::vector<products::BandStatistics>(layers))) {}

  void add(std::size_t part, const analysis::Pixels& pixels, const std::vector<double>& value) {
    analysis::for_each_in(regions_, pixels, [&](std::size_t r, std::size_t p) {
      if (!pixels.counts[p]) return;
      for (std::size_t k = 0; k < layers_; ++k) part_[part][r][k].add(value[p * layers_ + k]);
    });
  }
  products::BandStatistics of(std::size_t region, std::size_t layer) const {
    products::BandStatistics out;
    for (const auto& part : part_) out.merge(part[region][layer]);
    return out;
  }

 private:
  const std::vector<analysis::Region>& regions_;
  std::size_t layers_;
  std::vector<std::vector<std::vector<products::BandStatistics>>> part_;
};

int unmix(const UnmixRequest& request, Invocation& invocation) {
  const run::Services services = services_of(invocation);
  const analysis::Cube cube = open_cube(invocation, request.cube, request.bands);
  std::vector<analysis::Region> regions = regions_of(request, cube);
  for (const analysis::Region& region : regions)
    if (region.name() == "image")
      throw base::Error(base::Fault::input, "a region cannot be called \"image\", which is the whole");
  regions.push_back(analysis::region_where("image", cube.samples(), cube.lines(), [](auto, auto) { return true; }));
  AnalysisFolder folder(invocation, request, "unmix");
  const auto endmembers = analysis::read_spectra(request.endmembers, cube, ShownPass(services, "endmembers", cube));
  const analysis::Unmixing unmixing(endmembers, analysis::parse_constraint(request.constraint));
  std::vector<std::string> layers;
  for (const auto& one : endmembers) layers.push_back(one.name);
  layers.push_back("rms left");
  analysis::MapFiles maps(folder.set(), "unmix", cube, layers, "Shares of endmembers in " + cube.path());
  Means means(regions, layers.size());
  analysis::for_each_part(cube, ShownPass(services, "unmix", cube),
                          [&](std::size_t part, const analysis::Pixels& pixels) {
                            std::vector<double> shares;
                            unmixing.solve(pixels, shares);
                            means.add(part, pixels, shares);
                            maps.write(pixels, shares);
                          });
  maps.finish();

  std::string text = fmt::format("{:<20}", "region");
  for (const std::string& layer : layers) text += fmt::format(" {:>14}", layer);
  text += "\n";
  for (std::size_t r = 0; r < regions.size(); ++r) {
    nlohmann::ordered_json json = {{"region", regions[r].name()}, {"pixels", means.of(r, 0).count}};
    if (means.of(r, 0).count == 0)
      throw base::Error(base::Fault::input, "no pixel of the region \"" + regions[r].name() +
                                                "\" has finite numbers that are not the header's ignore value");
    text += fmt::format("{:<20}", regions[r].name());
    for (std::size_t k = 0; k < layers.size(); ++k) {
      const products::BandStatistics of = means.of(r, k);
      json["mean"].push_back(of.mean), json["standard_deviation"].push_back(of.standard_deviation());
      text += fmt::format(" {:>14.6g}", of.mean);
    }
    folder.numbers()["regions"].push_back(json), text += "\n";
  }
  folder.numbers()["layers"] = layers, folder.numbers()["constraint"] = request.constraint;
  std::vector<std::vector<double>> spectra;
  for (const auto& one : endmembers) {
    spectra.push_back(list_of(one.value));
    folder.numbers()["endmembers"].push_back(
        {{"name", one.name}, {"from", one.source}, {"spectrum", list_of(one.value)}});
  }
  layers.pop_back();
  write_spectra_table(folder.table("endmembers.csv"), cube, layers, spectra);
  return folder.finish(cube, text);
}

}  // namespace

Verb verb_analyze_unmix() {
  auto o = std::make_shared<UnmixRequest>();
  Verb verb("unmix", "Take each pixel apart into shares of endmembers");
  verb.description =
      "Least squares of x = E a. With --constraint full, shares sum to 1 and none is below 0: the exact solution, by "
      "active sets. unmix.img and unmix.tif have a layer of shares for each endmember and the root mean square of what "
      "they leave, in the cube's unit. The text and unmix.json have means over regions and the image.\n\n"
      "An endmember is a region's mean, in the cube's unit, or a reflectance from a file, which asks for a cube of "
      "reflectance.";
  verb.examples = {
      "raycube analyze unmix cube.img --endmember felt=10:12,40:42 --endmember cotton=20:22,40:42 --region "
      "mix=30:35,40:45",
      "raycube analyze unmix reflectance.img --endmember felt=felt.csv --endmember cotton=cotton.csv"};
  verb.common = kOutput | kThreads;
  verb.output_default = "unmix";
  verb.add_options = [o](base::OptionTable& table) {
    add_cube_options(table, *o);
    table.texts("--endmember", "NAME=WHAT", "2 to 12: FILE.csv, FILE.sli@NAME, or a region of the cube", o->endmembers);
    table.choice("--constraint", {"full", "sum", "none"}, "What shares keep: sum 1 and none below 0; sum 1; nothing",
                 o->constraint);
    add_region_options(table, *o, "over which shares are averaged");
  };
  verb.run = [o](Invocation& invocation) { return unmix(*o, invocation); };
  return verb;
}

}  // namespace raycube::cli
