#include "scene_compiler/scene_builder.h"

#include <algorithm>
#include <cmath>

#include "host/base/text.h"
#include "scene_compiler/compiled_file.h"
#include "scene_compiler/document_values.h"
#include "scene_compiler/panels.h"
#include "scene_compiler/placed_together.h"

namespace raycube::scene {
namespace {

using base::Problems;

constexpr double kMostRepeated = 5e7;

/// Squares of two materials in turn; of a family each has the texel at its middle.
Cut checker_of(const Record& checker, MaterialTable& materials, Problems& problems) {
  const Value& names = checker.value("materials");
  const double cell_m = checker.number("cell_m");
  std::array<std::uint32_t, 2> surface{};
  for (std::size_t i = 0; i < 2; ++i) surface[i] = materials.surface(names.texts[i], names.text_places[i], problems);
  return {cell_m, [surface, cell_m, &materials](std::uint32_t column, std::uint32_t row) {
            return materials.at(surface[(column + row) % 2], (column + 0.5) * cell_m, (row + 0.5) * cell_m);
          }};
}

/// One square of one material, or a square for each texel, lifted by its relief.
Cut texels_of(std::uint32_t surface, MaterialTable& materials) {
  const Relief* relief = materials.relief(surface);
  if (relief != nullptr && relief->by_coordinates()) relief = nullptr;  // reported
  double texel_m = materials.texel_m(surface);
  if (relief != nullptr) texel_m = texel_m > 0 ? std::min(texel_m, relief->texel_m()) : relief->texel_m();
  Cut out{texel_m, [surface, texel_m, &materials](std::uint32_t column, std::uint32_t row) {
            return materials.at(surface, (column + 0.5) * texel_m, (row + 0.5) * texel_m);
          }};
  if (relief != nullptr) out.height_m = [relief](double along_m, double up_m) { return relief->at(along_m, up_m); };
  return out;
}

bool too_many_cells(double width_m, double length_m, const Cut& cut, const Record& record, MemorySum& memory,
                    Problems& problems) {
  const auto along = [&](double size_m) { return std::max(1.0, std::ceil(size_m / cut.cell_m)); };
  if (cut.cell_m <= 0) return false;
  const double cells = along(width_m) * along(length_m);
  if (cells <= 1e7)
    return !memory.take(2 * cells * kTriangle_bytes, record.where, number_text(cells) + " squares",
                        "use larger squares or texels, or fewer such faces", problems);
  problems.add(record.where, "more than 1e7 squares of a checkerboard, texture or relief on one face",
               number_text(width_m) + " x " + number_text(length_m) + " m of " + number_text(cut.cell_m) + " m",
               "use larger squares or texels");
  return true;
}

void place_once(SceneParts& parts, std::string name, TriangleMesh mesh) {
  parts.placed.push_back({static_cast<std::uint32_t>(parts.meshes.size()), kIdentity});
  parts.meshes.push_back({std::move(name), std::move(mesh)});
}

void add_plane(const Record& record, const std::string& name, MaterialTable& materials, SceneParts& parts,
               Problems& problems) {
  const Record* checker_record = record.table("checker");
  if (record.given("material") == (checker_record != nullptr)) {
    problems.add(record.where, "a plane needs exactly one of material and checker", checker_record ? "both" : "neither",
                 "remove or add one");
    return;
  }
  const Cut cut =
      checker_record
          ? checker_of(*checker_record, materials, problems)
          : texels_of(materials.surface(record.text("material"), record.place("material"), problems, Covers::panel),
                      materials);
  const auto& size = record.numbers("size_m");
  if (too_many_cells(size[0], size[1], cut, record, parts.memory, problems)) return;
  place_once(parts, name,
             plane_mesh(position_of(record, parts, problems), {size[0], size[1]}, record.number("yaw_deg"),
                        record.number("tilt_deg"), cut));
}

void add_box(const Record& record, const std::string& name, MaterialTable& materials, SceneParts& parts,
             Problems& problems) {
  std::array<std::uint32_t, 6> surface{};
  std::array<bool, 6> known{};
  if (record.given("material")) {
    surface.fill(materials.surface(record.text("material"), record.place("material"), problems, Covers::panel));
    known.fill(true);
  }
  for (const auto& [face, value] : record.value("materials").map) {
    const auto found = std::find(kBoxFaceNames.begin(), kBoxFaceNames.end(), face);
    if (found == kBoxFaceNames.end()) {
      problems.add(value.where, "a box has no such face", "'" + face + "'",
                   "faces: top, bottom, north, south, east, west");
      continue;
    }
    const auto index = static_cast<std::size_t>(found - kBoxFaceNames.begin());
    surface[index] = materials.surface(value.text, value.where, problems, Covers::panel);
    known[index] = true;
  }
  std::array<Cut, 6> faces;
  for (std::size_t i = 0; i < faces.size(); ++i) faces[i] = texels_of(surface[i], materials);
  if (const Record* checker = record.table("checker"))
    faces[kTop] = checker_of(*checker, materials, problems), known[kTop] = true;
  for (std::size_t i = 0; i < known.size(); ++i)
    if (!known[i])
      problems.add(record.where, "a face of the box has no material", kBoxFaceNames[i],
                   "give material, or materials = { " + std::string(kBoxFaceNames[i]) + " = ... }");
  const auto& size = record.numbers("size_m");
  const std::array<std::array<double, 2>, 6> extent{{{size[0], size[1]},
                                                     {size[0], size[1]},
                                                     {size[0], size[2]},
                                                     {size[0], size[2]},
                                                     {size[1], size[2]},
                                                     {size[1], size[2]}}};
  for (std::size_t i = 0; i < faces.size(); ++i)
    if (too_many_cells(extent[i][0], extent[i][1], faces[i], record, parts.memory, problems)) return;
  place_once(
      parts, name,
      box_mesh(position_of(record, parts, problems), {size[0], size[1], size[2]}, record.number("yaw_deg"), faces));
}

/// Where each mesh first stands in the list of placements; 0 of those that are never placed.
std::vector<std::uint32_t> first_placements(const SceneParts& parts) {
  std::vector<std::uint32_t> out(parts.meshes.size(), 0);
  for (auto i = static_cast<std::uint32_t>(parts.placed.size()); i-- > 0;) out[parts.placed[i].mesh] = i;
  return out;
}

/// Meshes of each tree.
std::vector<std::vector<std::uint32_t>> tree_groups(const SceneParts& parts, TreeSharing sharing) {
  if (sharing == TreeSharing::together) return placed_together(parts.placed, parts.meshes.size());
  std::vector<std::vector<std::uint32_t>> alone;
  for (std::uint32_t mesh = 0; mesh < parts.meshes.size(); ++mesh) alone.push_back({mesh});
  return alone;
}

/// [scene] periodic: places everything again beside itself, thing by thing, so that of two at one place the one that
/// stands first in the file is seen in every cell.
void repeat_cell(const Record& root, SceneParts& parts, Problems& problems) {
  const Record* scene = root.table("scene");
  const Record* cell = scene ? scene->table("periodic") : nullptr;
  if (cell == nullptr || !cell->sound) return;
  if (!parts.volumes.empty()) {
    problems.add(cell->where, "volumes do not repeat", base::counted(parts.volumes.size(), "volume"),
                 "remove them, or periodic");
    return;
  }
  const auto copies = cell->integer("copies");
  const std::vector<Placed> once = parts.placed;
  const double more = 4.0 * static_cast<double>(copies) * static_cast<double>(copies + 1);
  if (more * static_cast<double>(once.size()) > kMostRepeated) {
    problems.add(cell->place("copies"), "more placements than a scene holds",
                 number_text(more * static_cast<double>(once.size())), "at most 5e7: give fewer copies");
    return;
  }
  const double copied = more * static_cast<double>(once.size());
  if (!parts.memory.take(copied * kPlaced_bytes, cell->place("copies"), number_text(copied) + " placements",
                         "give fewer copies", problems))
    return;
  parts.cell_m = {cell->number("x_m"), cell->number("y_m")};
  parts.cell_copies = static_cast<int>(copies);
  parts.placed.clear();
  parts.placed.reserve(once.size() * static_cast<std::size_t>((2 * copies + 1) * (2 * copies + 1)));
  for (const Placed& own : once)
    for (auto i = -copies; i <= copies; ++i)
      for (auto j = -copies; j <= copies; ++j) {
        Placed placed = own;
        placed.scene_from_mesh[3] += static_cast<double>(i) * parts.cell_m->at(0);
        placed.scene_from_mesh[7] += static_cast<double>(j) * parts.cell_m->at(1);
        parts.placed.push_back(placed);
      }
}

}  // namespace

std::array<double, 3> position_of(const Record& record, const SceneParts& parts, Problems& problems) {
  const auto& p = record.numbers("position_m");
  std::array<double, 3> position{p[0], p[1], p[2]};
  if (!record.boolean("on_terrain")) return position;
  if (const auto z = parts.terrain_height_m(p[0], p[1])) {
    position[2] += *z;
  } else if (parts.terrains_whole) {
    problems.add(record.place("position_m"), "on_terrain, but no terrain lies there",
                 "x " + std::to_string(p[0]) + ", y " + std::to_string(p[1]), "move it, or set on_terrain = false");
  }
  return position;
}

std::optional<double> SceneParts::terrain_height_m(double x_m, double y_m) const {
  std::optional<double> highest;
  for (const auto& terrain : terrains)
    if (const auto z = terrain.height_m(x_m, y_m); z && (!highest || *z > *highest)) highest = z;
  return highest;
}

void add_panels(const Record& root, MaterialTable& materials, SceneParts& parts, Problems& problems) {
  std::size_t number = 0;
  for (const auto& record : root.records("plane")) {
    ++number;
    if (record.sound)
      add_plane(record, record.given("name") ? record.text("name") : "plane " + std::to_string(number), materials,
                parts, problems);
  }
  number = 0;
  for (const auto& record : root.records("box")) {
    ++number;
    if (record.sound)
      add_box(record, record.given("name") ? record.text("name") : "box " + std::to_string(number), materials, parts,
              problems);
  }
}

/// Part by which a metre of the map may differ from one on the ground: UTM's and most national grids' do by 0.04 %.
constexpr double kMostStretch = 0.005;
/// How far latitude_deg and longitude_deg may lie from the place that epsg and its coordinates name, degrees.
constexpr double kSamePlace_deg = 0.01;

/// Whether the origin lies in a projected system whose metres are metres of the ground, and is one place.
void check_origin(const Record& record, const Origin& origin, Problems& problems) {
  const std::string found = "EPSG:" + std::to_string(origin.epsg) + " at " + number_text(origin.easting_m) + ", " +
                            number_text(origin.northing_m);
  std::string why;
  const auto place = geographic_place(origin.epsg, origin.easting_m, origin.northing_m, &why);
  if (!place) {
    problems.add(record.place("epsg"), "not a projected system in metres in which the origin lies", found + ": " + why,
                 "use a projected system in metres, like EPSG:32618 (UTM 18N), and its easting and northing");
    return;
  }
  if (std::max(std::abs(place->scale_north - 1), std::abs(place->scale_east - 1)) > kMostStretch)
    problems.add(
        record.place("epsg"), "metres of this map are not metres on the ground",
        found + ": a metre on the ground is " + number_text(place->scale_north) + " to north and " +
            number_text(place->scale_east) + " to east on the map",
        "slopes, shadows and sizes would be wrong; use the place's UTM zone, EPSG:" + std::to_string(utm_zone(*place)));
  const bool latitude = record.given("latitude_deg"), longitude = record.given("longitude_deg");
  const double east = longitude ? std::remainder(record.number("longitude_deg") - place->longitude_deg, 360.0) : 0,
               north = latitude ? record.number("latitude_deg") - place->latitude_deg : 0;
  if (std::max(std::abs(east), std::abs(north)) > kSamePlace_deg)
    problems.add(
        record.place(latitude ? "latitude_deg" : "longitude_deg"), "the origin is two places",
        found + " is latitude " + number_text(place->latitude_deg) + ", longitude " + number_text(place->longitude_deg),
        "remove latitude_deg and longitude_deg, which epsg tells, or correct one");
}

SceneParts read_scene_parts(const Record& root, MaterialTable& materials, Problems& problems) {
  SceneParts parts;
  if (const Record* scene = root.table("scene"))
    if (const Record* origin = scene->table("origin")) {
      parts.origin.epsg = static_cast<int>(origin->integer("epsg"));
      parts.origin.easting_m = origin->number("easting_m");
      parts.origin.northing_m = origin->number("northing_m");
      parts.origin.height_m = origin->number("height_m");
      if (parts.origin.epsg != 0) check_origin(*origin, parts.origin, problems);
    }
  add_terrains(root, materials, parts, problems);
  add_panels(root, materials, parts, problems);
  add_meshes_and_instances(root, materials, parts, problems);
  add_volumes(root, parts, problems);
  repeat_cell(root, parts, problems);
  return parts;
}

CompiledScene compile_scene(SceneParts&& parts, MaterialTable&& materials, TreeSharing sharing) {
  CompiledScene scene;
  scene.origin = parts.origin;
  scene.volumes = std::move(parts.volumes);
  materials.move_to(scene);
  for (const auto& mesh : parts.meshes) scene.meshes.push_back({mesh.name, 0, 0, {}, {}, {}});
  const auto first_places = first_placements(parts);
  for (const auto& group : tree_groups(parts, sharing)) {
    std::vector<TreeMember> members;
    for (const std::uint32_t mesh : group)
      members.push_back(
          {mesh, first_places[mesh] - first_places[group[0]], &parts.meshes[mesh].mesh, &parts.meshes[mesh].mesh});
    append_tree(scene, members);
  }
  for (std::uint32_t i = 0; i < parts.placed.size(); ++i) {
    const Placed& placed = parts.placed[i];
    const Mesh& mesh = scene.meshes[placed.mesh];  // the others of its tree come with the first
    if (mesh.placed_after == 0) append_instance(scene, mesh.tree, placed.scene_from_mesh, i);
  }
  finish_top_tree(scene);
  scene.content_hash = content_hash(scene);
  return scene;
}

}  // namespace raycube::scene
