#include "atmos_tables/import/import_file.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <sstream>

#include <nlohmann/json.hpp>

#include "atmos_tables/import/acd.h"
#include "atmos_tables/import/modtran_chn.h"
#include "atmos_tables/import/modtran_csv.h"
#include "atmos_tables/import/modtran_json.h"
#include "atmos_tables/import/modtran_tape6.h"
#include "atmos_tables/import/modtran_tape7.h"
#include "atmos_tables/import/plain_csv.h"
#include "atmos_tables/import/sixs.h"
#include "atmos_tables/import/text_lines.h"
#include "atmos_tables/import/uvspec.h"
#include "host/base/text.h"

namespace raycube::atmos::imported {

namespace {

struct Format {
  const char* name;
  Imported (*read)(const std::string& path, const std::string& uvspec_input);
};

const Format kFormats[] = {
    {"tape7", [](const std::string& path, const std::string&) { return read_tape7(path); }},
    {"7sc", [](const std::string& path, const std::string&) { return read_tape7(path, "7sc"); }},
    {"tape6", [](const std::string& path, const std::string&) { return read_tape6(path); }},
    {"chn", [](const std::string& path, const std::string&) { return read_chn(path); }},
    {"json", [](const std::string& path, const std::string&) { return read_modtran_json(path); }},
    {"csv", [](const std::string& path, const std::string&) { return read_modtran_csv(path); }},
    {"acd", [](const std::string& path, const std::string&) { return read_acd_text(path); }},
    {"acd-binary", [](const std::string& path, const std::string&) { return read_acd_binary(path); }},
    {"uvspec", [](const std::string& path, const std::string& input) { return read_uvspec(path, input); }},
    {"6s", [](const std::string& path, const std::string&) { return read_sixs(path); }},
    {"plain-csv", [](const std::string& path, const std::string&) { return read_plain_csv(path); }},
};

/// By name where it is the code's own, else by words that only one format has in its head.
std::string told_apart(const std::string& path, const std::string& uvspec_input) {
  const std::filesystem::path file(path);
  const std::string name = base::lower_case(file.filename().string()),
                    end = base::lower_case(file.extension().string());
  const std::string bytes = read_bytes(path), head = bytes.substr(0, 20000), low = base::lower_case(head);
  const auto holds = [&](const char* word) { return head.find(word) != std::string::npos; };
  if (end == ".acd") return head.find('\0') == std::string::npos ? "acd" : "acd-binary";
  if (end == ".csv" && (holds("wavelength [") || holds("wavenumber ["))) return "plain-csv";
  if (end == ".json" || end == ".csv" || end == ".chn") return end.substr(1);
  if (end == ".7sc" || end == ".scn" || name == "tape7.scn") return "7sc";
  if (end == ".tp6" || name.find("tape6") != std::string::npos) return "tape6";
  if (!uvspec_input.empty()) return "uvspec";
  if (low.find("6s version") != std::string::npos || low.find("6sv version") != std::string::npos) return "6s";
  if (end == ".tp7" || name.find("tape7") != std::string::npos ||
      (holds("FREQ") && (holds("COMBIN") || holds("TOTAL_RAD") || holds("TOTAL RAD") || holds("SOL TR"))))
    return "tape7";
  if (end != ".inp" && !uvspec_input_beside(path).empty()) return "uvspec";
  std::string names;
  for (const auto& known : format_names()) names += (names.empty() ? "" : ", ") + known;
  throw base::Error(base::Fault::input, path + ": which code wrote this? name its format, one of " + names);
}

}  // namespace

const std::vector<std::string>& format_names() {
  static const std::vector<std::string> kNames = [] {
    std::vector<std::string> names;
    for (const Format& format : kFormats) names.emplace_back(format.name);
    return names;
  }();
  return kNames;
}

Imported import_file(const std::string& path, const std::string& format, const std::string& uvspec_input) {
  const std::string name = format.empty() ? told_apart(path, uvspec_input) : format;
  for (const Format& known : kFormats)
    if (name == known.name) return known.read(path, uvspec_input);
  throw base::Error(base::Fault::input, "\"" + format + "\" is no format that can be imported");
}

std::string imported_json(const Imported& imported) {
  nlohmann::ordered_json out{{"file", imported.file},
                             {"code", imported.code},
                             {"format", imported.format},
                             {"runs", nlohmann::ordered_json::array()}};
  const auto put = [](nlohmann::ordered_json& object, const char* key, const std::optional<double>& value) {
    if (value) object[key] = *value;
  };
  for (const Run& run : imported.runs) {
    nlohmann::ordered_json r{{"mode", run.mode},
                             {"geometry", nlohmann::ordered_json::object()},
                             {"notes", run.notes},
                             {"wavelength_um", run.wavelength_um}};
    const Geometry& g = run.geometry;
    put(r["geometry"], "sensor_height_m", g.sensor_height_m),
        put(r["geometry"], "path_end_height_m", g.path_end_height_m);
    put(r["geometry"], "path_length_m", g.path_length_m), put(r["geometry"], "sight_zenith_deg", g.sight_zenith_deg);
    put(r["geometry"], "view_zenith_deg", g.view_zenith_deg), put(r["geometry"], "sun_zenith_deg", g.sun_zenith_deg);
    put(r["geometry"], "relative_azimuth_deg", g.relative_azimuth_deg);
    put(r["geometry"], "sun_azimuth_deg", g.sun_azimuth_deg), put(r["geometry"], "ground_height_m", g.ground_height_m);
    if (g.day_of_year) r["geometry"]["day_of_year"] = *g.day_of_year;
    put(r["geometry"], "earth_sun_factor", g.earth_sun_factor);
    for (const Column& column : run.columns) {
      nlohmann::ordered_json c{{"name", column.name}, {"unit", column.unit}, {"source", column.source}};
      put(c, "height_m", column.place.height_m), put(c, "zenith_deg", column.place.zenith_deg);
      put(c, "relative_azimuth_deg", column.place.relative_azimuth_deg);
      if (column.place.top_of_air) c["top_of_air"] = true;
      if (column.place.k) c["k"] = *column.place.k;
      c["values"] = column.values;
      r["columns"].push_back(std::move(c));
    }
    out["runs"].push_back(std::move(r));
  }
  // What a file says of itself need not be UTF-8.
  return out.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

std::string imported_text(const Imported& imported) {
  std::ostringstream out;
  out << imported.file << ": " << imported.code << ", " << imported.format << ", " << imported.runs.size()
      << (imported.runs.size() == 1 ? " run\n" : " runs\n");
  for (const Run& run : imported.runs) {
    out << run.mode;
    if (!run.wavelength_um.empty()) {
      const auto [least, most] = std::minmax_element(run.wavelength_um.begin(), run.wavelength_um.end());
      out << ": " << base::counted(run.wavelength_um.size(), "wavelength") << ", " << *least << " to " << *most
          << " um (vacuum)";
    }
    out << "\n";
    const auto say = [&](const char* what, const std::optional<double>& value, const char* unit) {
      if (value) out << "  " << what << " " << *value << " " << unit << "\n";
    };
    say("sensor height", run.geometry.sensor_height_m, "m"), say("path ends at", run.geometry.path_end_height_m, "m");
    say("path length", run.geometry.path_length_m, "m"),
        say("line of sight, zenith", run.geometry.sight_zenith_deg, "deg");
    say("view zenith", run.geometry.view_zenith_deg, "deg"), say("sun zenith", run.geometry.sun_zenith_deg, "deg");
    say("relative azimuth", run.geometry.relative_azimuth_deg, "deg");
    say("sun azimuth", run.geometry.sun_azimuth_deg, "deg"), say("ground height", run.geometry.ground_height_m, "m");
    if (run.geometry.day_of_year) out << "  day of the year " << *run.geometry.day_of_year << "\n";
    say("earth-sun factor", run.geometry.earth_sun_factor, "");
    for (const auto& note : run.notes) out << "  note: " << note << "\n";
    for (const Column& column : run.columns) {
      const auto [low, high] = std::minmax_element(column.values.begin(), column.values.end());
      out << "  " << column.name;
      if (column.place.top_of_air) out << " at the top of the air";
      if (column.place.height_m) out << " at " << *column.place.height_m << " m";
      if (column.place.zenith_deg) out << ", zenith " << *column.place.zenith_deg << " deg";
      if (column.place.relative_azimuth_deg) out << ", azimuth " << *column.place.relative_azimuth_deg << " deg";
      if (column.place.k) out << ", k " << *column.place.k;
      out << " [" << column.unit << "] " << *low << " to " << *high << "  (" << column.source << ")\n";
    }
  }
  return out.str();
}

}  // namespace raycube::atmos::imported
