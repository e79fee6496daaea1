// White furnace (S16, REQUIREMENTS section 4): a white plane under a uniform sky of radiance 1 shows radiance 1,
// whatever the number of samples. Plain float sums stall at 2^24 = 1.7e7 samples; chunked, compensated sums do not.
// Tolerance 1e-6: the weight 1 / N, the map's value pi / pi and the baked band value are each one fp32 rounding (6e-8).
#include <doctest/doctest.h>

#include <chrono>
#include <cmath>
#include <cstdlib>

#include "atmos_tables/synthetic.h"
#include "host/render/truth.h"
#include "tests/support/full.h"
#include "tests/support/render_kit.h"

namespace {

using namespace raycube;

test::Image furnace(int samples_u, int samples_v, int pixels = 1,
                    scene::SamplerKind sampler = scene::SamplerKind::grid) {
  scene::Simulation simulation;
  const auto white = test::add_material(simulation.scene, "white", 1.0);
  test::place(simulation.scene, test::rectangle({-50, -50, 0}, {100, 0, 0}, {0, 100, 0}, white));
  finish_top_tree(simulation.scene);
  simulation.sun.zenith_deg = 120;  // the sun is down: no sun stage
  simulation.sky_directions = 1;
  auto camera = test::nadir_camera(pixels, 1, 500, 1.0);
  camera.samples_u = samples_u;
  camera.samples_v = samples_v;
  camera.sampler = sampler;
  simulation.instruments = {camera};
  return test::render_image(simulation, atmos::uniform_sky_table(0, 1.0, {0.3, 1.0, 4.0}, 120));
}

double worst_error(const test::Image& image) {
  double worst = 0;
  for (const float l : image.radiance) worst = std::max(worst, std::abs(l - 1.0));
  for (int pixel = 0; pixel < image.pixels; ++pixel) {
    worst = std::max(worst, std::abs(image.layer(0, pixel, render::truth::hit_fraction) - 1.0));  // hit fraction
    worst = std::max(worst, std::abs(image.layer(0, pixel, image.layers - 1) - 1.0));             // abundance of white
  }
  return worst;
}

}  // namespace

TEST_CASE("S16 S43 white furnace for grids of 1 x 1 to 31 x 31") {
  double worst = 0;
  for (const int n : {1, 4, 11, 31})
    worst = std::max(worst, worst_error(furnace(n, n, 5)));  // each builds its own kernels
  worst = std::max({worst, worst_error(furnace(31, 1, 5)), worst_error(furnace(3, 7, 5))});
  MESSAGE("worst error " << worst);
  CHECK(worst < 1e-6);
}

TEST_CASE("S16 S63 white furnace at 1e6 samples in a pixel, all samplers") {
  for (const auto sampler : {scene::SamplerKind::grid, scene::SamplerKind::jittered, scene::SamplerKind::lattice}) {
    const double error = worst_error(furnace(1000, 1000, 1, sampler));
    MESSAGE("1e6 samples, sampler " << int(sampler) << ": error " << error);
    CHECK(error < 1e-6);
  }
}

TEST_CASE("S16 S63 white furnace at 2e7 samples in a pixel, of all cases at 1e8") {  // 1.2 and 6 times 2^24
  const int columns = testing::full() ? 100000 : 20000;
  const auto start = std::chrono::steady_clock::now();
  const auto image = furnace(1000, columns);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  MESSAGE(1e3 * columns << " samples: error " << worst_error(image) << ", " << seconds << " s");
  CHECK(image.statistics.primary_rays == 1000u * static_cast<unsigned>(columns));
  CHECK(worst_error(image) < 1e-6);
}
