// Tied sky rays that explain what a device saw the other way (host/reference/tie_search.h). Oracle: trying
// every combination in order. How much is compared is counted, not timed.
#include <doctest/doctest.h>

#include <chrono>
#include <cmath>
#include <csignal>
#include <numeric>
#include <random>
#include <thread>

#include "host/base/error.h"
#include "host/base/interrupt.h"
#include "host/reference/tie_search.h"
#include "tests/support/patience.h"

using namespace raycube;
using reference::Components;

namespace {

struct Ties {
  std::vector<std::size_t> rays;   ///< indices into effect: every other one
  std::vector<Components> effect;  ///< [ray]
  Components residual{}, bound{};
};

/// n ties of so many components, as rays to a sky have them: cosines times weights, seen rays with a plus,
/// blocked ones with a minus. The bound is that of the check, a part of what all rays could take.
Ties random_ties(std::size_t n, std::size_t components, std::uint32_t seed, double part = 4e-6) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> draw(0, 1);
  Ties out;
  for (std::size_t i = 0; i < 2 * n; ++i) {
    Components& effect = out.effect.emplace_back();
    const double cosine = draw(random), sign = draw(random) < 0.5 ? -1 : 1;
    for (std::size_t m = 0; m < components; ++m) {
      const double weight = m == 0 ? 1 + 0.1 * draw(random) : draw(random) - 0.5;
      effect[m] = sign * cosine * weight, out.bound[m] += part * std::abs(weight);
    }
    if (i % 2 == 1) out.rays.push_back(i);
  }
  return out;
}

std::vector<std::size_t> plain_search(const Ties& t) {
  const std::size_t n = t.rays.size();
  const auto fits = [&](const std::vector<std::size_t>& rays) {
    Components left = t.residual;
    for (const std::size_t k : rays)
      for (std::size_t m = 0; m < left.size(); ++m) left[m] -= t.effect[k][m];
    for (std::size_t m = 0; m < left.size(); ++m)
      if (!(std::abs(left[m]) <= t.bound[m])) return false;
    return true;
  };
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i; j < n; ++j)
      for (std::size_t k = j; k < n; ++k) {
        std::vector<std::size_t> rays{t.rays[i]};
        if (j > i) rays.push_back(t.rays[j]);
        if (k > j) rays.push_back(t.rays[k]);
        if ((j > i || k == j) && fits(rays)) return rays;
      }
  return {};
}

void take(Ties& t, std::initializer_list<std::size_t> ties) {
  t.residual = {};
  for (const std::size_t i : ties)
    for (std::size_t m = 0; m < t.residual.size(); ++m) t.residual[m] += t.effect[t.rays[i]][m];
}

std::vector<std::size_t> few(const Ties& t) {
  return reference::few_that_sum_to(t.rays, t.effect, t.residual, t.bound).rays;
}

}  // namespace

TEST_CASE("S61 ties: one, two and three rays are those that trying all in order finds") {
  int found = 0, none = 0;
  for (std::uint32_t seed = 0; seed < 60; ++seed)
    for (const std::size_t components : {1, 2, 4, 8}) {
      // From one answer to many, of which the first counts.
      Ties t = random_ties(17 + seed % 30, components, seed, seed % 3 == 0 ? 4e-6 : seed % 3 == 1 ? 1e-4 : 3e-3);
      if (seed % 7 == 3)  // leaves of one size in one direction: rays that count alike
        for (std::size_t i = 0; i + 4 < t.rays.size(); ++i) t.effect[t.rays[i + 4]] = t.effect[t.rays[i]];
      CAPTURE(seed);
      CAPTURE(components);
      const std::size_t n = t.rays.size();
      for (const int what : {0, 1, 2, 3, 4, 5}) {
        if (what == 0) take(t, {n / 2});
        if (what == 1) take(t, {1, n - 1});
        if (what == 2) take(t, {n / 3, n / 2, n - 2});
        if (what == 3) take(t, {n / 3, n / 3, n - 2});  // twice the same is no answer
        if (what == 4) take(t, {0, 3, 5, n - 1});
        if (what == 5) t.residual[0] = 1e3;
        const auto expected = plain_search(t);
        CHECK(few(t) == expected);
        ++(expected.empty() ? none : found);
      }
    }
  CHECK(found > 500);
  CHECK(none > 200);
}

TEST_CASE("S61 ties: what is no number fits nothing, and hides no answer") {
  Ties t = random_ties(40, 4, 1);
  take(t, {5, 20, 30});
  t.effect[t.rays[7]][2] = NAN, t.effect[t.rays[25]][0] = INFINITY;
  CHECK(few(t) == plain_search(t));
  CHECK(few(t).size() == 3);
  t.residual[1] = NAN;
  CHECK(few(t).empty());
}

TEST_CASE("S61 ties: any subset of up to 38 ties is found, and none is made up") {
  for (std::uint32_t seed = 0; seed < 12; ++seed)
    for (const std::size_t n : {17, 18, 24}) {
      Ties t = random_ties(n, 4, seed, 1e-9);
      std::vector<std::size_t> chosen;
      t.residual = {};
      for (std::size_t i = 0; i < n; ++i)
        if ((seed * 2654435761u + i * 40503u) >> 7 & 1u) {
          chosen.push_back(t.rays[i]);
          for (std::size_t m = 0; m < 8; ++m) t.residual[m] += t.effect[t.rays[i]][m];
        }
      const auto search = [&] { return reference::subset_that_sums_to(t.rays, t.effect, t.residual, t.bound).rays; };
      CHECK(search() == chosen);
      t.residual[1] += 1e-5;
      CHECK(search().empty());
    }
}

TEST_CASE("S61 ties: 4096 directions that nothing explains cost n^2 and not n^3") {
  for (const std::size_t n : {1024, 4096}) {
    Ties t = random_ties(n, 4, 3, 1e-9);
    take(t, {n / 3, n / 2});
    t.residual[2] += 0.01;  // in reach of three rays, and none brings it
    const auto search = reference::few_that_sum_to(t.rays, t.effect, t.residual, t.bound);
    const double pairs = 0.5 * static_cast<double>(n) * static_cast<double>(n - 1);
    MESSAGE(n << " ties: " << static_cast<double>(search.looks) / pairs << " boxes and points compared a pair");
    CHECK(search.rays.empty());
    CHECK(static_cast<double>(search.looks) < 20 * pairs);
  }
  // Grazing rays: the first component of any subset is within the bound of any other.
  Ties t = random_ties(38, 4, 5);
  for (auto& effect : t.effect) effect[0] *= 1e-6;
  take(t, {1, 5, 9, 20, 33});
  t.residual[2] += 0.01;
  const auto search = reference::subset_that_sums_to(t.rays, t.effect, t.residual, t.bound);
  const double sums = std::pow(2, 19);
  MESSAGE("38 ties: " << static_cast<double>(search.looks) / sums << " boxes and points compared a sum");
  CHECK(search.rays.empty());
  CHECK(static_cast<double>(search.looks) < 50 * sums);
}

TEST_CASE("S61 ties: a signal stops the search") {
  base::install_signal_handlers();
  Ties t = random_ties(4096, 4, 3, 1e-9);
  take(t, {1300, 2000});
  t.residual[2] += 0.01;
  const auto whole = reference::few_that_sum_to(t.rays, t.effect, t.residual, t.bound);
  REQUIRE(whole.rays.empty());
  std::thread signal([] {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    std::raise(SIGTERM);
  });
  const testing::Patience patience("the end of a search after a signal");
  const auto search_for_ever = [&] {  // however soon one search would be over
    while (true) few(t);
  };
  CHECK_THROWS_AS(search_for_ever(), base::Error);
  signal.join();
  CHECK_THROWS_AS(reference::subset_that_sums_to(std::span(t.rays).first(20), t.effect, t.residual, t.bound),
                  base::Error);
  base::clear_interrupt();
}
