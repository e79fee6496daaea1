// What a render costs, from counts of rays, terms and bands: never a clock, so that two runs give one plan. Seconds are
// those of a nominal machine and serve to compare settings and to say when a tolerance is out of reach.
#pragma once

#include <cstdint>

#include "host/plan/plan.h"

namespace raycube::planner {

/// Counts of one pixel.
struct PixelCounts {
  double samples = 1;  ///< rays from the camera
  double sun_rays = 0, sky_rays = 0;
  double path_rays = 0;  ///< of light between surfaces: from each surface of a path one on and one to the sun
  double terms = 0;      ///< of the band integration
  double bands = 0;
};

/// Nominal seconds: two cores of an AVX-512 server, PoCL (bench/RESULTS.md, park, figures of rays that face their
/// light). A sample pays for its ray, its surface point and its shading. What counts for a choice is what one more
/// takes: a sky ray 2.3 times a sample with its sun ray (0.116 and 0.040 us in the park, 0.08 and 0.065 on the peer
/// scene, 2026-11-25; all of them over their number are 0.143 and 0.076, 0.126 and 0.099). A ray of a path,
/// of the 2 N that a path of N levels may have, takes 0.47 of a sky ray, since most paths end before (0.16 and 0.34 us:
/// park, 34 samples, 24 rays and paths, 4 levels, a server with AVX2 alone, 2026-11-26).
struct CostModel {
  double sample_s = 3.0e-8, sun_ray_s = 2.0e-8, sky_ray_s = 1.15e-7, path_ray_s = 5.4e-8, term_band_s = 1.5e-10;
  double seconds(const PixelCounts& c) const {
    return c.samples * sample_s + c.sun_rays * sun_ray_s + c.sky_rays * sky_ray_s + c.path_rays * path_ray_s +
           c.terms * c.bands * term_band_s;
  }
  /// What a pixel takes whatever its settings: a walk for its group, its place in files. No choice depends on it; what
  /// is said of a whole render does.
  double pixel_s = 4e-6, written_band_s = 1.2e-8;
  double whole_image_s(const PixelCounts& c, double pixels) const {
    return pixels * (seconds(c) + pixel_s + c.bands * written_band_s);
  }
};

/// Past this many nominal seconds for a million pixels a plan says that the tolerance is dear.
inline constexpr double kDear_s_per_megapixel = 30;
/// Settings past this are never chosen: a tolerance that needs them is not kept.
inline constexpr double kMost_s_per_megapixel = 1000;

/// Counts for `samples` a pixel and `directions` towards the sky, with the plan's sources and nodes.
PixelCounts pixel_counts(const plan::Plan& plan, double samples, double directions);

}  // namespace raycube::planner
