#include "host/reference/lidar_ends.h"

#include <cmath>

#include <glm/geometric.hpp>

namespace raycube::reference {

namespace {

/// Floats place a direction within so many radians: a few ulp of the distance, over the distance.
constexpr double kAngle_rad = 8 * kUlp;

glm::dvec3 vec(const lidar::Vec3& v) { return {v[0], v[1], v[2]}; }

}  // namespace

std::vector<LidarRay> lidar_rays(const lidar::LidarPlan& plan, const lidar::Shot& shot) {
  const lidar::Footprint& f = plan.footprint;
  std::vector<LidarRay> rays;
  const int count = static_cast<int>(f.a.size());
  if (plan.lidar.transport.sampling == scene::LidarSampling::transmitter) {
    const glm::dvec3 axis = vec(shot.exit_axis), u = vec(shot.exit_u), v = glm::cross(axis, u);
    const double spread = std::tan(shot.half_divergence_rad), exit_m = plan.lidar.pulse.exit_radius_m;
    for (int k = 0; k < count; ++k) {
      const auto i = static_cast<std::size_t>(k);
      LidarRay ray{vec(shot.exit_m),
                   glm::normalize(axis + spread * (static_cast<double>(f.a[i]) * u + static_cast<double>(f.b[i]) * v)),
                   0, k};
      if (!f.exit_a.empty())
        ray.origin += exit_m * (static_cast<double>(f.exit_a[i]) * u + static_cast<double>(f.exit_b[i]) * v);
      rays.push_back(ray);
    }
    return rays;
  }
  const scene::LidarReceiver& receiver = plan.lidar.receiver;
  const glm::dvec3 axis = vec(shot.pupil_axis), u = vec(shot.pupil_u), v = glm::cross(axis, u);
  for (int pixel = 0; pixel < plan.pixels(); ++pixel)
    for (int k = 0; k < count; ++k) {
      const auto i = static_cast<std::size_t>(k);
      const double x = (pixel % receiver.columns - 0.5 * (receiver.columns - 1) + static_cast<double>(f.a[i])) *
                       receiver.pixel_pitch_rad;
      const double y = (pixel / receiver.columns - 0.5 * (receiver.rows - 1) + static_cast<double>(f.b[i])) *
                       receiver.pixel_pitch_rad;
      rays.push_back({vec(shot.pupil_m), glm::normalize(axis + x * u + y * v), pixel, k});
    }
  return rays;
}

LidarEnds::LidarEnds(const lidar::LidarPlan& plan, const lidar::Shot& shot)
    : plan_(plan),
      shot_(shot),
      receiver_sampling_(plan.lidar.transport.sampling == scene::LidarSampling::receiver),
      exit_(vec(shot.exit_m)),
      exit_axis_(vec(shot.exit_axis)),
      pupil_(vec(shot.pupil_m)),
      pupil_axis_(vec(shot.pupil_axis)),
      pupil_u_(vec(shot.pupil_u)),
      pupil_v_(glm::cross(pupil_axis_, pupil_u_)) {}

double LidarEnds::weight(const LidarRay& ray) const {
  if (!receiver_sampling_) return shot_.gain;
  const double cos_psi = glm::dot(ray.direction, pupil_axis_), pitch = plan_.lidar.receiver.pixel_pitch_rad;
  return shot_.gain * collecting_area(plan_.lidar.receiver) * cos_psi * pitch * pitch * std::pow(cos_psi, 3) *
         plan_.lidar.receiver.efficiency;
}

std::optional<LidarConnection> LidarEnds::connect(const glm::dvec3& point) const {
  return receiver_sampling_ ? to_exit(point) : to_pupil(point);
}

std::optional<LidarConnection> LidarEnds::to_pupil(const glm::dvec3& point) const {
  const scene::LidarReceiver& receiver = plan_.lidar.receiver;
  const glm::dvec3 way = point - pupil_;
  const double along = glm::dot(way, pupil_axis_), distance = glm::length(way);
  if (!(along > 0)) return {};
  LidarConnection out{-way / distance, distance, 0, distance, false, 0};
  double share = 1;
  if (receiver.columns * receiver.rows > 1) {
    const double x = glm::dot(way, pupil_u_) / along / receiver.pixel_pitch_rad + 0.5 * receiver.columns;
    const double y = glm::dot(way, pupil_v_) / along / receiver.pixel_pitch_rad + 0.5 * receiver.rows;
    const double slack = kAngle_rad / receiver.pixel_pitch_rad + 8 * kUlp * (receiver.columns + receiver.rows);
    out.edge = std::abs(x - std::round(x)) < slack || std::abs(y - std::round(y)) < slack;
    if (!(x >= 0 && x < receiver.columns && y >= 0 && y < receiver.rows))
      return out.edge ? std::optional(out) : std::nullopt;
    out.pixel = static_cast<int>(y) * receiver.columns + static_cast<int>(x);
  } else if (plan_.lidar.transport.overlap == scene::LidarOverlap::exact) {
    share = pupil_share(receiver, along, glm::length(way - along * pupil_axis_));
  }
  if (!(share > 0)) return {};
  out.factor = collecting_area(receiver) * (along / distance) * share / (distance * distance) * receiver.efficiency;
  return out;
}

std::optional<LidarConnection> LidarEnds::to_exit(const glm::dvec3& point) const {
  const glm::dvec3 way = point - exit_;
  const double along = glm::dot(way, exit_axis_), distance = glm::length(way);
  if (!(along > 0)) return {};
  const double off = glm::length(way - along * exit_axis_), spread = along * std::tan(shot_.half_divergence_rad);
  const double exit_m = plan_.lidar.pulse.exit_radius_m;
  double per_m2 = 0;
  bool edge = false;
  if (plan_.lidar.pulse.profile == scene::BeamProfile::gaussian) {
    const double w2 = exit_m * exit_m + spread * spread;
    per_m2 = 2 / (M_PI * w2) * std::exp(-2 * off * off / w2);
  } else {
    edge = std::abs(off - (exit_m + spread)) < kAngle_rad * distance;
    if (off < exit_m + spread) per_m2 = 1 / (M_PI * (exit_m + spread) * (exit_m + spread));
  }
  if (!(per_m2 > 0 || edge)) return {};
  return LidarConnection{-way / distance, distance, -1, glm::length(point - pupil_), edge, per_m2 / (along / distance)};
}

}  // namespace raycube::reference
