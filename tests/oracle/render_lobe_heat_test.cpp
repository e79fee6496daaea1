// Thermal light of matter that is not Lambert's (S4.8, S21): by Kirchhoff's law a lobe emits by the angle what it does
// not send back of an even light. Oracles: one temperature everywhere is Planck's law whatever the lobes; integrals of
// the lobes over the parts of the hemisphere; the ground before a hot glossy wall.
#include <doctest/doctest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "atmos_tables/synthetic.h"
#include "host/base/planck.h"
#include "kernels/materials/shapes.h"
#include "scene_compiler/lobe_albedo.h"
#include "scene_compiler/matter.h"
#include "scene_compiler/spectral_shape.h"
#include "tests/support/lit_scenes.h"
#include "tests/support/shape_cases.h"

namespace {

using namespace raycube;
using test::check_mean, test::mean_of;
constexpr double kPi = std::numbers::pi, kFar_m = 2e4;
const std::vector<double> kCenters = {3.8, 8.6, 10.0, 12.1};

double planck(double l, double kelvin) { return base::planck_radiance(l, kelvin); }

scene::Curve level(double value) { return {{2, 15}, {value, value}}; }
scene::Curve falling(double at_2_um, double at_15_um) { return {{2, 15}, {at_2_um, at_15_um}}; }
double at(const scene::Curve& curve, double l) { return scene::value_at(curve, l); }

std::uint32_t warm(scene::CompiledScene& scene, const char* name, double kelvin, scene::Curve reflectance) {
  const auto surface = test::add_material(scene, name, 0.5);
  scene.materials.back().reflectance = std::move(reflectance);
  scene.materials.back().temperature_K = kelvin;
  return surface;
}

scene::Simulation seen_by(const scene::Instrument& camera) {
  scene::Simulation simulation;
  simulation.sun.zenith_deg = 120;
  simulation.sky_directions = 256, simulation.bounces_given = true;
  simulation.instruments = {camera};
  simulation.instruments[0].bands = test::gaussian_bands(kCenters, 0.01);
  simulation.instruments[0].samples_u = simulation.instruments[0].samples_v = 4;
  return simulation;
}

/// By night, under a sky of one temperature, through air that does nothing.
test::Image seen(scene::Simulation& simulation, int levels, double sky_K) {
  simulation.bounces = levels;
  atmos::UniformAir air;
  air.solar_irradiance = [](double) { return 0.0; };
  air.sun_zenith_deg = 120;
  air.thermal_sky_radiance = [=](double l) { return planck(l, sky_K); };
  air.thermal_path_radiance = [](double) { return 0.0; };
  return test::render_image(simulation, atmos::uniform_table(air, atmos::wavelength_grid(3.5, 12.5, 0.002)));
}

/// Gives the materials every kind of lobe that cameras know.
void give_lobes(scene::Material& material, int kind) {
  switch (kind) {
    case 0:
      material.front = {RC_SHAPE_rpv, {0.8, -0.2, 0.5}};
      break;
    case 1:
      material.gloss = {RC_SHAPE_gloss, {0.2, 0.3}};
      break;
    case 2:
      material.front = {RC_SHAPE_oren_nayar, {0.6}};
      material.gloss = {RC_SHAPE_ward, {0.15, 0.3, 0.4, 30}};
      break;
    case 3:
      material.front_nodes = {{8, {RC_SHAPE_rpv, {0.7, -0.25, 0.4}}}, {12, {RC_SHAPE_rpv, {1.1, 0.1, 1.0}}}};
      material.front = material.front_nodes[0].shape;
      material.gloss_nodes = {{4, {RC_SHAPE_gloss, {0.3, 0.1}}}, {12, {RC_SHAPE_gloss, {0.45, 0.4}}}};
      material.gloss = material.gloss_nodes[0].shape;
      break;
    case 4:
      material.front = {RC_SHAPE_hapke, {0.3, 0.2, 10, 1, 0.1}};
      break;
    default:
      material.gloss = {RC_SHAPE_phong, {20, 0.4}};
  }
  if (kind == 4) scene::take_nodes_of_curve(material);
  scene::make_lobes(material);
}

/// Integral of pi f cos / pi over directions `in` for which part(in) holds, for a curve of 1; the surface's normal is
/// `normal`, all in one frame.
double sent(const scene::Shape& shape, const RcLocal& normal, const RcLocal& out,
            const std::function<bool(const RcLocal&)>& part) {
  constexpr int n = 300;
  double sum = 0;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const double z = 2 * (i + 0.5) / n - 1, r = std::sqrt(1 - z * z), turn = 2 * kPi * (j + 0.5) / n;
      const RcLocal in{r * std::cos(turn), r * std::sin(turn), z};
      const double cosine = in.x * normal.x + in.y * normal.y + in.z * normal.z;
      if (cosine > 0 && part(in))
        sum += cosine * rc_shape_eval(shape.number, 1, shape.parameters(), rc_angles(normal, in, out));
    }
  return 4 * kPi * sum / n / n;
}

}  // namespace

TEST_CASE("S16 S4.8 where all is of one temperature, lobes of every kind show Planck's law") {
  const double kelvin = 288.15;
  for (const int levels : {0, 3}) {
    scene::Simulation simulation = seen_by(test::nadir_camera(24, 24, 1000, 1.0));
    auto& scene = simulation.scene;
    std::vector<std::uint32_t> of;
    for (int kind = 0; kind < 6; ++kind) {
      of.push_back(warm(scene, ("m" + std::to_string(kind)).c_str(), kelvin, falling(0.4, 0.2)));
      if (kind == 5)
        scene.materials.back().transmittance = level(0.2), scene.materials.back().behind = {RC_SHAPE_plate};
      if (kind == 1) scene.materials.back().transmittance = level(0.3);  // a leaf with gloss
      give_lobes(scene.materials.back(), kind);
    }
    test::place(scene, test::rectangle({-60, -60, 0}, {120, 0, 0}, {0, 120, 0}, of[0]));
    test::place(scene, test::box({-9, -3, 0}, {-6, 6, 8}, of[2]));
    test::place(scene, test::box({-2, 2, 0}, {3, 3, 5}, of[3]));
    test::place(scene, test::rectangle({2, -8, 0.5}, {6, 0, 3}, {0, 5, 1}, of[1]));
    test::place(scene, test::rectangle({-8, -9, 4}, {6, 0, 1}, {0, 5, 0}, of[5]));
    test::place(scene, test::rectangle({4, 5, 3}, {5, 0, 2}, {0, 5, 0}, of[4]));
    finish_top_tree(scene);
    const auto image = seen(simulation, levels, kelvin);
    CHECK(image.plan.bounces.any() == (levels > 0));
    CHECK(image.plan.matter.further > 0);
    CHECK(!image.plan.thermal.albedo.empty());
    std::vector<double> want;
    for (const double l : kCenters) want.push_back(planck(l, kelvin));
    const double worst = test::worst_relative(image, want);
    MESSAGE("worst pixel " << worst << " with " << levels << " surfaces more");
    CHECK(worst < 1e-4);  // the bands' width: half of B'' (3.8 um) times its square is 5e-5 of B
  }
}

TEST_CASE("S4.8 S21 a tilted warm plane sends by the angle what it does not send back of sky and surroundings") {
  const double sky_K = 240, plane_K = 310, tilt = 50 * kPi / 180;
  const RcLocal normal{-std::sin(tilt), 0, std::cos(tilt)}, up{0, 0, 1};
  const std::vector<scene::Shape> shapes = {{RC_SHAPE_rpv, {0.8, -0.2, 0.5}},
                                            {RC_SHAPE_oren_nayar, {0.6}},
                                            {RC_SHAPE_gloss, {0.2, 0.3}},
                                            {RC_SHAPE_ward, {0.2, 0.6, 0.5, 30}},
                                            {RC_SHAPE_phong, {12, 0.5}}};
  for (const scene::Shape& shape : shapes) {
    const bool gloss = scene::is_gloss(shape);
    scene::Simulation simulation = seen_by(test::nadir_camera(16, 16, 5000, 1.0));
    auto& scene = simulation.scene;
    const scene::Curve front = falling(0.3, 0.1);
    const auto surface = warm(scene, "plane", plane_K, front);
    (gloss ? scene.materials[0].gloss : scene.materials[0].front) = shape;
    test::place(scene,
                test::rectangle({-kFar_m * normal.z, -kFar_m, -kFar_m * std::sin(tilt)},
                                {2 * kFar_m * normal.z, 0, 2 * kFar_m * std::sin(tilt)}, {0, 2 * kFar_m, 0}, surface));
    finish_top_tree(scene);
    simulation.instruments[0].poses[0].z_m = 5000;
    const auto image = seen(simulation, 0, sky_K);
    const auto above = [](const RcLocal& in) { return in.z > 0; };
    const auto below = [](const RcLocal& in) { return in.z <= 0; };
    const double sky = sent(shape, normal, up, above), land = sent(shape, normal, up, below);
    const double open = (1 + normal.z) / 2;  // of Lambert's hemisphere
    CAPTURE(shape.number);
    for (std::size_t b = 0; b < kCenters.size(); ++b) {
      const double l = kCenters[b], r = at(front, l), own = planck(l, plane_K), cold = planck(l, sky_K);
      const double lobe = gloss ? 1 : r;  // whose curve
      double want = (1 - lobe * (sky + land)) * own + lobe * (sky * cold + land * own);
      if (gloss) want += r * (open * cold + (1 - open) * own) - r * own;
      check_mean(mean_of(image, static_cast<int>(b)), want, 1e-3);
    }
  }
}

TEST_CASE("S4.8 S21 a hot glossy wall warms the ground before it by its lobes, along paths") {
  // The sky is as warm as the surroundings, so that the wall's own light alone makes a difference.
  const double ground_K = 290, wall_K = 400, around_K = (ground_K + wall_K) / 2, x_m = 2.5;
  const scene::Shape shape{RC_SHAPE_gloss, {0.3, 0.5}};
  scene::Simulation simulation = seen_by(test::nadir_camera(16, 16, 50, 0.02, x_m, 0));
  auto& scene = simulation.scene;
  const scene::Curve land = falling(0.5, 0.3), front = falling(0.1, 0.2);
  const auto floor = warm(scene, "ground", ground_K, land), side = warm(scene, "wall", wall_K, front);
  scene.materials[1].gloss = shape;
  // Both are of one area, so that the surroundings are half of each.
  test::place(scene, test::rectangle({0, -kFar_m, 0}, {kFar_m, 0, 0}, {0, 2 * kFar_m, 0}, floor));
  test::place(scene, test::rectangle({0, -kFar_m, 0}, {0, 2 * kFar_m, 0}, {0, 0, kFar_m}, side));
  finish_top_tree(scene);
  const auto image = seen(simulation, 1, around_K);
  REQUIRE(image.plan.bounces.any());
  CHECK(image.plan.thermal.surroundings_K == doctest::Approx(around_K));
  // Over the quarter of directions towards the wall: what it does not send back of an even light towards the ground.
  double front_share = 0, gloss_share = 0;
  constexpr int n = 40;
  for (int i = 0; i < n; ++i) {
    const double z = (i + 0.5) / n, r = std::sqrt(1 - z * z);
    for (int j = 0; j < n; ++j) {
      const double turn = kPi * (j + 0.5) / n - kPi / 2;
      const RcLocal out{r * std::cos(turn), r * std::sin(turn), -z};  // from the wall to the ground
      const double weight = z * kPi / n / n / kPi;                    // cos dw / pi
      front_share += weight;
      gloss_share += weight * scene::lobe_albedo(shape, {out.y, -out.z, out.x});
    }
  }
  CHECK(front_share == doctest::Approx(0.5).epsilon(1e-3));
  for (std::size_t b = 0; b < kCenters.size(); ++b) {
    const double l = kCenters[b], around = planck(l, around_K), more = planck(l, wall_K) - around;
    const double sent = (front_share * (1 - at(front, l)) - gloss_share) * more;
    check_mean(mean_of(image, static_cast<int>(b)),
               (1 - at(land, l)) * planck(l, ground_K) + at(land, l) * (around + sent), 1.5e-3);
  }
}
