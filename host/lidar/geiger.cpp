#include "host/lidar/geiger.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/base/units.h"
#include "host/lidar/draws.h"

namespace raycube::lidar {

namespace {}  // namespace

std::vector<double> first_photon_probabilities(const std::vector<double>& expected) {
  std::vector<double> out;
  double before = 0;
  for (const double m : expected) {
    out.push_back(-std::exp(-before) * std::expm1(-m));
    before += m;
  }
  out.push_back(std::exp(-before));
  return out;
}

double no_event_probability(double mu, double modes) {
  return modes > 0 ? std::exp(-modes * std::log1p(mu / modes)) : std::exp(-mu);
}

double non_paralysable_rate_hz(double rate_hz, double dead_time_s) { return rate_hz / (1 + rate_hz * dead_time_s); }

double paralysable_rate_hz(double rate_hz, double dead_time_s) { return rate_hz * std::exp(-rate_hz * dead_time_s); }

EventClock::EventClock(const std::vector<double>& expected)
    : sum_(expected.size() + 1, 0.0), slope_(expected.size() + 1, 0.0) {
  const std::size_t bins = expected.size();
  for (std::size_t i = 0; i < bins; ++i) sum_[i + 1] = sum_[i] + std::max(0.0, expected[i]);
  for (std::size_t i = 1; i < bins; ++i) {
    const double a = sum_[i] - sum_[i - 1], b = sum_[i + 1] - sum_[i];
    slope_[i] = std::min({2 * a, 2 * b, 0.5 * (a + b)});  // Steffen's, even spacing, rising
  }
  if (bins) slope_.front() = sum_[1], slope_.back() = sum_[bins] - sum_[bins - 1];
}

double EventClock::inside(std::size_t bin, double f) const {
  const double m = sum_[bin + 1] - sum_[bin], p = slope_[bin], q = slope_[bin + 1];
  return f * (p + f * ((3 * m - 2 * p - q) + f * (p + q - 2 * m)));
}

double EventClock::events_until(double position) const {
  const auto bins = static_cast<double>(sum_.size() - 1);
  if (!(position > 0)) return 0;
  if (position >= bins) return total();
  const auto bin = static_cast<std::size_t>(position);
  return sum_[bin] + inside(bin, position - static_cast<double>(bin));
}

double EventClock::position_of(double events) const {
  const auto after = std::upper_bound(sum_.begin(), sum_.end(), events);
  if (after == sum_.end()) return static_cast<double>(sum_.size() - 1);
  const auto bin = static_cast<std::size_t>(after - sum_.begin()) - 1;
  const double target = events - sum_[bin];
  double lo = 0, hi = 1;
  for (int step = 0; step < 45; ++step) {  // 2^-45 of a bin
    const double middle = 0.5 * (lo + hi);
    (inside(bin, middle) < target ? lo : hi) = middle;
  }
  return static_cast<double>(bin) + 0.5 * (lo + hi);
}

std::vector<Photon> geiger_events(const scene::Lidar& lidar, const std::vector<double>& expected, std::uint64_t seed,
                                  std::uint32_t key, int line) {
  const scene::LidarDetector& detector = lidar.detector;
  const EventClock clock(expected);
  const int cells = std::max(1, detector.cells);
  const auto bins = static_cast<double>(expected.size());
  const double bin_s = lidar.gate.bin_s, dead_bins = detector.dead_time_s / bin_s, share = 1.0 / cells;
  std::vector<Photon> events;
  if (!(clock.total() > 0)) return events;
  for (int cell = 0; cell < cells; ++cell) {
    Stream stream(seed, key, static_cast<std::uint32_t>(cell), DrawFor::geiger, line);
    double armed = 0, released = std::numeric_limits<double>::infinity();
    for (;;) {
      const double reach = clock.events_until(armed) + stream.exponential() / share;
      const double arrival = reach < clock.total() ? clock.position_of(reach) : std::numeric_limits<double>::infinity();
      const double at = std::min(arrival, released);
      if (!(at < bins)) break;
      const double jitter_s =
          detector.jitter_fwhm_s > 0 ? base::kSigmaOfFwhm * detector.jitter_fwhm_s * stream.normal() : 0;
      events.push_back({lidar.gate.start_s + at * bin_s + jitter_s, cell});
      if (!(dead_bins > 0)) break;
      armed = at + dead_bins;
      const bool trapped = detector.afterpulse_probability > 0 && stream.uniform() < detector.afterpulse_probability;
      released = trapped ? armed + stream.exponential() * detector.afterpulse_time_s / bin_s
                         : std::numeric_limits<double>::infinity();
    }
  }
  std::stable_sort(events.begin(), events.end(), [](const Photon& a, const Photon& b) { return a.time_s < b.time_s; });
  return events;
}

double geiger_detection(const scene::Lidar& lidar, const std::vector<double>& signal, double background, double modes) {
  const int cells = std::max(1, lidar.detector.cells);
  // Walk of a cell through the gate: armed and not yet hit by signal, or dead after noise and back after the dead time
  // (its part of a bin shared between the two bins it ends in).
  const double dead_bins = lidar.detector.dead_time_s / lidar.gate.bin_s, whole = std::floor(dead_bins),
               part = dead_bins - whole;
  const auto back = static_cast<std::size_t>(std::min(whole, 1e9)) + 1;
  std::vector<double> returns(signal.size() + 1, 0.0);
  double armed = 1, hit = 0;
  for (std::size_t i = 0; i < signal.size(); ++i) {
    armed += returns[i];
    const double m = (signal[i] + background) / cells, fired = armed * -std::expm1(-m),
                 by_signal = m > 0 ? fired * signal[i] / (signal[i] + background) : 0;
    armed -= fired, hit += by_signal;
    if (!(dead_bins > 0)) continue;
    if (i + back < returns.size()) returns[i + back] += (fired - by_signal) * (1 - part);
    if (i + back + 1 < returns.size()) returns[i + back + 1] += (fired - by_signal) * part;
  }
  // Expected events that would miss all cells as often; speckle then acts on these.
  const double mu = -cells * std::log1p(-std::min(hit, 1 - 1e-16));
  return 1 - no_event_probability(mu, modes);
}

double geiger_noise_hz(const scene::Lidar& lidar, double background, std::size_t bins) {
  const int cells = std::max(1, lidar.detector.cells);
  const double rate = background / cells / lidar.gate.bin_s, gate_s = static_cast<double>(bins) * lidar.gate.bin_s;
  if (lidar.detector.dead_time_s > 0) return cells * non_paralysable_rate_hz(rate, lidar.detector.dead_time_s);
  return gate_s > 0 ? cells * -std::expm1(-rate * gate_s) / gate_s : 0;
}

}  // namespace raycube::lidar
