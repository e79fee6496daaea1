// Meshes of PLY files (Turk 1994), text and binary. Assimp 5.2.5 loses what the format allows: triangle strips but for
// one, rows after elements that stand before the vertices, bytes after a line feed, and digits of doubles.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/base/error.h"

namespace raycube::scene {

struct PlyMesh {
  std::vector<std::array<double, 3>> vertices;  ///< in the file's own numbers
  std::vector<std::array<float, 2>> in_image;   ///< of each vertex, NaN where the file gives none
  std::vector<std::uint32_t> face_corners;      ///< corners of each face, those of strips as triangles
  std::vector<std::uint32_t> corners;           ///< numbers of vertices, face after face; not checked
};

/// Elements may stand in any order; those and properties that are no geometry are passed over. Vertices: x, y, z, and
/// s t, u v or texture_u texture_v. Faces: a list vertex_indices or vertex_index. Strips: a list of that name in
/// tristrips, -1 begins another. nullopt after reporting, with the line or the element: a header that is cut short,
/// misspelt, or counts more or fewer numbers than the file holds; what is no number; vertices without coordinates.
std::optional<PlyMesh> read_ply(const std::string& text, const std::string& file, base::Problems& problems);

}  // namespace raycube::scene
