// Scene arrays in pages (DESIGN section 2; S60, S63): the same bits as in one buffer. The oracle is equality, stage by
// stage, with what one page of each array gives; scene_pages_test.cpp compares the elements themselves.
#include <doctest/doctest.h>

#include <set>

#include "atmos_tables/clear_sky.h"
#include "atmos_tables/synthetic.h"
#include "host/plan/sky_rays.h"
#include "tests/support/devices.h"
#include "tests/support/render_kit.h"
#include "tests/support/same_bytes.h"
#include "tests/support/skies.h"
#include "tests/support/test_scenes.h"
#include "tests/support/trace_chain.h"

namespace {

using namespace raycube;
using raycube::test::same_bytes;
using test::first_context;

constexpr std::size_t kMiB = std::size_t{1} << 20;

/// Hills under a crowd of 24000 turned, tilted and scaled bumpy spheres; 40000 mixtures of 8 materials. More than one
/// page of 1 MiB of every array.
scene::Simulation large_scene() {
  constexpr std::uint32_t kMixtures = 40000, kMaterials = 8, kStones = 24000, kPerRow = 155;
  scene::Simulation simulation;
  auto& scene = simulation.scene;
  for (std::uint32_t m = 0; m < kMaterials; ++m)
    test::add_material(scene, "material " + std::to_string(m), 0.1 + 0.1 * m);
  for (std::uint32_t k = 0; k < kMixtures; ++k) {
    shared::Surface mixture{};
    const float part = static_cast<float>(test::unit_random(4, k, 0));
    mixture.material[0] = 1 + k % kMaterials;
    mixture.material[1] = 1 + (k + 1 + k / kMaterials % (kMaterials - 1)) % kMaterials;
    mixture.fraction[0] = part;
    mixture.fraction[1] = 1 - part;
    scene.surfaces.push_back(mixture);
  }
  const auto any_surface = [&](scene::TriangleMesh& mesh, std::uint32_t seed) {
    for (std::size_t t = 0; t < mesh.surface.size(); ++t)
      mesh.surface[t] = static_cast<std::uint32_t>(test::unit_random(seed, static_cast<std::uint32_t>(t), 0) *
                                                   (kMixtures + kMaterials));
  };
  auto ground = test::terrain(200, 160);
  any_surface(ground, 5);
  auto stone = test::sphere(1, 0.3, 0.2);
  any_surface(stone, 6);
  const auto ground_mesh = append_mesh(scene, "ground", ground), stone_mesh = append_mesh(scene, "stone", stone);
  append_instance(scene, ground_mesh, test::kIdentity, 0);
  for (std::uint32_t i = 0; i < kStones; ++i)
    append_instance(scene, stone_mesh,
                    test::placement(0.7 * i, 0.3 * i, 0.6 + 0.8 * test::unit_random(7, i, 0),
                                    i % kPerRow - 77.0 + 0.3 * test::unit_random(7, i, 1), i / kPerRow - 77.0,
                                    3 + test::unit_random(7, i, 2)),
                    i + 1);
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

TEST_CASE(
    "S8 S60 S63 pages of 1 MiB: hits, surface points, sun and sky are those of one page, in bundles and ray by ray") {
  const auto& scene = large().scene;
  const render::SceneBuffers buffers(first_context(), scene, kMiB);
  MESSAGE("pages: nodes " << buffers.nodes.size() << ", triangles " << buffers.blocks.size() << ", instances "
                          << buffers.instances.size() << ", surfaces " << buffers.surfaces.size());
  REQUIRE(buffers.nodes.size() > 1);
  REQUIRE(buffers.blocks.size() > 1);
  REQUIRE(buffers.instances.size() > 1);
  REQUIRE(buffers.surfaces.size() > 1);
  const shared::rc_float4 sun{0.48f, 0.64f, 0.6f, 0};
  plan::Plan plan;
  plan.sky_components = 1;
  plan.sky_basis = test::uniform_sky();
  plan.sky = plan::make_sky_rays(plan.sky_basis, {}, 0, plan.sun_direction, 16);
  plan.sky.open_share.assign(scene.surfaces.size(), 0.5f);
  for (const bool bundle : {true, false}) {
    CAPTURE(bundle);
    test::TraceShape shape;
    shape.columns = shape.pixels_per_line = shape.lines = 40;
    shape.bundle = bundle;
    shape.components = 1;
    const auto groups = test::nadir_groups(shape, 0, 0, 300, 3.9, 300, 0.02);
    test::TraceChain plain(first_context(), scene, shape);
    shape.page_bytes = kMiB;
    test::TraceChain paged(first_context(), scene, shape);
    const auto hits = plain.primary(groups);
    CHECK(same_bytes(paged.primary(groups), hits));
    CHECK(same_bytes(paged.surface(), plain.surface()));
    CHECK(same_bytes(paged.sun(sun), plain.sun(sun)));
    CHECK(same_bytes(paged.sky(plan), plain.sky(plan)));
    std::set<std::size_t> block_pages, instance_pages;
    for (std::uint32_t pixel = 0; pixel < shape.pixels(); ++pixel)
      for (std::uint32_t s = 0; s < shape.elements().padded; ++s) {
        const std::uint32_t instance = hits[shape.hits_at(pixel, RC_HIT_INSTANCE, s)],
                            primitive = hits[shape.hits_at(pixel, RC_HIT_PRIMITIVE, s)];
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
  const auto table =
      atmos::build_clear_sky(simulation.atmosphere, simulation.sun, 300, atmos::wavelength_grid(0.46, 0.74, 0.004),
                             atmos::clear_sky_heights(simulation.scene.lo[2], simulation.scene.hi[2]));
  const auto plain = test::render_image(simulation, table);
  REQUIRE_FALSE(plain.radiance.empty());
  REQUIRE_FALSE(plain.truth.empty());
  render::RenderOptions options;
  options.page_bytes = kMiB;
  const auto paged = test::render_image(simulation, table, options);
  CHECK(paged.statistics.kernel_variants.front().find("RC_PAGED=1") != std::string::npos);
  CHECK(plain.statistics.kernel_variants.front().find("RC_PAGED") == std::string::npos);
  CHECK(std::set<float>(plain.radiance.begin(), plain.radiance.end()).size() > plain.radiance.size() / 2);
  CHECK(same_bytes(paged.radiance, plain.radiance));
  CHECK(same_bytes(paged.truth, plain.truth));
}
