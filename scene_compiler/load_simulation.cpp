#include "scene_compiler/load_simulation.h"

#include <cmath>
#include <filesystem>

#include "scene_compiler/csv_file.h"
#include "scene_compiler/document.h"
#include "scene_compiler/document_values.h"
#include "scene_compiler/instrument_builder.h"
#include "scene_compiler/scene_builder.h"
#include "scene_compiler/sun_position.h"

namespace raycube::scene {
namespace {

using base::Problems;

AtmosphereSpec read_atmosphere(const Record& root, const Origin& origin, Problems& problems) {
  AtmosphereSpec out;
  out.ground_height_m = origin.height_m;
  const Record* record = root.table("atmosphere");
  if (record == nullptr) {
    out.pressure_hPa = standard_pressure_hPa(out.ground_height_m);
    return out;
  }
  out.none = record->text("model") == "none";
  if (record->given("tables")) {
    out.table_file = std::filesystem::absolute(record->text("tables")).lexically_normal().string();
    check_readable(record->text("tables"), record->place("tables"), problems);
    if (record->given("model"))
      problems.add(record->place("model"), "'model' and 'tables' exclude each other", "both", "remove one");
  }
  if (record->given("ground_height_m")) out.ground_height_m = record->number("ground_height_m");
  out.pressure_hPa = record->given("pressure_hPa") ? record->number("pressure_hPa")
                                                   : standard_pressure_hPa(out.ground_height_m);
  out.water_g_cm2 = record->number("water_g_cm2");
  out.ozone_atm_cm = record->number("ozone_atm_cm");
  out.aod_550 = record->number("aod_550");
  out.angstrom = record->number("angstrom");
  out.ssa = record->number("ssa");
  out.asymmetry = record->number("asymmetry");
  out.ground_albedo = record->number("ground_albedo");
  if (record->given("adjacency")) {
    const std::string adjacency = record->text("adjacency");
    out.adjacency = adjacency == "local" ? Adjacency::local : adjacency == "mean" ? Adjacency::mean : Adjacency::off;
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
  problems.add(asked_by, "the sun at a time needs a place on earth",
               "no epsg, no latitude_deg and longitude_deg",
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
  const Record* angles = time->table("sun");
  if (time->given("utc") == (angles != nullptr)) {
    problems.add(time->where, "[time] needs exactly one of utc and sun", angles ? "both" : "neither",
                 "remove or add one");
    return sun;
  }
  if (angles) {
    sun.zenith_deg = angles->number("zenith_deg");
    sun.azimuth_deg = angles->number("azimuth_deg");
    sun.day_of_year = static_cast<int>(angles->integer("day_of_year"));
    return sun;
  }
  const auto place = place_of_scene(root, origin, time->place("utc"), problems);
  if (!place) return sun;
  try {
    sun = sun_from_time(time->text("utc"), place->latitude_deg, place->longitude_deg);
    sun.azimuth_deg = std::fmod(sun.azimuth_deg - place->grid_north_azimuth_deg + 360.0, 360.0);
  } catch (const base::Error& error) {
    problems.add(time->place("utc"), error.what(), "", "");
  }
  return sun;
}

}  // namespace

double standard_pressure_hPa(double height_m) {
  return 1013.25 * std::pow(1.0 - 0.0065 * height_m / 288.15, 5.25588);
}

Simulation load_simulation(const std::string& file, const LoadOptions& options) {
  Problems problems;
  Simulation out;
  out.file = std::filesystem::absolute(file).lexically_normal().string();
  const Record root = read_document(file, problems);
  out.tolerance = root.number("tolerance");
  out.seed = options.seed.value_or(static_cast<std::uint64_t>(root.integer("seed")));
  out.sky_directions = static_cast<int>(root.integer("sky_directions"));
  // A file that could not be read at all has one problem; what it lacks is not worth a line.
  const bool readable =
      problems.empty() || root.given("format") || !root.records("material").empty() || root.given("scene");
  if (!readable) problems.throw_if_any();

  MaterialTable materials(root, problems);
  SceneParts parts = read_scene_parts(root, materials, problems);
  out.atmosphere = read_atmosphere(root, parts.origin, problems);
  if (!root.records("instrument").empty() || root.given("time"))
    out.sun = read_sun(root, parts.origin, problems);
  out.instruments = read_instruments(root, parts, parts.notices, problems);
  if (options.need_instruments && root.records("instrument").empty())
    problems.add(root.where, "no [[instrument]] looks at the scene", "", "add one");
  problems.throw_if_any();

  out.notices = std::move(parts.notices);
  out.resolved_json = document_json(root);
  if (options.compile) out.scene = compile_scene(std::move(parts), std::move(materials));
  return out;
}

}  // namespace raycube::scene
