#include "host/cli/air_table.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <tuple>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "atmos_tables/clear_sky.h"
#include "atmos_tables/clear_sky_inputs.h"
#include "atmos_tables/compiler/layered_air.h"
#include "atmos_tables/rct_file.h"
#include "host/base/cache_folder.h"
#include "host/base/doing.h"
#include "host/base/error.h"
#include "host/base/interrupt.h"
#include "host/base/progress.h"
#include "host/base/sha256.h"

namespace raycube::cli {

namespace {

std::string file_text(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Which bytes a file holds, without reading gigabytes: name, size and time of the last change.
nlohmann::json file_stamp(const std::string& path) {
  if (path.empty()) return nullptr;
  std::error_code error;
  const auto size = std::filesystem::file_size(path, error);
  const auto changed = std::filesystem::last_write_time(path, error).time_since_epoch().count();
  return {path, size, changed};
}

std::string request_hash(const AirRequest& r, const std::vector<double>& wavelengths, const std::vector<double>& heights) {
  const scene::AirSpec& air = *r.spec->layered;
  const bool own_profile = std::filesystem::path(air.profile).is_absolute();
  nlohmann::json clouds;
  for (const auto& cloud : air.clouds) clouds.push_back({cloud.kind, cloud.base_km, cloud.top_km, cloud.optical_depth_550});
  nlohmann::json cross_sections;
  for (const auto& table : air.cross_sections) cross_sections.push_back({table.gas, table.ppmv, file_stamp(table.file)});
  const nlohmann::json key = {
      base::program_hash(), r.spec->ground_height_m, r.sun.zenith_deg, r.sun.azimuth_deg, r.sun.day_of_year, r.sun.moon_phase_deg, r.sensor_height_m,
      wavelengths, heights, own_profile ? base::sha256_hex(file_text(air.profile)) : air.profile, air.pressure_hPa,
      air.water_g_cm2, air.ozone_atm_cm, air.co2_ppmv, air.ch4_ppmv, air.aerosol, air.visibility_km, air.aod_550,
      air.humidity_percent, air.season, air.stratosphere, air.henyey_greenstein, air.gas_bands, air.streams, air.k_terms,
      air.layering, air.wind_m_s, clouds, file_stamp(air.lines), air.line_wing_per_cm, file_stamp(air.partition_sums), cross_sections};
  return base::sha256_hex(key.dump());
}

atmos::RenderTable build_with_progress(const AirRequest& request, const std::vector<double>& wavelengths,
                                       const std::vector<double>& heights, Context& context) {
  base::Progress progress(context.log, "atmosphere", wavelengths.size(), "wavelengths");
  atmos::BuildWatch watch;
  watch.threads = context.common.threads;
  watch.finished = [&](std::size_t) {
    base::throw_if_interrupted();
    progress.advance();
  };
  return atmos::build_layered(*request.spec, request.sun, request.sensor_height_m, wavelengths, heights, watch);
}

}  // namespace

std::optional<atmos::RenderTable> known_table(const AirRequest& request) {
  const scene::AtmosphereSpec& spec = *request.spec;
  const auto& [first_um, last_um, step_um] = std::tie(request.first_um, request.last_um, request.step_um);
  if (!spec.table_file.empty()) return atmos::make_table(spec, request.sun, request.sensor_height_m, {}, atmos::clear_sky_heights(request.low_m, request.high_m));
  if (spec.none)
    return atmos::make_table(spec, request.sun, request.sensor_height_m, atmos::vacuum_wavelengths(first_um, last_um, step_um), {request.low_m});
  const auto heights = atmos::clear_sky_heights(request.low_m, request.high_m);
  if (spec.layered)
    atmos::check_table_request(request.sun, request.sensor_height_m, atmos::layered_wavelengths(first_um, last_um, step_um), heights,
                               atmos::kLayeredFirst_um, atmos::kLayeredLast_um);
  else
    atmos::check_clear_sky(spec, request.sun, request.sensor_height_m, atmos::clear_sky_wavelengths(first_um, last_um, step_um), heights);
  return {};
}

atmos::RenderTable air_table(const AirRequest& request, Context& context) {
  const base::Doing doing("making the table of the air");
  const scene::AtmosphereSpec& spec = *request.spec;
  if (auto known = known_table(request)) return std::move(*known);
  if (!spec.layered)
    return atmos::make_table(spec, request.sun, request.sensor_height_m,
                             atmos::clear_sky_wavelengths(request.first_um, request.last_um, request.step_um),
                             atmos::clear_sky_heights(request.low_m, request.high_m));
  const auto wavelengths = atmos::layered_wavelengths(request.first_um, request.last_um, request.step_um);
  const auto heights = atmos::clear_sky_heights(request.low_m, request.high_m);
  const std::filesystem::path folder = request.cached ? base::cache_folder("atmosphere") : std::filesystem::path();
  if (folder.empty()) return build_with_progress(request, wavelengths, heights, context);
  const std::filesystem::path file = folder / (request_hash(request, wavelengths, heights) + ".rct");
  std::error_code error;
  if (std::filesystem::exists(file, error)) {
    try {
      atmos::RenderTable table = atmos::read_rct(file.string());
      context.log.detail("atmosphere: table from the cache, " + file.string());
      return table;
    } catch (const base::Error& damaged) {
      context.log.warning(std::string(damaged.what()) + "; it is built anew");
    }
  }
  atmos::RenderTable table = build_with_progress(request, wavelengths, heights, context);
  try {
    std::filesystem::create_directories(folder);
    atmos::write_rct(table, file.string(), base::IfExists::replace);
  } catch (const std::exception& failed) {
    context.log.detail(std::string("atmosphere: the table could not be kept for the next run: ") + failed.what());
  }
  return table;
}

std::pair<double, double> band_range(const std::vector<scene::Band>& bands) {
  double first = 1e9, last = 0;
  for (const auto& band : bands) {
    const bool gaussian = band.fwhm_um > 0;
    first = std::min(first, gaussian ? band.center_um - 2.5 * band.fwhm_um : band.wavelength_um.front());
    last = std::max(last, gaussian ? band.center_um + 2.5 * band.fwhm_um : band.wavelength_um.back());
  }
  return {first, last};
}

}  // namespace raycube::cli
