// [[mesh]], [[instance]] and [[scatter]] entries.
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "host/base/text.h"
#include "scene_compiler/counter_random.h"
#include "scene_compiler/csv_file.h"
#include "scene_compiler/document_values.h"
#include "scene_compiler/mesh_file.h"
#include "scene_compiler/mesh_images.h"
#include "scene_compiler/panels.h"
#include "scene_compiler/scene_builder.h"

namespace raycube::scene {
namespace {

using base::Problems;
using base::Where;

constexpr double kMaxInstances = 5e7;

/// Meshes by name; index -1: reported already, so that what names it is not reported again.
using MeshIndex = std::map<std::string, std::int64_t>;

std::string names_in(const MeshFile& file) {
  std::set<std::string> names;
  for (const auto& part : file.parts)
    for (const std::string& name : part.names()) names.insert(name);
  std::string out;
  for (const auto& name : names) out += (out.empty() ? "" : ", ") + name;
  return out.empty() ? "none" : out;
}

/// Turns part numbers into surfaces.
void assign_materials(const Record& record, const MaterialTable& materials, MeshFile& file, Problems& problems) {
  const auto& map = record.value("materials").map;
  std::map<std::string, std::uint32_t> by_name;
  std::set<std::string> used;
  for (const auto& [name, value] : map)
    by_name[name] = materials.surface(value.text, value.where, problems, Covers::mesh);
  std::optional<std::uint32_t> fallback;
  if (record.given("material"))
    fallback = materials.surface(record.text("material"), record.place("material"), problems, Covers::mesh);
  std::vector<std::uint32_t> surface_of_part(file.parts.size(), 0);
  std::set<std::string> without;
  for (std::size_t i = 0; i < file.parts.size(); ++i) {
    const auto& part = file.parts[i];
    const std::vector<std::string> names = part.names();
    const auto first = std::find_if(names.begin(), names.end(), [&](const auto& name) { return by_name.count(name); });
    if (first != names.end()) {
      surface_of_part[i] = by_name.at(*first);
    } else if (fallback) {
      surface_of_part[i] = *fallback;
    } else if (std::find(file.mesh.surface.begin(), file.mesh.surface.end(), i) != file.mesh.surface.end()) {
      without.insert(part.material.empty() ? "group '" + part.group + "'" : "'" + part.material + "'");
    }
    // All names count as seen: a map may name a group whose parts all go by material.
    used.insert(names.begin(), names.end());
  }
  for (const auto& name : without)
    problems.add(record.where, "faces of " + record.text("file") + " have no material", name,
                 "name it in 'materials', or give 'material' for all others");
  for (const auto& [name, value] : map)
    if (!used.count(name))
      problems.add(value.where, "mesh file has no material, group or node of that name", "'" + name + "'",
                   record.text("file") + " has: " + names_in(file));
  for (auto& surface : file.mesh.surface) surface = surface_of_part[surface];
}

void add_mesh(const Record& record, bool strict, MaterialTable& materials, SceneParts& parts, MeshIndex& index,
              Problems& problems) {
  const std::string& name = record.text("name");
  if (index.count(name)) {
    problems.add(record.where, "mesh '" + name + "' is defined twice", record.text("file"), "rename or remove one");
    return;
  }
  index[name] = -1;
  if (!record.sound) return;
  if (!record.given("material") && !record.given("materials")) {
    problems.add(record.where, "mesh '" + name + "' has neither material nor materials", record.text("file"),
                 "give one of them");
    return;
  }
  MeshRequest request{std::nullopt, std::nullopt, strict, std::max(0.0, parts.memory.left())};
  if (record.given("up")) request.up = record.text("up")[0];
  if (record.given("unit_m")) request.unit_m = record.number("unit_m");
  auto file = read_mesh_file(record.text("file"), request, record.place("file"), problems);
  if (!file) return;
  if (!parts.memory.take(static_cast<double>(file->mesh.triangles.size()) * kTriangle_bytes, record.where,
                         base::counted(file->mesh.triangles.size(), "triangle"), "give smaller meshes", problems))
    return;
  assign_materials(record, materials, *file, problems);
  if (problems.empty()) lay_images(record, materials, *file, parts.memory, parts.notices, problems);
  if (file->dropped_faces > 0)
    parts.notices.push_back(record.text("file") + ": dropped " + std::to_string(file->dropped_faces) + " of " +
                            base::counted(file->faces, "face") + " without area (first: " + file->first_dropped + ")");
  index[name] = static_cast<std::int64_t>(parts.meshes.size());
  parts.meshes.push_back({name, std::move(file->mesh), file->centre_m});
}

/// Index of a mesh, or -1 after reporting (or because its own entry was reported).
std::int64_t find_mesh(const Record& record, const MeshIndex& index, Problems& problems) {
  const auto found = index.find(record.text("mesh"));
  if (found != index.end()) return found->second;
  std::string known;
  for (const auto& [name, unused] : index) known += (known.empty() ? "" : ", ") + name;
  problems.add(record.place("mesh"), "unknown mesh", "'" + record.text("mesh") + "'",
               known.empty() ? "define it with [[mesh]]" : "define it with [[mesh]], or use one of: " + known);
  return -1;
}

double determinant(const std::array<double, 12>& m) {
  return m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8]) + m[2] * (m[4] * m[9] - m[5] * m[8]);
}

/// Adds a mesh where a matrix puts it; below 0: it was reported. The mesh's vertices count from its centre.
void place(std::int64_t mesh, std::array<double, 12> matrix, SceneParts& parts) {
  if (mesh < 0) return;
  const auto& c = parts.meshes[static_cast<std::size_t>(mesh)].centre_m;
  for (std::size_t row = 0; row < 12; row += 4)
    matrix[row + 3] += matrix[row] * c[0] + matrix[row + 1] * c[1] + matrix[row + 2] * c[2];
  parts.placed.push_back({static_cast<std::uint32_t>(mesh), matrix});
}

void add_instance(const Record& record, const MeshIndex& index, SceneParts& parts, Problems& problems) {
  const auto mesh = find_mesh(record, index, problems);
  std::array<double, 12> matrix{};
  if (record.given("matrix")) {
    for (const char* key : {"position_m", "yaw_deg", "scale"})
      if (record.given(key))
        problems.add(record.place(key), std::string("'") + key + "' and 'matrix' exclude each other", "both",
                     "remove one");
    const auto& m = record.numbers("matrix");
    if (m.size() == 16 && !(m[12] == 0 && m[13] == 0 && m[14] == 0 && m[15] == 1)) {
      problems.add(
          record.place("matrix"), "last row of the matrix is not 0, 0, 0, 1",
          number_text(m[12]) + ", " + number_text(m[13]) + ", " + number_text(m[14]) + ", " + number_text(m[15]),
          "the matrix is row-major and affine");
      return;
    }
    std::copy_n(m.begin(), 12, matrix.begin());
    const double size =
        std::max({std::hypot(m[0], m[4], m[8]), std::hypot(m[1], m[5], m[9]), std::hypot(m[2], m[6], m[10])});
    if (!(std::abs(determinant(matrix)) > 1e-9 * size * size * size)) {
      problems.add(record.place("matrix"), "matrix cannot be inverted",
                   "determinant " + number_text(determinant(matrix)), "its three axes must span space");
      return;
    }
  } else {
    const auto& p = record.numbers("position_m");
    matrix = placement({p[0], p[1], p[2]}, record.number("yaw_deg"), record.number("scale"));
  }
  if (record.boolean("on_terrain")) {
    const auto z = parts.terrain_height_m(matrix[3], matrix[7]);
    if (!z && parts.terrains_whole)
      problems.add(record.place("on_terrain"), "on_terrain, but no terrain lies there",
                   "x " + number_text(matrix[3]) + ", y " + number_text(matrix[7]),
                   "move it, or set on_terrain = false");
    matrix[11] += z.value_or(0);
  }
  place(mesh, matrix, parts);
}

/// Drops a point on the terrain when asked to; false after reporting a place off the terrain.
bool drop(const Record& record, const SceneParts& parts, const Where& where, std::array<double, 3>& p,
          Problems& problems) {
  if (!record.boolean("on_terrain") || parts.terrains.empty() || !parts.terrains_whole) return true;
  const auto z = parts.terrain_height_m(p[0], p[1]);
  if (!z) {
    problems.add(where, "place is off the terrain", "x " + number_text(p[0]) + ", y " + number_text(p[1]),
                 "move it, or set on_terrain = false");
    return false;
  }
  p[2] += *z;
  return true;
}

void scatter_listed(const Record& record, std::int64_t mesh, SceneParts& parts, Problems& problems) {
  const auto csv = read_csv(record.text("positions"), record.place("positions"), problems);
  if (!csv) return;
  if (!parts.memory.take(static_cast<double>(csv->rows.size()) * kPlaced_bytes, record.place("positions"),
                         base::counted(csv->rows.size(), "placement"), "list fewer", problems))
    return;
  const auto x = csv->column("x_m"), y = csv->column("y_m"), z = csv->column("z_m"), yaw = csv->column("yaw_deg"),
             scale = csv->column("scale");
  bool sound = x && y;
  if (!sound)
    problems.add({csv->file, csv->header_line, 0, ""}, "columns x_m and y_m are needed", csv->columns_text(),
                 "name them; z_m, yaw_deg and scale are optional");
  for (const auto& column : csv->columns)
    if (column != "x_m" && column != "y_m" && column != "z_m" && column != "yaw_deg" && column != "scale") {
      problems.add({csv->file, csv->header_line, 0, ""}, "unknown column", "'" + column + "'",
                   "columns: x_m, y_m, z_m, yaw_deg, scale");
      sound = false;
    }
  const std::size_t before = problems.count();
  for (std::size_t row = 0; sound && row < csv->rows.size() && problems.count() < before + 20; ++row) {
    const auto cell = [&](const std::optional<std::size_t>& column, double fallback) {
      return column ? csv->number(row, *column, problems) : std::optional(fallback);
    };
    const auto px = cell(x, 0), py = cell(y, 0), pz = cell(z, 0), turn = cell(yaw, 0), size = cell(scale, 1);
    if (!px || !py || !pz || !turn || !size) continue;
    if (!(*size > 0 && *size < 1e6)) {
      problems.add(csv->at(row, *scale), "scale must be above 0", number_text(*size), "give a scale like 1.0");
      continue;
    }
    std::array<double, 3> p{*px, *py, *pz};
    if (drop(record, parts, {csv->file, csv->row_lines[row], 0, ""}, p, problems))
      place(mesh, placement(p, *turn, *size), parts);
  }
}

bool inside(const std::vector<std::pair<double, double>>& polygon, double x, double y) {
  bool in = false;
  for (std::size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
    const auto [xi, yi] = polygon[i];
    const auto [xj, yj] = polygon[j];
    if ((yi > y) != (yj > y) && x < (xj - xi) * (y - yi) / (yj - yi) + xi) in = !in;
  }
  return in;
}

double area_of(const std::vector<std::pair<double, double>>& polygon) {
  double twice = 0;
  for (std::size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++)
    twice += polygon[j].first * polygon[i].second - polygon[i].first * polygon[j].second;
  return 0.5 * std::abs(twice);
}

/// Bounding rectangle of the region, or nullopt after reporting one that is missing or empty.
std::optional<std::array<double, 4>> region_bounds(const Record& record, const SceneParts& parts, Problems& problems) {
  const bool rectangle = record.given("rectangle_m"), polygon = record.given("polygon_m"),
             by_class = record.given("class");
  if ((rectangle && polygon) || (!rectangle && !polygon && !by_class)) {
    problems.add(record.where, "a scatter by density needs one region",
                 rectangle ? "rectangle_m and polygon_m" : "none", "give one of rectangle_m, polygon_m, or class");
    return std::nullopt;
  }
  if (by_class && std::none_of(parts.terrain_classes.begin(), parts.terrain_classes.end(),
                               [](const auto& c) { return !c.empty(); })) {
    if (parts.terrains_whole)
      problems.add(record.place("class"), "'class' needs a terrain with a class map",
                   std::to_string(record.integer("class")), "give [[terrain]] a class_map");
    return std::nullopt;
  }
  std::array<double, 4> b{1e300, 1e300, -1e300, -1e300};
  const auto grow = [&b](double x, double y) {
    b = {std::min(b[0], x), std::min(b[1], y), std::max(b[2], x), std::max(b[3], y)};
  };
  if (rectangle) {
    const auto& r = record.numbers("rectangle_m");
    grow(r[0], r[1]), grow(r[2], r[3]);
  } else if (polygon) {
    const auto& points = record.value("polygon_m").points;
    if (points.size() < 3) {
      problems.add(record.place("polygon_m"), "a polygon needs at least three corners", std::to_string(points.size()),
                   "give [[x, y], [x, y], [x, y]]");
      return std::nullopt;
    }
    for (const auto& [x, y] : points) grow(x, y);
  } else {
    for (const auto& terrain : parts.terrains) {
      const auto t = terrain.bounds();
      grow(t[0], t[1]), grow(t[2], t[3]);
    }
  }
  if (!(b[2] > b[0] && b[3] > b[1])) {
    problems.add(record.where, "region of the scatter has no area",
                 number_text(b[2] - b[0]) + " x " + number_text(b[3] - b[1]) + " m", "give opposite corners");
    return std::nullopt;
  }
  return b;
}

bool in_class(const SceneParts& parts, double x, double y, long wanted) {
  for (std::size_t i = 0; i < parts.terrains.size(); ++i)
    if (const auto cell = parts.terrains[i].cell_at(x, y);
        cell && !parts.terrain_classes[i].empty() && parts.terrain_classes[i][*cell] == wanted)
      return true;
  return false;
}

void scatter_drawn(const Record& record, std::int64_t mesh, std::uint64_t stream, SceneParts& parts,
                   Problems& problems) {
  const auto bounds = region_bounds(record, parts, problems);
  if (!bounds) return;
  const auto& b = *bounds;
  const double expected = record.number("density_per_m2") * (b[2] - b[0]) * (b[3] - b[1]);
  if (expected > kMaxInstances) {
    problems.add(record.place("density_per_m2"), "scatter asks for too many instances",
                 number_text(std::round(expected)) + " in the region's rectangle", "at most 5e7; lower the density");
    return;
  }
  const bool by_class = record.given("class");
  const double share =
      record.given("polygon_m") ? area_of(record.value("polygon_m").points) / ((b[2] - b[0]) * (b[3] - b[1])) : 1;
  const auto fits = [&](double count) {
    return parts.memory.take(count * kPlaced_bytes, record.place("density_per_m2"),
                             number_text(std::round(count)) + " placements", "lower the density", problems);
  };
  if (!by_class && !fits(share * expected)) return;
  double placed = 0;  // of a class they are counted as they come
  const auto seed = static_cast<std::uint64_t>(record.integer("seed"));
  const auto& yaw = record.numbers("yaw_range_deg");
  const auto& scale = record.numbers("scale_range");
  const std::size_t before = problems.count();
  // A fixed number of candidates over the rectangle, thinned by the region: the density is right on average
  // and the draw of one candidate never depends on another's.
  for (std::uint64_t i = 0; i < static_cast<std::uint64_t>(std::llround(expected)) && problems.count() < before + 20;
       ++i) {
    const auto draw = [&](double low, double high, std::uint64_t dimension) {
      return low + (high - low) * counter_uniform(seed, stream, i, dimension);
    };
    std::array<double, 3> p{draw(b[0], b[2], 0), draw(b[1], b[3], 1), 0};
    if (record.given("polygon_m") && !inside(record.value("polygon_m").points, p[0], p[1])) continue;
    if (record.given("class") && !in_class(parts, p[0], p[1], record.integer("class"))) continue;
    if (by_class) {
      if (!parts.memory.take_quietly(kPlaced_bytes)) {
        parts.memory.give_back(placed * kPlaced_bytes);
        fits(placed + 1);
        return;
      }
      ++placed;
    }
    if (drop(record, parts, record.where, p, problems))
      place(mesh, placement(p, draw(yaw[0], yaw[1], 2), draw(scale[0], scale[1], 3)), parts);
  }
}

void add_scatter(const Record& record, std::uint64_t stream, const MeshIndex& index, SceneParts& parts,
                 Problems& problems) {
  const auto mesh = find_mesh(record, index, problems);
  const bool listed = record.given("positions"), drawn = record.given("density_per_m2");
  if (listed == drawn) {
    problems.add(record.where, "a scatter needs exactly one of positions and density_per_m2",
                 listed ? "both" : "neither", "remove or add one");
    return;
  }
  const std::size_t placed = parts.placed.size(), before = problems.count();
  if (listed) {
    for (const char* key : {"rectangle_m", "polygon_m", "class", "yaw_range_deg", "scale_range", "seed"})
      if (record.given(key))
        problems.add(record.place(key), std::string("'") + key + "' goes with density_per_m2", "", "remove it");
    scatter_listed(record, mesh, parts, problems);
  } else {
    scatter_drawn(record, mesh, stream, parts, problems);
  }
  if (mesh >= 0 && parts.placed.size() == placed && problems.count() == before)
    parts.notices.push_back(record.where.text() + ": scatter of '" + record.text("mesh") + "' placed nothing");
}

}  // namespace

void add_meshes_and_instances(const Record& root, MaterialTable& materials, SceneParts& parts, Problems& problems) {
  const Record* scene = root.table("scene");
  const bool strict = scene != nullptr && scene->boolean("strict");
  MeshIndex index;
  for (const auto& record : root.records("mesh")) add_mesh(record, strict, materials, parts, index, problems);
  const std::size_t first = parts.placed.size();
  for (const auto& record : root.records("instance"))
    if (record.sound) add_instance(record, index, parts, problems);
  std::uint64_t stream = 0;
  for (const auto& record : root.records("scatter")) {
    ++stream;
    if (record.sound) add_scatter(record, stream, index, parts, problems);
  }
  std::vector<bool> used(parts.meshes.size());
  for (std::size_t i = first; i < parts.placed.size(); ++i) used[parts.placed[i].mesh] = true;
  for (const auto& [name, mesh] : index)
    if (mesh >= 0 && !used[static_cast<std::size_t>(mesh)])
      parts.notices.push_back("mesh '" + name + "' is never placed; add [[instance]] mesh = \"" + name + "\"");
}

}  // namespace raycube::scene
