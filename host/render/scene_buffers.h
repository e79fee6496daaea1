// A compiled scene on the device. An array past half of the device's largest buffer comes in up to 8 pages, which
// kernels address through kernels/geometry/scene_arrays.h; indices do not change.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/cl/arguments.h"
#include "host/cl/buffer.h"
#include "scene_compiler/compiled_scene.h"

namespace raycube::render {

/// How an array is cut: element i lies in page i >> shift. With one page the shift is not used.
struct Paging {
  std::uint32_t pages = 1, shift = 0;
};

constexpr std::uint32_t kMostPages = RC_MOST_PAGES;
/// A triangle's number, block * 16 + lane, has 32 bits; the stack of a traversal keeps bit 31 of an index for itself.
constexpr std::uint64_t kMostElements = std::uint64_t{1} << 28;

/// Elements that 8 pages hold when each is a power of two of them in a buffer of at most largest_bytes (page_bytes,
/// when > 0).
std::uint64_t most_elements(std::size_t element_bytes, std::uint64_t largest_bytes, std::uint64_t page_bytes = 0);

/// The cut of `count` elements on a device whose buffers take `largest_bytes`: one page when they fit half of that,
/// else pages of the largest power of two of elements that fits half; where 8 of those are too few, the next power, if
/// a whole buffer takes it. page_bytes > 0 (tests) stands for that half and allows no next power. Nothing past
/// most_elements().
std::optional<Paging> cut_into_pages(std::uint64_t count, std::size_t element_bytes, std::uint64_t largest_bytes,
                                     std::uint64_t page_bytes = 0);

/// One error that names need, limits and ways out when 8 pages do not hold an array of the scene, or the device's
/// memory not all of them.
void check_fits(const scene::CompiledScene& scene, const cl::DeviceInfo& device, std::uint64_t page_bytes = 0);

/// RC_STACK of kernels that cast rays, for CompiledScene::stack_bound(): up to a multiple of 128, so that scenes of any
/// depth share compiled kernels. What is not used of it costs nothing.
constexpr std::uint32_t kernel_stack(std::uint32_t stack_bound) { return (stack_bound + 127) / 128 * 128; }

/// Checked with check_fits before anything is copied.
struct SceneBuffers {
  /// page_bytes > 0: largest page of every array, at least one element; for tests.
  SceneBuffers(const cl::Context& context, const scene::CompiledScene& scene, std::uint64_t page_bytes = 0);

  /// Build option of arrays in pages; empty when each is one buffer.
  std::string options;
  cl::PagedBuffer<shared::BvhNode> nodes;
  cl::PagedBuffer<shared::TriBlock> blocks;
  cl::PagedBuffer<shared::Instance> instances;
  cl::PagedBuffer<shared::Surface> surfaces;
  scene::Skyline skyline;           ///< without its cells
  cl::Buffer<float> skyline_cells;  ///< at least one
  cl::Buffer<shared::Lobe> lobes;  ///< [surface][RC_LOBES] where a material does not reflect by Lambert's law, else one
};

}  // namespace raycube::render
