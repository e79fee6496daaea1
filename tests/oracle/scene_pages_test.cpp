// What kernels read through kernels/geometry/scene_arrays.h, element by element, against the host's own arrays (DESIGN
// section 2, S60): pages of every array, and scenes that no pages hold.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstring>

#include "host/base/error.h"
#include "host/cl/kernel.h"
#include "host/render/renderer.h"
#include "host/render/scene_buffers.h"
#include "tests/support/devices.h"
#include "tests/support/probes.h"
#include "tests/support/same_bytes.h"

namespace {

using namespace raycube;
using raycube::test::same_bytes;
using test::first_context;

template <class T>
void fill(std::vector<T>& array, std::size_t count, std::uint32_t& next) {
  array.resize(count);
  for (std::size_t at = 0; at < count * sizeof(T); at += sizeof next, next = next * 1664525u + 1013904223u)
    std::memcpy(reinterpret_cast<char*>(array.data()) + at, &next, sizeof next);
}

/// Arrays of numbers, no scene: for reading them back. Only the mesh that instances name is one that is there, since
/// the buffers ask which matter is in use.
scene::CompiledScene numbers(std::size_t nodes, std::size_t blocks, std::size_t instances, std::size_t surfaces) {
  scene::CompiledScene scene;
  std::uint32_t next = 1;
  fill(scene.nodes, nodes, next);
  fill(scene.blocks, blocks, next);
  fill(scene.instances, instances, next);
  scene.trees.resize(1);
  for (shared::Instance& instance : scene.instances) instance.tree = 0;
  fill(scene.surfaces, surfaces, next);
  return scene;
}

/// What kernels read at every index of every array.
scene::CompiledScene read_on_device(const scene::CompiledScene& scene, std::size_t page_bytes) {
  const render::SceneBuffers buffers(first_context(), scene, page_bytes);
  const auto program = test::probes(first_context(), buffers.options);
  cl::Kernel kernel(*program, "read_all");
  cl::Buffer<shared::BvhNode> nodes(first_context(), scene.nodes.size(), cl::Access::write_only, "nodes read");
  cl::Buffer<shared::TriBlock> blocks(first_context(), scene.blocks.size(), cl::Access::write_only, "blocks read");
  cl::Buffer<shared::Instance> instances(first_context(), scene.instances.size(), cl::Access::write_only,
                                         "instances read");
  cl::Buffer<shared::Surface> surfaces(first_context(), scene.surfaces.size(), cl::Access::write_only, "surfaces read");
  const auto count = [](const auto& array) { return static_cast<cl_uint>(array.size()); };
  kernel.arguments(buffers.nodes, buffers.blocks, buffers.instances, buffers.surfaces, nodes, blocks, instances,
                   surfaces, count(scene.nodes), count(scene.blocks), count(scene.instances), count(scene.surfaces));
  first_context().launch(
      kernel, std::max({scene.nodes.size(), scene.blocks.size(), scene.instances.size(), scene.surfaces.size()}));
  first_context().finish();
  scene::CompiledScene read;
  read.nodes = nodes.read_all();
  read.blocks = blocks.read_all();
  read.instances = instances.read_all();
  read.surfaces = surfaces.read_all();
  return read;
}

void check_read(const scene::CompiledScene& scene, std::size_t page_bytes) {
  REQUIRE_FALSE((scene.nodes.empty() || scene.blocks.empty() || scene.instances.empty() || scene.surfaces.empty()));
  const scene::CompiledScene read = read_on_device(scene, page_bytes);
  CHECK(same_bytes(read.nodes, scene.nodes));
  CHECK(same_bytes(read.blocks, scene.blocks));
  CHECK(same_bytes(read.instances, scene.instances));
  CHECK(same_bytes(read.surfaces, scene.surfaces));
}

}  // namespace

TEST_CASE("S60 every element is itself: arrays that end before, at and after the edges of pages") {
  constexpr std::size_t kPage = 1536;  // 6 -> 4 nodes, 2 blocks, 13 -> 8 instances, 48 -> 32 surfaces
  check_read(numbers(3, 1, 7, 31), kPage);
  check_read(numbers(6, 3, 12, 41), kPage);
  check_read(numbers(8, 4, 16, 64), kPage);
  check_read(numbers(9, 5, 17, 65), kPage);
  check_read(numbers(31, 15, 63, 255), kPage);
  check_read(numbers(32, 16, 64, 256), kPage);
  check_read(numbers(27, 1, 5, 129), kPage);  // one array in one page, another in several
  const render::SceneBuffers all(first_context(), numbers(32, 16, 64, 256), kPage);
  CHECK(all.nodes.size() == 8);
  CHECK(all.blocks.size() == 8);
  CHECK(all.instances.size() == 8);
  CHECK(all.surfaces.size() == 8);
  const render::SceneBuffers one(first_context(), numbers(32, 16, 64, 256));
  CHECK(one.options.empty());
  CHECK(one.nodes.size() == 1);
  CHECK(one.surfaces.size() == 1);
}

TEST_CASE("S60 a scene past 8 pages is refused before anything is copied, with need, limit and ways out") {
  const auto scene = numbers(4, 2049, 8, 32);  // 1.5 MiB of triangles, pages of 256
  render::RenderOptions options;
  options.page_bytes = 256 * sizeof(shared::TriBlock);
  CHECK_NOTHROW(render::Renderer(numbers(4, 2048, 8, 32), options));
  std::string text;
  try {
    render::Renderer(scene, options);
  } catch (const base::Error& error) {
    text = error.what();
    CHECK(error.fault() == base::Fault::device);
  }
  CHECK(text.find("triangles 2 MiB of at most 1 MiB") != std::string::npos);
  CHECK(text.find("instances, use coarser meshes or terrain") != std::string::npos);
}
