// [[volume]] entries: boxes, grids and plumes of gas and particles.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "scene_compiler/csv_file.h"
#include "scene_compiler/document_values.h"
#include "scene_compiler/raster.h"
#include "scene_compiler/scene_builder.h"
#include "scene_compiler/volume_spectrum.h"

namespace raycube::scene {
namespace {

using base::Problems;

constexpr std::int64_t kMostCells = std::int64_t{1} << 26;

void refuse(const Record& record, std::initializer_list<const char*> keys, const std::string& shape,
            Problems& problems) {
  for (const char* key : keys)
    if (record.given(key))
      problems.add(record.place(key), std::string("'") + key + "' means nothing for shape = \"" + shape + "\"", "",
                   "remove it, or choose another shape");
}

bool want(const Record& record, std::initializer_list<const char*> keys, const std::string& shape, Problems& problems) {
  bool all = true;
  for (const char* key : keys)
    if (!record.given(key)) {
      problems.add(record.where, std::string("'") + key + "' is missing for shape = \"" + shape + "\"", "",
                   std::string(find_key(record.path, key)->text));
      all = false;
    }
  return all;
}

void read_csv_values(const Record& record, Volume& out, Problems& problems) {
  const auto csv = read_csv(record.text("values"), record.place("values"), problems);
  if (!csv) return;
  const auto i = csv->column("i"), j = csv->column("j"), k = csv->column("k"), value = csv->column("value");
  if (!i || !j || !k || !value || csv->columns.size() != 4) {
    problems.add({csv->file, csv->header_line, 0, ""}, "a grid's file has the columns i, j, k, value",
                 csv->columns_text(), "name them so");
    return;
  }
  if (!record.given("cells")) {
    problems.add(record.where, "a grid from a CSV needs 'cells'", "", "give the numbers of cells along x, y, z");
    return;
  }
  for (std::size_t axis = 0; axis < 3; ++axis) out.cells[axis] = static_cast<int>(record.integers("cells")[axis]);
  const std::int64_t count = std::int64_t{out.cells[0]} * out.cells[1] * out.cells[2];
  if (count > kMostCells) {
    problems.add(record.place("cells"), "a grid has at most 2^26 cells", std::to_string(count), "use larger cells");
    return;
  }
  out.values.assign(static_cast<std::size_t>(count), 0.0f);
  const std::size_t before = problems.count();
  for (std::size_t row = 0; row < csv->rows.size() && problems.count() < before + 20; ++row) {
    std::array<std::int64_t, 3> at{};
    bool sound = true;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t column = *std::array{i, j, k}[axis];
      const auto n = csv->number(row, column, problems);
      if (n && (*n != std::floor(*n) || *n < 0 || *n >= out.cells[axis]))
        problems.add(csv->at(row, column), "no such cell", number_text(*n),
                     "give 0 to " + std::to_string(out.cells[axis] - 1));
      sound = sound && n && problems.count() == before;
      if (sound) at[axis] = static_cast<std::int64_t>(*n);
    }
    const auto v = csv->number(row, *value, problems);
    if (v && *v < 0) problems.add(csv->at(row, *value), "a value is negative", number_text(*v), "give 0 or more");
    if (sound && v)
      out.values[static_cast<std::size_t>((at[2] * out.cells[1] + at[1]) * out.cells[0] + at[0])] =
          static_cast<float>(*v);
  }
}

void read_raster_values(const Record& record, Volume& out, Problems& problems) {
  if (record.given("cells"))
    problems.add(record.place("cells"), "'cells' goes with a CSV", "", "remove it: a raster tells its own");
  const auto raster = read_raster(record.text("values"), {.count = 0}, record.place("values"), problems);
  if (!raster) return;
  out.cells = {raster->columns, raster->rows, static_cast<int>(raster->bands.size())};
  if (std::int64_t{out.cells[0]} * out.cells[1] * out.cells[2] > kMostCells) {
    problems.add(record.place("values"), "a grid has at most 2^26 cells",
                 std::to_string(raster->columns) + " x " + std::to_string(raster->rows), "use larger cells");
    return;
  }
  if (!raster->system.wkt.empty())
    problems.tell({raster->file, 0, 0, ""},
                  "its map coordinates do not place the volume; position_m and size_m of the scene do");
  const bool south_first = raster->georeferenced && raster->transform[5] > 0;
  std::size_t bad = 0;
  for (std::size_t band = 0; band < raster->bands.size(); ++band)
    for (int i = raster->rows - 1; i >= 0; --i)
      for (int column = 0; column < raster->columns; ++column) {
        const int row = south_first ? raster->rows - 1 - i : i;
        const auto at = static_cast<std::size_t>(row) * static_cast<std::size_t>(raster->columns) +
                        static_cast<std::size_t>(column);
        if (!raster->valid[band][at] || raster->bands[band][at] < 0) ++bad;
        out.values.push_back(static_cast<float>(raster->bands[band][at]));
      }
  if (bad > 0)
    problems.add({raster->file, 0, 0, ""}, "cells of a grid are negative or without data", std::to_string(bad),
                 "give 0 where there is nothing");
}

void read_plume(const Record& record, Volume& out, Problems& problems) {
  const std::string shape = "plume";
  refuse(record, {"size_m", "values", "cells", "concentration_ppm"}, shape, problems);
  want(record, {"source_g_s", "wind_m_s"}, shape, problems);
  out.source_g_s = record.number("source_g_s");
  out.wind_m_s = record.number("wind_m_s");
  out.release_height_m = record.number("release_height_m");
  out.molar_mass_g = record.number("molar_mass_g_mol");
  out.length_m = record.number("length_m");
  // Briggs (1973), open country, classes A to D: a, b of sigma_y, then of sigma_z.
  static const std::map<std::string, std::array<double, 4>> kBriggs = {{"A", {0.22, 1e-4, 0.20, 0}},
                                                                       {"B", {0.16, 1e-4, 0.12, 0}},
                                                                       {"C", {0.11, 1e-4, 0.08, 2e-4}},
                                                                       {"D", {0.08, 1e-4, 0.06, 1.5e-3}}};
  const auto& law = kBriggs.at(record.text("stability"));
  out.sigma_y_a = law[0], out.sigma_y_b = law[1], out.sigma_z_a = law[2], out.sigma_z_b = law[3];
  const auto width = [&](const char* law_key, const char* constant_key, double& a, double& b, double& constant_m) {
    if (record.given(law_key) && record.given(constant_key))
      problems.add(record.place(law_key),
                   std::string("'") + law_key + "' and '" + constant_key + "' exclude each other", "both",
                   "remove one");
    if (record.given(law_key)) {
      a = record.numbers(law_key)[0], b = record.numbers(law_key)[1];
      if (!(a > 0))
        problems.add(record.place(law_key), "a plume widens: a must be above 0", number_text(a),
                     "raise it, or give " + std::string(constant_key));
    }
    constant_m = record.number(constant_key);
  };
  width("sigma_y_law", "sigma_y_m", out.sigma_y_a, out.sigma_y_b, out.sigma_y_m);
  width("sigma_z_law", "sigma_z_m", out.sigma_z_a, out.sigma_z_b, out.sigma_z_m);
}

Volume read_volume(const Record& record, const SceneParts& parts, Problems& problems) {
  Volume out;
  out.name = record.text("name");
  out.position_m = position_of(record, parts, problems);
  out.yaw_deg = record.number("yaw_deg");
  out.gas = record.text("gas");
  const std::string& shape = record.text("shape");
  if (shape == "plume") {
    out.shape = Volume::Shape::plume;
    read_plume(record, out, problems);
  } else {
    refuse(record,
           {"source_g_s", "wind_m_s", "release_height_m", "molar_mass_g_mol", "stability", "sigma_y_law", "sigma_z_law",
            "sigma_y_m", "sigma_z_m", "length_m"},
           shape, problems);
    if (want(record, {"size_m"}, shape, problems)) std::copy_n(record.numbers("size_m").begin(), 3, out.size_m.begin());
    if (shape == "grid") {
      out.shape = Volume::Shape::grid;
      out.concentration_ppm = record.given("concentration_ppm") ? record.number("concentration_ppm") : 1;
      if (want(record, {"values"}, shape, problems))
        lower_case(record.text("values")).ends_with(".csv") ? read_csv_values(record, out, problems)
                                                            : read_raster_values(record, out, problems);
    } else {
      refuse(record, {"values", "cells"}, shape, problems);
      if (!out.gas.empty()) want(record, {"concentration_ppm"}, shape, problems);
      out.concentration_ppm = record.number("concentration_ppm");
    }
  }
  if (!out.gas.empty()) read_cross_section(record, out, problems);
  for (const char* key : {"concentration_ppm", "cross_section", "line"})
    if (out.gas.empty() && record.given(key))
      problems.add(record.place(key), std::string("'") + key + "' goes with a gas", "no gas", "name the gas");
  if (const Record* particles = record.table("particles")) {
    out.extinction_per_m = particles->number("extinction_per_m");
    out.lidar_ratio_sr = particles->number("lidar_ratio_sr");
  } else if (out.gas.empty()) {
    problems.add(record.where, "a volume needs gas or particles", "neither", "add one");
  }
  return out;
}

}  // namespace

void add_volumes(const Record& root, SceneParts& parts, Problems& problems) {
  std::map<std::string, base::Where> places;
  for (const auto& record : root.records("volume")) {
    const std::string& name = record.text("name");
    if (const auto [place, fresh] = places.emplace(name, record.where); !fresh && !name.empty())
      problems.add(record.where, "volume '" + name + "' is defined twice", "first in " + place->second.text(),
                   "rename one");
    if (record.sound) parts.volumes.push_back(read_volume(record, parts, problems));
  }
}

}  // namespace raycube::scene
