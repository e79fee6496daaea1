#include "scene_compiler/mesh_file.h"

#include <assimp/DefaultLogger.hpp>
#include <assimp/Importer.hpp>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <limits>
#include <sstream>

#include "host/base/limited_child.h"
#include "scene_compiler/csv_file.h"
#include "scene_compiler/document_values.h"
#include "scene_compiler/polygon.h"

namespace raycube::scene {
namespace {

using base::Problems;
using base::Where;

constexpr std::size_t kMaxReports = 20;
// What reading may take. Assimp needs about 1 us and 10 to 60 bytes for each byte of OBJ or PLY text; formats
// that compress more.
constexpr double kBase_s = 60, kPerByte_s = 20e-6;
constexpr std::uint64_t kBase_bytes = 2ull << 30, kPerByte_bytes = 200;

/// Faces of one material and one group as Assimp has them, its node's transform applied.
struct Part {
  MeshPart names;
  std::vector<std::array<float, 3>> vertices;
  std::vector<std::array<float, 2>> in_image;
  std::vector<std::uint32_t> face_corners, corners;
};

std::string vertex_text(const std::array<float, 3>& v) {
  return "(" + number_text(v[0]) + ", " + number_text(v[1]) + ", " + number_text(v[2]) + ")";
}

/// Names of the nodes from this one up, the nearest first. What all of a file hangs from is named by the file or by
/// Assimp, unless it has a mesh itself.
std::vector<std::string> names_above(const aiNode& node) {
  std::vector<std::string> out;
  for (const aiNode* at = &node; at != nullptr; at = at->mParent)
    if (at->mName.length > 0 && (at->mParent != nullptr || at->mNumMeshes > 0)) out.emplace_back(at->mName.C_Str());
  return out;
}

void send_mesh(const aiScene& scene, const aiMesh& mesh, const aiMatrix4x4& file_from_node,
               const std::vector<std::string>& nodes, base::Parcel& parcel) {
  aiString material;
  if (mesh.mMaterialIndex < scene.mNumMaterials) scene.mMaterials[mesh.mMaterialIndex]->Get(AI_MATKEY_NAME, material);
  std::vector<std::array<float, 3>> vertices(mesh.mNumVertices);
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  std::vector<std::array<float, 2>> in_image(mesh.mNumVertices, {kNone, kNone});
  for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
    const aiVector3D v = file_from_node * mesh.mVertices[i];
    vertices[i] = {v.x, v.y, v.z};
    if (mesh.HasTextureCoords(0)) in_image[i] = {mesh.mTextureCoords[0][i].x, mesh.mTextureCoords[0][i].y};
  }
  std::vector<std::uint32_t> face_corners(mesh.mNumFaces), corners;
  for (unsigned i = 0; i < mesh.mNumFaces; ++i) {
    face_corners[i] = mesh.mFaces[i].mNumIndices;
    corners.insert(corners.end(), mesh.mFaces[i].mIndices, mesh.mFaces[i].mIndices + mesh.mFaces[i].mNumIndices);
  }
  parcel.value(true);
  parcel.text(material.C_Str());
  parcel.text(mesh.mName.C_Str());
  parcel.value(static_cast<std::uint64_t>(nodes.size()));
  for (const std::string& node : nodes) parcel.text(node);
  parcel.list(vertices.data(), vertices.size());
  parcel.list(in_image.data(), in_image.size());
  parcel.list(face_corners.data(), face_corners.size());
  parcel.list(corners.data(), corners.size());
}

void send_node(const aiScene& scene, const aiNode& node, const aiMatrix4x4& parent, base::Parcel& parcel) {
  const aiMatrix4x4 file_from_node = parent * node.mTransformation;
  for (unsigned i = 0; i < node.mNumMeshes; ++i)
    send_mesh(scene, *scene.mMeshes[node.mMeshes[i]], file_from_node, names_above(node), parcel);
  for (unsigned i = 0; i < node.mNumChildren; ++i) send_node(scene, *node.mChildren[i], file_from_node, parcel);
}

/// In the child: Assimp's word on the file (empty: it was read), then its meshes, each after a true, then a
/// false.
void read_by_assimp(const std::string& file, const std::string& text, base::Parcel& parcel) {
  Assimp::Importer importer;
  // Polygons stay whole here so that face numbers are the file's; normals and colours are not used.
  importer.SetPropertyInteger(AI_CONFIG_PP_RVC_FLAGS, aiComponent_NORMALS | aiComponent_TANGENTS_AND_BITANGENTS |
                                                          aiComponent_COLORS | aiComponent_BONEWEIGHTS |
                                                          aiComponent_ANIMATIONS | aiComponent_TEXTURES |
                                                          aiComponent_LIGHTS | aiComponent_CAMERAS);
  const auto other = ply_for_assimp(text);
  const aiScene* scene =
      other ? importer.ReadFileFromMemory(other->data(), other->size(), aiProcess_RemoveComponent, "ply")
            : importer.ReadFile(file, aiProcess_RemoveComponent);
  const bool read = scene != nullptr && scene->mRootNode != nullptr;
  const std::string said = importer.GetErrorString();
  parcel.text(read ? "" : said.empty() ? "no message" : said);
  if (!read) return;
  send_node(*scene, *scene->mRootNode, aiMatrix4x4(), parcel);
  parcel.value(false);
}

class Importer {
 public:
  Importer(std::string file, double unit_m, bool y_up, bool strict, Problems& problems)
      : file_(std::move(file)), unit_m_(unit_m), y_up_(y_up), strict_(strict), problems_(problems) {}

  void add_mesh(const Part& mesh) {
    const auto part = static_cast<std::uint32_t>(out.parts.size());
    out.parts.push_back(mesh.names);
    const auto first = static_cast<std::uint32_t>(out.mesh.vertices.size());
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
      const auto& v = mesh.vertices[i];
      if (!std::isfinite(v[0]) || !std::isfinite(v[1]) || !std::isfinite(v[2]))
        report("vertex " + std::to_string(first + i), "vertex is not finite", vertex_text(v), "correct the file");
      const double x = v[0] * unit_m_, y = v[1] * unit_m_, z = v[2] * unit_m_;
      if (y_up_)
        out.mesh.vertices.push_back({float(x), float(-z), float(y)});
      else
        out.mesh.vertices.push_back({float(x), float(y), float(z)});
    }
    out.in_image.insert(out.in_image.end(), mesh.in_image.begin(), mesh.in_image.end());
    const std::uint32_t* corner = mesh.corners.data();
    for (const std::uint32_t corners : mesh.face_corners) {
      add_face(corner, corners, static_cast<std::uint32_t>(mesh.vertices.size()), first, part);
      corner += corners;
    }
  }

  MeshFile out;

 private:
  void report(const std::string& element, const std::string& what, const std::string& found,
              const std::string& way_out) {
    if (++reports_ <= kMaxReports) problems_.add({file_, 0, 0, element}, what, found, way_out);
  }

  void add_face(const std::uint32_t* corner, std::uint32_t corner_count, std::uint32_t vertex_count,
                std::uint32_t first, std::uint32_t part) {
    const auto number = static_cast<std::uint32_t>(out.faces++);
    const std::string element = "face " + std::to_string(number);
    for (std::uint32_t k = 0; k < corner_count; ++k)
      if (corner[k] >= vertex_count) {
        report(element, "face index out of range",
               std::to_string(corner[k]) + " of " + std::to_string(vertex_count) + " vertices", "correct the file");
        return;
      }
    if (corner_count < 3) return;  // points and lines have no surface
    corners_.clear();
    for (std::uint32_t k = 0; k < corner_count; ++k) {
      const auto& v = out.mesh.vertices[first + corner[k]];
      corners_.push_back({v[0], v[1], v[2]});
    }
    bool kept = false;
    for (const auto& triangle : triangulate_polygon(corners_)) {
      const std::array<std::uint32_t, 3> index{first + corner[triangle[0]], first + corner[triangle[1]],
                                               first + corner[triangle[2]]};
      const auto& v = out.mesh.vertices;
      if (zero_area(v[index[0]], v[index[1]], v[index[2]])) continue;
      out.mesh.triangles.push_back(index);
      out.mesh.surface.push_back(part);
      out.mesh.user_face.push_back(number);
      kept = true;
    }
    if (kept) return;
    if (strict_)
      report(element, "face has no area", std::to_string(corner_count) + " corners",
             "remove it, or set scene.strict = false to drop such faces");
    if (out.dropped_faces++ == 0) out.first_dropped = element;
  }

  std::string file_;
  double unit_m_;
  bool y_up_, strict_;
  Problems& problems_;
  std::size_t reports_ = 0;
  std::vector<std::array<double, 3>> corners_;
};

/// The words of a text.
std::vector<std::string> words_of(const std::string& text) {
  std::istringstream in(text);
  return {std::istream_iterator<std::string>(in), {}};
}

/// A part's names as the child sends them; the groups of an OBJ's face stand in one name, apart by spaces.
MeshPart read_names(base::Unpacked& read, bool obj) {
  MeshPart out;
  out.material = read.text(), out.group = read.text();
  const auto nodes = read.value<std::uint64_t>();
  if (obj) out.others = words_of(out.group);
  for (std::uint64_t i = 0; i < nodes; ++i) out.others.push_back(read.text());
  return out;
}

}  // namespace

std::vector<std::string> MeshPart::names() const {
  std::vector<std::string> out;
  const auto add = [&](const std::string& name) {
    if (!name.empty() && std::find(out.begin(), out.end(), name) == out.end()) out.push_back(name);
  };
  add(material), add(group);
  for (const std::string& name : others) add(name);
  return out;
}

bool zero_area(const std::array<float, 3>& a, const std::array<float, 3>& b, const std::array<float, 3>& c) {
  const std::array<double, 3> e{double(b[0]) - a[0], double(b[1]) - a[1], double(b[2]) - a[2]};
  const std::array<double, 3> f{double(c[0]) - a[0], double(c[1]) - a[1], double(c[2]) - a[2]};
  const std::array<double, 3> g{double(c[0]) - b[0], double(c[1]) - b[1], double(c[2]) - b[2]};
  const double nx = e[1] * f[2] - e[2] * f[1], ny = e[2] * f[0] - e[0] * f[2], nz = e[0] * f[1] - e[1] * f[0];
  const auto square = [](const std::array<double, 3>& v) { return v[0] * v[0] + v[1] * v[1] + v[2] * v[2]; };
  const double longest2 = std::max({square(e), square(f), square(g)});
  return !(nx * nx + ny * ny + nz * nz > 4e-24 * longest2 * longest2);
}

std::optional<MeshFile> read_mesh_file(const std::string& file, double unit_m, bool y_up, bool strict,
                                       const Where& asked_by, Problems& problems) {
  const std::size_t before = problems.lines().size();
  const auto text = read_whole_file(file, asked_by, problems);
  if (!text) return std::nullopt;
  const bool obj = lower_case(std::filesystem::path(file).extension().string()) == ".obj";
  if (obj) check_obj_text(*text, file, problems);
  if (text->starts_with("ply")) check_ply_header(*text, file, problems);
  if (problems.lines().size() != before) return std::nullopt;

  // Damaged files hang, crash or bloat Assimp (5.2.5: a PLY header cut in a word). Whole ones take
  // microseconds a byte.
  const double bytes = static_cast<double>(text->size());
  base::ChildLimits limits;
  limits.cpu_s = kBase_s + kPerByte_s * bytes;
  limits.memory_bytes = kBase_bytes + kPerByte_bytes * text->size();
  base::Unpacked read =
      base::in_limited_child(limits, [&](base::Parcel& parcel) { read_by_assimp(file, *text, parcel); });
  const std::string said = read.end == base::ChildEnd::done ? read.text() : "it " + read.why;
  if (!said.empty()) {
    problems.add({file, 0, 0, ""}, "Assimp cannot read the mesh", said,
                 "correct or convert the file; " + asked_by.text() + " names it");
    return std::nullopt;
  }
  Importer reader(file, unit_m, y_up, strict, problems);
  while (read.value<bool>()) {
    Part part;
    part.names = read_names(read, obj);
    part.vertices = read.list<std::array<float, 3>>();
    part.in_image = read.list<std::array<float, 2>>();
    part.face_corners = read.list<std::uint32_t>(), part.corners = read.list<std::uint32_t>();
    reader.add_mesh(part);
  }
  if (problems.lines().size() != before) return std::nullopt;
  if (obj && !sound_obj_places(*text))
    for (auto& place : reader.out.in_image) place.fill(std::numeric_limits<float>::quiet_NaN());
  if (reader.out.mesh.triangles.empty()) {
    problems.add({file, 0, 0, ""}, "mesh has no faces with area",
                 std::to_string(reader.out.mesh.vertices.size()) + " vertices, " + std::to_string(reader.out.faces) +
                     " faces, " + std::to_string(reader.out.dropped_faces) + " of them without area",
                 "give a surface mesh; point clouds and lines have nothing to hit");
    return std::nullopt;
  }
  return std::move(reader.out);
}

}  // namespace raycube::scene
