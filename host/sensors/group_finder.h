// Which groups of rays a few small boxes may project into, without walking the image.
//
// A ray of a line is o + b ov + T (D + i du + b dv): i pixels from the line's middle, b across lines, T the
// distance. The rows A, U, V of the inverse of (D, du, dv) give T = A.w, T i = U.w, T b = V.w of a point at
// w = p - o, so "left of", "right of", "before", "behind" a line and "behind the sensor" are signs of five
// linear functions of p. Over many lines (whisk-broom: pixels) their coefficients and o lie in boxes, and
// interval arithmetic tells a whole span of lines that a box surely lies outside. That holds whatever the
// poses do between two lines, since each line's own coefficients are in its span's boxes. Nothing is missed:
// the answer holds every group that sees a box. It asks for no ground, so views along it cost no more.
//
// Where a pose moves, dv differs from group to group and may be 0: the third row is then that of the normal
// of the fan of rays, and what b does to i, T and o is added as a bound. Lines where that is no small thing,
// or whose rays have no inverse, are handed out whole.
//
// Cost: a camera's spans are bounded by their ends (all is linear in the line); of a scanner each pose is
// looked at once. Then it grows with the boxes' own groups.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "host/sensors/scene_objects.h"
#include "kernels/shared/structs.h"
#include "scene_compiler/simulation.h"

namespace raycube::sensors {

class GroupFinder {
 public:
  /// `settled`: with automatic motion settled; a reference is kept. A box belongs to a pixel when it projects
  /// to less than `reach_px` from its centre, and spans at most `widest_px` pixels across lines.
  GroupFinder(const scene::Instrument& settled, double reach_px, double widest_px);

  using Look = std::function<void(int line, int group)>;
  /// Calls look for every group that an object's box may project into, once, in image order. Throws
  /// Error(interrupted) after a signal.
  void visit(std::span<const SceneObject> objects, const Look& look) const;

 private:
  struct Box {
    glm::dvec3 lo{0}, hi{0};
  };
  /// Bounds over the rays of some leaves.
  struct Rays {
    Box origin_m, a, u, v;
    double reach_b = 0;    ///< |V.w| <= reach_b A.w
    double beside_px = 0;  ///< what b adds to i at most
    double stretch = 0;    ///< and to T, of T
    bool wild = false;     ///< nothing is known
  };
  struct Test;

  /// A leaf: a line, or of a whisk-broom a pixel.
  Rays leaf(std::size_t index) const;
  Rays turned(std::size_t first, std::size_t end) const;
  Rays run(std::size_t first, std::size_t end) const;
  Rays bounds(std::size_t level, std::size_t index) const;
  void build();
  void descend(std::size_t level, std::size_t index, std::span<const SceneObject> objects,
               const std::vector<std::uint32_t>& from_above, const Look& look) const;
  void look_at(std::size_t leaf, std::span<const SceneObject> objects, const std::vector<std::uint32_t>& of_run,
               const Look& look) const;
  static Rays both(const Rays& x, const Rays& y);
  static Test test(const Rays& rays, double first_px, double last_px);
  static Box away(const Box& box, const Box& origin_m);
  static double upper(const Box& n, const Box& w);
  static Box sum(const Box& x, const Box& y, double times);

  const scene::Instrument& instrument_;
  double reach_px_, reach_moving_px_;
  bool moving_, scanner_;
  int width_, per_line_, per_leaf_;  ///< pixels of a group; groups of a line, of a leaf
  std::size_t leaves_, top_level_;
  std::vector<std::vector<Rays>> levels_;  ///< of scanners: [0] runs of kRun leaves, then pairs
};

}  // namespace raycube::sensors
