// S21: pulses on matter that is a sum of lobes: at the laser's wavelength it is one shape. Oracles: what returns from a
// tilted plane on its own way over what a Lambertian one sends, by the closed forms at the laser's own wavelength,
// curve and index; surfaces of two materials; two lines at once; paths that go on.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "host/lidar/pulse_lobes.h"
#include "scene_compiler/fresnel.h"
#include "scene_compiler/spectral_shape.h"
#include "tests/support/lidar_device.h"
#include "tests/support/lidar_kit.h"

using namespace raycube;
using namespace raycube::test;

namespace {

constexpr double kPi = std::numbers::pi, kTilt_rad = 0.6, kLine_um = 1.064;

/// At 0.9 and 1.3 um.
const std::vector<scene::ShapeNode> kFront = {{0.9, {RC_SHAPE_rpv, {0.7, -0.25, 0.4}}},
                                              {1.3, {RC_SHAPE_rpv, {1.1, 0.1, 0.9}}}};
const std::vector<scene::ShapeNode> kGloss = {{0.9, {RC_SHAPE_gloss, {0.3, 0.1}}},
                                              {1.3, {RC_SHAPE_gloss, {0.45, 0.5}}}};

double eval(const scene::Shape& shape, double scale = 1) {
  const RcLocal way{std::sin(kTilt_rad), 0, std::cos(kTilt_rad)};  // of light and of what returns, about the normal
  return rc_shape_eval(shape.number, scale, shape.parameters(), rc_angles({0, 0, 1}, way, way));
}

double between(const std::vector<scene::ShapeNode>& nodes, double um) {
  const double on = (um - nodes[0].wavelength_um) / (nodes[1].wavelength_um - nodes[0].wavelength_um);
  return (1 - on) * eval(nodes[0].shape) + on * eval(nodes[1].shape);
}

scene::CompiledScene tilted(const std::vector<double>& reflectances, std::uint32_t surface = 0) {
  scene::CompiledScene scene = scene_of(reflectances);
  add_plane(scene, surface, {0, 0, 0}, 20, kTilt_rad);
  scene::finish_top_tree(scene);
  return scene;
}

lidar::LidarPlan plan_of(const scene::Lidar& lidar, const scene::CompiledScene& scene) {
  lidar::LidarPlan plan = hand_plan(lidar, scene);
  const auto lines = static_cast<std::size_t>(plan.lines());
  for (std::size_t m = 0; m < scene.materials.size(); ++m)
    for (std::size_t l = 0; l < lines; ++l) plan.matter[m * lines + l] = lidar::matter_at(plan, scene.materials[m], l);
  return plan;
}

/// Photons of a line that return from the plane.
double returned(const scene::Lidar& lidar, const scene::CompiledScene& scene, std::size_t line = 0) {
  const auto shot = shot_from(lidar, {0, 0, 1000}, {0, 0, -1});
  const auto result = render_shots(scene, plan_of(lidar, scene), {shot}).at(0);
  const auto bins =
      static_cast<std::ptrdiff_t>(result.first.size()) / static_cast<std::ptrdiff_t>(lidar.pulse.lines.size());
  const auto first = result.first.begin() + static_cast<std::ptrdiff_t>(line) * bins;
  return total({first, first + bins});
}

/// BRDF of a scene's plane at the line, 1/sr: over that of a white one.
double brdf(const scene::Lidar& lidar, const scene::CompiledScene& scene, std::size_t line = 0) {
  return returned(lidar, scene, line) / returned(lidar, tilted({1.0}), line) / kPi;
}

scene::Lidar two_lines() {
  scene::Lidar lidar = pencil_lidar();
  lidar.pulse.lines.push_back(lidar.pulse.lines.front());
  lidar.pulse.lines[0].wavelength_um = 0.95, lidar.pulse.lines[1].wavelength_um = 1.2;
  return lidar;
}

}  // namespace

TEST_CASE("S21: between the wavelengths of a shape and of a gloss a pulse sees the mean of what they scatter") {
  scene::CompiledScene scene = tilted({0.3});
  scene::Material& material = scene.materials[0];
  material.front = kFront[0].shape, material.front_nodes = kFront;
  make_lobes(material);
  CHECK(brdf(pencil_lidar(), scene) == doctest::Approx(0.3 * between(kFront, kLine_um)).epsilon(1e-5));
  material.gloss = kGloss[0].shape, material.gloss_nodes = kGloss;
  make_lobes(material);
  CHECK(brdf(pencil_lidar(), scene) ==
        doctest::Approx(0.3 * between(kFront, kLine_um) + between(kGloss, kLine_um)).epsilon(1e-5));
}

TEST_CASE("S21: each of two lines sees the shape of its own wavelength") {
  scene::CompiledScene scene = tilted({0.3});
  scene::Material& material = scene.materials[0];
  material.front = kFront[0].shape, material.front_nodes = kFront;
  material.gloss = kGloss[0].shape, material.gloss_nodes = kGloss;
  make_lobes(material);
  const scene::Lidar lidar = two_lines();
  for (const std::size_t line : {0u, 1u}) {
    const double um = lidar.pulse.lines[line].wavelength_um;
    CHECK(brdf(lidar, scene, line) == doctest::Approx(0.3 * between(kFront, um) + between(kGloss, um)).epsilon(1e-5));
  }
}

TEST_CASE("S21: of two materials in one surface each counts by its share and its reflectance") {
  scene::CompiledScene scene = scene_of({0.2, 0.6});
  for (scene::Material& material : scene.materials) {
    material.front = kFront[0].shape, material.front_nodes = kFront;
    make_lobes(material);
  }
  shared::Surface mixed{};
  mixed.material[0] = 1, mixed.material[1] = 2, mixed.fraction[0] = 0.25f, mixed.fraction[1] = 0.75f;
  scene.surfaces.push_back(mixed);
  add_plane(scene, 2, {0, 0, 0}, 20, kTilt_rad);
  scene::finish_top_tree(scene);
  CHECK(brdf(pencil_lidar(), scene) ==
        doctest::Approx((0.25 * 0.2 + 0.75 * 0.6) * between(kFront, kLine_um)).epsilon(1e-5));
}

TEST_CASE("S21: Hapke's ground at the curve's value, and a metal by Fresnel's law, at the laser's wavelength") {
  scene::CompiledScene scene = tilted({0.5});
  scene::Material& soil = scene.materials[0];
  soil.reflectance = {{0.8, 1.2}, {0.4, 0.9}};
  soil.front = {RC_SHAPE_hapke, {0.3, 0.2, 15, 0.6, 0.08}};
  take_nodes_of_curve(soil);
  make_lobes(soil);
  const double w = 0.4 + 0.5 * (kLine_um - 0.8) / 0.4, gamma = std::sqrt(1 - w);
  const double expected = eval({RC_SHAPE_hapke, {0.3, 0.2, 15, 0.6, 0.08, w}}, (1 - gamma) / (1 + gamma));
  CHECK(brdf(pencil_lidar(), scene) == doctest::Approx(expected).epsilon(6e-4));  // what lies between nodes: 5e-4

  scene = tilted({0.01});
  scene::Material& metal = scene.materials[0];
  metal.index_n = {{0.8, 1.4}, {0.2, 0.4}}, metal.index_k = {{0.8, 1.4}, {5, 9}};
  metal.gloss = {RC_SHAPE_gloss, {0.4, 1, 1}};
  make_lobes(metal);
  const double on = (kLine_um - 0.8) / 0.6;  // on its own way light meets facets upright: F0, linear as the curve is
  const double mirrored = (1 - on) * scene::fresnel_mirrored(0.2, 5, 1) + on * scene::fresnel_mirrored(0.4, 9, 1);
  CHECK(brdf(pencil_lidar(), scene) ==
        doctest::Approx(0.01 / kPi + mirrored * eval({RC_SHAPE_gloss, {0.4, 1, 0}})).epsilon(1e-5));
}

TEST_CASE("S21: nodes that are all alike send paths on as one shape does") {
  for (const bool nodes : {false, true}) {
    static double once = 0;
    scene::CompiledScene scene = scene_of({0.5, 0.6});
    for (scene::Material& material : scene.materials) {
      material.front = {RC_SHAPE_rpv, {0.8, -0.1, 0.9}};
      if (nodes) material.front_nodes = {{0.9, material.front}, {1.0, material.front}, {1.2, material.front}};
      make_lobes(material);
    }
    add_corner(scene, 0, 1, 4, 4, 4);
    scene::finish_top_tree(scene);
    scene::Lidar lidar = topographic_lidar();
    lidar.transport.max_bounces = 4, lidar.transport.subrays = 4096;
    lidar.pulse.half_divergence_rad = 1e-3;
    const auto shot =
        shot_from(lidar, {1000 * std::sin(0.6) + 1, 0, 1000 * std::cos(0.6)}, {-std::sin(0.6), 0, -std::cos(0.6)});
    const auto result = render_shots(scene, plan_of(lidar, scene), {shot}).at(0);
    const double more = total(result.multiple);
    CHECK(more > 0);
    if (!nodes) once = more;
    CHECK(more == doctest::Approx(once).epsilon(1e-5));  // the same draws
  }
}

namespace {

/// Share of light that plate A, z = 0, sends on its way at (2, 0, 0) to plate B, x = 0, whose Lambertian surface sends
/// it to a receiver far away, over what a white surface there sends that faces it: by the midpoint rule over B.
template <class Form>
double by_way_of(Form&& form, const RcLocal& in, double reflectance_b, double range_m) {
  constexpr int kSteps = 400;
  constexpr double kSize_m = 4, kFrom_m = 2;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i)
    for (int j = 0; j < kSteps; ++j) {
      const double y = kSize_m * (2 * (j + 0.5) / kSteps - 1), z = kSize_m * (i + 0.5) / kSteps;
      const double d2 = kFrom_m * kFrom_m + y * y + z * z, d = std::sqrt(d2);
      const RcLocal out{-kFrom_m / d, y / d, z / d};
      const double area = 2 * kSize_m * kSize_m / kSteps / kSteps, solid_angle = area * (kFrom_m / d) / d2;
      const double x = range_m * in.x + kFrom_m, away = std::sqrt(x * x + y * y + std::pow(range_m * in.z - z, 2));
      sum += form(in, out) * out.z * solid_angle * reflectance_b * (x / away) * std::pow(range_m / away, 2);
    }
  return sum;
}

/// Of all shots.
double result_collected(const std::vector<lidar::ShotResult>& results) {
  double sum = 0;
  for (const auto& result : results) sum += result.ledger[0].collected;
  return sum;
}

}  // namespace

TEST_CASE("S21: pulses go on by a gloss: what a second surface returns is the integral over the lobe") {
  const RcLocal in{std::sin(0.8), 0, std::cos(0.8)};
  const auto white = [](double exponent, double reflectance, const RcLocal& a, const RcLocal& b) {
    const double mirrored = a.z * b.z - a.x * b.x - a.y * b.y;
    return mirrored > 0 ? reflectance * (exponent + 2) / (2 * kPi) * std::pow(mirrored, exponent) : 0;
  };
  struct One {
    scene::Shape gloss;
    double expected;
  };
  const auto ggx = [](const RcLocal& a, const RcLocal& b) {
    return rc_shape_eval(RC_SHAPE_gloss, 1, {{0.4, 0.5}, nullptr}, rc_angles({0, 0, 1}, a, b));
  };
  const auto phong = [&](const RcLocal& a, const RcLocal& b) { return white(12, 0.6, a, b); };
  // All but a mirror: Schlick's share of 0.5 at normal incidence, seen where the one mirrored way meets B.
  const double schlick = 0.5 + 0.5 * std::pow(1 - in.z, 5), x = 1000 * in.x + 2, z = 1000 * in.z - 2 * in.z / in.x;
  const double away = std::sqrt(x * x + z * z), mirror = schlick * 0.7 * (x / away) * std::pow(1000 / away, 2);
  for (const One& one :
       {One{{RC_SHAPE_gloss, {0.4, 0.5}}, by_way_of(ggx, in, 0.7, 1000)}, One{{RC_SHAPE_gloss, {1e-4, 0.5}}, mirror},
        One{{RC_SHAPE_phong, {12, 0.6}}, by_way_of(phong, in, 0.7, 1000)}}) {
    scene::CompiledScene scene = scene_of({0.0, 0.7});
    scene.materials[0].gloss = one.gloss;
    add_corner(scene, 0, 1, 4, 4, 4);
    scene::finish_top_tree(scene);
    scene::Lidar lidar = topographic_lidar();
    lidar.pulse.half_divergence_rad = 1e-9;
    lidar.transport.max_bounces = 2, lidar.transport.subrays = 16384;
    const lidar::Vec3 at{1000 * in.x + 2, 0, 1000 * in.z};
    std::vector<lidar::Shot> shots;
    for (int pulse = 0; pulse < 16; ++pulse) shots.push_back(shot_from(lidar, at, {-in.x, 0, -in.z}, pulse));
    const auto results = render_shots(scene, plan_of(lidar, scene), shots);
    double more = 0;
    for (const auto& result : results) {
      more += total(result.multiple) / static_cast<double>(results.size());
      CHECK(std::abs(result.ledger[0].emitted_error()) <= 1e-6);
    }
    scene::CompiledScene facing = scene_of({1.0});
    add_plane(facing, 0, {2, 0, 0}, 20, 0.8);
    scene::finish_top_tree(facing);
    const auto direct = render_shots(facing, plan_of(lidar, facing), {shots[0]}).at(0);
    CAPTURE(one.expected);
    CHECK(std::isfinite(result_collected(results)));
    // 262144 paths whose weights spread by about 1.5 of their mean, which half of them reach: 4.5 of 0.4 %.
    CHECK(more / total(direct.first) == doctest::Approx(one.expected).epsilon(0.02));
  }
}

TEST_CASE("S21: mixed materials of different gloss that changes are refused, of plain gloss they are not") {
  for (const bool changing : {false, true}) {
    scene::CompiledScene scene = scene_of({0.2, 0.3});
    scene.materials[0].gloss = kGloss[0].shape, scene.materials[1].gloss = {RC_SHAPE_phong, {12, 0.2}};
    if (changing) scene.materials[0].gloss_nodes = kGloss;
    make_lobes(scene.materials[0]);
    shared::Surface mixed{};
    mixed.material[0] = 1, mixed.material[1] = 2, mixed.fraction[0] = mixed.fraction[1] = 0.5f;
    scene.surfaces.push_back(mixed);
    add_plane(scene, 2, {0, 0, 0}, 20, kTilt_rad);
    scene::finish_top_tree(scene);
    if (changing) {
      CHECK(scene::gloss_clash(scene).other == &scene.materials[1]);
      continue;
    }
    const double expected = 0.5 * (0.2 + 0.3) / kPi + 0.5 * (eval(kGloss[0].shape) + eval(scene.materials[1].gloss));
    CHECK(brdf(pencil_lidar(), scene) == doctest::Approx(expected).epsilon(1e-5));
  }
}
