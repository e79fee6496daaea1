// Counter-based draws: distributions against their probabilities and moments; the same numbers in any order.
#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "host/lidar/bin_draws.h"
#include "host/lidar/draws.h"
#include "host/lidar/normal_quantile.h"
#include "host/lidar/speckle.h"
#include "tests/support/chance_checks.h"
#include "tests/support/chi_square.h"

using namespace raycube::lidar;

namespace {

constexpr int kDraws = 100000;

Stream stream(int i, DrawFor purpose = DrawFor::counts) {
  return Stream(raycube::testing::seed(42), 5, static_cast<std::uint32_t>(i), purpose);
}

/// Chi-square of counts against a negative binomial (modes 0: Poisson), classes of at least 10 expected; pass below
/// what is as unusual as 4 standard deviations of a Gaussian.
void check_counts(double mean, double modes) {
  const auto classes =
      static_cast<std::size_t>(mean + 12 * std::sqrt(mean + (modes > 0 ? mean * mean / modes : 0)) + 20);
  std::vector<int> seen(classes, 0);
  double sum = 0, squares = 0;
  for (int i = 0; i < kDraws; ++i) {
    Stream s = stream(i);
    const double k = s.negative_binomial(mean, modes);
    sum += k, squares += (k - mean) * (k - mean);
    ++seen[std::min(static_cast<std::size_t>(k), classes - 1)];
  }
  double chi = 0, expected = 0, observed = 0;
  int dof = -1;
  for (std::size_t k = 0; k < classes; ++k) {
    expected += kDraws * negative_binomial_probability(static_cast<double>(k), mean, modes), observed += seen[k];
    if (expected < 10 && k + 1 < classes) continue;
    if (expected > 0) chi += (observed - expected) * (observed - expected) / std::max(expected, 1.0), ++dof;
    expected = observed = 0;
  }
  CAPTURE(mean);
  CAPTURE(modes);
  CHECK_BELOW(chi, raycube::testing::chi_square_limit(dof, 4));
  const double variance = mean + (modes > 0 ? mean * mean / modes : 0);
  CHECK_WITHIN(sum / kDraws - mean, 4 * std::sqrt(variance / kDraws));
  // Spread of the variance estimate of a gamma-mixed Poisson: (kurtosis - 1) variance^2 / n; kurtosis at most 9 + 1 /
  // variance here.
  CHECK_WITHIN(squares / kDraws / variance - 1, 4 * std::sqrt((8 + 1 / variance) / kDraws));
}

}  // namespace

TEST_CASE("S38: Poisson counts by inversion and by rejection follow their probabilities (chi-square)") {
  for (const double mean : {0.01, 0.7, 3.0, 9.99, 10.01, 37.0, 400.0}) check_counts(mean, 0);
}

TEST_CASE("L-22: counts under speckle follow the negative binomial (chi-square, moments)") {
  for (const double modes : {1.0, 1.35, 2.0, 10.0, 100.0}) check_counts(2, modes);
  check_counts(60, 3.5);
  // Probability of none from N = 2 and variances N + N^2 / M.
  const double none[][2] = {{1, 0.333333}, {2, 0.25}, {10, 0.161506}, {100, 0.138033}, {0, 0.135335}};
  for (const auto& [modes, expected] : none)
    CHECK(std::abs(negative_binomial_probability(0, 2, modes) - expected) < 5.1e-7);
  const double variances[][2] = {{1, 6}, {2, 4}, {10, 2.4}, {100, 2.04}, {0, 2}};
  for (const auto& [modes, expected] : variances) {
    double total = 0, mean = 0, squares = 0;
    for (int k = 0; k < 400; ++k) {
      const double p = negative_binomial_probability(k, 2, modes);
      total += p, mean += p * k, squares += p * k * k;
    }
    CHECK(total == doctest::Approx(1).epsilon(1e-12));
    CHECK(squares - mean * mean == doctest::Approx(expected).epsilon(1e-10));
  }
  // Limits: many modes are Poisson, one mode is thermal light (Bose-Einstein): N^k / (1 + N)^(k + 1).
  CHECK(negative_binomial_probability(3, 2, 1e7) ==
        doctest::Approx(negative_binomial_probability(3, 2, 0)).epsilon(1e-6));
  CHECK(negative_binomial_probability(5, 2, 1) == doctest::Approx(std::pow(2.0 / 3, 5) / 3).epsilon(1e-12));
}

TEST_CASE("S38: large means are Gaussian, odd ones harmless") {
  double sum = 0, squares = 0;
  constexpr int n = 20000;
  for (int i = 0; i < n; ++i) {
    Stream s = stream(i);
    const double z = (s.poisson(4e6) - 4e6) / 2000;
    sum += z, squares += z * z;
  }
  CHECK_WITHIN(sum / n, 4 / std::sqrt(n));
  CHECK_WITHIN(squares / n - 1, 4 * std::sqrt(2.0 / n));
  CHECK(stream(1).poisson(0) == 0);
  CHECK(stream(1).poisson(-1) == 0);
  CHECK(std::isnan(stream(1).poisson(std::nan(""))));
}

TEST_CASE("S35: gamma and normal draws have their moments") {
  for (const double shape : {0.3, 1.0, 4.5, 1383.0}) {
    double sum = 0, squares = 0;
    for (int i = 0; i < kDraws; ++i) {
      Stream s = stream(i, DrawFor::speckle);
      const double g = s.gamma(shape);
      sum += g, squares += (g - shape) * (g - shape);
    }
    CAPTURE(shape);
    CHECK_WITHIN(sum / kDraws - shape, 4 * std::sqrt(shape / kDraws));
    CHECK_WITHIN(squares / kDraws / shape - 1,
                 4 * std::sqrt((2 + 6 / shape) / kDraws));  // excess kurtosis of a gamma: 6 / shape
  }
}

TEST_CASE("S38: draws depend on what they are for and on nothing else") {
  const auto first = [](std::uint64_t seed, std::uint32_t key, std::uint32_t index, DrawFor purpose, int line) {
    return Stream(seed, key, index, purpose, line).uniform();
  };
  const double base = first(42, 5, 9, DrawFor::counts, 0);
  CHECK(first(42, 5, 9, DrawFor::counts, 0) == base);
  CHECK(first(43, 5, 9, DrawFor::counts, 0) != base);
  CHECK(first(42 + (1ull << 32), 5, 9, DrawFor::counts, 0) != base);
  CHECK(first(42, 6, 9, DrawFor::counts, 0) != base);
  CHECK(first(42, 5, 10, DrawFor::counts, 0) != base);
  CHECK(first(42, 5, 9, DrawFor::gain, 0) != base);
  CHECK(first(42, 5, 9, DrawFor::counts, 1) != base);
  Stream s(42, 5, 9, DrawFor::counts);
  CHECK(s.uniform() == base);
  CHECK(s.uniform() != base);
}

TEST_CASE("S38: draws of all bins at once are those of a stream for each, to the bit") {
  std::vector<double> mean, counts(1000), normals(1000, 2.0);
  for (int i = 0; i < 1000; ++i) mean.push_back(i % 7 == 0 ? 0.0 : std::pow(10.0, -5 + i % 11));
  mean[3] = std::nan(""), mean[4] = -1;
  BinDraws draws(42, 1, 0);
  draws.record(5, 2);
  draws.counts(17, counts.size(), mean.data(), counts.data());
  draws.add_readout(17, normals.size(), 0.5, normals.data());
  int wrong = 0;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const auto bin = static_cast<std::uint32_t>(17 + i);
    const double count = Stream(42, 5, bin, DrawFor::counts, 2).poisson(mean[i]);
    wrong += !(counts[i] == count || (std::isnan(counts[i]) && std::isnan(count)));
    wrong += normals[i] != 2.0 + 0.5 * Stream(42, 5, bin, DrawFor::readout, 2).normal();
  }
  CHECK(wrong == 0);
}

TEST_CASE("S35: the normal's quantile undoes its distribution function, far out too") {
  // u is rounded to 1e-16: near 1/2 that is 1e-16 / (z phi(z)) of z, 1.4e-15 at 0.2.
  for (const double z : {0.2, 0.4, 1.03, 1.05, 2.0, 4.0, 6.0, 6.6, 6.7, 8.0}) {
    CAPTURE(z);
    const double u = 0.5 * std::erfc(z / std::sqrt(2.0));
    CHECK(std::abs(normal_quantile(u) / -z - 1) < 4e-15);
  }
  for (double u = 1e-300; u < 0.5; u *= 1.7) CHECK(std::abs(log_of(u) / std::log(u) - 1) < 5e-16);
}
