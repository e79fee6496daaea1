#include "host/lidar/detection.h"

#include <algorithm>
#include <cmath>

#include "host/base/units.h"
#include "host/lidar/detector.h"
#include "host/lidar/draws.h"
#include "host/lidar/echoes.h"
#include "host/lidar/geiger.h"
#include "host/lidar/speckle.h"

namespace raycube::lidar {

namespace {

/// One row on its way to a record.
class Row {
 public:
  Row(const LidarPlan& plan, const ShotResult& result, int pixel, int line)
      : plan_(plan), lidar_(plan.lidar), seed_(plan.seed), key_(draw_key(plan, result.shot.pulse, pixel)), line_(line) {
    record_.pulse = result.shot.pulse, record_.pixel = pixel, record_.line = line;
    const auto bins = static_cast<std::size_t>(lidar_.gate.bins);
    const std::size_t row =
        static_cast<std::size_t>(pixel) * static_cast<std::size_t>(plan.lines()) + static_cast<std::size_t>(line);
    const double efficiency = lidar_.receiver.quantum_efficiency;
    expected_.signal.assign(bins, 0.0);
    for (const std::vector<float>* part : {&result.first, &result.multiple, &result.air})
      if (!part->empty())
        for (std::size_t i = 0; i < bins; ++i)
          expected_.signal[i] += efficiency * static_cast<double>((*part)[row * bins + i]);
    const double light_hz =
        lidar_.detector.solar_background && !result.background_hz.empty() ? result.background_hz[row] : 0;
    expected_.background = (light_hz * efficiency + lidar_.detector.dark_rate_hz) * lidar_.gate.bin_s;
    speckle_ = speckle_row(plan, result.shot, pixel, line, expected_.signal);
    for (const double s : expected_.signal) largest_ = std::max(largest_, s);
    noise_ = detector_noise(lidar_, expected_.background, largest_);
    recorded_ = convolve(expected_.signal, noise_.response);
    recorded_signal_ = recorded_;
    if (!lidar_.echoes.air_is_background || result.air.empty() || lidar_.detector.mode == scene::DetectorMode::geiger)
      return;
    std::vector<double> air(bins);
    for (std::size_t i = 0; i < bins; ++i) air[i] = efficiency * static_cast<double>(result.air[row * bins + i]);
    noise_.air = convolve(air, noise_.response);
    noise_.air_modes = speckle_.strongest_modes;
    for (std::size_t i = 0; i < bins; ++i) recorded_signal_[i] = std::max(0.0, recorded_[i] - noise_.air[i]);
  }

  Detection drawn() {
    std::vector<double> light = expected_.signal;
    for (std::size_t i = 0; i < light.size(); ++i) light[i] = light[i] * speckle_.factor[i] + expected_.background;
    if (lidar_.detector.mode == scene::DetectorMode::geiger) return geiger(light);
    std::vector<double> counts(light.size());
    for (std::size_t i = 0; i < light.size(); ++i)
      counts[i] = Stream(seed_, key_, static_cast<std::uint32_t>(i), DrawFor::counts, line_).poisson(light[i]);
    if (lidar_.detector.mode == scene::DetectorMode::linear)
      digitise(amplify(counts));
    else
      store_counts(counts);
    record_.echoes = find_echoes(lidar_, record_.waveform_pe, noise_);
    return finished();
  }

  Detection expectation() {
    std::vector<double> wave = recorded_;
    for (double& value : wave) value += expected_.background;
    store_scaled(wave);
    DetectorNoise none = noise_;
    none.drawn = false;
    if (!(none.full_scale > 0) || lidar_.detector.mode == scene::DetectorMode::geiger) none.full_scale = 0;
    record_.echoes = find_echoes(lidar_, record_.waveform_pe, none);
    return finished();
  }

 private:
  /// Avalanche gain of every bin's electrons, the electronics' response, readout noise; all over the mean gain.
  std::vector<double> amplify(const std::vector<double>& counts) const {
    std::vector<double> out(counts.size());
    for (std::size_t i = 0; i < counts.size(); ++i) {
      // Sum of `counts` gains of mean 1 and variance F - 1, each a gamma variate: exact for one carrier (F = 2), and
      // never negative.
      const double spread = noise_.excess - 1;
      out[i] =
          counts[i] > 0 && spread > 1e-12
              ? spread *
                    Stream(seed_, key_, static_cast<std::uint32_t>(i), DrawFor::gain, line_).gamma(counts[i] / spread)
              : counts[i];
    }
    out = convolve(out, noise_.response);
    const double readout = lidar_.detector.readout_noise_e / lidar_.detector.gain;
    if (readout > 0)
      for (std::size_t i = 0; i < out.size(); ++i)
        out[i] += readout * Stream(seed_, key_, static_cast<std::uint32_t>(i), DrawFor::readout, line_).normal();
    return out;
  }

  /// Sample 0 lies 8 rms of the readout below zero, so that noise is not cut on one side.
  void digitise(const std::vector<double>& signal) {
    const double steps = std::exp2(lidar_.detector.bits) - 1;
    record_.offset = -8 * lidar_.detector.readout_noise_e / lidar_.detector.gain;
    record_.gain = (noise_.full_scale - record_.offset) / steps;
    for (const double value : signal) {
      const double sample = std::clamp(std::round((value - record_.offset) / record_.gain), 0.0, steps);
      record_.truth.saturated = record_.truth.saturated || sample == steps;
      record_.samples.push_back(static_cast<std::uint16_t>(sample));
      record_.waveform_pe.push_back(static_cast<float>(record_.offset + record_.gain * sample));
    }
  }

  void store_counts(const std::vector<double>& counts) {
    store_scaled(counts);
    for (std::size_t i = 0; i < counts.size(); ++i) record_.waveform_pe[i] = static_cast<float>(counts[i]);
  }

  /// 16 bits as fine as they go in powers of two; counts below 65536 keep steps of one.
  void store_scaled(const std::vector<double>& wave) {
    double top = 0;
    for (const double value : wave) top = std::max(top, value);
    const bool counts =
        lidar_.detector.mode == scene::DetectorMode::photons || lidar_.detector.mode == scene::DetectorMode::geiger;
    record_.offset = 0;
    record_.gain = counts && top <= 65535 ? 1 : std::exp2(std::ceil(std::log2(std::max(top, 1e-30) / 65535)));
    for (const double value : wave) {
      record_.samples.push_back(static_cast<std::uint16_t>(std::clamp(std::round(value / record_.gain), 0.0, 65535.0)));
      record_.waveform_pe.push_back(static_cast<float>(value));
    }
  }

  Detection geiger(const std::vector<double>& light) {
    record_.tags = geiger_events(lidar_, light, plan_.seed, key_, line_);
    std::vector<double> events(light.size(), 0.0);
    for (const Photon& tag : record_.tags) {
      const double bin = std::floor((tag.time_s - lidar_.gate.start_s) / lidar_.gate.bin_s);
      if (bin >= 0 && bin < static_cast<double>(events.size())) events[static_cast<std::size_t>(bin)] += 1;
    }
    store_counts(events);
    record_.echoes = cluster_tags(lidar_, record_.tags);
    return finished();
  }

  /// Probability that the return expected about an echo is found.
  double probability_near(double time_s) const {
    const double bin = (time_s - lidar_.gate.start_s) / lidar_.gate.bin_s;
    const double half = std::max(1.0, 0.5 * base::kFwhmOfSigma * recorded_sigma_s(lidar_) / lidar_.gate.bin_s);
    const auto bins = static_cast<double>(recorded_signal_.size());
    const auto first = static_cast<std::size_t>(std::clamp(std::floor(bin - half), 0.0, bins)),
               last = static_cast<std::size_t>(std::clamp(std::ceil(bin + half), 0.0, bins));
    double sum = 0;
    std::size_t top = std::min(first, recorded_signal_.size() - 1);
    for (std::size_t i = first; i < last; ++i) {
      sum += recorded_signal_[i];
      if (recorded_signal_[i] > recorded_signal_[top]) top = i;
    }
    if (lidar_.detector.mode == scene::DetectorMode::geiger)
      return 1 - no_event_probability(sum, speckle_.strongest_modes);
    return bin_detection(lidar_, noise_of_bin(lidar_, noise_, top), first < last ? recorded_signal_[top] : 0,
                         speckle_.strongest_modes);
  }

  /// Returns of a record, on average, that chance makes no more likely than an echo's least likely bin.
  double chance_of(const Echo& echo) const {
    const double bin = (echo.time_s - lidar_.gate.start_s) / lidar_.gate.bin_s,
                 count = static_cast<double>(record_.waveform_pe.size());
    // As far to either side as find_echoes looks for a bin above the threshold.
    const double half =
        0.5 + std::max(1.0, std::ceil(0.5 * base::kFwhmOfSigma * recorded_sigma_s(lidar_) / lidar_.gate.bin_s));
    const auto first = static_cast<std::size_t>(std::clamp(std::floor(bin - half), 0.0, count)),
               last = static_cast<std::size_t>(std::clamp(std::ceil(bin + half), 0.0, count));
    double least = 1;
    for (std::size_t i = first; i < last; ++i) {
      const double value = record_.waveform_pe[i] - noise_.background - noise_.air_at(i);
      if (value > 0) least = std::min(least, noise_chance(lidar_, noise_, i, value));
    }
    return count * least;
  }

  /// Crossings of a bin's threshold by noise alone, averaged over the gate.
  double false_alarms_a_bin() const {
    const bool linear = lidar_.detector.mode == scene::DetectorMode::linear;
    if (noise_.air.empty() && (noise_.gaussian || !linear)) return bin_detection(lidar_, noise_, 0, 0);
    const auto alarms = [&](std::size_t bin) {
      // A linear threshold lies where chance is bin_chance, or higher, at threshold_pe.
      if (linear) return std::min(noise_.bin_chance, noise_chance(lidar_, noise_, bin, lidar_.echoes.threshold_pe));
      return bin_detection(lidar_, noise_of_bin(lidar_, noise_, bin), 0, 0);
    };
    if (noise_.air.empty()) return alarms(0);
    constexpr std::size_t kPlaces = 16;
    const std::size_t places = std::min(kPlaces, noise_.air.size());
    double sum = 0;
    for (std::size_t i = 0; i < places; ++i) sum += alarms((2 * i + 1) * noise_.air.size() / (2 * places));
    return sum / static_cast<double>(places);
  }

  Detection finished() {
    DetectionTruth& truth = record_.truth;
    truth.background_pe = expected_.background, truth.noise_pe = noise_.rms(), truth.threshold_pe = noise_.threshold;
    truth.speckle_modes = speckle_.strongest_modes;
    if (lidar_.detector.mode == scene::DetectorMode::geiger) {
      truth.threshold_pe = lidar_.echoes.threshold_pe;
      truth.detection_probability =
          geiger_detection(lidar_, expected_.signal, expected_.background, truth.speckle_modes);
      truth.false_alarm_rate_hz = geiger_noise_hz(lidar_, expected_.background, expected_.signal.size());
      const double gate_s = static_cast<double>(expected_.signal.size()) * lidar_.gate.bin_s;
      const double dead_s =
          lidar_.detector.dead_time_s > 0 ? std::max(lidar_.detector.dead_time_s, lidar_.gate.bin_s) : gate_s;
      truth.saturated = most_within(dead_s / lidar_.gate.bin_s) > std::max(1, lidar_.detector.cells);
    } else {
      const auto top = std::max_element(recorded_signal_.begin(), recorded_signal_.end());
      const auto bin = static_cast<std::size_t>(top - recorded_signal_.begin());
      truth.detection_probability =
          *top > 0 ? bin_detection(lidar_, noise_of_bin(lidar_, noise_, bin), *top, truth.speckle_modes) : 0;
      truth.false_alarm_rate_hz = false_alarms_a_bin() / lidar_.gate.bin_s;
      for (Echo& echo : record_.echoes) {
        truth.saturated = truth.saturated || echo.saturated;
        echo.chance = static_cast<float>(chance_of(echo));
      }
    }
    for (Echo& echo : record_.echoes) echo.detection_probability = static_cast<float>(probability_near(echo.time_s));
    return std::move(record_);
  }

  /// Most photo-electrons expected within so many bins.
  double most_within(double bins) const {
    const auto reach = static_cast<std::size_t>(std::max(1.0, std::round(bins)));
    double sum = 0, most = 0;
    for (std::size_t i = 0; i < expected_.signal.size(); ++i) {
      sum += expected_.signal[i] + expected_.background;
      if (i >= reach) sum -= expected_.signal[i - reach] + expected_.background;
      most = std::max(most, sum);
    }
    return most;
  }

  const LidarPlan& plan_;
  const scene::Lidar& lidar_;
  DrawSeed seed_;
  std::uint32_t key_;
  int line_;
  RowExpectation expected_;
  SpeckleRow speckle_;
  DetectorNoise noise_;
  std::vector<double> recorded_;         ///< expected light of the pulse after the electronics, photo-electrons
  std::vector<double> recorded_signal_;  ///< of it what is no background
  double largest_ = 0;
  Detection record_;
};

template <class Each>
std::vector<Detection> all_rows(const LidarPlan& plan, const ShotResult& shot, Each&& each) {
  std::vector<Detection> out;
  for (int pixel = 0; pixel < plan.pixels(); ++pixel)
    for (int line = 0; line < plan.lines(); ++line) {
      Row row(plan, shot, pixel, line);
      out.push_back(each(row));
    }
  return out;
}

}  // namespace

std::vector<Detection> detect(const LidarPlan& plan, const ShotResult& shot) {
  return all_rows(plan, shot, [](Row& row) { return row.drawn(); });
}

std::vector<Detection> expected_detections(const LidarPlan& plan, const ShotResult& shot) {
  return all_rows(plan, shot, [](Row& row) { return row.expectation(); });
}

}  // namespace raycube::lidar
