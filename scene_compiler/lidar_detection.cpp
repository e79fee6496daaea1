// [lidar.turbulence], [lidar.speckle], [lidar.detector], [lidar.echoes] and [lidar.products].
#include "scene_compiler/lidar_parts.h"

namespace raycube::scene::detail {

void read_turbulence(const Record& turbulence, Lidar& out, const LidarReport& report) {
  LidarTurbulence& t = out.turbulence;
  const std::string& profile = turbulence.text("profile");
  const std::string because = "profile = \"" + profile + "\"";
  if (profile == "constant") {
    t.profile = TurbulenceProfile::constant;
    want_keys(turbulence, {"cn2"}, because, report);
    refuse_keys(turbulence, {"wind_m_s", "ground_cn2", "ground_z_m"}, because, report);
  } else if (profile == "hufnagel_valley") {
    t.profile = TurbulenceProfile::hufnagel_valley;
    refuse_keys(turbulence, {"cn2"}, because, report);
  } else {
    refuse_keys(turbulence, {"cn2", "wind_m_s", "ground_cn2", "ground_z_m", "outer_scale_m", "wander_convention"},
                because, report);
  }
  t.cn2 = turbulence.number("cn2");
  if (turbulence.given("ground_z_m")) t.ground_z_m = turbulence.number("ground_z_m");
  t.wind_m_s = turbulence.number("wind_m_s"), t.ground_cn2 = turbulence.number("ground_cn2");
  t.spread = turbulence.boolean("spread"), t.wander = turbulence.boolean("wander");
  t.scintillation = turbulence.boolean("scintillation"), t.blur = turbulence.boolean("blur");
  t.broadening = turbulence.boolean("broadening");
  t.outer_scale_m = turbulence.number("outer_scale_m");
  t.andrews_wander = turbulence.text("wander_convention") == "andrews";
}

void read_detector(const Record& detector, bool has_sun, Lidar& out, const LidarReport& report) {
  LidarDetector& d = out.detector;
  const std::string& mode = detector.text("mode");
  const std::string because = "mode = \"" + mode + "\"";
  if (mode != "linear")
    refuse_keys(detector, {"gain", "ionization_ratio", "readout_noise_e", "response_fwhm_ns", "bits", "full_scale_e"},
                because, report);
  if (mode != "geiger")
    refuse_keys(detector, {"dead_time_ns", "jitter_fwhm_ns", "afterpulse_probability", "afterpulse_time_ns", "cells"},
                because, report);
  d.mode = mode == "linear" ? DetectorMode::linear : mode == "geiger" ? DetectorMode::geiger : DetectorMode::photons;
  d.dark_rate_hz = detector.number("dark_rate_hz");
  d.solar_background = detector.given("solar_background") ? detector.boolean("solar_background") : has_sun;
  if (d.solar_background && !has_sun)
    report.problems.add(detector.place("solar_background"), "background light needs the sun's place", "no [time]",
                        "add [time], or set solar_background = false");
  d.gain = detector.number("gain"), d.ionization_ratio = detector.number("ionization_ratio");
  d.readout_noise_e = detector.number("readout_noise_e");
  d.response_fwhm_s = detector.number("response_fwhm_ns") * 1e-9;
  d.bits = static_cast<int>(detector.integer("bits"));
  d.full_scale_e = detector.number("full_scale_e");
  d.dead_time_s = detector.number("dead_time_ns") * 1e-9, d.jitter_fwhm_s = detector.number("jitter_fwhm_ns") * 1e-9;
  d.afterpulse_probability = detector.number("afterpulse_probability");
  d.afterpulse_time_s = detector.number("afterpulse_time_ns") * 1e-9;
  d.cells = static_cast<int>(detector.integer("cells"));
}

void read_echoes(const Record& echoes, Lidar& out, const LidarReport& report) {
  LidarEchoes& e = out.echoes;
  const std::string& method = echoes.text("method");
  e.method = method == "peak"       ? EchoMethod::peak
             : method == "gaussian" ? EchoMethod::gaussian
                                    : EchoMethod::constant_fraction;
  if (out.detector.mode == DetectorMode::geiger)
    refuse_keys(echoes, {"false_returns", "threshold_sigma", "air_is_background", "noise_class_above"},
                "mode = \"geiger\"", report);
  if (count_given(echoes, {"false_returns", "threshold_sigma"}) == 2)
    report.problems.add(echoes.place("threshold_sigma"), "'false_returns' and 'threshold_sigma' exclude each other",
                        "both", "remove one");
  const bool by_sigma = echoes.given("threshold_sigma");
  e.false_returns = by_sigma ? 0 : echoes.number("false_returns");
  if (by_sigma) e.threshold_sigma = echoes.number("threshold_sigma");
  e.air_is_background = echoes.boolean("air_is_background");
  e.noise_class_above = echoes.number("noise_class_above");
  e.threshold_pe = echoes.number("threshold_pe");
  e.fraction = echoes.number("fraction");
  e.max_returns = static_cast<int>(echoes.integer("max_returns"));
}

void read_outputs(const Record* speckle, const Record* products, Lidar& out, const LidarReport& report) {
  if (speckle) {
    out.speckle.on = speckle->boolean("on");
    out.speckle.polarization_modes = speckle->number("polarization_modes");
  }
  if (!products) return;
  LidarProducts& p = out.products;
  p.waveforms = products->boolean("waveforms"), p.cube = products->boolean("cube"), p.las = products->boolean("las");
  p.csv = products->boolean("csv"), p.png = products->boolean("png");
  p.internal_waveforms = products->boolean("internal_waveforms"), p.orders = products->boolean("orders");
  p.laz = products->boolean("laz");
  if (p.laz && p.waveforms && p.internal_waveforms)
    report.problems.add(products->place("laz"), "'laz' keeps waveforms beside the points, not inside the file",
                        "internal_waveforms = true", "remove 'internal_waveforms'");
}

}  // namespace raycube::scene::detail
