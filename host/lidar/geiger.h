// Geiger-mode detectors: events one by one, and the closed forms they are held against (LIDAR specification, 10.2).
#pragma once

#include <cstdint>
#include <vector>

#include "host/lidar/detection.h"

namespace raycube::lidar {

/// P(first event in bin k) of expectations m: exp(-sum before)(1 - exp(-m_k)); the last entry is the probability of
/// none.
std::vector<double> first_photon_probabilities(const std::vector<double>& expected);
/// Probability of no event from mu expected ones with speckle modes: (1 + mu/M)^-M; M = 0: exp(-mu).
double no_event_probability(double mu, double modes);
/// Registered rate of a true rate with dead time, 1/s: r / (1 + r t) (active quench), r exp(-r t) (a bound for sanity).
double non_paralysable_rate_hz(double rate_hz, double dead_time_s);
double paralysable_rate_hz(double rate_hz, double dead_time_s);

/// Expected events between bin edges, and where inside a bin they fall: a monotone cubic through the sums at the edges
/// (Steffen, A&A 239 (1990) 443) keeps every bin's events and the rate's slope. Evaluated and inverted in bins from the
/// gate's start.
class EventClock {
 public:
  explicit EventClock(const std::vector<double>& expected);
  double total() const { return sum_.back(); }
  double events_until(double position) const;  ///< of 0 .. bins
  double position_of(double events) const;     ///< of 0 .. total()

 private:
  double inside(std::size_t bin, double f) const;
  std::vector<double> sum_, slope_;
};

/// Draws the events of a gate: cells armed at its start share the expected events evenly. dead_time 0: one event a
/// cell. An avalanche is followed by a trapped carrier with afterpulse_probability, freed after the dead time by an
/// exponential of afterpulse_time_s.
std::vector<Photon> geiger_events(const scene::Lidar& lidar, const std::vector<double>& expected, std::uint64_t seed,
                                  std::uint32_t key, int line);

/// Probability that the signal fires at least once, noise that fires first included, speckle modes common to all cells.
double geiger_detection(const scene::Lidar& lidar, const std::vector<double>& signal, double background, double modes);
/// Events a second from noise alone.
double geiger_noise_hz(const scene::Lidar& lidar, double background, std::size_t bins);

}  // namespace raycube::lidar
