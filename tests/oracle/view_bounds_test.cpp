// Extremes of an instrument's view without walking all of it: the very numbers of a walk over every pixel,
// soon, and stopped by Ctrl-C.
#include <doctest/doctest.h>

#include <cmath>
#include <csignal>
#include <limits>
#include <numbers>
#include <random>

#include <glm/geometric.hpp>

#include "host/base/error.h"
#include "host/base/interrupt.h"
#include "host/sensors/ray_groups.h"
#include "host/sensors/view_bounds.h"
#include "tests/support/patience.h"

using namespace raycube;

namespace {

/// Every pixel's centre and corners, as the kernels' rays have them.
plan::ViewBounds walked(scene::Instrument instrument) {
  instrument.motion = sensors::pose_moves(instrument) ? scene::PoseMotion::moving : scene::PoseMotion::held;
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  plan::ViewBounds bounds{kInfinity, -kInfinity, kInfinity, -kInfinity, kInfinity, -kInfinity, 0};
  const int width = sensors::pixels_per_group(instrument);
  const double half = 0.5 * std::max(1.0, instrument.psf_support_px);
  for (int line = 0; line < instrument.lines; ++line) {
    const auto groups = sensors::make_ray_groups(instrument, line, 1);
    for (int sample = 0; sample < instrument.pixels; ++sample) {
      const auto& g = groups[static_cast<std::size_t>(sample / width)];
      const double a = sample % width - 0.5 * (width - 1);
      for (const auto& [u, v] : {std::pair{0.0, 0.0}, {-half, -half}, {-half, half}, {half, -half}, {half, half}}) {
        const glm::dvec3 d = glm::dvec3(g.d0.x, g.d0.y, g.d0.z) + (a + u) * glm::dvec3(g.du.x, g.du.y, g.du.z) +
                             v * glm::dvec3(g.dv.x, g.dv.y, g.dv.z);
        const glm::dvec3 to_sensor = -d / glm::length(d);
        bounds.sec_min = std::min(bounds.sec_min, 1 / to_sensor.z),
        bounds.sec_max = std::max(bounds.sec_max, 1 / to_sensor.z);
        bounds.x_min = std::min(bounds.x_min, to_sensor.x), bounds.x_max = std::max(bounds.x_max, to_sensor.x);
        bounds.y_min = std::min(bounds.y_min, to_sensor.y), bounds.y_max = std::max(bounds.y_max, to_sensor.y);
      }
    }
  }
  return bounds;
}

void check_same(const scene::Instrument& instrument) {
  const auto found = sensors::view_bounds(instrument), wanted = walked(instrument);
  CHECK(found.sec_min == wanted.sec_min);
  CHECK(found.sec_max == wanted.sec_max);
  CHECK(found.x_min == wanted.x_min);
  CHECK(found.x_max == wanted.x_max);
  CHECK(found.y_min == wanted.y_min);
  CHECK(found.y_max == wanted.y_max);
}

scene::Instrument camera(scene::InstrumentKind kind, int pixels, int lines, double across_rad, double along_rad) {
  scene::Instrument c;
  c.name = "c";
  c.kind = kind;
  c.pixels = pixels, c.lines = lines;
  c.ifov_across_rad = across_rad, c.ifov_along_rad = along_rad;
  return c;
}

}  // namespace

TEST_CASE("bounds of a view are those of a walk over every pixel, to the bit") {
  std::mt19937 draw(4);
  const auto between = [&](double low, double high) { return std::uniform_real_distribution<double>(low, high)(draw); };
  for (int trial = 0; trial < 24; ++trial) {
    CAPTURE(trial);
    // Fields of 0.02 to 1 rad; one in four looks straight down, one along an axis.
    const int pixels = 300 + static_cast<int>(draw() % 1500), lines = 300 + static_cast<int>(draw() % 900);
    const double tilt = trial % 4 == 0 ? 0 : 25, heading = trial % 3 == 0 ? 90 * double(draw() % 4) : between(0, 360);
    scene::Pose pose{10, 20, between(300, 9000), between(-tilt, tilt), between(-tilt, tilt), heading};
    auto c =
        camera(scene::InstrumentKind::framing, pixels, lines, between(0.02, 1.0) / pixels, between(0.02, 0.8) / lines);
    if (trial % 5 == 0) c.psf_support_px = between(1, 8);
    c.poses = {pose};
    check_same(c);
    c.kind = scene::InstrumentKind::pushbroom;
    c.ifov_along_rad = c.ifov_across_rad;
    c.motion = trial % 2 ? scene::PoseMotion::moving : scene::PoseMotion::held;
    c.poses.clear();
    for (int line = 0; line < lines; ++line) {
      pose.y_m += 0.3;
      if (trial % 3 == 1)
        pose.roll_deg += between(-0.02, 0.02), pose.pitch_deg += between(-0.02, 0.02),
            pose.heading_deg += between(-0.02, 0.02);
      if (trial % 3 == 2 && draw() % 50 == 0)
        pose.roll_deg += between(-1, 1);  // straight stretches with corrections between them
      c.poses.push_back(pose);
    }
    check_same(c);
  }
  auto c = camera(scene::InstrumentKind::whiskbroom, 100, 40, 0.01, 0.01);
  for (int i = 0; i < 4000; ++i) c.poses.push_back({0, 0.1 * i, 500, between(-2, 2), between(-2, 2), between(0, 3)});
  check_same(c);
  check_same([&] {
    auto one = camera(scene::InstrumentKind::framing, 1, 1, 1e-3, 1e-3);
    one.poses = {{0, 0, 100, 0, 0, 0}};
    return one;
  }());
}

TEST_CASE("an image of 1e10 pixels is bounded without a walk over every pixel") {
  const testing::Patience patience("the bounds of two images of 1e10 pixels: moments, and an hour pixel by pixel");
  auto c = camera(scene::InstrumentKind::framing, 100000, 100000, 1e-5, 1e-5);
  c.poses = {{0, 0, 500, 1, 2, 37}};
  const auto bounds = sensors::view_bounds(c);
  CHECK(bounds.sec_min == doctest::Approx(1).epsilon(1e-9));
  // The corner pixels' outer corners: tan of the half field is 0.5 both ways.
  CHECK(bounds.sec_max > 1.224);  // without tilt sqrt(1.5)
  CHECK(bounds.sec_max < 1.30);
  c.kind = scene::InstrumentKind::pushbroom;
  c.poses.assign(100000, {0, 0, 500, 1, 2, 37});
  for (int line = 0; line < 100000; ++line) c.poses[static_cast<std::size_t>(line)].y_m = 0.005 * line;
  sensors::view_bounds(c);
}

TEST_CASE("a telescope's image, all of it flat, is bounded by some of its pixels, and no pixel lies outside") {
  constexpr double kRounding = 4e-7;  // of a direction to floats (host/sensors/view_bounds.cpp)
  auto c = camera(scene::InstrumentKind::framing, 3000, 2500, 1e-7, 1e-7);
  for (const double tilt_deg : {0.0, 20.0, 60.0}) {
    CAPTURE(tilt_deg);
    c.poses = {{0, 0, 500, 3, tilt_deg, 37}};
    const auto found = sensors::view_bounds(c), wanted = walked(c);
    const auto holds = [](double wider, double walk) { CHECK((wider >= walk && wider - walk <= 2 * kRounding)); };
    holds(wanted.sec_min / found.sec_min, 1), holds(-found.x_min, -wanted.x_min), holds(-found.y_min, -wanted.y_min);
    holds(found.sec_max / wanted.sec_max, 1), holds(found.x_max, wanted.x_max), holds(found.y_max, wanted.y_max);
  }
  const testing::Patience patience("the bounds of 2^32 pixels in 7e-5 rad: moments, and minutes pixel by pixel");
  c = camera(scene::InstrumentKind::framing, 65536, 65536, 1e-9, 1e-9);
  c.poses = {{0, 0, 500, 0, 20, 0}};
  // Closed form: the ends of a field of 65536 nrad about 20 deg.
  const auto bounds = sensors::view_bounds(c);
  const double middle = 20 * std::numbers::pi / 180, half = std::atan(0.5 * 65536e-9);
  CHECK(bounds.sec_min == doctest::Approx(1 / std::cos(middle - half)).epsilon(2e-6));
  CHECK(bounds.sec_max == doctest::Approx(1 / std::cos(middle + half)).epsilon(2e-6));
}

TEST_CASE("a ray that looks up is refused though few pixels are looked at; Ctrl-C ends it") {
  auto c = camera(scene::InstrumentKind::framing, 40000, 40000, 5e-5, 5e-5);
  c.poses = {{0, 0, 500, 50, 0, 0}};
  CHECK_THROWS_WITH_AS(sensors::view_bounds(c), doctest::Contains("looks up or level"), base::Error);
  c.poses = {{0, 0, 500, 0, 0, 0}};
  base::install_signal_handlers();
  std::raise(SIGINT);
  CHECK_THROWS_WITH_AS(sensors::view_bounds(c), doctest::Contains("interrupted"), base::Error);
  base::clear_interrupt();
}
