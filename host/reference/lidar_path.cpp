#include "host/reference/lidar_path.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "host/reference/lidar_quadrature.h"
#include "host/base/units.h"

namespace raycube::reference {

namespace {

constexpr double kAvogadro = 6.02214076e23;
constexpr double kMoleculesPerPpmM = 2.479371580e15;  ///< cm-2: 296 K, 101325 Pa

}  // namespace

void AirPath::add_depth(const Straight& piece, std::vector<double>& depth) const {
  if (air_.posts < 2 || !(piece.length_m > 0)) return;
  const auto posts = static_cast<std::size_t>(air_.posts);
  const double z_from = piece.origin.z, z_to = piece.at(piece.length_m).z;
  const double low = std::min(z_from, z_to), high = std::max(z_from, z_to);
  const auto layer_of = [&](double z) {
    return static_cast<std::size_t>(
        std::clamp(std::floor((z - air_.z0_m) / air_.dz_m), 0.0, static_cast<double>(air_.posts - 2)));
  };
  const double top = air_.z0_m + (air_.posts - 1) * air_.dz_m;
  const std::size_t first = layer_of(low), last = layer_of(high);
  const auto add = [&](std::size_t layer, double length_m) {
    for (std::size_t node = 0; node < depth.size(); ++node) {
      const double* post = air_.depth.data() + node * posts + layer;
      depth[node] += (post[1] - post[0]) / air_.dz_m * length_m;
    }
  };
  if (first == last && high <= top) return add(first, piece.length_m);
  if (low >= top) return;
  for (std::size_t k = first; k <= last; ++k) {
    const double bottom = air_.z0_m + static_cast<double>(k) * air_.dz_m;
    const double from = k == 0 ? low : std::max(low, bottom), to = std::min(high, bottom + air_.dz_m);
    if (to > from) add(k, (to - from) / (high - low) * piece.length_m);
  }
}

double AirPath::backscatter(int line, double height_m) const {
  if (air_.posts == 0 || air_.backscatter_per_m_sr.empty()) return 0;
  const double* post =
      air_.backscatter_per_m_sr.data() + static_cast<std::size_t>(line) * static_cast<std::size_t>(air_.posts);
  const double x = (height_m - air_.z0_m) / air_.dz_m;
  if (x > air_.posts - 1) return 0;
  if (x <= 0 || air_.posts == 1) return post[0];
  const int k = std::min(static_cast<int>(x), air_.posts - 2);
  return post[k] + (x - k) * (post[k + 1] - post[k]);
}

VolumePath::VolumePath(const scene::Volume& volume) : volume_(volume) {
  const double yaw = base::rad_by_division(volume.yaw_deg);
  y_ = {std::sin(yaw), std::cos(yaw), 0};
  x_ = {std::cos(yaw), -std::sin(yaw), 0};
  if (volume.shape == scene::Volume::Shape::plume) {
    // Beyond 12 widths nothing is left in double.
    const double end = volume.length_m;
    const auto width = [&](double a, double b, double constant) {
      return constant > 0 ? constant : a * end / std::sqrt(1 + b * end);
    };
    const double side = 12 * width(volume.sigma_y_a, volume.sigma_y_b, volume.sigma_y_m);
    const double height = volume.release_height_m + 12 * width(volume.sigma_z_a, volume.sigma_z_b, volume.sigma_z_m);
    lo_ = {-side, 0, 0}, hi_ = {side, end, height};
  } else {
    lo_ = {-0.5 * volume.size_m[0], -0.5 * volume.size_m[1], 0};
    hi_ = {0.5 * volume.size_m[0], 0.5 * volume.size_m[1], volume.size_m[2]};
  }
}

glm::dvec3 VolumePath::local(const glm::dvec3& point) const {
  const glm::dvec3 p = point - glm::dvec3(volume_.position_m[0], volume_.position_m[1], volume_.position_m[2]);
  return {glm::dot(p, x_), glm::dot(p, y_), p.z};
}

std::pair<double, double> VolumePath::clip(const Straight& piece) const {
  const glm::dvec3 from = local(piece.origin),
                   d{glm::dot(piece.direction, x_), glm::dot(piece.direction, y_), piece.direction.z};
  double enter = 0, leave = piece.length_m;
  for (int axis = 0; axis < 3; ++axis) {
    if (d[axis] == 0) {
      if (from[axis] < lo_[axis] || from[axis] > hi_[axis]) return {1, 0};
      continue;
    }
    const double a = (lo_[axis] - from[axis]) / d[axis], b = (hi_[axis] - from[axis]) / d[axis];
    enter = std::max(enter, std::min(a, b)), leave = std::min(leave, std::max(a, b));
  }
  return {enter, leave};
}

/// Trilinear between cell centres; the outer half cells keep the border's values.
double VolumePath::grid_value(const glm::dvec3& p) const {
  int cell[3];
  double part[3];
  for (int axis = 0; axis < 3; ++axis) {
    const int n = volume_.cells[static_cast<std::size_t>(axis)];
    const double x =
        std::clamp((p[axis] - lo_[axis]) / (hi_[axis] - lo_[axis]) * n - 0.5, 0.0, static_cast<double>(n - 1));
    cell[axis] = std::min(static_cast<int>(x), std::max(0, n - 2));
    part[axis] = x - cell[axis];
  }
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    double weight = 1;
    std::size_t index = 0;
    for (int axis = 2; axis >= 0; --axis) {
      const int up = corner >> axis & 1, n = volume_.cells[static_cast<std::size_t>(axis)];
      weight *= up ? part[axis] : 1 - part[axis];
      index = index * static_cast<std::size_t>(n) + static_cast<std::size_t>(std::min(cell[axis] + up, n - 1));
    }
    if (weight > 0) sum += weight * static_cast<double>(volume_.values[index]);
  }
  return sum;
}

double VolumePath::plume_g_m3(const glm::dvec3& p) const {
  const double x = p.y, y = p.x, z = p.z;
  if (x <= 0) return 0;
  const double sy =
      volume_.sigma_y_m > 0 ? volume_.sigma_y_m : volume_.sigma_y_a * x / std::sqrt(1 + volume_.sigma_y_b * x);
  const double sz =
      volume_.sigma_z_m > 0 ? volume_.sigma_z_m : volume_.sigma_z_a * x / std::sqrt(1 + volume_.sigma_z_b * x);
  const auto bell = [](double u) { return std::exp(-0.5 * u * u); };
  const double h = volume_.release_height_m;
  return volume_.source_g_s / (2 * M_PI * volume_.wind_m_s * sy * sz) * bell(y / sy) *
         (bell((z - h) / sz) + bell((z + h) / sz));
}

/// Where the integrand may bend: walls of a grid's cell centres, or closing in on the plume's axis and its foot.
std::vector<double> VolumePath::cuts(const Straight& piece, double from, double to) const {
  std::vector<double> out{from, to};
  const auto add = [&](double s) {
    if (s > from && s < to) out.push_back(s);
  };
  const glm::dvec3 o = local(piece.origin),
                   d{glm::dot(piece.direction, x_), glm::dot(piece.direction, y_), piece.direction.z};
  if (volume_.shape == scene::Volume::Shape::grid) {
    for (int axis = 0; axis < 3; ++axis) {
      const int n = volume_.cells[static_cast<std::size_t>(axis)];
      for (int i = 0; i < n && d[axis] != 0; ++i)
        add((lo_[axis] + (i + 0.5) / n * (hi_[axis] - lo_[axis]) - o[axis]) / d[axis]);
    }
  } else if (volume_.shape == scene::Volume::Shape::plume) {
    for (const double height : {volume_.release_height_m, 0.0}) {
      const double across = d.x * d.x + d.z * d.z;
      const double nearest = across > 0 ? -(o.x * d.x + (o.z - height) * d.z) / across : from;
      add(nearest);
      for (double step = to - from; step > 1e-3; step *= 0.5) add(nearest - step), add(nearest + step);
    }
  }
  std::sort(out.begin(), out.end());
  return out;
}

double VolumePath::integral(const Straight& piece, const std::function<double(const glm::dvec3&)>& value) const {
  const auto [from, to] = clip(piece);
  if (!(to > from)) return 0;
  const auto at = [&](double s) { return value(local(piece.at(s))); };
  return adaptive_integral(at, cuts(piece, from, to), 1e-11);
}

double VolumePath::column_cm2(const Straight& piece) const {
  if (volume_.gas.empty()) return 0;
  if (volume_.shape == scene::Volume::Shape::plume)
    return integral(piece, [&](const glm::dvec3& p) { return plume_g_m3(p); }) / volume_.molar_mass_g * kAvogadro *
           1e-4;
  if (volume_.shape == scene::Volume::Shape::grid)
    return kMoleculesPerPpmM * volume_.concentration_ppm *
           integral(piece, [&](const glm::dvec3& p) { return grid_value(p); });
  const auto [from, to] = clip(piece);
  return to > from ? kMoleculesPerPpmM * volume_.concentration_ppm * (to - from) : 0;
}

double VolumePath::particles_m(const Straight& piece) const {
  if (volume_.extinction_per_m <= 0) return 0;
  if (volume_.shape == scene::Volume::Shape::box) {
    const auto [from, to] = clip(piece);
    return std::max(0.0, to - from);
  }
  return integral(piece, [&](const glm::dvec3& p) {
    return volume_.shape == scene::Volume::Shape::grid ? grid_value(p) : plume_g_m3(p);
  });
}

double VolumePath::particles_at(const glm::dvec3& point) const {
  const glm::dvec3 p = local(point);
  for (int axis = 0; axis < 3; ++axis)
    if (p[axis] < lo_[axis] || p[axis] > hi_[axis]) return 0;
  if (volume_.shape == scene::Volume::Shape::box) return 1;
  return volume_.shape == scene::Volume::Shape::grid ? grid_value(p) : plume_g_m3(p);
}

}  // namespace raycube::reference
