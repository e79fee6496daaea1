// The converged double-precision waveforms of a few pulses, and how far others are from them.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "host/lidar/lidar_plan.h"

namespace raycube::study {

/// Rows [shot][pixel][line][bin], photons at the detector, all orders together, background left out.
struct ConvergedPulses {
  std::size_t bins = 0;  ///< of a row
  double bin_s = 0;
  std::vector<double> photons;  ///< mean of two independent halves
  std::vector<double> half;     ///< (first half - second half) / 2
};

/// `plan`: of many sub-rays and bounces and of the bins that count. The halves differ in the footprint's turn and in
/// all draws of scattered light. `progress`: called with the pulses done since the last call.
ConvergedPulses converge_pulses(const scene::CompiledScene& scene, const lidar::LidarPlan& plan,
                                const std::vector<std::int64_t>& pulses, int threads,
                                const std::function<void(std::uint64_t)>& progress = {});

struct PulseError {
  double rms = 0;            ///< over all bins, divided by the rms of the rows' peaks
  double own = 0;            ///< the reference's own standard error, likewise
  double p95 = 0;            ///< over rows: 95th percentile of each row's rms difference in its bins, divided alike
  double low = 0, high = 0;  ///< error bar of rms, as in ErrorFigures, over rows
};

/// photons: rows of the same shots, pixels and lines, in `bins` bins of bin_s from the same start. Wider bins are
/// spread evenly over the reference's.
PulseError pulse_error(const ConvergedPulses& reference, const std::vector<float>& photons, std::size_t bins,
                       double bin_s);

}  // namespace raycube::study
