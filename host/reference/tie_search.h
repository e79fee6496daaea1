// Which of a sample's tied sky rays the device saw the other way: few whose effects add up to what its
// blocked irradiance is off by.
//
// Of the many subsets only those are built that could fit: the last ray of three, or the second half of a
// subset, is looked up in a tree of boxes over what it would have to bring. The answer is that of trying all
// of them in order. n ties take n^2 / 2 look-ups at most for three rays, and 2^19 for subsets of kMostTies; a
// look-up goes down few branches, since nothing lies within the bound but an answer.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace raycube::reference {

/// Irradiance of the sky's components, of up to two quads.
using Components = std::array<double, 8>;

/// 2^19 sums of each half: 40 MB. Of the 2^38 subsets fewer than 1e-3 fit four components by chance.
inline constexpr std::size_t kMostTies = 38;

/// Every component within its bound; what is no number is not.
bool within(const Components& value, const Components& bound);
Components minus(Components from, const Components& what);

/// Points of the space of components, each with its place in the list that was given.
class BoxTree {
 public:
  static constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

  /// `bound` of the look-ups to come: boxes are cut where they are widest in its units.
  BoxTree(std::vector<Components> points, const Components& bound);
  /// The least place, `from` or later, of a point with within(wanted - point, bound); kNone where there is
  /// none. Adds the boxes and points that it compared to `looks`.
  std::size_t first_within(const Components& wanted, const Components& bound, std::size_t from,
                           std::uint64_t& looks) const;

 private:
  struct Node {
    Components lo, hi;
    std::size_t first, last;  ///< least and largest place in it
    std::size_t begin, end;   ///< of order_
    std::size_t left, right;  ///< kNone: a leaf
  };
  std::size_t add(std::size_t begin, std::size_t end, const Components& bound);

  std::vector<Components> points_;
  std::vector<std::size_t> order_;
  std::vector<Node> nodes_;
};

struct FoundTies {
  std::vector<std::size_t> rays;  ///< of `ties`, ascending; empty: none fit
  std::uint64_t looks = 0;        ///< boxes and points of trees that were compared
};

/// Up to three of the ties (indices into effect) whose effects, taken from `residual` in turn, leave it
/// within the bound: of the combinations i, then i and j > i, then i, j and k > j, in the order of i, j and
/// k, the first. Throws Error(interrupted) after a signal.
FoundTies few_that_sum_to(std::span<const std::size_t> ties, const std::vector<Components>& effect,
                          const Components& residual, const Components& bound);

/// Of up to kMostTies ties a subset whose effects sum to `wanted` within `bound` in every component. Both
/// halves' sums are listed, and one list searched for what the other leaves (Horowitz & Sahni, J. ACM 21(2),
/// 1974). Throws Error(interrupted) after a signal.
FoundTies subset_that_sums_to(std::span<const std::size_t> ties, const std::vector<Components>& effect,
                              const Components& wanted, const Components& bound);

}  // namespace raycube::reference
