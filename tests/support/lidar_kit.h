// LIDAR plans filled by hand, shots and small scenes, for tests of device and reference.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "host/lidar/lidar_plan.h"
#include "scene_compiler/bvh_builder.h"

namespace raycube::test {

/// Test L-01 of the LIDAR specification: 100 uJ at 1064 nm, 4 ns, 10 cm aperture with 3 cm obscured, 1000 bins of 1 ns
/// from
/// 6200 ns, 1/e2 half divergence 0.25 mrad, 256 sub-rays, overlap and air return off.
scene::Lidar topographic_lidar();

/// The same with one ray down the axis: what closed forms of a point describe.
scene::Lidar pencil_lidar();

/// The array of test L-02, DIRSIG's demo LidarValidate1: 150 uJ over a disc of 8 mrad half angle, 3 x 3 pixels of 0.125
/// mrad.
scene::Lidar flash_lidar();

/// Pulse shares over `phases` positions within a bin, integrated in double (erfc differences for a Gaussian, out to 6.5
/// standard deviations); shape as the pulse says (gaussian, rectangular; 0 s: an impulse).
lidar::PulseTaps make_taps(const scene::LidarPulse& pulse, double bin_s, int phases = 1024);

/// Nodes: one a line. Photons, matter from the materials' curves, taps, footprint. No air, no gas.
lidar::LidarPlan hand_plan(const scene::Lidar& lidar, const scene::CompiledScene& scene, std::uint64_t seed = 1);

/// The same air between two heights, at every node and line; nothing above `high_m`, the same below `low_m`.
void set_air(lidar::LidarPlan& plan, double extinction_per_m, double backscatter_per_m_sr, double low_m, double high_m);

/// A shot whose exit and pupil are both at a place and look along a direction (any length).
lidar::Shot shot_from(const scene::Lidar& lidar, const lidar::Vec3& at_m, const lidar::Vec3& towards,
                      std::int64_t pulse = 0);
/// Turns the pupil to look along a direction from a place of its own.
void place_pupil(lidar::Shot& shot, const lidar::Vec3& at_m, const lidar::Vec3& towards);

/// Empty scene with materials of constant reflectance; material and surface numbers are equal. Call finish_top_tree at
/// the end.
scene::CompiledScene scene_of(const std::vector<double>& reflectances);
/// Rectangle of 2 half x 2 half m about a centre, its normal tilted from +z towards +x.
void add_plane(scene::CompiledScene& scene, std::uint32_t surface, const lidar::Vec3& centre_m, double half_m,
               double tilt_rad = 0);
/// Rectangle from a corner; normal = edge_a x edge_b.
void add_rectangle(scene::CompiledScene& scene, std::uint32_t surface, const lidar::Vec3& corner_m,
                   const lidar::Vec3& edge_a_m, const lidar::Vec3& edge_b_m);
/// Right-angle corner: plate A in z = 0 (0 <= x <= length), plate B in x = 0 (0 <= z <= height), both |y| <=
/// half_width.
void add_corner(scene::CompiledScene& scene, std::uint32_t surface_a, std::uint32_t surface_b, double length_m,
                double height_m, double half_width_m);

/// The sum of a row's bins.
double total(const std::vector<float>& row);

/// Bins of one row.
struct Moments {
  double sum = 0, mean_bin = 0, deviation_bins = 0;  ///< of bin centres
};
Moments moments(const std::vector<float>& row);

/// Planck's constant times the speed of light, J m.
inline constexpr double kPlanckLight = 6.62607015e-34 * 299792458.0;
inline constexpr double kLightSpeed = 299792458.0;

}  // namespace raycube::test
