#include "scene_compiler/lamp_builder.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "host/base/text.h"
#include "host/base/units.h"
#include "scene_compiler/csv_file.h"
#include "scene_compiler/document_values.h"
#include "scene_compiler/ies_file.h"
#include "scene_compiler/spectrum_file.h"

namespace raycube::scene {
namespace {

using base::Problems;

constexpr double kFarthest_m = 1e7;         ///< of the key position_m
constexpr std::size_t kMostLamps = 100000;  ///< every draw weighs all of a source

std::array<double, 3> array_of(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

/// Both or neither of two keys is an error.
bool one_of(const Record& record, const char* a, const char* b, Problems& problems) {
  if (record.given(a) != record.given(b)) return true;
  problems.add(record.where, std::string("a lamp needs exactly one of ") + a + " and " + b,
               record.given(a) ? "both" : "neither", record.given(a) ? "remove one" : "add one");
  return false;
}

void refuse_key(const Record& record, const char* key, const std::string& why, Problems& problems) {
  if (record.given(key))
    problems.add(record.place(key), std::string("'") + key + "' " + why, value_text(record, key), "remove it");
}

std::vector<std::array<double, 3>> listed_places(const Record& record, const SceneParts& parts, Problems& problems) {
  std::vector<std::array<double, 3>> out;
  const auto csv = read_csv(record.text("positions"), record.place("positions"), problems);
  if (!csv) return out;
  const auto x = csv->column("x_m"), y = csv->column("y_m"), z = csv->column("z_m");
  if (!x || !y || !z || csv->columns.size() != 3) {
    problems.add({csv->file, csv->header_line, 0, ""}, "columns x_m, y_m and z_m are needed, and no others",
                 csv->columns_text(), "name them so");
    return out;
  }
  const std::size_t before = problems.count();
  for (std::size_t row = 0; row < csv->rows.size() && problems.count() < before + 20; ++row) {
    const auto px = csv->number(row, *x, problems), py = csv->number(row, *y, problems),
               pz = csv->number(row, *z, problems);
    if (!px || !py || !pz) continue;
    std::array<double, 3> place{*px, *py, *pz};
    if (const double* far =
            std::find_if(place.begin(), place.end(), [](double c) { return std::abs(c) > kFarthest_m; });
        far != place.end()) {
      problems.add({csv->file, csv->row_lines[row], 0, ""}, "a lamp must lie within 1e7 m of the origin",
                   number_text(*far), "correct it");
      continue;
    }
    if (record.boolean("on_terrain")) {
      const auto height = parts.terrain_height_m(*px, *py);
      if (!height && parts.terrains_whole)
        problems.add({csv->file, csv->row_lines[row], 0, ""}, "on_terrain, but no terrain lies there",
                     "x " + number_text(*px) + ", y " + number_text(*py), "move it, or set on_terrain = false");
      place[2] += height.value_or(0);
    }
    out.push_back(place);
  }
  return out;
}

/// Spectral flux of a file over its integral; empty after reporting.
LampSpectrum read_lamp_spectrum(const Record& record, Problems& problems) {
  LampSpectrum out;
  const auto csv = read_csv(record.text("spectrum"), record.place("spectrum"), problems);
  if (!csv) return out;
  std::optional<std::size_t> wavelength;
  for (std::size_t c = 0; c < csv->columns.size(); ++c)
    if (wavelength_unit_um(csv->columns[c])) wavelength = c;
  if (!wavelength || csv->columns.size() != 2) {
    problems.add({csv->file, csv->header_line, 0, ""}, "a lamp's spectrum has two columns", csv->columns_text(),
                 "give wavelength_nm or wavelength_um, and the spectral flux");
    return out;
  }
  const double unit_um = *wavelength_unit_um(csv->columns[*wavelength]);
  const std::size_t before = problems.count();
  for (std::size_t row = 0; row < csv->rows.size() && problems.count() < before + 20; ++row) {
    const auto x = csv->number(row, *wavelength, problems), y = csv->number(row, 1 - *wavelength, problems);
    if (!x || !y) continue;
    if (!out.wavelength_um.empty() && !(*x * unit_um > out.wavelength_um.back()))
      problems.add(csv->at(row, *wavelength), "wavelengths must ascend", number_text(*x), "sort the file");
    if (*x * unit_um < 0.05 || *x * unit_um > 1000)
      problems.add(csv->at(row, *wavelength), "a wavelength must be 0.05 to 1000 um", number_text(*x * unit_um) + " um",
                   "check the column's unit");
    if (*y < 0)
      problems.add(csv->at(row, 1 - *wavelength), "spectral flux must not be negative", number_text(*y), "correct it");
    out.wavelength_um.push_back(*x * unit_um), out.per_um.push_back(*y);
  }
  double integral = 0;
  for (std::size_t i = 1; i < out.per_um.size(); ++i)
    integral += 0.5 * (out.per_um[i] + out.per_um[i - 1]) * (out.wavelength_um[i] - out.wavelength_um[i - 1]);
  if (problems.count() == before && !(integral > 0))
    problems.add({csv->file, 0, 0, ""}, "the spectrum holds no light", base::counted(out.per_um.size(), "wavelength"),
                 "give two at least, and some flux");
  for (double& value : out.per_um) value /= integral > 0 ? integral : 1;
  return out;
}

/// Axis, and the width's direction or C0 about it.
void point_it(const Record& record, Lamp& out, Problems& problems) {
  const auto& d = record.numbers("direction");
  const glm::dvec3 given(d[0], d[1], d[2]);
  if (!(glm::length(given) > 0)) {
    problems.add(record.place("direction"), "a lamp must shine somewhere", "0, 0, 0", "give a direction");
    return;
  }
  const glm::dvec3 axis = glm::normalize(given);
  const glm::dvec3 north = std::abs(axis.y) > 0.999 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
  const glm::dvec3 zero = glm::normalize(north - glm::dot(north, axis) * axis);
  const double turn = base::rad_from_deg(record.number("turn_deg"));
  out.axis = array_of(axis);
  out.across = array_of(std::cos(turn) * zero + std::sin(turn) * glm::cross(axis, zero));
}

/// Keys of a shape, and of no other.
void read_lamp_shape(const Record& record, Lamp& out, Problems& problems) {
  const std::string& shape = record.text("shape");
  out.shape = shape == "spot"        ? LampShape::spot
              : shape == "rectangle" ? LampShape::rectangle
              : shape == "disc"      ? LampShape::disc
                                     : LampShape::point;
  const struct {
    const char* key;
    LampShape of;
    const char* shape;
    bool needed;
  } keys[] = {{"cone_deg", LampShape::spot, "spot", true},
              {"size_m", LampShape::rectangle, "rectangle", true},
              {"diameter_m", LampShape::disc, "disc", true},
              {"ies", LampShape::point, "point", false}};
  for (const auto& [key, of, name, needed] : keys) {
    if (out.shape != of) refuse_key(record, key, std::string("is of a ") + name, problems);
    if (out.shape == of && needed && !record.given(key))
      problems.add(record.where, std::string("a ") + name + " needs '" + key + "'", "", "give it");
  }
  const bool turned = out.shape == LampShape::rectangle || record.given("ies");
  if (!turned) refuse_key(record, "turn_deg", "turns nothing of such a lamp", problems);
  if (out.shape == LampShape::point && !record.given("ies"))
    refuse_key(record, "direction", "is nothing to a point that sends the same everywhere", problems);
  if (out.shape == LampShape::spot && record.given("cone_deg")) {
    std::copy_n(record.numbers("cone_deg").begin(), 2, out.cone_deg.begin());
    if (!(out.cone_deg[0] <= out.cone_deg[1]))
      problems.add(record.place("cone_deg"), "the inner cone must not be wider than the outer one",
                   value_text(record, "cone_deg"), "swap them");
    if (out.cone_deg[1] < 0.5)
      problems.add(record.place("cone_deg"), "the outer cone must be 0.5 deg wide at least",
                   number_text(out.cone_deg[1]), "give a wider one");
  }
  if (out.shape == LampShape::rectangle && record.given("size_m"))
    std::copy_n(record.numbers("size_m").begin(), 2, out.size_m.begin());
  if (out.shape == LampShape::disc && record.given("diameter_m"))
    out.size_m = {record.number("diameter_m"), record.number("diameter_m")};
}

Lamp read_lamp(const Record& record, const SceneParts& parts, Problems& problems) {
  Lamp out;
  out.name = record.text("name");
  read_lamp_shape(record, out, problems);
  point_it(record, out, problems);
  if (one_of(record, "position_m", "positions", problems))
    out.position_m = record.given("positions") ? listed_places(record, parts, problems)
                                               : std::vector{position_of(record, parts, problems)};
  const std::size_t before = problems.count();
  if (one_of(record, "spectrum", "temperature_K", problems)) {
    if (record.given("temperature_K"))
      out.spectrum.temperature_K = record.number("temperature_K");
    else
      out.spectrum = read_lamp_spectrum(record, problems);
  }
  if (out.shape == LampShape::point && record.given("ies"))
    if (auto light = read_ies(record.text("ies"), record.place("ies"), problems)) out.distribution = std::move(*light);
  const bool power = record.given("power_W"), flux = record.given("flux_lm");
  if (power && flux)
    problems.add(record.place("flux_lm"), "'power_W' and 'flux_lm' exclude each other", "both", "remove one");
  if (!power && !flux && !record.given("ies"))
    problems.add(record.where, "nothing says how much light the lamp sends", "", "give power_W or flux_lm");
  if (problems.count() != before) return out;
  if (power) {
    out.flux_W = record.number("power_W");
    return out;
  }
  const double efficacy = out.spectrum.efficacy_lm_W();
  const double lumens =
      flux ? record.number("flux_lm") : out.distribution.largest_cd * out.distribution.solid_angle_sr();
  if (efficacy > 0.01)
    out.flux_W = lumens / efficacy;
  else
    problems.add(record.where, "the eye sees next to nothing of the lamp's spectrum, lumens do not say how much it is",
                 number_text(efficacy) + " lm/W", "give power_W");
  return out;
}

}  // namespace

std::vector<Lamp> read_lamps(const Record& root, const SceneParts& parts, Problems& problems) {
  std::vector<Lamp> out;
  std::set<std::string> names;
  std::vector<LampSpectrum> spectra;
  std::size_t lamps = 0;
  for (const Record& record : root.records("lamp")) {
    if (!names.insert(record.text("name")).second)
      problems.add(record.where, "'" + record.text("name") + "' names another lamp", "", "rename one");
    if (parts.cell_m && out.empty())
      problems.add(record.where, "lamps do not repeat with a scene", "scene.periodic", "remove it, or the lamps");
    if (!record.sound) continue;
    const std::size_t before = problems.count();
    out.push_back(read_lamp(record, parts, problems));
    if (problems.count() != before) continue;
    lamps += out.back().position_m.size();
    if (std::find(spectra.begin(), spectra.end(), out.back().spectrum) != spectra.end()) continue;
    spectra.push_back(out.back().spectrum);
    if (static_cast<int>(spectra.size()) == kMostLampSpectra + 1)
      problems.add(record.where, "lamps have more than " + std::to_string(kMostLampSpectra) + " different spectra",
                   "'" + out.back().name + "' has one more", "let lamps share spectra, or leave some out");
  }
  if (lamps > kMostLamps)
    problems.add(root.where, "a scene has at most " + std::to_string(kMostLamps) + " lamps", std::to_string(lamps),
                 "leave out those that light nothing that is seen");
  return out;
}

}  // namespace raycube::scene
