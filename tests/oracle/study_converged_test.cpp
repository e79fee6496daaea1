// The converged reference against closed forms: half a pixel dark, and a wall's view factor, within what it says of
// itself.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "atmos_tables/synthetic.h"
#include "host/sensors/view_bounds.h"
#include "host/study/converged.h"
#include "tests/support/chance_checks.h"
#include "tests/support/render_kit.h"

using namespace raycube;
using doctest::Approx;

namespace {

constexpr double kPi = std::numbers::pi;

study::Converged converge(const scene::Simulation& s, const atmos::RenderTable& table,
                          const study::ConvergedSettings& settings) {
  const scene::Instrument& camera = s.instruments[0];
  const plan::Plan plan = plan::make_plan(s, camera, table, sensors::view_bounds(camera));
  return study::converge(s, camera, plan, table, {{0, 1, 0, camera.pixels}}, settings);
}

const std::vector<double> kGrid = {0.45, 0.5, 0.55, 0.6, 0.65, 0.7, 0.75, 0.8, 0.85, 0.9, 0.95};

}  // namespace

TEST_CASE(
    "S64 converged: a slanted edge through a row of pixels, sun alone: each within 4 of its own standard errors of its "
    "share") {
  scene::Simulation s;
  const auto black = test::add_material(s.scene, "black", 0), white = test::add_material(s.scene, "white", 0.5);
  test::place(s.scene, test::rectangle({-300, -300, 0}, {600, 0, 0}, {0, 600, 0}, black));
  // White where y < 0.05 x, 1 cm above: its parallax is 1e-5 of the height, 1 cm at most.
  test::place(s.scene, test::rectangle({-300, -315, 0.01}, {600, 30, 0}, {0, 300, 0}, white));
  scene::finish_top_tree(s.scene);
  s.sun.zenith_deg = 0, s.seed = testing::seed(s.seed);
  s.instruments = {test::nadir_camera(16, 1, 1000, 1)};
  const atmos::RenderTable table = atmos::uniform_sky_table(1000, 0, kGrid);
  study::ConvergedSettings settings;
  settings.grid = 22, settings.directions = 16, settings.per_sample = 1;
  const double full = 0.5 / kPi * 1000;
  double all = 0;
  constexpr int kSeeds = 4;
  for (int k = 0; k < kSeeds; ++k, ++s.seed) {
    const study::Converged found = converge(s, table, settings);
    REQUIRE(found.pixels() == 16);
    double own = 0, off = 0;
    for (std::size_t p = 0; p < 16; ++p) {
      const double x = static_cast<double>(p) - 7.5, share = 0.5 + 0.05 * x;  // of a pixel from -0.5 to 0.5 across
      own += std::pow(found.half[p * 3] / full, 2) / 16;
      off += std::pow(found.radiance[p * 3] / full - share, 2) / 16;
    }
    CHECK_BELOW(std::sqrt(off), 4 * std::sqrt(own));
    CHECK(study::own_error(found) == Approx(std::sqrt(own) / 0.5).epsilon(0.02));  // the row's mean is half of full
    all += own / kSeeds;
  }
  // 22 of 484 cells lie on the edge; a point in one is white with a probability p anywhere in 0 .. 1, p (1 - p) is 1/6
  // in the mean; two halves: sqrt(22 / 6 / 2) / 484 = 0.0028, known from sixteen pixels of four seeds to 9 %.
  CHECK_WITHIN(std::sqrt(all) / 0.0028 - 1, 0.45);
}

TEST_CASE("S16 S64 converged: sky directions spread over samples see what a wall hides as its view factor has it") {
  scene::Simulation s;
  const auto grey = test::add_material(s.scene, "grey", 0.5);
  test::place(s.scene, test::rectangle({-400, -400, 0}, {800, 0, 0}, {0, 800, 0}, grey));
  const double a = 8, b = 150, c = 4;  // wall of height a and half length b, c away
  test::place(s.scene, test::rectangle({-b, c, 0}, {2 * b, 0, 0}, {0, 0, a}, grey));
  scene::finish_top_tree(s.scene);
  s.sun.zenith_deg = 100;  // no sun
  s.instruments = {test::nadir_camera(4, 1, 1000, 0.01)};
  const atmos::RenderTable table = atmos::uniform_sky_table(0, 30, kGrid, 100);
  const study::Converged found = converge(s, table, {});
  const double reach = std::sqrt(a * a + c * c),
               wall = 2 * (std::atan(b / c) - c / reach * std::atan(b / reach)) / (2 * kPi);
  // The spiral's own error at a horizon and at an edge: 1024^-3/4 of the hemisphere each, see table_model_test.
  for (std::size_t p = 0; p < 4; ++p) CHECK(found.radiance[p * 3] == Approx(0.5 * 30 * (1 - wall)).epsilon(5e-3));
}
