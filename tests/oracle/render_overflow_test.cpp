// Pixels with more product keys than a row holds (DESIGN section 1b): the relaunch with 64 and 256 keys and the sum per
// sample. Oracle: a square of n x n tiles, each its own constant material, fills one pixel of a camera straight above;
// which sample meets which tile is an integer division, and the radiance is a sum over samples in double under a
// uniform sun and sky. Tolerance 2e-6: one fp32 rounding of the band value, one of each weight, and float16 sums of up
// to 64 groups (PERFORMANCE: float32 terms against double 2.5e-7, here with sums of a thousand samples).
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "atmos_tables/synthetic.h"
#include "host/render/truth.h"
#include "tests/support/render_kit.h"

namespace {

using namespace raycube;
constexpr double kSunZenith_deg = 35, kSun = 1200, kSky = 40;

/// Reflectance of tile number i of all: every tile another, above 0 to 1, neighbours far apart.
double tile_reflectance(std::size_t i, std::size_t all) { return double(i * 7919 % all + 1) / double(all); }

/// Pixels of 8 m in one line; pixel p holds tiles[p] x tiles[p] tiles. Tile t of pixel p is material first[p] + t.
struct TiledLine {
  scene::Simulation simulation;
  std::vector<int> tiles;
  std::vector<std::size_t> first;
  std::size_t materials = 0;

  TiledLine(std::vector<int> tiles_per_side, int samples) : tiles(std::move(tiles_per_side)) {
    constexpr double pixel = 8;
    for (const int n : tiles) {
      first.push_back(materials);
      materials += std::size_t(n) * n;
    }
    auto& scene = simulation.scene;
    for (std::size_t m = 0; m < materials; ++m)
      test::add_material(scene, "m" + std::to_string(m), tile_reflectance(m, materials));
    scene::TriangleMesh mesh;
    for (std::size_t p = 0; p < tiles.size(); ++p) {
      const int n = tiles[p];
      const double left = (double(p) - 0.5 * double(tiles.size())) * pixel;
      const auto base = static_cast<std::uint32_t>(mesh.vertices.size());
      for (int j = 0; j <= n; ++j)
        for (int i = 0; i <= n; ++i)
          mesh.vertices.push_back({float(left + pixel * i / n), float(pixel / 2 - pixel * j / n), 0.0f});
      for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
          const auto at = base + static_cast<std::uint32_t>(j * (n + 1) + i),
                     below = at + static_cast<std::uint32_t>(n) + 1;
          mesh.triangles.push_back({at, below, below + 1});
          mesh.triangles.push_back({at, below + 1, at + 1});
          mesh.surface.insert(mesh.surface.end(), 2,
                              static_cast<std::uint32_t>(first[p]) + static_cast<std::uint32_t>(j * n + i));
        }
    }
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) mesh.user_face.push_back(static_cast<std::uint32_t>(t));
    test::place(scene, mesh);
    finish_top_tree(scene);
    simulation.sun.zenith_deg = kSunZenith_deg;
    simulation.sky_directions = 1;
    auto camera = test::nadir_camera(static_cast<int>(tiles.size()), 1, 4096, pixel);
    camera.samples_u = camera.samples_v = samples;
    simulation.instruments = {camera};
  }

  test::Image render(const render::RenderOptions& options = {}) const {
    return test::render_image(simulation, atmos::uniform_sky_table(kSun, kSky, {0.3, 1.0, 4.0}, kSunZenith_deg),
                              options);
  }

  /// Samples of pixel p in tile t, over all samples.
  double share(std::size_t p, int t) const {
    const int n = tiles[p], samples = simulation.instruments[0].samples_u;
    const auto inside = [&](int tile) {  // sample centres (2 i + 1) / (2 samples) in [tile, tile + 1) / n
      int count = 0;
      for (int i = 0; i < samples; ++i) count += (2 * i + 1) * n / (2 * samples) == tile;
      return count;
    };
    return double(inside(t % n)) * inside(t / n) / (double(samples) * samples);
  }
  double radiance(std::size_t p) const {
    const double unit = kSun * std::cos(kSunZenith_deg * std::numbers::pi / 180) / std::numbers::pi + kSky;
    double sum = 0;
    for (int t = 0; t < tiles[p] * tiles[p]; ++t)
      sum += tile_reflectance(first[p] + std::size_t(t), materials) * share(p, t);
    return unit * sum;
  }
};

void check_line(const TiledLine& line, const test::Image& image, double tolerance) {
  double worst = 0, worst_abundance = 0;
  for (std::size_t p = 0; p < line.tiles.size(); ++p) {
    for (int band = 0; band < image.bands; ++band)
      worst = std::max(worst, std::abs(image.at(0, int(p), band) / line.radiance(p) - 1));
    const int n = line.tiles[p];
    double abundances = 0;
    for (int layer = image.layers - int(line.materials); layer < image.layers; ++layer)
      abundances += image.layer(0, int(p), layer);
    CHECK(abundances == doctest::Approx(image.layer(0, int(p), render::truth::hit_fraction))
                            .epsilon(1e-5));  // S26: abundances sum to the hit fraction
    CHECK(image.layer(0, int(p), render::truth::hit_fraction) == doctest::Approx(1).epsilon(1e-6));
    for (int t = 0; t < n * n; t += 1 + n * n / 400) {
      const int layer = image.layers - int(line.materials) + int(line.first[p]) + t;
      const double share = line.share(p, t);
      worst_abundance = std::max(worst_abundance, std::abs(image.layer(0, int(p), layer) - share) / share);
    }
  }
  MESSAGE("worst relative error: radiance " << worst << ", abundance " << worst_abundance << "; overflow pixels "
                                            << image.statistics.overflow_pixels << ", per sample "
                                            << image.statistics.per_sample_pixels);
  CHECK(worst < tolerance);
  CHECK(worst_abundance < 1e-5);
}

}  // namespace

TEST_CASE("S60 pixels of 1 to 324 curves equal the sum over samples in double, with and without the overflow path") {
  const TiledLine line({1, 4, 5, 10, 18, 15, 17, 3},
                       32);  // 1, 16, 25, 100, 324, 225, 289, 9 curves; rows hold 16, 64, 256
  const auto image = line.render();
  check_line(line, image, 2e-6);
  CHECK(image.statistics.overflow_pixels == 5);
  CHECK(image.statistics.per_sample_pixels == 2);
}

TEST_CASE("S60 the same curves with samples in chunks, whose sums are carried with compensation") {
  const TiledLine line({1, 4, 18, 10}, 96);  // 9216 samples: 10 chunks
  const auto image = line.render();
  check_line(line, image, 2e-6);
  CHECK(image.statistics.per_sample_pixels == 1);
}

TEST_CASE("S4.9 S60 light of the ground around joins pixels of 1, 100 and 324 curves alike, samples in chunks too") {
  for (const int samples : {32, 96}) {
    TiledLine line({1, 10, 18}, samples);
    line.simulation.atmosphere.adjacency = scene::Adjacency::mean;
    atmos::UniformAir air;
    air.solar_irradiance = [](double) { return kSun; };
    air.sky_radiance = [](double) { return kSky; };
    air.spherical_albedo = air.diffuse_return = air.diffuse_view_transmission = [](double) { return 0.25; };
    air.sun_zenith_deg = kSunZenith_deg;
    const auto image = test::render_image(line.simulation, atmos::uniform_table(air, {0.3, 1.0, 4.0}));
    CHECK(image.statistics.per_sample_pixels == 1);
    double mean = 0;
    for (std::size_t m = 0; m < line.materials; ++m)
      mean += image.plan.environment.mean[m] * tile_reflectance(m, line.materials);
    CHECK(mean > 0.1);
    const double light = kSun * std::cos(kSunZenith_deg * std::numbers::pi / 180) / std::numbers::pi + kSky;
    for (std::size_t p = 0; p < line.tiles.size(); ++p)
      CHECK(image.at(0, int(p), 1) ==
            doctest::Approx((line.radiance(p) + 0.25 * mean * light) / (1 - 0.25 * mean)).epsilon(2e-6));
  }
}

TEST_CASE("S60 S63 a pixel of 100 489 keys takes the path per sample and equals the sum in double") {
  const TiledLine line({317}, 317);  // every sample its own material
  const auto image = line.render();
  check_line(line, image, 2e-6);
  CHECK(image.statistics.overflow_pixels == 1);
  CHECK(image.statistics.per_sample_pixels == 1);
}
