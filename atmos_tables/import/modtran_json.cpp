#include "atmos_tables/import/modtran_json.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <iterator>

#include <nlohmann/json.hpp>

#include "atmos_tables/import/modtran_cards.h"
#include "atmos_tables/import/modtran_names.h"
#include "atmos_tables/import/text_lines.h"
#include "host/base/json_text.h"

namespace raycube::atmos::imported {

namespace {

using nlohmann::json;

const json* member(const json& object, const char* key) {
  if (!object.is_object()) return nullptr;
  const auto at = object.find(key);
  return at == object.end() ? nullptr : &*at;
}

double number_or(const json* object, const char* key, double standing) {
  const json* value = object ? member(*object, key) : nullptr;
  return value && value->is_number() ? value->get<double>() : standing;
}

json parse(const std::string& path) {
  const std::string text = read_bytes(path);
  try {
    return json::parse(base::shallow_json(text));
  } catch (const json::parse_error& error) {
    const std::size_t byte = std::min(error.byte == 0 ? std::size_t{0} : error.byte - 1, text.size());
    const auto lines = std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(byte), '\n');
    const std::size_t start = byte == 0 ? std::string::npos : text.rfind('\n', byte - 1);
    const std::size_t column = byte - (start == std::string::npos ? 0 : start + 1) + 1;
    throw base::Error(base::Fault::input,
                      base::Where{path, static_cast<int>(lines) + 1, static_cast<int>(column), ""}.text() +
                          ": the text is no JSON; it is cut short, or holds NaN, Infinity or ****, which JSON has not");
  } catch (const json::exception& error) {
    throw base::Error(base::Fault::input,
                      path + ": a number is beyond double precision (" + error.what() + "); run the code anew");
  }
}

std::optional<BandRequest> band_of(const json* input) {
  const json* spectral = input ? member(*input, "SPECTRAL") : nullptr;
  const double first = number_or(spectral, "V1", NAN), last = number_or(spectral, "V2", NAN);
  if (!(first >= 0 && last >= first)) return std::nullopt;
  const json* flags = member(*spectral, "FLAGS");
  const auto unit = axis_unit_from_flag(
      flags && flags->is_string() && !flags->get<std::string>().empty() ? flags->get<std::string>()[0] : ' ');
  if (!unit) return std::nullopt;
  return BandRequest{first, last, *unit, number_or(spectral, "DV", 0) + number_or(spectral, "FWHM", 0)};
}

Geometry geometry_of(const json* input) {
  const json* g = input ? member(*input, "GEOMETRY") : nullptr;
  if (!g) return {};
  ModtranPath path{number_or(g, "H1ALT", NAN), number_or(g, "H2ALT", NAN), number_or(g, "OBSZEN", NAN),
                   number_or(g, "HRANGE", NAN), number_or(g, "BETA", NAN)};
  path.iparm = whole_number(number_or(g, "IPARM", 0), 0, 99).value_or(0);
  const char* parm[] = {"PARM1", "PARM2", "PARM3", "PARM4"};
  for (std::size_t i = 0; i < std::size(parm); ++i) path.parm[i] = number_or(g, parm[i], NAN);
  path.day_of_year = whole_number(number_or(g, "IDAY", 0), 1, 366).value_or(0);
  path.time_h = number_or(g, "GMTIME", NAN), path.path_azimuth_deg = number_or(g, "TRUEAZ", NAN);
  path.ground_km = number_or(member(*input, "SURFACE"), "GNDALT", NAN);
  // Zeros stand for what was left open: no length, no angle, and of a path down to space an end that is the ground.
  if (path.range_km == 0) path.range_km = NAN;
  if (path.beta_deg == 0 && path.observer_zenith_deg != 180) path.beta_deg = NAN;
  const bool to_space = number_or(g, "ITYPE", 0) == 3;
  if (path.observer_zenith_deg > 90 && (std::isnan(path.h2_km) || (to_space && path.h2_km == 0)))
    path.h2_km = path.ground_km;
  return geometry_from_modtran(path);
}

/// The number at `place`, or a problem. JSON prints doubles or MODTRAN's floats: 7 digits are what is known of them.
Number number_at(const json& value, const std::string& file, const std::string& place, base::Problems& problems) {
  if (!value.is_number()) {
    problems.add({file, 0, 0, place}, "no number", value.dump().substr(0, 40), "run the code anew");
    return {};
  }
  const double x = value.get<double>();
  if (!std::isfinite(x) || x < 0) {
    problems.add({file, 0, 0, place}, x < 0 ? "a value is negative" : "a value is not finite", value.dump(),
                 "run the code anew");
    return {};
  }
  return {Number::State::good, x, 5e-7 * x};
}

void read_spectra(const json& spectra, const std::string& place, const std::string& kind, const json* input,
                  const std::string& path, base::Problems& problems, std::vector<Run>& runs) {
  const json* freq = member(spectra, "FREQ");
  const base::Where where{path, 0, 0, place};
  if (!freq || !freq->is_array() || freq->empty()) {
    problems.add(where, "no array FREQ", "", "the output is not whole");
    return;
  }
  Run run;
  run.mode = kind;
  std::transform(run.mode.begin(), run.mode.end(), run.mode.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  run.geometry = geometry_of(input);
  std::vector<double> axis;
  for (std::size_t i = 0; i < freq->size() && problems.count() < kEnoughProblems; ++i) {
    const std::string at = place + ".FREQ[" + std::to_string(i) + "]";
    const Number value = number_at((*freq)[i], path, at, problems);
    if (value.good() && value.value <= 0)
      problems.add({path, 0, 0, at}, "a frequency is not above 0", std::to_string(value.value), "");
    axis.push_back(value.value);
    if (i > 0 && (axis[i] == axis[i - 1] || (axis[i] > axis[i - 1]) != (axis[1] > axis[0])))
      problems.add({path, 0, 0, at}, "FREQ does not keep its order",
                   std::to_string(axis[i]) + " after " + std::to_string(axis[i - 1]),
                   "values are out of order or doubled");
  }
  if (!problems.empty()) return;
  const auto unit = settle_axis("FREQ", axis.front(), axis.back(), band_of(input), where, problems);
  if (!unit) return;
  for (const double value : axis) run.wavelength_um.push_back(wavelength_um_from_axis(value, *unit));
  for (const auto& [key, values] : spectra.items()) {
    if (key == "FREQ") continue;
    const auto quantity = modtran_quantity(key);
    if (!quantity || !values.is_array()) {
      run.notes.push_back("column " + key + " is not known and was left out");
      continue;
    }
    if (values.size() != axis.size()) {
      problems.add({path, 0, 0, place + "." + key}, "the array is not as long as FREQ",
                   std::to_string(values.size()) + " of " + std::to_string(axis.size()), "the output is not whole");
      continue;
    }
    Column column = modtran_column(*quantity, key);
    for (std::size_t i = 0; i < values.size() && problems.count() < kEnoughProblems; ++i)
      append_modtran(column, quantity->kind,
                     number_at(values[i], path, place + "." + key + "[" + std::to_string(i) + "]", problems), *unit,
                     run.wavelength_um[i]);
    run.columns.push_back(std::move(column));
  }
  if (!problems.empty()) return;
  if (run.find("radiance")) settle_radiance(run, where, {}, problems);
  sort_ascending(run);
  check_run(run, where, problems);
  runs.push_back(std::move(run));
}

/// What a case was asked for, where nothing came of it yet. Heights, sun and day serve the outputs that lack them.
void read_input(const json& input, const std::string& place, const std::string& path, base::Problems& problems,
                std::vector<Run>& runs) {
  Run run;
  run.mode = "input";
  run.geometry = geometry_of(&input);
  if (!run.geometry.sensor_height_m || !run.geometry.sight_zenith_deg)
    problems.add({path, 0, 0, place + ".MODTRANINPUT"}, "the input names no GEOMETRY of H1ALT and OBSZEN", "",
                 "give the whole input, or the .tp6 of the run");
  run.notes.push_back("what was asked for, no output: give the .chn, .csv, .acd or JSON output of the run beside it");
  runs.push_back(std::move(run));
}

bool is_input(const json& cases) {
  return std::none_of(cases.begin(), cases.end(), [](const json& one) { return member(one, "MODTRANOUTPUT"); }) &&
         std::all_of(cases.begin(), cases.end(), [](const json& one) {
           const json* input = member(one, "MODTRANINPUT");
           return input && input->is_object();
         });
}

}  // namespace

Imported read_modtran_json(const std::string& path) {
  const json root = parse(path);
  base::Problems problems;
  Imported out{path, "MODTRAN 6", "json", {}};
  const json* cases = member(root, "MODTRAN");
  if (!cases || !cases->is_array() || cases->empty()) {
    problems.add({path, 0, 0, ""}, "no array MODTRAN of cases", "", "is it a JSON file of MODTRAN 6?");
    problems.throw_if_any();
  }
  const bool input = is_input(*cases);
  for (std::size_t i = 0; i < cases->size(); ++i) {
    const std::string place = "MODTRAN[" + std::to_string(i) + "]";
    if (input) {
      read_input(*member((*cases)[i], "MODTRANINPUT"), place, path, problems, out.runs);
      continue;
    }
    const json* output = member((*cases)[i], "MODTRANOUTPUT");
    const json* spectra = output ? member(*output, "SPECTRA") : nullptr;
    if (!spectra || !spectra->is_object() || spectra->empty()) {
      problems.add({path, 0, 0, place}, "no MODTRANOUTPUT.SPECTRA", "",
                   "this case has none, others have; run MODTRAN with JSON output for all");
      continue;
    }
    for (const auto& [kind, values] : spectra->items())
      if (values.is_object())
        read_spectra(values, place + ".MODTRANOUTPUT.SPECTRA." + kind, kind, member((*cases)[i], "MODTRANINPUT"), path,
                     problems, out.runs);
  }
  if (out.runs.empty() && problems.empty())
    problems.add({path, 0, 0, ""}, "no spectra in the file", "", "run MODTRAN with JSON output");
  problems.throw_if_any();
  return out;
}

}  // namespace raycube::atmos::imported
