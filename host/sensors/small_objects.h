// Which pixels hold objects that their samples may miss, and how many samples those pixels need (S43).
//
// An rms over pixels, which `tolerance` is, is blind to the few pixels that hold a target. Such objects are
// known from their boxes (scene_objects.h) and projected here before a ray is sent. An object is small for an
// instrument when its projection is at most kWidest_px pixels wide and long. Where pixels are rendered as c cells
// (cells.h), sizes, shares and sums are those of a pixel about each cell, and each cell gets n / c. With n samples in a
// pixel's area and an object that covers the share a of that area, n a samples lie on it; of k points of a lattice or
// of jittered cells on a compact shape the count errs by about k^1/4 (its outline crosses some k^1/2 cells), so k =
// kPoints knows the area to 40^-3/4 = 6 % rms, and kFewestPoints to 19 %. A pixel needs
//
//     n = kPoints (1 - A) / A,    A = max(largest a, sum of a f) over objects of one kind, f: the part of an
//     object's rectangle in the pixel
//
// for the kind that needs most. Sums make what covers a pixel densely (a crown, gravel) ask for no more than
// its cover does: at A = 0.3 93 samples do, at 0.5 the 40 that a random point would need. A point spread
// spreads the samples over its square, so that n grows by its area. Shares are exact areas of projected
// triangles (half of them for closed surfaces), of objects with many triangles those of the projected box
// times pi / 4; what hides an object is not asked.
//
// Counts come in the levels of kFineLevels; the group that a pixel shares its rays with gets the most of its
// pixels. It depends on the group alone, so no bit depends on tiles.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "host/sensors/scene_objects.h"
#include "kernels/shared/structs.h"
#include "scene_compiler/simulation.h"

namespace raycube::sensors {

inline constexpr double kWidest_px = 2;
inline constexpr double kPoints = 40, kFewestPoints = 9;
/// Samples of a pixel, squares of even sides; the last is for point spreads alone, whose samples spread over
/// more than a pixel.
inline constexpr int kFineLevels[] = {256, 1024, 4096, 16384, 65536};

/// The most that the instrument's pixels may get.
int finest_level(const scene::Instrument& instrument);

/// The instrument with so many samples (of kFineLevels) in every pixel: a lattice, or jittered under a point
/// spread.
scene::Instrument with_fine_samples(const scene::Instrument& instrument, int samples);

/// One object that one pixel of a group may see.
struct ObjectInPixel {
  std::uint32_t object = 0;  ///< index into SmallObjectPixels::objects()
  int lane = 0;              ///< pixel of the group
  double share = 0;          ///< area of the whole object over the pixel's
  double part = 0;           ///< of the object's rectangle, in the pixel
  bool touches = true;       ///< its cell, of a pixel that is rendered as cells: of the pixel about it
};

class SmallObjectPixels {
 public:
  /// Keeps a reference to the scene. The instrument's samples are the ordinary ones.
  SmallObjectPixels(const scene::CompiledScene& scene, const scene::Instrument& instrument);
  /// The same of the scene whose objects these are.
  SmallObjectPixels(KnownObjects& known, const scene::Instrument& instrument);
  ~SmallObjectPixels();
  SmallObjectPixels(SmallObjectPixels&&) noexcept;

  /// From now on the ordinary samples are those of this instrument, which is the same but for them.
  void set_samples(const scene::Instrument& instrument);
  /// No object of the scene can be small for the instrument.
  bool empty() const;
  const SceneObjects& objects() const;
  std::string name(std::uint32_t object) const;  ///< of an object, as object_name has it

  /// The small objects of the first `used` pixels of a group (sensors::make_ray_groups), in the order of
  /// their numbers.
  std::vector<ObjectInPixel> in_group(const shared::RayGroup& group, int used) const;

  using LookAtGroup = std::function<void(int line, int group, const shared::RayGroup& rays)>;
  /// Every group of the image that in_group may find something in, once, in image order; the others are not
  /// made (group_finder.h). Throws Error(interrupted) after a signal.
  void visit_groups(const LookAtGroup& look) const;

  /// Samples that the pixels of a group need, of kFineLevels; 0: the ordinary ones do.
  int samples_of(const shared::RayGroup& group, int used) const;
  int samples_of(std::span<const ObjectInPixel> seen) const;
  /// Whether adaptive samples must not leave it at the first look there.
  bool needs_all(const shared::RayGroup& group, int used) const;
  bool needs_all(std::span<const ObjectInPixel> seen) const;
  /// A of each, in the pixel that sees it.
  std::vector<double> covers(std::span<const ObjectInPixel> seen) const;

 private:
  /// Samples a pixel, before levels: the most that any of the objects asks for.
  double needed(std::span<const ObjectInPixel> seen) const;

  struct State;
  std::unique_ptr<State> state_;
};

/// What is known of an instrument's small objects before it renders.
struct SmallObjectSurvey {
  struct Object {
    std::string name;
    std::array<double, 3> size_m{};  ///< of its box
    double share = 0;                ///< largest, of a pixel's area
    double points = 0;               ///< samples on it, in the pixel that has fewest
    std::uint64_t pixels = 0;        ///< that it projects onto
    int line = 0, sample = 0;        ///< the first of them
  };
  struct Group {
    int line = 0, sample = 0, samples = 0;  ///< its first pixel, and the samples that its pixels get
  };
  bool on = false;                      ///< the instrument's small objects get the samples they need
  std::uint64_t looked_at = 0;          ///< groups of rays: those that objects' boxes may project into
  std::size_t objects = 0;              ///< small ones that the image holds
  std::size_t scarce = 0;               ///< of them: need more than the ordinary samples
  std::uint64_t pixels = 0;             ///< rendered with more samples; on: whole groups
  double more_samples = 0;              ///< in all of those
  std::map<int, std::uint64_t> levels;  ///< pixels by samples
  std::vector<Object>
      missed;  ///< those with fewer than kFewestPoints samples on them as the image is rendered, fewest first
  std::vector<Group> groups;          ///< in image order
  std::vector<std::string> textures;  ///< kinds of more than kMostOfAKind objects
};

/// Looks at the groups that small objects project into, not at the image. on: as the instrument is rendered.
SmallObjectSurvey survey_small_objects(const scene::CompiledScene& scene, const scene::Instrument& instrument, bool on);
/// The same where the objects are known; `small` takes the instrument's samples.
SmallObjectSurvey survey_small_objects(SmallObjectPixels small, const scene::Instrument& instrument, bool on);

}  // namespace raycube::sensors
