// [lidar.pulse]: lines, beam and shape in time; every width converted from what the user says it measures.
#include <algorithm>
#include <cmath>
#include <set>

#include "scene_compiler/csv_file.h"
#include "scene_compiler/document_values.h"
#include "scene_compiler/lidar_parts.h"

namespace raycube::scene {

std::optional<double> beam_width_factor(const std::string& definition) {
  if (definition == "1/e^2" || definition == "edge") return 1.0;
  if (definition == "1/e") return std::sqrt(2.0);
  if (definition == "FWHM") return std::sqrt(2.0 / std::log(2.0));
  if (definition == "1 sigma") return 2.0;
  return std::nullopt;
}

std::optional<double> half_divergence(double angle, const std::string& definition) {
  for (const auto& [start, share] : {std::pair<std::string, double>{"full angle ", 0.5}, {"half angle ", 1.0}}) {
    if (!definition.starts_with(start)) continue;
    std::string width = definition.substr(start.size());
    if (width.starts_with("at ")) width.erase(0, 3);
    if (const auto factor = beam_width_factor(width)) return angle * share * *factor;
  }
  return std::nullopt;
}

namespace detail {
namespace {

constexpr double kTransformLimit = 0.441271;  // 2 ln 2 / pi, of Gaussian widths (FWHM) in frequency and time

void read_lines(const Record& pulse, LidarPulse& out, const LidarReport& report) {
  auto& problems = report.problems;
  const auto& lines = pulse.records("line");
  if (lines.empty()) {
    want_keys(pulse, {"energy_J", "wavelength_nm"}, "a pulse without [[lidar.pulse.line]]", report);
    refuse_keys(pulse, {"separation_s"}, "a pulse of one wavelength", report);
    out.lines = {
        {"laser", pulse.number("wavelength_nm") * 1e-3, pulse.number("line_fwhm_nm") * 1e-3, pulse.number("energy_J")}};
    return;
  }
  refuse_keys(pulse, {"energy_J", "wavelength_nm", "line_fwhm_nm"}, "a pulse with [[lidar.pulse.line]]", report);
  std::set<std::string> names;
  for (const Record& line : lines) {
    out.lines.push_back({line.text("name"), line.number("wavelength_nm") * 1e-3, line.number("fwhm_nm") * 1e-3,
                         line.number("energy_J")});
    if (!names.insert(line.text("name")).second)
      problems.add(line.place("name"), "two lines of a pulse have one name", "'" + line.text("name") + "'",
                   "rename one");
  }
  out.separation_s = pulse.number("separation_s");
}

void read_beam(const Record& pulse, LidarPulse& out, const LidarReport& report) {
  auto& problems = report.problems;
  out.profile = pulse.text("profile") == "uniform" ? BeamProfile::uniform : BeamProfile::gaussian;
  const bool uniform = out.profile == BeamProfile::uniform;
  const auto fits = [&](const char* key) {
    const std::string& is = pulse.text(key);
    const bool edge = is.ends_with("edge");
    if (edge != uniform)
      problems.add(
          pulse.place(key), std::string("'") + key + "' does not fit the profile",
          "'" + is + "' of a " + pulse.text("profile") + " beam",
          uniform ? "a uniform beam has edges alone" : "a Gaussian beam has no edge: say where it is measured");
    return edge == uniform;
  };
  if (!pulse.given("divergence_is")) {
    problems.add(pulse.place("divergence_mrad"), "a divergence without its definition says nothing",
                 number_text(pulse.number("divergence_mrad")) + " mrad",
                 "add divergence_is = \"full angle at 1/e^2\", or one of: " +
                     choices_text(*find_key(pulse.path, "divergence_is")));
  } else if (fits("divergence_is")) {
    out.half_divergence_rad = *half_divergence(pulse.number("divergence_mrad") * 1e-3, pulse.text("divergence_is"));
    if (out.half_divergence_rad > 1.4)
      problems.add(pulse.place("divergence_mrad"), "the beam's half angle is above 1.4 rad",
                   number_text(out.half_divergence_rad) + " rad", "lower it");
  }
  if (!pulse.given("exit_diameter_mm")) {
    refuse_keys(pulse, {"exit_is"}, "a pulse without exit_diameter_mm", report);
  } else if (!pulse.given("exit_is")) {
    problems.add(pulse.place("exit_diameter_mm"), "a diameter without its definition says nothing",
                 number_text(pulse.number("exit_diameter_mm")) + " mm",
                 "add exit_is = \"1/e^2\", or one of: " + choices_text(*find_key(pulse.path, "exit_is")));
  } else if (fits("exit_is")) {
    out.exit_radius_m = 0.5e-3 * pulse.number("exit_diameter_mm") * *beam_width_factor(pulse.text("exit_is"));
  }
}

/// Piecewise linear power: area, and first moment about 0.
std::pair<double, double> moments(const std::vector<double>& t, const std::vector<double>& p) {
  double area = 0, first = 0;
  for (std::size_t i = 1; i < t.size(); ++i) {
    const double d = t[i] - t[i - 1];
    area += 0.5 * d * (p[i] + p[i - 1]);
    first += d * (t[i - 1] * (2 * p[i - 1] + p[i]) + t[i] * (2 * p[i] + p[i - 1])) / 6;
  }
  return {area, first};
}

void read_tabulated(const Record& pulse, LidarPulse& out, const LidarReport& report) {
  auto& problems = report.problems;
  const auto csv = read_csv(pulse.text("shape_file"), pulse.place("shape_file"), problems);
  if (!csv) return;
  const auto time = csv->column("time_ns"), power = csv->column("power");
  if (!time || !power || csv->columns.size() != 2) {
    problems.add({csv->file, csv->header_line, 0, ""}, "a pulse's shape has the columns time_ns and power",
                 csv->columns_text(), "name them so");
    return;
  }
  std::vector<double> t_s, p;
  const std::size_t before = problems.count();
  for (std::size_t row = 0; row < csv->rows.size() && problems.count() < before + 20; ++row) {
    const auto t = csv->number(row, *time, problems), value = csv->number(row, *power, problems);
    if (!t || !value) continue;
    if (*value < 0)
      problems.add(csv->at(row, *power), "power is negative", number_text(*value),
                   "a pulse only emits: subtract no background below zero");
    if (!t_s.empty() && *t * 1e-9 <= t_s.back())
      problems.add(csv->at(row, *time), "times must ascend", number_text(*t) + " ns", "sort the rows");
    t_s.push_back(*t * 1e-9), p.push_back(*value);
  }
  if (problems.count() != before) return;
  const auto [area, first] = moments(t_s, p);
  if (!(area > 0)) {
    problems.add({csv->file, 0, 0, ""}, "a pulse's shape needs two rows and power above 0",
                 number_text(area) + " of area", "give its samples");
    return;
  }
  const std::string& zero = pulse.text("zero_at");
  const double zero_s = zero == "file" ? 0.0
                        : zero == "centroid"
                            ? first / area
                            : t_s[static_cast<std::size_t>(std::max_element(p.begin(), p.end()) - p.begin())];
  for (double& t : t_s) t -= zero_s;
  for (double& value : p) value /= area;
  out.shape_time_s = std::move(t_s), out.shape_power = std::move(p);
}

void read_shape(const Record& pulse, LidarPulse& out, const LidarReport& report) {
  const std::string& shape = pulse.text("shape");
  const std::string because = "shape = \"" + shape + "\"";
  if (shape == "gaussian") {
    want_keys(pulse, {"fwhm_ns"}, because, report);
    refuse_keys(pulse, {"length_ns", "shape_file", "zero_at"}, because, report);
    out.fwhm_s = pulse.number("fwhm_ns") * 1e-9;
  } else if (shape == "rectangular") {
    out.shape = PulseShape::rectangular;
    want_keys(pulse, {"length_ns"}, because, report);
    refuse_keys(pulse, {"fwhm_ns", "shape_file", "zero_at"}, because, report);
    out.fwhm_s = pulse.number("length_ns") * 1e-9;
  } else {
    out.shape = PulseShape::tabulated;
    want_keys(pulse, {"shape_file", "zero_at"}, because, report);
    refuse_keys(pulse, {"fwhm_ns", "length_ns"}, because, report);
    if (pulse.given("shape_file") && pulse.given("zero_at")) read_tabulated(pulse, out, report);
  }
}

/// What no laser can do is said, not refused (LIDAR specification, 2.1 and 2.3).
void remark(const Record& pulse, const LidarPulse& out, const LidarReport& report) {
  if (out.exit_radius_m == 0 && out.half_divergence_rad == 0)
    report.notice(pulse.where, "a beam without width and divergence: one ray carries all energy");
  for (const LidarLine& line : out.lines) {
    if (!(line.wavelength_um > 0)) continue;
    const double m2 = M_PI * out.exit_radius_m * out.half_divergence_rad / (line.wavelength_um * 1e-6);
    if (out.profile == BeamProfile::gaussian && out.exit_radius_m > 0 && m2 < 1)
      report.notice(pulse.place("divergence_mrad"),
                    "line '" + line.name + "' has M2 = " + number_text(m2) + ", below the diffraction limit of 1");
    const double width_hz =
        base::kLightSpeed_m_s * line.fwhm_um * 1e-6 / (line.wavelength_um * line.wavelength_um * 1e-12);
    if (out.shape == PulseShape::gaussian && line.fwhm_um > 0 && out.fwhm_s > 0 &&
        width_hz * out.fwhm_s < kTransformLimit)
      report.notice(pulse.place("fwhm_ns"), "line '" + line.name + "' times pulse is " +
                                                number_text(width_hz * out.fwhm_s) +
                                                ", below the transform limit of 0.441");
  }
}

}  // namespace

void read_pulse(const Record& pulse, Lidar& out, const LidarReport& report) {
  read_lines(pulse, out.pulse, report);
  read_beam(pulse, out.pulse, report);
  read_shape(pulse, out.pulse, report);
  out.pulse.transmit_efficiency = pulse.number("transmit_efficiency");
  remark(pulse, out.pulse, report);
}

}  // namespace detail
}  // namespace raycube::scene
