// What a render costs, from counts of rays, terms and bands: never a clock, so that two runs give one plan. Seconds are
// those of a nominal machine and serve to compare settings and to say when a tolerance is out of reach.
#pragma once

#include <cstdint>

#include "host/plan/plan.h"

namespace raycube::planner {

/// Counts of one pixel.
struct PixelCounts {
  double samples = 1;  ///< rays from the camera
  double sun_rays = 0, sky_rays = 0, lamp_rays = 0;
  double lamps = 0;          ///< that draws weigh
  double paths = 0;          ///< of light between surfaces, of one ray each
  double path_surfaces = 0;  ///< that they come to, each with a ray to the sun and one on
  double skeleton = 0;       ///< wavelengths that paths carry
  double terms = 0;          ///< of the band integration
  double bands = 0;

  double rays() const { return samples + sun_rays + sky_rays + lamp_rays + paths + 2 * path_surfaces; }
};

/// Nominal seconds: two cores of an AVX-512 server, PoCL (bench/RESULTS.md, park, figures of rays that face their
/// light). A sample pays for its ray, its surface point and its shading. What counts for a choice is what one more
/// takes: a sky ray 2.3 times a sample with its sun ray (0.116 and 0.040 us in the park, 0.08 and 0.065 on the peer
/// scene, 2026-11-25; all of them over their number are 0.143 and 0.076, 0.126 and 0.099). A path and what it meets
/// take 2.8 sky rays in the park (0.35 surfaces, 96 wavelengths), 1.04 on the starter scene (0.08, 32), 0.98 and 0.87
/// where trees and targets are few (0.02 surfaces; a server with AVX2 alone, 2026-11-26): one ray, and what each
/// surface takes the more the more wavelengths are carried. A ray to a lamp counts as one into the sky; what each lamp
/// takes where one is drawn is a guess.
struct CostModel {
  double sample_s = 3.0e-8, sun_ray_s = 2.0e-8, sky_ray_s = 1.15e-7, term_band_s = 1.5e-10, lamp_s = 6e-9;
  double path_s = 1.0e-7, path_surface_s = 1.4e-7, carried_s = 4e-9;
  double seconds(const PixelCounts& c) const {
    return c.samples * sample_s + c.sun_rays * sun_ray_s + (c.sky_rays + c.lamp_rays) * sky_ray_s + c.lamps * lamp_s +
           c.paths * path_s + c.path_surfaces * (path_surface_s + c.skeleton * carried_s) +
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

/// Counts for `samples` a pixel and `directions` towards the sky, with the plan's sources and nodes; paths_per_two: as
/// SkyRays has it, the plan's where it is not given.
PixelCounts pixel_counts(const plan::Plan& plan, double samples, double directions);
PixelCounts pixel_counts(const plan::Plan& plan, double samples, double directions, int paths_per_two);

}  // namespace raycube::planner
