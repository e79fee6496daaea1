// Exponential sums for multiple scattering. Oracles: sums that are known, Beer's law, and the band model whose
// transmittances the terms stand for (S4.4: rms of T below 0.003).
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <initializer_list>
#include <vector>

#include "atmos_tables/gas/band_models.h"
#include "atmos_tables/gas/exponential_sum.h"
#include "atmos_tables/gas/layer_gases.h"
#include "atmos_tables/optics/standard_air.h"
#include "host/base/error.h"

using namespace raycube;
using namespace raycube::atmos;

namespace {

const std::vector<double> kAmounts = [] {
  std::vector<double> out;
  for (int k = -6; k < 6; ++k) out.push_back(std::pow(2.5, k));
  return out;
}();

template <class Curve>
std::vector<double> curve(Curve&& transmittance) {
  std::vector<double> out;
  for (double amount : kAmounts) out.push_back(transmittance(amount));
  return out;
}

const std::vector<double> kEqual(12, 1.0);

double rms(const ExponentialSum& sum, const std::vector<double>& truth) {
  double squares = 0;
  for (std::size_t k = 0; k < kAmounts.size(); ++k) squares += std::pow(sum.at(kAmounts[k]) - truth[k], 2);
  return std::sqrt(squares / 12);
}

double transmittance(const LayerGases::KTerms& terms, const std::vector<double>& path) {
  double sum = 0;
  for (std::size_t j = 0; j < terms.weight.size(); ++j) {
    double depth = 0;
    for (std::size_t i = 0; i < path.size(); ++i) depth += terms.layer_depth[j][i] * path[i];
    sum += terms.weight[j] * std::exp(-depth);
  }
  return sum;
}

const std::vector<double> kLevels = [] {
  const AirProfile air = afgl_profile(AfglModel::midlatitude_summer);
  std::vector<double> out;
  for (const AirLevel& level : air.levels())
    if (level.height_km <= 100) out.push_back(level.height_km);
  return out;
}();

std::vector<double> between_km(double low, double high, double factor = 1) {
  std::vector<double> out;
  for (std::size_t i = 0; i + 1 < kLevels.size(); ++i)
    out.push_back(kLevels[i] >= low && kLevels[i + 1] <= high ? factor : 0);
  return out;
}

}  // namespace

TEST_CASE("S4.4 exponential sums: known sums come back, Beer's law is one term") {
  const auto truth = curve([](double s) { return 0.3 * std::exp(-6 * s) + 0.7 * std::exp(-0.09 * s); });
  const ExponentialSum two = fit_exponential_sum(kAmounts, truth, kEqual, 2);
  REQUIRE(two.weight.size() == 2);
  CHECK(std::abs(two.weight[0] - 0.3) <= 1e-3);
  CHECK(std::abs(two.rate[0] / 6 - 1) <= 1e-2);
  CHECK(std::abs(two.rate[1] / 0.09 - 1) <= 1e-2);
  CHECK(rms(two, truth) <= 1e-4);
  const auto beer = curve([](double s) { return std::exp(-0.5 * s); });
  CHECK(rms(fit_exponential_sum(kAmounts, beer, kEqual, 1), beer) <= 1e-4);
  const ExponentialSum of_three = fit_exponential_sum(kAmounts, beer, kEqual, 3);
  CHECK(rms(of_three, beer) <= 1e-3);
}

TEST_CASE("S4.4 a Malkmus and a Goody bin on 12 amounts: rms below 0.003 with 3 to 5 terms, never worse with more") {
  for (auto depth : {malkmus_depth, goody_depth})
    for (double strength : {0.01, 0.5, 20.0, 1e3}) {
      const auto truth = curve([&](double s) { return std::exp(-depth(strength, 0.1, s, 0.6 * s)); });
      double before = 1;
      for (std::size_t terms = 1; terms <= 5; ++terms) {
        const ExponentialSum sum = fit_exponential_sum(kAmounts, truth, kEqual, terms);
        CHECK(sum.weight.size() <= terms);
        double total = 0;
        for (std::size_t j = 0; j < sum.weight.size(); ++j) {
          CHECK(sum.weight[j] > 0);
          CHECK(sum.rate[j] > 0);
          total += sum.weight[j];
        }
        CHECK(std::abs(total - 1) <= 1e-12);
        CHECK(rms(sum, truth) <= before + 3e-4);
        before = rms(sum, truth);
        if (terms >= 4) CHECK(before <= 0.003);
      }
    }
  CHECK_THROWS_AS(fit_exponential_sum({}, {}, {}, 3), base::Error);
  CHECK_THROWS_AS(fit_exponential_sum({1.0}, {0.5}, {1.0}, 0), base::Error);
}

TEST_CASE("S4.4 one gas in one band: partial columns are as good as the whole one, for LOWTRAN7's amounts add up") {
  AirProfile air = afgl_profile(AfglModel::midlatitude_summer);
  std::vector<AirLevel> levels = air.levels();
  for (AirLevel& level : levels)
    for (Gas gas : {Gas::h2o, Gas::o3, Gas::n2o, Gas::co, Gas::ch4, Gas::o2}) level.gas(gas) = 0;
  const LayerGases gases(AirProfile(levels, "carbon dioxide"), kLevels, BandModel::lowtran);
  for (double v : {4960.0, 6350.0}) {  // no trace gas above 2970 cm-1
    const auto terms = gases.k_terms(v, v, 4);
    for (double low : {0.0, 3.0, 10.0})
      for (double high : {3.0, 10.0, 100.0}) {
        const auto path = between_km(low, high);
        CHECK(std::abs(transmittance(terms, path) - gases.line_transmission(v, v, path)) <= 0.006);
      }
  }
}

TEST_CASE("S4.4 terms of bins: weights, weak bins, clear bins, deep bins") {
  const LayerGases gases(afgl_profile(AfglModel::midlatitude_summer), kLevels);
  const auto whole = between_km(0, 100);
  for (double um : {0.5, 0.76, 0.94, 1.38, 2.7, 4.26, 6.3, 9.6, 15.0}) {
    for (std::size_t count : {1u, 2u, 3u, 5u}) {
      const auto terms = gases.k_terms(1e4 / (um * 1.002), 1e4 / um, count);
      CHECK(terms.weight.size() <= count);
      double total = 0;
      for (double weight : terms.weight) {
        CHECK(weight >= 0);
        total += weight;
      }
      CHECK(std::abs(total - 1) <= 1e-12);
      for (const auto& depths : terms.layer_depth) {
        CHECK(depths.size() == gases.layers());
        for (double depth : depths) CHECK((depth >= 0 && std::isfinite(depth)));
      }
    }
  }
  const auto clear = gases.k_terms(19000, 19100, 3);
  CHECK(clear.weight.size() == 1);
  CHECK(transmittance(clear, whole) == 1);
  const auto edge = gases.k_terms(17700, 18000, 3);  // partly outside the model: 140 of 300 cm-1 stay clear on any path
  CHECK(transmittance(edge, between_km(0, 100, 90)) > 0.4);
  CHECK(std::abs(transmittance(edge, whole) - gases.line_transmission(17700, 18000, whole)) <= 0.003);
  double weakest = 1;
  for (double v = 6000; v < 17000; v += 20) {  // one term where the column is below 1e-4 deep
    const double depth = gases.mean_line_depth(v, v + 20, whole);
    if (!(depth > 0 && depth < 1e-4)) continue;
    const auto weak = gases.k_terms(v, v + 20, 3);
    CHECK(weak.weight.size() == 1);
    CHECK(std::abs(transmittance(weak, whole) - std::exp(-depth)) <= 1e-12);
    weakest = std::min(weakest, depth);
  }
  CHECK(weakest < 1e-4);
  CHECK_THROWS_AS(gases.k_terms(5000, 5010, 0), base::Error);
  CHECK_THROWS_AS(gases.k_terms(5000, 5010, 6), base::Error);
}

TEST_CASE("S4.4 rms of T over 0.58 to 14 um in bins of 1 %: whole column below 0.003, partial columns as stated") {
  const LayerGases gases(afgl_profile(AfglModel::midlatitude_summer), kLevels);
  struct Path {
    const char* name;
    std::vector<double> factor;
    double limit[2];  ///< with 3 and 4 terms
  };
  const auto sum = [](std::vector<double> a, const std::vector<double>& b) {
    std::transform(a.begin(), a.end(), b.begin(), a.begin(), [](double x, double y) { return x + y; });
    return a;
  };
  // Partial columns hold other mixtures of gases and pressures than the whole one that the terms were fitted to: one
  // share per layer for all terms cannot give both ends of the column their depth at once.
  const std::vector<Path> paths = {
      {"vertical", between_km(0, 100), {0.003, 0.001}},
      {"60 degrees", between_km(0, 100, 2), {0.003, 0.0015}},
      {"sun 40 degrees and up to 3 km", sum(between_km(0, 100, 1.3), between_km(0, 3)), {0.004, 0.003}},
      {"ground to 3 km", between_km(0, 3), {0.006, 0.005}},
      {"3 km to top", between_km(3, 100), {0.006, 0.005}},
      {"10 km to top", between_km(10, 100), {0.016, 0.008}}};
  for (std::size_t count : {3u, 4u}) {
    std::vector<double> squares(paths.size(), 0.0);
    double bins = 0;
    for (double um = 0.58; um < 14; um *= 1.03, ++bins) {
      const double low = 1e4 / (um * 1.01), high = 1e4 / um;
      const auto terms = gases.k_terms(low, high, count);
      for (std::size_t p = 0; p < paths.size(); ++p)
        squares[p] +=
            std::pow(transmittance(terms, paths[p].factor) - gases.line_transmission(low, high, paths[p].factor), 2);
    }
    for (std::size_t p = 0; p < paths.size(); ++p) {
      const double found = std::sqrt(squares[p] / bins);
      std::printf("%zu terms, %s: rms %.4f\n", count, paths[p].name, found);
      CAPTURE(paths[p].name);
      CHECK(found <= paths[p].limit[count - 3]);
    }
  }
}
