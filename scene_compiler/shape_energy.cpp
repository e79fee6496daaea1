#include "scene_compiler/shape_energy.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "scene_compiler/shape_list.h"

namespace raycube::scene {

namespace {

constexpr double kSteepest_deg = 80;  ///< beyond it shapes that do not conserve stay as they are there
constexpr int kCosines = 64, kAzimuths = 96, kWhole = 64;
constexpr RcLocal kNormal{0, 0, 1};

RcLocal direction(double cosine, double azimuth_rad) {
  const double sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
  return {sine * std::cos(azimuth_rad), sine * std::sin(azimuth_rad), cosine};
}

double eval(const Shape& shape, double scale, const RcLocal& in, const RcLocal& out) {
  return rc_shape_eval(shape.number, scale, shape.parameters(), rc_angles(kNormal, in, out));
}

double albedo_of(const Shape& shape, double cosine) {
  const RcLocal in = direction(cosine, 0);
  double sum = 0;
  for (int i = 0; i < kCosines; ++i) {
    const double out = (i + 0.5) / kCosines;  // in the cosine: shapes may grow as its inverse, light falls with it
    for (int j = 0; j < kAzimuths; ++j)       // shapes know no left and right
      sum += 2 * out * eval(shape, 1, in, direction(out, std::numbers::pi * (j + 0.5) / kAzimuths));
  }
  return std::numbers::pi * sum / (kCosines * kAzimuths);
}

}  // namespace

double black_sky_albedo(const Shape& shape, double zenith_rad) { return albedo_of(shape, std::cos(zenith_rad)); }

double white_sky_albedo(const Shape& shape) {
  if (shape.number == RC_SHAPE_lambert) return 1;
  static thread_local std::pair<Shape, double> last{{}, 0};  // members of a family have one shape
  if (last.first == shape) return last.second;
  double sum = 0;
  for (int i = 0; i < kWhole; ++i) {
    const double in = (i + 0.5) / kWhole;
    sum += 2 * in * albedo_of(shape, in);
  }
  last = {shape, sum / kWhole};
  return last.second;
}

MostAlbedo most_albedo(const Shape& shape) {
  if (shape_entry(shape.number).conserves) return {1, 0};
  static thread_local std::pair<Shape, MostAlbedo> last{};  // members of a family have one shape
  if (last.first == shape) return last.second;
  MostAlbedo most{0, 0};
  for (double zenith_deg = 0; zenith_deg <= kSteepest_deg; zenith_deg += 5)
    if (const double albedo = black_sky_albedo(shape, zenith_deg * std::numbers::pi / 180); albedo > most.albedo)
      most = {albedo, zenith_deg};
  last = {shape, most};
  return most;
}

double brightest_direction(const Shape& shape) {
  double most = 0;
  for (double in_deg = 0; in_deg <= kSteepest_deg; in_deg += 5)
    for (double out_deg = 0; out_deg <= kSteepest_deg; out_deg += 5)
      for (double turn_deg = 0; turn_deg <= 180; turn_deg += 15) {
        const auto at = [](double zenith_deg, double azimuth_deg) {
          return direction(std::cos(zenith_deg * std::numbers::pi / 180), azimuth_deg * std::numbers::pi / 180);
        };
        most = std::max(most, eval(shape, std::numbers::pi, at(in_deg, 0), at(out_deg, turn_deg)));
      }
  return most;
}

}  // namespace raycube::scene
