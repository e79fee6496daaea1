#include "host/run/lidar_csv.h"
#include "host/base/units.h"

#include <cmath>
#include <limits>

namespace raycube::run {
namespace {

std::vector<std::string> place_columns(const scene::Simulation& simulation, const std::string& prefix) {
  if (simulation.scene.origin.epsg != 0) return {prefix + "easting_m", prefix + "northing_m", prefix + "height_m"};
  return {prefix + "x_m", prefix + "y_m", prefix + "z_m"};
}

std::vector<std::string> joined(std::initializer_list<std::vector<std::string>> parts) {
  std::vector<std::string> out;
  for (const auto& part : parts) out.insert(out.end(), part.begin(), part.end());
  return out;
}

std::vector<std::string> pulse_columns(const scene::Simulation& simulation) {
  return joined({{"pulse", "line", "time_s", "gps_time_s"},
                 place_columns(simulation, "exit_"),
                 {"axis_x", "axis_y", "axis_z"},
                 place_columns(simulation, "pupil_"),
                 {"pupil_axis_x",
                  "pupil_axis_y",
                  "pupil_axis_z",
                  "scan_angle_deg",
                  "half_divergence_mrad",
                  "scintillation",
                  "gate_start_s",
                  "cube_line",
                  "photons_emitted",
                  "photons_in_gate",
                  "background_hz",
                  "returns",
                  "recorded_pe",
                  "background_pe_per_bin",
                  "noise_pe",
                  "threshold_pe",
                  "detection_probability",
                  "false_alarm_hz",
                  "speckle_modes",
                  "saturated_records",
                  "absorbed",
                  "air",
                  "volumes",
                  "escaped",
                  "truncated",
                  "collected",
                  "early",
                  "late",
                  "near"}});
}

std::vector<std::string> return_columns(const scene::Simulation& simulation) {
  return joined(
      {{"pulse", "pixel", "line", "return", "of", "time_s", "gps_time_s"},
       place_columns(simulation, ""),
       {"range_m",         "delay_ns",    "peak_pe",   "energy_pe",     "fwhm_ns",      "detection_probability",
        "saturated",       "cut_by_gate", "las_class", "chance",        "range_true_m", "expected_pe",
        "order",           "object",      "material",  "incidence_deg", "overlap",      "transmission_2way",
        "footprint_share", "pulses_back"}});
}

}  // namespace

std::string line_name(const scene::Lidar& lidar, int line) {
  const auto& name = lidar.pulse.lines[static_cast<std::size_t>(line)].name;
  return name.empty() ? "line " + std::to_string(line + 1) : name;
}

int las_class_of(const scene::Simulation& simulation, const scene::Lidar& lidar, const lidar::Echo& echo,
                 const lidar::ReturnTruth& behind) {
  constexpr int kUnclassified = 1, kNoise = 7;  // ASPRS standard classes
  const double doubtful = lidar.echoes.noise_class_above;
  if (doubtful > 0 && static_cast<double>(echo.chance) > doubtful) return kNoise;
  if (behind.material >= simulation.scene.materials.size()) return kUnclassified;
  return static_cast<int>(simulation.scene.materials[behind.material].las_class);
}

LidarCsv::LidarCsv(base::OutputSet& set, const scene::Simulation& simulation, const lidar::LidarPlan& plan)
    : simulation_(simulation),
      plan_(plan),
      pulses_(set.add("pulses.csv"), pulse_columns(simulation)),
      returns_(set.add("returns.csv"), return_columns(simulation)) {
  if (plan.lidar.detector.mode == scene::DetectorMode::geiger)
    photons_.emplace(set.add("photons.csv"),
                     std::vector<std::string>{"pulse", "pixel", "line", "cell", "delay_ns", "range_m"});
}

void LidarCsv::add_return(const lidar::Shot& shot, const lidar::Detection& d, const lidar::Echo& echo,
                          const lidar::Vec3& at, const lidar::ReturnTruth& t) {
  const auto& origin = simulation_.scene.origin;
  returns_.add(d.pulse)
      .add(d.pixel)
      .add(line_name(plan_.lidar, d.line))
      .add(echo.number)
      .add(echo.of)
      .add(shot.time_s)
      .add(plan_.lidar.gps_start_s + shot.time_s);
  returns_.add(origin.easting_m + at[0]).add(origin.northing_m + at[1]).add(origin.height_m + at[2]);
  returns_.add(echo.range_m)
      .add(echo.time_s * 1e9)
      .add(echo.peak_pe)
      .add(echo.energy_pe)
      .add(echo.fwhm_s * 1e9f)
      .add(echo.detection_probability);
  returns_.add(static_cast<int>(echo.saturated)).add(static_cast<int>(echo.cut));
  returns_.add(las_class_of(simulation_, plan_.lidar, echo, t))
      .add(echo.chance)
      .add(t.range_m)
      .add(t.expected_pe)
      .add(t.order);
  if (t.object == RC_NONE)
    returns_.add("");
  else
    returns_.add(static_cast<std::int64_t>(t.object));
  returns_.add(t.material < simulation_.scene.materials.size() ? simulation_.scene.materials[t.material].name
                                                               : std::string());
  returns_.add(t.incidence_deg)
      .add(t.overlap)
      .add(t.transmission_2way)
      .add(t.subray_share)
      .add(t.pulses_back)
      .end_row();
}

void LidarCsv::add_photons(const lidar::Detection& d) {
  if (!photons_) return;
  const double metres_per_s = base::kLightSpeed_m_s / (2 * plan_.lidar.transport.group_index);
  for (const auto& tag : d.tags)
    photons_->add(d.pulse)
        .add(d.pixel)
        .add(line_name(plan_.lidar, d.line))
        .add(tag.cell)
        .add(tag.time_s * 1e9)
        .add(tag.time_s * metres_per_s)
        .end_row();
}

void LidarCsv::add_shot(const lidar::ShotResult& r, const std::vector<lidar::Detection>& detections,
                        std::int64_t cube_line) {
  const auto& shot = r.shot;
  const auto& origin = simulation_.scene.origin;
  const double base[3] = {origin.easting_m, origin.northing_m, origin.height_m};
  const auto place = [&](const lidar::Vec3& at) {
    for (std::size_t i = 0; i < 3; ++i) pulses_.add(base[i] + at[i]);
  };
  const auto vector = [&](const lidar::Vec3& v) {
    for (const double c : v) pulses_.add(c);
  };
  const auto lines = static_cast<std::size_t>(plan_.lines()), pixels = static_cast<std::size_t>(plan_.pixels()),
             bins = static_cast<std::size_t>(plan_.lidar.gate.bins);
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t l = 0; l < lines; ++l) {
    pulses_.add(shot.pulse)
        .add(line_name(plan_.lidar, static_cast<int>(l)))
        .add(shot.time_s)
        .add(plan_.lidar.gps_start_s + shot.time_s);
    place(shot.exit_m), vector(shot.exit_axis), place(shot.pupil_m), vector(shot.pupil_axis);
    pulses_.add(base::deg_from_rad(shot.scan_angle_rad))
        .add(shot.half_divergence_rad * 1e3)
        .add(shot.line_gain.empty() ? shot.gain : shot.gain * shot.line_gain[l])
        .add(plan_.lidar.gate.start_s)
        .add(cube_line);
    double photons = 0, background_hz = r.background_hz.empty() ? kNone : 0;
    for (std::size_t p = 0; p < pixels; ++p) {
      const std::size_t at = p * lines + l;
      for (const auto* row : {&r.first, &r.multiple, &r.air})
        if (!row->empty())
          for (std::size_t i = at * bins; i < (at + 1) * bins; ++i) photons += (*row)[i];
      if (!r.background_hz.empty()) background_hz += r.background_hz[at] / static_cast<double>(pixels);
    }
    pulses_.add(plan_.photons[l]).add(photons).add(background_hz);
    if (detections.empty()) {
      for (int i = 0; i < 9; ++i) pulses_.add("");
    } else {
      std::int64_t returns = 0, saturated = 0;
      double recorded = 0;
      lidar::DetectionTruth mean;
      for (std::size_t p = 0; p < pixels; ++p) {
        const auto& d = detections[p * lines + l];
        returns += static_cast<std::int64_t>(d.echoes.size());
        saturated += d.truth.saturated;
        for (const float pe : d.waveform_pe) recorded += pe;
        const double share = 1.0 / static_cast<double>(pixels);
        mean.background_pe += share * d.truth.background_pe;
        mean.noise_pe += share * d.truth.noise_pe;
        mean.threshold_pe += share * d.truth.threshold_pe;
        mean.detection_probability += share * d.truth.detection_probability;
        mean.false_alarm_rate_hz += share * d.truth.false_alarm_rate_hz;
        mean.speckle_modes += share * d.truth.speckle_modes;
      }
      pulses_.add(returns)
          .add(recorded)
          .add(mean.background_pe)
          .add(mean.noise_pe)
          .add(mean.threshold_pe)
          .add(mean.detection_probability);
      pulses_.add(mean.false_alarm_rate_hz).add(mean.speckle_modes).add(saturated);
    }
    const lidar::Ledger ledger = l < r.ledger.size() ? r.ledger[l] : lidar::Ledger{kNone, kNone, kNone, kNone, kNone,
                                                                                   kNone, kNone, kNone, kNone};
    for (const double share : {ledger.absorbed, ledger.air, ledger.volumes, ledger.escaped, ledger.truncated,
                               ledger.collected, ledger.early, ledger.late, ledger.near})
      pulses_.add(share);
    pulses_.end_row();
  }
}

void LidarCsv::finish(products::RunRecord& record) {
  pulses_.finish();
  returns_.finish();
  record.files.emplace_back("pulses.csv", "every pulse: geometry, detection, energy ledger");
  record.files.emplace_back("returns.csv", "every return, measured and true");
  if (!photons_) return;
  photons_->finish();
  record.files.emplace_back("photons.csv", "every event of the Geiger detector");
}

}  // namespace raycube::run
