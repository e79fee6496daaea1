#include "host/run/air_table.h"

#include <algorithm>
#include <filesystem>
#include <tuple>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "atmos_tables/clear_sky.h"
#include "atmos_tables/clear_sky_inputs.h"
#include "atmos_tables/compiler/layered_air.h"
#include "atmos_tables/rct_file.h"
#include "atmos_tables/solar_spectrum.h"
#include "host/base/cache_folder.h"
#include "host/base/doing.h"
#include "host/base/error.h"
#include "host/plan/quadrature.h"

namespace raycube::run {

namespace {

nlohmann::json provenance_of(const atmos::RenderTable& table) {
  return table.provenance_json.empty() ? nlohmann::json() : nlohmann::json::parse(table.provenance_json);
}

atmos::RenderTable build_with_progress(const AirRequest& request, const std::vector<double>& wavelengths,
                                       const std::vector<double>& heights, Services& services) {
  const Step progress(services, "atmosphere", wavelengths.size(), "wavelengths");
  atmos::BuildWatch watch;
  watch.threads = services.threads;
  watch.finished = [&](std::size_t) { progress.advance(); };
  return atmos::build_layered(*request.spec, request.sun, request.sensor_height_m, wavelengths, heights, watch);
}

/// Where the cache keeps the table of a request; empty: nowhere. Throws Error(environment) when a file that the
/// request names cannot be read.
std::filesystem::path kept_file(const AirRequest& request, const std::vector<double>& wavelengths,
                                const std::vector<double>& heights) {
  const std::filesystem::path folder = request.cached ? base::cache_folder("atmosphere") : std::filesystem::path();
  return folder.empty() ? folder : folder / (request_hash(request, wavelengths, heights) + ".rct");
}

/// A table of lines that is kept was sound: long lists are not read again to say so.
bool lines_are_kept(const AirRequest& request, const std::vector<double>& wavelengths,
                    const std::vector<double>& heights) {
  if (request.spec->layered->lines.empty()) return false;
  try {
    std::error_code none;
    return std::filesystem::exists(kept_file(request, wavelengths, heights), none);
  } catch (const base::Error&) {  // who reads the list says what is wrong with it
    return false;
  }
}

}  // namespace

std::optional<atmos::RenderTable> known_table(const AirRequest& request) {
  const scene::AtmosphereSpec& spec = *request.spec;
  const auto& [first_um, last_um, step_um] = std::tie(request.first_um, request.last_um, request.step_um);
  if (!spec.table_file.empty())
    return atmos::make_table(spec, request.sun, request.sensor_height_m, {},
                             atmos::clear_sky_heights(request.low_m, request.high_m));
  if (spec.none)
    return atmos::make_table(spec, request.sun, request.sensor_height_m,
                             atmos::vacuum_wavelengths(first_um, last_um, step_um), {request.low_m});
  const auto heights = atmos::clear_sky_heights(request.low_m, request.high_m);
  if (spec.layered) {
    const auto wavelengths = atmos::layered_wavelengths(first_um, last_um, step_um);
    if (!lines_are_kept(request, wavelengths, heights))
      atmos::check_layered(spec, request.sun, request.sensor_height_m, wavelengths, heights);
  } else {
    atmos::check_clear_sky(spec, request.sun, request.sensor_height_m,
                           atmos::clear_sky_wavelengths(first_um, last_um, step_um), heights);
  }
  return {};
}

namespace {

/// Built without a look at the cache.
atmos::RenderTable built_table(const AirRequest& request, const std::vector<double>& wavelengths,
                               const std::vector<double>& heights, Services& services) {
  if (request.spec->layered) return build_with_progress(request, wavelengths, heights, services);
  return atmos::make_table(*request.spec, request.sun, request.sensor_height_m, wavelengths, heights);
}

/// The cache's, if it has it whole.
std::optional<atmos::RenderTable> kept_table(const std::filesystem::path& file, Services& services) {
  std::error_code error;
  if (!std::filesystem::exists(file, error)) return {};
  try {
    atmos::RenderTable table = atmos::read_rct(file.string());
    services.log.detail("atmosphere: table from the cache, " + file.string());
    return table;
  } catch (const base::Error& damaged) {
    services.log.warning(std::string(damaged.what()) + "; it is built anew");
    return {};
  }
}

/// Read, built, or taken from the cache.
atmos::RenderTable made_table(const AirRequest& request, Services& services) {
  const scene::AtmosphereSpec& spec = *request.spec;
  if (spec.none || !spec.table_file.empty()) return std::move(*known_table(request));
  const auto wavelengths = spec.layered
                               ? atmos::layered_wavelengths(request.first_um, request.last_um, request.step_um)
                               : atmos::clear_sky_wavelengths(request.first_um, request.last_um, request.step_um);
  const auto heights = atmos::clear_sky_heights(request.low_m, request.high_m);
  if (!spec.layered) static_cast<void>(known_table(request));  // refuses what the model cannot have
  const std::filesystem::path file = kept_file(request, wavelengths, heights);
  if (file.empty()) return built_table(request, wavelengths, heights, services);
  if (auto kept = kept_table(file, services)) return std::move(*kept);
  atmos::RenderTable table = built_table(request, wavelengths, heights, services);
  try {
    std::filesystem::create_directories(file.parent_path());
    atmos::write_rct(table, file.string(), base::IfExists::replace);
  } catch (const std::exception& failed) {
    services.log.detail(std::string("atmosphere: the table could not be kept for the next run: ") + failed.what());
  }
  return table;
}

}  // namespace

std::optional<atmos::RenderTable> quick_table(const AirRequest& request) {
  if (auto known = known_table(request)) return known;
  const scene::AtmosphereSpec& spec = *request.spec;
  const auto heights = atmos::clear_sky_heights(request.low_m, request.high_m);
  if (!spec.layered)
    return atmos::make_table(spec, request.sun, request.sensor_height_m,
                             atmos::clear_sky_wavelengths(request.first_um, request.last_um, request.step_um), heights);
  const auto wavelengths = atmos::layered_wavelengths(request.first_um, request.last_um, request.step_um);
  try {
    const std::filesystem::path file = kept_file(request, wavelengths, heights);
    std::error_code none;
    if (!file.empty() && std::filesystem::exists(file, none)) return atmos::read_rct(file.string());
  } catch (const base::Error&) {  // whoever computes the table says that what is kept is damaged
  }
  return {};
}

atmos::RenderTable air_table(const AirRequest& request, Services& services) {
  const base::Doing doing("making the table of the air");
  atmos::RenderTable table = made_table(request, services);
  if (!request.spec->table_file.empty()) return table;  // its notices were said when it was made
  say_air(table, services);
  return table;
}

std::vector<std::string> air_notices(const atmos::RenderTable& table) {
  const auto provenance = provenance_of(table);
  if (!provenance.contains("notices")) return {};
  return provenance["notices"].get<std::vector<std::string>>();
}

void say_air(const atmos::RenderTable& table, Services& services) {
  for (const auto& notice : air_notices(table)) services.warn_once(notice);
  if (const std::string aerosol = aerosol_text(table); !aerosol.empty())
    services.log.detail("atmosphere: " + aerosol.substr(0, aerosol.size() - 1));
}

namespace {

/// The shipped aerosol and the user's own, of a table's parameters.
std::string aerosol_names(const nlohmann::json& parameters) {
  std::string out = parameters["aerosol"].get<std::string>();
  const auto own = parameters.value("own_aerosols", nlohmann::json::array());
  if (out == "none" && !own.empty()) out.clear();
  for (const auto& aerosol : own) out += (out.empty() ? "" : ", ") + aerosol["name"].get<std::string>();
  return out;
}

}  // namespace

std::string aerosol_text(const atmos::RenderTable& table) {
  const auto provenance = provenance_of(table);
  if (!provenance.contains("parameters") || !provenance["parameters"].contains("aod_550")) return "";
  const auto& p = provenance["parameters"];
  if (p.value("aod_550_from", "") == "no aerosol") return "aerosol: none\n";
  std::string out = fmt::format("aerosol: optical depth {:.4g} at 550 nm", p["aod_550"].get<double>());
  if (p.contains("aerosol")) out += " (" + aerosol_names(p);
  if (p.contains("aerosol") && p["visibility_km"].is_number())
    out += fmt::format(", visibility {:.3g} km", p["visibility_km"].get<double>());
  return out + (p.contains("aerosol") ? ")\n" : "\n");
}

namespace {

/// Beyond this the sun's lines are few, weak and far narrower than any band of the reflected light there.
constexpr double kSunLinesTo_um = 2.5;

/// FWHM, or the area of a tabulated response over its peak.
double width_um(const scene::Band& band) {
  if (band.fwhm_um > 0) return band.fwhm_um;
  double area = 0;
  for (std::size_t i = 1; i < band.wavelength_um.size(); ++i)
    area += 0.5 * (band.response[i] + band.response[i - 1]) * (band.wavelength_um[i] - band.wavelength_um[i - 1]);
  return area / *std::max_element(band.response.begin(), band.response.end());
}

}  // namespace

std::optional<std::string> coarse_sun_notice(const scene::AtmosphereSpec& spec, const std::vector<scene::Band>& bands) {
  if (!spec.table_file.empty()) return std::nullopt;
  const atmos::SolarSpectrum sun(spec.solar);
  std::size_t finer = 0;
  double narrowest_um = 1e9, at_um = 0;
  for (const scene::Band& band : bands) {
    const double width = width_um(band);
    if (!(band.center_um < kSunLinesTo_um) || !(width < (1 - 1e-6) * sun.step_um(band.center_um))) continue;
    if (sun.straight(band.center_um)) continue;
    ++finer;
    if (width < narrowest_um) narrowest_um = width, at_um = band.center_um;
  }
  if (finer == 0) return std::nullopt;
  return fmt::format(
      "{} of its bands, the narrowest {:.3g} nm wide at {:.6g} nm, {} finer than the sun's spectrum, whose steps there "
      "are {:.3g} nm: its lines are smoothed; name a finer one in solar_spectrum_file",
      finer, 1000 * narrowest_um, 1000 * at_um, finer == 1 ? "is" : "are", 1000 * sun.step_um(at_um));
}

std::pair<double, double> band_range(const std::vector<scene::Band>& bands) {
  double first = 1e9, last = 0;
  for (const auto& band : bands) {
    const auto [from, to] = plan::band_support(band);
    first = std::min(first, from), last = std::max(last, to);
  }
  return {first, last};
}

}  // namespace raycube::run
