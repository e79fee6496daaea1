// First hits of the device against Embree (robust) and double arithmetic, on the same fp32 rays: by the million,
// nothing else.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "host/reference/sampled_pixel.h"

namespace raycube::reference {

/// What the device said about one pixel's rays.
struct PixelHits {
  PixelAddress address;
  std::vector<Hit> hits;  ///< [sample]
};

/// A ray whose hit nothing explains, named so that anyone can trace it again.
struct UnexplainedRay {
  std::uint32_t line = 0, sample = 0, ray = 0;  ///< pixel, and number of the ray among its samples
  Hit device, embree, exact;                    ///< exact: of the double traversal
};

struct HitReport {
  static constexpr std::size_t kMostNamed = 16;

  std::uint64_t rays = 0;
  std::array<std::uint64_t, kCauses> hits{};         ///< device against Embree, by Cause
  std::uint64_t hit_miss = 0;                        ///< one hit, the other missed: device and Embree
  std::uint64_t hit_miss_double = 0;                 ///< device and double, over all rays
  std::uint64_t device_right = 0, embree_right = 0;  ///< of the explained: the hit of double arithmetic is theirs
  std::vector<UnexplainedRay> unexplained;           ///< the first kMostNamed in image order

  std::uint64_t of(Cause cause) const { return hits[static_cast<std::size_t>(cause)]; }
  /// Rays that differ from Embree's within the bounds of contact.h, and their share of all.
  std::uint64_t explained() const;
  double explained_share() const { return rays ? static_cast<double>(explained()) / static_cast<double>(rays) : 0; }
  void add(const HitReport& other);
};

class HitComparison {
 public:
  /// Keeps references to scene and instrument.
  HitComparison(const scene::CompiledScene& scene, const scene::Instrument& instrument, std::uint64_t seed,
                int threads = 0);

  /// Compares every ray of these pixels, on several threads. Where device and Embree differ the ray is retraced in
  /// double (DoubleTracer::explain). Whether it hits at all is asked of double for every ray; a device that double
  /// contradicts there beyond the bounds is unexplained even when Embree sides with it.
  void add(const std::vector<PixelHits>& pixels);
  const HitReport& report() const { return report_; }

 private:
  HitReport compare(const PixelHits& pixel) const;

  const scene::Instrument& instrument_;
  std::uint64_t seed_;
  int threads_;
  ReferenceScene scene_;
  HitReport report_;
};

}  // namespace raycube::reference
