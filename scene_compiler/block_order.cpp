#include "scene_compiler/block_order.h"

#include <algorithm>
#include <cstddef>
#include <limits>

#include "host/base/parallel.h"

namespace raycube::scene::detail {
namespace {

constexpr std::ptrdiff_t kBlock = RC_BLOCK;
constexpr std::ptrdiff_t kSwept = 64;       // triangles of a range in which every cut between blocks is looked at
constexpr std::ptrdiff_t kBinned = 2048;    // triangles that tell where a larger range is cut
constexpr int kBins = 32;                   // of larger ranges' centres, along each axis
constexpr std::size_t kSeveral = 1u << 13;  // triangles from which pieces of a mesh are ordered side by side
constexpr std::ptrdiff_t kPieces = 8;

struct Entry {
  Box box;
  std::uint32_t index;
};

/// Twice the centre.
float centre(const Box& box, int axis) { return box.lo[axis] + box.hi[axis]; }

/// Half of the surface's area, m2; 0 of an empty box.
double half_area(const Box& box) {
  const double x = box.hi[0] - box.lo[0], y = box.hi[1] - box.lo[1], z = box.hi[2] - box.lo[2];
  return x < 0 ? 0 : x * y + y * z + z * x;
}

/// What a range with this box is likely to cost a ray.
double cost_of(const Box& box, std::ptrdiff_t count) {
  return half_area(box) * static_cast<double>((count + kBlock - 1) / kBlock);
}

auto before_along(int axis) {
  return [axis](const Entry& a, const Entry& b) {
    const float at = centre(a.box, axis), other = centre(b.box, axis);
    return at != other ? at < other : a.index < b.index;
  };
}

struct Cut {
  int axis = 0;
  std::ptrdiff_t left = 0;  // triangles, a multiple of kBlock
  double cost = std::numeric_limits<double>::max();
};

/// The best cut between full blocks of a small range. Leaves it sorted along the last axis.
Cut swept_cut(Entry* first, std::ptrdiff_t count) {
  Cut best;
  std::array<double, kSwept> right{};  // costs
  for (int axis = 0; axis < 3; ++axis) {
    std::sort(first, first + count, before_along(axis));
    Box box;
    for (std::ptrdiff_t i = count - 1; i >= kBlock; --i) {
      box.grow(first[i].box);
      if (i % kBlock == 0) right[static_cast<std::size_t>(i)] = cost_of(box, count - i);
    }
    box = {};
    for (std::ptrdiff_t i = 0; i < count; ++i) {
      if (i > 0 && i % kBlock == 0) {
        const double cost = cost_of(box, i) + right[static_cast<std::size_t>(i)];
        if (cost < best.cost) best = {axis, i, cost};
      }
      box.grow(first[i].box);
    }
  }
  return best;
}

/// The best cut between bins of a large range by some of its triangles, moved to the next full block.
Cut binned_cut(const Entry* first, std::ptrdiff_t count) {
  const std::ptrdiff_t step = std::max<std::ptrdiff_t>(1, count / kBinned), told = (count + step - 1) / step;
  std::array<float, 3> lo, hi;
  lo.fill(std::numeric_limits<float>::max()), hi.fill(std::numeric_limits<float>::lowest());
  for (std::ptrdiff_t i = 0; i < count; i += step)
    for (int axis = 0; axis < 3; ++axis) {
      const float at = centre(first[i].box, axis);
      lo[axis] = std::min(lo[axis], at), hi[axis] = std::max(hi[axis], at);
    }
  struct Bin {
    Box box;
    std::ptrdiff_t count = 0;
  };
  std::array<std::array<Bin, kBins>, 3> bins;
  std::array<float, 3> scale{};
  for (int axis = 0; axis < 3; ++axis)
    scale[axis] = hi[axis] > lo[axis] ? static_cast<float>(kBins) / (hi[axis] - lo[axis]) : 0.0f;
  for (std::ptrdiff_t i = 0; i < count; i += step)
    for (int axis = 0; axis < 3; ++axis) {
      const auto at = static_cast<int>((centre(first[i].box, axis) - lo[axis]) * scale[axis]);
      Bin& bin = bins[axis][std::clamp(at, 0, kBins - 1)];
      bin.box.grow(first[i].box);
      ++bin.count;
    }
  Cut best{0, told / 2, std::numeric_limits<double>::max()};
  for (int axis = 0; axis < 3; ++axis) {
    std::array<double, kBins> right{};
    Box box;
    std::ptrdiff_t passed = 0;
    for (int i = kBins - 1; i > 0; --i) {
      box.grow(bins[axis][i].box);
      right[i] = cost_of(box, passed += bins[axis][i].count);
    }
    box = {}, passed = 0;
    for (int i = 1; i < kBins; ++i) {
      box.grow(bins[axis][i - 1].box);
      passed += bins[axis][i - 1].count;
      const double cost = cost_of(box, passed) + right[i];
      if (passed > 0 && passed < told && cost < best.cost) best = {axis, passed, cost};
    }
  }
  const std::ptrdiff_t most = (count - 1) / kBlock * kBlock;
  best.left = std::clamp((best.left * step + kBlock / 2) / kBlock * kBlock, kBlock, most);
  return best;
}

/// Cuts the range in two and returns how many lie left of the cut, in front.
std::ptrdiff_t cut(Entry* first, std::ptrdiff_t count) {
  const Cut best = count <= kSwept ? swept_cut(first, count) : binned_cut(first, count);
  std::nth_element(first, first + best.left, first + count, before_along(best.axis));
  return best.left;
}

void order(Entry* first, std::ptrdiff_t count) {
  while (count > kBlock) {
    const std::ptrdiff_t left = cut(first, count);
    order(first, left);
    first += left, count -= left;
  }
  std::sort(first, first + count, [](const Entry& a, const Entry& b) { return a.index < b.index; });
}

struct Piece {
  Entry* first;
  std::ptrdiff_t count;
};

/// Cuts until no piece is larger than `most`.
void cut_into(std::vector<Piece>& pieces, Entry* first, std::ptrdiff_t count, std::ptrdiff_t most) {
  if (count <= most) {
    pieces.push_back({first, count});
    return;
  }
  const std::ptrdiff_t left = cut(first, count);
  cut_into(pieces, first, left, most);
  cut_into(pieces, first + left, count - left, most);
}

}  // namespace

std::vector<std::uint32_t> block_order(std::uint32_t boxes, const std::function<Box(std::uint32_t)>& box_of) {
  std::vector<Entry> entries(boxes);
  for (std::uint32_t i = 0; i < boxes; ++i) entries[i] = {box_of(i), i};
  const std::ptrdiff_t count = boxes;
  std::vector<Piece> pieces;
  cut_into(pieces, entries.data(), count, boxes < kSeveral ? count : count / kPieces);
  base::for_each_index(pieces.size(), 0, [&](std::size_t i) { order(pieces[i].first, pieces[i].count); });
  std::vector<std::uint32_t> out(boxes);
  for (std::uint32_t i = 0; i < boxes; ++i) out[i] = entries[i].index;
  return out;
}

std::vector<std::uint32_t> block_order(const std::vector<Box>& boxes) {
  return block_order(static_cast<std::uint32_t>(boxes.size()), [&](std::uint32_t i) { return boxes[i]; });
}

}  // namespace raycube::scene::detail
