#include "scene_compiler/mesh_file.h"

#include <assimp/DefaultLogger.hpp>
#include <assimp/Importer.hpp>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "scene_compiler/csv_file.h"
#include "scene_compiler/document_values.h"
#include "scene_compiler/polygon.h"

namespace raycube::scene {
namespace {

using base::Problems;
using base::Where;

constexpr std::size_t kMaxReports = 20;

std::string vertex_text(const aiVector3D& v) {
  return "(" + number_text(v.x) + ", " + number_text(v.y) + ", " + number_text(v.z) + ")";
}

/// Squared doubled area over squared longest edge to the fourth: 0 for a degenerate triangle, at most 3/4.
bool zero_area(const std::array<float, 3>& a, const std::array<float, 3>& b, const std::array<float, 3>& c) {
  const std::array<double, 3> e{double(b[0]) - a[0], double(b[1]) - a[1], double(b[2]) - a[2]};
  const std::array<double, 3> f{double(c[0]) - a[0], double(c[1]) - a[1], double(c[2]) - a[2]};
  const std::array<double, 3> g{double(c[0]) - b[0], double(c[1]) - b[1], double(c[2]) - b[2]};
  const double nx = e[1] * f[2] - e[2] * f[1], ny = e[2] * f[0] - e[0] * f[2], nz = e[0] * f[1] - e[1] * f[0];
  const auto square = [](const std::array<double, 3>& v) { return v[0] * v[0] + v[1] * v[1] + v[2] * v[2]; };
  const double longest2 = std::max({square(e), square(f), square(g)});
  return !(nx * nx + ny * ny + nz * nz > 4e-24 * longest2 * longest2);
}

class Importer {
 public:
  Importer(std::string file, double unit_m, bool y_up, bool strict, Problems& problems)
      : file_(std::move(file)), unit_m_(unit_m), y_up_(y_up), strict_(strict), problems_(problems) {}

  void add_node(const aiScene& scene, const aiNode& node, const aiMatrix4x4& parent) {
    const aiMatrix4x4 file_from_node = parent * node.mTransformation;
    for (unsigned i = 0; i < node.mNumMeshes; ++i)
      add_mesh(scene, *scene.mMeshes[node.mMeshes[i]], file_from_node);
    for (unsigned i = 0; i < node.mNumChildren; ++i) add_node(scene, *node.mChildren[i], file_from_node);
  }

  MeshFile out;

 private:
  void report(const std::string& element, const std::string& what, const std::string& found,
              const std::string& way_out) {
    if (++reports_ <= kMaxReports) problems_.add({file_, 0, 0, element}, what, found, way_out);
  }

  void add_mesh(const aiScene& scene, const aiMesh& mesh, const aiMatrix4x4& file_from_node) {
    aiString material;
    if (mesh.mMaterialIndex < scene.mNumMaterials)
      scene.mMaterials[mesh.mMaterialIndex]->Get(AI_MATKEY_NAME, material);
    const auto part = static_cast<std::uint32_t>(out.parts.size());
    out.parts.push_back({material.C_Str(), mesh.mName.C_Str()});
    const auto first = static_cast<std::uint32_t>(out.mesh.vertices.size());
    for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
      const aiVector3D v = file_from_node * mesh.mVertices[i];
      if (!std::isfinite(v.x) || !std::isfinite(v.y) || !std::isfinite(v.z))
        report("vertex " + std::to_string(first + i), "vertex is not finite", vertex_text(v),
               "correct the file");
      const double x = v.x * unit_m_, y = v.y * unit_m_, z = v.z * unit_m_;
      if (y_up_)
        out.mesh.vertices.push_back({float(x), float(-z), float(y)});
      else
        out.mesh.vertices.push_back({float(x), float(y), float(z)});
    }
    for (unsigned i = 0; i < mesh.mNumFaces; ++i) add_face(mesh.mFaces[i], mesh.mNumVertices, first, part);
  }

  void add_face(const aiFace& face, unsigned vertex_count, std::uint32_t first, std::uint32_t part) {
    const auto number = static_cast<std::uint32_t>(out.faces++);
    const std::string element = "face " + std::to_string(number);
    for (unsigned k = 0; k < face.mNumIndices; ++k)
      if (face.mIndices[k] >= vertex_count) {
        report(element, "face index out of range",
               std::to_string(face.mIndices[k]) + " of " + std::to_string(vertex_count) + " vertices",
               "correct the file");
        return;
      }
    if (face.mNumIndices < 3) return;  // points and lines have no surface
    corners_.clear();
    for (unsigned k = 0; k < face.mNumIndices; ++k) {
      const auto& v = out.mesh.vertices[first + face.mIndices[k]];
      corners_.push_back({v[0], v[1], v[2]});
    }
    bool kept = false;
    for (const auto& triangle : triangulate_polygon(corners_)) {
      const std::array<std::uint32_t, 3> index{first + face.mIndices[triangle[0]],
                                               first + face.mIndices[triangle[1]],
                                               first + face.mIndices[triangle[2]]};
      const auto& v = out.mesh.vertices;
      if (zero_area(v[index[0]], v[index[1]], v[index[2]])) continue;
      out.mesh.triangles.push_back(index);
      out.mesh.surface.push_back(part);
      out.mesh.user_face.push_back(number);
      kept = true;
    }
    if (kept) return;
    if (strict_)
      report(element, "face has no area", std::to_string(face.mNumIndices) + " corners",
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

}  // namespace

std::optional<MeshFile> read_mesh_file(const std::string& file, double unit_m, bool y_up, bool strict,
                                       const Where& asked_by, Problems& problems) {
  const std::size_t before = problems.lines().size();
  const auto text = read_whole_file(file, asked_by, problems);
  if (!text) return std::nullopt;
  if (lower_case(std::filesystem::path(file).extension().string()) == ".obj")
    check_obj_text(*text, file, problems);
  if (problems.lines().size() != before) return std::nullopt;

  Assimp::Importer importer;
  // Polygons stay whole here so that face numbers are the file's; normals, colours and texture coordinates
  // are not used.
  importer.SetPropertyInteger(AI_CONFIG_PP_RVC_FLAGS,
                              aiComponent_NORMALS | aiComponent_TANGENTS_AND_BITANGENTS | aiComponent_COLORS |
                                  aiComponent_TEXCOORDS | aiComponent_BONEWEIGHTS | aiComponent_ANIMATIONS |
                                  aiComponent_TEXTURES | aiComponent_LIGHTS | aiComponent_CAMERAS);
  const aiScene* scene = importer.ReadFile(file, aiProcess_RemoveComponent);
  if (scene == nullptr || scene->mRootNode == nullptr) {
    problems.add({file, 0, 0, ""}, "Assimp cannot read the mesh", importer.GetErrorString(),
                 "correct or convert the file; " + asked_by.text() + " names it");
    return std::nullopt;
  }
  Importer reader(file, unit_m, y_up, strict, problems);
  reader.add_node(*scene, *scene->mRootNode, aiMatrix4x4());
  if (problems.lines().size() != before) return std::nullopt;
  if (reader.out.mesh.triangles.empty()) {
    problems.add({file, 0, 0, ""}, "mesh has no faces with area",
                 std::to_string(reader.out.mesh.vertices.size()) + " vertices, " +
                     std::to_string(reader.out.faces) + " faces, " +
                     std::to_string(reader.out.dropped_faces) + " of them without area",
                 "give a surface mesh; point clouds and lines have nothing to hit");
    return std::nullopt;
  }
  return std::move(reader.out);
}

}  // namespace raycube::scene
