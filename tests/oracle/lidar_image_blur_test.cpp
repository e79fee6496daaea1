// Blur of an array's image: sums, a Gaussian-like limit, nothing where nothing is to be seen.
#include <doctest/doctest.h>

#include <cmath>
#include <numeric>

#include "host/lidar/image_blur.h"
#include "host/lidar/quadrature.h"
#include "host/lidar/turbulence.h"
#include "tests/oracle/lidar_detection_cases.h"

using namespace raycube;
using namespace raycube::lidar;

namespace {

LidarPlan array_plan(int side, double pitch_rad) {
  LidarPlan plan = test::small_plan(3);
  plan.lidar.receiver.columns = plan.lidar.receiver.rows = side;
  plan.lidar.receiver.pixel_pitch_rad = pitch_rad;
  plan.lidar.receiver.half_fov_rad = 0;
  return plan;
}

}  // namespace

TEST_CASE("S37: shares of a pixel's blur sum to 1, are symmetric, and fall outwards") {
  const LidarPlan plan = array_plan(32, 20e-6);
  const PixelBlur blur(plan.lidar, 0.03);
  REQUIRE(blur.any());
  double sum = 0;
  for (int v = -blur.reach(); v <= blur.reach(); ++v)
    for (int u = -blur.reach(); u <= blur.reach(); ++u) {
      sum += blur.share(u, v);
      CHECK(blur.share(u, v) == blur.share(-u, v));
      CHECK(blur.share(u, v) == blur.share(v, u));
    }
  CHECK(sum == doctest::Approx(1).epsilon(1e-12));
  CHECK(blur.share(0, 0) > blur.share(1, 0));
  CHECK(blur.share(1, 0) > blur.share(1, 1));
  CHECK(blur.share(1, 0) > 0.02);
  CHECK(blur.share(0, blur.reach() + 1) == 0);
  // Worse air, wider blur; wider pixels, less of it.
  CHECK(PixelBlur(plan.lidar, 0.015).share(0, 0) < blur.share(0, 0));
  CHECK(PixelBlur(array_plan(32, 80e-6).lidar, 0.03).share(0, 0) > blur.share(0, 0));
}

TEST_CASE("S37: a column of pixels gets the line spread integrated over light and pixel, by another quadrature") {
  // Sum over rows leaves one dimension: int M(f) sinc^2(f) cos(2 pi k f) df, M the modulation along the axis alone.
  const double pitch = 20e-6, wavelength = 1.064e-6, diameter = 0.1, fried = 0.03;
  const LidarPlan plan = array_plan(32, pitch);
  const PixelBlur blur(plan.lidar, fried);
  const double cut_off = diameter / wavelength * pitch;  // cycles / pixel
  std::vector<double> expected;
  double total = 0;
  for (int k = 0; k <= blur.reach(); ++k) {
    expected.push_back(2 * integrate(
                               [&](double f) {
                                 const double a = f / cut_off,
                                              aperture = 2 / M_PI * (std::acos(a) - a * std::sqrt(1 - a * a)),
                                              s = std::sin(M_PI * f) / (M_PI * f);
                                 return aperture * short_exposure_mtf(f / pitch, wavelength, fried, diameter) * s * s *
                                        std::cos(2 * M_PI * k * f);
                               },
                               0, cut_off, 20));
    total += (k == 0 ? 1 : 2) * expected.back();
  }
  CHECK(total > 0.96);  // the rest are rings of the aperture's image beyond the reach, given back in proportion
  for (int k = 0; k <= blur.reach(); ++k) {
    double column = 0;
    for (int v = -blur.reach(); v <= blur.reach(); ++v) column += blur.share(k, v);
    CAPTURE(k);
    CHECK(std::abs(column - expected[static_cast<std::size_t>(k)] / total) <
          1 - total);  // rows beyond the reach are cut here alone: at most as much again
  }
}

TEST_CASE(
    "S37: an even image keeps its light away from the rim, a point becomes the blur, and little blur changes nothing") {
  LidarPlan plan = array_plan(15, 20e-6);
  const PixelBlur blur(plan.lidar, 0.05);
  REQUIRE(blur.any());
  REQUIRE(blur.reach() <= 7);
  ShotResult even = test::empty_shot(plan), point = test::empty_shot(plan);
  for (float& bin : even.first) bin = 2;
  const std::size_t middle = 7 * 15 + 7;
  point.first[middle * 3 + 1] = 10;
  blur.apply(plan, even), blur.apply(plan, point);
  CHECK(even.first[middle * 3] == doctest::Approx(2).epsilon(1e-6));
  CHECK(even.first[0] < 2);
  CHECK(std::accumulate(point.first.begin(), point.first.end(), 0.0) == doctest::Approx(10).epsilon(1e-6));
  CHECK(point.first[(middle + 1) * 3 + 1] == doctest::Approx(10 * blur.share(1, 0)).epsilon(1e-6));
  CHECK(point.first[(middle + 15) * 3 + 1] == point.first[(middle + 1) * 3 + 1]);
  CHECK(point.first[middle * 3] == 0);
  CHECK(!PixelBlur(plan.lidar, 0).any());
  CHECK(!PixelBlur(array_plan(15, 1e-3).lidar, 0.05).any());
  CHECK(!PixelBlur(array_plan(1, 20e-6).lidar, 0.05).any());
  plan.lidar.turbulence.blur = false;
  CHECK(!PixelBlur(plan.lidar, 0.05).any());
}
