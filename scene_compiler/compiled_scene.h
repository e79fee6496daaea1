// A scene flattened for the device: flat arrays, one mesh stored once however often it is placed. Frame: local
// ENU (x east, y north, z up), metres, relative to the recorded origin. Georeferenced doubles end here.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "kernels/shared/structs.h"

namespace raycube::scene {

/// One spectrum of a material. Wavelengths are vacuum, strictly ascending.
struct Curve {
  std::vector<double> wavelength_um;
  std::vector<double> value;  ///< reflectance or transmittance, 0..1
};

/// A named material. Its reflectance curve has id = index + 1 in term keys.
struct Material {
  std::string name;
  std::string source;         ///< where the curve comes from, as the user's file states it
  Curve reflectance;
  Curve transmittance;        ///< empty when opaque
  double temperature_K = 0;   ///< fixed temperature of everything made of it; 0: none given
};

struct Mesh {
  std::string name;
  std::uint32_t root = 0;         ///< node index of the tree's root
  std::uint32_t first_block = 0;
  std::uint32_t block_count = 0;
  std::uint32_t triangle_count = 0;
  std::uint32_t depth = 0;        ///< levels of nodes from root to deepest leaf
  std::array<float, 3> lo{}, hi{};  ///< bounds, m, mesh frame
  /// user_face[p - first_block * 16]: face number in the user's file of primitive p; RC_NONE in unused lanes
  std::vector<std::uint32_t> user_face;
};

/// Where the local frame lies. epsg 0: not georeferenced.
struct Origin {
  int epsg = 0;
  double easting_m = 0, northing_m = 0, height_m = 0;
};

struct CompiledScene {
  Origin origin;
  std::vector<Material> materials;
  std::vector<shared::Surface> surfaces;    ///< the first materials.size() are the pure materials, in order
  std::vector<Mesh> meshes;
  std::vector<shared::Instance> instances;
  std::vector<shared::BvhNode> nodes;       ///< top tree first: node 0 is its root (count 0 in an empty scene)
  std::vector<shared::TriBlock> blocks;
  std::uint32_t top_depth = 0;              ///< levels of the top tree
  std::array<float, 3> lo{}, hi{};          ///< world bounds, m; lo > hi in an empty scene
  std::string content_hash;                 ///< SHA-256 (hex) of everything above that changes a result

  /// Deepest stack a depth-first traversal of 8-wide nodes can need: 7 * (top_depth + deepest mesh) + 8.
  std::uint32_t stack_bound() const {
    std::uint32_t deepest = 0;
    for (const auto& mesh : meshes) deepest = mesh.depth > deepest ? mesh.depth : deepest;
    return 7u * (top_depth + deepest) + 8u;
  }
};

}  // namespace raycube::scene
