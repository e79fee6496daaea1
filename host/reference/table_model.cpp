#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "atmos_tables/interpolate.h"
#include "host/reference/radiance.h"

namespace raycube::reference {

namespace {

constexpr double kDegree = 180 / std::numbers::pi;
/// A target above the table's highest node, or below its lowest, is taken at that node (the plan does the same).
double within_table(const atmos::RenderTable& table, double height_m) {
  const std::vector<double>& nodes = table.axis("target_height").nodes;
  return nodes.size() < 2 ? height_m : std::clamp(height_m, nodes.front(), nodes.back());
}

/// Between sky height nodes this far apart, linear weights are off by (100 m / 8 km scale height)^2 / 8 = 2e-5.
constexpr double kSkyHeightStep_m = 100;

double zenith_deg(const glm::dvec3& unit) { return std::acos(std::clamp(unit.z, -1.0, 1.0)) * kDegree; }

/// Clockwise from north (y), of the direction towards something.
double azimuth_deg(const glm::dvec3& unit) { return std::atan2(unit.x, unit.y) * kDegree; }

}  // namespace

TableModel::TableModel(const ReferenceScene& scene, const plan::Plan& plan, const atmos::RenderTable& table, bool no_air,
                       double height_lo_m, double height_hi_m, int directions)
    : scene_(scene), plan_(plan), table_(table), no_air_(no_air),
      reflectance_(reflectance_on(scene.compiled, plan.wavelength_um)) {
  if (no_air) return;
  if (!plan.environment.empty()) environment_.emplace(scene, plan, table);
  // Spiral of equal solid angles (Gonzalez 2010, Mathematical Geosciences 42, 49), upper half.
  const double turn = std::numbers::pi * (3 - std::sqrt(5.0));
  for (int k = 0; k < directions; ++k) {
    const double z = (k + 0.5) / directions, r = std::sqrt(1 - z * z);
    direction_.emplace_back(r * std::sin(turn * k), r * std::cos(turn * k), z);
  }
  solid_angle_ = 2 * std::numbers::pi / directions;
  height_lo_m = within_table(table, height_lo_m), height_hi_m = within_table(table, height_hi_m);
  const int steps = static_cast<int>(std::ceil((height_hi_m - height_lo_m) / kSkyHeightStep_m));
  height_first_ = height_lo_m;
  height_step_ = steps > 0 ? (height_hi_m - height_lo_m) / steps : 1;
  for (int node = 0; node <= steps; ++node) {
    std::vector<float>& values = sky_.emplace_back();
    for (const glm::dvec3& d : direction_)
      for (double radiance : atmos::sky_radiance(table, height_first_ + node * height_step_, zenith_deg(d),
                                                 azimuth_deg(d) - table.sun_azimuth_deg))
        values.push_back(static_cast<float>(radiance));
    if (!environment_) continue;
    std::size_t at = 0;
    for (const glm::dvec3& d : direction_)
      for (double radiance : environment_->sky_increment(height_first_ + node * height_step_, zenith_deg(d)))
        values[at++] += static_cast<float>(radiance);
  }
}

std::vector<double> TableModel::on_grid(const std::vector<double>& table_spectrum) const {
  return atmos::resample_linear(atmos::wavelengths(table_), table_spectrum, plan_.wavelength_um);
}

/// Radiance at the sensor per unit reflectance and per unit (cosine, or sky irradiance spectrum), 1/pi inside.
std::vector<double> TableModel::source(double height_m, double zenith, bool sun) const {
  std::vector<double> out = sun ? atmos::solar_irradiance(table_) : std::vector<double>(atmos::wavelengths(table_).size(), 1.0);
  std::vector<double> through(out.size(), 1.0);
  if (!no_air_) {
    if (sun) {
      through = atmos::two_way_transmission(table_, height_m, zenith);
    } else {
      // Scattered light shares the gas absorption of the beam, and with it the two-way factor (ATMOSPHERE S5.3).
      through = atmos::view_transmission(table_, height_m, zenith);
      const std::vector<double> factor = atmos::two_way_factor(table_, height_m, zenith);
      for (std::size_t i = 0; i < through.size(); ++i) through[i] *= factor[i];
    }
  }
  for (std::size_t i = 0; i < out.size(); ++i) out[i] *= through[i] / std::numbers::pi;
  return out;
}

BandRadiance TableModel::radiance(const SampledPixel& pixel) const {
  // Within the pixel, spectra are linear between its own lowest and highest point: second order in metres over kilometres.
  double lowest = std::numeric_limits<double>::infinity(), highest = -lowest;
  for (const Sample& sample : pixel.samples) {
    const double z = sample.hit.miss() ? static_cast<double>(plan_.height.first) : sample.point.z;
    lowest = std::min(lowest, z), highest = std::max(highest, z);
  }
  struct PerMaterial {
    double sun = 0;                    ///< sum of weight x fraction x cosine over lit samples
    std::vector<double> sky;           ///< [direction]: sum of weight x fraction x cosine x solid angle where seen
  };
  std::map<std::uint32_t, PerMaterial> ends[2];  // by material
  double path_weight[2] = {0, 0};
  for (const Sample& sample : pixel.samples) {
    const double z = sample.hit.miss() ? static_cast<double>(plan_.height.first) : sample.point.z;
    const double f = highest > lowest ? (z - lowest) / (highest - lowest) : 0;
    const double share[2] = {sample.weight * (1 - f), sample.weight * f};
    for (int end = 0; end < 2; ++end) path_weight[end] += share[end];
    if (sample.hit.miss()) continue;
    std::vector<double> seen(direction_.size(), 0.0);
    for (std::size_t k = 0; k < direction_.size(); ++k) {
      const double cosine = glm::dot(sample.normal, direction_[k]);
      if (cosine > 0 && scene_.sees(sample, direction_[k])) seen[k] = cosine * solid_angle_;
    }
    const shared::Surface& surface = scene_.compiled.surfaces[scene_.compiled.blocks[sample.hit.primitive / RC_BLOCK]
                                                                  .surface[sample.hit.primitive % RC_BLOCK]];
    for (int m = 0; m < 4; ++m) {
      if (surface.curve[m] == 0) continue;
      for (int end = 0; end < 2; ++end) {
        const double w = share[end] * static_cast<double>(surface.fraction[m]);
        if (w == 0) continue;
        PerMaterial& sum = ends[end][surface.curve[m] - 1];
        if (sample.sun_visible) sum.sun += w * std::max(0.0, sample.cos_sun);
        sum.sky.resize(direction_.size(), 0.0);
        for (std::size_t k = 0; k < seen.size(); ++k) sum.sky[k] += w * seen[k];
      }
    }
  }

  const std::size_t grid = plan_.wavelength_um.size(), lines = atmos::wavelengths(table_).size();
  const double zenith = zenith_deg(pixel.to_sensor);
  std::vector<double> environment(environment_ ? grid : 0, 0.0);
  std::array<std::vector<double>, 2> around;
  if (environment_) around = environment_->around(ground_point(pixel, plan_));
  std::vector<double> sun(grid, 0.0), sky(grid, 0.0), path(grid, 0.0);
  for (int end = 0; end < 2; ++end) {
    const double z = no_air_ ? 0 : within_table(table_, end == 0 ? lowest : highest);
    if (path_weight[end] == 0) continue;
    if (!no_air_) {
      const std::vector<double> l = on_grid(
          atmos::path_radiance(table_, z, zenith, azimuth_deg(pixel.to_sensor) - table_.sun_azimuth_deg));
      for (std::size_t i = 0; i < grid; ++i) path[i] += path_weight[end] * l[i];
    }
    if (environment_) {
      const std::vector<double> l = on_grid(environment_->light(around, z, zenith));
      for (std::size_t i = 0; i < grid; ++i) environment[i] += path_weight[end] * l[i];
    }
    if (ends[end].empty()) continue;
    const std::vector<double> sun_light = on_grid(source(z, zenith, true)), through = source(z, zenith, false);
    for (const auto& [material, sum] : ends[end]) {
      const std::vector<double>& rho = reflectance_[material];
      for (std::size_t i = 0; i < grid; ++i) sun[i] += rho[i] * sum.sun * sun_light[i];
      if (direction_.empty()) continue;
      std::vector<double> irradiance(lines, 0.0);
      const double t = std::clamp((z - height_first_) / height_step_, 0.0, static_cast<double>(sky_.size() - 1));
      for (std::size_t node = 0; node < sky_.size(); ++node) {
        const double share = std::max(0.0, 1 - std::abs(t - static_cast<double>(node)));
        if (share == 0) continue;
        for (std::size_t k = 0; k < direction_.size(); ++k) {
          const double w = share * sum.sky[k];
          if (w == 0) continue;
          const float* l = sky_[node].data() + k * lines;
          for (std::size_t i = 0; i < lines; ++i) irradiance[i] += w * static_cast<double>(l[i]);
        }
      }
      for (std::size_t i = 0; i < lines; ++i) irradiance[i] *= through[i];
      const std::vector<double> light = on_grid(irradiance);
      for (std::size_t i = 0; i < grid; ++i) sky[i] += rho[i] * light[i];
    }
  }
  BandRadiance out{band_values(plan_, sun), band_values(plan_, sky), band_values(plan_, path), {}};
  if (environment_) out.environment = band_values(plan_, environment);
  return out;
}

}  // namespace raycube::reference
