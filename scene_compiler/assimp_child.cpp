#include "scene_compiler/assimp_child.h"

#include <assimp/DefaultIOSystem.h>
#include <assimp/DefaultLogger.hpp>
#include <assimp/Importer.hpp>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <filesystem>
#include <limits>
#include <utility>

#include "host/base/input_file.h"
#include "host/base/text.h"
#include "scene_compiler/csv_file.h"
#include "scene_compiler/mesh_declared.h"
#include "scene_compiler/mesh_file.h"

namespace raycube::scene {
namespace {

/// Names of the nodes from this one up, the nearest first. What all of a file hangs from is named by the file or by
/// Assimp, unless it has a mesh itself.
std::vector<std::string> names_above(const aiNode& node) {
  std::vector<std::string> out;
  for (const aiNode* at = &node; at != nullptr; at = at->mParent)
    if (at->mName.length > 0 && (at->mParent != nullptr || at->mNumMeshes > 0)) out.emplace_back(at->mName.C_Str());
  return out;
}

std::vector<std::array<float, 2>> places_in_image(const aiMesh& mesh) {
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  std::vector<std::array<float, 2>> out(mesh.mNumVertices, {kNone, kNone});
  for (unsigned i = 0; i < mesh.mNumVertices && mesh.HasTextureCoords(0); ++i)
    out[i] = {mesh.mTextureCoords[0][i].x, mesh.mTextureCoords[0][i].y};
  return out;
}

void send_mesh(const aiScene& scene, const aiMesh& mesh, base::Parcel& parcel) {
  aiString material;
  if (mesh.mMaterialIndex < scene.mNumMaterials) scene.mMaterials[mesh.mMaterialIndex]->Get(AI_MATKEY_NAME, material);
  std::vector<std::array<float, 3>> vertices(mesh.mNumVertices);
  for (unsigned i = 0; i < mesh.mNumVertices; ++i)
    vertices[i] = {mesh.mVertices[i].x, mesh.mVertices[i].y, mesh.mVertices[i].z};
  const auto in_image = places_in_image(mesh);
  std::vector<std::uint32_t> face_corners(mesh.mNumFaces), corners;
  for (unsigned i = 0; i < mesh.mNumFaces; ++i) {
    face_corners[i] = mesh.mFaces[i].mNumIndices;
    corners.insert(corners.end(), mesh.mFaces[i].mIndices, mesh.mFaces[i].mIndices + mesh.mFaces[i].mNumIndices);
  }
  parcel.text(material.C_Str());
  parcel.text(mesh.mName.C_Str());
  parcel.list(vertices.data(), vertices.size());
  parcel.list(in_image.data(), in_image.size());
  parcel.list(face_corners.data(), face_corners.size());
  parcel.list(corners.data(), corners.size());
}

/// Calls visit(node, mesh number) for each mesh of each node, the file's order.
template <class Visit>
void for_node_meshes(const aiNode& node, const aiMatrix4x4& parent, const Visit& visit) {
  const aiMatrix4x4 file_from_node = parent * node.mTransformation;
  for (unsigned i = 0; i < node.mNumMeshes; ++i) visit(node, file_from_node, node.mMeshes[i]);
  for (unsigned i = 0; i < node.mNumChildren; ++i) for_node_meshes(*node.mChildren[i], file_from_node, visit);
}

void send_node(const aiNode& node, const aiMatrix4x4& file_from_node, std::uint32_t mesh, base::Parcel& parcel) {
  parcel.value(true), parcel.value(mesh);
  const std::vector<std::string> names = names_above(node);
  parcel.value(static_cast<std::uint64_t>(names.size()));
  for (const std::string& name : names) parcel.text(name);
  AssimpNode out;
  for (unsigned row = 0; row < 3; ++row)
    for (unsigned column = 0; column < 4; ++column) out.file_from_node[4 * row + column] = file_from_node[row][column];
  parcel.value(out.file_from_node);
}

/// The file's meshes that nodes name, by the file's numbers, and their own numbers: RC_NONE of others.
std::vector<std::uint32_t> numbers_of_named(const aiScene& scene, std::vector<std::uint32_t>& named) {
  std::vector<std::uint32_t> out(scene.mNumMeshes, RC_NONE);
  for_node_meshes(*scene.mRootNode, {}, [&](const aiNode&, const aiMatrix4x4&, std::uint32_t mesh) {
    if (out[mesh] != RC_NONE) return;
    out[mesh] = static_cast<std::uint32_t>(named.size());
    named.push_back(mesh);
  });
  return out;
}

double corners_of(const aiMesh& mesh) {
  double out = 0;
  for (unsigned f = 0; f < mesh.mNumFaces; ++f) out += mesh.mFaces[f].mNumIndices;
  return out;
}

ShownByNodes count_shown(const aiScene& scene, const std::vector<std::uint32_t>& named) {
  ShownByNodes out;
  std::vector<double> corners(scene.mNumMeshes, 0);
  for (const std::uint32_t mesh : named) {
    corners[mesh] = corners_of(*scene.mMeshes[mesh]);
    out.own_vertices += scene.mMeshes[mesh]->mNumVertices, out.own_corners += corners[mesh];
  }
  for_node_meshes(*scene.mRootNode, {}, [&](const aiNode&, const aiMatrix4x4&, std::uint32_t mesh) {
    out.vertices += scene.mMeshes[mesh]->mNumVertices, out.faces += scene.mMeshes[mesh]->mNumFaces;
    out.corners += corners[mesh];
  });
  return out;
}

/// What the file's own numbers are, by its ending and what Assimp 5.2.5 says of it.
MeshFrame declared_frame(const aiScene& scene, const std::string& file) {
  const std::string ending = lower_case(std::filesystem::path(file).extension().string());
  if (ending == ".3mf") {
    DeclaredUnit unit = package_unit(file);
    return {'z', unit.metres, false, std::move(unit.wrong)};
  }
  if (ending == ".gltf" || ending == ".glb") return {'y', 1.0};
  if (ending == ".3ds" || ending == ".dxf" || ending == ".ase") return {'z', std::nullopt};
  if (ending == ".x3d" || ending == ".wrl") return {'y', 1.0};
  if (ending == ".dae") return {'z', 1.0};  // declared; Assimp has made metres of it, and turned it (below)
  MeshFrame out;
  int axis = 0, sign = 1;
  float centimetres = 0;
  if (ending != ".fbx" || !scene.mMetaData) return out;
  if (scene.mMetaData->Get("UpAxis", axis) && axis >= 0 && axis <= 2) out.up = "xyz"[axis];
  if (scene.mMetaData->Get("UpAxisSign", sign) && sign < 0) out.upside_down = true;
  if (scene.mMetaData->Get("UnitScaleFactor", centimetres) && centimetres > 0) out.unit_m = 0.01 * double(centimetres);
  return out;
}

/// Files that a mesh's file names, for Assimp: plain ones, since opening a pipe waits and a device may never end.
class PlainFiles : public Assimp::DefaultIOSystem {
 public:
  /// refused: what was asked for and is no plain file, and why.
  explicit PlainFiles(std::string& refused) : refused_(refused) {}
  bool Exists(const char* path) const override { return is_plain(path) && DefaultIOSystem::Exists(path); }
  Assimp::IOStream* Open(const char* path, const char* mode) override {
    return is_plain(path) ? DefaultIOSystem::Open(path, mode) : nullptr;
  }

 private:
  bool is_plain(const char* path) const {
    std::error_code code;
    if (!std::filesystem::exists(path, code)) return true;  // Assimp says that it is missing
    const std::string why = base::why_no_plain_file(path);
    if (!why.empty() && !std::filesystem::is_directory(path, code)) refused_ = std::string(path) + ", which " + why;
    return why.empty();
  }
  std::string& refused_;
};

}  // namespace

bool is_obj(const std::string& file) { return lower_case(std::filesystem::path(file).extension().string()) == ".obj"; }

void send_by_assimp(const std::string& file, const std::string& text,
                    const std::optional<std::array<double, 3>>& centre, double room_bytes, base::Parcel& parcel) {
  Assimp::Importer importer;
  // Polygons stay whole here so that face numbers are the file's; normals and colours are not used.
  importer.SetPropertyInteger(AI_CONFIG_PP_RVC_FLAGS, aiComponent_NORMALS | aiComponent_TANGENTS_AND_BITANGENTS |
                                                          aiComponent_COLORS | aiComponent_BONEWEIGHTS |
                                                          aiComponent_ANIMATIONS | aiComponent_TEXTURES |
                                                          aiComponent_LIGHTS | aiComponent_CAMERAS);
  std::string refused;
  importer.SetIOHandler(new PlainFiles(refused));  // which the importer deletes
  const bool obj = is_obj(file);
  const auto other = obj ? obj_for_assimp(text, centre.value_or(std::array<double, 3>{})) : std::nullopt;
  const aiScene* scene =
      other ? importer.ReadFileFromMemory(other->data(), other->size(), aiProcess_RemoveComponent, "obj")
            : importer.ReadFile(file, aiProcess_RemoveComponent);
  const bool read = refused.empty() && scene != nullptr && scene->mRootNode != nullptr;
  const std::string said = refused.empty() ? importer.GetErrorString() : "it names " + refused;
  parcel.text(read ? "" : said.empty() ? "no message" : said);
  if (!read) return;
  std::vector<std::uint32_t> named;
  const std::vector<std::uint32_t> number = numbers_of_named(*scene, named);
  const ShownByNodes shown = count_shown(*scene, named);
  parcel.value(shown);
  if (shown.bytes() > room_bytes) return;
  const MeshFrame declared = declared_frame(*scene, file);
  parcel.value(declared.up.value_or('\0')), parcel.value(declared.unit_m.value_or(0));
  parcel.value(declared.upside_down), parcel.text(declared.wrong_unit);
  parcel.value(static_cast<std::uint64_t>(named.size()));
  for (const std::uint32_t mesh : named) send_mesh(*scene, *scene->mMeshes[mesh], parcel);
  for_node_meshes(*scene->mRootNode, {}, [&](const aiNode& node, const aiMatrix4x4& file_from_node, unsigned mesh) {
    send_node(node, file_from_node, number[mesh], parcel);
  });
  parcel.value(false);
}

std::vector<AssimpMesh> take_meshes(base::Unpacked& read) {
  std::vector<AssimpMesh> out(read.value<std::uint64_t>());
  for (AssimpMesh& mesh : out) {
    mesh.material = read.text(), mesh.name = read.text();
    mesh.vertices = read.list<std::array<float, 3>>();
    mesh.in_image = read.list<std::array<float, 2>>();
    mesh.face_corners = read.list<std::uint32_t>(), mesh.corners = read.list<std::uint32_t>();
  }
  return out;
}

std::optional<AssimpNode> take_node(base::Unpacked& read) {
  if (!read.value<bool>()) return std::nullopt;
  AssimpNode out;
  out.mesh = read.value<std::uint32_t>();
  out.names.resize(read.value<std::uint64_t>());
  for (std::string& name : out.names) name = read.text();
  out.file_from_node = read.value<std::array<float, 12>>();
  return out;
}

}  // namespace raycube::scene
