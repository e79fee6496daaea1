// Gauss-Hermite rules against moments and closed-form means.
#include <doctest/doctest.h>

#include <cmath>

#include "host/base/error.h"
#include "host/lidar/gauss_hermite.h"

using namespace raycube;

TEST_CASE("L-09: Gauss-Hermite rules integrate polynomials to degree 2n - 1 against a standard normal") {
  for (const int n : {1, 2, 3, 5, 8, 16, 32, 64, 127, 200}) {
    const auto rule = lidar::gauss_hermite(n);
    REQUIRE(rule.x.size() == static_cast<std::size_t>(n));
    double total = 0, moment = 1;
    for (const double w : rule.w) total += w;
    CHECK(std::abs(total - 1) < 1e-14);
    for (int power = 0; power < n && power <= 20; ++power) {  // E x^(2p) = (2p - 1)!!
      double sum = 0;
      for (std::size_t i = 0; i < rule.x.size(); ++i) sum += rule.w[i] * std::pow(rule.x[i], 2 * power);
      CAPTURE(n);
      CAPTURE(power);
      CHECK(std::abs(sum / moment - 1) < 1e-12);  // rounding of 20 products
      moment *= 2 * power + 1;
    }
  }
  const auto three = lidar::gauss_hermite(3);
  CHECK(three.x[2] == doctest::Approx(std::sqrt(3.0)).epsilon(1e-15));
  CHECK(three.w[0] == doctest::Approx(1.0 / 6).epsilon(1e-14));
}

TEST_CASE("L-09: means of exponentials: E exp(t x) = exp(t^2 / 2), tails included") {
  for (const int n : {32, 64}) {
    const auto rule = lidar::gauss_hermite(n);
    for (const double t : {0.5, 2.0, 4.0}) {
      double sum = 0;
      for (std::size_t i = 0; i < rule.x.size(); ++i) sum += rule.w[i] * std::exp(t * rule.x[i]);
      CHECK(std::abs(sum / std::exp(t * t / 2) - 1) < 1e-12);
    }
  }
  CHECK_THROWS_AS(lidar::gauss_hermite(0), base::Error);
  CHECK_THROWS_AS(lidar::gauss_hermite(201), base::Error);
}
