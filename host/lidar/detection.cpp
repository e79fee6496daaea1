#include "host/lidar/detection.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "host/base/units.h"
#include "host/lidar/bin_draws.h"
#include "host/lidar/detector.h"
#include "host/lidar/draws.h"
#include "host/lidar/echoes.h"
#include "host/lidar/geiger.h"
#include "host/lidar/record_bins.h"
#include "host/lidar/speckle.h"

namespace raycube::lidar {

/// One row after the other on its way to a record. Where nothing but signal makes counts, bins without it, dark, are
/// left out of all that follows: those from from_ to before past_ are looked at.
class Detecting::Row {
 public:
  explicit Row(const LidarPlan& plan)
      : plan_(plan),
        lidar_(plan.lidar),
        bins_(static_cast<std::size_t>(plan.lidar.gate.bins)),
        echo_half_bins_(0.5 * base::kFwhmOfSigma * recorded_sigma_s(plan.lidar) / plan.lidar.gate.bin_s),
        draws_(plan.seed, 0, 0),
        law_(plan.lidar),
        finder_(plan.lidar, plan.waveform_error),
        signal_(bins_),
        light_(bins_),
        counts_(bins_),
        recorded_(bins_),
        recorded_signal_(bins_) {}

  template <class Make>
  void all(const ShotResult& shot, std::vector<Detection>& records, const Make& make) {
    records.resize(static_cast<std::size_t>(plan_.pixels()) * static_cast<std::size_t>(plan_.lines()));
    std::size_t i = 0;
    for (int pixel = 0; pixel < plan_.pixels(); ++pixel)
      for (int line = 0; line < plan_.lines(); ++line) {
        record_ = &records[i++];
        begin(shot, pixel, line);
        make(*this);
      }
  }

  void draw() {
    const bool geiger_mode = lidar_.detector.mode == scene::DetectorMode::geiger;
    std::copy(signal_.begin() + static_cast<std::ptrdiff_t>(from_),
              signal_.begin() + static_cast<std::ptrdiff_t>(past_),
              light_.begin() + static_cast<std::ptrdiff_t>(from_));
    if (!speckle_.factor.empty())
      for (std::size_t i = from_; i < past_; ++i) light_[i] *= speckle_.factor[i];
    if (background_ != 0)
      for (double& bin : light_) bin += background_;
    if (geiger_mode) return geiger();
    draws_.record(key_, line_);
    draws_.counts(from_, past_ - from_, light_.data() + from_, counts_.data() + from_);
    if (lidar_.detector.mode == scene::DetectorMode::linear)
      digitise(amplified());
    else
      store_scaled(counts_);
    finder_(record_->waveform_pe, from_, past_, *noise_, record_->echoes);
    finish();
  }

  void expect() {
    light_.assign(recorded_row_, recorded_row_ + bins_);
    if (background_ != 0)
      for (double& value : light_) value += background_;
    store_scaled(light_);
    DetectorNoise none = *noise_;
    none.drawn = false;
    if (!(none.full_scale > 0) || lidar_.detector.mode == scene::DetectorMode::geiger) none.full_scale = 0;
    finder_(record_->waveform_pe, from_, past_, none, record_->echoes);
    finish();
  }

 private:
  /// What is expected of the row, and the noise that goes with it.
  void begin(const ShotResult& result, int pixel, int line) {
    key_ = draw_key(plan_, result.shot.pulse, pixel), line_ = line;
    record_->pulse = result.shot.pulse, record_->pixel = pixel, record_->line = line;
    record_->gain = 1, record_->offset = 0, record_->truth = {};
    record_->tags.clear();
    record_->waveform_pe.assign(bins_, 0.0F), record_->samples.assign(bins_, 0);
    const std::size_t row =
        static_cast<std::size_t>(pixel) * static_cast<std::size_t>(plan_.lines()) + static_cast<std::size_t>(line);
    const double efficiency = lidar_.receiver.quantum_efficiency;
    scale_bins(result.first.data() + row * bins_, efficiency, bins_, signal_.data());
    for (const std::vector<float>* part : {&result.multiple, &result.air})
      if (!part->empty()) add_scaled_bins(part->data() + row * bins_, efficiency, bins_, signal_.data());
    const double light_hz =
        lidar_.detector.solar_background && !result.background_hz.empty() ? result.background_hz[row] : 0;
    if (plan_.waveform_error > 0) tell_of_surfaces(result, row);
    background_ = (light_hz * efficiency + lidar_.detector.dark_rate_hz) * lidar_.gate.bin_s;
    speckle_ = {};
    if (lidar_.speckle.on) speckle_ = speckle_row(plan_, result.shot, pixel, line, signal_);
    noise_ = &law_.of(background_, largest_of(signal_.data(), bins_));
    choose_bins();
    recorded_row_ = signal_.data();
    if (noise_->response.size() > 1) {
      recorded_.assign(bins_, 0.0);
      convolve(signal_.data(), 0, bins_, bins_, noise_->response, recorded_.data());
      recorded_row_ = recorded_.data();
    }
    recorded_signal_row_ = recorded_row_;
    if (lidar_.echoes.air_is_background && lidar_.detector.mode != scene::DetectorMode::geiger) take_media(result, row);
  }

  /// Of sub-rays alone: air and particles are integrated along the beam.
  void tell_of_surfaces(const ShotResult& result, std::size_t of_row) {
    surfaces_.resize(bins_);
    scale_bins(result.first.data() + of_row * bins_, lidar_.receiver.quantum_efficiency, bins_, surfaces_.data());
    if (!result.particles.empty())
      add_scaled_bins(result.particles.data() + of_row * bins_, -lidar_.receiver.quantum_efficiency, bins_,
                      surfaces_.data());
    finder_.expect_surfaces(surfaces_);
  }

  /// The bins that may hold anything: all where there is noise, else those that signal reaches.
  void choose_bins() {
    from_ = 0, past_ = bins_;
    const bool linear = lidar_.detector.mode == scene::DetectorMode::linear;
    if (background_ != 0 || lidar_.detector.mode == scene::DetectorMode::geiger ||
        (linear && lidar_.detector.readout_noise_e > 0))
      return;
    const std::size_t reach = noise_->response.size() / 2;
    const std::size_t lit = first_lit(signal_.data(), bins_);
    from_ = lit - std::min(lit, reach);
    past_ = std::max(from_, std::min(bins_, past_lit(signal_.data(), bins_) + reach));
  }

  /// What air and particles in volumes send back counts as background.
  void take_media(const ShotResult& result, std::size_t of_row) {
    if (result.air.empty() && result.particles.empty()) return;
    with_air_ = *noise_;
    with_air_.air.assign(bins_, 0.0);
    std::vector<double> row(bins_, 0.0);
    for (const std::vector<float>* part : {&result.air, &result.particles})
      if (!part->empty())
        add_scaled_bins(part->data() + of_row * bins_, lidar_.receiver.quantum_efficiency, bins_, row.data());
    convolve(row.data(), 0, bins_, bins_, noise_->response, with_air_.air.data());
    with_air_.air_modes = speckle_.strongest_modes;
    noise_ = &with_air_;
    for (std::size_t i = 0; i < bins_; ++i) recorded_signal_[i] = std::max(0.0, recorded_row_[i] - noise_->air[i]);
    recorded_signal_row_ = recorded_signal_.data();
  }

  /// Avalanche gain of every bin's electrons, the electronics' response, readout noise; all over the mean gain.
  const std::vector<double>& amplified() {
    // Sum of `counts` gains of mean 1 and variance F - 1, each a gamma variate: exact for one carrier (F = 2), and
    // never negative.
    const double spread = noise_->excess - 1;
    if (spread > 1e-12)
      for (std::size_t i = from_; i < past_; ++i)
        if (counts_[i] > 0)
          counts_[i] =
              spread *
              Stream(plan_.seed, key_, static_cast<std::uint32_t>(i), DrawFor::gain, line_).gamma(counts_[i] / spread);
    std::vector<double>* out = &counts_;
    if (noise_->response.size() > 1) {
      amplified_.assign(bins_, 0.0);
      convolve(counts_.data(), from_, past_, bins_, noise_->response, amplified_.data());
      out = &amplified_;
    }
    const double readout = lidar_.detector.readout_noise_e / lidar_.detector.gain;
    if (readout > 0) draws_.add_readout(from_, past_ - from_, readout, out->data() + from_);
    return *out;
  }

  /// Sample 0 lies 8 rms of the readout below zero, so that noise is not cut on one side.
  void digitise(const std::vector<double>& signal) {
    const double steps = std::exp2(lidar_.detector.bits) - 1;
    record_->offset = -8 * lidar_.detector.readout_noise_e / lidar_.detector.gain;
    record_->gain = (noise_->full_scale - record_->offset) / steps;
    record_->truth.saturated =
        digitise_bins(signal.data() + from_, past_ - from_, record_->offset, record_->gain, steps,
                      record_->samples.data() + from_, record_->waveform_pe.data() + from_);
  }

  /// 16 bits as fine as they go in powers of two; counts below 65536 keep steps of one.
  void store_scaled(const std::vector<double>& wave) {
    const double top = largest_of(wave.data() + from_, past_ - from_);
    const bool counts =
        lidar_.detector.mode == scene::DetectorMode::photons || lidar_.detector.mode == scene::DetectorMode::geiger;
    record_->offset = 0;
    record_->gain = counts && top <= 65535 ? 1 : std::exp2(std::ceil(std::log2(std::max(top, 1e-30) / 65535)));
    store_bins(wave.data() + from_, past_ - from_, record_->gain, record_->samples.data() + from_,
               record_->waveform_pe.data() + from_);
  }

  void geiger() {
    record_->tags = geiger_events(lidar_, light_, plan_.seed, key_, line_);
    std::fill(counts_.begin(), counts_.end(), 0.0);
    for (const Photon& tag : record_->tags) {
      const double bin = std::floor((tag.time_s - lidar_.gate.start_s) / lidar_.gate.bin_s);
      if (bin >= 0 && bin < static_cast<double>(bins_)) counts_[static_cast<std::size_t>(bin)] += 1;
    }
    store_scaled(counts_);
    record_->echoes = cluster_tags(lidar_, record_->tags);
    finish();
  }

  /// Bins no farther than `half` from a time: [0] to before [1].
  std::array<std::size_t, 2> bins_about(double time_s, double half) const {
    const double bin = (time_s - lidar_.gate.start_s) / lidar_.gate.bin_s, count = static_cast<double>(bins_);
    return {static_cast<std::size_t>(std::clamp(std::floor(bin - half), 0.0, count)),
            static_cast<std::size_t>(std::clamp(std::ceil(bin + half), 0.0, count))};
  }

  /// Probability that the return expected about an echo is found.
  double probability_near(double time_s) const {
    const auto [first, last] = bins_about(time_s, std::max(1.0, echo_half_bins_));
    double sum = 0;
    std::size_t top = std::min(first, bins_ - 1);
    for (std::size_t i = first; i < last; ++i) {
      sum += recorded_signal_row_[i];
      if (recorded_signal_row_[i] > recorded_signal_row_[top]) top = i;
    }
    if (lidar_.detector.mode == scene::DetectorMode::geiger)
      return 1 - no_event_probability(sum, speckle_.strongest_modes);
    return bin_detection(lidar_, *noise_, top, first < last ? recorded_signal_row_[top] : 0, speckle_.strongest_modes);
  }

  /// Returns of a record, on average, that chance makes no more likely than an echo's least likely bin.
  double chance_of(const Echo& echo) const {
    // As far to either side as a finder looks for a bin above the threshold.
    const auto [first, last] = bins_about(echo.time_s, 0.5 + std::max(1.0, std::ceil(echo_half_bins_)));
    const auto chance = [&](std::size_t bin, double value) {
      return value > 0 ? noise_chance(lidar_, *noise_, bin, value) : 1;
    };
    double least = 1, highest = 0;
    for (std::size_t i = first; i < last; ++i) {
      const double value = static_cast<double>(record_->waveform_pe[i]) - noise_->background - noise_->air_at(i);
      if (noise_->air.empty())  // one law for all bins: the highest is the least likely
        highest = std::max(highest, value);
      else
        least = std::min(least, chance(i, value));
    }
    return static_cast<double>(bins_) * std::min(least, chance(first, highest));
  }

  /// Crossings of a bin's threshold by noise alone, averaged over the gate.
  double false_alarms_a_bin() const {
    if (noise_->air.empty()) return noise_->alarms;
    constexpr std::size_t kPlaces = 16;
    const std::size_t places = std::min(kPlaces, bins_);
    double sum = 0;
    for (std::size_t i = 0; i < places; ++i) sum += alarm_chance(lidar_, *noise_, (2 * i + 1) * bins_ / (2 * places));
    return sum / static_cast<double>(places);
  }

  void finish() {
    DetectionTruth& truth = record_->truth;
    truth.background_pe = background_, truth.noise_pe = noise_->rms(), truth.threshold_pe = noise_->threshold;
    truth.speckle_modes = speckle_.strongest_modes;
    if (lidar_.detector.mode == scene::DetectorMode::geiger)
      finish_geiger();
    else
      finish_waveform();
    for (Echo& echo : record_->echoes) echo.detection_probability = static_cast<float>(probability_near(echo.time_s));
  }

  void finish_geiger() {
    DetectionTruth& truth = record_->truth;
    truth.threshold_pe = lidar_.echoes.threshold_pe;
    truth.detection_probability = geiger_detection(lidar_, signal_, background_, truth.speckle_modes);
    truth.false_alarm_rate_hz = geiger_noise_hz(lidar_, background_, bins_);
    const double gate_s = static_cast<double>(bins_) * lidar_.gate.bin_s;
    const double dead_s =
        lidar_.detector.dead_time_s > 0 ? std::max(lidar_.detector.dead_time_s, lidar_.gate.bin_s) : gate_s;
    truth.saturated = most_within(dead_s / lidar_.gate.bin_s) > std::max(1, lidar_.detector.cells);
  }

  void finish_waveform() {
    DetectionTruth& truth = record_->truth;
    const double* const top = std::max_element(recorded_signal_row_ + from_, recorded_signal_row_ + past_);
    truth.detection_probability =
        from_<past_&& * top> 0 ? bin_detection(lidar_, *noise_, static_cast<std::size_t>(top - recorded_signal_row_),
                                               *top, truth.speckle_modes)
                               : 0;
    truth.false_alarm_rate_hz = false_alarms_a_bin() / lidar_.gate.bin_s;
    for (Echo& echo : record_->echoes) {
      truth.saturated = truth.saturated || echo.saturated;
      echo.chance = static_cast<float>(chance_of(echo));
    }
  }

  /// Most photo-electrons expected within so many bins.
  double most_within(double bins) const {
    const auto reach = static_cast<std::size_t>(std::max(1.0, std::round(bins)));
    double sum = 0, most = 0;
    for (std::size_t i = 0; i < bins_; ++i) {
      sum += signal_[i] + background_;
      if (i >= reach) sum -= signal_[i - reach] + background_;
      most = std::max(most, sum);
    }
    return most;
  }

  const LidarPlan& plan_;
  const scene::Lidar& lidar_;
  const std::size_t bins_;
  const double echo_half_bins_;  ///< half the full width at half maximum of a recorded pulse
  BinDraws draws_;
  NoiseOfRecords law_;
  EchoFinder finder_;

  std::uint32_t key_ = 0;
  int line_ = 0;
  Detection* record_ = nullptr;
  double background_ = 0;  ///< expected photo-electrons a bin: background light and dark counts
  std::size_t from_ = 0, past_ = 0;
  SpeckleRow speckle_;
  DetectorNoise with_air_;
  const DetectorNoise* noise_ = nullptr;
  std::vector<double> signal_;  ///< [bin] expected photo-electrons, quantum efficiency included
  std::vector<double> light_, counts_, amplified_;
  std::vector<double> surfaces_;  ///< [bin] of signal_ what surfaces scatter once
  std::vector<double> recorded_, recorded_signal_;
  const double* recorded_row_ = nullptr;         ///< expected light of the pulse after the electronics
  const double* recorded_signal_row_ = nullptr;  ///< of it what is no background
};

Detecting::Detecting(const LidarPlan& plan) : row_(std::make_unique<Row>(plan)) {}
Detecting::~Detecting() = default;
Detecting::Detecting(Detecting&&) noexcept = default;

void Detecting::detect(const ShotResult& shot, std::vector<Detection>& records) {
  row_->all(shot, records, [](Row& row) { row.draw(); });
}

void Detecting::expect(const ShotResult& shot, std::vector<Detection>& records) {
  row_->all(shot, records, [](Row& row) { row.expect(); });
}

std::vector<Detection> detect(const LidarPlan& plan, const ShotResult& shot) {
  std::vector<Detection> records;
  Detecting(plan).detect(shot, records);
  return records;
}

std::vector<Detection> expected_detections(const LidarPlan& plan, const ShotResult& shot) {
  std::vector<Detection> records;
  Detecting(plan).expect(shot, records);
  return records;
}

}  // namespace raycube::lidar
