// How an error falls with a setting, band by band: measured at some levels, a power law between and beyond them, on the
// careful side.
#pragma once

#include <map>

#include "host/planner/band_errors.h"

namespace raycube::planner {

/// Exponents p of error ~ level^-p that are assumed where nothing was measured.
struct LawExponents {
  double beyond = 1;       ///< past the largest level measured: the slowest fall to be expected
  double before = 2;       ///< short of the smallest: the fastest rise
  double hope = 1.5;       ///< what it may be at best: levels that might do are tried, not trusted
  double hope_before = 1;  ///< the same short of a level that was measured: the slowest rise
  double hope_below = 1;   ///< the same from the smallest that was measured to what is short of it
};

/// Samples of a pixel on a lattice: sampling an edge falls like samples^-0.75 on average, like samples^-0.5 at worst.
/// Where all that differs lies within a hair of the pixels' edges, few samples do nearly as well as many.
inline constexpr LawExponents kSamplesLaw{0.625, 1, 0.75, 0.5, 0.25};
/// Rays into the sky, K a pixel: between K^-0.5 (independent) and K^-1 (spread evenly over a smooth horizon).
inline constexpr LawExponents kDirectionLaw{0.6, 1, 0.75, 0.5, 0.5};
/// Sub-rays of a footprint: nested rings of equal energy over an edge.
inline constexpr LawExponents kSubrayLaw{0.5, 1, 1, 0.5, 0.5};

class ErrorLaw {
 public:
  explicit ErrorLaw(LawExponents exponents) : exponents_(exponents) {}

  /// Errors found at a level (>= 1), of as many bands at every level; the bound is what is taken where a choice depends
  /// on it. One that noise has lifted above what the law makes of the next smaller level's comes down to that, never
  /// below the estimate; where few rare things are missed by chance, a smaller level seems better than a larger one:
  /// its bound comes up to what the slowest rise makes of the larger level's.
  void measured(double level, BandErrors errors);
  /// The same of one band.
  void measured(double level, double estimate, double bound) { measured(level, BandErrors{{estimate}, {bound}}); }
  bool has(double level) const { return points_.count(level) > 0; }
  bool empty() const { return points_.empty(); }
  /// Whether a level lies between two that were measured, or is one.
  bool spans(double level) const { return !empty() && level >= smallest() && level <= largest(); }
  double largest() const { return points_.empty() ? 0 : points_.rbegin()->first; }
  double smallest() const { return points_.empty() ? 0 : points_.begin()->first; }

  /// Of every band; infinite of one where nothing was measured.
  BandErrors errors(double level) const;
  /// The least that may be hoped of a level that was not measured, from every one that was, known as well as those; the
  /// errors of one that was.
  BandErrors hoped(double level) const;

  /// Of the worst band.
  double estimate(double level) const { return errors(level).worst_estimate(); }
  double bound(double level) const { return errors(level).worst_bound(); }
  double hope(double level) const { return hoped(level).worst_bound(); }

 private:
  LawExponents exponents_;
  std::map<double, BandErrors> points_;
};

}  // namespace raycube::planner
