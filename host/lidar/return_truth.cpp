#include "host/lidar/return_truth.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "host/lidar/overlap.h"

namespace raycube::lidar {

namespace {

constexpr double kLight_m_s = 299792458.0;

Vec3 operator+(const Vec3& a, const Vec3& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
Vec3 operator-(const Vec3& a, const Vec3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Vec3 operator*(double s, const Vec3& a) { return {s * a[0], s * a[1], s * a[2]}; }
double dot(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
double length(const Vec3& a) { return std::sqrt(dot(a, a)); }
Vec3 unit(const Vec3& a) { return (1 / length(a)) * a; }
Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

double row(const shared::rc_float4& r, const Vec3& p) { return r.x * p[0] + r.y * p[1] + r.z * p[2] + r.w; }
Vec3 place(const shared::Instance& instance, const Vec3& p) {
  return {row(instance.world_from_local_0, p), row(instance.world_from_local_1, p), row(instance.world_from_local_2, p)};
}

/// Depth of a line's air between two heights along a segment, mean extinction of its nodes.
double air_depth(const LidarPlan& plan, int line, const Vec3& a, const Vec3& b) {
  const AirColumn& air = plan.air;
  if (air.posts == 0) return 0;
  double mean = 0;
  for (int n = plan.first_node[static_cast<std::size_t>(line)]; n < plan.first_node[static_cast<std::size_t>(line) + 1]; ++n) {
    const double* depth = air.depth.data() + static_cast<std::size_t>(n) * static_cast<std::size_t>(air.posts);
    const auto at = [&](double z) {
      const double x = (z - air.z0_m) / air.dz_m;
      if (x >= air.posts - 1) return depth[air.posts - 1];
      const auto i = static_cast<std::size_t>(std::max(0.0, std::floor(x)));
      return depth[i] + (x - static_cast<double>(i)) * (depth[i + 1] - depth[i]);
    };
    double low = std::min(a[2], b[2]), high = std::max(a[2], b[2]);
    if (high - low < 1e-3) low -= 0.5, high += 0.5;
    mean += plan.nodes[static_cast<std::size_t>(n)].weight * (at(high) - at(low)) / (high - low) * length(b - a);
  }
  return mean;
}

}  // namespace

SubRay sub_ray(const LidarPlan& plan, const Shot& shot, int pixel, int k) {
  const auto i = static_cast<std::size_t>(k);
  const auto& receiver = plan.lidar.receiver;
  if (plan.lidar.transport.sampling == scene::LidarSampling::receiver) {
    const int column = pixel % receiver.columns, line = pixel / receiver.columns;
    const double pitch = plan.pixels() > 1 ? receiver.pixel_pitch_rad : std::sqrt(M_PI) * receiver.half_fov_rad;
    const double a = (column - 0.5 * (receiver.columns - 1) + plan.footprint.a[i]) * pitch;
    const double b = (line - 0.5 * (receiver.rows - 1) + plan.footprint.b[i]) * pitch;
    return {shot.pupil_m, unit(shot.pupil_axis + a * shot.pupil_u + b * cross(shot.pupil_axis, shot.pupil_u))};
  }
  const Vec3 v = cross(shot.exit_axis, shot.exit_u);
  const double spread = std::tan(shot.half_divergence_rad);
  SubRay ray{shot.exit_m, unit(shot.exit_axis + spread * plan.footprint.a[i] * shot.exit_u + spread * plan.footprint.b[i] * v)};
  if (!plan.footprint.exit_a.empty())
    ray.from_m = ray.from_m + plan.lidar.pulse.exit_radius_m * (plan.footprint.exit_a[i] * shot.exit_u + plan.footprint.exit_b[i] * v);
  return ray;
}

SurfacePoint surface_point(const scene::CompiledScene& scene, const LidarPlan& plan, const Shot& shot, int pixel, int k, const FirstHit& hit) {
  SurfacePoint out;
  if (hit.instance == RC_NONE) return out;
  const shared::TriBlock& block = scene.blocks[hit.primitive / RC_BLOCK];
  const std::size_t lane = hit.primitive % RC_BLOCK;
  const shared::Instance& instance = scene.instances[hit.instance];
  const Vec3 a = place(instance, {block.v0_x[lane], block.v0_y[lane], block.v0_z[lane]});
  const Vec3 b = place(instance, {block.v1_x[lane], block.v1_y[lane], block.v1_z[lane]});
  const Vec3 c = place(instance, {block.v2_x[lane], block.v2_y[lane], block.v2_z[lane]});
  const SubRay ray = sub_ray(plan, shot, pixel, k);
  Vec3 normal = cross(b - a, c - a);
  const double facing = dot(normal, ray.direction);
  if (facing == 0) return out;
  out.at_m = ray.from_m + dot(normal, a - ray.from_m) / facing * ray.direction;
  out.normal = (facing > 0 ? -1 / length(normal) : 1 / length(normal)) * normal;
  out.surface = block.surface[lane];
  out.instance = hit.instance;
  out.hit = true;
  return out;
}

std::vector<ReturnTruth> return_truth(const scene::CompiledScene& scene, const LidarPlan& plan, const ShotResult& result, int pixel,
                                      int line, const std::vector<Echo>& echoes) {
  std::vector<ReturnTruth> out(echoes.size());
  const auto& receiver = plan.lidar.receiver;
  const bool backwards = plan.lidar.transport.sampling == scene::LidarSampling::receiver;
  const int samples = static_cast<int>(plan.footprint.a.size());
  const double window_m = 0.5 * kLight_m_s / plan.lidar.transport.group_index * (plan.lidar.pulse.fwhm_s + plan.lidar.gate.bin_s);
  const double clear = M_PI * (receiver.aperture_radius_m * receiver.aperture_radius_m - receiver.obscuration_radius_m * receiver.obscuration_radius_m);
  const double each = plan.photons[static_cast<std::size_t>(line)] / samples * clear * receiver.efficiency * receiver.quantum_efficiency * result.shot.gain;
  const Stop stop{receiver.aperture_radius_m, receiver.obscuration_radius_m, receiver.half_fov_rad, receiver.focus_m};
  const bool vignetted = plan.lidar.transport.overlap == scene::LidarOverlap::exact && plan.pixels() == 1 && !backwards;
  std::vector<double> weight(echoes.size(), 0), range(echoes.size(), 0);
  std::vector<std::map<std::pair<std::uint32_t, std::uint32_t>, double>> senders(echoes.size());
  for (int k = 0; k < samples; ++k) {
    const auto& hit = result.hits[static_cast<std::size_t>(backwards ? pixel * samples + k : k)];
    const SurfacePoint point = surface_point(scene, plan, result.shot, pixel, k, hit);
    if (!point.hit) continue;
    const SubRay ray = sub_ray(plan, result.shot, pixel, k);
    const Vec3 back = result.shot.pupil_m - point.at_m;
    const double there = length(point.at_m - result.shot.exit_m), home = length(back), half_path = 0.5 * (there + home);
    std::size_t nearest = echoes.size();
    double off = window_m;
    for (std::size_t e = 0; e < echoes.size(); ++e)
      if (std::abs(echoes[e].range_m - half_path) <= off) off = std::abs(echoes[e].range_m - half_path), nearest = e;
    if (nearest == echoes.size()) continue;
    const auto& surface = scene.surfaces[point.surface];
    double reflectance = 0;
    std::uint32_t material = RC_NONE;
    float largest = 0;
    for (int m = 0; m < 4; ++m) {
      if (surface.curve[m] == 0) continue;
      reflectance += surface.fraction[m] * plan.matter[(surface.curve[m] - 1) * static_cast<std::size_t>(plan.lines()) + static_cast<std::size_t>(line)].reflectance;
      if (surface.fraction[m] > largest) largest = surface.fraction[m], material = surface.curve[m] - 1;
    }
    const double off_axis = dot(-1.0 * result.shot.pupil_axis, (1 / home) * back);
    const double along = home * off_axis, aside = std::sqrt(std::max(0.0, home * home - along * along));
    const double eta = vignetted ? vignetting(stop, along, aside) : 1;
    const double transmission = std::exp(-air_depth(plan, line, result.shot.exit_m, point.at_m) - air_depth(plan, line, point.at_m, result.shot.pupil_m));
    const double cosine = std::max(0.0, dot(point.normal, (1 / home) * back));
    const double sent = each * reflectance / M_PI * cosine * off_axis / (home * home) * eta * transmission;
    ReturnTruth& truth = out[nearest];
    truth.order = 1;
    truth.expected_pe += static_cast<float>(sent);
    truth.incidence_deg += static_cast<float>(180 / M_PI * std::acos(std::min(1.0, std::abs(dot(point.normal, ray.direction)))));
    truth.overlap += static_cast<float>(eta);
    truth.transmission_2way += static_cast<float>(transmission);
    truth.subray_share += 1;
    weight[nearest] += sent;
    range[nearest] += sent * half_path;
    senders[nearest][{point.instance, material}] += sent;
  }
  for (std::size_t e = 0; e < echoes.size(); ++e) {
    ReturnTruth& truth = out[e];
    truth.range_m = weight[e] > 0 ? range[e] / weight[e] : std::numeric_limits<double>::quiet_NaN();
    if (truth.order == 0) continue;
    const float count = truth.subray_share;
    truth.incidence_deg /= count, truth.overlap /= count, truth.transmission_2way /= count, truth.subray_share /= static_cast<float>(samples);
    if (backwards) truth.expected_pe = echoes[e].energy_pe;
    const auto most = std::max_element(senders[e].begin(), senders[e].end(), [](const auto& a, const auto& b) { return a.second < b.second; });
    truth.object = scene.instances[most->first.first].id;
    truth.material = most->first.second;
  }
  return out;
}

Vec3 apparent_point(const LidarPlan& plan, const Shot& shot, int pixel, double range_m) {
  const bool backwards = plan.lidar.transport.sampling == scene::LidarSampling::receiver;
  Vec3 from = backwards ? shot.pupil_m : shot.exit_m, direction = shot.exit_axis;
  const Vec3 other = backwards ? shot.exit_m : shot.pupil_m;
  if (plan.pixels() > 1) {
    const auto& receiver = plan.lidar.receiver;
    const double a = (pixel % receiver.columns - 0.5 * (receiver.columns - 1)) * receiver.pixel_pitch_rad;
    const double b = (pixel / receiver.columns - 0.5 * (receiver.rows - 1)) * receiver.pixel_pitch_rad;
    from = shot.pupil_m;
    direction = unit(shot.pupil_axis + a * shot.pupil_u + b * cross(shot.pupil_axis, shot.pupil_u));
  }
  // |t d| + |from + t d - other| = 2 range: squaring once leaves a linear equation in t.
  const Vec3 base = from - (plan.pixels() > 1 ? shot.exit_m : other);
  const double path = 2 * range_m, along = dot(direction, base);
  const double t = (path * path - dot(base, base)) / (2 * (path + along));
  return from + t * direction;
}

}  // namespace raycube::lidar
