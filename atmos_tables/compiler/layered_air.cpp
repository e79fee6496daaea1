#include "atmos_tables/compiler/layered_air.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <mutex>
#include <numbers>
#include <optional>
#include <thread>

#include <nlohmann/json.hpp>

#include "atmos_tables/bird_riordan.h"
#include "atmos_tables/clear_sky_inputs.h"
#include "atmos_tables/compiler/air_provenance.h"
#include "atmos_tables/compiler/air_stack.h"
#include "atmos_tables/compiler/bin_rows.h"
#include "atmos_tables/moon.h"
#include "atmos_tables/table_rows.h"
#include "host/base/error.h"

namespace raycube::atmos {

namespace {

std::string provenance(const scene::AtmosphereSpec& spec, const scene::Sun& sun, const AirStack& stack,
                       const std::vector<std::string>& notices) {
  const scene::AirSpec& air = *spec.layered;
  const AirLevel ground = stack.profile().levels().front();
  nlohmann::json j;
  j["model"] = "raycube layered air";
  j["sources"] = {"profile: " + stack.profile().source(),
                  "gases: LOWTRAN7 (Kneizys et al. 1988) and 6S (Vermote et al. 1997) bands, blended",
                  "Rayleigh: Bodhaine et al. 1999",
                  aerosol_source(air),
                  "scattering: discrete ordinates (Stamnes et al. 1988), delta-M, Nakajima & Tanaka 1988",
                  "Spencer 1971"};
  j["parameters"] = air_parameters(spec, stack.aerosols());
  j["parameters"].update({{"ground_pressure_hPa", ground.pressure_hPa},
                          {"ground_temperature_K", ground.temperature_K},
                          {"water_g_cm2", stack.profile().water_g_cm2()},
                          {"ozone_atm_cm", stack.profile().ozone_atm_cm()},
                          {"co2_ppmv", ground.ppmv(Gas::co2)},
                          {"day_of_year", sun.day_of_year},
                          {"streams", air.streams},
                          {"k_terms", air.k_terms},
                          {"layers", stack.layers()},
                          {"gas_bands", air.gas_bands}});
  if (!air.lines.empty())
    j["sources"].push_back("lines: " + air.lines + ", Voigt profiles to " +
                           nlohmann::json(air.line_wing_per_cm).dump() + " cm-1 (cite the list's edition)");
  for (const auto& table : air.cross_sections)
    j["sources"].push_back("cross-sections of " + table.gas + ": " + table.file);
  j["notices"] = notices;
  j["limits"] = {"no polarisation: Rayleigh light off by 1 to 5 %, up to 11 % at grazing angles",
                 "gas structure finer than 20 cm-1 (LOWTRAN7) or 10 cm-1 (6S) is not resolved but for gases with lines "
                 "or cross-sections, "
                 "which are monochromatic at the wavelengths",
                 "plane-parallel scattering: rough for view zeniths above 80 deg"};
  return j.dump();
}

/// Lines or cross-sections of the specification for these wavelengths, with a word where the grid is too coarse for
/// lines.
LineAir resolved_gases(const scene::AirSpec& air, const std::vector<double>& wavelength_um) {
  if (!has_line_air(air)) return {};
  if (wavelength_um.size() > kMostResolvedNodes)
    throw base::Error(base::Fault::input,
                      "atmosphere wavelengths: a table with lines or cross-sections holds at most " +
                          std::to_string(kMostResolvedNodes) + " wavelengths, not " +
                          std::to_string(wavelength_um.size()) + "; narrow the range or widen the step");
  LineAir lines = read_line_air(air, 1e4 / wavelength_um.back(), 1e4 / wavelength_um.front());
  double widest_per_cm = 0;
  for (std::size_t i = 0; i + 1 < wavelength_um.size(); ++i)
    widest_per_cm = std::max(widest_per_cm, 1e4 / wavelength_um[i] - 1e4 / wavelength_um[i + 1]);
  if (!air.lines.empty() && widest_per_cm > 0.1)
    lines.notices.push_back(
        "wavelengths up to " + nlohmann::json(widest_per_cm).dump() +
        " cm-1 apart step over lines, whose half width is about 0.06 cm-1 at the ground; choose a finer spectral step");
  return lines;
}

/// Runs body(i) for every i on some threads; the first exception ends all and is thrown on.
void for_each_on_threads(std::size_t count, int threads, const std::function<void(std::size_t)>& body) {
  const auto hardware = std::max(1u, std::thread::hardware_concurrency());
  const auto workers = std::min<std::size_t>(count, threads > 0 ? static_cast<std::size_t>(threads) : hardware);
  std::atomic<std::size_t> next{0};
  std::exception_ptr failure;
  std::mutex mutex;
  const auto work = [&] {
    try {
      for (std::size_t i; (i = next.fetch_add(1)) < count;) body(i);
    } catch (...) {
      next = count;
      const std::lock_guard lock(mutex);
      if (!failure) failure = std::current_exception();
    }
  };
  std::vector<std::thread> pool;
  try {
    for (std::size_t t = 1; t < workers; ++t) pool.emplace_back(work);
  } catch (const std::system_error&) {  // no more threads to be had: those that run do it all
  }
  work();
  for (auto& thread : pool) thread.join();
  if (failure) std::rethrow_exception(failure);
}

/// The air in layers, with a level at the sensor and every target.
AirStack stack_of(const scene::AtmosphereSpec& spec, double sensor_height_m, const std::vector<double>& target_height_m,
                  const LineAir& lines) {
  const double z0_km = spec.ground_height_m / 1000;
  std::vector<double> marks_km = {z0_km + sensor_height_m / 1000};
  for (double height : target_height_m) marks_km.push_back(z0_km + height / 1000);
  return {*spec.layered, z0_km + target_height_m.front() / 1000, marks_km, lines};
}

}  // namespace

void check_layered(const scene::AtmosphereSpec& spec, const scene::Sun& sun, double sensor_height_m,
                   const std::vector<double>& wavelength_um, const std::vector<double>& target_height_m) {
  if (!spec.layered) throw base::Error(base::Fault::bug, "check_layered was given no layered air");
  check_table_request(sun, sensor_height_m, wavelength_um, target_height_m, kLayeredFirst_um, kLayeredLast_um);
  check_view_zeniths(spec.view_zenith_deg);
  static_cast<void>(SolarSpectrum(spec.solar));  // refuses what it cannot take
  const AirStack stack = stack_of(spec, sensor_height_m, target_height_m, resolved_gases(*spec.layered, wavelength_um));
  stack.aerosols().check_covers(wavelength_um.front(), wavelength_um.back());
}

RenderTable build_layered(const scene::AtmosphereSpec& spec, const scene::Sun& sun, double sensor_height_m,
                          const std::vector<double>& wavelength_um, const std::vector<double>& target_height_m,
                          const BuildWatch& watch) {
  if (!spec.layered) throw base::Error(base::Fault::bug, "build_layered was given no layered air");
  check_table_request(sun, sensor_height_m, wavelength_um, target_height_m, kLayeredFirst_um, kLayeredLast_um);
  check_view_zeniths(spec.view_zenith_deg);
  const double z0_km = spec.ground_height_m / 1000;
  const LineAir lines = resolved_gases(*spec.layered, wavelength_um);
  const AirStack stack = stack_of(spec, sensor_height_m, target_height_m, lines);
  stack.aerosols().check_covers(wavelength_um.front(), wavelength_um.back());
  std::optional<ResolvedGases> resolved;
  if (!lines.gases.empty()) {
    std::vector<double> wavenumbers;  // ascending, as wavelengths descend
    for (std::size_t i = wavelength_um.size(); i-- > 0;) wavenumbers.push_back(1e4 / wavelength_um[i]);
    resolved.emplace(lines.gases, stack.profile(), stack.level_km(), wavenumbers);
  }
  const auto resolved_depths = [&](std::size_t i) {
    std::vector<double> depths;
    // Noise of measured cross-sections may be negative.
    for (std::size_t layer = 0; resolved && layer < resolved->layers(); ++layer)
      depths.push_back(std::max(0.0, resolved->depth(wavelength_um.size() - 1 - i, layer)));
    return depths;
  };

  const SolarSpectrum spectrum(spec.solar);
  RenderTable table = sunlit_table(spectrum, sun, sensor_height_m, wavelength_um, target_height_m);
  std::vector<std::string> notices = stack.notices();
  if (auto notice = spectrum.notice(wavelength_um.front(), wavelength_um.back())) notices.push_back(std::move(*notice));
  table.provenance_json = provenance(spec, sun, stack, notices);
  const BinGeometry geometry(stack, sun, z0_km, sensor_height_m, target_height_m, spec.view_zenith_deg);
  BinRows rows(table, geometry, wavelength_um.back() >= kThermalFrom_um,
               spec.layered->gas_bands == "lowtran" ? LayerEmission::one_temperature : LayerEmission::graded);
  const std::vector<SpectralBin> bins = spectral_bins(wavelength_um);
  // A node stands for its bin, in the sun's light as in the transmission of gases.
  std::vector<float>& solar = table.rows.at("solar_irradiance").values;
  for (std::size_t i = 0; i < bins.size(); ++i) {
    const double moon = sun.moon_phase_deg >= 0 ? moon_over_sun(sun.moon_phase_deg, bins[i].wavelength_um) : 1;
    solar[i] = static_cast<float>(moon * earth_sun_factor(sun.day_of_year) *
                                  spectrum.mean_1au(1e4 / bins[i].high_per_cm, 1e4 / bins[i].low_per_cm));
  }
  for_each_on_threads(bins.size(), watch.threads, [&](std::size_t i) {
    rows.fill(i, SpectralAir(stack, bins[i], static_cast<std::size_t>(spec.layered->k_terms), resolved_depths(i)),
              spec.layered->streams);
    if (watch.finished) watch.finished(i);
  });
  validate(table, "layered air");
  return table;
}

std::vector<double> layered_wavelengths(double first_um, double last_um, double step_um) {
  base::Problems problems;
  if (!(first_um >= kLayeredFirst_um && last_um <= kLayeredLast_um && first_um < last_um))
    problems.add({"", 0, 0, "atmosphere wavelengths"}, "the layered model covers 0.3 to 30 um and ends there",
                 std::to_string(first_um) + " to " + std::to_string(last_um) + " um",
                 "narrow the range, or import a table");
  if (!(step_um >= 0) || (step_um > 0 && (last_um - first_um) / step_um > 1e6))
    problems.add({"", 0, 0, "atmosphere wavelength step"}, "must be positive and give at most 1e6 wavelengths",
                 std::to_string(step_um) + " um", "choose a wider step");
  problems.throw_if_any();
  std::vector<double> out;
  if (step_um > 0) {
    add_steps(out, first_um, last_um, {first_um, last_um, step_um});
  } else {
    add_steps(out, first_um, last_um, {first_um, 1.0, 0.001});
    add_steps(out, first_um, last_um, {1.0, 2.5, 0.002});
    if (last_um > 2.5) {
      // Steps of 5 cm-1 on multiples of 5, the spacing of the band tables.
      const double start = std::max(first_um, 2.5);
      if (out.empty() || start > out.back()) out.push_back(start);
      for (double v = 5 * std::floor((1e4 / start - 1) / 5); v > 1e4 / last_um + 1; v -= 5) out.push_back(1e4 / v);
    }
  }
  out.push_back(last_um);
  return out;
}

}  // namespace raycube::atmos
