#include <algorithm>
#include <cmath>

#include "atmos_tables/detail/row_corners.h"
#include "atmos_tables/interpolate.h"
#include "host/base/units.h"

namespace raycube::atmos {

namespace {
using namespace detail;
/// The shape's sun stands no lower than 2.9 degrees (airmass 20, as the round air has it at 88 degrees of zenith), and
/// the air is no deeper than this along its path. Beyond, light scattered once is a vanishing part of the sky: exp(-tau
/// / mu0) would span decades between two nodes of a sky that is nearly even, and 1e11 came out between them at 89.5
/// degrees. What it takes, rms between nodes with depths up to 2, 3 and without a limit: 23 km, sun at 80 degrees, 0.42
/// um 0.50, 0.43, 1.0 %; 5 km, 85 degrees 0.6, 0.6, 132 %; a cloud of depth 10, 75 degrees 0.4, 0.7, 7000 %. Skies
/// within the limits keep their bits.
constexpr double kLowestSun = 0.05, kDeepestSun = 3;
}  // namespace

double sky_shape(double phase, double depth, double cos_sun, double cos_view) {
  const double mu0 = std::max(cos_sun, kLowestSun), mu = std::max(cos_view, 1e-9);
  depth = std::min(depth, kDeepestSun * mu0);
  const double a = depth / mu0, b = depth / mu;
  // exp(-min) (1 - exp(-(max - min))) / (max - min) times depth / mu: no difference of like numbers, no overflow.
  const double low = std::min(a, b), gap = std::abs(b - a);
  const double mean = gap < 1e-8 ? 1 - 0.5 * gap : -std::expm1(-gap) / gap;
  return phase * b * std::exp(-low) * mean;
}

double airmass(double zenith_deg) {
  return 1 / (std::max(0.0, std::cos(base::rad_by_division(zenith_deg))) +
              0.50572 * std::pow(96.07995 - zenith_deg, -1.6364));
}

Spectrum sky_radiance_thermal(const RenderTable& table, double height_m, double zenith_deg) {
  require_zenith(zenith_deg, 90, true, "sky");
  const Row& row = table.need("sky_radiance_thermal", "light the sky emits");
  const std::vector<Coordinate> point = {{"target_height", height_m}, {"sky_zenith", zenith_deg}};
  std::vector<Corner> corners = corners_of(table, point);
  const auto& zeniths = table.axis("sky_zenith").nodes;
  const Bracket b = bracket(table.axis("sky_zenith"), zenith_deg);
  if (b.weight > 0 && b.weight < 1) {  // the same nodes, weighed by airmass
    const double low = airmass(zeniths[b.low]), high = airmass(zeniths[b.high]),
                 w = (airmass(zenith_deg) - low) / (high - low);
    for (Corner& corner : corners) corner.weight *= corner.node[1] == b.low ? (1 - w) / (1 - b.weight) : w / b.weight;
  }
  const RowView view(table, row);
  Spectrum out(wavelengths(table).size(), 0.0);
  for (const Corner& corner : corners) {
    const std::size_t base = view.offset(point, corner);
    for (std::size_t i = 0; i < out.size(); ++i) out[i] += corner.weight * view.at(base, i);
  }
  return out;
}

std::vector<std::pair<std::size_t, std::size_t>> nodes_around_sun(const std::vector<double>& sky_zenith_deg,
                                                                  const std::vector<double>& sky_azimuth_deg,
                                                                  double sun_zenith_deg) {
  // A sun at the horizon is sought where its shape stands, and told by azimuth alone: between zeniths the light there
  // changes with the air's depth rather than with the angle to the sun.
  const bool low = std::cos(base::rad_by_division(sun_zenith_deg)) < kLowestSun && sky_azimuth_deg.size() > 1;
  const double from_deg = low ? base::deg_by_division(std::acos(kLowestSun)) : sun_zenith_deg;
  const auto nearest = std::min_element(sky_zenith_deg.begin(), sky_zenith_deg.end(), [&](double p, double q) {
    return std::abs(p - from_deg) < std::abs(q - from_deg);
  });
  const auto z = static_cast<std::size_t>(nearest - sky_zenith_deg.begin());
  if (low) return {{z, 0}, {z, 1}};
  std::vector<std::pair<std::size_t, std::size_t>> nodes = {{z, 0}};
  if (z + 1 < sky_zenith_deg.size()) nodes.emplace_back(z + 1, 0);
  if (z > 0) nodes.emplace_back(z - 1, 0);
  if (sky_azimuth_deg.size() > 1) nodes.emplace_back(z, 1);
  return nodes;
}

double once_scattered_level(const std::vector<SkyNode>& nodes) {
  if (nodes.size() < 2) return 0;
  double phase = 0, level = 0;
  for (std::size_t i = 1; i < nodes.size(); ++i) phase += nodes[i].phase, level += nodes[i].level;
  phase /= static_cast<double>(nodes.size() - 1), level /= static_cast<double>(nodes.size() - 1);
  if (!(nodes[0].phase > 1.05 * phase)) return 0;
  return std::max(0.0, (nodes[0].level - level) / (nodes[0].phase - phase));
}

Spectrum sky_radiance(const RenderTable& table, double height_m, double zenith_deg, double relative_azimuth_deg) {
  require_zenith(zenith_deg, 90, true, "sky");
  const double azimuth = fold_azimuth(relative_azimuth_deg);
  const Row& row = table.need("sky_radiance_solar", "skylight");
  const std::vector<Coordinate> point = {
      {"target_height", height_m}, {"sky_zenith", zenith_deg}, {"sky_azimuth", azimuth}};
  if (!table.has("sky_phase_mean") || !table.has("sky_scattering_depth")) return linear(table, row, point);

  const Row& phase_row = table.need("sky_phase_mean", "skylight");
  const Row& depth_row = table.need("sky_scattering_depth", "skylight");
  const RowView view(table, row), phase_view(table, phase_row), depth_view(table, depth_row);
  const double cos_sun = std::cos(base::rad_by_division(table.sun_zenith_deg)),
               sin_sun = std::sin(base::rad_by_division(table.sun_zenith_deg));
  const auto& heights = table.axis("target_height").nodes;
  const auto& zeniths = table.axis("sky_zenith").nodes;
  const auto& azimuths = table.axis("sky_azimuth").nodes;

  /// Phase function nodes and depth offset at one direction and height.
  struct Shape {
    double cos_view;
    std::vector<Coordinate> point;
    std::vector<Corner> corners;
    std::vector<Coordinate> depth_point;
    std::vector<Corner> depth_corners;
    std::vector<std::size_t> offset, depth_offset;  ///< of the corners' values
  };
  const auto shape_of = [&](double height, double zenith, double relative) {
    const double mu = std::cos(base::rad_by_division(zenith));
    const double cosine =
        cos_sun * mu + sin_sun * std::sin(base::rad_by_division(zenith)) * std::cos(base::rad_by_division(relative));
    const double angle = base::deg_by_division(std::acos(std::clamp(cosine, -1.0, 1.0)));
    Shape s{mu, {{"target_height", height}, {"scattering_angle", angle}}, {}, {{"target_height", height}}, {}, {}, {}};
    s.corners = corners_of(table, s.point);
    s.depth_corners = corners_of(table, s.depth_point);
    s.offset = phase_view.offsets(s.point, s.corners);
    s.depth_offset = depth_view.offsets(s.depth_point, s.depth_corners);
    return s;
  };
  // What divides the sky between nodes, for the column's phase function and for an even one.
  struct Value {
    double scattered, even;
  };
  const auto value_of = [&](const Shape& s, std::size_t i) {
    double phase = 0, depth = 0;
    for (std::size_t c = 0; c < s.corners.size(); ++c) phase += s.corners[c].weight * phase_view.at(s.offset[c], i);
    for (std::size_t c = 0; c < s.depth_corners.size(); ++c)
      depth += s.depth_corners[c].weight * depth_view.at(s.depth_offset[c], i);
    const double even = sky_shape(1, depth, cos_sun, s.cos_view);
    return Value{phase * even, even};
  };
  const std::vector<Corner> corners = corners_of(table, point);
  std::vector<Shape> shapes;
  for (const Corner& corner : corners)
    shapes.push_back(shape_of(heights[corner.node[0]], zeniths[corner.node[1]], azimuths[corner.node[2]]));
  const std::vector<std::size_t> offset = view.offsets(point, corners);
  // How the sky grows with the phase function around the sun says how much of it is light scattered once.
  struct SunNodes {
    double weight;
    std::vector<std::size_t> offset;
    std::vector<Shape> shape;
  };
  std::vector<SunNodes> sun_nodes;
  for (const Corner& corner : corners_of(table, {{"target_height", height_m}})) {
    SunNodes list{corner.weight, {}, {}};
    for (const auto& [z, a] : nodes_around_sun(zeniths, azimuths, table.sun_zenith_deg)) {
      list.offset.push_back(view.offset(point, {1.0, {corner.node[0], z, a}}));
      list.shape.push_back(shape_of(heights[corner.node[0]], zeniths[z], azimuths[a]));
    }
    sun_nodes.push_back(std::move(list));
  }
  const Shape here = shape_of(height_m, zenith_deg, azimuth);
  const std::size_t count = wavelengths(table).size();
  Spectrum out(count, 0.0);
  std::vector<SkyNode> nodes;
  for (std::size_t i = 0; i < count; ++i) {
    double once = 0;
    for (const SunNodes& list : sun_nodes) {
      nodes.clear();
      for (std::size_t n = 0; n < list.shape.size(); ++n) {
        const Value value = value_of(list.shape[n], i);
        if (value.even > 0) nodes.push_back({value.scattered / value.even, view.at(list.offset[n], i) / value.even});
      }
      once += list.weight * once_scattered_level(nodes);
    }
    double plain = 0, rest = 0;
    bool usable = true;
    for (std::size_t c = 0; c < corners.size(); ++c) {
      const double value = view.at(offset[c], i);
      plain += corners[c].weight * value;
      const Value node = value_of(shapes[c], i);
      if (node.even > 0)
        rest += corners[c].weight * (value - once * node.scattered) / node.even;
      else
        usable = false;
    }
    const Value value = value_of(here, i);
    out[i] = usable ? std::max(0.0, once * value.scattered + rest * value.even) : plain;
  }
  return out;
}

}  // namespace raycube::atmos
