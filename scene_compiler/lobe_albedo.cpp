#include "scene_compiler/lobe_albedo.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "kernels/materials/shapes.h"

namespace raycube::scene {

namespace {

constexpr int kDraws = 1597, kStep = 987;  ///< of each law: a Fibonacci lattice (Sloan & Joe 1994)
constexpr RcLocal kUp{0, 0, 1};

RcLocal towards(double cosine, double azimuth_rad) {
  const double sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
  return {sine * std::sin(azimuth_rad), sine * std::cos(azimuth_rad), cosine};
}

/// Whether a shape changes when light and viewer are turned together about the normal.
bool has_grain(const Shape& shape) {
  const auto turned = [&](double by_rad) {
    return rc_shape_eval(shape.number, 1, shape.parameters(),
                         rc_angles(kUp, towards(0.8, by_rad), towards(0.6, by_rad + 2)));
  };
  const double first = turned(0);
  for (int k = 1; k < 8; ++k)
    if (std::abs(turned(k * std::numbers::pi / 8) - first) > 1e-9 * std::abs(first)) return true;
  return false;
}

}  // namespace

double lobe_albedo(const Shape& shape, const RcLocal& direction) {
  if (shape.number == RC_SHAPE_lambert) return 1;
  const RcParameters p = shape.parameters();
  double sum = 0;
  for (int i = 0; i < kDraws; ++i) {
    const double u = (i + 0.5) / kDraws, v = (i * kStep % kDraws + 0.5) / kDraws;
    for (const RcLocal& from : {rc_shape_sample(shape.number, p, direction, u, v), rc_cosine_law(1 - u, v)}) {
      if (!(from.z > 0)) continue;
      const double drawn = rc_shape_pdf(shape.number, p, rc_angles(kUp, direction, from)),
                   by_cosine = from.z * std::numbers::inv_pi;
      sum += rc_shape_eval(shape.number, 1, p, rc_angles(kUp, from, direction)) * from.z / (drawn + by_cosine);
    }
  }
  return sum / kDraws;
}

double mean_lobe_albedo(const Shape& shape) {
  constexpr int kCosines = 24, kAzimuths = 8;
  const int azimuths = has_grain(shape) ? kAzimuths : 1;
  double sum = 0;
  for (int c = 0; c < kCosines; ++c)
    for (int a = 0; a < azimuths; ++a) {
      const double cosine = (c + 0.5) / kCosines;
      sum += 2 * cosine * lobe_albedo(shape, towards(cosine, std::numbers::pi * (a + 0.5) / azimuths));
    }
  return sum / (kCosines * azimuths);
}

LobeAlbedo::LobeAlbedo(const Shape& shape, int zeniths, int azimuths)
    : zeniths_(zeniths), azimuths_(azimuths), value_(static_cast<std::size_t>(zeniths * azimuths)) {
  const int own = has_grain(shape) ? azimuths - 1 : 1;
  for (int a = 0; a < azimuths; ++a)
    for (int c = 0; c < zeniths; ++c) {
      const auto at = static_cast<std::size_t>(a * zeniths + c);
      const double cosine = std::max(1e-3, std::cos(std::numbers::pi / 2 * c / (zeniths - 1)));
      value_[at] = a < own
                       ? static_cast<float>(lobe_albedo(shape, towards(cosine, std::numbers::pi * a / (azimuths - 1))))
                       : value_[static_cast<std::size_t>((own == 1 ? 0 : a - own) * zeniths + c)];
    }
}

double between_albedos(std::span<const float> nodes, int zeniths, int azimuths, const RcLocal& direction) {
  double azimuth = std::atan2(direction.x, direction.y);
  if (azimuth < 0) azimuth += std::numbers::pi;
  const auto place = [](double at, int count, int& low) {
    low = std::clamp(static_cast<int>(at), 0, count - 2);
    return std::clamp(at - low, 0.0, 1.0);
  };
  int a = 0, c = 0;
  const double f = place(azimuth / std::numbers::pi * (azimuths - 1), azimuths, a),
               g = place(std::acos(std::clamp(direction.z, 0.0, 1.0)) * 2 / std::numbers::pi * (zeniths - 1), zeniths,
                         c);
  const auto node = [&](int i, int j) {
    return static_cast<double>(nodes[static_cast<std::size_t>((a + i) * zeniths + c + j)]);
  };
  return (1 - f) * ((1 - g) * node(0, 0) + g * node(0, 1)) + f * ((1 - g) * node(1, 0) + g * node(1, 1));
}

}  // namespace raycube::scene
