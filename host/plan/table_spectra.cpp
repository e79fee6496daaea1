#include "host/plan/table_spectra.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "atmos_tables/interpolate.h"
#include "host/base/planck.h"
#include "host/base/units.h"
#include "host/plan/sky_basis.h"

namespace raycube::plan {

namespace {

/// A scene may stick out of the table's heights by this much (m) and gets the last node's air: 1e-4 of an air column.
constexpr double kHeightSlack = 1.0;

/// A row seen through the names of its axes.
struct View {
  const float* value = nullptr;
  std::size_t wavelength = 0, height = 0, a = 0, b = 0;  ///< strides; a, b: the remaining axes as asked

  View() = default;
  View(const atmos::RenderTable& table, const atmos::Row& row, const char* axis_a, const char* axis_b)
      : value(row.values.data()) {
    std::size_t stride = 1;
    for (auto name = row.axes.rbegin(); name != row.axes.rend(); ++name) {
      if (*name == "wavelength") wavelength = stride;
      if (*name == "target_height") height = stride;
      if (axis_a && *name == axis_a) a = stride;
      if (axis_b && *name == axis_b) b = stride;
      stride *= table.axis(*name).nodes.size();
    }
  }
};

std::vector<double> radians(const std::vector<double>& degrees) {
  std::vector<double> out;
  for (const double d : degrees) out.push_back(d / base::deg_from_rad(1));
  return out;
}

double cos_scattering(double sun_zenith, double zenith, double azimuth) {
  return std::clamp(
      std::cos(sun_zenith) * std::cos(zenith) + std::sin(sun_zenith) * std::sin(zenith) * std::cos(azimuth), -1.0, 1.0);
}

/// The table's one or two nodes of height around a target, and their weights.
struct HeightNodes {
  std::size_t first = 0, count = 1;
  std::array<double, 2> weight{};

  HeightNodes(const atmos::RenderTable& table, double height_m) {
    const Cell cell = find_cell(table.axis("target_height").nodes, height_m);
    first = cell.index, count = cell.fraction > 0 ? 2 : 1;
    weight = {1 - cell.fraction, cell.fraction};
  }
};

/// Scattered sunlight at one height on a product grid of directions, one wavelength at a time. Between the table's
/// directions radiance is divided by the shape that single scattering gives it, where the table knows that shape.
class SolarSky {
 public:
  /// Keeps references. sky_zenith, sky_azimuth: the table's own nodes, rad.
  SolarSky(const atmos::RenderTable& table, const std::vector<double>& sky_zenith,
           const std::vector<double>& sky_azimuth, const HeightNodes& heights, const std::vector<double>& zenith_rad,
           const std::vector<double>& azimuth_rad)
      : node_zenith_(sky_zenith),
        node_azimuth_(sky_azimuth),
        heights_(heights),
        sky_(table, table.need("sky_radiance_solar", "skylight"), "sky_zenith", "sky_azimuth"),
        sun_zenith_(table.sun_zenith_deg / base::deg_from_rad(1)),
        cos_sun_(std::cos(sun_zenith_)),
        plain_(sky_zenith.size() * sky_azimuth.size()),
        rest_(plain_.size()),
        plain_row_(sky_azimuth.size()),
        rest_row_(sky_azimuth.size()) {
    for (const double t : zenith_rad) grid_cos_.push_back(std::cos(t));
    for (const double t : sky_zenith) node_cos_.push_back(std::cos(t));
    for (const double t : zenith_rad) zenith_cell_.push_back(find_cell(sky_zenith, t));
    for (const double f : azimuth_rad) azimuth_cell_.push_back(find_cell(sky_azimuth, f));
    if (!table.has("sky_phase_mean") || !table.has("sky_scattering_depth")) return;
    depth_ = View(table, table.need("sky_scattering_depth", "skylight"), nullptr, nullptr);
    phase_ = View(table, table.need("sky_phase_mean", "skylight"), "scattering_angle", nullptr);
    const auto& angles = table.axis("scattering_angle").nodes;
    node_angle_ = scattering_angles(angles, sky_zenith, sky_azimuth);
    grid_angle_ = scattering_angles(angles, zenith_rad, azimuth_rad);
    phase_here_.resize(angles.size());
    around_sun_ =
        atmos::nodes_around_sun(table.axis("sky_zenith").nodes, table.axis("sky_azimuth").nodes, table.sun_zenith_deg);
  }

  /// Radiance by the wavelength of this number on the table's axis, in every direction.
  void sample(std::size_t wavelength, std::span<double> out) {
    const Shape shape = shape_at(wavelength);
    const double once = shaped() ? once_scattered(wavelength, shape) : 0;
    divide_nodes(wavelength, shape, once);
    const double depth = heights_.weight[0] * shape.depth[0] + heights_.weight[1] * shape.depth[1];
    if (shaped())
      for (std::size_t k = 0; k < phase_here_.size(); ++k)
        phase_here_[k] = heights_.weight[0] * double{shape.phase[0][k * phase_.a]} +
                         heights_.weight[1] * double{shape.phase[1][k * phase_.a]};
    for (std::size_t z = 0; z < zenith_cell_.size(); ++z) {
      const double fall = shaped() ? atmos::sky_shape(1.0, depth, cos_sun_, grid_cos_[z]) : 0;
      if (shaped()) take_row(rest_, zenith_cell_[z], rest_row_);
      take_row(plain_, zenith_cell_[z], plain_row_);
      for (std::size_t f = 0; f < azimuth_cell_.size(); ++f) {
        const std::size_t n = z * azimuth_cell_.size() + f;
        double value = kNoShape;
        if (shaped()) {
          const Cell& angle = grid_angle_[n];
          const double p = between(phase_here_, angle);
          value = (once * p + between(rest_row_, azimuth_cell_[f])) * fall;
        }
        if (std::isnan(value)) value = between(plain_row_, azimuth_cell_[f]);
        out[n] = std::max(0.0, value);
      }
    }
  }

 private:
  /// Of a node without a shape: its cells stay plain.
  static constexpr double kNoShape = std::numeric_limits<double>::quiet_NaN();

  /// What single scattering makes the sky look like by one wavelength, at both nodes of height.
  struct Shape {
    std::array<double, 2> depth{};
    std::array<const float*, 2> phase{};  ///< over scattering angle
  };

  bool shaped() const { return phase_.value != nullptr; }

  /// Scattering angles of the directions of a product grid on the phase function's axis.
  std::vector<Cell> scattering_angles(const std::vector<double>& angle_deg, const std::vector<double>& zenith,
                                      const std::vector<double>& azimuth) const {
    std::vector<Cell> cells;
    for (const double t : zenith)
      for (const double f : azimuth)
        cells.push_back(find_cell(angle_deg, base::deg_from_rad(std::acos(cos_scattering(sun_zenith_, t, f)))));
    return cells;
  }

  Shape shape_at(std::size_t wavelength) const {
    Shape out;
    if (!shaped()) return out;
    for (std::size_t h = 0; h < 2; ++h) {
      const std::size_t node = heights_.first + (h < heights_.count ? h : 0);
      out.depth[h] = depth_.value[wavelength * depth_.wavelength + node * depth_.height];
      out.phase[h] = phase_.value + wavelength * phase_.wavelength + node * phase_.height;
    }
    return out;
  }

  double phase_at(const float* phase, const Cell& angle) const {
    const std::size_t stride = phase_.a, k = angle.index * stride;
    return angle.fraction > 0 ? (1 - angle.fraction) * phase[k] + angle.fraction * phase[k + stride]
                              : static_cast<double>(phase[k]);
  }

  /// The table's radiance at its own node, h counted from the lower height.
  double sky_at(std::size_t wavelength, std::size_t h, std::size_t z, std::size_t f) const {
    return double(
        sky_.value[wavelength * sky_.wavelength + (heights_.first + h) * sky_.height + z * sky_.a + f * sky_.b]);
  }

  /// How much of the phase function the sky shows around the sun.
  double once_scattered(std::size_t wavelength, const Shape& shape) const {
    double once = 0;
    for (std::size_t h = 0; h < heights_.count; ++h) {
      std::vector<atmos::SkyNode> list;
      for (const auto& [z, f] : around_sun_) {
        const double fall = atmos::sky_shape(1.0, shape.depth[h], cos_sun_, node_cos_[z]);
        if (fall > 0)
          list.push_back({phase_at(shape.phase[h], node_angle_[z * node_azimuth_.size() + f]),
                          sky_at(wavelength, h, z, f) / fall});
      }
      once += heights_.weight[h] * atmos::once_scattered_level(list);
    }
    return once;
  }

  /// Radiance at the table's nodes, as it is and as what single scattering leaves of it.
  void divide_nodes(std::size_t wavelength, const Shape& shape, double once) {
    std::fill(plain_.begin(), plain_.end(), 0.0);
    std::fill(rest_.begin(), rest_.end(), shaped() ? 0.0 : kNoShape);
    for (std::size_t z = 0; z < node_zenith_.size(); ++z)
      for (std::size_t h = 0; h < heights_.count; ++h) {
        const double fall = shaped() ? atmos::sky_shape(1.0, shape.depth[h], cos_sun_, node_cos_[z]) : 0;
        for (std::size_t f = 0; f < node_azimuth_.size(); ++f) {
          const std::size_t n = z * node_azimuth_.size() + f;
          const double value = sky_at(wavelength, h, z, f);
          plain_[n] += heights_.weight[h] * value;
          if (!shaped()) continue;
          rest_[n] = fall > 0 ? rest_[n] + heights_.weight[h] *
                                               (value / fall - once * phase_at(shape.phase[h], node_angle_[n]))
                              : kNoShape;
        }
      }
  }

  /// A line of nodes at this zenith angle. A node without a shape leaves its cells without.
  void take_row(const std::vector<double>& v, const Cell& z, std::vector<double>& row) const {
    const double *at = &v[z.index * node_azimuth_.size()], *next = at + (z.fraction > 0 ? node_azimuth_.size() : 0);
    for (std::size_t f = 0; f < row.size(); ++f) row[f] = (1 - z.fraction) * at[f] + z.fraction * next[f];
  }

  static double between(const std::vector<double>& v, const Cell& at) {
    return (1 - at.fraction) * v[at.index] + at.fraction * v[at.index + (at.fraction > 0 ? 1 : 0)];
  }

  const std::vector<double>&node_zenith_, &node_azimuth_;
  const HeightNodes& heights_;
  View sky_;
  View depth_, phase_;  ///< empty where the table does not know the sky's shape
  double sun_zenith_, cos_sun_;
  std::vector<Cell> zenith_cell_, azimuth_cell_;
  std::vector<Cell> node_angle_, grid_angle_;  ///< of the table's nodes, of the grid's
  std::vector<std::pair<std::size_t, std::size_t>> around_sun_;
  std::vector<double> grid_cos_, node_cos_;  ///< of the zenith angles
  std::vector<double> plain_, rest_;         ///< [zenith][azimuth] of the table, of the wavelength in hand
  std::vector<double> plain_row_, rest_row_, phase_here_;  ///< of the zenith angle, and of the wavelength in hand
};

/// What the air sends back of light that the ground sent up, per unit of that.
class GroundReturn {
 public:
  GroundReturn(const atmos::RenderTable& table, const HeightNodes& heights)
      : heights_(heights),
        back_(table, table.need("diffuse_return", "light between ground and air"), "sky_zenith", nullptr) {}

  double at(std::size_t wavelength, const Cell& zenith) const {
    double t = 0;
    for (std::size_t h = 0; h < heights_.count; ++h) {
      const float* at =
          back_.value + wavelength * back_.wavelength + (heights_.first + h) * back_.height + zenith.index * back_.a;
      const double f = zenith.fraction;
      t += heights_.weight[h] * (f > 0 ? (1 - f) * double{at[0]} + f * double{at[back_.a]} : double{at[0]});
    }
    return t;
  }

 private:
  const HeightNodes& heights_;
  View back_;
};

}  // namespace

TableSpectra::TableSpectra(const atmos::RenderTable& table, bool no_air, bool sun_up, std::size_t first,
                           std::size_t count, Spectrum ground)
    : table_(table),
      no_air_(no_air),
      sun_up_(sun_up),
      first_(first),
      count_(count),
      ground_(std::move(ground)),
      last_view_zenith_(base::kPi / 2) {
  thermal_ = !no_air && (table.has("path_radiance_thermal") || table.has("sky_radiance_thermal"));
  bool heat_alone = thermal_;  // both rows: a render without the sun's
  if (thermal_) {
    table.need("path_radiance_thermal", "thermal light");
    const bool dark_sky =
        !table.has("sky_radiance_thermal") && !base::asks_for_heat(table.axis("wavelength").nodes.back());
    heat_alone = !dark_sky;
    if (!dark_sky) {
      const auto& sky = table.need("sky_radiance_thermal", "thermal light");
      has_thermal_sky_ = std::any_of(sky.values.begin(), sky.values.end(), [](float v) { return v > 0; });
    }
  }
  if (!heat_alone) table.need("solar_irradiance", "every render");
  if (!table.has("solar_irradiance")) sun_up_ = false;
  if (no_air) return;
  if (!heat_alone) {
    table.need("path_radiance_solar", "a render with air");
    table.need("sky_radiance_solar", "a render with air");
  }
  path_scatters_ = table.has("path_radiance_solar");
  if (table.has("sky_radiance_solar")) {
    const auto& sky = table.need("sky_radiance_solar", "a render with air");
    has_sky_ = std::any_of(sky.values.begin(), sky.values.end(), [](float v) { return v > 0; });
  }
  if (couples_ground() && !has_sky_) {
    const auto& back = table.need("diffuse_return", "light between ground and air").values;
    has_sky_ = std::any_of(back.begin(), back.end(), [](float v) { return v > 0; });
  }
  sky_zenith_ = radians(table.axis("sky_zenith").nodes);
  if (table.has("sky_radiance_solar")) sky_azimuth_ = radians(table.axis("sky_azimuth").nodes);
  const auto& view = table.axis("view_zenith").nodes;
  if (view.size() > 1) last_view_zenith_ = view.back() / base::deg_from_rad(1);
}

Spectrum TableSpectra::slice(const Spectrum& whole) const {
  const auto begin = whole.begin() + static_cast<std::ptrdiff_t>(first_);
  return {begin, begin + static_cast<std::ptrdiff_t>(count_)};
}

double TableSpectra::clamp_height(double height_m) const {
  const auto& nodes = table_.axis("target_height").nodes;
  const double clamped = std::clamp(height_m, nodes.front(), nodes.back());
  return std::abs(clamped - height_m) <= kHeightSlack ? clamped : height_m;
}

std::vector<double> TableSpectra::sky_azimuth_rad(Sky sky) const {
  return sky == Sky::solar ? sky_azimuth_ : std::vector<double>{0, base::kPi};
}

Spectrum TableSpectra::solar_irradiance() const {
  if (!sun_up_) return Spectrum(count_, 0.0);
  return slice(atmos::solar_irradiance(table_));
}

Spectrum TableSpectra::sun(double height_m) const {
  Spectrum out = solar_irradiance();
  if (no_air_ || !sun_up_) return out;
  const Spectrum t = slice(atmos::sun_transmission(table_, clamp_height(height_m)));
  for (std::size_t i = 0; i < count_; ++i) out[i] *= t[i];
  return out;
}

Spectrum TableSpectra::view_transmission(double height_m, double zenith_rad) const {
  if (no_air_) return Spectrum(count_, 1.0);
  return slice(atmos::view_transmission(table_, clamp_height(height_m), base::deg_from_rad(zenith_rad)));
}

Spectrum TableSpectra::two_way_transmission(double height_m, double zenith_rad) const {
  if (no_air_) return Spectrum(count_, 1.0);
  return slice(atmos::two_way_transmission(table_, clamp_height(height_m), base::deg_from_rad(zenith_rad)));
}

Spectrum TableSpectra::two_way_factor_thermal(double height_m, double zenith_rad) const {
  return slice(atmos::two_way_factor_thermal(table_, clamp_height(height_m), base::deg_from_rad(zenith_rad)));
}

Spectrum TableSpectra::two_way_factor(double height_m, double zenith_rad) const {
  if (no_air_) return Spectrum(count_, 1.0);
  return slice(atmos::two_way_factor(table_, clamp_height(height_m), base::deg_from_rad(zenith_rad)));
}

Spectrum TableSpectra::path_radiance(double height_m, double zenith_rad, double azimuth_rad) const {
  if (no_air_) return Spectrum(count_, 0.0);
  const double z = clamp_height(height_m), zenith = base::deg_from_rad(zenith_rad);
  Spectrum out(count_, 0.0);
  if (path_scatters_) out = slice(atmos::path_radiance(table_, z, zenith, base::deg_from_rad(azimuth_rad)));
  if (!thermal_) return out;
  const Spectrum emitted = emitted_path(height_m, zenith_rad);
  for (std::size_t i = 0; i < count_; ++i) out[i] += emitted[i];
  return out;
}

Spectrum TableSpectra::emitted_path(double height_m, double zenith_rad) const {
  return slice(atmos::path_radiance_thermal(table_, clamp_height(height_m), base::deg_from_rad(zenith_rad)));
}

Spectrum TableSpectra::diffuse_irradiance(double height_m) const {
  if (no_air_ || !table_.has("diffuse_irradiance")) return {};
  Spectrum out = slice(atmos::diffuse_irradiance(table_, clamp_height(height_m)));
  if (!couples_ground()) return out;
  const Spectrum up = ground_radiance(height_m), back = slice(atmos::spherical_albedo(table_, clamp_height(height_m)));
  for (std::size_t i = 0; i < count_; ++i) out[i] += base::kPi * ground_[i] * up[i] * back[i];
  return out;
}

bool TableSpectra::knows_flux_of_sky() const { return !no_air_ && atmos::has_ground_coupling(table_); }

Spectrum TableSpectra::ground_radiance(double height_m) const {
  const double z = clamp_height(height_m);
  Spectrum out = slice(atmos::diffuse_irradiance(table_, z));
  const Spectrum direct = slice(atmos::direct_irradiance(table_, z)), back = slice(atmos::spherical_albedo(table_, z));
  for (std::size_t i = 0; i < count_; ++i)
    out[i] = (out[i] + (sun_up_ ? direct[i] : 0.0)) / (base::kPi * (1 - ground_[i] * back[i]));
  return out;
}

Spectrum TableSpectra::diffuse_view_transmission(double height_m, double zenith_rad) const {
  const double z = clamp_height(height_m);
  Spectrum out = slice(atmos::diffuse_view_transmission(table_, z, base::deg_from_rad(zenith_rad)));
  const Spectrum factor = slice(atmos::two_way_factor(table_, z, base::deg_from_rad(zenith_rad)));
  for (std::size_t i = 0; i < count_; ++i) out[i] *= factor[i];
  return out;
}

void TableSpectra::sky_grid(double height_m, const std::vector<double>& zenith_rad,
                            const std::vector<double>& azimuth_rad, Sky kind, std::span<double> out) const {
  sky_grid(height_m, zenith_rad, azimuth_rad, kind, 0, count_, out);
}

void TableSpectra::sky_grid(double height_m, const std::vector<double>& zenith_rad,
                            const std::vector<double>& azimuth_rad, Sky kind, std::size_t from, std::size_t count,
                            std::span<double> out) const {
  const std::size_t azimuths = azimuth_rad.size(), directions = zenith_rad.size() * azimuths;
  if (!has_sky(kind)) {
    std::fill(out.begin(), out.end(), 0.0);
    return;
  }
  if (kind == Sky::thermal) {
    for (std::size_t z = 0; z < zenith_rad.size(); ++z) {
      const Spectrum emitted = slice(atmos::sky_radiance_thermal(table_, clamp_height(height_m),
                                                                 std::min(base::deg_from_rad(zenith_rad[z]), 90.0)));
      for (std::size_t i = 0; i < count; ++i)
        std::fill_n(out.begin() + static_cast<std::ptrdiff_t>(i * directions + z * azimuths), azimuths,
                    emitted[from + i]);
    }
    return;
  }
  const HeightNodes heights(table_, clamp_height(height_m));
  SolarSky sky(table_, sky_zenith_, sky_azimuth_, heights, zenith_rad, azimuth_rad);
  for (std::size_t i = 0; i < count; ++i) sky.sample(first_ + from + i, out.subspan(i * directions, directions));
  if (!couples_ground()) return;
  // What the ground sent up and the air sends back: the same at all azimuths.
  const Spectrum up = ground_radiance(height_m);
  const GroundReturn back(table_, heights);
  for (std::size_t z = 0; z < zenith_rad.size(); ++z) {
    const Cell cell = find_cell(sky_zenith_, zenith_rad[z]);
    for (std::size_t i = 0; i < count; ++i) {
      const double t = ground_[from + i] * up[from + i] * back.at(first_ + from + i, cell);
      for (std::size_t a = 0; a < azimuths; ++a) out[i * directions + z * azimuths + a] += t;
    }
  }
}

}  // namespace raycube::plan
