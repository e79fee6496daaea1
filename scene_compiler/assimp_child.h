// What Assimp reads of a mesh file, as a child process hands it over: each mesh once, however many nodes name it, and
// then where nodes put them.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/base/limited_child.h"
#include "scene_compiler/memory_sum.h"

namespace raycube::scene {

/// What all nodes of a file show together; a mesh that several nodes name counts for each.
struct ShownByNodes {
  double vertices = 0, faces = 0, corners = 0;
  double own_vertices = 0, own_corners = 0;  ///< of the meshes, each once
  double triangles() const { return std::max(faces, corners - 2 * faces); }
  /// Meshes as they are handed over and held, what nodes make of them, then triangles and their tree.
  double bytes() const { return 40 * own_vertices + 8 * own_corners + 20 * vertices + kTriangle_bytes * triangles(); }
};

/// Faces of one material and one group, in the mesh's own frame.
struct AssimpMesh {
  std::string material, name;
  std::vector<std::array<float, 3>> vertices;
  std::vector<std::array<float, 2>> in_image;
  std::vector<std::uint32_t> face_corners, corners;
};

/// A node that names a mesh.
struct AssimpNode {
  std::uint32_t mesh = 0;
  std::vector<std::string> names;          ///< of the node and of those above it, the nearest first
  std::array<float, 12> file_from_node{};  ///< row-major 3 x 4, of Assimp in single precision
  /// A vertex in the file's frame, in the order of operations of Assimp.
  std::array<float, 3> placed(const std::array<float, 3>& v) const {
    std::array<float, 3> out{};
    for (std::size_t i = 0; i < 3; ++i) {
      const float* const row = file_from_node.data() + 4 * i;
      out[i] = row[0] * v[0] + row[1] * v[1] + row[2] * v[2] + row[3];
    }
    return out;
  }
};

bool is_obj(const std::string& file);

/// In the child: Assimp's word on the file (empty: it was read), what its nodes show, then, where there is room for
/// that, what it declares of axis and unit, its meshes, and each node that names one, after a true, then a false.
void send_by_assimp(const std::string& file, const std::string& text,
                    const std::optional<std::array<double, 3>>& centre, double room_bytes, base::Parcel& parcel);

/// The meshes, and then node by node, as they come; nullopt after the last.
std::vector<AssimpMesh> take_meshes(base::Unpacked& read);
std::optional<AssimpNode> take_node(base::Unpacked& read);

}  // namespace raycube::scene
