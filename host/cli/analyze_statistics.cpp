// raycube analyze statistics: mean, spread and range of regions, band by band.
#include <memory>
#include <ostream>

#include <fmt/format.h>

#include "host/analysis/statistics.h"
#include "host/base/error.h"
#include "host/cli/analyze_kit.h"
#include "host/cli/analyze_verbs.h"
#include "host/cli/services.h"

namespace raycube::cli {
namespace {

/// Region, or the whole image.
std::vector<analysis::Region> regions_or_all(const AnalyzeRequest& request, const analysis::Cube& cube) {
  std::vector<analysis::Region> out = regions_of(request, cube);
  if (out.empty())
    out.push_back(analysis::region_where("image", cube.samples(), cube.lines(), [](auto, auto) { return true; }));
  return out;
}

int statistics(const AnalyzeRequest& request, Invocation& invocation) {
  const run::Services services = services_of(invocation);
  const analysis::Cube cube = open_cube(invocation, request.cube, request.bands);
  const std::vector<analysis::Region> regions = regions_or_all(request, cube);
  AnalysisFolder folder(invocation, request, "statistics");
  const auto all = analysis::region_statistics(cube, regions, ShownPass(services, "statistics", cube));

  std::vector<std::string> columns;
  std::vector<std::vector<double>> values;
  std::string text = fmt::format("{:<24} {:>10} {:>10} {:>12} {:>12} {:>12}\n", "region", "pixels", "left out", "mean",
                                 "deviation", "signal/noise");
  for (const analysis::RegionStatistics& one : all) {
    nlohmann::ordered_json json = {{"region", one.name}, {"pixels", one.pixels()}, {"left_out", one.left_out}};
    const auto add = [&](const char* name, const auto& of) {
      std::vector<double> column;
      for (const auto& band : one.band) column.push_back(of(band));
      columns.push_back(one.name + "_" + name), values.push_back(column), json[name] = column;
    };
    add("mean", [](const auto& band) { return band.mean; });
    add("standard_deviation", [](const auto& band) { return band.standard_deviation(); });
    add("minimum", [](const auto& band) { return band.min; });
    add("maximum", [](const auto& band) { return band.max; });
    folder.numbers()["regions"].push_back(json);
    const products::BandStatistics merged = products::merged(one.band);
    double ratio = 0;  // mean over bands
    for (const auto& band : one.band)
      ratio += band.mean / band.standard_deviation() / static_cast<double>(cube.bands());
    text += fmt::format("{:<24} {:>10} {:>10} {:>12.6g} {:>12.6g} {:>12.4g}\n", one.name, one.pixels(), one.left_out,
                        merged.mean, merged.standard_deviation(), ratio);
  }
  write_spectra_table(folder.table("statistics.csv"), cube, columns, values);
  return folder.finish(cube, text);
}

}  // namespace

Verb verb_analyze_statistics() {
  auto o = std::make_shared<AnalyzeRequest>();
  Verb verb("statistics", "Take mean, standard deviation and range of regions, band by band");
  verb.description =
      "Of each region (without any, the whole image) statistics.csv has a column for mean, sample standard deviation, "
      "minimum and maximum, in the cube's unit; signal/noise in the text is the mean over bands of mean over standard "
      "deviation. Pixels that are not finite in some band, or hold the header's ignore value in all, are left out and "
      "counted.";
  verb.examples = {"raycube analyze statistics cube.img --region black=10:19,40:49 --region white=30:39,40:49",
                   "raycube analyze statistics cube.img --classes classes.img --wavelengths 418:643 -o out"};
  verb.common = kOutput | kThreads;
  verb.output_default = "statistics";
  verb.add_options = [o](base::OptionTable& table) {
    add_cube_options(table, *o);
    add_region_options(table, *o, "whose statistics are taken");
  };
  verb.run = [o](Invocation& invocation) { return statistics(*o, invocation); };
  return verb;
}

}  // namespace raycube::cli
