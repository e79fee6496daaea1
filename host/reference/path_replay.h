// The device's own paths between surfaces, walked again (docs/light.md): every ray that it sent is traced by Embree and
// judged in double, every direction and decision and the weights of first rays are found anew from the draws, and what
// the paths bring is summed in double at the wavelengths along them. Where the two answer a ray differently and both
// may be right, the device's answer is followed. Taken from the plan are the chances of sides and the largest
// reflectances that end paths, and what lies between the wavelengths; lamplight is not looked at.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "host/reference/path_light.h"
#include "host/reference/replay_report.h"
#include "kernels/sampling/sky_rays.h"
#include "kernels/shared/structs.h"

namespace raycube::reference {

class PathReplay {
 public:
  /// Keeps references. The plan's paths are logged (Bounces::logged).
  PathReplay(const ReferenceScene& scene, const plan::Plan& plan, const scene::Instrument& instrument,
             std::uint64_t seed);

  /// One pixel. hits: of its samples; steps, glow: its parts of PixelProbe's.
  ReplayReport replay(const PixelAddress& address, std::span<const Hit> hits, std::span<const shared::PathStep> steps,
                      std::span<const double> glow) const;

 private:
  struct Pixel;
  struct Path;
  struct Law {
    double near, most, gloss;  ///< as Bounces::scattering
  };
  float draw(const Pixel& pixel, const Path& path, int level, std::uint32_t what) const;
  Law law_of(const Hit& hit) const;
  /// Side by which a path goes on; the device's, RC_STEP_ENDS where it does not say.
  rc_id side_by_draw(Pixel& pixel, double u, const Law& law, rc_id device) const;
  /// Whether nothing hides a direction, as the device says, who may be wrong.
  bool open(Pixel& pixel, const Sample& from, const glm::dvec3& way, bool device) const;
  /// Direction that u and v draw from a side, turned as the device does, by floats.
  ::SkyRay own_way(const Sample& side, float u, float v) const;
  /// Sides over height of a triangle, about: how much more than 1 ulp its normal may be off.
  double slender(const Hit& hit) const;
  void compare_start(Pixel& pixel, const Sample& side, const shared::PathStep& step) const;
  /// How much more than by Lambert's law a way is worth that was drawn from a side by u and v.
  double leaving_weight(Pixel& pixel, const Sample& side, float u, float v, const shared::PathStep& step) const;
  void add_sun(Pixel& pixel, Path& path, const SampledPixel& at, bool lit) const;
  bool begin(Pixel& pixel, Path& path) const;
  bool go_on(Pixel& pixel, Path& path, const SampledPixel& at, int level) const;
  void follow(Pixel& pixel, Path& path) const;

  const ReferenceScene& scene_;
  const plan::Plan& plan_;
  const scene::Instrument& instrument_;
  std::uint32_t seed_;  ///< of rays and paths
  std::uint64_t sample_seed_;
  plan::Plan lines_;  ///< the plan at the wavelengths along its paths
  PathLight light_;
  std::vector<Spectrum> share_;  ///< [source], of the light together
  Spectrum emitted_share_;       ///< what a radiance that surfaces send is of it
};

}  // namespace raycube::reference
