#include "tests/support/lidar_kit.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "host/lidar/footprint.h"
#include "tests/support/seeds.h"

namespace raycube::test {

namespace {

using lidar::Vec3;

Vec3 unit(const Vec3& v) {
  const double length = std::hypot(v[0], v[1], v[2]);
  return {v[0] / length, v[1] / length, v[2] / length};
}
/// Perpendicular to a unit vector: along +x where it can be.
Vec3 across(const Vec3& axis) {
  const Vec3 helper = std::abs(axis[0]) < 0.9 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  const double along = helper[0] * axis[0] + helper[1] * axis[1] + helper[2] * axis[2];
  return unit({helper[0] - along * axis[0], helper[1] - along * axis[1], helper[2] - along * axis[2]});
}

double curve_at(const scene::Curve& curve, double wavelength_um) {
  if (curve.value.empty()) return 0;
  const auto above = std::upper_bound(curve.wavelength_um.begin(), curve.wavelength_um.end(), wavelength_um);
  if (above == curve.wavelength_um.begin()) return curve.value.front();
  if (above == curve.wavelength_um.end()) return curve.value.back();
  const auto i = static_cast<std::size_t>(above - curve.wavelength_um.begin());
  const double f = (wavelength_um - curve.wavelength_um[i - 1]) / (curve.wavelength_um[i] - curve.wavelength_um[i - 1]);
  return curve.value[i - 1] + f * (curve.value[i] - curve.value[i - 1]);
}

/// Share of the pulse before bin coordinate x when its centre is at 0.
double before(const scene::LidarPulse& pulse, double bin_s, double x) {
  if (pulse.shape == scene::PulseShape::rectangular) return std::clamp(x * bin_s / pulse.fwhm_s + 0.5, 0.0, 1.0);
  const double deviation = pulse.fwhm_s / (2 * std::sqrt(2 * std::log(2.0))) / bin_s;
  return 0.5 * std::erfc(-x / (deviation * std::sqrt(2.0)));
}

}  // namespace

scene::Lidar topographic_lidar() {
  scene::Lidar lidar;
  lidar.name = "topographic";
  lidar.trajectory = {{0, 0, 0, 1000}};
  lidar.pulse.lines = {{"laser", 1.064, 0, 100e-6}};
  lidar.pulse.half_divergence_rad = 0.25e-3;
  lidar.pulse.fwhm_s = 4e-9;
  lidar.pulse.transmit_efficiency = 0.9;
  lidar.receiver.aperture_radius_m = 0.05;
  lidar.receiver.obscuration_radius_m = 0.015;
  lidar.receiver.half_fov_rad = 0.5e-3;
  lidar.receiver.efficiency = 0.5;
  lidar.receiver.quantum_efficiency = 0.3;
  lidar.gate = {6200e-9, 1e-9, 1000};
  lidar.transport.subrays = 256;
  lidar.transport.line_nodes = 1;
  lidar.transport.overlap = scene::LidarOverlap::off;
  lidar.transport.air_return = false;
  return lidar;
}

scene::Lidar pencil_lidar() {
  scene::Lidar lidar = topographic_lidar();
  lidar.pulse.half_divergence_rad = 0;
  lidar.transport.subrays = 1;
  return lidar;
}

scene::Lidar flash_lidar() {
  scene::Lidar lidar;
  lidar.name = "flash";
  lidar.trajectory = {{0, 0, 0, 2000}};
  lidar.pulse.lines = {{"laser", 1.064, 0, 150e-6}};
  lidar.pulse.profile = scene::BeamProfile::uniform;
  lidar.pulse.half_divergence_rad = 8e-3;
  lidar.pulse.shape = scene::PulseShape::rectangular;
  lidar.pulse.fwhm_s = 2e-9;
  lidar.receiver.aperture_radius_m = 0.10;
  lidar.receiver.columns = lidar.receiver.rows = 3;
  lidar.receiver.pixel_pitch_rad = 50e-6 / 0.4;
  lidar.receiver.focal_length_m = 0.4;
  lidar.receiver.efficiency = 0.5;
  lidar.gate = {13300e-9, 1e-9, 100};
  lidar.transport.sampling = scene::LidarSampling::receiver;
  lidar.transport.subrays = 16;
  lidar.transport.air_return = false;
  return lidar;
}

lidar::PulseTaps make_taps(const scene::LidarPulse& pulse, double bin_s, int phases) {
  lidar::PulseTaps taps;
  if (pulse.fwhm_s == 0) return {1, 1, 0, {1.0f, 1.0f}};
  const double reach = pulse.shape == scene::PulseShape::rectangular
                           ? 0.5 * pulse.fwhm_s / bin_s
                           : 6.5 * pulse.fwhm_s / (2 * std::sqrt(2 * std::log(2.0))) / bin_s;
  taps.phases = phases;
  taps.first = -static_cast<int>(std::ceil(reach));
  taps.taps = static_cast<int>(std::ceil(reach)) * 2 + 1;
  for (int q = 0; q <= phases; ++q) {
    const double f = static_cast<double>(q) / phases;
    std::vector<double> share;
    double sum = 0;
    for (int i = 0; i < taps.taps; ++i) {
      const double lo = taps.first + i - f, hi = lo + 1;
      // On the late side by the symmetric difference: no cancellation of numbers near 1.
      share.push_back(lo > 0 ? before(pulse, bin_s, -lo) - before(pulse, bin_s, -hi)
                             : before(pulse, bin_s, hi) - before(pulse, bin_s, lo));
      sum += share.back();
    }
    for (const double s : share) taps.share.push_back(static_cast<float>(s / sum));
  }
  return taps;
}

lidar::LidarPlan hand_plan(const scene::Lidar& lidar, const scene::CompiledScene& scene, std::uint64_t seed) {
  lidar::LidarPlan plan;
  plan.lidar = lidar;
  plan.seed = testing::seed(seed);
  for (const auto& line : lidar.pulse.lines) {
    plan.first_node.push_back(static_cast<int>(plan.nodes.size()));
    plan.nodes.push_back({static_cast<int>(plan.photons.size()), line.wavelength_um, 1});
    plan.photons.push_back(line.energy_J * line.wavelength_um * 1e-6 / kPlanckLight * lidar.pulse.transmit_efficiency);
  }
  plan.first_node.push_back(static_cast<int>(plan.nodes.size()));
  for (const auto& material : scene.materials)
    for (const auto& line : lidar.pulse.lines)
      plan.matter.push_back(
          {curve_at(material.reflectance, line.wavelength_um), curve_at(material.transmittance, line.wavelength_um)});
  plan.cross_section_cm2.assign(scene.volumes.size() * plan.nodes.size(), 0.0);
  plan.taps = make_taps(lidar.pulse, lidar.gate.bin_s);
  plan.footprint = lidar::make_footprint(lidar, lidar::exit_matters(lidar));
  plan.sensor_low_m = plan.sensor_high_m = lidar.trajectory.empty() ? 0 : lidar.trajectory.front().z_m;
  for (const auto& pose : lidar.trajectory) {
    plan.sensor_low_m = std::min(plan.sensor_low_m, pose.z_m);
    plan.sensor_high_m = std::max(plan.sensor_high_m, pose.z_m);
  }
  return plan;
}

void set_air(lidar::LidarPlan& plan, double extinction_per_m, double backscatter_per_m_sr, double low_m,
             double high_m) {
  constexpr int kPosts = 33;
  plan.air = {low_m, (high_m - low_m) / (kPosts - 1), kPosts, {}, {}};
  for (std::size_t node = 0; node < plan.nodes.size(); ++node)
    for (int i = 0; i < kPosts; ++i) plan.air.depth.push_back(extinction_per_m * i * plan.air.dz_m);
  plan.air.backscatter_per_m_sr.assign(plan.photons.size() * kPosts, backscatter_per_m_sr);
}

lidar::Shot shot_from(const scene::Lidar& lidar, const Vec3& at_m, const Vec3& towards, std::int64_t pulse) {
  lidar::Shot shot;
  shot.pulse = pulse;
  shot.exit_m = at_m;
  shot.exit_axis = unit(towards);
  shot.exit_u = across(shot.exit_axis);
  shot.half_divergence_rad = lidar.pulse.half_divergence_rad;
  place_pupil(shot, at_m, towards);
  return shot;
}

void place_pupil(lidar::Shot& shot, const Vec3& at_m, const Vec3& towards) {
  shot.pupil_m = at_m;
  shot.pupil_axis = unit(towards);
  shot.pupil_u = across(shot.pupil_axis);
}

scene::CompiledScene scene_of(const std::vector<double>& reflectances) {
  scene::CompiledScene scene;
  for (std::size_t i = 0; i < reflectances.size(); ++i) {
    scene::Material material;
    material.name = "material " + std::to_string(i);
    material.source = "constant";
    material.reflectance = {{0.3, 4.0}, {reflectances[i], reflectances[i]}};
    scene.materials.push_back(material);
    shared::Surface surface{};
    surface.material[0] = static_cast<std::uint32_t>(i + 1);
    surface.fraction[0] = 1.0f;
    scene.surfaces.push_back(surface);
  }
  return scene;
}

void add_rectangle(scene::CompiledScene& scene, std::uint32_t surface, const Vec3& corner, const Vec3& a,
                   const Vec3& b) {
  scene::TriangleMesh mesh;
  for (const auto& [s, t] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}})
    mesh.vertices.push_back({static_cast<float>(corner[0] + s * a[0] + t * b[0]),
                             static_cast<float>(corner[1] + s * a[1] + t * b[1]),
                             static_cast<float>(corner[2] + s * a[2] + t * b[2])});
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.surface = {surface, surface};
  mesh.user_face = {0, 1};
  const std::uint32_t index = scene::append_mesh(scene, "rectangle " + std::to_string(scene.meshes.size()), mesh);
  scene::append_instance(scene, index, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}, index);
}

void add_plane(scene::CompiledScene& scene, std::uint32_t surface, const Vec3& centre, double half, double tilt) {
  const Vec3 a{2 * half * std::cos(tilt), 0, -2 * half * std::sin(tilt)}, b{0, 2 * half, 0};
  add_rectangle(scene, surface,
                {centre[0] - (a[0] + b[0]) / 2, centre[1] - (a[1] + b[1]) / 2, centre[2] - (a[2] + b[2]) / 2}, a, b);
}

void add_corner(scene::CompiledScene& scene, std::uint32_t surface_a, std::uint32_t surface_b, double length,
                double height, double half_width) {
  add_rectangle(scene, surface_a, {0, -half_width, 0}, {length, 0, 0}, {0, 2 * half_width, 0});
  add_rectangle(scene, surface_b, {0, -half_width, 0}, {0, 2 * half_width, 0}, {0, 0, height});
}

double total(const std::vector<float>& row) {
  double sum = 0;
  for (const float x : row) sum += x;
  return sum;
}

Moments moments(const std::vector<float>& row) {
  Moments out;
  for (std::size_t i = 0; i < row.size(); ++i) {
    out.sum += row[i];
    out.mean_bin += row[i] * (static_cast<double>(i) + 0.5);
  }
  out.mean_bin /= out.sum;
  double square = 0;
  for (std::size_t i = 0; i < row.size(); ++i) {
    const double off = static_cast<double>(i) + 0.5 - out.mean_bin;
    square += row[i] * off * off;
  }
  out.deviation_bins = std::sqrt(square / out.sum);
  return out;
}

}  // namespace raycube::test
