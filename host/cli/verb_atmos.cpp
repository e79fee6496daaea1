// raycube atmos build | info: render tables made and described. The other verbs have files of their own.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <ostream>
#include <tuple>

#include <nlohmann/json.hpp>

#include "atmos_tables/clear_sky_inputs.h"
#include "atmos_tables/rct_file.h"
#include "atmos_tables/report.h"
#include "atmos_tables/solar_spectrum.h"
#include "host/base/error.h"
#include "host/base/output_file.h"
#include "host/cli/air_options.h"
#include "host/run/air_table.h"
#include "host/run/air_limits.h"
#include "host/cli/atmos_compare.h"
#include "host/cli/atmos_export.h"
#include "host/cli/atmos_import.h"
#include "host/cli/atmos_lidar.h"
#include "host/cli/atmos_plot.h"
#include "host/cli/services.h"
#include "host/cli/verb.h"
#include "scene_compiler/load_simulation.h"
#include "scene_compiler/solar_file.h"
#include "host/cli/typed.h"

namespace raycube::cli {

namespace {

struct BuildOptions {
  std::string file, model, lines, solar;
  std::vector<std::string> view_zeniths;
  AirOptions air;
  bool no_air = false, no_cache = false;
  double co2 = kUnset, ch4 = kUnset;
  double sun_zenith = kUnset, sun_azimuth = kUnset, day = kUnset;
  double sensor = kUnset, lowest = kUnset, highest = kUnset;
  double first_um = kUnset, last_um = kUnset, step_nm = 0;
  double ground = kUnset, pressure = kUnset, water = kUnset, ozone = kUnset, angstrom = kUnset;
  double ssa = kUnset, asymmetry = kUnset, albedo = kUnset, scale_height = kUnset;
};

/// An option that would shape air, as typed; empty: none.
std::string typed_air(const BuildOptions& o) {
  const std::pair<bool, const char*> given[] = {{!o.model.empty(), "--model"},
                                                {!o.air.profile.empty(), "--profile"},
                                                {!o.air.fill.empty(), "--fill"},
                                                {!o.air.aerosol.empty(), "--aerosol"},
                                                {!std::isnan(o.air.visibility_km), "--visibility"},
                                                {!std::isnan(o.air.aod_550), "--aod"},
                                                {!std::isnan(o.air.humidity_percent), "--humidity"},
                                                {!o.lines.empty(), "--lines"},
                                                {!std::isnan(o.co2), "--co2"},
                                                {!std::isnan(o.ch4), "--ch4"},
                                                {!std::isnan(o.pressure), "--pressure"},
                                                {!std::isnan(o.water), "--water"},
                                                {!std::isnan(o.ozone), "--ozone"},
                                                {!std::isnan(o.angstrom), "--angstrom"},
                                                {!std::isnan(o.ssa), "--ssa"},
                                                {!std::isnan(o.asymmetry), "--asymmetry"},
                                                {!std::isnan(o.albedo), "--ground-albedo"},
                                                {!std::isnan(o.scale_height), "--scale-height"},
                                                {!o.view_zeniths.empty(), "--view-zenith"}};
  for (const auto& [is, option] : given)
    if (is) return option;
  return "";
}

/// --aerosol own: Henyey-Greenstein particles in place of every aerosol of the file.
scene::OwnAerosolSpec typed_aerosol(const BuildOptions& o) {
  if (std::isnan(o.air.aod_550))
    throw base::Error(base::Fault::input, "--aerosol own: how much of it? give --aod, its optical depth at 0.55 um");
  for (const auto& [value, option] :
       {std::pair(o.air.visibility_km, "--visibility"), std::pair(o.air.humidity_percent, "--humidity")})
    if (!std::isnan(value))
      throw base::Error(base::Fault::input,
                        std::string(option) + " is for a shipped aerosol, not for --aerosol own; remove it");
  const scene::AtmosphereSpec standing;  // the clear sky's particles
  scene::OwnAerosolSpec out;
  out.optical_depth = o.air.aod_550;
  out.angstrom = standing.angstrom, out.single_scattering_albedo = {standing.ssa}, out.asymmetry = {standing.asymmetry};
  replace(out.angstrom, o.angstrom), replace(out.scale_height_km, o.scale_height);
  replace(out.single_scattering_albedo[0], o.ssa), replace(out.asymmetry[0], o.asymmetry);
  return out;
}

/// Options of one model alone are refused with the other, all of them without air; the shared ones go where
/// the model reads them. A file's air comes as that of --model already (LoadOptions::air_model).
void choose_model(const BuildOptions& o, scene::AtmosphereSpec& air) {
  if (air.none) {
    if (const std::string option = typed_air(o); !option.empty())
      throw base::Error(base::Fault::input, option + " means nothing without air (" +
                                                (o.no_air ? "--no-air" : "the file has model = \"none\"") +
                                                "); remove it" + (o.no_air ? "" : ", or choose a --model"));
    air.layered.reset();
    return;
  }
  const bool layered = o.file.empty() ? o.model != "clear_sky" : air.layered.has_value();
  const auto refuse = [&](bool given, const char* option, const char* model) {
    if (given)
      throw base::Error(base::Fault::input,
                        std::string(option) + " belongs to --model " + model + "; remove it, or choose that");
  };
  if (!layered) {
    refuse(!o.air.profile.empty(), "--profile", "layered"), refuse(!o.air.fill.empty(), "--fill", "layered");
    refuse(!o.air.aerosol.empty(), "--aerosol", "layered"), refuse(!o.lines.empty(), "--lines", "layered");
    refuse(!std::isnan(o.air.visibility_km), "--visibility", "layered"),
        refuse(!std::isnan(o.air.humidity_percent), "--humidity", "layered");
    refuse(!std::isnan(o.co2), "--co2", "layered"), refuse(!std::isnan(o.ch4), "--ch4", "layered");
    refuse(!std::isnan(o.scale_height), "--scale-height", "layered");
    return;
  }
  const bool own = o.air.aerosol == "own";
  for (const auto& [value, option] :
       {std::pair(o.angstrom, "--angstrom"), std::pair(o.ssa, "--ssa"), std::pair(o.asymmetry, "--asymmetry")})
    refuse(!own && !std::isnan(value), option, "clear_sky, or to --aerosol own");
  if (!own && !std::isnan(o.scale_height))
    throw base::Error(base::Fault::input, "--scale-height belongs to --aerosol own; remove it, or choose that aerosol");
  refuse(!std::isnan(o.albedo), "--ground-albedo", "clear_sky");
  if (!air.layered) air.layered.emplace();
  scene::AirSpec& spec = *air.layered;
  AirOptions typed = o.air;
  std::vector<scene::OwnAerosolSpec> owned;
  if (own) owned = {typed_aerosol(o)}, typed.aerosol = "none", typed.aod_550 = kUnset;
  apply(typed, spec);
  if (own) spec.own_aerosols = std::move(owned);
  if (!o.lines.empty()) spec.lines = std::filesystem::absolute(o.lines).lexically_normal().string();
  replace(spec.pressure_hPa, o.pressure), replace(spec.water_g_cm2, o.water), replace(spec.ozone_atm_cm, o.ozone);
  replace(spec.co2_ppmv, o.co2), replace(spec.ch4_ppmv, o.ch4);
}

/// --solar-spectrum: a name, or else a file.
scene::SolarSpectrumSpec typed_solar(const std::string& name) {
  if (atmos::SolarSpectrum::is_shipped(name)) return {name, {}, {}};
  base::Problems problems;
  const auto file = scene::read_solar_spectrum(name, {"", 0, 0, "--solar-spectrum"}, problems);
  problems.throw_if_any();
  return *file;
}

int build(const BuildOptions& o, Invocation& invocation) {
  scene::Simulation simulation;
  double sensor_height = 610, lowest = 0, highest = 100, first_um = 0.35, last_um = 2.5;
  if (!o.file.empty()) {
    scene::LoadOptions load;
    load.need_instruments = true;
    if (!o.no_air) load.air_model = o.model;
    load.compile = std::isnan(o.lowest) || std::isnan(o.highest);
    simulation = scene::load_simulation(o.file, load);
    if (simulation.instruments.empty())
      throw base::Error(base::Fault::input,
                        o.file + ": no [[instrument]] whose bands a table could cover; a [[lidar]] needs none");
    if (load.compile) lowest = simulation.scene.lo[2], highest = simulation.scene.hi[2];
    sensor_height = simulation.instruments.front().poses.front().z_m;
  } else if (std::isnan(o.sun_zenith)) {
    throw base::Error(base::Fault::input, "where is the sun? give a scene FILE, or --sun-zenith in degrees");
  }
  if (!simulation.atmosphere.table_file.empty())
    throw base::Error(base::Fault::input, o.file + ": names a table already (" + simulation.atmosphere.table_file +
                                              "); see it with raycube atmos info");
  scene::AtmosphereSpec& air = simulation.atmosphere;
  if (o.no_air) air.none = true;
  choose_model(o, air);
  if (!std::isnan(o.ground)) {
    air.ground_height_m = o.ground;
    if (std::isnan(o.pressure)) {
      air.pressure_hPa = scene::standard_pressure_hPa(o.ground);
      if (air.layered) air.layered->pressure_hPa = scene::AirSpec().pressure_hPa;  // the profile's, there
    }
  }
  replace(air.pressure_hPa, o.pressure), replace(air.water_g_cm2, o.water), replace(air.ozone_atm_cm, o.ozone);
  replace(air.aod_550, o.air.aod_550), replace(air.angstrom, o.angstrom), replace(air.ssa, o.ssa);
  replace(air.asymmetry, o.asymmetry), replace(air.ground_albedo, o.albedo);
  if (!o.solar.empty()) air.solar = typed_solar(o.solar);
  if (!o.view_zeniths.empty()) air.view_zenith_deg = numbers_of(o.view_zeniths, "--view-zenith");
  replace(simulation.sun.zenith_deg, o.sun_zenith), replace(simulation.sun.azimuth_deg, o.sun_azimuth);
  if (!std::isnan(o.day)) simulation.sun.day_of_year = static_cast<int>(o.day);
  run::keep_within_air(simulation);  // as a scene that names the table will be
  std::vector<scene::Band> bands;
  for (const auto& instrument : simulation.instruments)
    bands.insert(bands.end(), instrument.bands.begin(), instrument.bands.end());
  if (!bands.empty()) std::tie(first_um, last_um) = run::band_range(bands);
  replace(sensor_height, o.sensor), replace(lowest, o.lowest), replace(highest, o.highest);
  // Rays look down: what towers over the sensor is no target.
  if (std::isnan(o.highest)) highest = std::max(lowest, std::min(highest, sensor_height));
  replace(first_um, o.first_um), replace(last_um, o.last_um);
  if (lowest > highest)
    throw base::Error(base::Fault::input, "--lowest (" + std::to_string(lowest) + " m) is above --highest (" +
                                              std::to_string(highest) + " m)");
  const double step_um = o.step_nm > 0 || !air.layered ? o.step_nm / 1000 : air.layered->spectral_step_um;
  const std::string output = invocation.common.output.empty() ? "atmosphere.rct" : invocation.common.output;
  // A name that is taken or a folder that cannot be written is known before the work begins.
  { const base::OutputFile probe(output, if_exists(invocation.common)); }
  for (const std::string& notice : simulation.notices) invocation.log.warning(notice);
  run::Services services = services_of(invocation);
  const atmos::RenderTable table = run::air_table(
      {&air, simulation.sun, sensor_height, first_um, last_um, step_um, lowest, highest, !o.no_cache}, services);
  if (const auto notice = atmos::no_light_notice(air, simulation.sun, first_um)) invocation.log.warning(*notice);
  for (const scene::Instrument& instrument : simulation.instruments)
    if (const auto notice = run::coarse_sun_notice(air, instrument.bands))
      invocation.log.warning(instrument.name + ": " + *notice);
  const std::string hash = atmos::write_rct(table, output, if_exists(invocation.common));
  if (invocation.common.json)
    invocation.out << nlohmann::json{{"table", output},
                                     {"content_hash", hash},
                                     {"atmosphere", nlohmann::json::parse(table.provenance_json)}}
                          .dump()
                   << "\n";
  else
    invocation.out << "table: " << output << "\n" << run::aerosol_text(table);
  return 0;
}

Verb verb_atmos_build() {
  auto o = std::make_shared<BuildOptions>();
  Verb verb("build", "Build a render table with a built-in model of the air");
  verb.description =
      "Sun, air, heights, bands and sensor come from a scene FILE, or from options, which replace what the "
      "file says; a --model that is not the file's takes over what both have (pressure, columns, AOD), and a "
      "key of the file that it has not is refused. The layered "
      "model covers 0.3 to 30 um (profiles, gas bands, aerosols, multiple scattering), the clear-sky model 0.3 to 4 um "
      "by a few "
      "formulas; docs/atmosphere.md and docs/table_format.md say how good they are. Tables of the layered model are "
      "kept in "
      "~/.cache/raycube/atmosphere and read again when the same one is asked for.";
  verb.examples = {"raycube atmos build scenes/park/park.toml -o park.rct",
                   "raycube atmos build --sun-zenith 40 --visibility 10 --sensor-height 3000 -o hazy.rct",
                   "raycube atmos build --model clear_sky --sun-zenith 40 --aod 0.2 -o quick.rct"};
  verb.common = kOutput | kThreads;
  verb.add_options = [o](base::OptionTable& table) {
    const auto number = [&](const char* names, const char* unit, double low, double high, const char* help,
                            double& value, const char* standing) {
      table.number(names, unit, low, high, help, value).default_text = standing;
    };
    table.optional_argument("FILE", "A scene file", o->file);
    number("--sun-zenith", "deg", 0, 180, "Sun zenith angle", o->sun_zenith, "FILE's");
    number("--sun-azimuth", "deg", -360, 360, "Sun azimuth, clockwise from north", o->sun_azimuth, "FILE's, or 0");
    number("--day", "", 0, 366, "Day of the year for the earth-sun distance; 0: mean distance", o->day, "FILE's, or 0");
    number("--sensor-height", "m", -1000, 1e9, "Sensor height above the scene's z = 0", o->sensor,
           "FILE's first pose, or 610");
    number("--lowest", "m", -1000, 1e5, "Lowest target height", o->lowest, "FILE's scene, or 0");
    number("--highest", "m", -1000, 1e5, "Highest target height", o->highest, "FILE's scene, or 100");
    number("--from", "um", 0.3, 30, "First wavelength", o->first_um, "FILE's bands, or 0.35");
    number("--to", "um", 0.3, 30, "Last wavelength", o->last_um, "FILE's bands, or 2.5");
    table.number("--step", "nm", 0, 100, "Wavelength step; 0: 1 nm to 1 um, 2 nm to 2.5 um, 10 nm beyond", o->step_nm);
    table
        .texts("--view-zenith", "DEG",
               "View zenith angles of the table, deg, separated by commas: two or more from 0 to 89.9", o->view_zeniths)
        .default_text = "FILE's, or 0 to 80, 5 apart from 30 on (layered) or 10 apart (clear_sky)";
    table
        .text("--solar-spectrum", "NAME|FILE",
              "Sun above the air: tsis1, e490, or a CSV whose columns' names hold the units (docs/atmosphere.md)",
              o->solar)
        .default_text = "FILE's, or tsis1";
    number("--ground-height", "m", -500, 9000, "Height of z = 0 above the sea; sets the pressure too", o->ground,
           "FILE's, or 0");
    number("--pressure", "hPa", 1, 1200, "Air pressure at the ground", o->pressure, "FILE's, or 1013.25");
    number("--water", "g/cm2", 0, 10, "Precipitable water", o->water, "FILE's, or 1.5");
    number("--ozone", "atm cm", 0, 1, "Ozone column", o->ozone, "FILE's, or 0.32");
    number("--angstrom", "", -1, 5, "clear_sky, or --aerosol own: Angstrom exponent", o->angstrom, "FILE's, or 1.2");
    number("--ssa", "", 0, 1, "clear_sky: aerosol single-scattering albedo at 0.4 um; --aerosol own: at all", o->ssa,
           "FILE's, or 0.945");
    number("--asymmetry", "", -0.95, 0.95, "clear_sky, or --aerosol own: asymmetry factor", o->asymmetry,
           "FILE's, or 0.65");
    number("--scale-height", "km", 0.01, 100, "layered, --aerosol own: height over which extinction falls by e",
           o->scale_height, "2");
    number("--ground-albedo", "", 0, 1, "Albedo of the surroundings in the sky's light", o->albedo, "FILE's, or 0");
    table.choice("--model", {"layered", "clear_sky"}, "Model of the air", o->model).default_text = "FILE's, or layered";
    add_air_options(table, o->air, "FILE's, or by --visibility (layered), 0.1 (clear_sky)");
    for (base::Option& option : table.rows())
      if (option.names == "--aerosol")
        option.help += "; or own: by --aod, --angstrom, --ssa, --asymmetry and --scale-height, Henyey-Greenstein";
    table
        .text("--lines", "FILE", "layered: HITRAN line list (.par); its gases are resolved at the table's wavelengths",
              o->lines)
        .default_text = "FILE's, or none";
    number("--co2", "ppmv", 0, 1e4, "layered: carbon dioxide", o->co2, "FILE's, or the profile's 330");
    number("--ch4", "ppmv", 0, 1000, "layered: methane", o->ch4, "FILE's, or the profile's");
    table.flag("--no-cache", "Neither read nor keep a table of the layered model", o->no_cache);
    table.flag("--no-air", "Vacuum: transmission 1, no sky, no path radiance", o->no_air);
  };
  verb.run = [o](Invocation& invocation) { return build(*o, invocation); };
  return verb;
}

Verb verb_atmos_info() {
  auto file = std::make_shared<std::string>();
  Verb verb("info", "Describe a render table: axes, rows, absent rows, provenance, stated errors");
  verb.add_options = [file](base::OptionTable& table) { table.argument("FILE", "A render table (.rct)", *file); };
  verb.run = [file](Invocation& invocation) {
    const atmos::RenderTable table = atmos::read_rct(*file);
    const std::string hash = atmos::content_hash(table);
    invocation.out << (invocation.common.json ? atmos::table_json(table, hash) : atmos::table_text(table, hash));
    return 0;
  };
  return verb;
}

}  // namespace

Verb verb_atmos() {
  Verb verb("atmos", "Build, describe, draw and compare render tables of the air; read what other codes wrote");
  verb.verbs = {verb_atmos_build(),  verb_atmos_info(),    verb_atmos_plot(), verb_atmos_export(),
                verb_atmos_import(), verb_atmos_compare(), verb_atmos_lidar()};
  return verb;
}

}  // namespace raycube::cli
