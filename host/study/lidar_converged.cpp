#include "host/study/lidar_converged.h"

#include <algorithm>
#include <cmath>
#include <mutex>

#include "host/base/error.h"
#include "host/base/interrupt.h"
#include "host/reference/lidar_shot.h"
#include "host/base/parallel.h"

namespace raycube::study {

namespace {

constexpr std::uint64_t kSeedStep = 0x9E3779B97F4A7C15ull;  ///< between the halves' seeds: any other number would do

std::vector<double> all_orders(const reference::LidarRows& rows, std::size_t values) {
  std::vector<double> out(values, 0.0);
  for (const auto* part : {&rows.first, &rows.multiple, &rows.air, &rows.particles})
    for (std::size_t i = 0; i < part->size(); ++i) out[i] += (*part)[i];
  return out;
}

/// A row in bins of other width, as photons per reference bin.
std::vector<double> spread(const float* row, std::size_t bins, double ratio, std::size_t wanted) {
  std::vector<double> out(wanted, 0.0);
  for (std::size_t j = 0; j < bins; ++j) {
    const double from = static_cast<double>(j) * ratio, to = from + ratio;
    for (std::size_t i = static_cast<std::size_t>(from); i < wanted && static_cast<double>(i) < to; ++i) {
      const double shared = std::min(to, static_cast<double>(i) + 1) - std::max(from, static_cast<double>(i));
      if (shared > 0) out[i] += static_cast<double>(row[j]) * shared / ratio;
    }
  }
  return out;
}

}  // namespace

ConvergedPulses converge_pulses(const scene::CompiledScene& scene, const lidar::LidarPlan& plan,
                                const std::vector<std::int64_t>& pulses, int threads,
                                const std::function<void(std::uint64_t)>& progress) {
  const reference::EmbreeScene embree(scene);
  ConvergedPulses out;
  out.bins = static_cast<std::size_t>(plan.lidar.gate.bins);
  out.bin_s = plan.lidar.gate.bin_s;
  const std::size_t values =
      out.bins * static_cast<std::size_t>(plan.pixels()) * static_cast<std::size_t>(plan.lines());
  std::vector<lidar::Shot> shots[2];
  for (std::uint64_t half = 0; half < 2; ++half)
    for (const std::int64_t pulse : pulses)
      for (lidar::Shot& shot : lidar::make_shots(plan.lidar, pulse, 1, plan.seed + half * kSeedStep))
        shots[half].push_back(shot);
  out.photons.resize(shots[0].size() * values);
  out.half.resize(out.photons.size());
  std::mutex mutex;
  base::for_each_index(shots[0].size(), threads, [&](std::size_t s) {
    base::throw_if_interrupted();
    std::vector<double> found[2];
    for (std::uint64_t half = 0; half < 2; ++half) {
      reference::LidarShotOptions options;
      options.seed = plan.seed + (half + 1) * kSeedStep;
      options.own_seed = true;
      found[half] = all_orders(reference::reference_shot(scene, embree, plan, shots[half][s], options).rows, values);
    }
    for (std::size_t i = 0; i < values; ++i) {
      out.photons[s * values + i] = (found[0][i] + found[1][i]) / 2;
      out.half[s * values + i] = (found[0][i] - found[1][i]) / 2;
    }
    if (!progress) return;
    const std::lock_guard lock(mutex);
    progress(1);
  });
  return out;
}

PulseError pulse_error(const ConvergedPulses& reference, const std::vector<float>& photons, std::size_t bins,
                       double bin_s) {
  const std::size_t rows = reference.photons.size() / reference.bins;
  if (bins == 0 || photons.size() != rows * bins)
    throw base::Error(base::Fault::bug, "pulse_error: " + std::to_string(photons.size()) + " values for " +
                                            std::to_string(rows) + " rows of " + std::to_string(bins) + " bins");
  const double ratio = bin_s / reference.bin_s;
  double peaks = 0, own = 0, all = 0;
  std::vector<double> squares(rows, 0.0);
  for (std::size_t r = 0; r < rows; ++r) {
    const std::vector<double> found = spread(photons.data() + r * bins, bins, ratio, reference.bins);
    double peak = 0;
    for (std::size_t i = 0; i < reference.bins; ++i) {
      const double exact = reference.photons[r * reference.bins + i];
      squares[r] += std::pow(found[i] - exact, 2);
      own += std::pow(reference.half[r * reference.bins + i], 2);
      peak = std::max(peak, exact);
    }
    peaks += peak * peak, all += squares[r];
  }
  PulseError out;
  if (!(peaks > 0))
    throw base::Error(
        base::Fault::input,
        "none of the pulses that were picked has a return inside the gate: widen it, or pick more pulses");
  out.rms = std::sqrt(all / peaks);
  out.own = std::sqrt(own / peaks);
  const double n = static_cast<double>(rows), mean = all / n;
  double spread_of = 0;
  for (const double s : squares) spread_of += std::pow(s - mean, 2);
  const double standard = out.rms > 0 && n > 1 ? 0.5 * std::sqrt(spread_of / (n - 1) / n) / (peaks / n) / out.rms : 0;
  out.low = std::max(0.0, std::sqrt(std::max(0.0, out.rms * out.rms - out.own * out.own)) - standard);
  out.high = out.rms + standard;
  const std::size_t at = static_cast<std::size_t>(std::ceil(0.95 * n)) - 1;
  std::nth_element(squares.begin(), squares.begin() + static_cast<std::ptrdiff_t>(at), squares.end());
  out.p95 = std::sqrt(squares[at] / (peaks / n));
  return out;
}

}  // namespace raycube::study
