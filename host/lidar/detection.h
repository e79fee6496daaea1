// From expected photons to records: photo-electrons, digitised waveforms, time tags, echoes. A stage of its own: the
// same numbers come out during a run and from stored expectations, in any order of pulses, pixels and lines, since
// every draw is a function of (plan.seed, draw_key, line, bin).
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "host/lidar/lidar_plan.h"

namespace raycube::lidar {

/// A registered event of a Geiger detector: the avalanche's time after emission, jitter included, s; which parallel
/// cell.
struct Photon {
  double time_s = 0;
  int cell = 0;
};

/// A return found in a waveform.
struct Echo {
  double range_m = 0;   ///< c time_s / (2 group_index): half the path
  double time_s = 0;    ///< of the echo's centre, after emission
  float peak_pe = 0;    ///< highest value above background and (air_is_background) air, photo-electrons per bin
  float energy_pe = 0;  ///< area, photo-electrons
  float fwhm_s = 0;     ///< of the echo as recorded: pulse, target and electronics together
  float detection_probability =
      0;             ///< analytic, of the expected return: its highest bin reaches the threshold (geiger: the expected
                     ///< photo-electrons within an echo's width fire a cell)
  float chance = 0;  ///< returns at least so unlikely that noise, background and air make of a record on
                     ///< average; geiger: 0
  int number = 1, of = 1;  ///< from 1, in order of time
  bool saturated = false;  ///< touches the full scale
  bool cut = false;        ///< nearer to an end of the gate than half a recorded pulse: its range is a bound
};

/// What a record's reader should know of how it came about.
struct DetectionTruth {
  double background_pe = 0;  ///< expected photo-electrons per bin of background light and dark counts
  double noise_pe = 0;       ///< rms of a bin without signal, primary photo-electrons
  double threshold_pe =
      0;  ///< an echo's peak is at least that much above the background; more where air is (noise_of_bin)
  double detection_probability =
      0;  ///< analytic: highest expected bin reaches the threshold (geiger: at least one event from the signal)
  double false_alarm_rate_hz =
      0;  ///< crossings of the threshold by noise alone, per second of gate (with air: mean of 16 places)
  double speckle_modes = 0;  ///< of the strongest return; 0: speckle off
  bool saturated =
      false;  ///< a sample at full scale, or (geiger) an expectation above one photo-electron per cell and dead time
};

/// Record of one pixel at one line of one pulse.
struct Detection {
  std::int64_t pulse = 0;
  int pixel = 0, line = 0;
  std::vector<float>
      waveform_pe;  ///< [bin] primary photo-electrons (linear: digitised signal over the gain; geiger: events)
  std::vector<std::uint16_t> samples;  ///< [bin] what the digitiser wrote: waveform_pe = offset + gain * sample
  double gain = 1, offset = 0;         ///< photo-electrons per step, photo-electrons at sample 0
  std::vector<Photon> tags;            ///< geiger: in order of time
  std::vector<Echo> echoes;            ///< in order of time, at most max_returns
  DetectionTruth truth;
};

/// Makes records of shots, one after the other in one thread: its memory and its thresholds are kept from one to the
/// next.
class Detecting {
 public:
  explicit Detecting(const LidarPlan& plan);
  ~Detecting();
  Detecting(Detecting&&) noexcept;

  /// Records of a shot in the order [pixel][line], in place of what `records` holds. Background light takes part where
  /// the shot has it and the detector asks for it. linear with full_scale_e = 0: the full scale of a record is the
  /// power of two above its largest expectation plus six sigma, so that a survey needs few waveform descriptors.
  void detect(const ShotResult& shot, std::vector<Detection>& records);

  /// Echoes of the expectations themselves (photo-electrons, no noise drawn), thresholds as for detect(): truth, or a
  /// quick look.
  void expect(const ShotResult& shot, std::vector<Detection>& records);

 private:
  class Row;
  std::unique_ptr<Row> row_;
};

/// The same for one shot alone.
std::vector<Detection> detect(const LidarPlan& plan, const ShotResult& shot);
std::vector<Detection> expected_detections(const LidarPlan& plan, const ShotResult& shot);

}  // namespace raycube::lidar
