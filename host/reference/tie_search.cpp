#include "host/reference/tie_search.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "host/base/interrupt.h"

namespace raycube::reference {

namespace {

constexpr std::size_t kLeaf = 8;            ///< points of a box that is not cut any more
constexpr std::size_t kSumsPerLook = 1024;  ///< between two looks for a signal

bool is_number(const Components& c) {
  return std::all_of(c.begin(), c.end(), [](double x) { return std::isfinite(x); });
}

}  // namespace

bool within(const Components& value, const Components& bound) {
  for (std::size_t m = 0; m < value.size(); ++m)
    if (!(std::abs(value[m]) <= bound[m])) return false;
  return true;
}

Components minus(Components from, const Components& what) {
  for (std::size_t m = 0; m < from.size(); ++m) from[m] -= what[m];
  return from;
}

BoxTree::BoxTree(std::vector<Components> points, const Components& bound) : points_(std::move(points)) {
  for (std::size_t i = 0; i < points_.size(); ++i)
    if (is_number(points_[i])) order_.push_back(i);  // the others are within nothing
  if (!order_.empty()) add(0, order_.size(), bound);
}

std::size_t BoxTree::add(std::size_t begin, std::size_t end, const Components& bound) {
  const std::size_t index = nodes_.size();
  Node node{points_[order_[begin]], points_[order_[begin]], kNone, 0, begin, end, kNone, kNone};
  for (std::size_t i = begin; i < end; ++i) {
    const Components& p = points_[order_[i]];
    for (std::size_t m = 0; m < p.size(); ++m)
      node.lo[m] = std::min(node.lo[m], p[m]), node.hi[m] = std::max(node.hi[m], p[m]);
    node.first = std::min(node.first, order_[i]), node.last = std::max(node.last, order_[i]);
  }
  nodes_.push_back(node);
  if (end - begin <= kLeaf) return index;
  std::size_t widest = 0;
  double width = -1;
  for (std::size_t m = 0; m < bound.size(); ++m)
    if (const double here = node.hi[m] - node.lo[m]; here > 0 && here / bound[m] > width)
      widest = m, width = here / bound[m];
  const std::size_t middle = begin + (end - begin) / 2;
  const auto at = [&](std::size_t i) { return order_.begin() + static_cast<std::ptrdiff_t>(i); };
  std::nth_element(at(begin), at(middle), at(end), [&](std::size_t x, std::size_t y) {
    return std::pair(points_[x][widest], x) < std::pair(points_[y][widest], y);
  });
  const std::size_t left = add(begin, middle, bound), right = add(middle, end, bound);
  nodes_[index].left = left, nodes_[index].right = right;
  return index;
}

std::size_t BoxTree::first_within(const Components& wanted, const Components& bound, std::size_t from,
                                  std::uint64_t& looks) const {
  std::size_t best = kNone;
  // Differences round alike for a point and for the side of its box beyond it: no point is lost.
  const auto may_hold = [&](const Node& node) {
    for (std::size_t m = 0; m < bound.size(); ++m)
      if (!(wanted[m] - node.hi[m] <= bound[m] && wanted[m] - node.lo[m] >= -bound[m])) return false;
    return true;
  };
  std::array<std::size_t, 128> open;  // a tree cut in halves is less deep than a half of that
  std::size_t count = 0;
  if (!nodes_.empty()) open[count++] = 0;
  while (count > 0) {
    const Node& node = nodes_[open[--count]];
    ++looks;
    if (node.last < from || node.first >= best || !may_hold(node)) continue;
    if (node.left != kNone) {
      open[count++] = node.right, open[count++] = node.left;
      continue;
    }
    for (std::size_t i = node.begin; i < node.end; ++i, ++looks)
      if (const std::size_t place = order_[i];
          place >= from && place < best && within(minus(wanted, points_[place]), bound))
        best = place;
  }
  return best;
}

FoundTies few_that_sum_to(std::span<const std::size_t> ties, const std::vector<Components>& effect,
                          const Components& residual, const Components& bound) {
  FoundTies found;
  std::vector<Components> effects;
  for (const std::size_t k : ties) effects.push_back(effect[k]);
  const BoxTree tree(std::move(effects), bound);
  for (std::size_t i = 0; i < ties.size(); ++i) {
    base::throw_if_interrupted();
    const Components one = minus(residual, effect[ties[i]]);
    if (within(one, bound)) {
      found.rays = {ties[i]};
      return found;
    }
    for (std::size_t j = i + 1; j < ties.size(); ++j) {
      const Components two = minus(one, effect[ties[j]]);
      if (within(two, bound)) {
        found.rays = {ties[i], ties[j]};
        return found;
      }
      const std::size_t k = tree.first_within(two, bound, j + 1, found.looks);
      if (k == BoxTree::kNone) continue;
      found.rays = {ties[i], ties[j], ties[k]};
      return found;
    }
  }
  return found;
}

FoundTies subset_that_sums_to(std::span<const std::size_t> ties, const std::vector<Components>& effect,
                              const Components& wanted, const Components& bound) {
  FoundTies found;
  const std::size_t half = ties.size() / 2;
  using Sum = std::pair<Components, std::uint64_t>;
  const auto sums = [&](std::size_t from, std::size_t to) {
    std::vector<Sum> all{{Components{}, 0u}};
    for (std::size_t i = from; i < to; ++i)
      for (std::size_t known = all.size(), s = 0; s < known; ++s) {
        auto [sum, members] = all[s];
        for (std::size_t m = 0; m < sum.size(); ++m) sum[m] += effect[ties[i]][m];
        all.emplace_back(sum, members | std::uint64_t{1} << i);
      }
    return all;
  };
  const auto left = sums(0, half);
  auto right = sums(half, ties.size());
  std::sort(right.begin(), right.end(), [](const Sum& x, const Sum& y) { return x.first[0] < y.first[0]; });
  std::vector<Components> places;
  for (const Sum& one : right) places.push_back(one.first);
  const BoxTree tree(std::move(places), bound);
  for (std::size_t s = 0; s < left.size(); ++s) {
    if (s % kSumsPerLook == 0) base::throw_if_interrupted();
    const std::size_t at = tree.first_within(minus(wanted, left[s].first), bound, 0, found.looks);
    if (at == BoxTree::kNone) continue;
    for (std::size_t i = 0; i < ties.size(); ++i)
      if ((left[s].second | right[at].second) >> i & 1u) found.rays.push_back(ties[i]);
    return found;
  }
  return found;
}

}  // namespace raycube::reference
