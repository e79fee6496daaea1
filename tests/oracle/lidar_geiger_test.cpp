// Geiger mode: closed forms by quadrature, and the same numbers from events drawn one by one.
#include <doctest/doctest.h>

#include <cmath>
#include <numeric>

#include "host/lidar/detection.h"
#include "host/lidar/geiger.h"
#include "host/lidar/quadrature.h"
#include "tests/oracle/lidar_detection_cases.h"
#include "tests/support/chance_checks.h"
#include "tests/support/chi_square.h"

using namespace raycube;
using namespace raycube::lidar;

namespace {

scene::Lidar geiger_lidar() {
  scene::Lidar lidar = test::small_plan().lidar;
  lidar.detector.mode = scene::DetectorMode::geiger;
  lidar.gate.start_s = 0;
  return lidar;
}

/// Mean and standard deviation of the first event's place for a density f of mu events, by quadrature of f exp(-mu F).
struct FirstEvent {
  double mean, deviation;
};
template <class Density, class Cumulated>
FirstEvent first_event(double mu, double lo, double hi, Density f, Cumulated F) {
  double total = 0, first = 0, second = 0;
  const auto weight = [&](double t) { return mu * f(t) * std::exp(-mu * F(t)); };
  total = integrate(weight, lo, hi, 16);
  first = integrate([&](double t) { return t * weight(t); }, lo, hi, 16) / total;
  second = integrate([&](double t) { return t * t * weight(t); }, lo, hi, 16) / total;
  return {first, std::sqrt(second - first * first)};
}
double pdf(double z) { return std::exp(-0.5 * z * z) / std::sqrt(2 * M_PI); }
double cdf(double z) { return 0.5 * std::erfc(-z / std::sqrt(2.0)); }

}  // namespace

TEST_CASE("L-24: first photon in bin k") {
  const auto p = first_photon_probabilities({0.2, 1.0, 0.5});
  REQUIRE(p.size() == 4);
  CHECK(std::abs(p[0] - 0.1812692469) < 5.1e-11);
  CHECK(std::abs(p[1] - 0.5175365412) < 5.1e-11);
  CHECK(std::abs(p[2] - 0.1185106879) < 5.1e-11);
  CHECK(std::abs(p[3] - 0.1826835241) < 5.1e-11);
  CHECK(std::accumulate(p.begin(), p.end(), 0.0) == doctest::Approx(1).epsilon(1e-15));
  CHECK(no_event_probability(1.7, 0) == doctest::Approx(p[3]).epsilon(1e-15));
  CHECK(no_event_probability(2, 1) == doctest::Approx(1.0 / 3).epsilon(1e-14));  // (1 + mu/M)^-M

  // Events drawn: chi-square over the four outcomes, N = 1e5, 3 degrees of freedom.
  scene::Lidar lidar = geiger_lidar();
  int seen[4] = {0, 0, 0, 0};
  constexpr int n = 100000;
  for (int i = 0; i < n; ++i) {
    const auto events =
        geiger_events(lidar, {0.2, 1.0, 0.5}, raycube::testing::seed(1), static_cast<std::uint32_t>(i), 0);
    REQUIRE(events.size() <= 1);
    ++seen[events.empty() ? 3 : static_cast<int>(events[0].time_s / lidar.gate.bin_s)];
  }
  double chi = 0;
  for (int k = 0; k < 4; ++k)
    chi += std::pow(seen[k] - n * p[static_cast<std::size_t>(k)], 2) / (n * p[static_cast<std::size_t>(k)]);
  CHECK_BELOW(chi, raycube::testing::chi_square_limit(3, 4));
}

TEST_CASE("L-25: first-photon bias of a rectangular pulse") {
  const double table[][2] = {{0.1, 0.491668}, {1, 0.418023}, {2, 0.343482}, {5, 0.193216}, {10, 0.0999546}};
  for (const auto& [mu, expected] : table) {
    CAPTURE(mu);
    CHECK(std::abs(1 / mu - std::exp(-mu) / -std::expm1(-mu) - expected) < 5.1e-7);
    CHECK(std::abs(first_event(
                       mu, 0, 1, [](double) { return 1.0; }, [](double t) { return t; })
                       .mean -
                   expected) < 5.1e-7);
    // Drawn inside one single bin: tags lie inside the bin by its own shape, not in its middle.
    double sum = 0, squares = 0;
    int found = 0;
    scene::Lidar lidar = geiger_lidar();
    for (int i = 0; i < 40000; ++i)
      for (const Photon& event :
           geiger_events(lidar, {0.5 * mu, 0.5 * mu}, raycube::testing::seed(2), static_cast<std::uint32_t>(i), 0))
        ++found, sum += event.time_s / 2e-9, squares += std::pow(event.time_s / 2e-9, 2);
    const double mean = sum / found, error = std::sqrt((squares / found - mean * mean) / found);
    CHECK_WITHIN(mean - expected, 4 * error);
  }
}

TEST_CASE("L-26: first-photon bias and spread of a Gaussian pulse") {
  struct Row {
    double mu, mean, deviation;
  };
  for (const Row& r : {Row{0.1, -0.028205, 0.999832}, Row{1, -0.278064, 0.983696}, Row{2, -0.534004, 0.940310},
                       Row{5, -1.081569, 0.770378}, Row{10, -1.504486, 0.624335}, Row{100, -2.505579, 0.431258}}) {
    CAPTURE(r.mu);
    const FirstEvent q = first_event(r.mu, -9, 9, pdf, cdf);
    CHECK(std::abs(q.mean - r.mean) < 5.1e-7);
    CHECK(std::abs(q.deviation - r.deviation) < 5.1e-7);
    // Drawn from bins of 1/4 sigma: 4 standard errors of N = 20000, and what the cubic inside a bin misses of the
    // Gaussian's curve, (bin / sigma)^4 / 100 or so.
    constexpr double bins_per_sigma = 4;
    std::vector<float> row(80, 0.0F);
    test::add_return(row, r.mu, 40, bins_per_sigma);
    const std::vector<double> expected(row.begin(), row.end());
    scene::Lidar lidar = geiger_lidar();
    double sum = 0, squares = 0;
    int found = 0;
    for (int i = 0; i < 20000; ++i)
      for (const Photon& event :
           geiger_events(lidar, expected, raycube::testing::seed(3), static_cast<std::uint32_t>(i), 0)) {
        const double z = (event.time_s / lidar.gate.bin_s - 40) / bins_per_sigma;
        ++found, sum += z, squares += z * z;
      }
    const double mean = sum / found, deviation = std::sqrt(squares / found - mean * mean);
    CHECK_WITHIN(mean - r.mean, 4 * r.deviation / std::sqrt(found) + 1e-4);
    CHECK_WITHIN(deviation / r.deviation - 1, 4 / std::sqrt(found) + 1e-3);  // kurtosis up to 4
  }
  // mu 5, FWHM 4 ns: -0.2754 m.
  CHECK(std::abs(-1.081569 * 0.5 * 299792458.0 * test::kSigmaOfFwhm * 4e-9 + 0.2754) < 5.1e-5);
}

TEST_CASE("L-27: dead time: rates in closed form, and registered events of a steady light") {
  CHECK(std::abs(non_paralysable_rate_hz(1e7, 50e-9) / 6.6667e6 - 1) < 1e-5);
  CHECK(std::abs(paralysable_rate_hz(1e7, 50e-9) / 6.0653e6 - 1) < 1e-5);
  CHECK(std::abs(non_paralysable_rate_hz(1e8, 50e-9) / 1.6667e7 - 1) < 3e-5);
  CHECK(std::abs(paralysable_rate_hz(1e8, 50e-9) / 6.738e5 - 1) < 1e-4);
  CHECK(std::exp(-1e7 * 100e-9) == doctest::Approx(0.3679).epsilon(2e-4));
  // 100 us gates of 100 ns bins; counting of a renewal process: mean T / (t + 1/r) + (1 - var ratio) / 2 of an event
  // from the armed start, variance r_out T (1 - r_out t)^2 (Mueller, NIM 112 (1973) 47). N = 200 gates, 4 standard
  // errors.
  for (const double rate : {1e7, 1e8}) {
    scene::Lidar lidar = geiger_lidar();
    lidar.gate.bin_s = 100e-9;
    lidar.detector.dead_time_s = 50e-9;
    const std::vector<double> expected(1000, rate * 100e-9);
    double total = 0;
    constexpr int gates = 200;
    for (int i = 0; i < gates; ++i) {
      const auto events = geiger_events(lidar, expected, raycube::testing::seed(4), static_cast<std::uint32_t>(i), 0);
      for (std::size_t k = 1; k < events.size(); ++k)
        REQUIRE(events[k].time_s - events[k - 1].time_s >= 50e-9 * (1 - 1e-9));
      total += static_cast<double>(events.size());
    }
    const double out = non_paralysable_rate_hz(rate, 50e-9), mean = out * 1e-4, live = 1 - out * 50e-9;
    CAPTURE(rate);
    CHECK_WITHIN(total / gates - mean,
                 4 * std::sqrt(mean * live * live / gates) + 1);  // 1: an event of the start's transient
  }
}

TEST_CASE("S39: noise before the target: survival exp(-r t), and detection in closed form against events") {
  LidarPlan plan = test::small_plan();
  plan.lidar.detector.mode = scene::DetectorMode::geiger;
  plan.lidar.detector.dark_rate_hz = 5e6;
  std::vector<float> row(200, 0.0F);
  test::add_return(row, 1.5, 150, 1.7);
  constexpr int n = 20000;
  for (const double dead_s : {0.0, 40e-9})
    for (const int cells : {1, 4}) {
      plan.lidar.detector.dead_time_s = dead_s, plan.lidar.detector.cells = cells;
      const std::vector<double> signal(row.begin(), row.end());
      std::vector<double> light = signal;
      for (double& m : light) m += 5e-3;
      // Events of signal are counted as those in the return's 20 bins; noise there (0.1 events) fires as well.
      const double noise_there = 20 * 5e-3, p = geiger_detection(plan.lidar, signal, 5e-3, 0);
      int hit = 0;
      for (int i = 0; i < n; ++i) {
        bool seen = false;
        for (const Photon& e :
             geiger_events(plan.lidar, light, raycube::testing::seed(5), static_cast<std::uint32_t>(i), 0))
          seen = seen || (e.time_s > 6740e-9 && e.time_s < 6760e-9);
        hit += seen;
      }
      const double share = static_cast<double>(hit) / n, error = 4 * std::sqrt(p * (1 - p) / n);
      CAPTURE(dead_s);
      CAPTURE(cells);
      CHECK_ABOVE(share, p - error);
      // A cell fires in the window by its signal, or by noise with a chance of its share of the events there at most;
      // noise that comes before the return keeps the cell from it, so that the two do not go by independent chances.
      const double no_cell = std::pow(std::pow(1 - p, 1.0 / cells) - noise_there / cells, cells);
      CHECK_BELOW(share, 1 - no_cell + error);
    }
}

TEST_CASE("S39: jitter widens, afterpulses add their share, cells share the light") {
  scene::Lidar lidar = geiger_lidar();
  lidar.detector.dead_time_s = 20e-9, lidar.detector.jitter_fwhm_s = 1e-9;
  lidar.detector.afterpulse_probability = 0.1, lidar.detector.afterpulse_time_s = 10e-9;
  std::vector<double> expected(400, 0.0);
  expected[5] = 1e-12, expected[6] = 30;  // an impulse that fires for sure
  double sum = 0, squares = 0;
  int pairs = 0;
  constexpr int n = 40000;
  for (int i = 0; i < n; ++i) {
    const auto events = geiger_events(lidar, expected, raycube::testing::seed(6), static_cast<std::uint32_t>(i), 0);
    REQUIRE(!events.empty());
    const double t = events.front().time_s / 1e-9 - 6;
    sum += t, squares += t * t, pairs += events.size() > 1;
  }
  const double mean = sum / n, variance = squares / n - mean * mean;
  // First of 30 events evenly in 1 ns: mean 1/30, variance 1/900; jitter (0.42466 ns)^2. The first bin's slope into the
  // impulse is gentle: 2 %.
  CHECK_WITHIN(variance / (1.0 / 900 + 0.18034) - 1, 0.04);
  CHECK_WITHIN(pairs - 0.1 * n, 4 * std::sqrt(0.09 * n));
  lidar.detector.cells = 8, lidar.detector.afterpulse_probability = 0;
  double events = 0;
  for (int i = 0; i < n / 4; ++i)
    events += static_cast<double>(
        geiger_events(lidar, expected, raycube::testing::seed(7), static_cast<std::uint32_t>(i), 0).size());
  CHECK_WITHIN(events / (n / 4) - 8 * -std::expm1(-30.0 / 8), 4 * std::sqrt(8 * 0.023 / (n / 4.0)));
}

TEST_CASE("S39: clock of events keeps every bin's share, rises, and inverts") {
  const EventClock clock({0, 0.3, 2.0, 2.1, 0, 0, 5, 0.01});
  const double sums[] = {0, 0, 0.3, 2.3, 4.4, 4.4, 4.4, 9.4, 9.41};
  for (int i = 0; i <= 8; ++i) CHECK(clock.events_until(i) == doctest::Approx(sums[i]).epsilon(1e-14));
  double before = 0;
  for (int i = 1; i <= 800; ++i) {
    const double now = clock.events_until(i / 100.0);
    REQUIRE(now >= before - 1e-15);
    before = now;
  }
  for (double e = 0.01; e < 9.4; e += 0.173)
    CHECK(clock.events_until(clock.position_of(e)) == doctest::Approx(e).epsilon(1e-10));
}
