// Scintillation: distributions in closed form and drawn; aperture averaging against an integral made here.
#include <doctest/doctest.h>

#include <cmath>

#include "host/lidar/apply_turbulence.h"
#include "host/lidar/quadrature.h"
#include "host/lidar/scintillation.h"
#include "tests/oracle/lidar_detection_cases.h"
#include "tests/support/chance_checks.h"

using namespace raycube;
using namespace raycube::lidar;

namespace {

/// Averaging of a weak plane or spherical wave by a circular aperture: ratio of int xi int kappa of kappa^(-8/3) (1 -
/// cos(phase)) and that with [2 J1(x)/x]^2; kappa in units of sqrt(k / L), D^2 = 4 d. Written apart from the program,
/// which only interpolates a table.
double averaging(bool spherical, double d) {
  const double diameter = std::sqrt(4 * d);
  const auto inner = [&](double kappa, bool averaged) {
    const auto filter = [&](double scale) {
      const double x = 0.5 * kappa * diameter * scale;
      if (!averaged || x < 1e-8) return 1.0;
      return std::pow(2 * std::cyl_bessel_j(1.0, x) / x, 2);
    };
    const double u = kappa * kappa;
    // xi runs from the source; a spherical wave's pattern grows by 1 / xi on its way to the aperture.
    if (!spherical) return (u < 1e-3 ? u * u / 6 : 1 - std::sin(u) / u) * filter(1);
    return integrate([&](double xi) { return (1 - std::cos(u * xi * (1 - xi))) * filter(xi); }, 0, 1,
                     1 + static_cast<int>((u / 4 + kappa * diameter) / 40));
  };
  const auto total = [&](bool averaged) {
    double sum = 0;
    for (double a = std::log(1e-3); a < std::log(60.0) - 1e-9; a += std::log(6e4) / 44)
      sum += integrate([&](double t) { return std::exp(-5 * t / 3) * inner(std::exp(t), averaged); }, a,
                       a + std::log(6e4) / 44);
    // Beyond 60 the cosine averages out: 3/5 60^(-5/3) without an aperture; with one, what it passes from 60 to 1200.
    if (!averaged) return sum + 0.6 * std::pow(60.0, -5.0 / 3);
    const auto passed = [&](double kappa) {
      const auto filter = [&](double x) { return x < 1e-8 ? 1.0 : std::pow(2 * std::cyl_bessel_j(1.0, x) / x, 2); };
      if (!spherical) return filter(0.5 * kappa * diameter);
      return integrate([&](double xi) { return filter(0.5 * kappa * diameter * xi); }, 0, 1,
                       1 + static_cast<int>(kappa * diameter / 60));
    };
    return sum + integrate([&](double t) { return std::exp(-5 * t / 3) * passed(std::exp(t)); }, std::log(60.0),
                           std::log(1200.0), 1);
  };
  return total(true) / total(false);
}

}  // namespace

TEST_CASE("L-18: gamma-gamma parameters of the worked paths") {
  struct Row {
    double rytov, alpha, beta, index, s2;
  };
  for (const Row& r :
       {Row{0.308804, 8.2517, 6.7407, 0.28752, 0.25272}, Row{5.90375, 4.7957, 1.1933, 1.2213, 0.79808},
        Row{3.08804, 4.1377, 1.4204, 1.1159, 0.74946}, Row{0.0824484, 25.868, 23.968, 0.081994, 0.078806}}) {
    const GammaGamma g = gamma_gamma_plane(r.rytov);
    CAPTURE(r.rytov);
    CHECK(std::abs(g.alpha / r.alpha - 1) < 2e-5);
    CHECK(std::abs(g.beta / r.beta - 1) < 4e-5);
    CHECK(std::abs(g.scintillation_index() / r.index - 1) < 5e-5);
    CHECK(std::abs(std::log1p(g.scintillation_index()) / r.s2 - 1) < 5e-5);
    CHECK(with_index(g, 0.01).scintillation_index() == doctest::Approx(0.01).epsilon(1e-12));
  }
  CHECK(gamma_gamma_spherical(1e-4).scintillation_index() == doctest::Approx(1e-4).epsilon(1e-3));
}

TEST_CASE("L-18: probability of a fade below half, and moments drawn") {
  const GammaGamma g = gamma_gamma_plane(0.308804);
  CHECK(std::abs(gamma_gamma_below(0.5, g) - 0.149991) < 1.1e-6);
  CHECK(std::abs(log_normal_below(0.5, g.scintillation_index()) - 0.129773) < 1.1e-6);
  CHECK(gamma_gamma_below(1e3, g) == doctest::Approx(1).epsilon(1e-9));
  // N = 1e5, 4 standard errors; share of fades binomial, index by its own spread (kurtosis below 12 here).
  constexpr int n = 100000;
  for (const bool gamma_gamma : {true, false}) {
    double sum = 0, squares = 0;
    int fades = 0;
    for (int i = 0; i < n; ++i) {
      Stream stream(raycube::testing::seed(9), static_cast<std::uint32_t>(i), 0, DrawFor::scintillation);
      const double value = draw_irradiance(stream, g.scintillation_index(), gamma_gamma ? &g : nullptr);
      sum += value, squares += (value - 1) * (value - 1), fades += value < 0.5;
    }
    const double p = gamma_gamma ? 0.149991 : 0.129773;
    CHECK_WITHIN(sum / n - 1, 4 * std::sqrt(0.287518 / n));
    CHECK_WITHIN(squares / n / 0.287518 - 1, 4 * std::sqrt(11.0 / n));
    CHECK_WITHIN(static_cast<double>(fades) / n - p, 4 * std::sqrt(p * (1 - p) / n));
  }
  Stream stream(9, 0, 0, DrawFor::scintillation);
  CHECK(draw_irradiance(stream, 0, nullptr) == 1);
}

TEST_CASE("S32: aperture averaging: the table's rows, an independent integral between them, asymptotes, and no jumps") {
  const double table[][3] = {{0.01, 0.96845, 0.97199}, {0.03, 0.92973, 0.93848},   {0.1, 0.83913, 0.86234},
                             {0.3, 0.68142, 0.73487},  {1, 0.41345, 0.52387},      {3, 0.17049, 0.30869},
                             {10, 0.04905, 0.13211},   {14.763, 0.03228, 0.09531}, {30, 0.01486, 0.05009},
                             {100, 0.00388, 0.01515},  {300, 0.00111, 0.00473}};
  for (const auto& [d, plane_wave, spherical_wave] : table) {  // half a unit of the last digit, and interpolation
    CHECK(std::abs(aperture_averaging_plane(d) - plane_wave) < 5e-5);
    CHECK(std::abs(aperture_averaging_spherical(d) - spherical_wave) < 5e-5);
  }
  CHECK(aperture_averaging_plane(0) == 1);
  for (const double d : {0.05, 0.1, 0.5, 1.0, 2.0, 6.0}) {
    CAPTURE(d);
    // Interpolation between rows an eighth of a decade apart, and the integral's own 1e-4.
    CHECK(std::abs(averaging(false, d) / aperture_averaging_plane(d) - 1) < 2e-4);
    CHECK(std::abs(averaging(true, d) / aperture_averaging_spherical(d) - 1) < 2e-4);
  }
  double plane = 1, spherical = 1;
  for (double d = 1e-4; d < 1e6; d *= 1.01) {
    const double p = aperture_averaging_plane(d), s = aperture_averaging_spherical(d);
    REQUIRE(p < plane);
    REQUIRE(s < spherical);
    REQUIRE(p > 0.975 * plane);
    REQUIRE(s > 0.975 * spherical);
    REQUIRE(s > p);
    plane = p, spherical = s;
  }
  CHECK(aperture_averaging_plane(1e9) == doctest::Approx(0.933 * std::pow(1e9, -7.0 / 6)).epsilon(2e-3));
  CHECK(aperture_averaging_spherical(1e9) == doctest::Approx(4.675 * std::pow(1e9, -7.0 / 6)).epsilon(5e-3));
}

TEST_CASE(
    "S32: gains of shots: log-normal in weak turbulence, gamma-gamma in strong, with the total index of both ways") {
  for (const double cn2 : {2e-15, 3e-13}) {
    LidarPlan plan = test::small_plan(1000);
    plan.lidar.turbulence.profile = scene::TurbulenceProfile::constant, plan.lidar.turbulence.cn2 = cn2;
    plan.lidar.turbulence.wander = plan.lidar.turbulence.blur = false;
    plan.lidar.receiver.aperture_radius_m = 0.01;
    constexpr int n = 20000;
    double sum = 0, squares = 0;
    TurbulenceTruth truth;
    for (int i = 0; i < n; ++i) {
      Shot shot;
      shot.pulse = i, shot.half_divergence_rad = 1e-5;
      shot.exit_m = {0, 0, 900}, shot.exit_axis = {0, 0, -1}, shot.exit_u = {1, 0, 0};
      truth = apply_turbulence(plan, 0, shot);
      REQUIRE(shot.gain == truth.gain);
      sum += shot.gain, squares += (shot.gain - 1) * (shot.gain - 1);
    }
    CHECK(truth.gamma_gamma == (cn2 > 1e-13));
    CHECK(truth.index_total == doctest::Approx((1 + truth.index_down) * (1 + truth.index_up) - 1).epsilon(1e-14));
    CHECK(truth.index_up < 1.5 * truth.rytov_spherical);
    CHECK_WITHIN(sum / n - 1, 4 * std::sqrt(truth.index_total / n));
    // Kurtosis of the product near 3 + 16 index for weak and up to 60 for strong.
    CHECK_WITHIN(squares / n / truth.index_total - 1, 4 * std::sqrt((cn2 > 1e-13 ? 59 : 3) / static_cast<double>(n)));
  }
}

TEST_CASE("S32: lines of a shot flicker with their own variance, together or apart as the wind has it") {
  LidarPlan plan = test::small_plan(1000);
  plan.lidar.turbulence.profile = scene::TurbulenceProfile::constant, plan.lidar.turbulence.cn2 = 2e-15;
  plan.lidar.turbulence.wander = plan.lidar.turbulence.blur = false;
  plan.lidar.receiver.aperture_radius_m = 0.01;
  const auto shoot = [&](std::int64_t pulse, TurbulenceTruth* truth = nullptr) {
    Shot shot;
    shot.pulse = pulse, shot.half_divergence_rad = 1e-5;
    shot.exit_m = {0, 0, 900}, shot.exit_axis = {0, 0, -1}, shot.exit_u = {1, 0, 0};
    const TurbulenceTruth found = apply_turbulence(plan, 0, shot);
    if (truth) *truth = found;
    return shot;
  };
  plan.lidar.pulse.lines = {{"one", 1.064, 0, 1}};
  const double alone = shoot(7).gain;
  CHECK(shoot(7).line_gain.empty());

  plan.lidar.pulse.lines = {{"on", 1.064, 0, 1}, {"off", 1.064, 0, 1}, {"green", 0.532, 0, 1}};
  TurbulenceTruth truth;
  const Shot together = shoot(7, &truth);
  REQUIRE(together.line_gain.size() == 3);
  CHECK(together.gain == 1);
  CHECK(together.line_gain[0] == alone);
  CHECK(together.line_gain[1] == alone);
  // Log-normal of one normal deviate: ln gain + index / 2 scales with the indices' square roots; k^(7/6) of the
  // spherical wave.
  CHECK(truth.lines[2].rytov_spherical / truth.lines[0].rytov_spherical ==
        doctest::Approx(std::pow(2.0, 7.0 / 6)).epsilon(1e-9));
  CHECK(truth.warnings.size() >= 1);  // wavelengths a factor of 2 apart

  // Index of the rest: 4 standard errors of a log-normal's variance, kurtosis near 3.
  for (const bool apart : {false, true}) {
    plan.lidar.pulse.separation_s = apart ? 1 : 0;
    constexpr int n = 4000;
    double squares[3] = {0, 0, 0}, product = 0;
    for (int i = 0; i < n; ++i) {
      const Shot shot = shoot(i, &truth);
      for (std::size_t line = 0; line < 3; ++line) squares[line] += std::pow(shot.line_gain[line] - 1, 2) / n;
      product += (shot.line_gain[0] - 1) * (shot.line_gain[1] - 1) / n;
    }
    for (std::size_t line = 0; line < 3; ++line) {
      const double index = (1 + truth.lines[line].index_down) * (1 + truth.lines[line].index_up) - 1;
      CHECK_WITHIN(squares[line] / index - 1, 4 * std::sqrt(3.0 / n));
    }
    const double correlation = product / std::sqrt(squares[0] * squares[1]);
    if (apart)
      CHECK_WITHIN(correlation, 4 / std::sqrt(static_cast<double>(n)));
    else
      CHECK(correlation == doctest::Approx(1).epsilon(1e-12));
  }

  ShotResult result;
  result.shot = together;
  result.shot.line_gain = {2, 3, 0.5};
  result.first.assign(3 * 1000, 1.0F), result.air.assign(3 * 1000, 4.0F), result.ledger.resize(3);
  for (Ledger& ledger : result.ledger) ledger.collected = 1, ledger.absorbed = 1;
  plan.photons = {1, 1, 1};
  apply_line_gain(plan, result);
  for (std::size_t line = 0; line < 3; ++line) {
    CHECK(result.first[line * 1000 + 500] == static_cast<float>(result.shot.line_gain[line]));
    CHECK(result.air[line * 1000 + 999] == 4 * static_cast<float>(result.shot.line_gain[line]));
    CHECK(result.ledger[line].collected == result.shot.line_gain[line]);
    CHECK(result.ledger[line].absorbed == 1);
  }
}
