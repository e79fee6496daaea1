// Pulses of the device against the reference, bin by bin.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "host/reference/double_trace.h"
#include "host/reference/lidar_shot.h"

namespace raycube::reference {

/// Beyond these the check fails.
struct LidarLimits {
  double bin = 1e-5;     ///< of a line's peak bin, for pulses whose rays and ways to the receiver are the same ones
  double ledger = 1e-6;  ///< of the emitted energy: how far the device's ledger may be from closed
  /// Of the peak bin of air and of particles. The device integrates along the beam's middle, not along every sub-ray,
  /// and lets surfaces stop it by whole bins: `air_end` is for bins that hold an echo of a surface. The device takes
  /// the share of the beam that a field's edge cuts off from the footprint without its turn about the axis:
  /// footprint_noise is added to both where edges can cut beams.
  double air = 1e-2, air_end = 5e-2;
  double deviations = 5;  ///< of the statistics of scattered light
};

/// Four standard deviations of the share of a beam on one side of an edge, by its number of sub-rays: 1.51 % at 64
/// falling as N^-0.79, a fit to the table of the LIDAR specification, 2.1 (0.53 % at 256, 0.16 % at 1024); 0 where no
/// edge can cut the beam.
double footprint_noise(const lidar::LidarPlan& plan);

struct LidarCompareOptions {
  LidarLimits limits;
  int threads = 0;    ///< 0: all
  int replicas = 16;  ///< of scattered light, each with draws of its own
};

/// Scattered light of all pulses together, device against replicas of the reference.
struct LidarScattered {
  std::uint64_t pulses = 0,
                same_draws =
                    0;  ///< same_draws: pulses whose scattered bins agree within limits.bin on the device's own draws
  std::size_t groups = 0;                 ///< of bins, each wide enough for the noise to be normal
  double energy_ratio = 1, energy_z = 0;  ///< device / reference, and standard errors between
  double chi_square = 0;                  ///< per group
  double chi_z = 0;                       ///< deviations from what replicas have against one another
};

/// sums: [device, replica 0, 1, ...][line * bins], over all pulses and pixels. Fewer than 7 replicas: nothing is said.
LidarScattered compare_scattered(const std::vector<std::vector<double>>& sums, const scene::Lidar& lidar);

struct LidarReport {
  LidarLimits limits;
  std::uint64_t pulses = 0, rays = 0;
  std::array<std::uint64_t, kCauses> hits{};   ///< rays by cause
  std::uint64_t parted_pulses = 0;             ///< first hits differ
  std::uint64_t edge_pulses = 0;               ///< beyond the limit, with a way to the receiver that rounding decides
  std::uint64_t rounded_pulses = 0;            ///< beyond the limit by no more than rounded paths change in a bin
  double rounded_worst = 0, float_path_m = 0;  ///< float_path_m: how far floats may be off in such a pulse's paths
  std::uint64_t beyond_pulses = 0;             ///< beyond the limit for no such reason
  std::uint64_t compared_pulses = 0;           ///< the others
  double median = 0, worst = 0;                ///< of each compared pulse's worst bin, over its line's peak
  std::int64_t worst_pulse = -1;
  int worst_line = 0, worst_bin = 0;
  double ledger_closure = 0,
         ledger_difference = 0;  ///< worst of the device; worst against the reference, compared pulses
  bool has_air = false, has_scattered = false;
  double air_end_worst = 0;
  double air_median = 0, air_worst = 0;  ///< of each compared pulse, returns of air and particles over their own peak
  LidarScattered scattered;
  std::int64_t unexplained_pulse = -1;  ///< the first whose hits nothing explains
  std::uint32_t unexplained_ray = 0;

  std::vector<std::string> failures() const;
  std::string text() const;
  std::string json() const;
};

class LidarComparison {
 public:
  /// Keeps references to scene and plan.
  LidarComparison(const scene::CompiledScene& scene, const lidar::LidarPlan& plan, const LidarCompareOptions& options);

  /// Shots with first hits. Several threads.
  void add(const std::vector<lidar::ShotResult>& shots);
  LidarReport report() const;

 private:
  struct Result;
  Result compare(const lidar::ShotResult& device) const;
  bool within_rounding(const lidar::ShotResult& device, const LidarReference& reference) const;

  const scene::CompiledScene& scene_;
  const lidar::LidarPlan& plan_;
  LidarCompareOptions options_;
  EmbreeScene embree_;
  DoubleTracer judge_;
  std::vector<Result> results_;
  std::vector<std::vector<double>>
      scattered_;  ///< [device, replica 0, 1, ...][line * bins], sums over pulses and pixels

 public:
  ~LidarComparison();
};

}  // namespace raycube::reference
