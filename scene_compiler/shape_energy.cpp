#include "scene_compiler/shape_energy.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "kernels/shared/product_key.h"
#include "scene_compiler/lobe_albedo.h"
#include "scene_compiler/shape_list.h"
#include "scene_compiler/spectral_shape.h"

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

/// Of the last shapes asked for: members of a family have the same ones, unless they go by the curve.
template <class Value>
class Kept {
 public:
  const Value* find(const Shape& shape) const {
    const auto found = std::find_if(kept_.begin(), kept_.end(), [&](const auto& one) { return one.first == shape; });
    return found == kept_.end() ? nullptr : &found->second;
  }
  Value keep(const Shape& shape, const Value& value) {
    if (kept_.size() >= 8 * RC_MOST_NODES) kept_.erase(kept_.begin());
    kept_.emplace_back(shape, value);
    return value;
  }

 private:
  std::vector<std::pair<Shape, Value>> kept_;
};

}  // namespace

namespace {

/// Zenith angles at which a shape is asked for the most that it sends back, deg: where one was measured, there.
std::vector<double> zeniths_deg(const Shape& shape) {
  std::vector<double> out;
  if (!shape.table)
    for (double zenith_deg = 0; zenith_deg <= kSteepest_deg; zenith_deg += 5) out.push_back(zenith_deg);
  else
    for (std::size_t i = 0; i < static_cast<std::size_t>((*shape.table)[0]); ++i)
      out.push_back(static_cast<double>((*shape.table)[3 + i]) * 180 / std::numbers::pi);
  return out;
}

/// The largest factor of a measured table.
double largest_of(const std::vector<float>& table) {
  const auto first = 3 + static_cast<std::ptrdiff_t>(table[0] + table[1] + table[2]);
  return static_cast<double>(*std::max_element(table.begin() + first, table.end()));
}

}  // namespace

double black_sky_albedo(const Shape& shape, double zenith_rad) { return albedo_of(shape, std::cos(zenith_rad)); }

double white_sky_albedo(const Shape& shape) {
  if (shape.number == RC_SHAPE_lambert) return 1;
  static thread_local Kept<double> kept;
  if (const double* known = kept.find(shape)) return *known;
  if (rc_shape_role(shape.number) == RC_ROLE_gloss) return kept.keep(shape, mean_lobe_albedo(shape));
  double sum = 0;
  for (int i = 0; i < kWhole; ++i) {
    const double in = (i + 0.5) / kWhole;
    sum += 2 * in * albedo_of(shape, in);
  }
  return kept.keep(shape, sum / kWhole);
}

MostAlbedo most_albedo(const Shape& shape) {
  if (shape_entry(shape.number).conserves) return {1, 0};
  static thread_local Kept<MostAlbedo> kept;
  if (const MostAlbedo* known = kept.find(shape)) return *known;
  MostAlbedo most{0, 0};
  for (const double zenith_deg : zeniths_deg(shape))
    if (const double albedo = black_sky_albedo(shape, zenith_deg * std::numbers::pi / 180); albedo > most.albedo)
      most = {albedo, zenith_deg};
  return kept.keep(shape, most);
}

MostAlbedo most_albedo(const Material& material, double wavelength_um) {
  const auto& nodes = material.front_nodes;
  if (nodes.empty()) return most_albedo(material.front);
  static thread_local std::pair<std::vector<ShapeNode>, std::vector<std::vector<double>>> last;  // as above
  if (last.first.empty() || last.first != nodes) {
    last = {nodes, {}};
    for (const ShapeNode& node : nodes) {
      auto& albedos = last.second.emplace_back();
      for (const double zenith_deg : zeniths_deg(node.shape))
        albedos.push_back(black_sky_albedo(node.shape, zenith_deg * std::numbers::pi / 180));
    }
  }
  MostAlbedo most{0, 0};
  const double reflectance = std::max(1e-9, value_at(material.reflectance, wavelength_um));
  const std::vector<ShapeAndCurve> parts = front_parts(material);
  for (std::size_t zenith = 0; zenith < last.second.front().size(); ++zenith) {
    double albedo = 0;
    for (std::size_t node = 0; node < nodes.size(); ++node)
      albedo += value_at(parts[node].curve, wavelength_um) / reflectance * last.second[node][zenith];
    if (albedo > most.albedo) most = {albedo, zeniths_deg(material.front)[zenith]};
  }
  return most;
}

double brightest_direction(const Shape& shape) {
  if (shape.table) return largest_of(*shape.table);
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
