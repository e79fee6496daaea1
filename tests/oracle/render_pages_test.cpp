// Scene arrays in pages (DESIGN section 2; S60, S63): the same bits as in one buffer. The oracle is equality with the host's own
// arrays, element by element, and with the rendering from one page each.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstring>
#include <set>

#include "atmos_tables/clear_sky.h"
#include "atmos_tables/synthetic.h"
#include "host/base/error.h"
#include "kernels/kernel_source.h"
#include "tests/support/render_kit.h"
#include "tests/support/test_scenes.h"
#include "tests/support/trace_chain.h"

namespace {

using namespace raycube;

constexpr std::size_t kMiB = std::size_t{1} << 20;

const cl::Context& context() {
  static const cl::Context instance{cl::Device(cl::list_devices().front()())};
  return instance;
}

template <class T>
bool same_bytes(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && !a.empty() && std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
}

template <class T>
void fill(std::vector<T>& array, std::size_t count, std::uint32_t& next) {
  array.resize(count);
  for (std::size_t at = 0; at < count * sizeof(T); at += sizeof next, next = next * 1664525u + 1013904223u)
    std::memcpy(reinterpret_cast<char*>(array.data()) + at, &next, sizeof next);
}

/// Arrays of numbers, no scene: for reading them back.
scene::CompiledScene numbers(std::size_t nodes, std::size_t blocks, std::size_t instances, std::size_t surfaces) {
  scene::CompiledScene scene;
  std::uint32_t next = 1;
  fill(scene.nodes, nodes, next);
  fill(scene.blocks, blocks, next);
  fill(scene.instances, instances, next);
  fill(scene.surfaces, surfaces, next);
  return scene;
}

const char kReadAll[] = R"(
kernel void read_all(RC_NODES, RC_BLOCKS, RC_INSTANCES, RC_SURFACES, global BvhNode* nodes, global TriBlock* blocks,
                     global Instance* instances, global Surface* surfaces, uint node_count, uint block_count,
                     uint instance_count, uint surface_count) {
  SceneArrays scene;
  RC_GATHER_NODES(scene);
  RC_GATHER_BLOCKS(scene);
  RC_GATHER_INSTANCES(scene);
  RC_GATHER_SURFACES(scene);
  const uint at = get_group_id(0);
  if (at < node_count) nodes[at] = *rc_node(scene, at);
  if (at < block_count) blocks[at] = *rc_block(scene, at);
  if (at < instance_count) instances[at] = *rc_instance(scene, at);
  if (at < surface_count) surfaces[at] = *rc_surface(scene, at);
}
)";

/// What kernels read at every index of every array.
scene::CompiledScene read_on_device(const scene::CompiledScene& scene, std::size_t page_bytes) {
  const render::SceneBuffers buffers(context(), scene, page_bytes);
  const cl::Program program(context(), "read_all", std::string(kernels::kernel_source("trace")) + kReadAll,
                            "-cl-std=CL1.2" + buffers.options);
  cl::Kernel kernel(program, "read_all");
  cl::Buffer<shared::BvhNode> nodes(context(), scene.nodes.size(), cl::Access::write_only, "nodes read");
  cl::Buffer<shared::TriBlock> blocks(context(), scene.blocks.size(), cl::Access::write_only, "blocks read");
  cl::Buffer<shared::Instance> instances(context(), scene.instances.size(), cl::Access::write_only, "instances read");
  cl::Buffer<shared::Surface> surfaces(context(), scene.surfaces.size(), cl::Access::write_only, "surfaces read");
  const auto count = [](const auto& array) { return static_cast<cl_uint>(array.size()); };
  kernel.arguments(buffers.nodes, buffers.blocks, buffers.instances, buffers.surfaces, nodes, blocks, instances, surfaces,
                   count(scene.nodes), count(scene.blocks), count(scene.instances), count(scene.surfaces));
  context().launch(kernel, std::max({scene.nodes.size(), scene.blocks.size(), scene.instances.size(), scene.surfaces.size()}));
  context().finish();
  scene::CompiledScene read;
  read.nodes = nodes.read_all();
  read.blocks = blocks.read_all();
  read.instances = instances.read_all();
  read.surfaces = surfaces.read_all();
  return read;
}

void check_read(const scene::CompiledScene& scene, std::size_t page_bytes) {
  const scene::CompiledScene read = read_on_device(scene, page_bytes);
  CHECK(same_bytes(read.nodes, scene.nodes));
  CHECK(same_bytes(read.blocks, scene.blocks));
  CHECK(same_bytes(read.instances, scene.instances));
  CHECK(same_bytes(read.surfaces, scene.surfaces));
}

/// Hills under a crowd of 24000 turned, tilted and scaled octahedron-like stones; 40000 mixtures of 8 materials. More than one
/// page of 1 MiB of every array.
scene::Simulation large_scene() {
  constexpr std::uint32_t kMixtures = 40000, kMaterials = 8, kStones = 24000, kPerRow = 155;
  scene::Simulation simulation;
  auto& scene = simulation.scene;
  for (std::uint32_t m = 0; m < kMaterials; ++m) test::add_material(scene, "material " + std::to_string(m), 0.1 + 0.1 * m);
  for (std::uint32_t k = 0; k < kMixtures; ++k) {
    shared::Surface mixture{};
    const float part = static_cast<float>(test::unit_random(4, k, 0));
    mixture.curve[0] = 1 + k % kMaterials;
    mixture.curve[1] = 1 + (k + 1 + k / kMaterials % (kMaterials - 1)) % kMaterials;
    mixture.fraction[0] = part;
    mixture.fraction[1] = 1 - part;
    scene.surfaces.push_back(mixture);
  }
  const auto any_surface = [&](scene::TriangleMesh& mesh, std::uint32_t seed) {
    for (std::size_t t = 0; t < mesh.surface.size(); ++t)
      mesh.surface[t] = static_cast<std::uint32_t>(test::unit_random(seed, static_cast<std::uint32_t>(t), 0) * (kMixtures + kMaterials));
  };
  auto ground = test::terrain(200, 160);
  any_surface(ground, 5);
  auto stone = test::sphere(1, 0.3, 0.2);
  any_surface(stone, 6);
  const auto ground_mesh = append_mesh(scene, "ground", ground), stone_mesh = append_mesh(scene, "stone", stone);
  append_instance(scene, ground_mesh, test::kIdentity, 0);
  for (std::uint32_t i = 0; i < kStones; ++i)
    append_instance(scene, stone_mesh,
                    test::placement(0.7 * i, 0.3 * i, 0.6 + 0.8 * test::unit_random(7, i, 0), i % kPerRow - 77.0 + 0.3 * test::unit_random(7, i, 1),
                                    i / kPerRow - 77.0, 3 + test::unit_random(7, i, 2)), i + 1);
  finish_top_tree(scene);
  simulation.sun.zenith_deg = 55;
  simulation.sun.azimuth_deg = 130;
  simulation.seed = 7;
  simulation.sky_directions = 4;
  simulation.tolerance = 5e-3;
  auto camera = test::nadir_camera(40, 40, 300, 4.0);
  camera.samples_u = camera.samples_v = 4;
  camera.bands = test::gaussian_bands({0.5, 0.6, 0.7}, 0.01);
  simulation.instruments = {camera};
  return simulation;
}

const scene::Simulation& large() {
  static const scene::Simulation instance = large_scene();
  return instance;
}

}  // namespace

TEST_CASE("S60 every element is itself: arrays that end before, at and after the edges of pages") {
  constexpr std::size_t kPage = 1280;  // 5 -> 4 nodes, 2 blocks, 11 -> 8 instances, 40 -> 32 surfaces
  check_read(numbers(3, 1, 7, 31), kPage);
  check_read(numbers(6, 3, 12, 41), kPage);
  check_read(numbers(8, 4, 16, 64), kPage);
  check_read(numbers(9, 5, 17, 65), kPage);
  check_read(numbers(31, 15, 63, 255), kPage);
  check_read(numbers(32, 16, 64, 256), kPage);
  check_read(numbers(27, 1, 5, 129), kPage);  // one array in one page, another in several
  const render::SceneBuffers all(context(), numbers(32, 16, 64, 256), kPage);
  CHECK(all.nodes.size() == 8);
  CHECK(all.blocks.size() == 8);
  CHECK(all.instances.size() == 8);
  CHECK(all.surfaces.size() == 8);
  const render::SceneBuffers one(context(), numbers(32, 16, 64, 256));
  CHECK(one.options.empty());
  CHECK(one.nodes.size() == 1);
  CHECK(one.surfaces.size() == 1);
}

TEST_CASE("S60 a scene past 8 pages is refused before anything is copied, with need, limit and ways out") {
  const auto scene = numbers(4, 2049, 8, 32);  // 1.25 MiB of triangles, pages of 256
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

TEST_CASE("S8 S60 S63 pages of 1 MiB: hits, surface points, sun and sky are those of one page, in bundles and ray by ray") {
  const auto& scene = large().scene;
  const render::SceneBuffers buffers(context(), scene, kMiB);
  MESSAGE("pages: nodes " << buffers.nodes.size() << ", triangles " << buffers.blocks.size() << ", instances "
                          << buffers.instances.size() << ", surfaces " << buffers.surfaces.size());
  REQUIRE(buffers.nodes.size() > 1);
  REQUIRE(buffers.blocks.size() > 1);
  REQUIRE(buffers.instances.size() > 1);
  REQUIRE(buffers.surfaces.size() > 1);
  const shared::rc_float4 sun{0.48f, 0.64f, 0.6f, 0};
  const std::vector<shared::rc_float4> directions{{0.6f, 0, 0.8f, 0}, {0, -0.8f, 0.6f, 0}, {-0.8f, 0.36f, 0.48f, 0}},
      weights{{1, 0.5f, 0.25f, 2}, {0.5f, 1, 3, 0.1f}, {0.7f, 0.3f, 0.2f, 0.1f}};
  for (const bool bundle : {true, false}) {
    CAPTURE(bundle);
    test::TraceShape shape;
    shape.columns = shape.pixels_per_line = shape.lines = 40;
    shape.bundle = bundle;
    const auto groups = test::nadir_groups(shape, 0, 0, 300, 3.9, 300, 0.02);
    test::TraceChain plain(context(), scene, shape);
    shape.page_bytes = kMiB;
    test::TraceChain paged(context(), scene, shape);
    const auto hits = plain.primary(groups);
    CHECK(same_bytes(paged.primary(groups), hits));
    CHECK(same_bytes(paged.surface(), plain.surface()));
    CHECK(same_bytes(paged.sun(sun), plain.sun(sun)));
    CHECK(same_bytes(paged.sky(directions, weights, 1), plain.sky(directions, weights, 1)));
    std::set<std::size_t> block_pages, instance_pages;
    const std::uint32_t n = shape.npad();
    for (std::uint32_t pixel = 0; pixel < shape.pixels(); ++pixel)
      for (std::uint32_t s = 0; s < n; ++s) {
        const std::uint32_t instance = hits[pixel * 2 * n + s], primitive = hits[(pixel * 2 + 1) * n + s];
        if (instance == RC_NONE) continue;
        instance_pages.insert(instance / buffers.instances[0].size());
        block_pages.insert(primitive / RC_BLOCK / buffers.blocks[0].size());
      }
    CHECK(instance_pages.size() == buffers.instances.size());
    CHECK(block_pages.size() == buffers.blocks.size());
  }
}

TEST_CASE("S60 S63 pages of 1 MiB: radiance and truth are the same bytes") {
  const auto& simulation = large();
  const auto table = atmos::build_clear_sky(simulation.atmosphere, simulation.sun, 300, atmos::wavelength_grid(0.46, 0.74, 0.004),
                                            atmos::clear_sky_heights(simulation.scene.lo[2], simulation.scene.hi[2]));
  const auto plain = test::render_image(simulation, table);
  render::RenderOptions options;
  options.page_bytes = kMiB;
  const auto paged = test::render_image(simulation, table, options);
  CHECK(paged.statistics.build_options.find("RC_BLOCK_PAGES=") != std::string::npos);
  CHECK(plain.statistics.build_options.find("_PAGES=") == std::string::npos);
  CHECK(std::set<float>(plain.radiance.begin(), plain.radiance.end()).size() > plain.radiance.size() / 2);
  CHECK(same_bytes(paged.radiance, plain.radiance));
  CHECK(same_bytes(paged.truth, plain.truth));
}
