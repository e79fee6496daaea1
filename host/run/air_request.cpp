#include "host/run/air_request.h"

#include <fstream>

#include <nlohmann/json.hpp>

#include "host/base/cache_folder.h"
#include "host/base/error.h"
#include "host/base/input_file.h"
#include "host/base/sha256.h"

namespace raycube::run {

namespace {

using nlohmann::json;

/// SHA-256 of what a file holds, whatever it is called; null without one.
json content_of(const std::string& path) {
  if (path.empty()) return nullptr;
  base::refuse_other_than_plain(path);
  std::ifstream file(path, std::ios::binary);
  if (!file) throw base::Error(base::Fault::environment, path + ": cannot be read; check the name and its permissions");
  base::Sha256 hash;
  std::vector<char> block(std::size_t{1} << 20);
  while (file.read(block.data(), static_cast<std::streamsize>(block.size())) || file.gcount() > 0)
    hash.add(block.data(), static_cast<std::size_t>(file.gcount()));
  return hash.hex();
}

template <class Value>
json key_of(const Value& value) {
  return value;
}

json key_of(const scene::CloudSpec& cloud) {
  json out;
#define RC_CLOUD(type, name, fallback, text) out[#name] = cloud.name;
#include "scene_compiler/air_spec.def"
  return out;
}

json key_of(const scene::CrossSectionSpec& table) {
  json out;
#define RC_CROSS_SECTION(type, name, fallback, text) out[#name] = table.name;
#define RC_CROSS_SECTION_FILE(name, text) out[#name] = content_of(table.name);
#include "scene_compiler/air_spec.def"
  return out;
}

json key_of(const scene::OwnAerosolSpec& aerosol) {
  json out;
#define RC_OWN_AEROSOL(type, name, fallback, text) out[#name] = aerosol.name;
#include "scene_compiler/air_spec.def"
  return out;
}

template <class Entry>
json key_of(const std::vector<Entry>& list) {
  json out = json::array();
  for (const Entry& entry : list) out.push_back(key_of(entry));
  return out;
}

json key_of(const scene::AirSpec& air) {
  json out;
#define RC_AIR(type, name, fallback, text) out[#name] = key_of(air.name);
#define RC_AIR_FILE(name, text) out[#name] = content_of(air.name);
#include "scene_compiler/air_spec.def"
  return out;
}

/// Of a file what it holds, whatever it is called.
json key_of(const scene::SolarSpectrumSpec& solar) {
  if (solar.wavelength_um.empty()) return solar.name;
  return {solar.wavelength_um, solar.irradiance};
}

/// Of the clear sky: what it reads of a specification.
json clear_sky_key(const scene::AtmosphereSpec& spec) {
  return {spec.pressure_hPa, spec.water_g_cm2, spec.ozone_atm_cm, spec.aod_550,
          spec.angstrom,     spec.ssa,         spec.asymmetry,    spec.ground_albedo};
}

}  // namespace

std::string request_hash(const AirRequest& request, const std::vector<double>& wavelength_um,
                         const std::vector<double>& target_height_m) {
  const scene::Sun& sun = request.sun;
  const json key = {{"program", base::program_hash()},
                    {"air", request.spec->layered ? key_of(*request.spec->layered) : clear_sky_key(*request.spec)},
                    {"ground_height_m", request.spec->ground_height_m},
                    {"solar_spectrum", key_of(request.spec->solar)},
                    {"view_zenith_deg", request.spec->view_zenith_deg},
                    {"sun", {sun.zenith_deg, sun.azimuth_deg, sun.day_of_year, sun.moon_phase_deg}},
                    {"sensor_height_m", request.sensor_height_m},
                    {"wavelength_um", wavelength_um},
                    {"target_height_m", target_height_m}};
  return base::sha256_hex(key.dump(-1, ' ', false, json::error_handler_t::replace));
}

}  // namespace raycube::run
