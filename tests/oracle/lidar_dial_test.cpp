// DIAL: line width after the exponential, several gases, saturation, errors against drawn counts, profiles.
#include <doctest/doctest.h>

#include <cmath>

#include "host/base/error.h"
#include "host/lidar/dial.h"
#include "host/lidar/draws.h"
#include "host/lidar/gauss_hermite.h"
#include "tests/oracle/lidar_detection_cases.h"
#include "tests/support/chance_checks.h"

using namespace raycube;
using namespace raycube::lidar;

namespace {

constexpr double kPpmM = 2.479371580e15;  // molecules / cm2 at 296 K, 101325 Pa

/// Lorentz line of section 6.3: S 2.0e-19 cm / molecule, half width 0.06 / cm.
double lorentz_cm2(double from_centre) { return 2.0e-19 / M_PI * 0.06 / (from_centre * from_centre + 0.06 * 0.06); }

/// Laser line of a width (1 / cm, full at half maximum) about a wavenumber from the line's centre.
LineSection laser(double from_centre, double fwhm, int nodes) {
  LineSection out;
  const HermiteRule rule = gauss_hermite(fwhm > 0 ? nodes : 1);
  for (std::size_t i = 0; i < rule.x.size(); ++i) {
    out.weight.push_back(rule.w[i]);
    out.sigma_cm2.push_back(lorentz_cm2(from_centre + rule.x[i] * fwhm * test::kSigmaOfFwhm));
  }
  return out;
}

NetCounts noiseless(double transmission) { return {1e6 * transmission, 0, 1}; }

}  // namespace

TEST_CASE(
    "L-09: a laser line's width is averaged after the exponential; retrievals with the peak's and the averaged "
    "cross-section") {
  const double peak = lorentz_cm2(0), off_sigma = lorentz_cm2(1.5);
  CHECK(std::abs(peak / 1.061032954e-18 - 1) < 5e-10);
  CHECK(std::abs(off_sigma / 1.694941e-21 - 1) < 3e-7);
  const double voigt[][2] = {{0.02, 1.04094e-18}, {0.05, 9.60463e-19}, {0.10, 8.03856e-19}, {0.20, 5.78628e-19}};
  for (const auto& [fwhm, sigma] : voigt) CHECK(std::abs(laser(0, fwhm, 128).mean_sigma_cm2() / sigma - 1) < 6e-6);
  struct Row {
    double ppm_m, fwhm, on, off, by_peak, by_voigt;
  };
  for (const Row& r :
       {Row{100, 0, 0.5908820, 0.999160, 1, 0}, Row{100, 0.05, 0.6221263, 0.999160, 0.901909, 0.996515},
        Row{100, 0.10, 0.6757258, 0.999160, 0.744581, 0.983298}, Row{1000, 0, 5.188089e-3, 0.991630, 1, 0},
        Row{1000, 0.05, 1.061674e-2, 0.991630, 0.863684, 0.954280},
        Row{1000, 0.10, 3.897977e-2, 0.991630, 0.616089, 0.813611},
        Row{10000, 0.10, 1.484220e-6, 0.919387, 0.253886, 0.335283}}) {
    const double column = r.ppm_m * kPpmM;
    // The off line is narrow against its distance: its own width changes nothing here, as in the table.
    const LineSection on = laser(0, r.fwhm, 64), off = laser(1.5, 0, 1);
    CAPTURE(r.ppm_m);
    CAPTURE(r.fwhm);
    CHECK(std::abs(on.transmission(column) / r.on - 1) < 5e-7);  // half a unit of seven digits
    CHECK(std::abs(off.transmission(column) - r.off) < 5.1e-7);
    const NetCounts n_on = noiseless(on.transmission(column)), n_off = noiseless(off.transmission(column));
    CHECK(std::abs(dial_column(n_on, n_off, peak - off_sigma).column_cm2 / column - r.by_peak) < 1.1e-6);
    if (r.by_voigt > 0)
      CHECK(std::abs(dial_column(n_on, n_off, laser(0, r.fwhm, 128).mean_sigma_cm2() - off_sigma).column_cm2 / column -
                     r.by_voigt) < 2e-6);
    // With the line's shape known there is no bias.
    const DialColumn exact = dial_column_of_line(n_on, n_off, on, off);
    CHECK(exact.state == DialState::good);
    CHECK(std::abs(exact.column_cm2 / column - 1) < 1e-10);
  }
  // 32 nodes are good to 2e-6 where the line is no wider than the feature.
  CHECK(std::abs(laser(0, 0.10, 32).transmission(10000 * kPpmM) / 1.484220e-6 - 1) < 3e-6);
}

TEST_CASE("L-09: an opaque column is saturated with a lower bound, no light is no signal; nothing is NaN") {
  // 10000 ppm m on a monochromatic line: T = 1.4e-23.
  const double column = 10000 * kPpmM, peak = lorentz_cm2(0), transmission = std::exp(-2 * peak * column);
  CHECK(transmission < 2e-23);
  const NetCounts off{1e6, 1e6, 1}, on{1e6 * transmission, 3, 1};
  const DialColumn result = dial_column(on, off, peak);
  CHECK(result.state == DialState::saturated);
  CHECK(result.column_cm2 == doctest::Approx(std::log(1e6 / std::sqrt(3.0)) / (2 * peak)).epsilon(1e-12));
  CHECK(result.column_cm2 < column);
  for (const NetCounts& dark : {NetCounts{0, 0, 1}, NetCounts{-4, 9, 1}, NetCounts{0, 1, 1}}) {
    const DialColumn a = dial_column(dark, off, peak), b = dial_column(off, dark, peak),
                     c = dial_column(dark, dark, peak);
    CHECK(a.state == DialState::saturated);
    CHECK(std::isfinite(a.column_cm2));
    CHECK(std::isfinite(a.error_cm2));
    CHECK(b.state == DialState::no_signal);
    CHECK(b.column_cm2 == 0);
    CHECK(c.state == DialState::no_signal);
    CHECK(dial_column_of_line(dark, off, laser(0, 0.1, 32), laser(1.5, 0, 1)).state == DialState::saturated);
    CHECK(std::isfinite(dial_column_of_line(dark, off, laser(0, 0.1, 32), laser(1.5, 0, 1)).column_cm2));
  }
  CHECK_THROWS_AS(dial_column(on, off, 0), base::Error);
  CHECK_THROWS_AS(dial_column({1, 1, 0}, off, peak), base::Error);
}

TEST_CASE("S33: error of a column against counts drawn") {
  // 6.2: 400 and 1200 counts, sigma 1.061e-18: 2.72e16 / cm2 = 11.0 ppm m.
  const DialColumn one = dial_column({400, 400, 1}, {1200, 1200, 1}, 1.061e-18);
  CHECK(std::abs(one.error_cm2 / 2.72e16 - 1) < 1e-3);
  CHECK(std::abs(one.error_cm2 / kPpmM - 11.0) < 0.05);
  CHECK(dial_column({400, 400, 1}, {1200, 1200, 1}, 1.061e-18, 2.0 / 26).error_cm2 ==
        doctest::Approx(std::sqrt(1.0 / 400 + 1.0 / 1200 + 2.0 / 26) / 2.122e-18).epsilon(1e-12));
  constexpr int n = 20000;
  double sum = 0, squares = 0;
  const double truth = std::log(3.0) / 2.122e-18;
  for (int i = 0; i < n; ++i) {
    Stream on(raycube::testing::seed(5), static_cast<std::uint32_t>(i), 0, DrawFor::counts),
        off(raycube::testing::seed(5), static_cast<std::uint32_t>(i), 1, DrawFor::counts);
    const double a = on.poisson(400), b = off.poisson(1200);
    const double z = (dial_column({a, a, 1}, {b, b, 1}, 1.061e-18).column_cm2 - truth) / one.error_cm2;
    sum += z, squares += z * z;
  }
  // The logarithm's curvature shifts the mean by (1/400 - 1/1200) / 2 of its argument and widens it by 1/400 or so.
  CHECK_WITHIN(sum / n - (1.0 / 400 - 1.0 / 1200) / 2 / std::sqrt(1.0 / 400 + 1.0 / 1200), 4 / std::sqrt(n));
  CHECK_WITHIN(squares / n - 1, 4 * std::sqrt(2.0 / n) + 0.006);
}

TEST_CASE("L-10: two gases at three wavelengths; one wavelength alone is biased") {
  const std::vector<std::vector<double>> sigma{{1.0e-18, 5.0e-20}, {2.0e-20, 1.0e-18}, {1.0e-21, 2.0e-20}};
  const double table[] = {0.60753002, 0.94223090, 0.99851348};
  std::vector<NetCounts> returns;
  for (std::size_t i = 0; i < 3; ++i) {
    const double t = std::exp(-2 * (100 * sigma[i][0] + 10 * sigma[i][1]) * kPpmM);
    CHECK(std::abs(t - table[i]) < 5.1e-9);
    returns.push_back({2e5 * t * (1.0 + static_cast<double>(i)), 0, 1.0 + static_cast<double>(i)});
  }
  const DialGases exact = dial_gases(returns, sigma);
  REQUIRE(exact.state == DialState::good);
  CHECK(exact.column_cm2[0] / kPpmM == doctest::Approx(100).epsilon(1e-11));
  CHECK(exact.column_cm2[1] / kPpmM == doctest::Approx(10).epsilon(1e-11));
  CHECK(exact.error_cm2[0] == 0);
  CHECK(std::abs(dial_column(returns[0], returns[2], 1.0e-18).column_cm2 / kPpmM - 100.20) < 5e-3);
  // Four wavelengths, counts drawn: errors describe the spread (N = 4000, 4 standard errors of a deviation).
  std::vector<std::vector<double>> four = sigma;
  four.push_back({5e-19, 5e-19});
  double sum = 0, squares = 0;
  constexpr int n = 4000;
  for (int i = 0; i < n; ++i) {
    std::vector<NetCounts> noisy;
    for (std::size_t k = 0; k < 4; ++k) {
      Stream stream(raycube::testing::seed(6), static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(k),
                    DrawFor::counts);
      const double c = stream.poisson(1e5 * std::exp(-2 * (100 * four[k][0] + 10 * four[k][1]) * kPpmM));
      noisy.push_back({c, c, 1});
    }
    const DialGases gases = dial_gases(noisy, four);
    const double z = (gases.column_cm2[1] - 10 * kPpmM) / gases.error_cm2[1];
    sum += z, squares += z * z;
  }
  CHECK_WITHIN(sum / n, 4 / std::sqrt(n) + 0.01);
  CHECK_WITHIN(squares / n - 1, 4 * std::sqrt(2.0 / n) + 0.01);
  // A dark wavelength leaves two for two gases and a factor: said, not solved.
  returns[0].counts = 0;
  CHECK(dial_gases(returns, sigma).state == DialState::saturated);
  CHECK(dial_gases(returns, sigma).column_cm2.empty());
  CHECK(dial_gases({{0, 0, 1}, {0, 0, 1}, {0, 0, 1}}, sigma).state == DialState::no_signal);
}

TEST_CASE("S33: range-resolved density of a uniform gas, and an opaque far end") {
  std::vector<NetCounts> on, off;
  const double density = 5e12, d_sigma = 1e-18, bin_m = 15;  // 1 / cm3
  for (int i = 0; i < 40; ++i) {
    const double r = 500 + bin_m * i, air = 1e12 / (r * r) * std::exp(-2e-4 * r);
    off.push_back({air, air, 1});
    on.push_back({air * std::exp(-2 * density * d_sigma * 100 * bin_m * i), air, 2});
    on.back().photons = 1;
  }
  for (const int apart : {1, 4}) {
    const auto profile = dial_profile(on, off, d_sigma, bin_m, apart);
    REQUIRE(profile.size() == static_cast<std::size_t>(40 - apart));
    for (const DialColumn& cell : profile) {
      CHECK(cell.state == DialState::good);
      CHECK(cell.column_cm2 == doctest::Approx(density).epsilon(1e-9));
      CHECK(cell.error_cm2 > 0);
    }
  }
  for (std::size_t i = 20; i < 40; ++i) on[i].counts = 0;
  const auto dark = dial_profile(on, off, d_sigma, bin_m, 1);
  CHECK(dark[18].state == DialState::good);
  CHECK(dark[19].state == DialState::saturated);
  CHECK(dark[30].state == DialState::saturated);
  for (const DialColumn& cell : dark) CHECK(std::isfinite(cell.column_cm2));
}

TEST_CASE("S33: columns from drawn records lie around the truth by their stated error") {
  LidarPlan plan = test::small_plan(120);
  plan.lidar.pulse.lines.push_back(plan.lidar.pulse.lines[0]);
  plan.photons = {1e14, 2e14};
  plan.lidar.detector.mode = scene::DetectorMode::linear;
  plan.lidar.detector.gain = 50, plan.lidar.detector.ionization_ratio = 0.02, plan.lidar.detector.readout_noise_e = 100,
  plan.lidar.detector.full_scale_e = 4096;
  plan.lidar.detector.dark_rate_hz = 3e8;
  ShotResult shot = test::empty_shot(plan);
  std::vector<float> on(120, 0.0F), off(120, 0.0F);
  const double column = 100 * kPpmM, sigma = 1e-18;
  test::add_return(on, 4000 * std::exp(-2 * sigma * column), 60.3, 4 * test::kSigmaOfFwhm),
      test::add_return(off, 8000, 60.3, 4 * test::kSigmaOfFwhm);
  std::copy(on.begin(), on.end(), shot.first.begin()), std::copy(off.begin(), off.end(), shot.first.begin() + 120);
  double sum = 0, squares = 0;
  constexpr int n = 2000;
  for (int pulse = 0; pulse < n; ++pulse) {
    shot.shot.pulse = pulse;
    const auto records = detect(plan, shot);
    const Echo* ground = strongest_echo(records[1]);
    REQUIRE(ground != nullptr);
    const double time_s = ground->time_s;
    const DialColumn c = dial_column(net_counts(plan, records[0], time_s), net_counts(plan, records[1], time_s), sigma);
    REQUIRE(c.state == DialState::good);
    const double z = (c.column_cm2 - column) / c.error_cm2;
    sum += z, squares += z * z;
  }
  // Both windows are the same and cut the same 0.3 % of both returns.
  CHECK_WITHIN(sum / n, 4 / std::sqrt(n) + 0.02);  // curvature of the logarithm, 1/2 relative variance over its root
  CHECK_WITHIN(squares / n - 1, 4 * std::sqrt(2.0 / n) + 0.01);
}
