#include "scene_compiler/load_simulation.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "scene_compiler/budget_builder.h"
#include "scene_compiler/csv_file.h"
#include "scene_compiler/document.h"
#include "scene_compiler/document_values.h"
#include "scene_compiler/ground.h"
#include "scene_compiler/instrument_builder.h"
#include "scene_compiler/lamp_builder.h"
#include "scene_compiler/lidar_builder.h"
#include "scene_compiler/measure_builder.h"
#include "scene_compiler/own_aerosol_builder.h"
#include "scene_compiler/placed_box.h"
#include "scene_compiler/scene_builder.h"
#include "scene_compiler/solar_file.h"
#include "scene_compiler/sun_position.h"

namespace raycube::scene {
namespace {

using base::Problems;

constexpr const char* kLayeredKeys[] = {
    "profile", "profile_file", "co2_ppmv",         "ch4_ppmv", "aerosol",       "visibility_km",  "humidity_percent",
    "season",  "stratosphere", "wind_m_s",         "cloud",    "own_aerosol",   "gas_bands",      "streams",
    "k_terms", "layering",     "spectral_step_nm", "lines",    "line_wing_cm1", "partition_sums", "cross_section"};
/// Of both models; pressure_hPa and ground_height_m say where the ground lies, with a table too.
constexpr const char* kColumnKeys[] = {"water_g_cm2", "ozone_atm_cm", "aod_550"};
constexpr const char* kClearSkyKeys[] = {"angstrom", "ssa", "asymmetry", "ground_albedo"};

/// A key that the chosen model would ignore is an error. `asked`: the model that the caller wants instead of
/// the file's, or empty.
template <std::size_t N>
void refuse_keys(const Record& record, const char* const (&keys)[N], const char* model, const std::string& asked,
                 Problems& problems) {
  const std::string instead = asked.empty() ? "" : ", and " + asked + " is asked for instead";
  for (const char* key : keys)
    if (record.given(key))
      problems.add(record.place(key), std::string("'") + key + "' belongs to model = \"" + model + "\"" + instead,
                   value_text(record, key), "remove it, or choose that model");
}

/// What says how much aerosol there is, or of what kind, says nothing of none, nor of the user's own. A depth of 0 is
/// no contradiction.
void refuse_amounts_of_none(const Record& record, Problems& problems) {
  const bool own = !record.records("own_aerosol").empty();
  for (const char* key : {"aod_550", "visibility_km", "humidity_percent", "season", "stratosphere", "wind_m_s"})
    if (record.given(key) && !(std::string(key) == "aod_550" && record.number(key) == 0))
      problems.add(
          record.place(key),
          std::string("'") + key +
              (own ? "' belongs to a shipped aerosol, and there are those of [[atmosphere.own_aerosol]] alone"
                   : "' belongs to an aerosol, and aerosol = \"none\" holds none at any height"),
          "", own ? "remove it (each has its own optical_depth), or name an aerosol" : "remove it, or name an aerosol");
}

AirSpec read_layered(const Record& record, Problems& problems) {
  AirSpec air;
  const auto number = [&](const char* key, double& value) {
    if (record.given(key)) value = record.number(key);
  };
  air.profile = record.text("profile");
  if (record.given("profile_file")) {
    air.profile_file = std::filesystem::absolute(record.text("profile_file")).lexically_normal().string();
    check_readable(record.text("profile_file"), record.place("profile_file"), problems);
  }
  number("pressure_hPa", air.pressure_hPa), number("water_g_cm2", air.water_g_cm2),
      number("ozone_atm_cm", air.ozone_atm_cm);
  number("co2_ppmv", air.co2_ppmv), number("ch4_ppmv", air.ch4_ppmv), number("aod_550", air.aod_550);
  number("humidity_percent", air.humidity_percent);
  if (record.given("aod_550") && record.given("visibility_km"))
    problems.add(record.place("aod_550"), "'aod_550' and 'visibility_km' exclude each other", "both", "remove one");
  air.visibility_km = record.number("visibility_km");
  air.own_aerosols = read_own_aerosols(record, problems);
  // A user's own are all there are, unless one of the shipped is named too.
  air.aerosol = !air.own_aerosols.empty() && !record.given("aerosol") ? "none" : record.text("aerosol");
  if (air.aerosol == "none") refuse_amounts_of_none(record, problems);
  if (air.aerosol != "none" && air.aerosol != "desert" && record.given("wind_m_s"))
    problems.add(record.place("wind_m_s"), "'wind_m_s' raises the desert aerosol alone",
                 "aerosol = \"" + air.aerosol + "\"", "remove it, or choose that aerosol");
  air.season = record.text("season");
  air.stratosphere = record.text("stratosphere");
  air.wind_m_s = record.number("wind_m_s");
  for (const Record& cloud : record.records("cloud")) {
    air.clouds.push_back(
        {cloud.text("kind"), cloud.number("base_km"), cloud.number("top_km"), cloud.number("optical_depth_550")});
    if (!(air.clouds.back().base_km < air.clouds.back().top_km))
      problems.add(cloud.place("top_km"), "a cloud's top must lie above its base",
                   std::to_string(air.clouds.back().top_km) + " km", "swap or correct them");
  }
  air.gas_bands = record.text("gas_bands");
  air.streams = static_cast<int>(record.integer("streams"));
  air.k_terms = static_cast<int>(record.integer("k_terms"));
  air.layering = static_cast<int>(record.integer("layering"));
  air.spectral_step_um = record.number("spectral_step_nm") / 1000;
  const auto path = [&](const Record& where, const char* key, std::string& value) {
    if (!where.given(key)) return;
    value = std::filesystem::absolute(where.text(key)).lexically_normal().string();
    check_readable(where.text(key), where.place(key), problems);
  };
  path(record, "lines", air.lines), path(record, "partition_sums", air.partition_sums);
  air.line_wing_per_cm = record.number("line_wing_cm1");
  for (const char* key : {"line_wing_cm1", "partition_sums"})
    if (record.given(key) && air.lines.empty())
      problems.add(record.place(key), std::string("'") + key + "' is for 'lines'", "no lines",
                   "add the list or remove it");
  for (const Record& table : record.records("cross_section")) {
    scene::CrossSectionSpec& one = air.cross_sections.emplace_back();
    one.gas = table.text("gas");
    path(table, "file", one.file);
    if (table.given("mixing_ratio_ppmv")) one.ppmv = table.number("mixing_ratio_ppmv");
  }
  if (air.streams % 2 != 0)
    problems.add(record.place("streams"), "the number of streams must be even", std::to_string(air.streams),
                 "take the next one");
  return air;
}

SolarSpectrumSpec read_solar(const Record& record, Problems& problems) {
  SolarSpectrumSpec out;
  out.name = record.text("solar_spectrum");
  if (!record.given("solar_spectrum_file")) return out;
  if (record.given("solar_spectrum"))
    problems.add(record.place("solar_spectrum"), "'solar_spectrum' and 'solar_spectrum_file' exclude each other",
                 "both", "remove one");
  const auto file =
      read_solar_spectrum(record.text("solar_spectrum_file"), record.place("solar_spectrum_file"), problems);
  return file.value_or(out);
}

AtmosphereSpec read_atmosphere(const Record& root, const Origin& origin, const std::string& asked, Problems& problems) {
  AtmosphereSpec out;
  out.ground_height_m = origin.height_m;
  const Record* record = root.table("atmosphere");
  if (record == nullptr) {
    if (asked.empty() || asked == "layered") out.layered.emplace();
    out.pressure_hPa = standard_pressure_hPa(out.ground_height_m);
    return out;
  }
  const std::string model = asked.empty() ? record->text("model") : asked;
  out.none = model == "none";
  // A table holds its air: what would shape a model's is refused beside it.
  const bool table = record->given("tables");
  const std::string instead = table ? "" : asked;
  if (table || model != "layered") refuse_keys(*record, kLayeredKeys, "layered", instead, problems);
  if (table || model != "clear_sky") refuse_keys(*record, kClearSkyKeys, "clear_sky", instead, problems);
  const auto refuse_columns = [&](const char* what) {
    for (const char* key : kColumnKeys)
      if (record->given(key)) problems.add(record->place(key), std::string("'") + key + "' " + what, "", "remove it");
  };
  if (table)
    refuse_columns("would shape a model's air, and 'tables' holds its own");
  else if (out.none)
    refuse_columns("says something of air, and model = \"none\" has none");
  for (const char* key : {"pressure_hPa", "view_zenith_deg", "adjacency"})
    if (out.none && record->given(key) && !(std::string(key) == "adjacency" && record->text(key) == "off"))
      problems.add(record->place(key),
                   std::string("'") + key + "' says something of air, and model = \"none\" has none", "", "remove it");
  if (model == "layered") out.layered = read_layered(*record, problems);
  if (record->given("tables")) {
    out.table_file = std::filesystem::absolute(record->text("tables")).lexically_normal().string();
    check_readable(record->text("tables"), record->place("tables"), problems);
    if (record->given("model"))
      problems.add(record->place("model"), "'model' and 'tables' exclude each other", "both", "remove one");
  }
  if (record->given("ground_height_m")) out.ground_height_m = record->number("ground_height_m");
  out.pressure_hPa =
      record->given("pressure_hPa") ? record->number("pressure_hPa") : standard_pressure_hPa(out.ground_height_m);
  if (record->given("water_g_cm2")) out.water_g_cm2 = record->number("water_g_cm2");
  if (record->given("ozone_atm_cm")) out.ozone_atm_cm = record->number("ozone_atm_cm");
  if (record->given("aod_550")) out.aod_550 = record->number("aod_550");
  out.angstrom = record->number("angstrom");
  out.ssa = record->number("ssa");
  out.asymmetry = record->number("asymmetry");
  out.ground_albedo = record->number("ground_albedo");
  if (table)
    for (const char* key : {"view_zenith_deg", "solar_spectrum", "solar_spectrum_file"})
      if (record->given(key))
        problems.add(record->place(key),
                     std::string("'") + key + "' is for a table that is built, and 'tables' holds one", "",
                     "remove it");
  out.solar = read_solar(*record, problems);
  out.view_zenith_deg = record->numbers("view_zenith_deg");
  if (record->given("adjacency")) {
    const std::string adjacency = record->text("adjacency");
    out.adjacency = adjacency == "local" ? Adjacency::local : adjacency == "mean" ? Adjacency::mean : Adjacency::off;
  }
  return out;
}

PlanOverrides read_plan(const Record& root, Problems& problems) {
  PlanOverrides out;
  const Record* record = root.table("plan");
  if (record == nullptr) return out;
  const auto number = [&](const char* key, int& value) {
    if (record->given(key)) value = static_cast<int>(record->integer(key));
  };
  number("sky_rank", out.sky_rank);
  for (const auto& [key, value] : {std::pair{"height_nodes", &out.height_nodes},
                                   {"view_nodes", &out.view_nodes},
                                   {"path_nodes", &out.path_nodes}}) {
    number(key, *value);
    if (*value == 6) problems.add(record->place(key), "nodes come in 1, 2, 3, 4, 5 and 7", "6", "take 5 or 7");
  }
  return out;
}

/// Latitude, longitude and the azimuth of the scene's north, from the origin; nullopt after reporting that it
/// has none.
std::optional<GeoPlace> place_of_scene(const Record& root, const Origin& origin, const base::Where& asked_by,
                                       Problems& problems) {
  if (origin.epsg != 0) return geographic_place(origin.epsg, origin.easting_m, origin.northing_m);
  const Record* scene = root.table("scene");
  const Record* record = scene ? scene->table("origin") : nullptr;
  if (record && record->given("latitude_deg") && record->given("longitude_deg"))
    return GeoPlace{record->number("longitude_deg"), record->number("latitude_deg"), 0.0};
  problems.add(asked_by, "the sun at a time needs a place on earth", "no epsg, no latitude_deg and longitude_deg",
               "give scene.origin an epsg with easting and northing, or latitude_deg and longitude_deg");
  return std::nullopt;
}

Sun read_sun(const Record& root, const Origin& origin, Problems& problems) {
  Sun sun;
  const Record* time = root.table("time");
  if (time == nullptr || !time->sound) {
    if (time == nullptr)
      problems.add(root.where, "[time] is missing", "",
                   "write time = { utc = \"2012-09-20T15:30:00Z\" } or time = { sun = { zenith_deg = 40, "
                   "azimuth_deg = 160 } }");
    return sun;
  }
  const Record *angles = time->table("sun"), *moon = time->table("moon");
  if (static_cast<int>(time->given("utc")) + (angles != nullptr) + (moon != nullptr) != 1) {
    problems.add(time->where, "[time] needs exactly one of utc, sun and moon",
                 angles || moon || time->given("utc") ? "more than one" : "none", "remove or add one");
    return sun;
  }
  if (time->given("light") && !time->given("utc"))
    problems.add(time->place("light"), "'light' goes with utc", time->text("light"),
                 "remove it: the table sun or moon says it already");
  if (const Record* given = angles ? angles : moon) {
    sun.zenith_deg = given->number("zenith_deg");
    sun.azimuth_deg = given->number("azimuth_deg");
    sun.day_of_year = static_cast<int>(given->integer("day_of_year"));
    if (moon) sun.moon_phase_deg = moon->number("phase_angle_deg");
    return sun;
  }
  const auto place = place_of_scene(root, origin, time->place("utc"), problems);
  if (!place) return sun;
  try {
    const auto light = time->text("light") == "moon" ? moon_from_time : sun_from_time;
    sun = light(time->text("utc"), place->latitude_deg, place->longitude_deg);
    sun.azimuth_deg = std::fmod(sun.azimuth_deg - place->grid_north_azimuth_deg + 360.0, 360.0);
  } catch (const base::Error& error) {
    problems.add(time->place("utc"), error.what(), "", "");
  }
  return sun;
}

/// What the tolerance is of; its materials must be the scene's.
ToleranceMeasure read_measure(const Record& root, const MaterialTable& materials, Problems& problems) {
  ToleranceMeasure out{figure_named(root.text("tolerance_of")), root.value("tolerance_materials").texts};
  if (problems.empty() && root.given("tolerance_materials") && out.materials.empty())
    problems.add(root.place("tolerance_materials"), "'tolerance_materials' names none, so no pixel would count", "[]",
                 "name those that matter, or remove the key");
  for (const std::string& name : out.materials)
    materials.surface(name, root.place("tolerance_materials"), problems, Covers::nothing);
  return out;
}

bool counts_from_ground(const Lidar& lidar) {
  return lidar.turbulence.profile == TurbulenceProfile::hufnagel_valley && !lidar.turbulence.ground_z_m;
}

/// The file's paths for two of its directions.
int read_paths(const Record& root, const Simulation& simulation, Problems& problems) {
  const auto paths = static_cast<int>(root.integer("paths"));
  if (root.text("bounces").empty() && root.integer("bounces") == 0)
    problems.add(root.place("paths"), "'paths' means nothing with bounces = 0", std::to_string(paths), "remove one");
  std::string may;
  for (int per_two = 1; per_two <= kMostPathsPerTwo && simulation.sky_directions_given; ++per_two) {
    const int beside = paths_beside(simulation.sky_directions, per_two);
    if (beside == paths) return per_two;
    may += (may.empty() ? "" : ", ") + std::to_string(beside);
  }
  if (may.empty())
    problems.add(root.place("paths"), "'paths' needs sky_directions", "none",
                 "give sky_directions too, or let the tolerance choose both");
  else
    problems.add(root.place("paths"), "'paths' is no multiple of half the sky_directions",
                 std::to_string(paths) + " for " + std::to_string(simulation.sky_directions), "give one of " + may);
  return 1;
}

}  // namespace

double standard_pressure_hPa(double height_m) { return 1013.25 * std::pow(1.0 - 0.0065 * height_m / 288.15, 5.25588); }

Simulation load_simulation(const std::string& file, const LoadOptions& options) {
  Problems problems;
  Simulation out;
  out.file = std::filesystem::absolute(file).lexically_normal().string();
  const Record root = read_document(file, problems, options.overrides);
  out.tolerance = root.number("tolerance");
  out.seed = options.seed.value_or(static_cast<std::uint64_t>(root.integer("seed")));
  out.sky_directions_given = root.given("sky_directions");
  if (out.sky_directions_given) out.sky_directions = static_cast<int>(root.integer("sky_directions"));
  if (root.given("paths")) out.paths_per_two = read_paths(root, out, problems);
  out.bounces_given = root.text("bounces").empty();
  out.bounces = out.bounces_given ? static_cast<int>(root.integer("bounces")) : kMostChosenBounces;
  out.plan = read_plan(root, problems);
  if (const Record* thermal = root.table("thermal")) out.thermal_below_3um = thermal->text("below_3um") != "left_out";
  // A file that could not be read at all has one problem; what it lacks is not worth a line.
  const bool readable =
      problems.empty() || root.given("format") || !root.records("material").empty() || root.given("scene");
  if (!readable) problems.throw_if_any();

  MaterialTable materials(root, problems);
  out.tolerance_of = read_measure(root, materials, problems);
  SceneParts parts = read_scene_parts(root, materials, problems);
  out.atmosphere = read_atmosphere(root, parts.origin, options.air_model, problems);
  if (!root.records("instrument").empty() || root.given("time")) out.sun = read_sun(root, parts.origin, problems);
  out.lamps = read_lamps(root, parts, problems);
  out.instruments = read_instruments(root, parts, parts.notices, problems);
  out.measures = read_measures(root, problems);
  out.budgets = read_budgets(root, problems);
  const std::vector<PlacedBox> boxes = placed_boxes(parts);
  check_resolution(parts, boxes, out.file, parts.notices, problems);
  std::vector<std::uint32_t> buried;
  if (problems.empty()) buried = find_buried(parts, boxes, out.file, parts.notices);
  out.lidars = read_lidars(root, parts, box_around(boxes), root.given("time"), parts.notices, problems);
  if (options.need_instruments && root.records("instrument").empty() && root.records("lidar").empty())
    problems.add(root.where, "no [[instrument]] or [[lidar]] looks at the scene", "", "add one");
  problems.throw_if_any();
  tell_of_buried(parts, out, parts.notices);
  parts.notices.insert(parts.notices.end(), problems.notices().begin(), problems.notices().end());

  if (std::any_of(out.lidars.begin(), out.lidars.end(), counts_from_ground))
    out.ground = std::make_shared<const Ground>(parts.terrains);
  out.cell_m = parts.cell_m, out.cell_copies = parts.cell_copies;
  out.notices = std::move(parts.notices);
  out.resolved_json = document_json(root);
  if (options.compile) out.scene = compile_scene(std::move(parts), std::move(materials), options.trees);
  out.scene.buried = std::move(buried);
  return out;
}

}  // namespace raycube::scene
