// Speckle modes: the integral's published values, an annulus, discs, and a simulated field (direct sum of random
// scatterers).
#include <doctest/doctest.h>

#include <cmath>
#include <complex>
#include <random>

#include "host/lidar/speckle.h"
#include "tests/oracle/lidar_detection_cases.h"
#include "tests/support/chance_checks.h"

using namespace raycube;
using namespace raycube::lidar;

TEST_CASE("L-21: spatial modes of a Gaussian spot, exact integral") {
  struct Row {
    double diameter_m, w_m, wavelength_m, range_m, exact, approximate;
  };
  for (const Row& r :
       {Row{0.10, 0.25, 1064e-9, 1000, 1383.33, 1363.19}, Row{0.10, 0.020, 3.3e-6, 200, 25.6946, 23.6575},
        Row{0.020, 0.0125, 1064e-9, 100, 16.0665, 14.6219}, Row{0.020, 0.0020, 1064e-9, 100, 1.36566, 1.34872}}) {
    CAPTURE(r.exact);
    CHECK(std::abs(spatial_modes(r.diameter_m / 2, 0, true, r.w_m, r.wavelength_m, r.range_m) / r.exact - 1) <
          4e-6);  // six digits printed
    const double cell = std::pow(r.wavelength_m * r.range_m / r.w_m, 2) / M_PI;
    CHECK(std::abs((1 + M_PI * r.diameter_m * r.diameter_m / 4 / cell) / r.approximate - 1) < 4e-6);
  }
}

TEST_CASE("L-21: limits: one mode for a small pupil, area over speckle area for a large one, discs and annuli") {
  CHECK(spatial_modes(1e-6, 0, true, 0.01, 1e-6, 1000) == doctest::Approx(1).epsilon(1e-9));
  CHECK(spatial_modes(0.05, 0, true, 0, 1e-6, 1000) == 1);
  // Speckle much smaller than the pupil: integral of the coherence alone, (lambda R)^2 / (pi w^2) and, for a disc,
  // (lambda R)^2 / (pi a^2).
  const double large = M_PI * 0.25 / std::pow(1e-6 * 1000, 2);
  CHECK(spatial_modes(0.5, 0, true, 1, 1e-6, 1000) ==
        doctest::Approx(large * M_PI).epsilon(2e-3));  // next order: speckle size over pupil size
  CHECK(spatial_modes(0.5, 0, false, 1, 1e-6, 1000) == doctest::Approx(large * M_PI).epsilon(2e-3));
  // An annulus counts by its own area where speckle is small.
  CHECK(spatial_modes(0.5, 0.3, true, 1, 1e-6, 1000) == doctest::Approx(large * (1 - 0.36) * M_PI).epsilon(4e-3));
  // Autocorrelation of the annulus: area at 0, nothing beyond the diameter, total = area squared.
  CHECK(pupil_autocorrelation(0.5, 0.3, 0) == doctest::Approx(M_PI * 0.16).epsilon(1e-14));
  CHECK(pupil_autocorrelation(0.5, 0.3, 1) == 0);
  double total = 0;
  constexpr int n = 20000;
  for (int i = 0; i < n; ++i) total += 2 * M_PI * (i + 0.5) / n * pupil_autocorrelation(0.5, 0.3, (i + 0.5) / n) / n;
  CHECK(total == doctest::Approx(std::pow(M_PI * 0.16, 2)).epsilon(1e-6));
}

TEST_CASE("S35: effective area of the sub-rays' footprint is pi w^2 for a Gaussian, and of half of them half") {
  std::vector<double> energy, cell;
  constexpr int n = 1000;
  const double w = 0.25;
  for (int i = 0; i < n; ++i) {  // equal-energy rings: cell = energy share over irradiance share 2 / (pi w^2) (1 - u)
    energy.push_back(1.0 / n), cell.push_back(1.0 / n / (2 / (M_PI * w * w) * (1 - (i + 0.5) / n)));
  }
  CHECK(effective_area_m2(energy, cell) == doctest::Approx(M_PI * w * w).epsilon(1e-12));
  for (int i = 0; i < n; i += 2) energy[static_cast<std::size_t>(i)] = 0;
  CHECK(effective_area_m2(energy, cell) == doctest::Approx(0.5 * M_PI * w * w).epsilon(2e-3));
  CHECK(effective_area_m2({}, {}) == 0);
}

TEST_CASE("L-21: modes agree with a simulated field: random scatterers summed at the points of the pupil") {
  // 400 scatterers of random phase, Gaussian spot, far field phase exp(i k x.p / R). M = mean^2 / variance of the
  // pupil's power over
  // 4000 fields; relative error of a variance estimate near sqrt(2 + 6/M) / sqrt(4000), 4 standard errors; the field of
  // 400 phasors is Gaussian to 1 / 400 of its variance.
  constexpr int fields = 4000, scatterers = 400, side = 13;
  const double w = 0.0125, wavelength = 1064e-9, range = 100, radius = 0.005, k = 2 * M_PI / wavelength;
  std::vector<std::array<double, 2>> points;
  for (int i = 0; i < side; ++i)
    for (int j = 0; j < side; ++j) {
      const double x = radius * (2 * (i + 0.5) / side - 1), y = radius * (2 * (j + 0.5) / side - 1);
      if (x * x + y * y < radius * radius) points.push_back({x, y});
    }
  std::mt19937_64 random(raycube::testing::seed(3));
  std::uniform_real_distribution<double> unit(0, 1);
  std::normal_distribution<double> normal(0, 0.5 * w);
  double sum = 0, squares = 0;
  std::vector<std::complex<double>> column(side), row(side);
  for (int f = 0; f < fields; ++f) {
    std::vector<std::complex<double>> field(static_cast<std::size_t>(side * side));
    for (int s = 0; s < scatterers; ++s) {
      const double x = normal(random), y = normal(random), phase = 2 * M_PI * unit(random), step = 2 * radius / side;
      // Phases along the lattice by repeated multiplication: the sum is still the direct one.
      const auto turn_x = std::polar(1.0, k * x * step / range), turn_y = std::polar(1.0, k * y * step / range);
      column[0] = std::polar(1.0, phase + k * (x + y) * (0.5 * step - radius) / range), row[0] = 1;
      for (std::size_t i = 1; i < side; ++i) column[i] = column[i - 1] * turn_x, row[i] = row[i - 1] * turn_y;
      for (std::size_t i = 0; i < side; ++i)
        for (std::size_t j = 0; j < side; ++j) field[i * side + j] += column[i] * row[j];
    }
    double power = 0;
    for (int i = 0; i < side; ++i)
      for (int j = 0; j < side; ++j) {
        const double x = radius * (2 * (i + 0.5) / side - 1), y = radius * (2 * (j + 0.5) / side - 1);
        if (x * x + y * y < radius * radius) power += std::norm(field[static_cast<std::size_t>(i * side + j)]);
      }
    sum += power, squares += power * power;
  }
  const double mean = sum / fields, variance = squares / fields - mean * mean, measured = mean * mean / variance;
  const double expected = spatial_modes(radius, 0, true, w, wavelength, range);
  CAPTURE(measured);
  CAPTURE(expected);
  CHECK_WITHIN(measured / expected - 1,
               4 * std::sqrt((2 + 6 / expected) / fields) + 0.01);  // 0.01: 137 points stand for the disc
}

TEST_CASE("S35: modes of polarisation and of the line multiply; widths in Hz") {
  CHECK(line_width_hz(1.064, 1e-5) == doctest::Approx(2.648e9).epsilon(2e-4));
  CHECK(line_width_hz(3.3, 1e-4) == doctest::Approx(2.753e9).epsilon(2e-4));
  CHECK(temporal_modes(0, 4e-9) == 1);
  CHECK(temporal_modes(2.648e9, 4e-9) == doctest::Approx(std::sqrt(1 + 10.592 * 10.592)).epsilon(1e-9));
  scene::Lidar lidar = test::small_plan().lidar;
  const double two = speckle_modes(lidar, 0, 2.5e-4, 1000);
  CHECK(two == doctest::Approx(2 * 1383.33).epsilon(4e-6));
  lidar.speckle.polarization_modes = 1;
  CHECK(speckle_modes(lidar, 0, 2.5e-4, 1000) == doctest::Approx(0.5 * two).epsilon(1e-14));
}

TEST_CASE("S35: a return shares one draw, two returns have their own; factors have mean 1 and variance 1 / M") {
  LidarPlan plan = test::small_plan();
  plan.lidar.speckle.on = true;
  plan.lidar.pulse.half_divergence_rad = 2e-6, plan.lidar.receiver.aperture_radius_m = 0.01;
  std::vector<float> floats(200, 0.0F);
  test::add_return(floats, 1000, 60.3, 1.7), test::add_return(floats, 500, 120.8, 1.7);
  const std::vector<double> expected(floats.begin(), floats.end());
  double sum = 0, squares = 0, both = 0, modes = 0;
  constexpr int n = 4000;
  for (int i = 0; i < n; ++i) {
    Shot shot;
    shot.pulse = i, shot.half_divergence_rad = 2e-6;
    const SpeckleRow row = speckle_row(plan, shot, 0, 0, expected);
    modes = row.strongest_modes;
    REQUIRE(row.factor[57] == row.factor[64]);
    REQUIRE(row.factor[57] != row.factor[120]);
    const double a = row.factor[60] - 1, b = row.factor[120] - 1;
    sum += a, squares += a * a, both += a * b;
  }
  CHECK(modes == doctest::Approx(speckle_modes(plan.lidar, 0, 2e-6, 0.5 * 299792458.0 * 6660.3e-9))
                     .epsilon(1e-3));  // the row's modes lie on a power of the range between exact ones
  CHECK_WITHIN(sum / n, 4 / std::sqrt(modes * n));
  CHECK_WITHIN(squares / n * modes - 1, 4 * std::sqrt((2 + 6 / modes) / n));
  CHECK_WITHIN(both / n * modes, 4 / std::sqrt(n));
}
