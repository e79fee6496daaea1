#include "host/plan/band_truth.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "host/plan/baked_rows.h"
#include "host/plan/band_space.h"
#include "host/plan/curve.h"
#include "host/plan/node_choice.h"
#include "host/plan/quadrature.h"
#include "host/plan/sky_factors.h"
#include "host/plan/spectral_plan.h"
#include "host/plan/table_spectra.h"
#include "host/plan/thermal_plan.h"
#include "kernels/shared/product_key.h"
#include "scene_compiler/matter.h"
#include "scene_compiler/shape_energy.h"
#include "scene_compiler/spectral_shape.h"

namespace raycube::plan {

scene::BandTruth light_kind(const Plan& plan, std::uint64_t key, int channel) {
  using enum scene::BandTruth;
  if (key == 0) return path;
  if ((key & kSkeletonKey) == kSkeletonKey) return between_surfaces;
  if (key & kEnvironmentKey) return ground_around;
  const int source = channel / (plan.height.count * plan.view.count), component = source - plan.first_component();
  if (component < 0) return sun;
  if (source >= plan.first_emission()) return emission;
  if (source >= plan.first_lamp()) return lamps;
  if (component < plan.sky_components) return sky;
  return component + 1 < plan.components() ? thermal_sky : surroundings;
}

bool has_part(const Plan& plan, scene::BandTruth part) {
  using enum scene::BandTruth;
  switch (part) {
    case path:
      return true;
    case ground_around:
      return !plan.environment.empty();
    case sun:
      return plan.sun_sources > 0;
    case sky:
      return plan.sky_components > 0;
    case thermal_sky:
      return plan.thermal.on && plan.thermal.sky_components > 0;
    case surroundings:
    case emission:
      return plan.thermal.on;
    case lamps:
      return plan.lamps.sources() > 0;
    case between_surfaces:
      return plan.bounces.any();
    default:
      return false;
  }
}

std::vector<scene::BandTruth> truth_columns(const Plan& plan, const scene::Instrument& instrument) {
  std::vector<scene::BandTruth> out;
  for (std::size_t i = 0; i < std::size(scene::kBandTruth); ++i) {
    const auto truth = static_cast<scene::BandTruth>(i);
    if (scene::kBandTruth[i].kind == scene::BandTruthKind::way) continue;
    if (instrument.asks_for(truth) || (instrument.all_parts && has_part(plan, truth))) out.push_back(truth);
  }
  return out;
}

namespace {

/// Columns of a cube of truth in a row.
class Columns {
 public:
  Columns(const Plan& plan, std::size_t cube, std::size_t padded, std::vector<float>& row)
      : bands_(plan.bands.size()), first_((1 + cube) * bands_), padded_(padded), row_(row) {}

  void copy_radiance(std::size_t channel) {
    std::copy_n(row_.begin() + at(channel, 0), bands_, row_.begin() + at(channel, first_));
  }
  void put(std::size_t channel, const std::vector<double>& values) {
    std::transform(values.begin(), values.end(), row_.begin() + at(channel, first_),
                   [](double value) { return static_cast<float>(value); });
  }

 private:
  std::ptrdiff_t at(std::size_t channel, std::size_t column) const {
    return static_cast<std::ptrdiff_t>(channel * padded_ + column);
  }
  std::size_t bands_, first_, padded_;
  std::vector<float>& row_;
};

/// Of a material's light on the side that is seen: what falls onto it, times the share of a shape's node in it.
void put_irradiance(const Plan& plan, const std::vector<double>& share, Columns& columns) {
  const auto views = static_cast<std::size_t>(plan.view.count);
  for (std::size_t c = 0; c < plan.incident.size(); ++c) {
    std::vector<double> incident = plan.incident[c];
    for (std::size_t b = 0; b < incident.size(); ++b) incident[b] *= share[b];
    for (std::size_t v = 0; v < views; ++v) columns.put(c * views + v, incident);
  }
}

/// 1 less all that a material sends back of an even light, by all its lobes, and lets through.
std::vector<double> hemispherical_emissivity(const scene::CompiledScene& scene, std::uint32_t number,
                                             const std::vector<double>& wavelength_um) {
  const scene::Material& material = scene.materials[number];
  std::vector<double> out(wavelength_um.size(), 1.0);
  const auto less = [&](std::uint32_t curve, double times) {
    const std::vector<double> values = curve_on(scene, curve, wavelength_um);
    for (std::size_t i = 0; i < out.size(); ++i) out[i] -= times * values[i];
  };
  less(scene::reflectance_curve(scene, number), scene::white_sky_albedo(material.front));
  less(scene::transmittance_curve(scene, number), 1);
  if (material.gloss.number != RC_SHAPE_none)
    less(scene::gloss_curve(scene, number), scene::white_sky_albedo(material.gloss));
  for (std::size_t t = 0; t < material.further.size(); ++t)
    less(scene::further_curve(scene, number, t), scene::white_sky_albedo(material.further[t].shape));
  return out;
}

/// Of a curve by which a material reflects, its share in all of those in the bands; 1 where it has one.
std::vector<double> share_of(const Plan& plan, const scene::CompiledScene& scene, std::uint32_t curve) {
  const scene::Material& material = scene.materials[scene::material_of_curve(scene, curve)];
  if (material.front_curve.value.empty()) return std::vector<double>(plan.bands.size(), 1.0);
  std::vector<double> share = curve_on(scene, curve, plan.wavelength_um);
  const std::vector<double> all = sample_reflectance(material, plan.wavelength_um);
  for (std::size_t i = 0; i < share.size(); ++i) share[i] = all[i] > 0 ? share[i] / all[i] : 0;
  return in_bands(plan.bands, share);
}

}  // namespace

void fill_incident(Plan& plan, const TableSpectra& air, const BandSpace& bands, const PlannedSkies& skies,
                   const SpectralPlan& spectral, int threads) {
  const auto heights = static_cast<std::size_t>(plan.height.count);
  plan.incident.resize(static_cast<std::size_t>(plan.first_emission()) * heights);
  for (std::size_t h = 0; h < heights; ++h) {
    const double z = node_position(plan.height, static_cast<int>(h));
    std::size_t source = 0;
    const auto add = [&](const std::vector<double>& spectrum) {
      plan.incident[source++ * heights + h] = in_bands(spectral.bands, spectrum);
    };
    if (plan.sun_sources > 0) add(bands.to_grid(air.sun(z)));
    const SkySpectra solar = sky_spectra(skies.solar, air, z, nullptr, threads);
    for (int m = 0; m < plan.sky_components; ++m) add(bands.to_grid(solar[static_cast<std::size_t>(m)]));
    if (plan.thermal.on) {
      const SkySpectra warm = sky_spectra(skies.thermal, air, z, nullptr, threads);
      for (int m = 0; m < plan.thermal.sky_components; ++m) add(bands.to_grid(warm[static_cast<std::size_t>(m)]));
      add(planck_spectrum(spectral.wavelength_um, plan.thermal.surroundings_K));
    }
    for (const auto& spectrum : plan.lamps.spectrum) add(spectrum);
  }
}

void tell_of_missing_truth(Plan& plan, const scene::Instrument& instrument, double sun, double sky) {
  const bool asked = instrument.all_parts || instrument.asks_for(scene::BandTruth::irradiance) ||
                     instrument.asks_for(scene::BandTruth::sun) || instrument.asks_for(scene::BandTruth::sky);
  if (!plan.sun_up) sun = 0;
  if (!asked || !(sun > 0 || sky > 0)) return;
  plan.notices.push_back(fmt::format(
      "instrument '{}': {} left out, {:.2g} % of the radiance beside thermal light: truth per band does not hold it, "
      "irradiance neither, where it may be more; a smaller tolerance keeps it",
      instrument.name,
      sun > 0 && sky > 0 ? "sunlight and skylight are"
      : sun > 0          ? "sunlight is"
                         : "skylight is",
      100 * (sun + sky)));
}

Plan with_truth(const Plan& plan, const std::vector<scene::BandTruth>& cubes) {
  Plan out = plan;
  out.truth = cubes;
  out.baked = std::make_shared<BakedRows>();
  return out;
}

void bake_truth(const Plan& plan, const scene::CompiledScene& scene, std::uint64_t key, std::size_t padded,
                std::vector<float>& row) {
  using enum scene::BandTruth;
  const bool product = key != 0 && (key & kEnvironmentKey) == 0;
  const bool seen =
      product && rc_curve_role(rc_key_curve(key, 0), scene::material_count(scene)) == RC_CURVE_REFLECTANCE;
  const std::size_t channels = row.size() / padded - (product ? 1 : 0);
  const auto coverage = static_cast<std::size_t>(plan.coverage_channel());
  const auto reflected = [&] {
    return sample_reflectance(scene.materials[scene::material_of_curve(scene, rc_key_curve(key, 0))],
                              plan.wavelength_um);
  };
  for (std::size_t cube = 0; cube < plan.truth.size(); ++cube) {
    Columns columns(plan, cube, padded, row);
    const scene::BandTruth truth = plan.truth[cube];
    if (scene::band_truth_entry(truth).kind == scene::BandTruthKind::part) {
      for (std::size_t c = 0; c < channels; ++c)
        if (light_kind(plan, key, static_cast<int>(c)) == truth) columns.copy_radiance(c);
    } else if (product && truth == irradiance && scene::is_of_front(scene, rc_key_curve(key, 0))) {
      put_irradiance(plan, share_of(plan, scene, rc_key_curve(key, 0)), columns);
    } else if (seen && truth == reflectance) {
      columns.put(coverage, in_bands(plan.bands, reflected()));
    } else if (seen && truth == emissivity) {
      const std::uint32_t material = scene::material_of_curve(scene, rc_key_curve(key, 0));
      columns.put(coverage, in_bands(plan.bands, hemispherical_emissivity(scene, material, plan.wavelength_um)));
    }
  }
}

}  // namespace raycube::plan
