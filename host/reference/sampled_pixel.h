// One pixel traced by the reference: its samples' rays, hits, surface points and visibilities.
#pragma once

#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "host/plan/plan.h"
#include "host/reference/double_trace.h"
#include "host/reference/embree_scene.h"
#include "scene_compiler/simulation.h"

namespace raycube::reference {

/// Which pixel, and the group whose rays it shares.
struct PixelAddress {
  std::uint32_t line = 0, sample = 0;
  shared::RayGroup group{};
  int lane = 0;  ///< place of the pixel in its group
  int group_width = RC_GROUP_WIDTH;
};

/// Appends pixels `first` .. `first + count - 1` of a line; `groups`: all of the line, of `width` pixels each.
void append_addresses(std::vector<PixelAddress>& to, int line, int first, int count, const shared::RayGroup* groups,
                      int width);

/// The fp32 ray of one sample of a pixel, bit for bit the device's.
Ray pixel_ray(const scene::Instrument& instrument, std::uint64_t seed, const PixelAddress& address, int sample);

struct Sample {
  Ray ray;
  double weight = 0;  ///< of the point spread; a pixel's weights sum to 1
  Hit hit;
  glm::dvec3 point{0};   ///< m, scene frame
  glm::dvec3 normal{0};  ///< unit, turned to the viewer
  rc_id side =
      0;  ///< of the surface (product_key.h): 0 seen; 1 the far one, its normal turned away; 2 gloss; further lobes
  rc_id rays = 0;      ///< side whose rays and draws it shares: of further lobes that of their shape, else its own
  double cos_sun = 0;  ///< n . s
  bool sun_visible = false;  ///< meaningful where cos_sun > 0
};

struct SampledPixel {
  std::uint32_t number = 0;  ///< line * pixels + sample: the key of its random numbers
  glm::dvec3 sensor{0};      ///< m, scene frame: for the centre ray
  glm::dvec3 to_sensor{0};   ///< unit vector target -> sensor of the pixel's centre ray
  std::vector<Sample> samples;
  /// Of the samples, in their order: where matter lets light through the far sides, where some is glossy the near ones
  /// as their gloss has it; else empty. A side without either has hit nothing. Then likewise each further lobe.
  std::vector<Sample> far_sides, glosses, further;

  /// Sides of the samples' surfaces: the near ones, the far ones, the glosses, further lobes. Side i is of sample
  /// i % samples.size().
  std::size_t sides() const { return samples.size() + far_sides.size() + glosses.size() + further.size(); }
  const Sample& side(std::size_t i) const {
    if (i < samples.size()) return samples[i];
    i -= samples.size();
    if (i < far_sides.size()) return far_sides[i];
    i -= far_sides.size();
    return i < glosses.size() ? glosses[i] : further[i - glosses.size()];
  }
  Sample& side(std::size_t i) { return const_cast<Sample&>(std::as_const(*this).side(i)); }
};

/// Weight of each sample in the order of rc_sample_uv: the detector's box convolved with the optics' Gaussian
/// (psf_sigma_px), integrated over the sample's cell, normalised. The lattice has no cells: 1/N.
std::vector<double> sample_weights(const scene::Instrument& instrument);

/// How far a spawned ray starts off its surface, in ulp of the point's size: its distance from the scene's origin plus
/// that of its instance, plus the distance to its triangle's farthest corner. More than the 16 ulp (contact.h) by which
/// Embree may misplace the ray's origin in the instance's frame.
inline constexpr double kOffsetUlp = 24;
/// How far the origin of another correct fp32 computation of the same spawned ray may lie from the reference's. An
/// error-bounded offset is up to 6 ulp of each of two transforms of either size, times 3 where it is summed over the
/// axes of an oblique normal: 36, rounded up, and the reference's own.
inline constexpr double kOriginSlackUlp = 64;
/// In an instance's frame the primary ray itself is rounded, and its hit slides along the surface: ulp of the ray's
/// origin and range.
inline constexpr double kSlideUlp = 16;

/// The scene in the three forms the reference needs; all const members may be used from several threads.
class ReferenceScene {
 public:
  /// Keeps a reference to the scene.
  explicit ReferenceScene(const scene::CompiledScene& scene) : compiled(scene), embree(scene), tracer(scene) {}

  const scene::CompiledScene& compiled;
  const EmbreeScene embree;
  const DoubleTracer tracer;

  /// Rays of every sample, first hits by Embree, sun by Embree. Throws Error(input) when the pixel looks up.
  SampledPixel sample_pixel(const scene::Instrument& instrument, const plan::Plan& plan, std::uint64_t seed,
                            const PixelAddress& address) const;

  /// Point, normal and sun of a sample's sides for the hit it carries (set by Embree, or taken over from the device).
  void place(SampledPixel& pixel, std::size_t sample, const plan::Plan& plan) const;

  /// Nothing along the direction, by Embree, from an origin offset along the normal. t_far: nothing beyond counts, in
  /// units of the direction.
  bool sees(const Sample& sample, const glm::dvec3& direction,
            double t_far = std::numeric_limits<double>::infinity()) const;
  /// What it meets that way, by the same ray.
  Hit meets(const Sample& sample, const glm::dvec3& direction) const;
  /// The same question to the double traversal, allowing for another computation's origin.
  Visibility sees_in_double(const Sample& sample, const glm::dvec3& direction,
                            double t_far = std::numeric_limits<double>::infinity()) const;
  /// One ulp of the sizes that a spawned ray's origin is rounded relative to, m.
  double point_ulp_m(const Sample& sample) const;

 private:
  void place(Sample& sample, const plan::Plan& plan) const;
  double farthest_corner_m(const Sample& sample) const;
};

}  // namespace raycube::reference
