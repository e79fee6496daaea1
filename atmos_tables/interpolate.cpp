#include "atmos_tables/interpolate.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "atmos_tables/detail/row_corners.h"
#include "host/base/error.h"
#include "host/base/units.h"

namespace raycube::atmos {

namespace {

using namespace detail;

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
    cos_here = std::cos(base::rad_by_division(point.back().value));
    // One node: no variation along the axis is stated, not a vertical depth to be stretched.
    if (zenith->nodes.size() == 1) zenith = nullptr, cos_here = 1;
  }
  for (const Corner& corner : corners_of(table, point)) {
    const std::size_t base = row.offset(point, corner);
    const double scale =
        corner.weight * (zenith ? std::cos(base::rad_by_division(zenith->nodes[corner.node.back()])) : 1.0) / cos_here;
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

DepthRow sun_depth_row(const RenderTable& t) {
  return {t, "sun_optical_depth", "sun_transmission", "sunlight on a target"};
}
DepthRow view_depth_row(const RenderTable& t) {
  return {t, "view_optical_depth", "view_transmission", "the path from target to sensor"};
}

/// ln linear over height where both nodes are positive, else linear.
Spectrum log_linear(const RenderTable& table, const Row& row, const std::vector<Coordinate>& point) {
  const std::size_t count = wavelengths(table).size();
  const RowView view(table, row);
  const std::vector<Corner> corners = corners_of(table, point);
  const std::vector<std::size_t> offset = view.offsets(point, corners);
  Spectrum out(count, 0.0);
  for (std::size_t i = 0; i < count; ++i) {
    double sum = 0, log_sum = 0;
    bool positive = true;
    for (std::size_t c = 0; c < corners.size(); ++c) {
      const double value = view.at(offset[c], i);
      sum += corners[c].weight * value;
      positive = positive && value > 0;
      if (positive) log_sum += corners[c].weight * std::log(value);
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

namespace {

/// L / (1 - T) linear between the row's nodes; the point's first two coordinates are height and view zenith.
Spectrum path_light(const RenderTable& table, const Row& row, const std::vector<Coordinate>& point) {
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

}  // namespace

Spectrum path_radiance(const RenderTable& table, double height_m, double zenith_deg, double relative_azimuth_deg) {
  require_zenith(zenith_deg, 90, false, "view");
  return path_light(table, table.need("path_radiance_solar", "light scattered into the path"),
                    {{"target_height", height_m},
                     {"view_zenith", zenith_deg},
                     {"relative_azimuth", fold_azimuth(relative_azimuth_deg)}});
}

Spectrum path_radiance_thermal(const RenderTable& table, double height_m, double zenith_deg) {
  require_zenith(zenith_deg, 90, false, "view");
  return path_light(table, table.need("path_radiance_thermal", "light the path emits"),
                    {{"target_height", height_m}, {"view_zenith", zenith_deg}});
}

Spectrum two_way_factor_thermal(const RenderTable& table, double height_m, double zenith_deg) {
  require_zenith(zenith_deg, 90, false, "view");
  if (!table.has("two_way_factor_thermal")) return Spectrum(wavelengths(table).size(), 1.0);
  return linear(table, table.need("two_way_factor_thermal", "reflected thermal sky"),
                {{"target_height", height_m}, {"view_zenith", zenith_deg}});
}

Spectrum diffuse_irradiance(const RenderTable& table, double height_m) {
  return log_linear(table, table.need("diffuse_irradiance", "skylight on a plane"), {{"target_height", height_m}});
}

Spectrum direct_irradiance(const RenderTable& table, double height_m) {
  if (table.has("direct_irradiance"))
    return log_linear(table, table.need("direct_irradiance", "sunlight on a plane"), {{"target_height", height_m}});
  const double mu0 = std::max(0.0, std::cos(base::rad_by_division(table.sun_zenith_deg)));
  Spectrum out = solar_irradiance(table);
  if (!(table.sun_zenith_deg < 90)) return Spectrum(out.size(), 0.0);
  const Spectrum transmission = sun_transmission(table, height_m);
  for (std::size_t i = 0; i < out.size(); ++i) out[i] *= mu0 * transmission[i];
  return out;
}

bool has_ground_coupling(const RenderTable& table) {
  for (const char* row : {"spherical_albedo", "diffuse_view_transmission", "diffuse_return", "diffuse_irradiance"})
    if (!table.has(row)) return false;
  return true;
}

Spectrum spherical_albedo(const RenderTable& table, double height_m) {
  return linear(table, table.need("spherical_albedo", "light between ground and air"), {{"target_height", height_m}});
}

Spectrum diffuse_view_transmission(const RenderTable& table, double height_m, double zenith_deg) {
  require_zenith(zenith_deg, 90, false, "view");
  return linear(table, table.need("diffuse_view_transmission", "light between ground and air"),
                {{"target_height", height_m}, {"view_zenith", zenith_deg}});
}

Spectrum diffuse_return(const RenderTable& table, double height_m, double zenith_deg) {
  require_zenith(zenith_deg, 90, true, "sky");
  return linear(table, table.need("diffuse_return", "light between ground and air"),
                {{"target_height", height_m}, {"sky_zenith", zenith_deg}});
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
