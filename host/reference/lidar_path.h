// What lies on a straight piece of a path: extinction depth of air and volumes at every spectral node, in double.
#pragma once

#include <functional>
#include <vector>

#include <glm/vec3.hpp>

#include "host/lidar/lidar_plan.h"

namespace raycube::reference {

/// A straight piece: from `origin` along a unit direction.
struct Straight {
  glm::dvec3 origin{0}, direction{0};
  double length_m = 0;
  glm::dvec3 at(double s) const { return origin + s * direction; }
};

/// Air in flat layers of constant extinction between posts. Sums the layers that the piece crosses.
class AirPath {
 public:
  explicit AirPath(const lidar::AirColumn& air) : air_(air) {}
  /// Adds the depth of a piece to that of every node.
  void add_depth(const Straight& piece, std::vector<double>& depth) const;
  /// Backscatter at a height, 1/(m sr).
  double backscatter(int line, double height_m) const;

 private:
  const lidar::AirColumn& air_;
};

/// Gas and particles of one volume along straight pieces.
class VolumePath {
 public:
  explicit VolumePath(const scene::Volume& volume);
  /// Molecules per cm2 of the gas (1 along a piece).
  double column_cm2(const Straight& piece) const;
  /// Length in metres, weighted by the particles' local share of extinction_per_m.
  double particles_m(const Straight& piece) const;
  /// The part of a piece inside the volume's bounds; empty when first > second.
  std::pair<double, double> clip(const Straight& piece) const;
  /// The local share itself.
  double particles_at(const glm::dvec3& point) const;

 private:
  glm::dvec3 local(const glm::dvec3& point) const;
  double grid_value(const glm::dvec3& local) const;
  double plume_g_m3(const glm::dvec3& local) const;
  double integral(const Straight& piece, const std::function<double(const glm::dvec3&)>& value) const;
  std::vector<double> cuts(const Straight& piece, double from, double to) const;

  const scene::Volume& volume_;
  glm::dvec3 x_{1, 0, 0}, y_{0, 1, 0}, lo_{0}, hi_{0};
};

}  // namespace raycube::reference
