// How many surfaces light comes by, chosen by a trial: against the series of two half planes that see each other.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "atmos_tables/synthetic.h"
#include "host/planner/bounce_level.h"
#include "host/sensors/view_bounds.h"
#include "tests/support/render_kit.h"

using namespace raycube;

namespace {

constexpr double kSunIrradiance = 1500, kSkyRadiance = 30, kFar_m = 2e4, kZenith_deg = 40;
constexpr double kReflectance = 0.9;

/// Endless ground, with an endless wall of the same matter west of it or none; seen from above 2 to 3 m before it.
scene::Simulation corner(bool wall, double tolerance) {
  scene::Simulation s;
  s.file = "corner.toml";
  const auto grey = test::add_material(s.scene, "grey", kReflectance);
  test::place(s.scene, test::rectangle({0, -kFar_m, 0}, {kFar_m, 0, 0}, {0, 2 * kFar_m, 0}, grey));
  if (wall) test::place(s.scene, test::rectangle({0, -kFar_m, 0}, {0, 2 * kFar_m, 0}, {0, 0, kFar_m}, grey));
  finish_top_tree(s.scene);
  s.tolerance = tolerance;
  s.bounces = scene::kMostChosenBounces, s.bounces_given = false;
  s.sun.zenith_deg = kZenith_deg, s.sun.azimuth_deg = 90;
  auto camera = test::nadir_camera(24, 24, 20, 0.04, 2.5, 0);
  camera.bands = test::gaussian_bands({0.5, 0.7}, 0.01);
  s.instruments = {camera};
  return s;
}

struct Chosen {
  plan::Plan plan;
  double before = 0;  ///< total error without
};
Chosen choose(const scene::Simulation& s) {
  atmos::UniformAir air;
  air.solar_irradiance = [](double) { return kSunIrradiance; };
  air.sky_radiance = [](double) { return kSkyRadiance; };
  air.sun_zenith_deg = s.sun.zenith_deg, air.sun_azimuth_deg = s.sun.azimuth_deg;
  const auto table = atmos::uniform_table(air, atmos::wavelength_grid(0.35, 1.0, 0.005));
  Chosen out{plan::make_plan(s, s.instruments[0], table, sensors::view_bounds(s.instruments[0])), 0};
  out.before = out.plan.report.total_error;
  render::Renderer renderer(s.scene, {});
  planner::choose_bounces(renderer, s, s.instruments[0], out.plan);
  return out;
}

/// Radiosity of the ground by light of at most `levels` more surfaces: either plane sees the other in half of its
/// hemisphere (the corner of render_bounces_test.cpp).
double seen(int levels) {
  const double angle = kZenith_deg * std::numbers::pi / 180, sky = std::numbers::pi * kSkyRadiance / 2;
  double ground = kReflectance * (kSunIrradiance * std::cos(angle) + sky),
         wall = kReflectance * (kSunIrradiance * std::sin(angle) + sky), sum = ground;
  for (int level = 0; level < levels; ++level) {
    const double next = kReflectance * wall / 2;
    wall = kReflectance * ground / 2, ground = next;
    sum += ground;
  }
  return sum;
}
double missed(int levels) { return 1 - seen(levels) / seen(400); }

}  // namespace

TEST_CASE("bounces = auto: levels are the fewest whose series leaves out less than a tenth of the tolerance") {
  // Missed by 0, 1, 2, 4, 8 and 16 levels: 0.42, 0.20, 0.086, 0.017, 7.1e-4 and 1.2e-6; a trial of 8192 paths knows
  // them to some percent: tolerances whose tenth is a factor of 1.5 from any.
  for (const auto& [tolerance, levels] : {std::pair(1.5, 2), {0.4, 4}, {0.05, 8}, {0.002, 16}}) {
    const Chosen chosen = choose(corner(true, tolerance));
    CAPTURE(tolerance);
    CHECK(chosen.plan.bounces.levels == levels);
    const plan::BounceReport& report = chosen.plan.report.bounces;
    CHECK(report.chosen);
    // Two draws of 256 pixels by 16 paths, of which half meet the next surface, and whose light scatters by less than
    // 1.5 of its mean: 4 standard errors; told in sixteenths of a tenth of the tolerance. Beyond four levels it is the
    // series of the levels before: their ratio's error, twice and six times.
    const auto known = [](int n) { return 4 * 1.5 / std::sqrt(8192 * std::pow(0.5, n)); };
    const double step = 0.1 * tolerance / 32;
    CHECK(std::abs(report.once_missed - missed(0)) < known(0) * missed(0) + step);
    CHECK(std::abs(report.missed - missed(levels)) <
          (levels > 4 ? levels / 4 : 1) * known(std::min(levels, 4)) * missed(levels) + step);
    CHECK(chosen.plan.report.total_error == doctest::Approx(std::hypot(chosen.before, report.missed)));
    CHECK(chosen.plan.bounces.curve.size() > 0);
    CHECK(chosen.plan.notices.empty());
  }
}

TEST_CASE("bounces = auto: ground that sees nothing but sky has light scattered once") {
  const Chosen chosen = choose(corner(false, 0.01));
  CHECK(chosen.plan.bounces.levels == 0);
  CHECK(!chosen.plan.bounces.any());
  CHECK(chosen.plan.report.bounces.chosen);
  CHECK(chosen.plan.report.bounces.once_missed == 0);
  CHECK(chosen.plan.report.total_error == chosen.before);
}

TEST_CASE("bounces = auto: black matter among the scene's is none of its light's") {
  auto s = corner(true, 0.4);
  const auto black = test::add_material(s.scene, "black", 0);
  test::place(s.scene, test::rectangle({1000, 1000, 1}, {1, 0, 0}, {0, 1, 0}, black));
  finish_top_tree(s.scene);
  const Chosen chosen = choose(s);
  CHECK(chosen.plan.bounces.levels == 4);
  CHECK(chosen.plan.bounces.strength > 0.1);
  CHECK(chosen.plan.bounces.strength <= 1);
  CHECK(chosen.plan.bounces.error < 1e-6);
  CHECK(chosen.plan.notices.empty());
}

TEST_CASE("bounces = auto: what the file gives stays") {
  auto s = corner(true, 0.01);
  s.bounces = 3, s.bounces_given = true;
  const Chosen chosen = choose(s);
  CHECK(chosen.plan.bounces.levels == 3);
  CHECK(!chosen.plan.report.bounces.chosen);
}
