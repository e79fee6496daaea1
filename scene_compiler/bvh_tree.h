// An 8-wide tree over boxes from Embree's rtcBuildBVH, one item per leaf, flattened into BvhNode order. Private to the
// BVH builder.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "kernels/shared/structs.h"

namespace raycube::scene::detail {

struct Box {
  std::array<float, 3> lo{3.4e38f, 3.4e38f, 3.4e38f}, hi{-3.4e38f, -3.4e38f, -3.4e38f};  ///< empty until grown, m
  void grow(const std::array<float, 3>& point);
  void grow(const Box& other);
};

struct BoxTree {
  std::vector<shared::BvhNode> nodes;  ///< node 0 is the root; children by index into this array, leaves by item index
  std::uint32_t depth = 0;             ///< levels of nodes
};

/// Precondition: at least one box, all finite. The tree is the same on every run: it is built on one thread.
BoxTree build_tree(const std::vector<Box>& boxes);

}  // namespace raycube::scene::detail
