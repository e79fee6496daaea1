// What stands behind a return: the surfaces that the pulse's sub-rays met within the echo, for truth beside every
// point.
#pragma once

#include <vector>

#include "host/lidar/detection.h"
#include "host/lidar/lidar_plan.h"
#include "host/lidar/volumes.h"
#include "scene_compiler/compiled_scene.h"

namespace raycube::lidar {

struct ReturnTruth {
  double range_m =
      0;  ///< half the path over the surfaces, weighted by what they send back; NaN: no first surface there
  float expected_pe = 0;  ///< photo-electrons of these surfaces, once scattered, without gloss and the image's blur
  int order = 0;          ///< 1; 0 where no first surface explains the echo (noise, air, later bounces)
  std::uint32_t object = RC_NONE;    ///< the user's number of the placement whose surface that sends most
  std::uint32_t material = RC_NONE;  ///< its material with the largest share, a family's first
  float incidence_deg = 0;           ///< mean angle between beam and normal
  float overlap = 0;                 ///< mean vignetting
  float transmission_2way = 0;       ///< of air and volumes from exit to pupil, mean of the line after the exponential
  float subray_share = 0;            ///< of the pulse's sub-rays (receiver sampling: of the pixel's samples)
  /// How many pulses before this one its light was sent, fold_ambiguous (negative: after it). range_m is of that pulse.
  int pulses_back = 0;
};

/// A sub-ray's first surface.
struct SurfacePoint {
  Vec3 at_m{}, normal{};                                 ///< unit normal towards the sub-ray's start
  std::uint32_t surface = RC_NONE, placement = RC_NONE;  ///< placement: the user's number
  bool hit = false;
};
/// Start and unit direction of a sub-ray.
struct SubRay {
  Vec3 from_m{}, direction{};
};
/// Those of a shot; of a pixel, receiver sampling.
class SubRays {
 public:
  SubRays(const LidarPlan& plan, const Shot& shot, int pixel);
  SubRay ray(int k) const;

 private:
  const LidarPlan& plan_;
  const Shot& shot_;
  bool backwards_ = false;
  double column_ = 0, row_ = 0, scale_ = 0;
  Vec3 u_{}, v_{};
};
/// The plane of the triangle that a sub-ray met first, in double.
class HitPlane {
 public:
  HitPlane() = default;
  HitPlane(const scene::CompiledScene& scene, const FirstHit& hit);  ///< hit: not a miss
  bool is_of(const FirstHit& hit) const { return hit.instance == hit_.instance && hit.primitive == hit_.primitive; }
  SurfacePoint met_by(const SubRay& ray) const;

 private:
  FirstHit hit_;
  Vec3 corner_{}, normal_{};
  std::uint32_t surface_ = RC_NONE, placement_ = RC_NONE;
};

/// One for each echo of a pixel's record. A sub-ray belongs to the nearest echo within the recorded pulse's width
/// (2.355 standard deviations) and a bin of it (geiger: within the pulse's span of an event that surfaces most likely
/// made: a strong return fires a cell long before its power has come); sub-rays into an array to the pixel that sees
/// their surface. A plate is the first surface of its sub-rays: what lies behind it is not explained (order 0 unless
/// other sub-rays met it directly). `result.hits` must be there; volumes: flatten_volumes of the scene's.
std::vector<ReturnTruth> return_truth(const scene::CompiledScene& scene, const FlatVolumes& volumes,
                                      const LidarPlan& plan, const ShotResult& result, int pixel, int line,
                                      const std::vector<Echo>& echoes);

/// Where a return appears: on the line of sight (the beam's axis; receiver sampling: the pixel's) so far from its start
/// that the path from the exit and to the pupil is twice its range.
Vec3 apparent_point(const LidarPlan& plan, const Shot& shot, int pixel, double range_m);

}  // namespace raycube::lidar
