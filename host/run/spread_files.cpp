#include "host/run/spread_files.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/products/csv_writer.h"
#include "host/products/envi_writer.h"

namespace raycube::run {
namespace {

constexpr double kStep = 0.05;  ///< cycles a pixel, of mtf.csv

void write_mtf(const sensors::Cells& cells, base::OutputFile& file) {
  products::CsvWriter table(file, {"band", "wavelength_nm", "focal_plane", "cycles_per_pixel", "mtf_across",
                                   "mtf_along", "asked_across", "asked_along"});
  std::vector<sensors::OpticalTransfer> optics;
  for (const scene::FocalPlane& plane : cells.seen.focal_planes)
    optics.emplace_back(plane, std::max(1.0, cells.grid.lines_of_pixel));
  for (std::size_t b = 0; b < cells.seen.bands.size(); ++b) {
    const double um = cells.seen.bands[b].center_um;
    const std::size_t plane = cells.seen.plane_of(um);
    const sensors::SpreadKernel& kernel = cells.kernels[cells.bands[b].kernel];
    for (int i = 0; i * kStep <= 1 + 1e-9; ++i) {
      const double f = i * kStep, along = f / cells.grid.lines_of_pixel;
      table.add(static_cast<int>(b) + 1)
          .add(1e3 * um)
          .add(std::string_view(cells.seen.focal_planes[plane].name))
          .add(f);
      table.add(std::abs(kernel.transfer(cells.grid, f, 0))).add(std::abs(kernel.transfer(cells.grid, 0, along)));
      table.add(std::abs(sensors::wanted_transfer(optics[plane], um, cells.grid, f, 0)));
      table.add(std::abs(sensors::wanted_transfer(optics[plane], um, cells.grid, 0, along))).end_row();
    }
  }
  table.finish();
}

bool displaced(const sensors::Cells& cells) {
  return cells.most_keystone_px > 0 ||
         std::any_of(cells.seen.focal_planes.begin(), cells.seen.focal_planes.end(),
                     [](const scene::FocalPlane& p) { return p.smiles() || p.offset_px != std::array<double, 2>{}; });
}

void write_registration(const sensors::Cells& cells, base::OutputSet& set) {
  const scene::Instrument& seen = cells.seen;
  products::EnviHeader header;
  header.samples = seen.pixels, header.lines = static_cast<std::int64_t>(seen.bands.size()), header.bands = 3;
  header.description = "where each band looks at each sample, beside its place; a line is a band";
  header.band_names = {"across [pixel]", "along [pixel]", "centre's shift [nm]"};
  products::EnviWriter writer(set, "registration.img", header);
  std::vector<float> values;
  for (std::size_t b = 0; b < seen.bands.size(); ++b) {
    const auto& offset = seen.focal_planes[seen.plane_of(seen.bands[b].center_um)].offset_px;
    for (int s = 0; s < seen.pixels; ++s)
      values.insert(values.end(),
                    {static_cast<float>(offset[0] + sensors::keystone_px(seen, b, s)), static_cast<float>(offset[1]),
                     static_cast<float>(1e3 * sensors::smile_um(seen, b, s))});
  }
  products::Strip strip;
  strip.lines = header.lines, strip.values = values.data();
  writer.write(strip);
  writer.finish();
}

}  // namespace

std::vector<std::pair<std::string, std::string>> add_spread_files(const sensors::Cells& cells, base::OutputSet& set) {
  std::vector<std::pair<std::string, std::string>> out = {{"mtf.csv", "transfer of each band, across and along"}};
  write_mtf(cells, set.add("mtf.csv"));
  if (displaced(cells)) {
    write_registration(cells, set);
    out.emplace_back("registration.img", "where each band looks at each sample, and its centre's shift, ENVI");
  }
  return out;
}

std::string spread_json(const sensors::Cells& cells) {
  double worst = 0;
  std::size_t most_terms = 0;
  for (const auto& kernel : cells.kernels)
    worst = std::max(worst, kernel.mtf_error), most_terms = std::max(most_terms, kernel.terms.size());
  return nlohmann::json{{"cells_of_pixel_and_line", cells.grid.cells},
                        {"margin_px", cells.margin_px},
                        {"lines_of_pixel", cells.grid.lines_of_pixel},
                        {"mtf_error", worst},
                        {"products_per_kernel", most_terms}}
      .dump();
}

}  // namespace raycube::run
