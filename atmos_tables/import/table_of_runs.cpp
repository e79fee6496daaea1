#include "atmos_tables/import/table_of_runs.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <sstream>

#include <nlohmann/json.hpp>

#include "atmos_tables/import/run_samples.h"
#include "atmos_tables/import/sixs_bands.h"
#include "atmos_tables/import/text_lines.h"
#include "atmos_tables/row_registry.h"
#include "atmos_tables/table_rows.h"
#include "host/base/planck.h"
#include "host/base/units.h"

namespace raycube::atmos::imported {

namespace {

/// Sunlight matters below, emitted light above: a table that reaches across needs both.
constexpr double kSolarTo_um = 5;
const std::set<std::string> kSolarRows = {
    "solar_irradiance",  "sun_transmission",   "two_way_factor",   "path_radiance_solar",       "sky_radiance_solar",
    "direct_irradiance", "diffuse_irradiance", "spherical_albedo", "diffuse_view_transmission", "diffuse_return"};
const std::set<std::string> kThermalSkyRows = {"sky_radiance_thermal", "two_way_factor_thermal"};

/// A row of a table, the runs it comes from, and what each code must be told to compute them.
struct Need {
  const char *row, *from, *way_out;
};

class Maker {
 public:
  Maker(Samples samples, const TableRequest& request) : s_(std::move(samples)), request_(request) {}

  RenderTable table() {
    sun_and_sensor();
    solar_irradiance();
    two_ways();
    irradiances();
    ground_and_sky();
    for (const char* helper :
         {kTwoWay, kTotalIrradiance, kSunGroundDiffuse, kIrradianceCosOverPi, "solar_irradiance_sun_ground_sensor"})
      drop(helper);
    if (!request_.partial) demands();
    assemble();
    return std::move(table_);
  }
  std::vector<std::string> notices() { return std::move(s_.notices); }

 private:
  bool has(const std::string& row) const {
    return std::any_of(s_.all.begin(), s_.all.end(), [&](const Sample& s) { return s.row == row; });
  }
  void drop(const std::string& row) {
    s_.all.erase(std::remove_if(s_.all.begin(), s_.all.end(), [&](const Sample& s) { return s.row == row; }),
                 s_.all.end());
  }
  std::vector<Sample> of(const std::string& row) const {
    std::vector<Sample> out;
    for (const Sample& s : s_.all)
      if (s.row == row) out.push_back(s);
    return out;
  }
  static bool same(const std::optional<double>& a, const std::optional<double>& b, double within) {
    return !a || !b || std::abs(*a - *b) <= within;
  }
  static bool same_place(const Sample& a, const Sample& b) {
    return same(a.height_m, b.height_m, 0.5) && same(a.zenith_deg, b.zenith_deg, 0.01) &&
           same(a.azimuth_deg, b.azimuth_deg, 0.01);
  }
  const Sample* at(const std::string& row, const Sample& place) const {
    for (const Sample& s : s_.all)
      if (s.row == row && same_place(s, place)) return &s;
    return nullptr;
  }
  void put(const std::string& row, const Sample& place, Spectrum values) {
    Sample sample = place;
    sample.row = row, sample.values = std::move(values);
    s_.all.push_back(std::move(sample));
  }
  void note(const std::string& text) { s_.notices.push_back(text); }

  /// What was asked for goes before what the runs say; a difference is noted.
  std::optional<double> asked_or_said(const std::optional<double>& asked, const std::optional<double>& said,
                                      double within, const std::string& what, const std::string& unit) {
    if (asked && said && std::abs(*asked - *said) > within)
      note(what + " " + shown(*asked) + " " + unit + " as asked for; the runs say " + shown(*said) + " " + unit);
    return asked ? asked : said;
  }

  void sun_and_sensor() {
    const bool solar =
        has("path_radiance_solar") || has("sun_transmission") || has("solar_irradiance") || has(kIrradianceCosOverPi);
    const auto zenith = asked_or_said(request_.sun_zenith_deg, s_.sun_zenith_deg, 0.05, "sun zenith", "deg");
    if (solar && !zenith)
      missing_.emplace_back("the sun's zenith: these files do not name it",
                            "give --sun-zenith, or the run's listing (.tp6) or input JSON");
    table_.sun_zenith_deg = zenith.value_or(0);
    std::optional<double> azimuth = s_.sun_azimuth_deg;  // -90 and 270 are one
    if (azimuth && request_.sun_azimuth_deg)
      azimuth = *request_.sun_azimuth_deg + std::remainder(*azimuth - *request_.sun_azimuth_deg, 360.0);
    table_.sun_azimuth_deg = asked_or_said(request_.sun_azimuth_deg, azimuth, 0.05, "sun azimuth", "deg").value_or(0);
    const auto sensor = asked_or_said(request_.sensor_height_m, s_.sensor_height_m, 0.5, "sensor height", "m");
    if (!sensor)
      missing_.emplace_back("the sensor's height: these files do not name it",
                            "give --sensor-height, or the run's listing (.tp6) or input JSON");
    table_.sensor_height_m = sensor.value_or(0);
    if (s_.day_of_year)
      note("the sun above the air is that of day " + std::to_string(*s_.day_of_year) + " of the year" +
           (s_.earth_sun_factor ? ", " + shown(*s_.earth_sun_factor) + " times that at the mean distance" : ""));
    mu0_ = std::cos(base::rad_from_deg(table_.sun_zenith_deg));
    if (solar && zenith && !(mu0_ > 0))
      missing_.emplace_back("a sun above the horizon", "give the runs of a day, or a range beyond 5 um");
  }

  void solar_irradiance() {
    if (const auto above = of(kIrradianceCosOverPi); !above.empty() && mu0_ > 0) {
      Spectrum e0 = above.front().values;
      for (double& e : e0) e *= std::numbers::pi / mu0_;
      for (const Sample& transmitted : of("solar_irradiance_sun_ground_sensor")) {
        Spectrum two_way = transmitted.values;
        for (std::size_t i = 0; i < e0.size(); ++i) two_way[i] = e0[i] > 0 ? std::min(1.0, two_way[i] / e0[i]) : 0;
        put(kTwoWay, transmitted, std::move(two_way));
      }
      put("solar_irradiance", {}, std::move(e0));
    }
  }

  /// T_sun and R2 from what there is: T_sun alone (product), the joined path alone (T_sun = T2 / T_view, product), or
  /// both.
  void two_ways() {
    auto joined = of(kTwoWay);
    std::stable_sort(joined.begin(), joined.end(), [](const Sample& a, const Sample& b) {
      return a.zenith_deg.value_or(0) < b.zenith_deg.value_or(0);
    });
    if (!has("sun_transmission") && !joined.empty()) {
      for (const Sample& path : joined) {
        const Sample* view = at("view_transmission", path);
        Sample place = path;
        place.zenith_deg.reset(), place.azimuth_deg.reset();
        if (!view || at("sun_transmission", place)) continue;
        Spectrum sun;
        for (std::size_t i = 0; i < path.values.size(); ++i)
          sun.push_back(view->values[i] > 0 ? std::min(1.0, path.values[i] / view->values[i]) : 0);
        put("sun_transmission", place, std::move(sun));
      }
      note(
          "sun transmission is that of the path sun to target to sensor over that of target to sensor: their product "
          "is exact, the sun alone is not known");
    }
    if (!has("sun_transmission") || !has("view_transmission") || has("two_way_factor")) return;
    bool product = false;
    for (const Sample& view : of("view_transmission")) {
      const Sample *path = at(kTwoWay, view), *sun = at("sun_transmission", view);
      Spectrum factor(view.values.size(), 1.0);
      for (std::size_t i = 0; path && sun && i < factor.size(); ++i)
        if (const double both = sun->values[i] * view.values[i]; both > 1e-12) factor[i] = path->values[i] / both;
      product = product || !path;
      Sample place = view;
      place.azimuth_deg.reset();
      put("two_way_factor", place, std::move(factor));
    }
    if (product)
      note(
          "two-way factor 1 where no run has the path from sun to target to sensor: the product of both transmissions "
          "is used");
  }

  void irradiances() {
    const auto e0 = of("solar_irradiance");
    if (e0.empty() || has("diffuse_irradiance")) return;
    for (const Sample& total : of(kTotalIrradiance)) {
      const Sample *sun = at("sun_transmission", total), *factor = at("two_way_factor", total);
      if (!sun) continue;
      Spectrum diffuse;
      for (std::size_t i = 0; i < total.values.size(); ++i)
        // R2 acts on all that the ground reflects, so the light that was seen is R2 T_view E_g0.
        diffuse.push_back(std::max(
            0.0, total.values[i] / (factor ? factor->values[i] : 1) - mu0_ * e0.front().values[i] * sun->values[i]));
      put("diffuse_irradiance", total, std::move(diffuse));
    }
    for (const Sample& part : of(kSunGroundDiffuse)) {
      Spectrum diffuse = part.values;
      for (std::size_t i = 0; i < diffuse.size(); ++i) diffuse[i] *= mu0_ * e0.front().values[i];
      put("diffuse_irradiance", part, std::move(diffuse));
    }
  }

  void ground_and_sky() {
    if (request_.even_sky && !has("sky_radiance_solar")) {
      for (const Sample& diffuse : of("diffuse_irradiance")) {
        Spectrum even = diffuse.values;
        for (double& l : even) l /= std::numbers::pi;
        Sample place;
        place.height_m = diffuse.height_m;
        put("sky_radiance_solar", place, std::move(even));
      }
      note("even sky: the diffuse irradiance over pi in every direction, as asked for");
    }
    if (has("spherical_albedo") && has("diffuse_view_transmission") && !has("diffuse_return")) {
      for (const Sample& s : of("spherical_albedo")) put("diffuse_return", s, s.values);
      note("diffuse return: the spherical albedo in every direction, which keeps S = 2 int t mu dmu");
    }
  }

  void demands() {
    const double first = s_.wavelength_um.front(), last = s_.wavelength_um.back();
    const Need view{
        "view_transmission",
        "transmission from target to sensor: a MODTRAN run that looks down, .chn, .acd, uvspec with edir "
        "at ground and sensor, 6S run by run",
        "MODTRAN: a zenith beyond 90 deg on card 3, or a filter file for a .chn; uvspec: zout at ground and "
        "sensor, source solar; 6S: iwave -1 or 0"};
    const std::vector<Need> solar = {
        {"solar_irradiance",
         "sun above the air: TOA_SUN of tape7, .chn, a direct-irradiance run, uvspec with zout TOA, 6S",
         "MODTRAN: IEMSCT 2 or 3 on card 1; uvspec: TOA among zout"},
        {"sun_transmission",
         "sun to target: REF_SOL and TOA_SUN of tape7, .chn, .acd, a direct-irradiance run (IEMSCT 3), uvspec with "
         "zout TOA, 6S",
         "MODTRAN: IEMSCT 2 on card 1 for REF_SOL, or IEMSCT 3 with the sun's zenith on card 3; uvspec: TOA among "
         "zout"},
        {"path_radiance_solar",
         "sunlight scattered into the path: SOL_SCAT of a run that looks down, .chn, uvspec with umu > 0, 6S",
         "MODTRAN: IEMSCT 2 and IMULT 1 on card 1, SURREF 0; uvspec: umu above 0, albedo 0"},
        {"sky_radiance_solar",
         "sky: SOL_SCAT of runs that look up from the ground, uvspec with umu < 0; or --even-sky where the diffuse "
         "irradiance is known",
         "MODTRAN: IEMSCT 2 on card 1, H1 the ground and zeniths below 90 deg on card 3; uvspec: umu below 0, phi; 6S "
         "and .chn: --even-sky"}};
    const std::vector<Need> thermal = {
        {"path_radiance_thermal",
         "light the path emits: PTH_THRML of a run that looks down, .chn, a thermal uvspec run with umu > 0",
         "MODTRAN: IEMSCT 1 or 2 on card 1, a zenith beyond 90 deg on card 3; uvspec: source thermal, zout at ground "
         "and "
         "sensor, with a run by source solar"},
        {"sky_radiance_thermal",
         "light the sky emits: PTH_THRML of runs that look up from the ground, a thermal uvspec run with umu < 0",
         "MODTRAN: IEMSCT 1 or 2 on card 1, H1 the ground and zeniths below 90 deg on card 3; uvspec: source thermal, "
         "umu below 0"}};
    const auto lacking = [&](const std::vector<Need>& needs) {
      std::vector<Need> out;
      for (const Need& need : needs)
        if (!has(need.row)) out.push_back(need);
      return out;
    };
    const auto no_sun = lacking(solar);
    const bool wants_sun = first < kSolarTo_um, wants_heat = base::asks_for_heat(last);
    const auto miss = [&](const std::vector<Need>& needs) {
      for (const Need& need : needs)
        missing_.emplace_back(std::string(need.row) + ", " + need.from,
                              std::string(need.way_out) + "; or add a CSV column of this name");
    };
    miss(lacking({view}));
    if (wants_sun) miss(no_sun);
    if (wants_heat) miss(lacking(thermal));
    if (!missing_.empty()) {
      base::Problems problems;
      for (const auto& [what, way_out] : missing_)
        problems.add({}, "a render from " + shown(first) + " to " + shown(last) + " um lacks " + what, "", way_out);
      problems.throw_if_any();
    }
    const auto leave_out = [&](const std::set<std::string>& rows, const char* what, const char* why) {
      std::string names;
      for (const auto& row : rows)
        if (has(row)) names += (names.empty() ? "" : ", ") + row, drop(row);
      if (!names.empty()) note(std::string(what) + " left out (" + names + "): " + why);
    };
    if (!wants_sun && !no_sun.empty())
      leave_out(kSolarRows, "sunlight", "beyond 5 um, and not all that a render needs of it is there");
    if (wants_heat) return;
    // Below 3 um emitted light is taken as far as the runs have it; a render sees whether it matters.
    if (!has("path_radiance_thermal"))
      leave_out(kThermalSkyRows, "light the sky emits",
                "no run says what the path emits, and below 3 um neither is needed");
    else if (!has("sky_radiance_thermal"))
      note(
          "light that the path emits is taken; no run says what the sky emits, so the ground reflects none "
          "of it (below 3 um)");
  }

  void assemble() {
    base::Problems problems;
    for (const auto& [what, way_out] : missing_) note("missing: " + what + "; " + way_out);
    std::map<std::string, std::set<double>> nodes;
    const auto coordinates = [](const RowSpec& spec) {
      std::istringstream words(spec.axes);
      std::vector<std::string> out;
      for (std::string word; words >> word;)
        if (word != "[k]") out.push_back(word);
      return out;
    };
    const auto coordinate = [](const Sample& s, const std::string& axis) {
      return axis == "target_height"                               ? s.height_m
             : axis == "view_zenith" || axis == "sky_zenith"       ? s.zenith_deg
             : axis == "relative_azimuth" || axis == "sky_azimuth" ? s.azimuth_deg
                                                                   : std::optional<double>();
    };
    const auto slack = [](const std::string& axis) { return axis == "target_height" ? 0.5 : 0.01; };
    std::set<std::string> rows;
    for (const Sample& s : s_.all) {
      rows.insert(s.row);
      for (const auto& axis : coordinates(*find_row_spec(s.row))) {
        auto& set = nodes[axis];
        const auto value = coordinate(s, axis);
        if (value &&
            std::none_of(set.begin(), set.end(), [&](double n) { return std::abs(n - *value) <= slack(axis); }))
          set.insert(*value);
      }
    }
    if (rows.empty()) throw base::Error(base::Fault::input, "none of the runs says anything a render table can hold");
    add_axis(table_, "wavelength", s_.wavelength_um);
    // Every table has these axes; one node says that nothing varies along it.
    for (const char* axis : {"target_height", "view_zenith", "relative_azimuth", "sky_zenith", "sky_azimuth"}) {
      auto& set = nodes[axis];
      add_axis(table_, axis, set.empty() ? Spectrum{0.0} : Spectrum(set.begin(), set.end()));
    }
    for (const std::string& name : rows) fill(name, coordinates(*find_row_spec(name)), coordinate, slack, problems);
    problems.throw_if_any();
  }

  template <class Coordinate, class Slack>
  void fill(const std::string& name, const std::vector<std::string>& axes, const Coordinate& coordinate,
            const Slack& slack, base::Problems& problems) {
    Row& row = add_row(table_, name, "imported; the provenance names files and assumptions");
    const auto samples = of(name);
    const std::size_t wavelengths = s_.wavelength_um.size(), inner = row.values.size() / wavelengths;
    for (std::size_t cell = 0; cell < inner; ++cell) {
      std::map<std::string, double> place;
      std::size_t rest = cell;
      for (auto axis = axes.rbegin(); axis != axes.rend() && *axis != "wavelength"; ++axis) {
        const auto& nodes = table_.axis(*axis).nodes;
        place[*axis] = nodes[rest % nodes.size()];
        rest /= nodes.size();
      }
      const Sample* found = nullptr;
      for (const Sample& s : samples) {
        bool here = true;
        for (const auto& [axis, value] : place)
          if (const auto c = coordinate(s, axis)) here = here && std::abs(*c - value) <= slack(axis);
        if (!here) continue;
        if (const auto i = found ? first_difference(found->values, s.values) : std::nullopt)
          problems.add(
              {"", 0, 0, name},
              "two runs say different things of one place" + (place.empty() ? "" : ", " + text_of(place)),
              shown(found->values[*i]) + " and " + shown(s.values[*i]) + " at " + shown(s_.wavelength_um[*i]) + " um",
              "give runs of one sun and air, one per place");
        if (!found) found = &s;
      }
      if (!found) {
        problems.add({"", 0, 0, name}, "no run at", text_of(place),
                     "directions and heights of one quantity must form a full grid");
        continue;
      }
      const RowSpec& spec = *find_row_spec(name);
      for (std::size_t i = 0; i < wavelengths; ++i) {
        // Printed digits may carry a ratio a little above 1.
        const double value = found->values[i], most = spec.max == 1 ? 1.0 : spec.max;
        row.values[i * inner + cell] = static_cast<float>(value > most && value < most * (1 + 2e-3) ? most : value);
      }
    }
  }

  /// Beyond 1 %: MODTRAN prints irradiances with three digits.
  static std::optional<std::size_t> first_difference(const Spectrum& a, const Spectrum& b) {
    for (std::size_t i = 0; i < a.size(); ++i)
      if (std::abs(a[i] - b[i]) > 1e-2 * std::max(a[i], b[i]) + 1e-6) return i;
    return std::nullopt;
  }
  static std::string text_of(const std::map<std::string, double>& place) {
    std::string out;
    for (const auto& [axis, value] : place) out += (out.empty() ? "" : ", ") + axis + " " + shown(value);
    return out;
  }

  Samples s_;
  const TableRequest& request_;
  RenderTable table_;
  std::vector<std::pair<std::string, std::string>> missing_;  ///< what, and the way out
  double mu0_ = 1;
};

}  // namespace

/// [first moment, centre, FWHM] um of every node of a table whose nodes are channels of one .chn or bands of 6S; empty
/// for other tables. Where a file's descriptions name neither, the moment, and the equivalent width as that of a
/// Gaussian.
nlohmann::ordered_json channels_of(const std::vector<Imported>& files, const Spectrum& nodes_um) {
  constexpr double kWidthOverFwhm = 1.0644670194312262;  // of a Gaussian: sqrt(pi / (4 ln 2))
  for (const Imported& file : files) {
    if (file.runs.empty() || (file.format != "chn" && !file.runs.front().find("channel_fwhm"))) continue;
    const Run& run = file.runs.front();
    const Column *center = run.find("channel_center"), *fwhm = run.find("channel_fwhm"),
                 *width = run.find("channel_width");
    auto out = nlohmann::ordered_json::array();
    for (const double node : nodes_um)
      for (std::size_t i = 0; i < run.wavelength_um.size(); ++i)
        if (std::abs(run.wavelength_um[i] - node) <= 1e-9 && out.size() < nodes_um.size())
          out.push_back({node, center ? center->values[i] : node,
                         fwhm    ? fwhm->values[i]
                         : width ? width->values[i] / kWidthOverFwhm
                                 : 0.0});
    if (out.size() == nodes_um.size()) return out;
  }
  return {};
}

/// What one line of sight leaves open.
void note_one_direction(const RenderTable& table, const std::vector<Imported>& files,
                        std::vector<std::string>& notices) {
  const bool runs =
      std::any_of(files.begin(), files.end(), [](const Imported& file) { return file.format != "plain-csv"; });
  const auto &zeniths = table.axis("view_zenith").nodes, &sky = table.axis("sky_zenith").nodes;
  if (!runs || !table.has("view_transmission")) return;
  if (zeniths.size() == 1)
    notices.push_back("one line of sight, " + shown(zeniths[0]) + " deg of view zenith" +
                      (zeniths[0] == 0 ? " (straight down where the files name none)" : "") +
                      ": renders that look elsewhere are told so, or refused");
  if (sky.size() == 1 && (table.has("sky_radiance_solar") || table.has("sky_radiance_thermal")))
    notices.push_back("one direction of the sky, taken for all of it");
}

TableOfRuns table_of_runs(const std::vector<Imported>& given, const TableRequest& request) {
  const std::vector<Imported> files = with_bands_joined(given);
  Maker maker(samples_of(files, request), request);
  TableOfRuns out{maker.table(), {}};
  out.notices = maker.notices();
  note_one_direction(out.table, files, out.notices);
  nlohmann::ordered_json provenance{{"model", "imported"}, {"files", nlohmann::ordered_json::array()}};
  for (const Imported& file : given)
    provenance["files"].push_back(
        {{"file", file.file}, {"code", file.code}, {"format", file.format}, {"runs", file.runs.size()}});
  provenance["notices"] = out.notices;
  if (auto channels = channels_of(files, out.table.axis("wavelength").nodes); !channels.empty())
    provenance["channels"] = std::move(channels);
  out.table.provenance_json =
      provenance.dump(-1, ' ', false, std::decay_t<decltype(provenance)>::error_handler_t::replace);
  out.table.solar_source = "as the imported runs have it";
  validate(out.table, "the imported table");
  return out;
}

}  // namespace raycube::atmos::imported
