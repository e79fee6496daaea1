#include "atmos_tables/interpolate.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>

#include "host/base/error.h"

namespace raycube::atmos {

namespace {

using Spectrum = std::vector<double>;

struct Coordinate {
  const char* axis;
  double value;
};

/// A node set around the point: per coordinate the node index, and the product of the linear weights.
struct Corner {
  double weight;
  std::vector<std::size_t> node;  ///< per coordinate
};

struct Bracket {
  std::size_t low = 0, high = 0;
  double weight = 0;  ///< of high
};

std::string shortest(double value) {
  std::string text = std::to_string(value);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text;
}

Bracket bracket(const Axis& axis, double value) {
  const auto& nodes = axis.nodes;
  if (nodes.size() == 1) return {};
  const double slack = 1e-9 * (nodes.back() - nodes.front());
  if (!(value >= nodes.front() - slack && value <= nodes.back() + slack))
    throw base::Error(base::Fault::input, "atmosphere table: " + axis.name + " " + shortest(value) + " " + axis.unit +
                                              " lies outside the table's " + shortest(nodes.front()) + " to " +
                                              shortest(nodes.back()) + " " + axis.unit +
                                              "; build a table that covers it");
  const auto upper = std::upper_bound(nodes.begin(), nodes.end(), value);
  std::size_t high = static_cast<std::size_t>(upper - nodes.begin());
  high = std::clamp<std::size_t>(high, 1, nodes.size() - 1);
  const double w = (value - nodes[high - 1]) / (nodes[high] - nodes[high - 1]);
  return {high - 1, high, std::clamp(w, 0.0, 1.0)};
}

std::vector<Corner> corners_of(const RenderTable& table, const std::vector<Coordinate>& point) {
  std::vector<Corner> corners = {{1.0, {}}};
  for (const Coordinate& coordinate : point) {
    const Bracket b = bracket(table.axis(coordinate.axis), coordinate.value);
    std::vector<Corner> next;
    for (const Corner& corner : corners) {
      if (b.weight < 1) next.push_back({corner.weight * (1 - b.weight), corner.node}), next.back().node.push_back(b.low);
      if (b.weight > 0) next.push_back({corner.weight * b.weight, corner.node}), next.back().node.push_back(b.high);
    }
    corners = std::move(next);
  }
  return corners;
}

/// Where a corner's values lie in a row: value(wavelength, k) = values[base + wavelength * wavelength_stride + k * k_stride].
class RowView {
 public:
  RowView(const RenderTable& table, const Row& row) : table_(table), row_(row) {
    std::size_t stride = 1;
    for (auto name = row.axes.rbegin(); name != row.axes.rend(); ++name) {
      strides_.push_back({*name, stride});
      stride *= table.axis(*name).nodes.size();
    }
  }
  std::size_t stride(const std::string& axis) const {
    for (const auto& [name, stride] : strides_)
      if (name == axis) return stride;
    return 0;
  }
  bool has_k() const { return stride("k") != 0; }
  std::size_t offset(const std::vector<Coordinate>& point, const Corner& corner) const {
    std::size_t at = 0;
    for (std::size_t i = 0; i < point.size(); ++i) at += corner.node[i] * stride(point[i].axis);
    return at;
  }
  double at(std::size_t offset, std::size_t wavelength, std::size_t k = 0) const {
    return row_.values[offset + wavelength * stride("wavelength") + k * stride("k")];
  }

 private:
  const RenderTable& table_;
  const Row& row_;
  std::vector<std::pair<std::string, std::size_t>> strides_;
};

double radians(double degrees) { return degrees * std::numbers::pi / 180; }

/// Optical depth of a path, from the depth row when the table holds it, else from the transmission row. A float
/// transmission that underflowed to 0 counts as the smallest float.
class DepthRow {
 public:
  DepthRow(const RenderTable& table, const std::string& depth_row, const std::string& transmission_row,
           const std::string& needed_by)
      : depth_(table.has(depth_row)),
        row_(depth_ ? table.need(depth_row, needed_by) : table.need(transmission_row, needed_by)),
        view_(table, row_) {}
  bool has_k() const { return view_.has_k(); }
  std::size_t offset(const std::vector<Coordinate>& point, const Corner& corner) const {
    return view_.offset(point, corner);
  }
  double at(std::size_t offset, std::size_t wavelength, std::size_t k) const {
    const double value = view_.at(offset, wavelength, k);
    return depth_ ? value : -std::log(std::max(value, double(std::numeric_limits<float>::denorm_min())));
  }

 private:
  bool depth_;
  const Row& row_;
  RowView view_;
};

std::size_t k_count(const RenderTable& table, bool has_k) { return has_k ? table.axis("k").nodes.size() : 1; }

/// Optical depths [wavelength * k_count + k] at a point; slant: the point's last coordinate is the view zenith.
Spectrum depths(const RenderTable& table, const DepthRow& row, const std::vector<Coordinate>& point, bool slant) {
  const std::size_t count = wavelengths(table).size(), terms = k_count(table, row.has_k());
  Spectrum out(count * terms, 0.0);
  double cos_here = 1;
  const Axis* zenith = nullptr;
  if (slant) {
    zenith = &table.axis("view_zenith");
    cos_here = std::cos(radians(point.back().value));
    // One node: no variation along the axis is stated, not a vertical depth to be stretched.
    if (zenith->nodes.size() == 1) zenith = nullptr, cos_here = 1;
  }
  for (const Corner& corner : corners_of(table, point)) {
    const std::size_t base = row.offset(point, corner);
    const double scale = corner.weight * (zenith ? std::cos(radians(zenith->nodes[corner.node.back()])) : 1.0) / cos_here;
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t k = 0; k < terms; ++k) out[i * terms + k] += scale * row.at(base, i, k);
  }
  return out;
}

Spectrum k_weights(const RenderTable& table, std::size_t count, std::size_t terms) {
  if (terms == 1 && !table.has("k_weight")) return Spectrum(count, 1.0);
  const Row& row = table.need("k_weight", "a row over k-terms");
  return Spectrum(row.values.begin(), row.values.end());
}

Spectrum sum_of_terms(const RenderTable& table, const Spectrum& depth, bool has_k) {
  const std::size_t count = wavelengths(table).size(), terms = k_count(table, has_k);
  Spectrum out(count);
  if (!has_k) {
    for (std::size_t i = 0; i < count; ++i) out[i] = std::exp(-depth[i]);
    return out;
  }
  const Spectrum weight = k_weights(table, count, terms);
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t k = 0; k < terms; ++k) out[i] += weight[i * terms + k] * std::exp(-depth[i * terms + k]);
  return out;
}

DepthRow sun_depth_row(const RenderTable& t) { return {t, "sun_optical_depth", "sun_transmission", "sunlight on a target"}; }
DepthRow view_depth_row(const RenderTable& t) {
  return {t, "view_optical_depth", "view_transmission", "the path from target to sensor"};
}

void require_zenith(double zenith_deg, double limit, bool inclusive, const char* what) {
  if (zenith_deg >= 0 && (zenith_deg < limit || (inclusive && zenith_deg == limit))) return;
  throw base::Error(base::Fault::input, std::string("atmosphere table: ") + what + " zenith " + shortest(zenith_deg) +
                                            " deg is outside 0 to " + shortest(limit) + " deg; " +
                                            "the direction must point above the horizon");
}

/// Plain linear interpolation of a row without k.
Spectrum linear(const RenderTable& table, const Row& row, const std::vector<Coordinate>& point) {
  const std::size_t count = wavelengths(table).size();
  const RowView view(table, row);
  Spectrum out(count, 0.0);
  for (const Corner& corner : corners_of(table, point)) {
    const std::size_t base = view.offset(point, corner);
    for (std::size_t i = 0; i < count; ++i) out[i] += corner.weight * view.at(base, i);
  }
  return out;
}

/// ln linear over height where both nodes are positive, else linear.
Spectrum log_linear(const RenderTable& table, const Row& row, const std::vector<Coordinate>& point) {
  const std::size_t count = wavelengths(table).size();
  const RowView view(table, row);
  const std::vector<Corner> corners = corners_of(table, point);
  Spectrum out(count, 0.0);
  for (std::size_t i = 0; i < count; ++i) {
    double sum = 0, log_sum = 0;
    bool positive = true;
    for (const Corner& corner : corners) {
      const double value = view.at(view.offset(point, corner), i);
      sum += corner.weight * value;
      positive = positive && value > 0;
      if (positive) log_sum += corner.weight * std::log(value);
    }
    out[i] = corners.size() == 1 || !positive ? sum : std::exp(log_sum);
  }
  return out;
}

}  // namespace

const std::vector<double>& wavelengths(const RenderTable& table) { return table.axis("wavelength").nodes; }

double fold_azimuth(double degrees) {
  double folded = std::fmod(std::abs(degrees), 360.0);
  return folded > 180 ? 360 - folded : folded;
}

Spectrum solar_irradiance(const RenderTable& table) {
  const Row& row = table.need("solar_irradiance", "sunlight");
  return Spectrum(row.values.begin(), row.values.end());
}

Spectrum sun_transmission(const RenderTable& table, double height_m) {
  const DepthRow row = sun_depth_row(table);
  return sum_of_terms(table, depths(table, row, {{"target_height", height_m}}, false), row.has_k());
}

Spectrum view_transmission(const RenderTable& table, double height_m, double zenith_deg) {
  require_zenith(zenith_deg, 90, false, "view");
  const DepthRow row = view_depth_row(table);
  return sum_of_terms(table, depths(table, row, {{"target_height", height_m}, {"view_zenith", zenith_deg}}, true),
                      row.has_k());
}

Spectrum two_way_transmission(const RenderTable& table, double height_m, double zenith_deg) {
  require_zenith(zenith_deg, 90, false, "view");
  const DepthRow sun_row = sun_depth_row(table), view_row = view_depth_row(table);
  Spectrum sun = depths(table, sun_row, {{"target_height", height_m}}, false);
  const Spectrum view = depths(table, view_row, {{"target_height", height_m}, {"view_zenith", zenith_deg}}, true);
  if (sun_row.has_k() && view_row.has_k()) {
    for (std::size_t i = 0; i < sun.size(); ++i) sun[i] += view[i];
    return sum_of_terms(table, sun, true);
  }
  const Spectrum factor = linear(table, table.need("two_way_factor", "light from sun to target to sensor"),
                                 {{"target_height", height_m}, {"view_zenith", zenith_deg}});
  Spectrum out = sum_of_terms(table, sun, sun_row.has_k());
  const Spectrum up = sum_of_terms(table, view, view_row.has_k());
  for (std::size_t i = 0; i < out.size(); ++i) out[i] *= up[i] * factor[i];
  return out;
}

Spectrum two_way_factor(const RenderTable& table, double height_m, double zenith_deg) {
  require_zenith(zenith_deg, 90, false, "view");
  if (table.has("two_way_factor") || !sun_depth_row(table).has_k() || !view_depth_row(table).has_k())
    return linear(table, table.need("two_way_factor", "light from sun to target to sensor"),
                  {{"target_height", height_m}, {"view_zenith", zenith_deg}});
  Spectrum out = two_way_transmission(table, height_m, zenith_deg);
  const Spectrum sun = sun_transmission(table, height_m), view = view_transmission(table, height_m, zenith_deg);
  for (std::size_t i = 0; i < out.size(); ++i) {
    const double product = sun[i] * view[i];
    out[i] = product > 0 ? out[i] / product : 1;
  }
  return out;
}

Spectrum path_radiance(const RenderTable& table, double height_m, double zenith_deg, double relative_azimuth_deg) {
  require_zenith(zenith_deg, 90, false, "view");
  const Row& row = table.need("path_radiance_solar", "light scattered into the path");
  const std::vector<Coordinate> point = {{"target_height", height_m},
                                         {"view_zenith", zenith_deg},
                                         {"relative_azimuth", fold_azimuth(relative_azimuth_deg)}};
  const std::vector<Coordinate> path_point(point.begin(), point.begin() + 2);
  const DepthRow depth_row = view_depth_row(table);
  const bool has_k = depth_row.has_k();
  const Spectrum depth_here = depths(table, depth_row, path_point, true);
  const RowView view(table, row);
  const std::vector<Corner> corners = corners_of(table, point);
  const std::size_t count = wavelengths(table).size(), terms = k_count(table, has_k);
  const Spectrum weight = has_k ? k_weights(table, count, terms) : Spectrum{};
  const auto absorbed = [&](auto&& depth, std::size_t i) {  // 1 - T without loss of digits
    if (!has_k) return -std::expm1(-depth(0));
    double sum = 0;
    for (std::size_t k = 0; k < terms; ++k) sum -= weight[i * terms + k] * std::expm1(-depth(k));
    return sum;
  };
  std::vector<std::size_t> value_at, depth_at;
  for (const Corner& corner : corners) {
    value_at.push_back(view.offset(point, corner));
    depth_at.push_back(depth_row.offset(path_point, {1.0, {corner.node[0], corner.node[1]}}));
  }
  Spectrum out(count, 0.0);
  for (std::size_t i = 0; i < count; ++i) {
    double plain = 0, ratio = 0, ratio_weight = 0;
    bool source_without_air = false;
    for (std::size_t c = 0; c < corners.size(); ++c) {
      const double value = view.at(value_at[c], i);
      const double lost = absorbed([&](std::size_t k) { return depth_row.at(depth_at[c], i, k); }, i);
      plain += corners[c].weight * value;
      if (lost > 0) {
        ratio += corners[c].weight * value / lost;
        ratio_weight += corners[c].weight;
      } else if (value > 0) {
        source_without_air = true;
      }
    }
    // A corner at the sensor's own height has neither depth nor radiance: its ratio is that of the others.
    if (source_without_air || ratio_weight <= 0)
      out[i] = plain;
    else
      out[i] = ratio / ratio_weight * absorbed([&](std::size_t k) { return depth_here[i * terms + k]; }, i);
  }
  return out;
}

double sky_shape(double phase, double depth, double cos_sun, double cos_view) {
  const double mu0 = std::max(cos_sun, 1e-3), mu = std::max(cos_view, 1e-9);
  const double a = depth / mu0, b = depth / mu;
  // exp(-min) (1 - exp(-(max - min))) / (max - min) times depth / mu: no difference of like numbers, no overflow.
  const double low = std::min(a, b), gap = std::abs(b - a);
  const double mean = gap < 1e-8 ? 1 - 0.5 * gap : -std::expm1(-gap) / gap;
  return phase * b * std::exp(-low) * mean;
}

Spectrum sky_radiance(const RenderTable& table, double height_m, double zenith_deg, double relative_azimuth_deg) {
  require_zenith(zenith_deg, 90, true, "sky");
  const double azimuth = fold_azimuth(relative_azimuth_deg);
  const Row& row = table.need("sky_radiance_solar", "skylight");
  const std::vector<Coordinate> point = {{"target_height", height_m}, {"sky_zenith", zenith_deg}, {"sky_azimuth", azimuth}};
  if (!table.has("sky_phase_mean") || !table.has("sky_scattering_depth")) return linear(table, row, point);

  const Row& phase_row = table.need("sky_phase_mean", "skylight");
  const Row& depth_row = table.need("sky_scattering_depth", "skylight");
  const RowView view(table, row), phase_view(table, phase_row), depth_view(table, depth_row);
  const double cos_sun = std::cos(radians(table.sun_zenith_deg)), sin_sun = std::sin(radians(table.sun_zenith_deg));
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
  };
  const auto shape_of = [&](double height, double zenith, double relative) {
    const double mu = std::cos(radians(zenith));
    const double cosine = cos_sun * mu + sin_sun * std::sin(radians(zenith)) * std::cos(radians(relative));
    const double angle = std::acos(std::clamp(cosine, -1.0, 1.0)) * 180 / std::numbers::pi;
    Shape s{mu, {{"target_height", height}, {"scattering_angle", angle}}, {}, {{"target_height", height}}, {}};
    s.corners = corners_of(table, s.point);
    s.depth_corners = corners_of(table, s.depth_point);
    return s;
  };
  const auto value_of = [&](const Shape& s, std::size_t i) {
    double phase = 0, depth = 0;
    for (const Corner& c : s.corners) phase += c.weight * phase_view.at(phase_view.offset(s.point, c), i);
    for (const Corner& c : s.depth_corners) depth += c.weight * depth_view.at(depth_view.offset(s.depth_point, c), i);
    return sky_shape(phase, depth, cos_sun, s.cos_view);
  };
  const std::vector<Corner> corners = corners_of(table, point);
  std::vector<Shape> shapes;
  for (const Corner& corner : corners)
    shapes.push_back(shape_of(heights[corner.node[0]], zeniths[corner.node[1]], azimuths[corner.node[2]]));
  const Shape here = shape_of(height_m, zenith_deg, azimuth);
  const std::size_t count = wavelengths(table).size();
  Spectrum out(count, 0.0);
  for (std::size_t i = 0; i < count; ++i) {
    double plain = 0, ratio = 0;
    bool usable = true;
    for (std::size_t c = 0; c < corners.size(); ++c) {
      const double value = view.at(view.offset(point, corners[c]), i), shape = value_of(shapes[c], i);
      plain += corners[c].weight * value;
      if (shape > 0)
        ratio += corners[c].weight * value / shape;
      else
        usable = false;
    }
    out[i] = usable ? ratio * value_of(here, i) : plain;
  }
  return out;
}

Spectrum diffuse_irradiance(const RenderTable& table, double height_m) {
  return log_linear(table, table.need("diffuse_irradiance", "skylight on a plane"), {{"target_height", height_m}});
}

Spectrum direct_irradiance(const RenderTable& table, double height_m) {
  if (table.has("direct_irradiance"))
    return log_linear(table, table.need("direct_irradiance", "sunlight on a plane"), {{"target_height", height_m}});
  const double mu0 = std::max(0.0, std::cos(radians(table.sun_zenith_deg)));
  Spectrum out = solar_irradiance(table);
  if (!(table.sun_zenith_deg < 90)) return Spectrum(out.size(), 0.0);
  const Spectrum transmission = sun_transmission(table, height_m);
  for (std::size_t i = 0; i < out.size(); ++i) out[i] *= mu0 * transmission[i];
  return out;
}

double path_radiance_between(double up_at_sensor, double transmission, double up_at_target) {
  const double difference = up_at_sensor - transmission * up_at_target;
  if (difference >= 0) return difference;
  if (difference >= -1e-5 * up_at_sensor) return 0;
  throw base::Error(base::Fault::input,
                    "atmosphere table: upward radiance at the sensor (" + std::to_string(up_at_sensor) +
                        ") is below transmission times upward radiance at the target (" +
                        std::to_string(transmission * up_at_target) + "); the levels are not from one run");
}

Spectrum resample_linear(const std::vector<double>& from_um, const Spectrum& values, const std::vector<double>& to_um) {
  Axis axis{"wavelength", "um", from_um};
  Spectrum out;
  out.reserve(to_um.size());
  for (const double wavelength : to_um) {
    const Bracket b = bracket(axis, wavelength);
    out.push_back((1 - b.weight) * values[b.low] + b.weight * values[b.high]);
  }
  return out;
}

}  // namespace raycube::atmos
