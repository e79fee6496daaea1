#include "host/plan/table_spectra.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "atmos_tables/interpolate.h"
#include "host/base/planck.h"
#include "host/base/units.h"
#include "host/plan/sky_basis.h"

namespace raycube::plan {

namespace {

constexpr double kPi = std::numbers::pi;
/// A scene may stick out of the table's heights by this much (m) and gets the last node's air: 1e-4 of an air column.
constexpr double kHeightSlack = 1.0;

/// A row seen through the names of its axes.
struct View {
  const float* value = nullptr;
  std::size_t wavelength = 0, height = 0, a = 0, b = 0;  ///< strides; a, b: the remaining axes as asked

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

}  // namespace

TableSpectra::TableSpectra(const atmos::RenderTable& table, bool no_air, bool sun_up, std::size_t first,
                           std::size_t count, Spectrum ground)
    : table_(table),
      no_air_(no_air),
      sun_up_(sun_up),
      first_(first),
      count_(count),
      ground_(std::move(ground)),
      last_view_zenith_(kPi / 2) {
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
  return sky == Sky::solar ? sky_azimuth_ : std::vector<double>{0, kPi};
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
  for (std::size_t i = 0; i < count_; ++i) out[i] += kPi * ground_[i] * up[i] * back[i];
  return out;
}

bool TableSpectra::knows_flux_of_sky() const { return !no_air_ && atmos::has_ground_coupling(table_); }

Spectrum TableSpectra::ground_radiance(double height_m) const {
  const double z = clamp_height(height_m);
  Spectrum out = slice(atmos::diffuse_irradiance(table_, z));
  const Spectrum direct = slice(atmos::direct_irradiance(table_, z)), back = slice(atmos::spherical_albedo(table_, z));
  for (std::size_t i = 0; i < count_; ++i)
    out[i] = (out[i] + (sun_up_ ? direct[i] : 0.0)) / (kPi * (1 - ground_[i] * back[i]));
  return out;
}

Spectrum TableSpectra::diffuse_view_transmission(double height_m, double zenith_rad) const {
  const double z = clamp_height(height_m);
  Spectrum out = slice(atmos::diffuse_view_transmission(table_, z, base::deg_from_rad(zenith_rad)));
  const Spectrum factor = slice(atmos::two_way_factor(table_, z, base::deg_from_rad(zenith_rad)));
  for (std::size_t i = 0; i < count_; ++i) out[i] *= factor[i];
  return out;
}

std::vector<double> TableSpectra::sky_grid(double height_m, const std::vector<double>& zenith_rad,
                                           const std::vector<double>& azimuth_rad, Sky kind) const {
  std::vector<double> out(zenith_rad.size() * azimuth_rad.size() * count_, 0.0);
  if (!has_sky(kind)) return out;
  if (kind == Sky::thermal) {
    for (std::size_t z = 0; z < zenith_rad.size(); ++z) {
      const Spectrum emitted = slice(atmos::sky_radiance_thermal(table_, clamp_height(height_m),
                                                                 std::min(base::deg_from_rad(zenith_rad[z]), 90.0)));
      for (std::size_t f = 0; f < azimuth_rad.size(); ++f)
        std::copy(emitted.begin(), emitted.end(),
                  out.begin() + static_cast<std::ptrdiff_t>((z * azimuth_rad.size() + f) * count_));
    }
    return out;
  }
  const View sky(table_, table_.need("sky_radiance_solar", "skylight"), "sky_zenith", "sky_azimuth");
  const bool shaped = table_.has("sky_phase_mean") && table_.has("sky_scattering_depth");
  const Cell height = find_cell(table_.axis("target_height").nodes, clamp_height(height_m));
  const std::array<double, 2> height_weight = {1 - height.fraction, height.fraction};
  const int heights = height.fraction > 0 ? 2 : 1;

  // scattering angle of a node on the phase function's axis
  const double sun_zenith = table_.sun_zenith_deg / base::deg_from_rad(1), cos_sun = std::cos(sun_zenith);
  const auto locate = [&](const std::vector<double>& zenith, const std::vector<double>& azimuth) {
    std::vector<Cell> cells;
    if (!shaped) return cells;
    const auto& angles = table_.axis("scattering_angle").nodes;
    for (const double t : zenith)
      for (const double f : azimuth)
        cells.push_back(find_cell(angles, base::deg_from_rad(std::acos(cos_scattering(sun_zenith, t, f)))));
    return cells;
  };
  const auto node_angle = locate(sky_zenith_, sky_azimuth_), grid_angle = locate(zenith_rad, azimuth_rad);
  std::vector<Cell> zenith_cell, azimuth_cell;
  for (const double t : zenith_rad) zenith_cell.push_back(find_cell(sky_zenith_, t));
  for (const double f : azimuth_rad) azimuth_cell.push_back(find_cell(sky_azimuth_, f));

  const std::size_t nodes = sky_zenith_.size() * sky_azimuth_.size();
  std::vector<double> plain(nodes), rest(nodes), grid_fall(zenith_rad.size());
  const auto around_sun = shaped ? atmos::nodes_around_sun(table_.axis("sky_zenith").nodes,
                                                           table_.axis("sky_azimuth").nodes, table_.sun_zenith_deg)
                                 : std::vector<std::pair<std::size_t, std::size_t>>();
  const auto bilinear = [&](const std::vector<double>& v, const Cell& z, const Cell& f) {
    const double* at = &v[z.index * sky_azimuth_.size() + f.index];
    const std::size_t row = z.fraction > 0 ? sky_azimuth_.size() : 0, next = f.fraction > 0 ? 1 : 0;
    return (1 - z.fraction) * ((1 - f.fraction) * at[0] + f.fraction * at[next]) +
           z.fraction * ((1 - f.fraction) * at[row] + f.fraction * at[row + next]);
  };
  constexpr double none = std::numeric_limits<double>::quiet_NaN();  // a node without shape: its cells stay plain
  for (std::size_t i = 0; i < count_; ++i) {
    const std::size_t wavelength = first_ + i;
    std::fill(plain.begin(), plain.end(), 0.0);
    std::fill(rest.begin(), rest.end(), shaped ? 0.0 : none);
    std::array<double, 2> depth{};
    std::array<const float*, 2> phase{};
    std::size_t phase_stride = 0;
    if (shaped) {
      const View depth_view(table_, table_.need("sky_scattering_depth", "skylight"), nullptr, nullptr);
      const View phase_view(table_, table_.need("sky_phase_mean", "skylight"), "scattering_angle", nullptr);
      phase_stride = phase_view.a;
      for (std::size_t h = 0; h < 2; ++h) {
        const std::size_t node = height.index + (static_cast<int>(h) < heights ? h : 0);
        depth[h] = depth_view.value[wavelength * depth_view.wavelength + node * depth_view.height];
        phase[h] = phase_view.value + wavelength * phase_view.wavelength + node * phase_view.height;
      }
    }
    const auto phase_at = [&](const float* p, const Cell& c) {
      const std::size_t k = c.index * phase_stride;
      return c.fraction > 0 ? (1 - c.fraction) * p[k] + c.fraction * p[k + phase_stride] : static_cast<double>(p[k]);
    };
    const auto sky_at = [&](std::size_t h, std::size_t z, std::size_t f) {
      return double(sky.value[wavelength * sky.wavelength + (height.index + h) * sky.height + z * sky.a + f * sky.b]);
    };
    double once = 0;
    for (std::size_t h = 0; h < static_cast<std::size_t>(heights); ++h) {
      std::vector<atmos::SkyNode> list;
      for (const auto& [z, f] : around_sun) {
        const double fall = atmos::sky_shape(1.0, depth[h], cos_sun, std::cos(sky_zenith_[z]));
        if (fall > 0)
          list.push_back({phase_at(phase[h], node_angle[z * sky_azimuth_.size() + f]), sky_at(h, z, f) / fall});
      }
      once += height_weight[h] * atmos::once_scattered_level(list);
    }
    for (std::size_t z = 0; z < sky_zenith_.size(); ++z) {
      for (std::size_t h = 0; h < static_cast<std::size_t>(heights); ++h) {
        const double fall = shaped ? atmos::sky_shape(1.0, depth[h], cos_sun, std::cos(sky_zenith_[z])) : 0;
        for (std::size_t f = 0; f < sky_azimuth_.size(); ++f) {
          const std::size_t n = z * sky_azimuth_.size() + f;
          const double value = sky_at(h, z, f);
          plain[n] += height_weight[h] * value;
          if (!shaped) continue;
          rest[n] =
              fall > 0 ? rest[n] + height_weight[h] * (value / fall - once * phase_at(phase[h], node_angle[n])) : none;
        }
      }
    }
    const double depth_here = height_weight[0] * depth[0] + height_weight[1] * depth[1];
    for (std::size_t z = 0; z < zenith_rad.size(); ++z)
      grid_fall[z] = shaped ? atmos::sky_shape(1.0, depth_here, cos_sun, std::cos(zenith_rad[z])) : 0;
    for (std::size_t z = 0; z < zenith_rad.size(); ++z)
      for (std::size_t f = 0; f < azimuth_rad.size(); ++f) {
        const std::size_t n = z * azimuth_rad.size() + f;
        double value = none;
        if (shaped) {
          const double p = height_weight[0] * phase_at(phase[0], grid_angle[n]) +
                           height_weight[1] * phase_at(phase[1], grid_angle[n]);
          value = (once * p + bilinear(rest, zenith_cell[z], azimuth_cell[f])) * grid_fall[z];
        }
        if (std::isnan(value)) value = bilinear(plain, zenith_cell[z], azimuth_cell[f]);
        out[n * count_ + i] = std::max(0.0, value);
      }
  }
  if (!couples_ground()) return out;
  // What the ground sent up and the air sends back: the same at all azimuths.
  const View back(table_, table_.need("diffuse_return", "light between ground and air"), "sky_zenith", nullptr);
  const Spectrum up = ground_radiance(height_m);
  for (std::size_t z = 0; z < zenith_rad.size(); ++z)
    for (std::size_t i = 0; i < count_; ++i) {
      double t = 0;
      for (std::size_t h = 0; h < static_cast<std::size_t>(heights); ++h) {
        const float* at = back.value + (first_ + i) * back.wavelength + (height.index + h) * back.height +
                          zenith_cell[z].index * back.a;
        const double f = zenith_cell[z].fraction;
        t += height_weight[h] * (f > 0 ? (1 - f) * double{at[0]} + f * double{at[back.a]} : double{at[0]});
      }
      for (std::size_t a = 0; a < azimuth_rad.size(); ++a)
        out[(z * azimuth_rad.size() + a) * count_ + i] += ground_[i] * up[i] * t;
    }
  return out;
}

}  // namespace raycube::plan
