// A scene flattened for the device: flat arrays, one mesh stored once however often it is placed, meshes that always
// stand together in one tree. Frame: local ENU (x east, y north, z up), metres, relative to the recorded origin.
// Georeferenced doubles end here. Whose a triangle is, the user's placement, mesh and face, only owner.h says.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "kernels/materials/shapes.h"
#include "kernels/shared/structs.h"

namespace raycube::scene {

/// One spectrum of a material. Wavelengths are vacuum, strictly ascending.
struct Curve {
  std::vector<double> wavelength_um;
  std::vector<double> value;  ///< reflectance or transmittance, 0..1
};

/// Numbers of a shape that has more than parameters: in kernels/materials/measured.h. Shared by all that it shapes.
using ShapeTable = std::shared_ptr<const std::vector<float>>;

/// A scattering shape of kernels/materials/materials.def and its parameters, in the order of its entry.
struct Shape {
  std::uint32_t number = RC_SHAPE_none;
  std::array<double, 6> parameter{};
  ShapeTable table{};
  bool operator==(const Shape& other) const {
    const bool same_table = table == other.table || (table && other.table && *table == *other.table);
    return number == other.number && parameter == other.parameter && same_table;
  }
  RcParameters parameters() const {
    RcParameters out;
    std::copy(parameter.begin(), parameter.end(), out.of);
    out.table = table ? table->data() : nullptr;
    return out;
  }
};

/// A shape at one of the wavelengths that it is given at; of shapes whose form depends on the material's curve, at one
/// of the curve's values, which its parameter holds.
struct ShapeNode {
  double wavelength_um = 0;
  Shape shape;
  bool operator==(const ShapeNode&) const = default;
};

/// Part of what a material sends back: a shape that knows no wavelength times a curve.
struct FurtherLobe {
  Shape shape;
  Curve curve;
};

/// A named material: curves that it owns (ids: kernels/shared/product_key.h), and how it scatters.
struct Material {
  std::string name;    ///< a family's members have its name
  std::string source;  ///< where the curve comes from, as the user's file states it
  Curve reflectance;
  Curve transmittance;            ///< empty when opaque
  double temperature_K = 0;       ///< fixed temperature of everything made of it; 0: none given
  std::int32_t las_class = 1;     ///< of LIDAR returns, as ASPRS numbers classes
  Shape front{RC_SHAPE_lambert};  ///< how its reflectance is spread over directions
  Shape behind{RC_SHAPE_leaf};    ///< where its transmittance goes
  Shape gloss{RC_SHAPE_none};     ///< beside its reflectance
  /// Of shapes that change with wavelength (spectral_shape.h), by wavelength, ascending, two at least; else none. The
  /// first node's shape is `front`, or `gloss`.
  std::vector<ShapeNode> front_nodes, gloss_nodes;
  Curve index_n, index_k;            ///< refractive index of a gloss by Fresnel's law; else empty
  Curve front_curve, gloss_curve;    ///< of the first lobes, where those above make some: follow from them
  std::vector<FurtherLobe> further;  ///< those of `front` first: follow likewise
  std::uint32_t in_family = 0;       ///< place among the members, which follow one another; 0: the first, or no family
};

/// A gas or aerosol volume on the way of pulses.
struct Volume {
  enum class Shape { box, grid, plume } shape = Shape::box;
  std::string name;
  std::array<double, 3>
      position_m{};  ///< box, grid: centre of the base; plume: the source's foot, on the ground it reflects from
  std::array<double, 3> size_m{};  ///< box, grid: along x, y, z
  double yaw_deg = 0;              ///< azimuth of its +y axis; plume: of the wind's way
  /// Gas: mixing ratio times the number density that cross sections assume (1 ppm m = 2.479371580e15 cm-2 at 296 K).
  std::string gas;               ///< empty: none
  double concentration_ppm = 0;  ///< box; grid: factor on its values
  std::array<int, 3> cells{};    ///< grid, values at cell centres, trilinear, zero outside
  std::vector<float> values;     ///< grid, x fastest
  // plume: Gaussian, reflected at its foot: C = Q/(2 pi u sy sz) exp(-y^2/2sy^2) [exp(-(z-H)^2/2sz^2) +
  // exp(-(z+H)^2/2sz^2)]
  double source_g_s = 0, wind_m_s = 1, release_height_m = 0, molar_mass_g = 16.0425;
  double sigma_y_a = 0.08, sigma_y_b = 1e-4;    ///< sy = a x / sqrt(1 + b x) (Briggs, x in m)
  double sigma_z_a = 0.06, sigma_z_b = 1.5e-3;  ///< sz = a x / sqrt(1 + b x)
  double sigma_y_m = 0, sigma_z_m = 0;          ///< > 0: constant instead
  double length_m = 1000;                       ///< it ends here
  // particles
  double extinction_per_m = 0, lidar_ratio_sr = 50;
  /// Cross sections of the gas: vacuum wavelength ascending, cm2 per molecule; linear between.
  std::vector<double> wavelength_um, cross_section_cm2;
};

/// A mesh as the user gave it. Its triangles lie in a tree, perhaps among those of others.
struct Mesh {
  std::string name;
  std::uint32_t tree = 0;                ///< index into CompiledScene::trees
  std::uint32_t placed_after = 0;        ///< in its tree: places behind the tree's first mesh in the user's list
  std::array<float, 3> lo{}, hi{};       ///< bounds, m, mesh frame
  std::vector<std::uint32_t> user_face;  ///< face number in the user's file of each triangle, in the user's order
  std::uint32_t triangle_count() const { return static_cast<std::uint32_t>(user_face.size()); }
};

/// Which meshes share a tree: those that are always placed together (placed_together.h), or none, which tests compare.
enum class TreeSharing { together, none };

/// The triangles of one mesh, or of several that are always placed together, in one BVH.
struct Tree {
  std::vector<std::uint32_t> meshes;  ///< by placed_after, ascending; the first has 0
  std::uint32_t root = 0;             ///< node index
  std::uint32_t first_block = 0;
  std::uint32_t block_count = 0;
  std::uint32_t triangle_count = 0;  ///< of all its meshes
  std::uint32_t depth = 0;           ///< levels of nodes from root to deepest leaf
  std::array<float, 3> lo{}, hi{};   ///< bounds, m, frame of its meshes
};

/// Where the local frame lies. epsg 0: not georeferenced.
struct Origin {
  int epsg = 0;
  double easting_m = 0, northing_m = 0, height_m = 0;
};

/// Where the ground is known to hide nothing (skyline.h): a grid over the map of one placed tree, in its frame.
struct Skyline {
  std::uint32_t instance = RC_NONE;      ///< RC_NONE: no such grid
  float x_m = 0, y_m = 0, per_cell = 0;  ///< corner of the first cell; cells a metre
  std::uint32_t columns = 0, rows = 0;
  std::vector<float> cells;  ///< [row][column][2]: top, skyline
};

struct CompiledScene {
  Origin origin;
  std::vector<Material> materials;
  std::vector<Volume> volumes;
  std::vector<shared::Surface> surfaces;    ///< the first materials.size() are the pure materials, in order
  std::vector<Mesh> meshes;                 ///< in the user's order
  std::vector<Tree> trees;                  ///< in the order of their first meshes
  std::vector<shared::Instance> instances;  ///< placed trees, by placement, ascending
  std::vector<shared::BvhNode> nodes;       ///< top tree first: node 0 is its root (count 0 in an empty scene)
  std::vector<shared::TriBlock> blocks;
  Skyline skyline;                    ///< follows from what is above
  std::uint32_t top_depth = 0;        ///< levels of the top tree
  std::array<float, 3> lo{}, hi{};    ///< world bounds, m; lo > hi in an empty scene
  std::string content_hash;           ///< SHA-256 (hex) of everything above that changes a result
  std::vector<std::uint32_t> buried;  ///< placements under the terrain, ascending; of a loaded simulation alone

  /// Deepest stack a depth-first traversal of 8-wide nodes can need: 7 * (top_depth + deepest tree) + 8.
  std::uint32_t stack_bound() const {
    std::uint32_t deepest = 0;
    for (const auto& tree : trees) deepest = tree.depth > deepest ? tree.depth : deepest;
    return 7u * (top_depth + deepest) + 8u;
  }
};

/// The surface of a family's first member where this is that of another; of mixtures and all else itself.
inline std::uint32_t family_surface(const CompiledScene& scene, std::uint32_t surface) {
  return surface < scene.materials.size() ? surface - scene.materials[surface].in_family : surface;
}

}  // namespace raycube::scene
