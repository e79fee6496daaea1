// Adaptive samples, standard errors and the mask of pixels that have not converged (S43, S62). Oracles: a straight edge
// whose pixels are counted by hand, renders with all samples and with the first pass's alone, Student's distribution
// for stripes finer than the cells of a jittered grid, and equality whatever the tiles.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "atmos_tables/synthetic.h"
#include "host/render/truth.h"
#include "tests/support/chance_checks.h"
#include "tests/support/render_kit.h"
#include "tests/support/same_bytes.h"

namespace {

using namespace raycube;
using raycube::test::same_bytes;
constexpr double kDark = 0.1, kLight = 0.8, kSky = 40;

/// Light right of x = edge_m, dark left of it, under a uniform sky alone; 12 x 5 pixels of 1 m, pixel i from x = i - 6.
scene::Simulation edge_scene(double edge_m) {
  scene::Simulation simulation;
  const auto dark = test::add_material(simulation.scene, "dark", kDark),
             light = test::add_material(simulation.scene, "light", kLight);
  test::place(simulation.scene,
              test::join({test::rectangle({-50, -50, 0}, {50 + edge_m, 0, 0}, {0, 100, 0}, dark),
                          test::rectangle({edge_m, -50, 0}, {50 - edge_m, 0, 0}, {0, 100, 0}, light)}));
  finish_top_tree(simulation.scene);
  simulation.sun.zenith_deg = 120;
  simulation.sky_directions = 1;
  auto camera = test::nadir_camera(12, 5, 512, 1.0);
  camera.samples_u = camera.samples_v = 11;
  camera.first_samples = 16;
  simulation.instruments = {camera};
  return simulation;
}

atmos::RenderTable sky_table() { return atmos::uniform_sky_table(0, kSky, {0.3, 1.0, 4.0}, 120); }

test::Image render_with(scene::Simulation simulation, int samples_u, int samples_v) {
  scene::Instrument& camera = simulation.instruments[0];
  camera.samples_u = samples_u, camera.samples_v = samples_v, camera.first_samples = 0;
  return test::render_image(simulation, sky_table());
}

/// The first pass alone, as an image.
test::Image first_pass(scene::Simulation simulation) {
  simulation.instruments[0].sampler = scene::SamplerKind::lattice;
  return render_with(simulation, simulation.instruments[0].first_samples, 1);
}

/// Stripes along y of 0.01 m, dark and light by turns, finer than the cells of 8 x 8 samples in pixels of 1 m.
scene::Simulation stripes_scene(int pixels, int lines) {
  scene::Simulation simulation;
  const auto dark = test::add_material(simulation.scene, "dark", kDark),
             light = test::add_material(simulation.scene, "light", kLight);
  std::vector<scene::TriangleMesh> parts;
  const double half = pixels / 2.0 + 1;
  for (int i = 0; i < static_cast<int>(200 * half); ++i)
    parts.push_back(
        test::rectangle({-half + 0.01 * i, -half, 0}, {0.01, 0, 0}, {0, 2 * half, 0}, i % 2 ? light : dark));
  test::place(simulation.scene, test::join(parts));
  finish_top_tree(simulation.scene);
  simulation.sun.zenith_deg = 120;
  simulation.sky_directions = 1;
  auto camera = test::nadir_camera(pixels, lines, 512, 1.0);
  camera.sampler = scene::SamplerKind::jittered;
  camera.samples_u = camera.samples_v = 8;
  camera.standard_error = scene::StandardError::bands;
  simulation.instruments = {camera};
  return simulation;
}

}  // namespace

TEST_CASE("S43 adaptive: pixels about an edge have all samples, those far from it the first pass, to the bit") {
  // At 6 of the 16 columns of points of the first pass, which its four quarters never share evenly. (At 0.3 they do in
  // a fifth of the pixels, and where they do in all neighbours of an edge it passes for settled.)
  const auto simulation = edge_scene(0.375);
  const auto adaptive = test::render_image(simulation, sky_table());
  const auto all = render_with(simulation, 11, 11), first = first_pass(simulation);
  for (int line = 0; line < 5; ++line)
    for (int pixel = 0; pixel < 12; ++pixel)
      for (int band = 0; band < 3; ++band) {
        const double share = pixel < 6    ? 1
                             : pixel == 6 ? 4 / 11.0
                                          : 0;  // columns with centres (k + 0.5) / 11 below the edge
        CHECK(adaptive.at(line, pixel, band) ==
              doctest::Approx(kSky * (kDark * share + kLight * (1 - share))).epsilon(1e-5));
        // Groups of 4 pixels are rendered anew together: 4 .. 7 hold the edge and its neighbours.
        const std::size_t at = static_cast<std::size_t>((line * 12 + pixel) * 3 + band);
        CHECK(std::memcmp(&adaptive.radiance[at], &(pixel / 4 == 1 ? all : first).radiance[at], sizeof(float)) == 0);
      }
  CHECK(adaptive.statistics.adaptive_pixels == 60);
  CHECK(adaptive.statistics.refined_pixels == 20);
  // The look, one more pass of the pixels that tell the scene's mean (all of so small an image), the settled pixels,
  // and the edge's groups.
  CHECK(adaptive.statistics.primary_rays == (2 * 60 + 40) * 16 + 20 * 121);
}

TEST_CASE("S43 adaptive: an edge that a pixel's own samples miss is found by its neighbours'") {
  // 0.02 m of dark in pixel 6: 16 points with a random shift meet it in every third line or so.
  auto simulation = edge_scene(0.02);
  scene::Instrument& camera = simulation.instruments[0];
  camera.lines = 40;
  simulation.tolerance = 1e-4;
  camera.standard_error = scene::StandardError::bands;
  const auto first = first_pass(simulation);
  const auto adaptive = test::render_image(simulation, sky_table());
  int met = 0, anew = 0, by_neighbours = 0;
  const auto spread = [&](int line) {
    return line >= 0 && line < 40 && first.band_error[static_cast<std::size_t>((line * 12 + 6) * 3)] > 1e-2;
  };
  for (int line = 0; line < 40; ++line) {
    for (int pixel = 0; pixel < 12; ++pixel)
      if (pixel != 6) CHECK(first.band_error[static_cast<std::size_t>((line * 12 + pixel) * 3)] < 1e-4);
    const bool expected = spread(line - 1) || spread(line) || spread(line + 1);
    // With all samples, none of the 11 columns lies within 0.02 m of the pixel's side: it is light; of the first pass,
    // it has a spread or it is light too.
    const bool refined = adaptive.band_error[static_cast<std::size_t>((line * 12 + 6) * 3)] !=
                         first.band_error[static_cast<std::size_t>((line * 12 + 6) * 3)];
    if (spread(line)) CHECK(refined);
    met += spread(line), anew += expected, by_neighbours += expected && !spread(line);
  }
  CHECK(met >= 5);
  CHECK(by_neighbours >= 5);
  CHECK(adaptive.statistics.refined_pixels == static_cast<std::uint64_t>(4 * anew));
}

TEST_CASE("S43 S60 adaptive: the same bits for any tiles, threads, memory and row capacity, standard errors included") {
  auto simulation = stripes_scene(22, 9);
  scene::Instrument& camera = simulation.instruments[0];
  camera.ifov_across_rad *= 1.9;  // past the stripes: pixels that see nothing settle
  camera.first_samples = 9;
  simulation.sky_directions = 4;
  const auto base = test::render_image(simulation, sky_table());
  CHECK(base.statistics.refined_pixels > 0);
  CHECK(base.statistics.refined_pixels < base.statistics.adaptive_pixels);
  REQUIRE(base.band_error.size() == base.radiance.size());
  std::vector<render::RenderOptions> variants(6);
  variants[0].tile_lines = 1, variants[1].tile_lines = 2, variants[2].tile_lines = 4, variants[3].threads = 1;
  variants[4].row_capacity = 1;
  variants[5].memory_bytes = 250 << 10;  // parts of a line
  for (std::size_t i = 0; i < variants.size(); ++i) {
    INFO(i);
    const auto other = test::render_image(simulation, sky_table(), variants[i]);
    if (i == 5) CHECK(other.statistics.tile_columns < camera.pixels);
    CHECK(same_bytes(base.radiance, other.radiance));
    CHECK(same_bytes(base.truth, other.truth));
    CHECK(same_bytes(base.band_error, other.band_error));
  }
}

TEST_CASE("S43 standard error: stripes finer than the cells follow Student's distribution, in one chunk and in two") {
  for (const int side : {8, 40}) {  // 64 samples; 1600 in chunks of 1000
    auto simulation = stripes_scene(side == 8 ? 64 : 16, side == 8 ? 64 : 12);
    scene::Instrument& camera = simulation.instruments[0];
    camera.samples_u = camera.samples_v = side;
    const auto image = test::render_image(simulation, sky_table());
    const double middle = kSky * (kDark + kLight) / 2, sigma = kSky * (kLight - kDark) / 2 / side;
    const std::size_t pixels = static_cast<std::size_t>(image.lines) * static_cast<std::size_t>(image.pixels);
    double square = 0, stated = 0;
    int inside = 0;
    for (std::size_t p = 0; p < pixels; ++p) {
      const double error = image.radiance[3 * p] - middle, se = image.band_error[3 * p];
      square += error * error, stated += se * se;
      inside += std::abs(error) <= 2 * se;
    }
    const double n = static_cast<double>(pixels), share = inside / n;
    MESSAGE(side << " x " << side << ": rms error " << std::sqrt(square / n) / sigma << " sigma, rms standard error "
                 << std::sqrt(stated / n) / sigma << " sigma, within two of its own " << share);
    // Cells of 40 a side hold 2.5 stripes: the share of dark in them is 0.4 or 0.6, which takes a twenty-fifth of the
    // variance away.
    const double expected = side == 8 ? 1 : std::sqrt(0.96);
    // Relative standard deviations: 1 / sqrt(2 n) of the rms error, 1 / sqrt(6 n) of the rms of three degrees of
    // freedom; four of them. Of independent parts 0.85 is stated, for what edges and sky ask for.
    CHECK_WITHIN(std::sqrt(square / n) / sigma / expected - 1, 4 / std::sqrt(2 * n));
    CHECK_WITHIN(std::sqrt(stated / n) / sigma / (0.85 * expected) - 1, 4 / std::sqrt(6 * n));
    // P(|t| <= 2 * 0.85) with 3 degrees of freedom is 0.8123; four standard deviations, and 0.005 for the steps of a
    // mean of 16 draws.
    CHECK_WITHIN(share - 0.8123, 4 * std::sqrt(0.8123 * 0.1877 / n) + 0.005);
  }
}

TEST_CASE(
    "S43 S62 not converged: the layer is the worst band over its mean over the scene, the mask what exceeds the "
    "tolerance") {
  auto simulation = edge_scene(0.3);
  simulation.tolerance = 0.02;
  scene::Instrument& camera = simulation.instruments[0];
  camera.first_samples = 0;
  camera.standard_error = scene::StandardError::bands;
  const auto image = test::render_image(simulation, sky_table());
  REQUIRE(image.layers == render::truth::abundance + 2 + 2);
  double mean[3] = {};
  for (int p = 0; p < 60; ++p)
    for (int b = 0; b < 3; ++b) mean[b] += image.radiance[3 * p + b] / 60.0;
  int open = 0;
  for (int line = 0; line < 5; ++line)
    for (int pixel = 0; pixel < 12; ++pixel) {
      double worst = 0;
      for (int b = 0; b < 3; ++b) worst = std::max(worst, image.band_error[(line * 12 + pixel) * 3 + b] / mean[b]);
      CHECK(image.layer(line, pixel, image.layers - 2) == doctest::Approx(worst).epsilon(1e-5));
      CHECK(image.layer(line, pixel, image.layers - 1) == (worst > 0.02 ? 1 : 0));
      CHECK((pixel == 6) == (worst > 1e-6));
      open += worst > 0.02;
    }
  CHECK(open == 5);
  // By hand: of the columns 0 .. 10 the first three are dark; two of six even ones and one of five odd ones. 0.85 of
  // what four independent parts would say.
  const double whole = 3 / 11.0, even = 2 / 6.0 - whole, odd = 1 / 5.0 - whole;
  const double expected = 0.85 * kSky * (kLight - kDark) * std::sqrt(2 * (even * even + odd * odd) / 12);
  CHECK(image.band_error[(2 * 12 + 6) * 3] == doctest::Approx(expected).epsilon(1e-4));
}

TEST_CASE("S43 standard error: fewer samples than four tell none, and that is not called converged") {
  auto simulation = edge_scene(0.3);
  scene::Instrument& camera = simulation.instruments[0];
  camera.samples_u = 3, camera.samples_v = 1, camera.first_samples = 0;
  camera.standard_error = scene::StandardError::worst;
  const auto image = test::render_image(simulation, sky_table());
  for (int pixel = 0; pixel < 12; ++pixel) {
    CHECK(std::isnan(image.layer(2, pixel, image.layers - 2)));
    CHECK(image.layer(2, pixel, image.layers - 1) == 1);
  }
}
