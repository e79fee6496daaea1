#include "host/plan/thermal_use.h"

#include <algorithm>

#include <fmt/format.h>

#include "host/base/planck.h"
#include "host/plan/curve.h"
#include "host/plan/plan_errors.h"
#include "host/plan/sky_factors.h"
#include "host/plan/thermal_plan.h"
#include "scene_compiler/matter.h"

namespace raycube::plan {

namespace {

constexpr double kDark = 1e-12;           ///< W m-2 sr-1 um-1
constexpr double kVacuumHeatFrom_um = 4;  ///< vacuum has no rows that would ask for temperatures
constexpr std::size_t kNamed = 3;         ///< materials that a notice names

using Bands = std::vector<double>;

/// Keeps the largest share of any band.
void judge(ThermalUse& use, const Bands& emitted, const Bands& typical, const std::string& from) {
  for (std::size_t b = 0; b < emitted.size(); ++b) {
    const double share = emitted[b] > kDark ? emitted[b] / std::max(typical[b], kDark) : 0;
    if (share > use.share) use.share = share, use.band = b, use.from = from;
  }
}

/// Band means of (1 - reflectance - transmittance) B T_view.
Bands emitted_bands(const scene::Material& material, const Spectrum& up_on_grid, const SpectralPlan& spectral) {
  const Spectrum planck = planck_spectrum(spectral.wavelength_um, material.temperature_K);
  Spectrum returned = sample_reflectance(material, spectral.wavelength_um);
  if (scene::lets_light_through(material)) {
    const Spectrum through = sample_curve(material, material.transmittance, spectral.wavelength_um);
    for (std::size_t i = 0; i < returned.size(); ++i) returned[i] += through[i];
  }
  Bands out;
  for (const BandQuadrature& band : spectral.bands) {
    double sum = 0;
    for (std::size_t i = 0; i < band.weight.size(); ++i) {
      const std::size_t at = band.first + i;
      sum += band.weight[i] * (1 - returned[at]) * planck[at] * up_on_grid[at];
    }
    out.push_back(sum);
  }
  return out;
}

/// Path emission, and the thermal sky that the mean surface reflects.
Bands air_bands(const TableSpectra& air, const Domain& domain, const BandSpace& bands) {
  const double z = domain.z(0.5), sec = domain.sec(0.5);
  Bands out = bands.band_mean(air.emitted_path(z, zenith_of_sec(sec)));
  const Spectrum sky = coarse_sky_irradiance(air, z, Sky::thermal);
  const Bands reflected = bands.reflected_band_mean(product(sky, sky_path(air, z, sec, Sky::thermal)));
  for (std::size_t b = 0; b < out.size(); ++b) out[b] += reflected[b];
  return out;
}

std::string listed(const std::vector<std::string>& names) {
  std::string out;
  for (std::size_t i = 0; i < std::min(names.size(), kNamed); ++i) out += (i ? ", '" : "'") + names[i] + "'";
  return names.size() > kNamed ? fmt::format("{} and {} more", out, names.size() - kNamed) : out;
}

void add_notices(ThermalUse& use, const scene::CompiledScene& scene, const std::string& instrument,
                 const SpectralPlan& spectral) {
  std::vector<std::string> cold;
  double hottest_K = 0, coolest_K = 1e9;
  for (const auto index : scene::used_families(scene)) {
    const auto& material = scene.materials[index];
    if (!(material.temperature_K > 0)) cold.push_back(material.name);
    hottest_K = std::max(hottest_K, material.temperature_K), coolest_K = std::min(coolest_K, material.temperature_K);
  }
  const bool far = base::asks_for_heat(spectral.wavelength_um.back());
  if (!cold.empty() && (use.on || far))
    use.notices.push_back(fmt::format(
        "instrument '{}': {} without a temperature emits nothing: {}; give temperature_K, or [thermal] "
        "default_temperature_K{}",
        instrument, cold.size() == 1 ? "a material" : "every material", listed(cold),
        use.on ? fmt::format(" ({} makes {:.2g} times the other light of band {})", use.from, use.share, use.band + 1)
               : fmt::format(" (bands reach beyond {:g} um)", base::kHeatFrom_um)));
  const auto& reflected = spectral.largest_reflectance;
  const bool reflects = *std::max_element(reflected.begin(), reflected.end()) > 0;
  if (use.on && use.share > 1 && hottest_K > coolest_K && reflects)
    use.without_paths = fmt::format(
        "instrument '{}': light of hot surfaces that falls on other surfaces is not rendered "
        "(the hottest has {:g} K); give bounces above 0, or see by `raycube check` what "
        "that leaves out",
        instrument, hottest_K);
}

}  // namespace

std::string temperature_demand(bool vacuum, double bands_to_um, bool thermal_rows, double table_to_um) {
  if (thermal_rows && base::asks_for_heat(table_to_um)) return "the atmosphere table holds thermal light";
  if (vacuum && bands_to_um > kVacuumHeatFrom_um) return "bands without air reach beyond 4 um";
  return "";
}

ThermalUse thermal_use(const scene::Simulation& simulation, const scene::Instrument& instrument,
                       const atmos::RenderTable& table, const TableSpectra& air, const Domain& domain,
                       const BandSpace& bands, const SpectralPlan& spectral, double limit) {
  ThermalUse use;
  use.demanded_by = temperature_demand(simulation.atmosphere.none, spectral.wavelength_um.back(), air.thermal(),
                                       table.axis("wavelength").nodes.back());
  use.on = !use.demanded_by.empty();
  if (use.on) return use;

  const auto& scene = simulation.scene;
  std::vector<const scene::Material*> warm;
  for (const auto material : scene::used_materials(scene))
    if (scene.materials[material].temperature_K > 0) warm.push_back(&scene.materials[material]);
  if (!warm.empty() || air.thermal()) {
    TableSpectra sunlit = air;
    sunlit.leave_out_emission();
    const double z = domain.z(0.5), zenith = zenith_of_sec(domain.sec(0.5));
    const Bands typical = typical_radiance(sunlit, domain, bands, coarse_sky_irradiance(sunlit, z), {});
    if (air.thermal()) judge(use, air_bands(air, domain, bands), typical, "the air of the table");
    const Spectrum up = bands.to_grid(air.view_transmission(z, zenith));
    for (const auto* material : warm)
      judge(use, emitted_bands(*material, up, spectral), typical,
            fmt::format("material '{}' at {:g} K", material->name, material->temperature_K));
    use.on = simulation.thermal_below_3um && use.share > limit;
  }
  add_notices(use, scene, instrument.name, spectral);
  return use;
}

}  // namespace raycube::plan
