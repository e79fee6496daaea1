#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "atmos_tables/interpolate.h"
#include "host/base/interrupt.h"
#include "host/base/planck.h"
#include "host/base/units.h"
#include "host/reference/radiance.h"
#include "host/reference/lamp_light.h"
#include "host/reference/spread.h"
#include "kernels/shared/tile_layout.h"
#include "scene_compiler/matter.h"
#include "scene_compiler/shape_energy.h"

namespace raycube::reference {

namespace {

constexpr std::size_t kDirectionsPerLook = 64;  ///< between two looks for a signal
/// A target above the table's highest node, or below its lowest, is taken at that node (the plan does the same).
double within_table(const atmos::RenderTable& table, double height_m) {
  const std::vector<double>& nodes = table.axis("target_height").nodes;
  return nodes.size() < 2 ? height_m : std::clamp(height_m, nodes.front(), nodes.back());
}

/// Between sky height nodes this far apart, linear weights are off by (100 m / 8 km scale height)^2 / 8 = 2e-5.
constexpr double kSkyHeightStep_m = 100;

double zenith_deg(const glm::dvec3& unit) { return base::deg_from_rad(std::acos(std::clamp(unit.z, -1.0, 1.0))); }

/// Clockwise from north (y), of the direction towards something.
double azimuth_deg(const glm::dvec3& unit) { return base::deg_from_rad(std::atan2(unit.x, unit.y)); }

}  // namespace

TableModel::TableModel(const ReferenceScene& scene, const plan::Plan& plan, const atmos::RenderTable& table,
                       bool no_air, int directions, const SkyShare& share, bool beside_paths)
    : scene_(scene),
      plan_(plan),
      table_(table),
      no_air_(no_air),
      beside_paths_(beside_paths),
      curve_(curves_on(scene.compiled, plan.wavelength_um)) {
  sun_ = plan.sun_up && table.has("solar_irradiance");
  skylight_ = !no_air && table.has("sky_radiance_solar");
  warm_path_ = !no_air && table.has("path_radiance_thermal");
  warm_sky_ = !no_air && table.has("sky_radiance_thermal");
  for (const auto& material : scene.compiled.materials) {
    std::vector<double>& light = black_body_.emplace_back();
    for (std::size_t i = 0; material.temperature_K > 0 && i < plan.wavelength_um.size(); ++i)
      light.push_back(base::planck_radiance(plan.wavelength_um[i], material.temperature_K));
  }
  add_albedos();
  if (no_air && !plan.thermal.on) return;  // nothing comes from anywhere but the sun
  if (!plan.environment.empty()) environment_.emplace(scene, plan, table);
  // Spiral of equal solid angles (Gonzalez 2010, Mathematical Geosciences 42, 49), upper half.
  const double turn = std::numbers::pi * (3 - std::sqrt(5.0));
  for (int k = 0; k < directions; ++k) {
    const double z = (k + 0.5) / directions, r = std::sqrt(1 - z * z);
    direction_.emplace_back(r * std::sin(turn * k + share.turn_rad), r * std::cos(turn * k + share.turn_rad), z);
  }
  if (share.per_sample > 0) stride_ = static_cast<std::size_t>(std::max(1, directions / share.per_sample));
  solid_angle_ = 2 * std::numbers::pi / directions * static_cast<double>(stride_);
  // Points lie in the scene below the sensor; a ray that meets nothing ends at the plan's lowest node.
  const double floor_m = static_cast<double>(plan.height.first);
  const auto& compiled = scene.compiled;
  const bool empty = !(compiled.lo[2] <= compiled.hi[2]);
  const double lowest = empty ? floor_m : std::min(floor_m, static_cast<double>(compiled.lo[2]));
  const double highest =
      empty ? floor_m : std::max(lowest, std::min(static_cast<double>(compiled.hi[2]), table.sensor_height_m));
  const double height_lo_m = within_table(table, lowest), height_hi_m = within_table(table, highest);
  const int steps = static_cast<int>(std::ceil((height_hi_m - height_lo_m) / kSkyHeightStep_m));
  height_first_ = height_lo_m;
  height_step_ = steps > 0 ? (height_hi_m - height_lo_m) / steps : 1;
  const std::size_t lines = atmos::wavelengths(table).size();
  for (int node = 0; node <= steps; ++node) {
    const double z = height_first_ + node * height_step_;
    std::vector<float>& values = sky_.emplace_back();
    if (!skylight_) values.assign(direction_.size() * lines, 0.0f);
    std::size_t done = 0;
    for (const glm::dvec3& d : direction_) {
      if (done++ % kDirectionsPerLook == 0) base::throw_if_interrupted();
      if (skylight_)
        for (double radiance : atmos::sky_radiance(table, z, zenith_deg(d), azimuth_deg(d) - table.sun_azimuth_deg))
          values.push_back(static_cast<float>(radiance));
    }
    std::size_t at = 0;
    if (environment_)
      for (const glm::dvec3& d : direction_)
        for (double radiance : environment_->sky_increment(z, zenith_deg(d)))
          values[at++] += static_cast<float>(radiance);
    for (std::size_t i = 0; i < values.size(); ++i) values[i] *= static_cast<float>(plan.sky_flux.at(z, i % lines));
    if (!warm_sky_) continue;
    std::vector<float>& emitted = thermal_sky_.emplace_back();
    for (const glm::dvec3& d : direction_)
      for (double radiance : atmos::sky_radiance_thermal(table, z, zenith_deg(d)))
        emitted.push_back(static_cast<float>(radiance));
  }
}

void TableModel::add_albedos() {
  constexpr int kFiner = 2;  // than the plan's
  const auto add = [&](const scene::Shape& shape) {
    if (shape.number == RC_SHAPE_none || shape.number == RC_SHAPE_lambert) return;
    for (const auto& [known, table] : albedo_)
      if (known == shape) return;
    albedo_.emplace_back(
        shape, scene::LobeAlbedo(shape, kFiner * (RC_ALBEDO_ZENITHS - 1) + 1, kFiner * (RC_ALBEDO_AZIMUTHS - 1) + 1));
  };
  for (const auto number : scene::used_materials(scene_.compiled)) {
    const scene::Material& material = scene_.compiled.materials[number];
    if (!plan_.thermal.on && !(material.temperature_K > 0)) continue;
    add(material.front), add(material.gloss);
    for (const auto& lobe : material.further) add(lobe.shape);
  }
}

std::vector<double> TableModel::on_grid(const std::vector<double>& table_spectrum) const {
  return atmos::resample_linear(atmos::wavelengths(table_), table_spectrum, plan_.wavelength_um);
}

/// Radiance at the sensor per unit reflectance and per unit (cosine, or sky irradiance spectrum), 1/pi inside.
std::vector<double> TableModel::source(double height_m, double zenith, Light light) const {
  const bool sun = light == Light::sun;
  if ((sun && !sun_) || (light == Light::sky && !skylight_ && !no_air_))
    return std::vector<double>(atmos::wavelengths(table_).size(), 0.0);
  std::vector<double> out =
      sun ? atmos::solar_irradiance(table_) : std::vector<double>(atmos::wavelengths(table_).size(), 1.0);
  std::vector<double> through(out.size(), 1.0);
  if (!no_air_) {
    if (sun) {
      through = atmos::two_way_transmission(table_, height_m, zenith);
    } else {
      // Scattered light shares the gas absorption of the beam, and with it the two-way factor (ATMOSPHERE S5.3).
      through = atmos::view_transmission(table_, height_m, zenith);
      std::vector<double> factor(through.size(), 1.0);
      if (light == Light::sky) factor = atmos::two_way_factor(table_, height_m, zenith);
      if (light == Light::thermal_sky) factor = atmos::two_way_factor_thermal(table_, height_m, zenith);
      for (std::size_t i = 0; i < through.size(); ++i) through[i] *= factor[i];
    }
  }
  for (std::size_t i = 0; i < out.size(); ++i) out[i] *= through[i] / std::numbers::pi;
  return out;
}

double TableModel::emitted(std::uint32_t curve, double cover, double even, std::size_t i) const {
  const std::vector<double>& light = black_body_[scene::material_of_curve(scene_.compiled, curve)];
  if (light.empty()) return 0;
  const bool near = rc_curve_role(curve, scene::material_count(scene_.compiled)) == RC_CURVE_REFLECTANCE;
  return ((near ? cover : 0) - even * curve_[curve - 1][i]) * light[i];
}

std::vector<double> TableModel::surface_light(std::uint32_t surface) const {
  std::vector<double> out(plan_.wavelength_um.size(), 0.0);
  const scene::CompiledScene& scene = scene_.compiled;
  scene::for_each_material(scene.surfaces[surface], [&](std::size_t m, float share) {
    const scene::Material& material = scene.materials[m];
    for (rc_id role = 0; role < scene::curve_roles(scene); ++role) {
      const std::uint32_t curve = rc_curve_id(role, static_cast<rc_id>(m), scene::material_count(scene));
      if (!scene::carries_light(scene, curve)) continue;
      const double even = role == RC_CURVE_REFLECTANCE ? scene::white_sky_albedo(material.front)
                          : role == RC_CURVE_GLOSS     ? scene::white_sky_albedo(material.gloss)
                          : role >= RC_CURVE_FURTHER
                              ? scene::white_sky_albedo(material.further[role - RC_CURVE_FURTHER].shape)
                              : 1;
      for (std::size_t i = 0; i < out.size(); ++i)
        out[i] +=
            static_cast<double>(share) *
            (emitted(curve, 1, even, i) +
             even * curve_[curve - 1][i] * base::planck_radiance(plan_.wavelength_um[i], plan_.thermal.surroundings_K));
    }
  });
  return out;
}

/// What one sample sees of the sky, and what it meets where it sees none.
struct TableModel::SkyView {
  std::vector<double> seen;                ///< [direction]: cosine x solid angle, 0 where something hides it
  double even = 1;                         ///< of an even light, what the side's lobe sends to the viewer
  std::map<std::uint32_t, double> hidden;  ///< the same by the surface that is met instead; RC_NONE: beyond the scene
};

/// The light that a pixel's samples meet, by the curve by which it goes to the viewer. Within the pixel, spectra are
/// linear between its own lowest and highest point, its two ends: second order in metres over kilometres.
struct TableModel::PixelSums {
  struct OfCurve {
    double sun = 0;                          ///< sum of weight x fraction x cosine over lit samples
    std::vector<double> sky;                 ///< [direction]: sum of weight x fraction x SkyView::seen
    std::vector<double> lamps;               ///< [source]: sum of weight x fraction x irradiance
    double cover = 0, even = 0;              ///< sum of weight x fraction, and of that x SkyView::even
    std::map<std::uint32_t, double> hidden;  ///< sum of weight x fraction x SkyView::hidden
  };
  double lowest_m = std::numeric_limits<double>::infinity(), highest_m = -lowest_m;
  std::map<std::uint32_t, OfCurve> ends[2];  ///< by curve - 1
  double path_weight[2] = {0, 0};
};

/// A pixel's radiance on the plan's grid, by physics block.
struct TableModel::Spectra {
  std::vector<double> sun, sky, path, environment, emission, surroundings, lamps;
};

double TableModel::height_of(const Sample& sample) const {
  return sample.hit.miss() ? static_cast<double>(plan_.height.first) : sample.point.z;
}

double TableModel::even_light(const Sample& side) const {
  const scene::Shape* shape = shape_of(scene_.compiled, side);
  for (const auto& [known, table] : albedo_)
    if (shape && known == *shape) return table.at(on_surface(side.normal, viewer_of(side)));
  return 1;
}

TableModel::SkyView TableModel::look(const Sample& sample, std::size_t lot) const {
  SkyView view{std::vector<double>(direction_.size(), 0.0), 1, {}};
  const auto surface_of = [&](const Hit& hit) {
    return hit.miss() ? RC_NONE : scene::surface_of(scene_.compiled, hit.primitive);
  };
  for (std::size_t k = lot % stride_; k < direction_.size(); k += stride_) {
    const double cosine = glm::dot(sample.normal, direction_[k]);
    if (cosine > 0 && scene_.sees(sample, direction_[k]))
      view.seen[k] = cosine * solid_angle_ * spread(scene_.compiled, sample, direction_[k]);
    if (!plan_.thermal.on) continue;
    if (cosine > 0 && view.seen[k] == 0)
      view.hidden[surface_of(scene_.meets(sample, direction_[k]))] +=
          cosine * solid_angle_ * spread(scene_.compiled, sample, direction_[k]);
    const glm::dvec3 below(direction_[k].x, direction_[k].y, -direction_[k].z);
    const double down = glm::dot(sample.normal, below);
    if (down > 0)
      view.hidden[surface_of(scene_.meets(sample, below))] +=
          down * solid_angle_ * spread(scene_.compiled, sample, below);
  }
  view.even = even_light(sample);
  const scene::Shape* shape = shape_of(scene_.compiled, sample);
  if (!plan_.thermal.on || !shape || shape->number == RC_SHAPE_lambert) return view;
  // Directions are too few for a lobe: what they lack of the whole counts as the surroundings'.
  double lacking = std::numbers::pi * view.even;
  for (const double seen : view.seen) lacking -= seen;
  for (const auto& [blocker, weight] : view.hidden) lacking -= weight;
  view.hidden[RC_NONE] += lacking;
  return view;
}

void TableModel::add_hit(const Sample& sample, const SkyView& view, const double share[2], PixelSums& sums) const {
  const shared::Surface& surface = scene::matter_of(scene_.compiled, sample.hit.primitive);
  const double sun_spread = spread(scene_.compiled, sample,
                                   glm::dvec3(plan_.sun_direction[0], plan_.sun_direction[1], plan_.sun_direction[2]));
  const std::vector<double> lamplight = all_lamplight(scene_, plan_, sample);
  for (int m = 0; m < 4; ++m) {
    if (surface.material[m] == 0) continue;
    for (int end = 0; end < 2; ++end) {
      const double w = share[end] * static_cast<double>(surface.fraction[m]);
      if (w == 0) continue;
      PixelSums::OfCurve& sum = sums.ends[end][rc_curve_id(rc_curve_of_side(sample.side), surface.material[m] - 1,
                                                           scene::material_count(scene_.compiled)) -
                                               1];
      sum.cover += w, sum.even += w * view.even;
      for (const auto& [blocker, weight] : view.hidden) sum.hidden[blocker] += w * weight;
      if (sample.sun_visible) sum.sun += w * std::max(0.0, sample.cos_sun) * sun_spread;
      sum.lamps.resize(lamplight.size(), 0.0);
      for (std::size_t k = 0; k < lamplight.size(); ++k) sum.lamps[k] += w * lamplight[k];
      sum.sky.resize(direction_.size(), 0.0);
      for (std::size_t k = 0; k < view.seen.size(); ++k) sum.sky[k] += w * view.seen[k];
    }
  }
}

TableModel::PixelSums TableModel::gather(const SampledPixel& pixel) const {
  PixelSums sums;
  for (const Sample& sample : pixel.samples) {
    const double z = height_of(sample);
    sums.lowest_m = std::min(sums.lowest_m, z), sums.highest_m = std::max(sums.highest_m, z);
  }
  // Samples that follow each other look into other lots: the step is odd, so all lots come up, and so many apart that
  // rows of a grid do not meet the same one again. Pixels start anywhere.
  std::size_t lot = pixel.number * 2654435769u;
  for (std::size_t i = 0; i < pixel.sides(); ++i) {
    const Sample& sample = pixel.side(i);
    base::throw_if_interrupted();
    lot += 13;
    const double z = height_of(sample);
    const double f = sums.highest_m > sums.lowest_m ? (z - sums.lowest_m) / (sums.highest_m - sums.lowest_m) : 0;
    const double share[2] = {sample.weight * (1 - f), sample.weight * f};
    for (int end = 0; end < 2 && sample.side == 0; ++end) sums.path_weight[end] += share[end];
    if (!sample.hit.miss()) add_hit(sample, look(sample, lot), share, sums);
  }
  return sums;
}

void TableModel::add_path(const SampledPixel& pixel, double height_m, double weight, Spectra& out) const {
  const auto add = [&](const std::vector<double>& on_table) {
    const std::vector<double> l = on_grid(on_table);
    for (std::size_t i = 0; i < l.size(); ++i) out.path[i] += weight * l[i];
  };
  const double zenith = zenith_deg(pixel.to_sensor);
  if (table_.has("path_radiance_solar"))
    add(atmos::path_radiance(table_, height_m, zenith, azimuth_deg(pixel.to_sensor) - table_.sun_azimuth_deg));
  if (warm_path_) add(atmos::path_radiance_thermal(table_, height_m, zenith));
}

void TableModel::add_surroundings(const std::map<std::uint32_t, double>& hidden, const std::vector<double>& rho,
                                  const std::vector<double>& direct, std::vector<double>& surroundings) const {
  for (const auto& [blocker, weight] : hidden) {
    std::vector<double> light;
    if (blocker != RC_NONE && !beside_paths_)
      light = surface_light(blocker);
    else
      for (const double l : plan_.wavelength_um)
        light.push_back(base::planck_radiance(l, plan_.thermal.surroundings_K));
    for (std::size_t i = 0; i < surroundings.size(); ++i) surroundings[i] += rho[i] * weight * direct[i] * light[i];
  }
}

std::vector<double> TableModel::sky_at_sensor(const std::vector<double>& weight, double height_m,
                                              const std::vector<double>& through,
                                              const std::vector<double>& thermal_through) const {
  const std::size_t lines = atmos::wavelengths(table_).size();
  std::vector<double> irradiance(lines, 0.0), emitted(lines, 0.0);
  const double t = std::clamp((height_m - height_first_) / height_step_, 0.0, static_cast<double>(sky_.size() - 1));
  for (std::size_t node = 0; node < sky_.size(); ++node) {
    const double share = std::max(0.0, 1 - std::abs(t - static_cast<double>(node)));
    if (share == 0) continue;
    for (std::size_t k = 0; k < direction_.size(); ++k) {
      const double w = share * weight[k];
      if (w == 0) continue;
      const float* l = sky_[node].data() + k * lines;
      for (std::size_t i = 0; i < lines; ++i) irradiance[i] += w * static_cast<double>(l[i]);
      if (!warm_sky_) continue;
      const float* e = thermal_sky_[node].data() + k * lines;
      for (std::size_t i = 0; i < lines; ++i) emitted[i] += w * static_cast<double>(e[i]);
    }
  }
  for (std::size_t i = 0; i < lines; ++i) irradiance[i] *= through[i];
  if (warm_sky_)
    for (std::size_t i = 0; i < lines; ++i) irradiance[i] += emitted[i] * thermal_through[i];
  return irradiance;
}

void TableModel::add_materials(const PixelSums& sums, int end, double height_m, double zenith, Spectra& out) const {
  const std::size_t grid = plan_.wavelength_um.size();
  const std::vector<double> sun_light = on_grid(source(height_m, zenith, Light::sun)),
                            through = source(height_m, zenith, Light::sky);
  const std::vector<double> direct = on_grid(source(height_m, zenith, Light::direct));
  std::vector<double> thermal_through;
  if (warm_sky_) thermal_through = source(height_m, zenith, Light::thermal_sky);
  for (const auto& [curve, sum] : sums.ends[end]) {
    const std::vector<double>& rho = curve_[curve];
    for (std::size_t i = 0; i < grid; ++i) out.sun[i] += rho[i] * sum.sun * sun_light[i];
    for (std::size_t i = 0; i < grid; ++i)
      out.emission[i] += emitted(curve + 1, sum.cover, sum.even, i) * std::numbers::pi * direct[i];
    for (std::size_t k = 0; k < sum.lamps.size(); ++k)
      for (std::size_t i = 0; i < grid; ++i)
        out.lamps[i] += rho[i] * sum.lamps[k] * plan_.lamps.spectrum[k][i] * direct[i];
    if (direction_.empty()) continue;
    if (plan_.thermal.on) add_surroundings(sum.hidden, rho, direct, out.surroundings);
    const std::vector<double> light = on_grid(sky_at_sensor(sum.sky, height_m, through, thermal_through));
    for (std::size_t i = 0; i < grid; ++i) out.sky[i] += rho[i] * light[i];
  }
}

BandRadiance TableModel::radiance(const SampledPixel& pixel) const {
  const PixelSums sums = gather(pixel);
  const std::vector<double> dark(plan_.wavelength_um.size(), 0.0);
  Spectra spectra{dark, dark, dark, environment_ ? dark : std::vector<double>(), dark, dark, dark};
  std::array<std::vector<double>, 2> around;
  if (environment_) around = environment_->around(ground_point(pixel, plan_));
  const double zenith = zenith_deg(pixel.to_sensor);
  for (int end = 0; end < 2; ++end) {
    const double z = no_air_ ? 0 : within_table(table_, end == 0 ? sums.lowest_m : sums.highest_m);
    if (sums.path_weight[end] == 0) continue;
    if (!no_air_) add_path(pixel, z, sums.path_weight[end], spectra);
    if (environment_) {
      const std::vector<double> l = on_grid(environment_->light(around, z, zenith));
      for (std::size_t i = 0; i < l.size(); ++i) spectra.environment[i] += sums.path_weight[end] * l[i];
    }
    if (!sums.ends[end].empty()) add_materials(sums, end, z, zenith, spectra);
  }
  BandRadiance out{.sun = band_values(plan_, spectra.sun),
                   .sky = band_values(plan_, spectra.sky),
                   .path = band_values(plan_, spectra.path),
                   .lamps = plan_.lamps.sources() > 0 ? band_values(plan_, spectra.lamps) : std::vector<double>(),
                   .environment = {},
                   .emission = band_values(plan_, spectra.emission),
                   .surroundings = band_values(plan_, spectra.surroundings)};
  if (environment_) out.environment = band_values(plan_, spectra.environment);
  return out;
}

}  // namespace raycube::reference
