#include "host/cli/info_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <ostream>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "scene_compiler/csv_file.h"
#include "scene_compiler/mesh_file.h"

namespace raycube::cli {
namespace {

constexpr std::array kMeshEndings = {".obj", ".ply", ".stl", ".gltf", ".glb", ".dae", ".fbx",
                                     ".3ds", ".off", ".dxf", ".x3d",  ".amf", ".ase"};

struct MeshBox {
  std::array<double, 3> low, high;
};

/// Of the vertices, in the file's own unit and axes.
MeshBox box_of(const scene::MeshFile& file) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  MeshBox out{{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};
  for (const auto& vertex : file.mesh.vertices)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double at = double(vertex[axis]) + file.centre_m[axis];
      out.low[axis] = std::min(out.low[axis], at), out.high[axis] = std::max(out.high[axis], at);
    }
  return out;
}

std::vector<std::uint64_t> triangles_of_parts(const scene::MeshFile& file) {
  std::vector<std::uint64_t> out(file.parts.size(), 0);
  for (const std::uint32_t part : file.mesh.surface) ++out[part];
  return out;
}

/// Vertices that have a place in images.
std::size_t placed_in_images(const scene::MeshFile& file) {
  return static_cast<std::size_t>(
      std::count_if(file.in_image.begin(), file.in_image.end(), [](const auto& at) { return !std::isnan(at[0]); }));
}

nlohmann::ordered_json mesh_json(const std::string& path, const scene::MeshFile& file) {
  const MeshBox box = box_of(file);
  const auto triangles = triangles_of_parts(file);
  nlohmann::ordered_json out = {{"kind", "mesh"},
                                {"file", path},
                                {"vertices", file.mesh.vertices.size()},
                                {"faces", file.faces},
                                {"faces_without_area", file.dropped_faces},
                                {"triangles", file.mesh.triangles.size()},
                                {"low", box.low},
                                {"high", box.high},
                                {"vertices_with_texture_coordinates", placed_in_images(file)},
                                {"parts", nlohmann::ordered_json::array()}};
  for (std::size_t i = 0; i < file.parts.size(); ++i)
    out["parts"].push_back({{"material", file.parts[i].material},
                            {"group", file.parts[i].group},
                            {"names", file.parts[i].names()},
                            {"triangles", triangles[i]}});
  return out;
}

void print_mesh(std::ostream& out, const std::string& path, const scene::MeshFile& file) {
  const MeshBox box = box_of(file);
  out << fmt::format("{}: mesh\n", path);
  out << fmt::format("  size          {} vertices, {} faces{}, {} triangles\n", file.mesh.vertices.size(), file.faces,
                     file.dropped_faces > 0 ? fmt::format(" ({} without area)", file.dropped_faces) : "",
                     file.mesh.triangles.size());
  for (std::size_t axis = 0; axis < 3; ++axis)
    out << fmt::format("  {}             {:g} to {:g} m\n", "xyz"[axis], box.low[axis], box.high[axis]);
  out << fmt::format("  frame         {} up{}, one unit is {:g} m{}\n", file.up,
                     file.declared.up ? "" : " ([[mesh]] up may say otherwise)", file.unit_m,
                     file.declared.unit_m ? "" : " (unit_m may say otherwise)");
  out << fmt::format("  in images     {} of the vertices have texture coordinates\n", placed_in_images(file));
  out << fmt::format("  {:>9}  {}\n", "triangles", "names that [[mesh]] materials may use, the first given counts");
  const auto triangles = triangles_of_parts(file);
  for (std::size_t i = 0; i < file.parts.size(); ++i) {
    const std::vector<std::string> names = file.parts[i].names();
    out << fmt::format("  {:>9}  {}\n", triangles[i],
                       names.empty() ? "(none: give [[mesh]] material)" : fmt::format("{}", fmt::join(names, ", ")));
  }
}

}  // namespace

bool is_mesh_file(const std::string& path) {
  const std::string ending = scene::lower_case(std::filesystem::path(path).extension().string());
  return std::find(kMeshEndings.begin(), kMeshEndings.end(), ending) != kMeshEndings.end();
}

void print_mesh_info(Invocation& invocation, const std::string& path) {
  base::Problems problems;
  const auto file = scene::read_mesh_file(path, {}, {path, 0, 0, ""}, problems);
  problems.throw_if_any();
  for (const std::string& notice : problems.notices()) invocation.log.warning(notice);
  if (invocation.common.json)
    invocation.out << mesh_json(path, *file).dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace)
                   << "\n";
  else
    print_mesh(invocation.out, path, *file);
}

}  // namespace raycube::cli
