// How an error falls with a setting: measured at some levels, a power law between and beyond them, on the careful side.
#pragma once

#include <map>

namespace raycube::planner {

/// Exponents p of error ~ level^-p that are assumed where nothing was measured.
struct LawExponents {
  double beyond = 1;       ///< past the largest level measured: the slowest fall to be expected
  double before = 2;       ///< short of the smallest: the fastest rise
  double hope = 1.5;       ///< what it may be at best: levels that might do are tried, not trusted
  double hope_before = 1;  ///< the same short of a level that was measured: the slowest rise
  double hope_below = 1;   ///< the same from the smallest that was measured to what is short of it
};

/// Samples along one side of a pixel: sampling an edge falls like side^-1.5 on average, like side^-1 where edges run
/// along the grid. Where all that differs lies within a hair of the pixels' edges, few samples do as well as many.
inline constexpr LawExponents kSideLaw{1.25, 2, 1.75, 1, 0};
/// Directions of a set: between K^-0.5 (independent) and K^-1 (lattices over a smooth horizon).
inline constexpr LawExponents kDirectionLaw{0.6, 1, 1};
/// Sub-rays of a footprint: nested rings of equal energy over an edge.
inline constexpr LawExponents kSubrayLaw{0.5, 1, 1, 0.5, 0.5};

class ErrorLaw {
 public:
  explicit ErrorLaw(LawExponents exponents) : exponents_(exponents) {}

  /// `estimate` of the error at a level (>= 1), and `bound`: what is taken for it where a choice depends on it (>=
  /// estimate). A bound that noise has lifted above what the law makes of the next smaller level's comes down to that,
  /// never below the estimate.
  void measured(double level, double estimate, double bound);
  bool has(double level) const { return points_.count(level) > 0; }
  bool empty() const { return points_.empty(); }
  double largest() const { return points_.empty() ? 0 : points_.rbegin()->first; }
  double smallest() const { return points_.empty() ? 0 : points_.begin()->first; }

  double estimate(double level) const { return at(level, &Point::estimate); }
  double bound(double level) const { return at(level, &Point::bound); }
  /// The least that may be hoped of a level that was not measured, from every one that was; the bound of one that was.
  double hope(double level) const;

 private:
  struct Point {
    double estimate, bound;
  };
  double at(double level, double Point::*what) const;

  LawExponents exponents_;
  std::map<double, Point> points_;
};

}  // namespace raycube::planner
