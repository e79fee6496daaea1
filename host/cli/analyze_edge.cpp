// raycube analyze edge: resolution from a slanted edge.
#include <memory>
#include <ostream>

#include <fmt/format.h>

#include "host/analysis/slanted_edge.h"
#include "host/base/error.h"
#include "host/cli/analyze_kit.h"
#include "host/cli/analyze_verbs.h"
#include "host/cli/services.h"

namespace raycube::cli {
namespace {

struct EdgeRequest : AnalyzeRequest {
  double pixel_m = 0;
};

/// Curves of all bands in one table, a row for each place or frequency.
void write_curves(base::OutputFile& file, const std::string& first, const std::vector<std::string>& names,
                  const std::vector<double>& at, const std::vector<const std::vector<double>*>& curves) {
  std::vector<std::string> columns = {first};
  columns.insert(columns.end(), names.begin(), names.end());
  products::CsvWriter writer(file, columns);
  for (std::size_t i = 0; i < at.size(); ++i) {
    writer.add(at[i]);
    for (const auto* curve : curves) writer.add(i < curve->size() ? (*curve)[i] : NAN);
    writer.end_row();
  }
  writer.finish();
}

int edge(const EdgeRequest& request, Invocation& invocation) {
  const analysis::Cube cube = open_cube(invocation, request.cube, request.bands);
  const std::vector<analysis::Region> regions = regions_of(request, cube);
  if (regions.size() != 1)
    throw base::Error(base::Fault::input, fmt::format("an edge is looked for in one region (found {}); give --region "
                                                      "edge=X0:X1,Y0:Y1",
                                                      regions.size()));
  AnalysisFolder folder(invocation, request, "edge");
  const std::vector<analysis::EdgeSpread> bands = analysis::slanted_edge(cube, regions.front());
  std::vector<std::string> names;
  std::vector<const std::vector<double>*> mtf;
  products::CsvWriter summary(folder.table("edge.csv"), {"band", "wavelength_nm", "angle_deg", "low", "high", "fwhm_px",
                                                         "mtf_nyquist", "mtf50_cycles_per_px"});
  const std::vector<double> um = cube.wavelength_um();
  double sums[4] = {0, 0, 0, 0};
  for (std::size_t b = 0; b < bands.size(); ++b) {
    const analysis::EdgeSpread& one = bands[b];
    names.push_back("band " + cube.band_text(b)), mtf.push_back(&one.mtf);
    summary.add(static_cast<std::int64_t>(cube.chosen()[b] + 1)).add(um.empty() ? NAN : 1e3 * um[b]);
    summary.add(one.angle_deg).add(one.low).add(one.high).add(one.fwhm_px).add(one.mtf_nyquist).add(one.mtf50);
    summary.end_row();
    folder.numbers()["edges"].push_back({{"band", names.back()},
                                         {"angle_deg", one.angle_deg},
                                         {"low", one.low},
                                         {"high", one.high},
                                         {"fwhm_px", one.fwhm_px},
                                         {"mtf_nyquist", one.mtf_nyquist},
                                         {"mtf50_cycles_per_px", one.mtf50},
                                         {"at_px", one.at_px},
                                         {"edge_spread", one.spread},
                                         {"line_spread", one.line},
                                         {"mtf", one.mtf}});
    const double values[4] = {one.angle_deg, one.fwhm_px, one.mtf_nyquist, one.mtf50};
    for (int k = 0; k < 4; ++k) sums[k] += values[k] / static_cast<double>(bands.size());
  }
  summary.finish();
  folder.numbers()["frequency_cycles_per_px"] = bands.front().frequency;
  if (request.pixel_m > 0) folder.numbers()["pixel_m"] = request.pixel_m;
  write_curves(folder.table("mtf.csv"), "cycles_per_px", names, bands.front().frequency, mtf);
  std::string text = fmt::format(
      "{} bands, means: edge at {:.2f} deg, line spread {:.3f} px wide at half its maximum, MTF {:.3f} at 0.5 cycles "
      "per "
      "pixel, 0.5 at {:.3f} cycles per pixel\n",
      bands.size(), sums[0], sums[1], sums[2], sums[3]);
  if (request.pixel_m > 0)
    text += fmt::format("in metres: {:.3f} m wide, MTF 0.5 at {:.3f} cycles/m\n", sums[1] * request.pixel_m,
                        sums[3] / request.pixel_m);
  return folder.finish(cube, text);
}

}  // namespace

Verb verb_analyze_edge() {
  auto o = std::make_shared<EdgeRequest>();
  Verb verb("edge", "Edge spread, line spread and modulation transfer of each band, from a slanted edge");
  verb.description =
      "The edge is fitted through the rows' centroids (ISO 12233, annex D) and pixels are sorted by their distance "
      "from "
      "it; the transfer is that of straight lines between them. Frequencies are along the edge's normal, in cycles per "
      "pixel. The region is a "
      "rectangle "
      "with one straight edge that leaves by two opposite sides, at 0.5 to 40 degrees to rows or columns.";
  verb.examples = {"raycube analyze edge cube.img --region edge=20:59,100:139 --pixel 1.0",
                   "raycube analyze edge cube.img --region edge=20:59,100:139 --wavelengths 480:485,1520:1525"};
  verb.common = kOutput;
  verb.output_default = "edge";
  verb.add_options = [o](base::OptionTable& table) {
    add_cube_options(table, *o);
    add_region_options(table, *o, "with the edge");
    table.number("--pixel", "m", 0, 1e6, "Size of a pixel, to tell results in metres too", o->pixel_m);
  };
  verb.run = [o](Invocation& invocation) { return edge(*o, invocation); };
  return verb;
}

}  // namespace raycube::cli
