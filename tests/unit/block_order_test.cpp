// Which triangles share a block: every one once, blocks full, boxes no larger in all than by halves.
#include <doctest/doctest.h>

#include <algorithm>
#include <numeric>

#include "scene_compiler/block_order.h"
#include "scene_compiler/counter_random.h"

using namespace raycube;
using scene::detail::Box;

namespace {

/// Boxes of what a tree is made of: leaves of 5 to 10 cm all through a crown of 8 m, every eighth a piece of branch, up
/// to 3 m long.
std::vector<Box> leaves(std::size_t count) {
  std::vector<Box> out(count);
  for (std::size_t i = 0; i < count; ++i)
    for (int k = 0; k < 3; ++k) {
      const auto unit = [&](std::uint64_t stream) {
        return static_cast<float>(scene::counter_uniform(18, stream, i, static_cast<std::uint64_t>(k)));
      };
      const float at = 8 * unit(0), size = i % 8 == 0 && k == 2 ? 3 * unit(1) : 0.05f + 0.05f * unit(1);
      out[i].lo[k] = at, out[i].hi[k] = at + size;
    }
  return out;
}

/// Sum over blocks of half the surface of their boxes, m2.
double area_of(const std::vector<Box>& boxes, const std::vector<std::uint32_t>& order) {
  double sum = 0;
  for (std::size_t first = 0; first < order.size(); first += RC_BLOCK) {
    Box box;
    for (std::size_t i = first; i < std::min(order.size(), first + RC_BLOCK); ++i) box.grow(boxes[order[i]]);
    const double x = box.hi[0] - box.lo[0], y = box.hi[1] - box.lo[1], z = box.hi[2] - box.lo[2];
    sum += x * y + y * z + z * x;
  }
  return sum;
}

/// Halves along the longest axis of the centres, counted in full blocks.
void halve(const std::vector<Box>& boxes, std::uint32_t* first, std::ptrdiff_t count) {
  if (count <= RC_BLOCK) return;
  int axis = 0;
  float widest = -1;
  for (int k = 0; k < 3; ++k) {
    const auto [least, most] = std::minmax_element(
        first, first + count, [&](std::uint32_t a, std::uint32_t b) { return boxes[a].lo[k] < boxes[b].lo[k]; });
    const float wide = boxes[*most].lo[k] - boxes[*least].lo[k];
    if (wide > widest) widest = wide, axis = k;
  }
  std::sort(first, first + count,
            [&](std::uint32_t a, std::uint32_t b) { return boxes[a].lo[axis] < boxes[b].lo[axis]; });
  const std::ptrdiff_t half = ((count + 1) / 2 + RC_BLOCK - 1) / RC_BLOCK * RC_BLOCK;
  halve(boxes, first, half);
  halve(boxes, first + half, count - half);
}

}  // namespace

TEST_CASE("blocks hold every triangle once, for any number, also where all lie in one place") {
  for (const std::size_t count : {1u, 15u, 16u, 17u, 64u, 65u, 200u, 5000u, 20000u}) {
    auto boxes = leaves(count);
    for (const bool heap : {false, true}) {
      if (heap) std::fill(boxes.begin(), boxes.end(), boxes[0]);
      auto order = scene::detail::block_order(boxes);
      CHECK(order == scene::detail::block_order(boxes));
      std::sort(order.begin(), order.end());
      std::vector<std::uint32_t> all(count);
      std::iota(all.begin(), all.end(), 0u);
      CHECK(order == all);
    }
  }
}

TEST_CASE("blocks of leaves and branches have less surface than halves along the longest axis give") {
  const auto boxes = leaves(30000);
  std::vector<std::uint32_t> halves(boxes.size());
  std::iota(halves.begin(), halves.end(), 0u);
  halve(boxes, halves.data(), static_cast<std::ptrdiff_t>(halves.size()));
  const double ours = area_of(boxes, scene::detail::block_order(boxes)), theirs = area_of(boxes, halves);
  MESSAGE("surface of blocks over that by halves: " << ours / theirs);
  CHECK(ours < 0.9 * theirs);
}

TEST_CASE("a long row of tiles is cut across: blocks are sixteen neighbours") {
  std::vector<Box> boxes(4096);
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const auto place = static_cast<float>((i * 1229) % boxes.size());  // the file's order is not the row's
    boxes[i].lo = {place, 0, 0}, boxes[i].hi = {place + 1, 1, 0};
  }
  CHECK(area_of(boxes, scene::detail::block_order(boxes)) == doctest::Approx(4096.0));
}
