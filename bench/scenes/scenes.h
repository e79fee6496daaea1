// Scenes of known triangle counts, generated from hashes alone: the same on every machine.
#pragma once

#include <array>
#include <vector>

#include "scene_compiler/bvh_builder.h"
#include "scene_compiler/simulation.h"

namespace raycube::bench {

/// 1 048 600 triangles: 450 x 450 quads over 400 x 400 m of rolling ground, 2000 bumpy icospheres of 320 triangles
/// (radius 1.2 to 3.8 m), 300 boxes. The ground is closed under every ray of terrain_camera().
scene::TriangleMesh terrain_mesh();

/// Closed, 20 480 triangles, radius 2 m about the origin, bumps of 10 %: every ray from within 0.9 m of the origin
/// hits.
scene::TriangleMesh bumpy_sphere();

/// 600 m above ground, 3.4 degrees off nadir, 0.5 m pixels, 256 x 256 about the scene's centre, 11 x 11 samples.
scene::Instrument terrain_camera();

/// Square leaves of `leaf_m` anywhere in a box of side_m x side_m x height_m about the origin, turned any way: `layers`
/// times its area in all, one side counted.
scene::TriangleMesh leaf_slab(double layers, double leaf_m, double side_m, double height_m, unsigned seed);
/// A spherical crown, radius 3 m about the origin: square leaves, 2 triangles each, uniform in volume and orientation.
scene::TriangleMesh crown_mesh(int leaves, double leaf_m, unsigned seed);

/// Places of 100 crowns within 54 x 54 m, turned about the vertical: row-major 3 x 4.
std::vector<std::array<double, 12>> crown_places();

/// 80 x 80 m of ground, 28 800 triangles.
scene::TriangleMesh crown_ground();

/// 600 m up, 1 m pixels, 64 x 64 over the crowns, 11 x 11 samples.
scene::Instrument crown_camera();

/// Adds `other`, moved by a row-major 3 x 4 matrix, to `mesh`.
void append(scene::TriangleMesh& mesh, const scene::TriangleMesh& other, const std::array<double, 12>& place);

/// One-material scene of placed meshes; place[i] lists where mesh i stands.
scene::CompiledScene compile(const std::vector<scene::TriangleMesh>& meshes,
                             const std::vector<std::vector<std::array<double, 12>>>& places);

inline constexpr std::array<double, 12> kIdentity{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

}  // namespace raycube::bench
