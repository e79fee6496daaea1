#include "scene_compiler/placed_together.h"

#include <algorithm>
#include <numeric>

namespace raycube::scene {

namespace {

/// Places of one mesh in the user's list, ascending.
using Places = std::vector<std::uint32_t>;

/// An order of lists of placements in which those that stand together are equal: by their number, then one after the
/// other by the matrix and the distance from the first. Negative, zero, positive: a before, with, behind b.
int compare(const std::vector<Placed>& placed, const Places& a, const Places& b) {
  if (a.size() != b.size()) return a.size() < b.size() ? -1 : 1;
  for (std::size_t k = 0; k < a.size(); ++k) {
    const std::uint32_t apart_a = a[k] - a[0], apart_b = b[k] - b[0];
    if (apart_a != apart_b) return apart_a < apart_b ? -1 : 1;
    const auto &of_a = placed[a[k]].scene_from_mesh, &of_b = placed[b[k]].scene_from_mesh;
    if (of_a != of_b) return of_a < of_b ? -1 : 1;
  }
  return 0;
}

}  // namespace

std::vector<std::vector<std::uint32_t>> placed_together(const std::vector<Placed>& placed, std::size_t mesh_count) {
  std::vector<Places> places(mesh_count);
  for (std::uint32_t i = 0; i < placed.size(); ++i) places[placed[i].mesh].push_back(i);
  std::vector<std::uint32_t> order(mesh_count);
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    const int sign = compare(placed, places[a], places[b]);
    if (sign != 0 || places[a].empty()) return sign != 0 ? sign < 0 : a < b;
    return places[a][0] < places[b][0];
  });
  std::vector<std::vector<std::uint32_t>> groups;
  for (const std::uint32_t mesh : order) {
    const bool joins =
        !groups.empty() && !places[mesh].empty() && compare(placed, places[groups.back()[0]], places[mesh]) == 0;
    if (joins)
      groups.back().push_back(mesh);
    else
      groups.push_back({mesh});
  }
  const auto lowest = [](const auto& group) { return *std::min_element(group.begin(), group.end()); };
  std::sort(groups.begin(), groups.end(), [&](const auto& a, const auto& b) { return lowest(a) < lowest(b); });
  return groups;
}

}  // namespace raycube::scene
