// Turbulence along paths: published and worked numbers, closed forms of constant profiles, and what shots become.
#include <doctest/doctest.h>

#include <cmath>

#include "host/lidar/apply_turbulence.h"
#include "host/lidar/pulse_taps.h"
#include "host/lidar/turbulence.h"
#include "tests/oracle/lidar_detection_cases.h"
#include "tests/support/chance_checks.h"

using namespace raycube;
using namespace raycube::lidar;

namespace {

scene::LidarTurbulence hufnagel_valley(double wind_m_s = 21) {
  scene::LidarTurbulence t;
  t.profile = scene::TurbulenceProfile::hufnagel_valley, t.wind_m_s = wind_m_s;
  return t;
}

scene::LidarTurbulence constant(double cn2) {
  scene::LidarTurbulence t;
  t.profile = scene::TurbulenceProfile::constant, t.cn2 = cn2;
  return t;
}

PathNodes level_path(double cn2, double length_m) { return path_nodes(constant(cn2), {length_m, 10, 10}); }

/// A plan and a shot straight down from a height.
LidarPlan airborne_plan(const scene::LidarTurbulence& turbulence) {
  LidarPlan plan = test::small_plan(1000);
  plan.lidar.turbulence = turbulence;
  return plan;
}
Shot nadir(std::int64_t pulse, double height_m) {
  Shot shot;
  shot.pulse = pulse, shot.half_divergence_rad = 2.5e-4;
  shot.exit_m = shot.pupil_m = {0, 0, height_m};
  shot.exit_axis = shot.pupil_axis = {0, 0, -1}, shot.exit_u = shot.pupil_u = {1, 0, 0};
  return shot;
}

}  // namespace

TEST_CASE("L-17: Hufnagel-Valley profile, Fried's length and isoplanatic angle of vertical paths") {
  const auto t = hufnagel_valley();
  CHECK(std::abs(cn2_at(t, 0) / 1.727e-14 - 1) < 1e-12);
  CHECK(std::abs(cn2_at(t, 100) / 6.506537e-15 - 1) < 1e-7);
  CHECK(std::abs(cn2_at(t, 1000) / 1.393944e-16 - 1) < 4e-7);
  CHECK(std::abs(cn2_at(t, 10000) / 1.665732e-17 - 1) < 4e-7);
  CHECK(cn2_at(t, -50) == cn2_at(t, 0));
  CHECK(cn2_at(constant(3e-15), 700) == 3e-15);
  // Five digits of the specification's own quadrature; textbook values (Sasiela) are met within 0.2 %.
  const double table[][5] = {{21, 4.9606e-2, 6.8942e-6, 4.96e-2, 6.90e-6},
                             {35, 4.6754e-2, 3.9578e-6, 4.67e-2, 3.95e-6},
                             {54, 4.1854e-2, 2.4001e-6, 4.18e-2, 2.40e-6},
                             {72, 3.7037e-2, 1.7106e-6, 3.70e-2, 1.71e-6}};
  for (const auto& row : table) {
    const PathNodes path = path_nodes(hufnagel_valley(row[0]), {100e3, 0, 100e3});
    CAPTURE(row[0]);
    CHECK(std::abs(fried_plane_m(path, 0.5e-6) / row[1] - 1) < 3e-5);
    CHECK(std::abs(isoplanatic_angle_rad(path, 0.5e-6) / row[2] - 1) < 3e-5);
    CHECK(std::abs(fried_plane_m(path, 0.5e-6) / row[3] - 1) < 2e-3);
    CHECK(std::abs(isoplanatic_angle_rad(path, 0.5e-6) / row[4] - 1) < 2e-3);
  }
}

TEST_CASE("L-17: Rytov variances and Fried's lengths of level paths") {
  struct Row {
    double cn2, length_m, wavelength_m, plane, spherical, fried, fried_point;
  };
  for (const Row& r : {Row{1e-14, 1e3, 1064e-9, 0.308804, 0.124651, 4.997e-2, 9.001e-2},
                       Row{1e-14, 5e3, 1064e-9, 5.90375, 2.3831, 1.9025e-2, 3.427e-2},
                       Row{1e-13, 1e3, 1064e-9, 3.08804, 1.24651, 1.2552e-2, 2.261e-2},
                       Row{1e-14, 1e3, 3.3e-6, 0.0824484, 0.033281, 19.44e-2, 35.01e-2}}) {
    const PathNodes path = level_path(r.cn2, r.length_m);
    // The table takes 1.23 for 2.25 * 6/11 = 1.22727 in the plane wave, and 0.4967 rounded.
    CHECK(std::abs(rytov_plane(path, r.wavelength_m) / r.plane - 1) < 2.5e-3);
    CHECK(std::abs(rytov_spherical(path, r.wavelength_m) / r.spherical - 1) < 2.5e-3);
    CHECK(std::abs(fried_plane_m(path, r.wavelength_m) / r.fried - 1) < 2.7e-4);
    CHECK(std::abs(fried_at_start_m(path, r.wavelength_m) / r.fried_point - 1) < 2e-4);
    // Closed forms: 6/11 L^(11/6); Beta(11/6, 11/6) L^(11/6); 3/8 L.
    const double k76 = std::pow(2 * M_PI / r.wavelength_m, 7.0 / 6) * r.cn2 * std::pow(r.length_m, 11.0 / 6);
    CHECK(std::abs(rytov_plane(path, r.wavelength_m) / (2.25 * 6 / 11 * k76) - 1) < 1e-8);
    CHECK(std::abs(rytov_spherical(path, r.wavelength_m) / (2.25 * std::beta(11.0 / 6, 11.0 / 6) * k76) - 1) < 1e-8);
    CHECK(std::abs(fried_at_start_m(path, r.wavelength_m) /
                       (fried_plane_m(path, r.wavelength_m) * std::pow(3.0 / 8, -0.6)) -
                   1) < 1e-8);
    CHECK(std::abs(fried_at_end_m(path, r.wavelength_m) / fried_at_start_m(path, r.wavelength_m) - 1) < 1e-8);
  }
}

TEST_CASE(
    "L-33: looking down from 1 km, turbulence near the aperture counts for spot and image, near the ground for the "
    "target alone") {
  const PathNodes down = path_nodes(hufnagel_valley(), {1000, 1000, 0}),
                  up = path_nodes(hufnagel_valley(), {1000, 0, 1000});
  CHECK(std::abs(rytov_spherical(down, 1064e-9) / 0.01361 - 1) < 4e-4);
  CHECK(std::abs(fried_at_start_m(down, 1064e-9) / 0.717 - 1) < 7e-4);
  CHECK(std::abs(fried_at_end_m(down, 1064e-9) / 0.155 - 1) < 3.5e-3);
  // The same air the other way round.
  CHECK(fried_at_start_m(up, 1064e-9) == doctest::Approx(fried_at_end_m(down, 1064e-9)).epsilon(1e-7));
  CHECK(rytov_spherical(up, 1064e-9) == doctest::Approx(rytov_spherical(down, 1064e-9)).epsilon(1e-7));
  // A plane wave flickers by the turbulence far from its receiver.
  CHECK(rytov_plane(up, 1064e-9) > 3 * rytov_plane(down, 1064e-9));
  // Shots use the start's: twice the height, the same axis.
  const LidarPlan plan = airborne_plan(hufnagel_valley());
  CHECK(turbulence_statistics(plan, 0, nadir(0, 1000)).fried_m ==
        doctest::Approx(fried_at_start_m(down, 1064e-9)).epsilon(1e-9));
  // Heights count from the ground, wherever the scene's zero is.
  CHECK(turbulence_statistics(plan, 250, nadir(0, 1250)).fried_m ==
        doctest::Approx(fried_at_start_m(down, 1064e-9)).epsilon(1e-9));
}

TEST_CASE("L-17: heights count from the ground below the path, whatever the beam hits and wherever it is") {
  const auto t = hufnagel_valley();
  LidarPlan plan = airborne_plan(t);
  plan.lidar.gate.start_s = 0, plan.lidar.gate.bin_s = 1e-6;  // 150 km: no end of the path
  const double wavelength_m = plan.lidar.pulse.lines.front().wavelength_um * 1e-6, k = 2 * M_PI / wavelength_m;
  const auto ground_at = [](double z) { return [z](double, double) { return z; }; };
  Shot level = nadir(0, 300);
  level.exit_axis = {0, 1, 0};
  // All of a level path lies at 300 m over the ground; [0.423 k^2 Cn2 3/8 L]^(-3/5).
  const double level_m = std::pow(0.423 * k * k * cn2_at(t, 300) * 0.375 * 1000, -0.6);
  CHECK(level_m == doctest::Approx(0.345).epsilon(1e-3));
  CHECK(turbulence_statistics(plan, {ground_at(0), 1000}, level).fried_m == doctest::Approx(level_m).epsilon(1e-7));
  CHECK(turbulence_statistics(plan, {nullptr, 1000}, level).path_m == 1000);
  // The same over ground that lies higher than the scene's zero, and along a slope.
  level.exit_m[2] = 2100;
  CHECK(turbulence_statistics(plan, {ground_at(1800), 1000}, level).fried_m == doctest::Approx(level_m).epsilon(1e-7));
  Shot slope = nadir(0, 300);
  slope.exit_axis = {0.6, 0, 0.8};
  const auto rising = [](double x, double) { return x * 0.8 / 0.6; };
  CHECK(turbulence_statistics(plan, {rising, 1000}, slope).fried_m == doctest::Approx(level_m).epsilon(1e-7));

  // Waves of the ground under a slanting path, against 4e6 steps.
  const auto waves = [](double x, double y) { return 30 * std::sin(x / 40) + 20 * std::cos(y / 90); };
  Shot slant = nadir(0, 120);
  slant.exit_axis = {0.6, 0.76, 0.25};
  const double norm = std::sqrt(0.36 + 0.5776 + 0.0625), length = 3000;
  for (double& c : slant.exit_axis) c /= norm;
  constexpr int steps = 4000000;
  double start = 0, plane = 0;
  for (int i = 0; i < steps; ++i) {
    const double z = (i + 0.5) / steps * length;
    const double cn2 = cn2_at(t, 120 + slant.exit_axis[2] * z - waves(slant.exit_axis[0] * z, slant.exit_axis[1] * z)) *
                       length / steps;
    start += cn2 * std::pow(1 - z / length, 5.0 / 3), plane += cn2 * std::pow(length - z, 5.0 / 6);
  }
  const TurbulenceTruth found = turbulence_statistics(plan, {waves, length}, slant);
  CHECK(found.fried_m == doctest::Approx(std::pow(0.423 * k * k * start, -0.6)).epsilon(1e-6));
  CHECK(found.rytov_plane == doctest::Approx(2.25 * std::pow(k, 7.0 / 6) * plane).epsilon(1e-6));
  CHECK(found.start_height_m == doctest::Approx(100));

  // From the ground to space, ground at 1500 m: the profile's own name, 5 cm and 7 urad at 500 nm.
  plan.lidar.pulse.lines.front().wavelength_um = 0.5;
  Shot up = nadir(0, 1500);
  up.exit_axis = {0, 0, 1};
  const TurbulenceTruth space = turbulence_statistics(plan, {ground_at(1500), 100e3}, up);
  CHECK(std::abs(space.fried_plane_m / 4.9606e-2 - 1) < 3e-5);
  CHECK(std::abs(space.isoplanatic_rad / 6.8942e-6 - 1) < 3e-5);
  CHECK(space.end_height_m == 100e3);
}

TEST_CASE("S31: spread, wander and short-term spot of the worked beams") {
  struct Row {
    double exit_m, cn2, diffraction_m, rho0_m, long_m, wander_m, short_m;
  };
  for (const Row& r : {Row{0.05, 1e-14, 50.457e-3, 42.804e-3, 51.683e-3, 4.546e-3, 50.876e-3},
                       Row{0.025, 1e-13, 28.435e-3, 10.752e-3, 52.849e-3, 16.138e-3, 41.848e-3}}) {
    const PathNodes path = level_path(r.cn2, 1000);
    const double angle = 1064e-9 / (M_PI * r.exit_m), w = std::hypot(r.exit_m, angle * 1000);
    CHECK(std::abs(w / r.diffraction_m - 1) < 2e-5);
    CHECK(std::abs(fried_at_start_m(path, 1064e-9) / 2.1 / r.rho0_m - 1) < 2e-3);  // r0 / rho0 = 2.10 rounded
    const double long_term = long_term_radius_m(path, 1064e-9, w), wander = wander_sigma_m(path, r.exit_m, 0, false);
    CHECK(std::abs(long_term / r.long_m - 1) < 2e-5);
    CHECK(std::abs(wander / r.wander_m - 1) < 2e-4);
    CHECK(std::abs(short_term_radius(long_term, wander, w).radius_m / r.short_m - 1) <
          1e-4);  // the table's 0.7614 is 2.284 / 3 rounded up
    // Conventions: 0.7614 Cn2 L^3 w^(-1/3) per axis, and 2.42 for both axes.
    CHECK(wander * wander == doctest::Approx(2.284 / 3 * r.cn2 * 1e9 * std::pow(r.exit_m, -1.0 / 3)).epsilon(1e-8));
    const double andrews = wander_sigma_m(path, r.exit_m, 0, true);
    CHECK(2 * andrews * andrews == doctest::Approx(2.42 * r.cn2 * 1e9 * std::pow(r.exit_m, -1.0 / 3)).epsilon(1e-8));
    CHECK(wander_sigma_m(path, r.exit_m, angle, false) < wander);  // a growing beam wanders less
  }
  CHECK(short_term_radius(0.05, 0.03, 0.045).clamped);
  CHECK(short_term_radius(0.05, 0.03, 0.045).radius_m == 0.045);
}

TEST_CASE("L-19: short-term spots that wander add up to the long-term spot (Monte Carlo)") {
  // N = 40000 shots; second moment per axis of the mean spot = wander variance + w_ST^2 / 4; relative error of a
  // variance sqrt(2 / N), 4 of them.
  for (const bool andrews : {false, true}) {
    LidarPlan plan = airborne_plan(constant(2e-13));
    plan.lidar.turbulence.andrews_wander = andrews;
    plan.lidar.pulse.exit_radius_m = 0.02;
    plan.lidar.gate.bins = 10;
    constexpr int n = 40000;
    double xx = 0, yy = 0, xy = 0, short_m = 0, long_m = 0, sigma_m = 0;
    for (int pulse = 0; pulse < n; ++pulse) {
      Shot shot = nadir(pulse, 800);
      shot.half_divergence_rad = 2e-5;
      const TurbulenceTruth truth = apply_turbulence(plan, 0, shot);
      const double x = -shot.exit_axis[0] / shot.exit_axis[2] * 800, y = -shot.exit_axis[1] / shot.exit_axis[2] * 800;
      xx += x * x / n, yy += y * y / n, xy += x * y / n;
      short_m = std::hypot(0.02, std::tan(shot.half_divergence_rad) * 800), long_m = truth.long_term_m,
      sigma_m = truth.wander_sigma_m;
      REQUIRE(!truth.spread_clamped);
      if (pulse == 7) {
        CHECK(std::abs(shot.exit_axis[0] * shot.exit_u[0] + shot.exit_axis[1] * shot.exit_u[1] +
                       shot.exit_axis[2] * shot.exit_u[2]) < 1e-15);
        CHECK(short_m == doctest::Approx(truth.short_term_m).epsilon(1e-12));
        CHECK(x == doctest::Approx(800 * std::tan(truth.wander_rad[0])).epsilon(1e-9));
      }
    }
    const double error = 4 * std::sqrt(2.0 / n);
    CHECK_WITHIN(xx / (sigma_m * sigma_m) - 1, error);
    CHECK_WITHIN(yy / (sigma_m * sigma_m) - 1, error);
    CHECK_WITHIN(xy / (sigma_m * sigma_m), 4 / std::sqrt(n));
    CHECK_WITHIN((4 * xx + short_m * short_m) / (long_m * long_m) - 1,
                 error * 4 * sigma_m * sigma_m / (long_m * long_m));
    CHECK_WITHIN((4 * yy + short_m * short_m) / (long_m * long_m) - 1,
                 error * 4 * sigma_m * sigma_m / (long_m * long_m));
  }
}

TEST_CASE("L-20: angle of arrival and image blur") {
  const PathNodes path = level_path(1e-14, 1000);
  const double plane = fried_plane_m(path, 1064e-9), point = fried_at_start_m(path, 1064e-9);
  CHECK(std::abs(image_tilt_rad(1064e-9, plane, 0.1) / 7.82e-6 - 1) < 7e-4);
  CHECK(std::abs(image_tilt_rad(1064e-9, point, 0.1) / 4.79e-6 - 1) < 1.1e-3);
  CHECK(std::abs(wave_tilt_rad(1064e-9, plane, 0.1) / 8.09e-6 - 1) < 7e-4);
  CHECK(std::pow(image_tilt_rad(1064e-9, plane, 0.1), 2) ==
        doctest::Approx(2.84 * 1e-14 * 1e3 * std::pow(0.1, -1.0 / 3)).epsilon(1e-3));
  CHECK(std::pow(image_tilt_rad(1064e-9, point, 0.1), 2) ==
        doctest::Approx(1.065 * 1e-14 * 1e3 * std::pow(0.1, -1.0 / 3)).epsilon(1e-3));
  CHECK(std::pow(wave_tilt_rad(1064e-9, plane, 0.1), 2) ==
        doctest::Approx(3.04 * 1e-14 * 1e3 * std::pow(0.1, -1.0 / 3)).epsilon(2e-3));
  CHECK(long_exposure_mtf(0, 1064e-9, 0.05) == 1);
  CHECK(long_exposure_mtf(0.05 / 1064e-9, 1064e-9, 0.05) == doctest::Approx(std::exp(-3.44)).epsilon(1e-12));
  CHECK(short_exposure_mtf(0.1 / 1064e-9, 1064e-9, 0.05, 0.1) ==
        1);  // at the aperture's cut-off the tilt was all there was
  CHECK(short_exposure_mtf(0.0125 / 1064e-9, 1064e-9, 0.05, 0.1) ==
        doctest::Approx(std::exp(-3.44 * std::pow(0.25, 5.0 / 3) * 0.5)).epsilon(1e-12));
}

TEST_CASE("S31: temporal broadening is what the specification says: nothing to see") {
  CHECK(std::sqrt(broadening_s2(level_path(1e-14, 5000), 1)) == doctest::Approx(4.2e-14).epsilon(1e-2));
  CHECK(std::sqrt(broadening_s2(level_path(1e-13, 50000), 10)) == doctest::Approx(2.8e-12).epsilon(2e-2));
  CHECK(broadened_fwhm_s(4e-9, 0) == 4e-9);
  CHECK(broadened_fwhm_s(0, 1e-24) == doctest::Approx(1e-12 * std::sqrt(2 * M_LN2)).epsilon(1e-12));
}

TEST_CASE("S31: broadening adds to the pulse's variance in quadrature, where it can be seen at all") {
  const auto variance = [](const PulseTaps& taps) {
    double mean = 0, square = 0;
    for (int i = 0; i < taps.taps; ++i) mean += taps.share[static_cast<std::size_t>(i)] * i;
    for (int i = 0; i < taps.taps; ++i) square += taps.share[static_cast<std::size_t>(i)] * (i - mean) * (i - mean);
    return square;
  };
  LidarPlan plan = airborne_plan(constant(1e-14));
  plan.lidar.pulse.fwhm_s = 4e-9, plan.lidar.gate.bin_s = 1e-9;
  plan.taps = make_taps(plan.lidar.pulse, 1e-9);
  const double before = variance(plan.taps);
  CHECK_FALSE(broaden_pulse(plan, std::pow(4.2e-14, 2)));  // (4.2e-14 / 3.4e-9)^2 / 2 = 8e-11 of the width
  CHECK(plan.lidar.pulse.fwhm_s == 4e-9);
  // The squared half width at 1/e2 of power is 4 variances.
  CHECK(broaden_pulse(plan, 4e-18));
  CHECK(variance(plan.taps) - before == doctest::Approx(1).epsilon(1e-4));
  plan.lidar.pulse.shape = scene::PulseShape::rectangular;
  CHECK_FALSE(broaden_pulse(plan, 4e-18));
  plan.lidar.pulse.shape = scene::PulseShape::gaussian, plan.lidar.turbulence.broadening = false;
  CHECK_FALSE(broaden_pulse(plan, 4e-18));
}

TEST_CASE(
    "S31: each effect can be switched off, none changes anything without turbulence, and a tilt keeps the pupil's "
    "frame") {
  const auto axes = [](const Shot& s) {
    return std::array<double, 6>{s.exit_axis[0],  s.exit_axis[1],  s.half_divergence_rad,
                                 s.pupil_axis[0], s.pupil_axis[1], s.gain};
  };
  for (int only = -1; only < 4; ++only) {
    LidarPlan plan = airborne_plan(constant(1e-13));
    plan.lidar.turbulence.spread = only == 0, plan.lidar.turbulence.wander = only == 1;
    plan.lidar.turbulence.blur = only == 2, plan.lidar.turbulence.scintillation = only == 3;
    Shot shot = nadir(3, 900);
    apply_turbulence(plan, 0, shot);
    const auto a = axes(shot), b = axes(nadir(3, 900));
    CAPTURE(only);
    CHECK((a[2] > b[2]) == (only == 0));
    CHECK((a[0] != b[0]) == (only == 1));
    CHECK((a[3] != b[3]) == (only == 2));
    CHECK((a[5] != b[5]) == (only == 3));
    CHECK(std::abs(shot.pupil_axis[0] * shot.pupil_u[0] + shot.pupil_axis[1] * shot.pupil_u[1] +
                   shot.pupil_axis[2] * shot.pupil_u[2]) < 1e-15);
  }
  LidarPlan none = airborne_plan({});
  Shot shot = nadir(3, 900);
  CHECK(apply_turbulence(none, 0, shot).gain == 1);
  CHECK(axes(shot) == axes(nadir(3, 900)));
  LidarPlan still = airborne_plan(constant(0));
  apply_turbulence(still, 0, shot);
  CHECK(axes(shot) == axes(nadir(3, 900)));
}

TEST_CASE("S31: where models are stretched the truth says so") {
  LidarPlan plan = airborne_plan(constant(1e-12));
  plan.lidar.gate.start_s = 0, plan.lidar.gate.bin_s = 1e-7;  // 15 km
  Shot level = nadir(0, 20);
  level.exit_axis = {0, 1, 0}, level.exit_u = {1, 0, 0};
  const TurbulenceTruth truth = turbulence_statistics(plan, 0, level);
  CHECK(truth.path_m == doctest::Approx(14989.6229).epsilon(1e-6));
  CHECK(truth.rytov_plane > 25);
  CHECK(truth.gamma_gamma);
  CHECK(truth.warnings.size() >= 3);
  // A beam of the coherence length's width wanders by part of its spread; one from a point by all of it.
  LidarPlan wide = airborne_plan(hufnagel_valley());
  CHECK(turbulence_statistics(wide, 0, nadir(0, 1000)).spread_clamped);
  wide.lidar.pulse.exit_radius_m = 1;
  CHECK(turbulence_statistics(wide, 0, nadir(0, 1000)).warnings.empty());
}
