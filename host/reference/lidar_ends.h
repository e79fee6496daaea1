// The two ends of a path: where rays of a shot start, and what reaches the other end from a point.
#pragma once

#include <optional>

#include "host/reference/lidar_optics.h"
#include "host/reference/lidar_shot.h"

namespace raycube::reference {

/// A point joined to the end that rays do not start from: the pupil (transmitter sampling) or the exit (receiver
/// sampling).
struct LidarConnection {
  glm::dvec3 direction{0};  ///< unit, from the point
  double length_m = 0;
  int pixel = -1;      ///< -1: keep the ray's
  double pupil_m = 0;  ///< distance from the point to the pupil
  bool edge = false;   ///< floats may see the point in another pixel, or on the other side of the beam's rim
  double factor = 0;  ///< A_r cos(psi) eta / R^2 E_rx, or the beam's share of photons per m2 across the way to the exit
};

class LidarEnds {
 public:
  /// Keeps references.
  LidarEnds(const lidar::LidarPlan& plan, const lidar::Shot& shot);

  /// Start of a ray's weight: 1 (transmitter) or A_r cos(psi) Omega E_rx (receiver), times the shot's gain.
  double weight(const LidarRay& ray) const;
  /// Nothing, or a factor of 0 at an edge: the point is seen by no pixel or lies outside the beam.
  std::optional<LidarConnection> connect(const glm::dvec3& point) const;
  /// Place of the end itself.
  const glm::dvec3& far_end() const { return receiver_sampling_ ? exit_ : pupil_; }
  bool receiver_sampling() const { return receiver_sampling_; }

 private:
  std::optional<LidarConnection> to_pupil(const glm::dvec3& point) const;
  std::optional<LidarConnection> to_exit(const glm::dvec3& point) const;

  const lidar::LidarPlan& plan_;
  const lidar::Shot& shot_;
  bool receiver_sampling_;
  glm::dvec3 exit_, exit_axis_, pupil_, pupil_axis_, pupil_u_, pupil_v_;
};

}  // namespace raycube::reference
