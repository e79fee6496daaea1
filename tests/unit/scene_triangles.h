// What a compiled scene holds, as triangles in double, and small rasters and materials for scenes of tests.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "scene_compiler/owner.h"
#include "scene_files.h"

namespace raycube::scene::testing {

using Vector = std::array<double, 3>;

/// A placed triangle: corners in the scene frame (m), its surface, and its face's number in the file.
struct Triangle {
  std::array<Vector, 3> v;
  std::uint32_t surface = 0;
  std::uint32_t face = 0;
};

/// Every placed triangle in the scene frame, from the compiled buffers in double.
inline std::vector<Triangle> placed_triangles(const CompiledScene& scene) {
  std::vector<Triangle> out;
  const MeshTriangles triangles(scene);
  for (const Placement& placement : placements(scene)) {
    const auto& instance = scene.instances[placement.instance];
    const auto place = [&](float x, float y, float z) {
      const auto row = [&](const shared::rc_float4& r) {
        return double(r.x) * x + double(r.y) * y + double(r.z) * z + double(r.w);
      };
      return Vector{row(instance.world_from_local_0), row(instance.world_from_local_1),
                    row(instance.world_from_local_2)};
    };
    for (const std::uint32_t primitive : triangles.of(placement.mesh)) {
      const auto& block = scene.blocks[primitive / RC_BLOCK];
      const std::uint32_t lane = primitive % RC_BLOCK;
      out.push_back({{place(block.v0_x[lane], block.v0_y[lane], block.v0_z[lane]),
                      place(block.v1_x[lane], block.v1_y[lane], block.v1_z[lane]),
                      place(block.v2_x[lane], block.v2_y[lane], block.v2_z[lane])},
                     block.surface[lane],
                     owner_of(scene, placement.instance, primitive).face});
    }
  }
  return out;
}

inline Vector cross_of(const Triangle& t) {
  Vector e, f;
  for (int k = 0; k < 3; ++k) e[k] = t.v[1][k] - t.v[0][k], f[k] = t.v[2][k] - t.v[0][k];
  return {e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]};
}

inline double area(const Triangle& t) {
  const auto n = cross_of(t);
  return 0.5 * std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
}

inline double total_area(const std::vector<Triangle>& triangles) {
  double sum = 0;
  for (const auto& t : triangles) sum += area(t);
  return sum;
}

inline Vector lowest(const std::vector<Triangle>& triangles) {
  Vector out = triangles.at(0).v[0];
  for (const auto& t : triangles)
    for (const auto& v : t.v)
      for (int k = 0; k < 3; ++k) out[k] = std::min(out[k], v[k]);
  return out;
}

inline Vector highest(const std::vector<Triangle>& triangles) {
  Vector out = triangles.at(0).v[0];
  for (const auto& t : triangles)
    for (const auto& v : t.v)
      for (int k = 0; k < 3; ++k) out[k] = std::max(out[k], v[k]);
  return out;
}

/// Materials 1 and 2 of reflectance 0.1 and 0.8.
inline constexpr const char* kTwo =
    "[[material]]\nname = \"dark\"\nreflectance = 0.1\n[[material]]\nname = \"light\"\nreflectance = 0.8\n";

/// ESRI ASCII grid, row 0 north; corner of the lower left pixel at (x, y).
inline std::string ascii_grid(int columns, int rows, double x, double y, double cell,
                              const std::vector<double>& values) {
  std::string out = "ncols " + std::to_string(columns) + "\nnrows " + std::to_string(rows) + "\nxllcorner " +
                    std::to_string(x) + "\nyllcorner " + std::to_string(y) + "\ncellsize " + std::to_string(cell) +
                    "\nNODATA_value -9999\n";
  for (int r = 0; r < rows; ++r, out += "\n")
    for (int c = 0; c < columns; ++c) out += std::to_string(values[static_cast<std::size_t>(r * columns + c)]) + " ";
  return out;
}

}  // namespace raycube::scene::testing
