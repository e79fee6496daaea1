#include "scene_compiler/bvh_tree.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <new>
#include <numeric>
#include <string>

#include "host/base/error.h"

namespace raycube::scene::detail {
namespace {

using base::Error;
using base::Fault;

// What the callbacks build of a node: its children and their boxes. A leaf, of which there are more than nodes, is its
// item in place of an address.
struct BuildNode {
  std::uint32_t count = 0;
  std::array<void*, 8> child{};
  std::array<Box, 8> box;
};

void* leaf_of(std::uint32_t item) { return reinterpret_cast<void*>(std::uintptr_t{item} << 1 | 1); }
bool is_leaf(const void* child) { return (reinterpret_cast<std::uintptr_t>(child) & 1) != 0; }
std::uint32_t item_of(const void* leaf) {
  return static_cast<std::uint32_t>(reinterpret_cast<std::uintptr_t>(leaf) >> 1);
}

/// Embree returns null where there is no memory left, and passes what is thrown here on as its own error.
void* node_memory(RTCThreadLocalAllocator allocator) {
  void* const memory = rtcThreadLocalAlloc(allocator, sizeof(BuildNode), alignof(BuildNode));
  if (!memory) throw std::bad_alloc();
  return memory;
}

void* create_node(RTCThreadLocalAllocator allocator, unsigned, void*) { return new (node_memory(allocator)) BuildNode; }

void* create_leaf(RTCThreadLocalAllocator, const RTCBuildPrimitive* primitives, std::size_t, void*) {
  return leaf_of(primitives[0].primID);
}

void set_children(void* pointer, void** children, unsigned count, void*) {
  auto* node = static_cast<BuildNode*>(pointer);
  node->count = count;
  for (unsigned i = 0; i < count; ++i) node->child[i] = children[i];
}

void set_bounds(void* pointer, const RTCBounds** bounds, unsigned count, void*) {
  auto* node = static_cast<BuildNode*>(pointer);
  for (unsigned i = 0; i < count; ++i) {
    node->box[i].lo = {bounds[i]->lower_x, bounds[i]->lower_y, bounds[i]->lower_z};
    node->box[i].hi = {bounds[i]->upper_x, bounds[i]->upper_y, bounds[i]->upper_z};
  }
}

void set_slot(shared::BvhNode& node, std::uint32_t slot, const Box& box) {
  node.lo_x[slot] = box.lo[0], node.lo_y[slot] = box.lo[1], node.lo_z[slot] = box.lo[2];
  node.hi_x[slot] = box.hi[0], node.hi_y[slot] = box.hi[1], node.hi_z[slot] = box.hi[2];
}

// Largest coordinate, of any sign, of a node's boxes.
float reach_of(const BuildNode& node) {
  float reach = 0;
  for (std::uint32_t i = 0; i < node.count; ++i)
    for (int k = 0; k < 3; ++k) reach = std::max({reach, std::abs(node.box[i].lo[k]), std::abs(node.box[i].hi[k])});
  return reach;
}

// Children as rays that go up try them (kernels/geometry/any_hit.h): leaves from the lowest slot on, inner nodes from
// the highest, so that of either the topmost comes first.
std::array<std::uint32_t, 8> order_of(const BuildNode& node) {
  std::array<std::uint32_t, 8> order{};
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.begin() + node.count, [&](std::uint32_t a, std::uint32_t b) {
    const bool leaf = is_leaf(node.child[a]);
    if (leaf != is_leaf(node.child[b])) return leaf;
    const float top_a = node.box[a].hi[2], top_b = node.box[b].hi[2];
    return leaf ? top_a > top_b : top_a < top_b;
  });
  return order;
}

// Depth first; the deeper half of a child list lies right behind its parent, which is what a traversal visits next.
std::uint32_t flatten(const BuildNode& from, BoxTree& tree, std::uint32_t level) {
  tree.depth = std::max(tree.depth, level);
  const auto index = static_cast<std::uint32_t>(tree.nodes.size());
  tree.nodes.emplace_back();
  tree.nodes[index] = {};
  tree.nodes[index].count = from.count;
  tree.nodes[index].reach = reach_of(from);
  const std::array<std::uint32_t, 8> order = order_of(from);
  for (std::uint32_t i = 0; i < from.count; ++i) {
    const void* const child = from.child[order[i]];
    set_slot(tree.nodes[index], i, from.box[order[i]]);
    if (is_leaf(child)) {
      tree.nodes[index].child[i] = item_of(child);
      tree.nodes[index].leaf_mask |= 1u << i;
    } else {
      const std::uint32_t at = flatten(*static_cast<const BuildNode*>(child), tree, level + 1);
      tree.nodes[index].child[i] = at;
    }
  }
  return index;
}

struct DeviceRelease {
  void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
};
struct BvhRelease {
  void operator()(RTCBVH bvh) const { rtcReleaseBVH(bvh); }
};

}  // namespace

void Box::grow(const std::array<float, 3>& point) {
  for (int k = 0; k < 3; ++k) lo[k] = std::min(lo[k], point[k]), hi[k] = std::max(hi[k], point[k]);
}

void Box::grow(const Box& other) {
  grow(other.lo);
  grow(other.hi);
}

BoxTree build_tree(const std::vector<Box>& boxes) {
  BoxTree tree;
  if (boxes.size() == 1) {  // rtcBuildBVH would return a bare leaf
    tree.nodes.emplace_back();
    tree.nodes[0] = {};
    tree.nodes[0].count = 1;
    tree.nodes[0].leaf_mask = 1;
    set_slot(tree.nodes[0], 0, boxes[0]);
    for (int k = 0; k < 3; ++k)
      tree.nodes[0].reach = std::max({tree.nodes[0].reach, std::abs(boxes[0].lo[k]), std::abs(boxes[0].hi[k])});
    tree.depth = 1;
    return tree;
  }
  // One thread: the order in which threads partition equal keys would otherwise reach the tree.
  std::unique_ptr<RTCDeviceTy, DeviceRelease> device(rtcNewDevice("threads=1"));
  if (!device) throw Error(Fault::environment, "Embree: no device for the BVH builder (rtcNewDevice failed)");
  std::unique_ptr<RTCBVHTy, BvhRelease> bvh(rtcNewBVH(device.get()));
  std::vector<RTCBuildPrimitive> primitives(boxes.size());
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const Box& box = boxes[i];
    primitives[i] = {box.lo[0], box.lo[1], box.lo[2], 0, box.hi[0], box.hi[1], box.hi[2], static_cast<unsigned>(i)};
  }
  RTCBuildArguments arguments = rtcDefaultBuildArguments();
  arguments.buildQuality = RTC_BUILD_QUALITY_MEDIUM;
  arguments.maxBranchingFactor = 8;
  arguments.maxDepth = 64;
  arguments.minLeafSize = 1;
  arguments.maxLeafSize = 1;
  arguments.bvh = bvh.get();
  arguments.primitives = primitives.data();
  arguments.primitiveCount = primitives.size();
  arguments.primitiveArrayCapacity = primitives.size();
  arguments.createNode = create_node;
  arguments.createLeaf = create_leaf;
  arguments.setNodeChildren = set_children;
  arguments.setNodeBounds = set_bounds;
  const void* const built = rtcBuildBVH(&arguments);
  const auto* root = is_leaf(built) ? nullptr : static_cast<const BuildNode*>(built);
  const RTCError failed = !root || root->count == 0 ? rtcGetDeviceError(device.get()) : RTC_ERROR_NONE;
  if (failed == RTC_ERROR_OUT_OF_MEMORY) throw std::bad_alloc();
  if (!root || root->count == 0)
    throw Error(Fault::bug, "rtcBuildBVH made no tree over " + std::to_string(boxes.size()) + " boxes (Embree error " +
                                std::to_string(static_cast<int>(failed)) + ")");
  flatten(*root, tree, 1);
  return tree;
}

}  // namespace raycube::scene::detail
