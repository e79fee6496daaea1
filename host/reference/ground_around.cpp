#include "host/reference/ground_around.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "atmos_tables/environment_function.h"
#include "atmos_tables/interpolate.h"
#include "host/reference/radiance.h"
#include "scene_compiler/matter.h"
#include "scene_compiler/shape_energy.h"
#include "scene_compiler/spectral_shape.h"
#include "host/base/units.h"

namespace raycube::reference {

namespace {

/// Weight of node i of a uniform axis: a hat, clamped at the ends.
double hat(const plan::NodeAxis& axis, double value, int i) {
  if (axis.count < 2) return 1;
  const double t = (value - static_cast<double>(axis.first)) / static_cast<double>(axis.step);
  return std::max(0.0, 1 - std::abs(std::clamp(t, 0.0, static_cast<double>(axis.count - 1)) - i));
}

constexpr int kMeanPoints = 192;  ///< along a side of the region that the mean is taken over
constexpr int kPlaces = 1024;     ///< around a pixel, for each environment function

}  // namespace

Reflectances ground_albedos(const scene::CompiledScene& scene, const std::vector<double>& wavelength_um) {
  Reflectances out = curves_on(scene, wavelength_um);
  for (std::size_t m = 0; m < scene.materials.size(); ++m) {
    const scene::Material& material = scene.materials[m];
    for (const double share = scene::white_sky_albedo(material.front); double& value : out[m]) value *= share;
    for (std::size_t t = 0; t < material.further.size(); ++t) {
      if (scene::is_gloss(material.further[t].shape)) continue;
      const double share = scene::white_sky_albedo(material.further[t].shape);
      const std::vector<double>& curve = out[scene::further_curve(scene, m, t) - 1];
      for (std::size_t i = 0; i < curve.size(); ++i) out[m][i] += share * curve[i];
    }
  }
  out.resize(scene.materials.size());
  return out;
}

glm::dvec3 ground_point(const SampledPixel& pixel, const plan::Plan& plan) {
  glm::dvec3 sum(0);
  double weight = 0;
  for (const Sample& sample : pixel.samples)
    if (!sample.hit.miss()) sum += sample.weight * sample.point, weight += sample.weight;
  if (weight > 0) return sum / weight;
  const double down = (pixel.sensor.z - static_cast<double>(plan.height.first)) / pixel.to_sensor.z;
  return pixel.sensor - down * pixel.to_sensor;
}

std::vector<double> environment_light(const SampledPixel& pixel, const plan::Plan& plan,
                                      const Reflectances& reflectance) {
  const plan::EnvironmentMap& map = plan.environment;
  const std::size_t grid = plan.wavelength_um.size(), channels = static_cast<std::size_t>(plan.environment_channels());
  std::vector<double> molecules(grid, 0.0), aerosol(grid, 0.0), light(grid, 0.0);
  const glm::dvec3 point = ground_point(pixel, plan);
  const double x = (point.x - map.first_x_m) / map.step_m, y = (point.y - map.first_y_m) / map.step_m;
  const auto near = [](double at, int i, int count) {
    return std::max(0.0, 1 - std::abs(std::clamp(at, 0.0, static_cast<double>(count - 1)) - i));
  };
  for (int r = 0; r < map.rows; ++r)
    for (int c = 0; c < map.columns; ++c) {
      const double w = near(x, c, map.columns) * near(y, r, map.rows);
      if (w == 0) continue;
      const auto node = static_cast<std::size_t>(r * map.columns + c);
      for (std::size_t p = map.first_part[node]; p < map.first_part[node + 1]; ++p) {
        const std::vector<double>& rho = reflectance[map.part[p].material];
        for (std::size_t i = 0; i < grid; ++i) {
          molecules[i] += w * map.part[p].molecules * rho[i];
          aerosol[i] += w * map.part[p].aerosol * rho[i];
        }
      }
    }
  for (int h = 0; h < plan.height.count; ++h) {
    double at_height = 0;  // of all samples: light joins the path whatever it ends on
    for (const Sample& sample : pixel.samples)
      at_height += sample.weight *
                   hat(plan.height, sample.hit.miss() ? static_cast<double>(plan.height.first) : sample.point.z, h);
    for (int v = 0; v < plan.view.count; ++v) {
      const double w = at_height * hat(plan.view, 1 / pixel.to_sensor.z, v);
      if (w == 0) continue;
      const auto channel = static_cast<std::size_t>(h * plan.view.count + v);
      for (std::size_t i = 0; i < grid; ++i)
        light[i] += w * (molecules[i] * plan.environment_spectrum[channel][i] +
                         aerosol[i] * plan.environment_spectrum[channels + channel][i]);
    }
  }
  return light;
}

EnvironmentModel::EnvironmentModel(const ReferenceScene& scene, const plan::Plan& plan, const atmos::RenderTable& table)
    : scene_(scene),
      plan_(plan),
      table_(table),
      reflectance_(ground_albedos(scene.compiled, atmos::wavelengths(table))) {
  const auto& lo = plan.environment.mean_lo_m;
  const auto& hi = plan.environment.mean_hi_m;
  mean_.assign(atmos::wavelengths(table).size(), 0.0);
  double seen = 0;
  for (int j = 0; j < kMeanPoints; ++j)
    for (int i = 0; i < kMeanPoints; ++i)
      seen += add_ground(lo[0] + (hi[0] - lo[0]) * (i + 0.5) / kMeanPoints,
                         lo[1] + (hi[1] - lo[1]) * (j + 0.5) / kMeanPoints, 1, mean_);
  for (double& value : mean_) value /= std::max(1.0, seen);
}

bool EnvironmentModel::add_ground(double x_m, double y_m, double weight, std::vector<double>& sum) const {
  const scene::CompiledScene& scene = scene_.compiled;
  const Hit hit =
      scene_.embree.intersect({{static_cast<float>(x_m), static_cast<float>(y_m), scene.hi[2] + 1}, {0, 0, -1}});
  if (hit.miss()) return false;
  const shared::Surface& surface = scene::matter_of(scene, hit.primitive);
  for (int m = 0; m < 4; ++m) {
    if (surface.material[m] == 0) continue;
    const std::vector<double>& rho = reflectance_[surface.material[m] - 1];
    const double w = weight * static_cast<double>(surface.fraction[m]);
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += w * rho[i];
  }
  return true;
}

std::vector<double> EnvironmentModel::ground_radiance(double height_m) const {
  std::vector<double> out = atmos::diffuse_irradiance(table_, height_m);
  const std::vector<double> direct = atmos::direct_irradiance(table_, height_m),
                            back = atmos::spherical_albedo(table_, height_m);
  for (std::size_t i = 0; i < out.size(); ++i)
    out[i] = (out[i] + (plan_.sun_up ? direct[i] : 0)) / std::numbers::pi / (1 - mean_[i] * back[i]);
  return out;
}

std::vector<double> EnvironmentModel::sky_increment(double height_m, double zenith_deg) const {
  std::vector<double> out = ground_radiance(height_m);
  const std::vector<double> t = atmos::diffuse_return(table_, height_m, zenith_deg);
  for (std::size_t i = 0; i < out.size(); ++i) out[i] *= mean_[i] * t[i];
  return out;
}

std::array<std::vector<double>, 2> EnvironmentModel::around(const glm::dvec3& point) const {
  std::array<std::vector<double>, 2> out{mean_, mean_};
  if (!plan_.environment.local) return out;
  const double turn = std::numbers::pi * (3 - std::sqrt(5.0));
  for (std::size_t f = 0; f < 2; ++f) {
    std::fill(out[f].begin(), out[f].end(), 0.0);
    double unknown = 0;
    for (int k = 0; k < kPlaces; ++k) {
      const double share = (k + 0.5) / kPlaces;
      const double r =
          1000 * atmos::environment_radius_km(f == 0 ? atmos::Scatterer::molecules : atmos::Scatterer::aerosol, share,
                                              plan_.environment.height_m / 1000, plan_.environment.cos_view);
      if (!add_ground(point.x + r * std::cos(turn * k), point.y + r * std::sin(turn * k), 1.0 / kPlaces, out[f]))
        unknown += 1.0 / kPlaces;
    }
    for (std::size_t i = 0; i < mean_.size(); ++i) out[f][i] += unknown * mean_[i];
  }
  return out;
}

std::vector<double> EnvironmentModel::light(const std::array<std::vector<double>, 2>& around, double height_m,
                                            double zenith_deg) const {
  const std::vector<double> up = ground_radiance(height_m),
                            t_dif = atmos::diffuse_view_transmission(table_, height_m, zenith_deg),
                            factor = atmos::two_way_factor(table_, height_m, zenith_deg);
  const std::vector<double>& wavelength = atmos::wavelengths(table_);
  std::vector<double> out(up.size());
  for (std::size_t i = 0; i < out.size(); ++i) {
    const double by_molecules =
        std::min(t_dif[i], atmos::molecular_diffuse_transmission(wavelength[i], plan_.environment.pressure_hPa,
                                                                 height_m, plan_.environment.sensor_z_m,
                                                                 std::cos(base::rad_by_division(zenith_deg))));
    out[i] = up[i] * factor[i] * (by_molecules * around[0][i] + (t_dif[i] - by_molecules) * around[1][i]);
  }
  return out;
}

}  // namespace raycube::reference
