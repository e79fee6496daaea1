// Overlap of beam and field: closed forms, published numbers of the specification (level 1 and 2), limits, and a Monte
// Carlo count.
#include <doctest/doctest.h>

#include <cmath>
#include <random>

#include "host/lidar/overlap.h"
#include "tests/support/chance_checks.h"

using namespace raycube::lidar;

namespace {

double relative(double value, double expected) { return std::abs(value / expected - 1); }

/// The tilted bistatic system of L-03: 1 m apart, axes crossing at 500 m.
struct Tilted {
  double range_m;
  double offset_m() const { return std::abs(1.0 - 0.002 * range_m); }
  double beam_m(bool gaussian) const { return gaussian ? std::hypot(0.010, 1e-4 * range_m) : 0.010 + 1e-4 * range_m; }
  double field_m() const { return 0.10 + 2e-4 * range_m; }
  double level_2(double obscuration_m) const {
    return beam_overlap({0.10, obscuration_m, 2e-4, 0}, true, beam_m(true), range_m, offset_m());
  }
};

/// Half a unit in the last printed digit of a table.
constexpr double kSixth = 0.51e-6;

}  // namespace

TEST_CASE("L-03: area common to two circles") {
  CHECK(relative(circle_overlap(1, 1, 1), 2 * M_PI / 3 - std::sqrt(3.0) / 2) < 1e-14);
  CHECK(relative(circle_overlap(2, 1, 1.5), 2.392549868) < 3e-10);
  CHECK(relative(circle_overlap(0.5, 0.3, 0.4), 0.1822469466) < 3e-10);
  CHECK(circle_overlap(1, 2, 0.5) == doctest::Approx(M_PI).epsilon(1e-15));
  CHECK(circle_overlap(1, 2, 3) == 0);
  CHECK(circle_overlap(0, 2, 0.5) == 0);
  CHECK(circle_overlap(0, 0, 0) == 0);
}

TEST_CASE("L-03: no NaN where circles touch, and the area is continuous there (LIDAR 12.2)") {
  for (const double a : {0.3, 1.0, 1e-6, 4e5})
    for (const double b : {0.1, 0.7, 3e-9, 1.0}) {
      const double inside = std::abs(a - b), outside = a + b, small = M_PI * std::min(a, b) * std::min(a, b);
      // 200 steps of the last place of d leave the area where it was, unless they are no longer small against the
      // smaller circle.
      const double slack = 200 * 2.3e-16 * outside < 1e-6 * std::min(a, b) ? 1e-7 : 1;
      double d = inside;
      for (int step = 0; step < 200; ++step, d = std::nextafter(d, 1e9)) {
        const double area = circle_overlap(a, b, d);
        REQUIRE(std::isfinite(area));
        REQUIRE(std::abs(area - small) <= slack * small);
      }
      d = outside;
      for (int step = 0; step < 200; ++step, d = std::nextafter(d, 0)) {
        const double area = circle_overlap(a, b, d);
        REQUIRE(std::isfinite(area));
        REQUIRE(area >= 0);
        REQUIRE(area <= slack * small);
      }
    }
}

TEST_CASE("L-03: a thin lens has the area of two parabola segments") {
  // Sagitta e of the whole lens between equal circles: each segment's area is (4/3) sqrt(2 a) (e/2)^(3/2); next order e
  // / a.
  const double a = 1, e = 1e-8;
  CHECK(relative(circle_overlap(a, a, 2 * a - e), 2 * 4.0 / 3 * std::sqrt(2 * a) * std::pow(e / 2, 1.5)) < 2e-8);
}

TEST_CASE("L-03: Gaussian beam through a circle, 1 - Q1") {
  struct Row {
    double w, a, d, expected, digits;
  };
  // digits: half a unit of the last digit printed; where mpmath (25 digits) shows the print to be cut instead of
  // rounded, its value stands.
  for (const Row& r :
       {Row{1, 1, 0, 0.8646647168, 5e-11}, Row{1, 1, 0.5, 0.730987939964090, 1e-14}, Row{1, 1, 1, 0.3964990394, 5e-11},
        Row{1, 1, 2, 0.0147234641, 5e-11}, Row{1, 0.5, 1, 0.0818923036, 5e-11}, Row{0.2, 0.3, 1.0, 6.875777e-13, 5e-20},
        Row{0.01, 0.3, 0.3, 0.496675365543925, 1e-13}}) {
    CAPTURE(r.w);
    CAPTURE(r.a);
    CAPTURE(r.d);
    CHECK(std::abs(gaussian_circle_overlap(r.w, r.a, r.d) - r.expected) <= r.digits * 1.02);
  }
  CHECK(relative(gaussian_circle_overlap(0.7, 1.3, 0), 1 - std::exp(-2 * 1.3 * 1.3 / 0.49)) < 1e-13);
  CHECK(relative(gaussian_circle_overlap(1e-6, 0.3, 0.2), 1) < 1e-10);  // one last place of 0.2 m is 3e-11 of the beam
  CHECK(gaussian_circle_overlap(0.1, 0.3, 9) >= 0);
}

TEST_CASE("L-03: tilted bistatic system, levels 1 and 2, with and without obscuration") {
  struct Row {
    double range_m, uniform, gauss, exact, obscured, over_r2;
  };
  for (const Row& r :
       {Row{400, 0.231326, 0.152787, 0.002628, 0.003128, 1.643e-8},
        Row{425, 0.875856, 0.937938, 0.088138, 0.103253, 4.880e-7}, Row{450, 1, 0.999934, 0.317491, 0.318005, 1.568e-6},
        Row{475, 1, 1, 0.606800, 0.554079, 2.689e-6}, Row{500, 1, 1, 0.798252, 0.760962, 3.193e-6},
        Row{525, 1, 1, 0.679700, 0.633563, 2.466e-6}, Row{550, 1, 0.999939, 0.442462, 0.422565, 1.463e-6},
        Row{600, 0.647398, 0.720684, 0.064448, 0.074855, 1.790e-7},
        Row{650, 0.008918, 0.014212, 0.000317, 0.000377, 7.505e-10}}) {
    const Tilted t{r.range_m};
    CAPTURE(r.range_m);
    CHECK(std::abs(uniform_circle_overlap(t.beam_m(false), t.field_m(), t.offset_m()) - r.uniform) < kSixth);
    CHECK(std::abs(gaussian_circle_overlap(t.beam_m(true), t.field_m(), t.offset_m()) - r.gauss) < kSixth);
    CHECK(std::abs(t.level_2(0) - r.exact) < kSixth);
    CHECK(std::abs(t.level_2(0.04) - r.obscured) < kSixth);
    CHECK(relative(t.level_2(0) / (r.range_m * r.range_m), r.over_r2) < 5.1e-4);  // four digits printed
  }
  const Tilted ground{1000};
  CHECK(uniform_circle_overlap(ground.beam_m(false), ground.field_m(), ground.offset_m()) == 0);
  const double tail = gaussian_circle_overlap(ground.beam_m(true), ground.field_m(), ground.offset_m());
  CHECK(tail > 1e-45);
  CHECK(tail < 1e-43);
  CHECK(ground.level_2(0) < 1e-40);
  // Level 1 uniform is non-zero only between 386.957 and 652.941 m.
  const auto level_1 = [](double range_m) {
    return uniform_circle_overlap(0.010 + 1e-4 * range_m, 0.10 + 2e-4 * range_m, std::abs(1 - 0.002 * range_m));
  };
  CHECK(level_1(386.956) == 0);
  CHECK(level_1(386.958) > 0);
  CHECK(level_1(652.940) > 0);
  CHECK(level_1(652.942) == 0);
  // Figure 2 of the requirements: near, not at, the crossing.
  double best = 0, best_over_r2 = 0;
  int at = 0, at_over_r2 = 0;
  for (int range = 480; range < 520; ++range) {
    const double o = Tilted{static_cast<double>(range)}.level_2(0), over = o / range / range;
    if (o > best) best = o, at = range;
    if (over > best_over_r2) best_over_r2 = over, at_over_r2 = range;
  }
  CHECK(at == 502);
  CHECK(at_over_r2 == 497);
}

TEST_CASE("L-03: overlap is the probability that beam point and pupil point are within the field (Monte Carlo)") {
  // N = 4e5 draws a range; 4 standard errors. Level 2 states: weight of a point = share of the pupil within phi R of
  // it.
  std::mt19937_64 random(raycube::testing::seed(11));
  std::uniform_real_distribution<double> unit(0, 1);
  for (const double range_m : {450.0, 500.0, 600.0}) {
    const Tilted t{range_m};
    constexpr int n = 400000;
    int inside = 0;
    for (int i = 0; i < n; ++i) {
      const double r = t.beam_m(true) * std::sqrt(-std::log1p(-unit(random)) / 2), angle = 2 * M_PI * unit(random);
      const double p = std::sqrt(0.04 * 0.04 + (0.1 * 0.1 - 0.04 * 0.04) * unit(random)),
                   turn = 2 * M_PI * unit(random);
      const double x = t.offset_m() + r * std::cos(angle) - p * std::cos(turn),
                   y = r * std::sin(angle) - p * std::sin(turn);
      inside += std::hypot(x, y) < 2e-4 * range_m;
    }
    const double expected = t.level_2(0.04);
    CHECK_WITHIN(static_cast<double>(inside) / n - expected, 4 * std::sqrt(expected * (1 - expected) / n));
  }
}

TEST_CASE("L-04: coaxial telescope with obscuration is blind up to r_o / phi and full from r / phi") {
  const Stop stop{0.10, 0.04, 5e-4, 0};
  CHECK(vignetting(stop, 0, 0) == 0);
  CHECK(vignetting(stop, 40, 0) == 0);
  CHECK(vignetting(stop, 80, 0) < 1e-15);
  CHECK(relative(vignetting(stop, 100, 0), 0.107142857) < 5e-9);
  CHECK(relative(vignetting(stop, 150, 0), 0.479166667) < 2e-9);
  CHECK(vignetting(stop, 200, 0) == doctest::Approx(1).epsilon(1e-14));
  CHECK(relative(vignetting(stop, 4e5, 0), 1) < 1e-14);
}

TEST_CASE("L-05: parallel biaxial system") {
  // The transmitter's exit is a point (w = theta R).
  const double expected[][2] = {{100, 0},        {200, 0.020682},  {300, 0.174870}, {400, 0.427208},
                                {600, 0.819131}, {1000, 0.978291}, {2000, 0.997942}};
  for (const auto& [range_m, overlap] : expected) {
    CAPTURE(range_m);
    const double w = std::hypot(0.010, 2.5e-4 * range_m);
    CAPTURE(beam_overlap({0.10, 0, 5e-4, 0}, true, 2.5e-4 * range_m, range_m, 0.2));
    CHECK(std::abs(beam_overlap({0.10, 0, 5e-4, 0}, true, w, range_m, 0.2) - overlap) < kSixth);
  }
}

TEST_CASE(
    "L-05: in focus a point is a point: full inside the field, nothing outside; near focus the limit is reached "
    "smoothly") {
  const Stop focused{0.10, 0.03, 2e-4, 500};
  CHECK(vignetting(focused, 500, 0.0999) == 1);
  CHECK(vignetting(focused, 500, 0.1001) == 0);
  CHECK(vignetting(focused, 500.0001, 0.0999) == doctest::Approx(1).epsilon(1e-12));
  CHECK(vignetting(focused, 499.9999, 0.1001) == 0);
  // Focus at twice the range: blur of half the pupil, as the far-focused telescope of half the size.
  CHECK(vignetting({0.10, 0.04, 2e-4, 1000}, 500, 0.07) ==
        doctest::Approx(vignetting({0.05, 0.02, 2e-4, 0}, 500, 0.07)).epsilon(1e-14));
  // The whole beam: in focus level 2 is the hard circle of radius phi R, closed form 1 - Q1.
  CHECK(relative(beam_overlap(focused, true, 0.05, 500, 0.06), gaussian_circle_overlap(0.05, 0.1, 0.06)) < 1e-7);
  CHECK(relative(beam_overlap(focused, false, 0.05, 500, 0.09), uniform_circle_overlap(0.05, 0.1, 0.09)) < 1e-7);
}

TEST_CASE("S29: overlap converges to the far field and stays within 0 .. 1 for odd arguments") {
  CHECK(vignetting({0.1, 0, 0, 0}, 100, 0) == 0);
  CHECK(vignetting({0, 0, 1e-3, 0}, 100, 0.05) == 1);
  CHECK(beam_overlap({0.1, 0.1, 1e-3, 0}, true, 0.1, 100, 0) >= 0);
  CHECK(beam_overlap({0.1, 0, 1e-3, 0}, true, 0, 1000, 0.1) == vignetting({0.1, 0, 1e-3, 0}, 1000, 0.1));
  CHECK(beam_overlap({0.1, 0, 1e-3, 0}, true, 0.1, 0, 0) == 0);
  CHECK(relative(beam_overlap({0.1, 0, 5e-3, 0}, true, 250, 1e6, 0.2), 1) < 1e-13);
  // A uniform beam whose every point sees the whole pupil, and one that the field halves: reciprocity with a field much
  // wider.
  CHECK(relative(beam_overlap({0.1, 0, 1e-3, 0}, false, 0.2, 1000, 0), 1) < 1e-12);
  CHECK(relative(beam_overlap({1e-7, 0, 1e-3, 0}, false, 1.5, 1000, 1.0), uniform_circle_overlap(1.5, 1.0, 1.0)) <
        1e-6);
}
