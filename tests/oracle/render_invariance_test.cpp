// The same bits whatever the tiles, the memory, the threads and the row capacity (REQUIREMENTS section 4, "results
// identical for any tile size, work-group size, memory budget"; DESIGN sections 1b and 4). The oracle is equality: one
// rendering against another of the same scene, all bytes of radiance and truth.
#include <doctest/doctest.h>

#include <set>

#include "atmos_tables/clear_sky.h"
#include "atmos_tables/synthetic.h"
#include "host/render/truth.h"
#include "tests/support/render_kit.h"
#include "tests/support/same_bytes.h"
#include "tests/support/test_scenes.h"

namespace {

using namespace raycube;
using raycube::test::same_bytes;

/// More than the smallest band table holds (261 rows), so that rows are evicted where memory is short.
constexpr int kMaterials = 400;

/// Relief of 400 materials and 6 mixtures, 7 turned, tilted and scaled bumpy spheres, low sun: shadows, four nodes and
/// more.
scene::Simulation busy_scene() {
  scene::Simulation simulation;
  auto& scene = simulation.scene;
  for (int m = 0; m < kMaterials; ++m)
    test::add_material(scene, "material " + std::to_string(m), 0.05 + 0.9 * m / kMaterials);
  for (std::uint32_t m = 0; m < 6; ++m) {
    shared::Surface mixture{};
    for (std::uint32_t k = 0; k < 4; ++k) mixture.material[k] = 1 + 5 * m + 3 * k;
    const float fractions[4] = {0.4f, 0.3f, 0.2f, 0.1f};
    std::copy(fractions, fractions + 4, mixture.fraction);
    scene.surfaces.push_back(mixture);
  }
  auto ground = test::terrain(150, 90);
  for (std::size_t t = 0; t < ground.surface.size(); ++t)
    ground.surface[t] =
        static_cast<std::uint32_t>(test::unit_random(3, static_cast<std::uint32_t>(t), 0) * (kMaterials + 6));
  test::place(scene, ground);
  auto ball = test::sphere(2, 3, 0.2);
  for (std::size_t t = 0; t < ball.surface.size(); ++t)
    ball.surface[t] = static_cast<std::uint32_t>(kMaterials - 2 + t % 4);
  const auto mesh = append_mesh(scene, "ball", ball);
  for (std::uint32_t i = 0; i < 7; ++i)
    append_instance(scene, mesh, test::placement(0.7 * i, 0.3 * i, 0.5 + 0.2 * i, 8.0 * i - 24, 11.0 * (i % 3) - 9, 5),
                    i + 1);
  finish_top_tree(scene);
  simulation.sun.zenith_deg = 62;
  simulation.sun.azimuth_deg = 130;
  simulation.seed = 7;
  simulation.sky_directions = 48;
  simulation.tolerance = 1e-3;
  auto camera = test::nadir_camera(6, 67, 300, 1.0);
  camera.samples_u = camera.samples_v = 11;
  camera.bands.clear();
  for (int b = 0; b < 19; ++b) camera.bands.push_back(test::gaussian_bands({0.45 + 0.02 * b}, 0.006)[0]);
  simulation.instruments = {camera};
  return simulation;
}

atmos::RenderTable table_for(const scene::Simulation& simulation) {
  return atmos::build_clear_sky(simulation.atmosphere, simulation.sun, 300, atmos::wavelength_grid(0.42, 0.86, 0.004),
                                atmos::clear_sky_heights(simulation.scene.lo[2], simulation.scene.hi[2]));
}

struct Variant {
  std::string name;
  render::RenderOptions options;
};
template <class T>
Variant with(const std::string& name, T render::RenderOptions::*option, T value) {
  Variant variant{name, {}};
  variant.options.*option = value;
  return variant;
}
Variant tiles(int lines) {
  return with("tiles of " + std::to_string(lines) + " lines", &render::RenderOptions::tile_lines, lines);
}
Variant memory(std::size_t bytes) {
  return with("memory of " + std::to_string(bytes) + " bytes", &render::RenderOptions::memory_bytes, bytes);
}
Variant threads(int count) { return with(std::to_string(count) + " threads", &render::RenderOptions::threads, count); }
Variant capacity(int keys) {
  return with("rows of " + std::to_string(keys) + " keys", &render::RenderOptions::row_capacity, keys);
}

/// By the plan of the first, which no option changes.
void check_same(const scene::Simulation& simulation, const test::Image& first, const std::vector<Variant>& variants) {
  for (const auto& [name, options] : variants) {
    const auto image = test::render_planned(simulation, first.plan, options);
    INFO(name);
    CHECK(same_bytes(image.radiance, first.radiance));
    CHECK(same_bytes(image.truth, first.truth));
    if (options.tile_lines) CHECK(image.statistics.tile_lines == std::min(options.tile_lines, 67));
    if (options.memory_bytes < 1u << 20) CHECK(image.statistics.tile_columns < image.pixels);
  }
}
/// Hardly more than the least that works, the band table's rows of one pixel (twice as many where light goes between
/// ground and air), and a line that it does not hold.
constexpr std::size_t kLittle_bytes = 1000 << 10;
constexpr int kWide = 48;

/// Work-groups of `local` items, of three for two kernels; tiles of about so many samples.
Variant launches(std::size_t local, std::size_t tile_samples = render::kTileSamples) {
  Variant variant{"work-groups of " + std::to_string(local) + ", tiles of " + std::to_string(tile_samples) + " samples",
                  {}};
  variant.options.tuning = render::DeviceTuning{{local, {{"trace_sky", 3}, {"resolve", 3}}}, tile_samples, false};
  return variant;
}

}  // namespace

TEST_CASE("S60 S63 radiance and truth are the same bytes for any tiles, memory, threads and row capacity") {
  const auto simulation = busy_scene();
  const auto first = test::render_image(simulation, table_for(simulation));
  // The scene must be able to show a difference: overflow, several nodes and components, shadow, instances, many
  // values.
  CHECK(first.statistics.overflow_pixels > 10);
  CHECK(first.plan.sky_components > 1);
  CHECK(first.plan.height.count > 1);
  CHECK(std::set<float>(first.radiance.begin(), first.radiance.end()).size() > first.radiance.size() / 2);
  double lit = 0;
  for (int line = 0; line < first.lines; ++line) lit += first.layer(line, 3, render::truth::sun_fraction);
  CHECK(lit < 0.95 * first.lines);
  MESSAGE(first.statistics.overflow_pixels << " of " << first.lines * first.pixels << " pixels overflow 16 keys, "
                                           << first.plan.source_channels() << " source and "
                                           << first.plan.path_channels() << " path channels");
  const auto again = test::render_image(simulation, table_for(simulation));
  CHECK(same_bytes(again.radiance, first.radiance));
  CHECK(same_bytes(again.truth, first.truth));
  check_same(simulation, first,
             {tiles(1), tiles(7), tiles(64), tiles(67), memory(std::size_t{256} << 20), memory(std::size_t{8} << 30),
              threads(1), threads(2), capacity(1), capacity(2), capacity(16), capacity(256), launches(5),
              launches(1 << 20), launches(5, 6 * 128 * 10), launches(1, std::size_t{1} << 30)});
}

TEST_CASE("S63 tiles follow the samples that a launch is worth") {
  auto simulation = busy_scene();
  const auto image = test::render_image(simulation, table_for(simulation), launches(1, 6 * 128 * 10).options);
  CHECK(image.statistics.tile_lines == 10);
  CHECK(image.statistics.tile_columns == 6);
  const auto launched = render::Renderer(simulation.scene, launches(5).options).tuning().sizes;
  CHECK(launched.of("trace_sky") == 3);
  CHECK(launched.of("shade") == 5);
}

TEST_CASE("S63 part of one line per tile, and a band table that cannot hold every row, give the same bytes") {
  auto simulation = busy_scene();
  simulation.instruments[0].lines = 5;
  simulation.instruments[0].pixels = kWide;
  const auto first = test::render_image(simulation, table_for(simulation));
  check_same(simulation, first, {memory(kLittle_bytes)});
}

TEST_CASE("S63 samplers that depend on the pixel's number, and samples in chunks, do not see the tiles") {
  for (const auto sampler : {scene::SamplerKind::jittered, scene::SamplerKind::lattice}) {
    auto simulation = busy_scene();
    simulation.instruments[0].lines = 5;
    simulation.instruments[0].pixels = kWide;
    simulation.instruments[0].sampler = sampler;
    const auto first = test::render_image(simulation, table_for(simulation));
    check_same(simulation, first, {tiles(1), memory(kLittle_bytes), threads(1), capacity(2), launches(5)});
  }
  auto simulation = busy_scene();
  simulation.instruments[0].lines = 3;
  simulation.instruments[0].samples_u = simulation.instruments[0].samples_v = 41;  // 1681 samples: two chunks
  const auto first = test::render_image(simulation, table_for(simulation));
  check_same(simulation, first, {tiles(1), tiles(2), threads(1), capacity(2), launches(5)});
}

TEST_CASE("S4.9 S60 S63 light between ground and air: the same bytes for any tiles, memory, threads and row capacity") {
  auto simulation = busy_scene();
  simulation.instruments[0].lines = 4;
  simulation.instruments[0].pixels = 2 * kWide;
  auto table = table_for(simulation);
  test::add_ground_coupling(table);
  const auto first = test::render_image(simulation, table);
  CHECK(first.plan.environment.nodes() > 8);
  CHECK(first.statistics.overflow_pixels > 0);
  // Little memory: part of a line at a time, and a band table that holds neither all materials nor all nodes.
  check_same(simulation, first, {tiles(3), memory(3 * kLittle_bytes), threads(1), capacity(1), capacity(256)});
  simulation.instruments[0].lines = 3;
  simulation.instruments[0].samples_u = simulation.instruments[0].samples_v = 41;  // two chunks
  check_same(simulation, test::render_image(simulation, table), {capacity(2)});
}

TEST_CASE("S63 another seed gives other sky directions") {
  auto simulation = busy_scene();
  simulation.instruments[0].lines = 2;
  const auto first = test::render_image(simulation, table_for(simulation));
  simulation.seed = 8;
  const auto second = test::render_image(simulation, table_for(simulation));
  CHECK(!same_bytes(first.radiance, second.radiance));
  CHECK(same_bytes(first.truth, second.truth));
}
