// [[terrain]] entries: heights, georeferencing, class and mixture maps.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "host/base/text.h"
#include "scene_compiler/counter_random.h"
#include "scene_compiler/csv_file.h"
#include "scene_compiler/document_values.h"
#include "scene_compiler/scene_builder.h"

namespace raycube::scene {
namespace {

using base::Problems;
using base::Where;

std::string post_text(std::size_t index, int columns) {
  return "row " + std::to_string(index / static_cast<std::size_t>(columns)) + ", column " +
         std::to_string(index % static_cast<std::size_t>(columns));
}

/// Raster transform with the scene's origin taken off, in double.
std::array<double, 6> local_from(const Raster& raster, const Origin& origin) {
  auto t = raster.transform;
  t[0] -= origin.easting_m;
  t[3] -= origin.northing_m;
  return t;
}

/// Fine rasters of degrees lie so far from zero, those of metres about an origin of their own do not.
constexpr double kCellsFromZero = 10000;

/// The raster's coordinate system against the scene's; true when its transform can be used.
bool check_reference(const Raster& raster, const SceneParts& parts, const Where& where, Problems& problems) {
  const auto& t = raster.transform;
  const ReferenceSystem& system = raster.system;
  const double east = t[0] + 0.5 * (t[1] * raster.columns + t[2] * raster.rows),
               north = t[3] + 0.5 * (t[4] * raster.columns + t[5] * raster.rows);
  const std::string asked = "EPSG:" + std::to_string(parts.origin.epsg);
  const std::string origin_line = "origin = { epsg = " + std::to_string(system.epsg) +
                                  ", easting_m = " + number_text(std::round(east)) +
                                  ", northing_m = " + number_text(std::round(north)) + " }";
  if (system.geographic) {
    problems.add(where, "raster is in degrees", raster.file + ", " + system.name,
                 "project it first: gdalwarp -t_srs EPSG:326xx in.tif out.tif");
    return false;
  }
  if (!system.wkt.empty() && (parts.origin.epsg == 0 || !is_system(system.wkt, parts.origin.epsg))) {
    const std::string name =
        system.epsg != 0 ? "EPSG:" + std::to_string(system.epsg) : "'" + system.name + "', which has no EPSG code";
    const std::string warp = "gdalwarp -t_srs " + (parts.origin.epsg == 0 ? std::string("EPSG:326xx") : asked) + " " +
                             raster.file + " OUT.tif";
    problems.add(where, "raster and scene.origin are in different systems",
                 name + " and " + (parts.origin.epsg == 0 ? std::string("no origin") : asked),
                 system.epsg == 0 || std::abs(system.unit_m - 1) > 1e-12 ? warp
                 : parts.origin.epsg == 0                                ? "write in [scene]: " + origin_line
                                                                         : warp + ", or in [scene]: " + origin_line);
    return false;
  }
  if (system.wkt.empty() && std::abs(east) <= 180.5 && std::abs(north) <= 90.5 && std::abs(t[1]) < 0.02 &&
      (std::hypot(parts.origin.easting_m, parts.origin.northing_m) > 1000 ||
       std::hypot(east, north) > kCellsFromZero * std::abs(t[1])))
    problems.tell(where, raster.file + " names no reference system, and its coordinates look like degrees (centre " +
                             number_text(east) + ", " + number_text(north) + ")");
  if (std::hypot(east - parts.origin.easting_m, north - parts.origin.northing_m) > 1e5) {
    problems.add(where, "raster lies more than 100 km from scene.origin",
                 "centre at " + number_text(std::round(east)) + ", " + number_text(std::round(north)),
                 system.wkt.empty() ? "it names no reference system; write in [scene] an origin in its coordinates"
                                    : "write in [scene]: " + origin_line);
    return false;
  }
  return true;
}

std::optional<std::array<double, 6>> terrain_transform(const Record& record, const Raster& raster,
                                                       const SceneParts& parts, Problems& problems) {
  if (raster.georeferenced) {
    for (const char* key : {"cell_m", "upper_left_m"})
      if (record.given(key)) {
        problems.add(record.place(key), std::string("'") + key + "' is for rasters without georeferencing", raster.file,
                     "remove it");
        return std::nullopt;
      }
    if (!check_reference(raster, parts, record.place("raster"), problems)) return std::nullopt;
    return local_from(raster, parts.origin);
  }
  if (!record.given("cell_m")) {
    problems.add(record.place("raster"), "raster has no georeferencing", raster.file,
                 "give cell_m, and upper_left_m unless it is centred on the origin");
    return std::nullopt;
  }
  const double cell = record.number("cell_m");
  double x = -0.5 * cell * raster.columns, y = 0.5 * cell * raster.rows;
  if (record.given("upper_left_m")) x = record.numbers("upper_left_m")[0], y = record.numbers("upper_left_m")[1];
  return std::array<double, 6>{x, cell, 0, y, 0, -cell};
}

/// Metres of one of the file's heights: by the band's unit, else by the vertical part of its system; what is not metres
/// is told, what is not known refused.
std::optional<double> height_unit_m(const Raster& raster, const Where& where, Problems& problems) {
  const std::string& unit = raster.declared[0].unit;
  const double by_system = raster.system.height_unit_m;
  const double by_band = unit.empty() ? 0 : base::metres_of(unit);
  if (!unit.empty() && by_band == 0) {
    problems.add(where, "the heights' unit is not known", "'" + unit + "' in " + raster.file,
                 "give heights in metres or feet, or rewrite the unit: gdal_edit.py -units metre FILE");
    return std::nullopt;
  }
  const double metres = by_band > 0 ? by_band : by_system > 0 ? by_system : 1;
  if (std::abs(metres - 1) > 1e-12)
    problems.tell(where, raster.file + ": heights in " +
                             (by_band > 0 ? "'" + unit + "'" : "the unit of '" + raster.system.height_name + "'") +
                             " are taken as " + number_text(metres) + " m each");
  return metres;
}

std::optional<std::vector<double>> heights(const Record& record, const Raster& raster, const Origin& origin,
                                           Problems& problems) {
  const std::string& rule = record.text("nodata");
  const auto unit_m = height_unit_m(raster, record.place("raster"), problems);
  if (!unit_m) return std::nullopt;
  std::vector<double> z(raster.bands[0].size());
  std::size_t holes = 0, first = 0;
  for (std::size_t i = 0; i < z.size(); ++i) {
    double h = *unit_m * raster.bands[0][i];
    if (!raster.valid[0][i]) {
      if (holes++ == 0) first = i;
      h = record.number("nodata_height_m");
    } else {
      h = h * record.number("height_scale") + record.number("height_offset_m");
    }
    z[i] = h - origin.height_m;
    if (raster.valid[0][i] && !(std::abs(z[i]) < 1e6)) {
      problems.add({raster.file, 0, 0, post_text(i, raster.columns)}, "height is out of range",
                   number_text(raster.bands[0][i]),
                   "heights are metres; is this a nodata value that the file does not declare "
                   "(gdal_translate -a_nodata)?");
      return std::nullopt;
    }
  }
  if (holes > 0 && rule != "constant") {
    problems.add({raster.file, 0, 0, post_text(first, raster.columns)}, "terrain has posts without data",
                 std::to_string(holes) + " of " + std::to_string(z.size()),
                 rule == "refuse" ? "set nodata = \"interpolate\" or \"constant\" in " + record.where.text()
                                  : "interpolation found no neighbours; use nodata = \"constant\"");
    return std::nullopt;
  }
  return z;
}

/// Numbers that files write where they have no height.
constexpr double kDeepest = -500, kHighest = 9000;  ///< of the ground on earth above the sea's level, about, m
constexpr std::array kVoids = {-99999.0, -32768.0, -32767.0, -9999.0, -999.0, -99.0, 9999.0, 32767.0, 65535.0, 1e20};

/// How many posts have a property, and the first of them.
struct Posts {
  std::size_t count = 0, first = 0;
  void add(std::size_t post) {
    if (count++ == 0) first = post;
  }
};

/// Posts that may stand for voids which the file does not declare: told, by value and place. `z`: heights, m; a height
/// is far from another where no slope is between them, that is by 10 cells or 100 m, whichever is more.
void tell_of_voids(const Raster& raster, const std::vector<double>& z, double cell_m, Problems& problems) {
  const double far_m = std::max(100.0, 10 * cell_m);
  const auto tell = [&](const Posts& posts, const std::string& what) {
    problems.tell({raster.file, 0, 0, post_text(posts.first, raster.columns)},
                  base::counted(posts.count, "post") + " of height " + number_text(raster.bands[0][posts.first]) + " " +
                      what + "; if that means no data, declare it: gdal_translate -a_nodata");
  };
  const int columns = raster.columns, rows = raster.rows;
  std::array<Posts, kVoids.size()> voids;
  double least = std::numeric_limits<double>::infinity(), most = -least;
  const auto void_of = [&](std::size_t post) {
    const base::GdalBand& band = raster.declared[0];
    const double number = (raster.bands[0][post] - band.offset) / band.scale;
    return static_cast<std::size_t>(std::find(kVoids.begin(), kVoids.end(), number) - kVoids.begin());
  };
  for (std::size_t post = 0; post < z.size(); ++post) {
    if (!raster.valid[0][post]) continue;
    if (const std::size_t known = void_of(post); known < kVoids.size())
      voids[known].add(post);
    else
      least = std::min(least, z[post]), most = std::max(most, z[post]);
  }
  std::vector<bool> told(z.size(), false);
  for (const Posts& posts : voids)
    if (posts.count > 0 && (z[posts.first] < least - far_m || z[posts.first] > most + far_m)) {
      const double height = raster.bands[0][posts.first];
      if (height < kDeepest || height > kHighest)
        problems.add(
            {raster.file, 0, 0, post_text(posts.first, columns)}, "a height that no ground has",
            number_text(height) + ", " + std::to_string(posts.count) + " of " + std::to_string(z.size()) + " posts",
            "if it means no data, declare it: gdal_translate -a_nodata " + number_text(height) + " " + raster.file +
                " OUT.tif");
      else
        tell(posts, posts.count == 1 ? "stands far from all others" : "stand far from all others");
      for (std::size_t post = 0; post < z.size(); ++post) told[post] = told[post] || z[post] == z[posts.first];
    }
  Posts alone;
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) {
      const auto number = [&](int r, int c) {
        return static_cast<std::size_t>(r) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(c);
      };
      const std::size_t post = number(row, column);
      if (!raster.valid[0][post] || told[post]) continue;
      int neighbours = 0;
      bool lonely = true;
      for (int r = std::max(row - 1, 0); r <= std::min(row + 1, rows - 1); ++r)
        for (int c = std::max(column - 1, 0); c <= std::min(column + 1, columns - 1); ++c) {
          const std::size_t beside = number(r, c);
          if (beside == post || !raster.valid[0][beside] || told[beside]) continue;
          ++neighbours;
          lonely = lonely && std::abs(z[beside] - z[post]) > far_m;
        }
      if (lonely && neighbours >= 3) alone.add(post);
    }
  if (alone.count > 0)
    tell(alone, (alone.count == 1 ? "stands alone, more than " : "stand alone, more than ") + number_text(far_m) +
                    " m from all " + (alone.count == 1 ? "its" : "their") + " neighbours");
}

/// material of each number named in `materials`.
std::map<long, std::uint32_t> numbered_materials(const Record& record, const MaterialTable& materials,
                                                 Problems& problems) {
  std::map<long, std::uint32_t> out;
  for (const auto& [key, value] : record.value("materials").map) {
    const auto number = parse_number(key);
    if (!number || *number != std::round(*number) || std::abs(*number) > 1e9) {
      problems.add(value.where, "key of 'materials' is not a whole number", "'" + key + "'",
                   "use the class numbers of the map, or band numbers from 1");
      continue;
    }
    out[static_cast<long>(*number)] = materials.surface(value.text, value.where, problems);
  }
  return out;
}

std::optional<std::vector<std::size_t>> pixels_of(const TerrainGrid& grid, const Raster& map, const SceneParts& parts,
                                                  const Where& where, Problems& problems) {
  if (map.georeferenced && !check_reference(map, parts, where, problems)) return std::nullopt;
  return map_pixels(grid, map, local_from(map, parts.origin), where, problems);
}

std::vector<std::uint32_t> class_surfaces(const Record& record, const TerrainGrid& grid, const MaterialTable& materials,
                                          SceneParts& parts, std::vector<int>& classes, Problems& problems) {
  const auto known = numbered_materials(record, materials, problems);
  std::vector<std::uint32_t> out(grid.cell_count(), 0);
  const Where where = record.place("class_map");
  const auto map = read_raster(record.text("class_map"), {}, where, problems);
  if (!map) return out;
  const auto pixel = pixels_of(grid, *map, parts, where, problems);
  if (!pixel) return out;
  classes.resize(out.size());
  // Value: cells, first pixel. No number, which a map cannot order, goes by the least.
  std::map<double, std::pair<std::size_t, std::size_t>> missing;
  std::size_t without_data = 0;
  for (std::size_t cell = 0; cell < out.size(); ++cell) {
    const double value = map->bands[0][(*pixel)[cell]];
    const auto found =
        value == std::round(value) && std::abs(value) < 1e9 ? known.find(static_cast<long>(value)) : known.end();
    if (found == known.end()) {
      auto& entry = missing.emplace(std::isnan(value) ? -INFINITY : value, std::pair{std::size_t{0}, (*pixel)[cell]})
                        .first->second;
      ++entry.first;
      continue;
    }
    out[cell] = found->second;
    classes[cell] = static_cast<int>(value);
    without_data += !map->valid[0][(*pixel)[cell]];
  }
  if (without_data > 0)
    problems.tell({map->file, 0, 0, ""},
                  base::counted(without_data, "cell lies", "cells lie") +
                      " where the class map declares no data, and has the material that is named for its number there");
  std::size_t reports = 0;
  for (const auto& [value, entry] : missing)
    if (++reports <= 20)
      problems.add({map->file, 0, 0, post_text(entry.second, map->columns)}, "class has no material",
                   (std::isinf(value) ? "nan" : number_text(value)) + " on " + base::counted(entry.first, "cell"),
                   "name it in 'materials' of " + record.where.text());
  return out;
}

std::vector<std::uint32_t> mixture_surfaces(const Record& record, const TerrainGrid& grid, MaterialTable& materials,
                                            SceneParts& parts, Problems& problems) {
  std::vector<std::uint32_t> out(grid.cell_count(), 0);
  const Where where = record.place("mixture_map");
  const auto map = read_raster(record.text("mixture_map"), {.count = 0}, where, problems);
  const auto known = numbered_materials(record, materials, problems);
  if (!map) return out;
  for (int band = 1; band <= map->band_count; ++band)
    if (!known.count(band))
      problems.add(record.place("materials"), "band of the mixture map has no material",
                   "band " + std::to_string(band) + " of " + std::to_string(map->band_count),
                   "materials = { " + std::to_string(band) + " = ... }");
  for (const auto& [band, surface] : known)
    if (band < 1 || band > map->band_count)
      problems.add(record.place("materials"), "mixture map has no such band",
                   std::to_string(band) + " of " + std::to_string(map->band_count), "remove it");
  const auto pixel = pixels_of(grid, *map, parts, where, problems);
  if (!pixel || !problems.empty()) return out;
  const bool linear = record.text("mixture") == "linear";
  const auto seed = static_cast<std::uint64_t>(record.integer("seed"));
  const auto stream = static_cast<std::uint64_t>(parts.terrains.size());
  std::size_t reports = 0;
  for (std::size_t cell = 0; cell < out.size() && reports < 20; ++cell) {
    std::vector<std::pair<std::uint32_t, double>> mix;
    double sum = 0, worst = 0;
    for (const auto& [band, surface] : known) {
      const auto of_band = static_cast<std::size_t>(band - 1);
      const double f = map->valid[of_band][(*pixel)[cell]] ? map->bands[of_band][(*pixel)[cell]] : NAN;
      if (!(f >= 0 && f <= 1)) worst = f;
      sum += f;
      if (f > 0) mix.emplace_back(surface, f);
    }
    const Where place{map->file, 0, 0, post_text((*pixel)[cell], map->columns)};
    if (!(worst == 0) || !(std::abs(sum - 1) <= 1e-3)) {
      ++reports;
      if (!(worst == 0))
        problems.add(place, std::isnan(worst) ? "fraction without data" : "fraction outside 0 .. 1", number_text(worst),
                     "correct the mixture map");
      else
        problems.add(place, "fractions do not sum to 1 within 1e-3", number_text(sum), "normalise the mixture map");
      continue;
    }
    if (linear && mix.size() > 4) {
      ++reports;
      problems.add(place, "more than 4 materials in a cell", std::to_string(mix.size()),
                   "merge small fractions, or set mixture = \"stochastic\"");
      continue;
    }
    for (auto& [surface, f] : mix) f /= sum;
    if (linear && !materials.reflect_alike(mix)) {
      ++reports;
      problems.add(place, "materials of different scattering shapes mixed in a cell", "",
                   "give them one shape, or set mixture = \"stochastic\"");
      continue;
    }
    if (linear) {
      out[cell] = materials.mix(mix);
      continue;
    }
    double left = counter_uniform(seed, stream, cell, 0);
    std::size_t chosen = 0;
    while (chosen + 1 < mix.size() && left >= mix[chosen].second) left -= mix[chosen++].second;
    out[cell] = mix[chosen].first;
  }
  return out;
}

constexpr int kMostRefined = 64;
constexpr double kMostTerrainCells = 1e8;  ///< of a terrain: 16 GB of triangles and trees

/// How a terrain shows textures `times` as fine as its cells.
std::string finer_text(double times) {
  const int whole = static_cast<int>(std::ceil(times - 1e-6));
  return whole <= kMostRefined
             ? "refine = " + std::to_string(whole) + " shows them all"
             : "refine goes to " + std::to_string(kMostRefined) + ": give a finer raster or larger texels";
}

/// Whether a terrain of so many cells can be cut as it asks for.
bool can_refine(const Record& record, const TerrainGrid& grid, Problems& problems) {
  const auto cells = static_cast<double>(grid.cell_count()), times = static_cast<double>(record.integer("refine"));
  if (times == 1 || cells * times * times <= kMostTerrainCells) return true;
  problems.add(record.place("refine"), "a terrain of more than 1e8 cells",
               number_text(cells) + " cells, each cut into " + number_text(times * times),
               "refine = " + std::to_string(std::max(1, static_cast<int>(std::sqrt(kMostTerrainCells / cells)))) +
                   " fits, or split the raster");
  return false;
}

/// The terrain's triangles: its cells cut as asked for, each with the texels at its middle.
TriangleMesh textured_mesh(const Record& record, const TerrainGrid& grid, const std::vector<std::uint32_t>& surfaces,
                           MaterialTable& materials, std::vector<std::string>& notices) {
  const auto times = static_cast<int>(record.integer("refine"));
  const TerrainGrid finer = times > 1 ? grid.refined(times) : grid;
  const auto columns = static_cast<std::size_t>(finer.cell_columns());
  const double cell_m = std::sqrt(finer.cell_area_m2());
  std::vector<std::uint32_t> of_cell(finer.cell_count()), cut_from(finer.cell_count());
  double texel_m = 0;
  for (std::size_t cell = 0; cell < of_cell.size(); ++cell) {
    const std::size_t row = cell / columns / static_cast<std::size_t>(times),
                      column = cell % columns / static_cast<std::size_t>(times);
    const std::size_t coarse = row * static_cast<std::size_t>(grid.cell_columns()) + column;
    const std::uint32_t surface = surfaces[coarse];
    cut_from[cell] = static_cast<std::uint32_t>(coarse);
    const double size_m = materials.texel_m(surface);
    const auto [x, y] = finer.cell_center(cell);
    of_cell[cell] = size_m > 0 ? materials.at(surface, x, y) : surface;
    if (size_m > 0 && (texel_m == 0 || size_m < texel_m)) texel_m = size_m;
  }
  if (texel_m > 0 && cell_m > 1.01 * texel_m)
    notices.push_back("terrain '" + record.text("name") + "': its cells of " + number_text(cell_m) +
                      " m are larger than texels of " + number_text(texel_m) +
                      " m, and each has the one at its middle; " + finer_text(times * cell_m / texel_m));
  TriangleMesh mesh = finer.mesh(of_cell);
  for (std::uint32_t& face : mesh.user_face) face = cut_from[face];
  return mesh;
}

void add_terrain(const Record& record, MaterialTable& materials, SceneParts& parts, Problems& problems) {
  const int ways = int(record.given("material")) + int(record.given("class_map")) + int(record.given("mixture_map"));
  if (ways != 1)
    problems.add(record.where, "a terrain needs exactly one of material, class_map, mixture_map", std::to_string(ways),
                 "remove or add one");
  if (ways == 1 && record.given("material") == record.given("materials"))
    problems.add(record.where,
                 record.given("material") ? "'materials' goes with class_map or mixture_map" : "'materials' is missing",
                 "", record.given("material") ? "remove it" : "name the material of each class or band");
  const auto rule = record.text("nodata") == "interpolate" ? NoData::interpolate : NoData::mark;
  const auto raster =
      read_raster(record.text("raster"), {.first_band = static_cast<int>(record.integer("band")), .nodata = rule},
                  record.place("raster"), problems);
  if (!raster) return;
  if (raster->columns < 2 || raster->rows < 2) {
    problems.add(record.place("raster"), "a terrain needs at least 2 x 2 posts",
                 std::to_string(raster->columns) + " x " + std::to_string(raster->rows), "give a larger raster");
    return;
  }
  if (raster->declared[0].palette)
    problems.tell({raster->file, 0, 0, ""}, "its numbers are those of a palette's colours; they are taken as heights");
  const auto transform = terrain_transform(record, *raster, parts, problems);
  const auto z = heights(record, *raster, parts.origin, problems);
  if (!transform || !z) return;
  if (const double det = (*transform)[1] * (*transform)[5] - (*transform)[2] * (*transform)[4]; !(std::abs(det) > 0)) {
    problems.add({raster->file, 0, 0, ""}, "pixels have no area", number_text(det) + " m2",
                 "correct the raster's geotransform");
    return;
  }
  const TerrainGrid grid(raster->columns, raster->rows, *transform, *z);
  tell_of_voids(*raster, *z, std::sqrt(grid.cell_area_m2()), problems);
  if (!raster->system.height_name.empty())
    problems.tell(record.place("raster"), "heights of " + raster->file + " are above '" + raster->system.height_name +
                                              "'; scene.origin.height_m counts from there, too");
  std::vector<std::uint32_t> surfaces(grid.cell_count(), 0);
  std::vector<int> classes;
  if (ways == 1) {
    if (record.given("material"))
      std::fill(surfaces.begin(), surfaces.end(),
                materials.surface(record.text("material"), record.place("material"), problems));
    if (record.given("class_map")) surfaces = class_surfaces(record, grid, materials, parts, classes, problems);
    if (record.given("mixture_map")) surfaces = mixture_surfaces(record, grid, materials, parts, problems);
  }
  const double times = static_cast<double>(record.integer("refine")), cells = static_cast<double>(grid.cell_count());
  const bool fits = can_refine(record, grid, problems) &&
                    parts.memory.take(2 * cells * times * times * kTriangle_bytes, record.where,
                                      number_text(cells * times * times) + " cells of terrain",
                                      times > 1 ? "lower 'refine'" : "give a smaller or coarser raster", problems);
  parts.placed.push_back({static_cast<std::uint32_t>(parts.meshes.size()), kIdentity});
  parts.meshes.push_back({record.text("name"), !fits ? TriangleMesh{}
                                               : problems.empty()
                                                   ? textured_mesh(record, grid, surfaces, materials, parts.notices)
                                                   : grid.mesh(surfaces)});
  parts.terrains.push_back(grid);
  parts.terrain_classes.push_back(std::move(classes));
  parts.terrain_refine.push_back(static_cast<int>(record.integer("refine")));
}

}  // namespace

void add_terrains(const Record& root, MaterialTable& materials, SceneParts& parts, Problems& problems) {
  for (const auto& record : root.records("terrain"))
    if (record.sound) add_terrain(record, materials, parts, problems);
  parts.terrains_whole = parts.terrains.size() == root.records("terrain").size();
}

}  // namespace raycube::scene
