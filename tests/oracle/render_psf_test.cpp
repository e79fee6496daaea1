// A straight edge between two fabrics seen through a point spread (S48, S58): the pixel values across it are the
// integral of the detector's box convolved with the optics' Gaussian, cut to the sampled square. Oracle: that integral
// by Simpson's rule in double. The edge lies on cell borders of the sampler, so that no sampling error remains;
// tolerance 1e-6: fp32 sums of 1600 weights.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "atmos_tables/synthetic.h"
#include "host/render/truth.h"
#include "tests/support/render_kit.h"

namespace {

using namespace raycube;
constexpr double kDark = 0.1, kLight = 0.8, kSky = 40;

/// Response of a pixel to what lies left of x (pixels from its centre): box of 1 convolved with a Gaussian, from
/// `from`.
double response(double from, double x, double sigma) {
  const auto normal = [&](double t) { return 0.5 * std::erfc(-t / (sigma * std::sqrt(2.0))); };
  const auto density = [&](double t) { return normal(t + 0.5) - normal(t - 0.5); };
  constexpr int kSteps = 2000;
  double sum = 0;
  for (int i = 0; i <= kSteps; ++i)
    sum += density(from + (x - from) * i / kSteps) * (i == 0 || i == kSteps ? 1 : i % 2 ? 4 : 2);
  return sum * (x - from) / kSteps / 3;
}

}  // namespace

TEST_CASE(
    "S48 S58 an edge through box and Gaussian equals the integral of the point spread, samples in one chunk and in "
    "two") {
  for (const int samples : {24, 40}) {  // 576, and 1600 in chunks of 1000
    scene::Simulation simulation;
    const auto dark = test::add_material(simulation.scene, "dark", kDark),
               light = test::add_material(simulation.scene, "light", kLight);
    test::place(simulation.scene, test::join({test::rectangle({-50, -50, 0}, {50, 0, 0}, {0, 100, 0}, dark),
                                              test::rectangle({0, -50, 0}, {50, 0, 0}, {0, 100, 0}, light)}));
    finish_top_tree(simulation.scene);
    simulation.sun.zenith_deg = 120;
    simulation.sky_directions = 1;
    auto camera = test::nadir_camera(8, 3, 512, 1.0);  // the edge lies between pixels 3 and 4
    camera.samples_u = camera.samples_v = samples;
    camera.psf_sigma_px = 0.55;
    camera.psf_support_px = 4;
    simulation.instruments = {camera};
    const auto image = test::render_image(simulation, atmos::uniform_sky_table(0, kSky, {0.3, 1.0, 4.0}, 120));
    double worst = 0;
    const double whole = response(-2, 2, camera.psf_sigma_px);
    for (int line = 0; line < 3; ++line)
      for (int pixel = 0; pixel < 8; ++pixel) {
        const double edge = std::clamp(3.5 - pixel, -2.0, 2.0), share = response(-2, edge, camera.psf_sigma_px) / whole;
        worst =
            std::max(worst, std::abs(image.at(line, pixel, 0) / (kSky * (kDark * share + kLight * (1 - share))) - 1));
        CHECK(image.layer(line, pixel, image.layers - 2) == doctest::Approx(share).epsilon(1e-6));
        CHECK(image.layer(line, pixel, render::truth::hit_fraction) == doctest::Approx(1).epsilon(1e-6));
      }
    MESSAGE(samples << " samples a side: worst relative error " << worst);
    CHECK(worst < 1e-6);
  }
}
