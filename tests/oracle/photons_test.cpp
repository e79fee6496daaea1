// Photons (LIGHT 5) against closed forms: a leaf spread over wide ground, levels on, between and above the two, and
// rough ground, whose albedo under a direction is another code's quadrature of its own shape.
#include <doctest/doctest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "host/plan/bounces.h"
#include "host/plan/curve.h"
#include "host/render/photons.h"
#include "host/run/photon_ledger.h"
#include "kernels/materials/shapes.h"
#include "scene_compiler/lobe_albedo.h"
#include "scene_compiler/matter.h"
#include "scene_compiler/spectral_shape.h"
#include "tests/support/chance_checks.h"
#include "tests/support/render_kit.h"

namespace {

using namespace raycube;

const std::vector<double> kAt_um = {0.5, 0.8};
constexpr int kPhotons = 4000, kBatches = 64;  // of fewer batches the error itself is known too badly

scene::Curve curve(double first, double second) { return {kAt_um, {first, second}}; }

scene::TriangleMesh wide(double z_m, std::uint32_t surface) {
  return test::rectangle({-5e4, -5e4, z_m}, {1e5, 0, 0}, {0, 1e5, 0}, surface);
}

/// What became of photons: means and standard errors of a ledger's numbers.
struct Followed {
  std::vector<run::PhotonLedger> batch;

  void check(double want, const std::function<double(const run::PhotonLedger&)>& of) const {
    double sum = 0, square = 0;
    for (const run::PhotonLedger& one : batch) {
      const double share = of(one) / kPhotons;
      sum += share, square += share * share;
    }
    const double mean = sum / kBatches,
                 error = std::sqrt(std::max(0.0, square / kBatches - mean * mean) / (kBatches - 1));
    CAPTURE(mean);
    CAPTURE(error);
    CAPTURE(want);
    CHECK_WITHIN(mean - want, 4.5 * error + 1e-5);
    CHECK_BELOW(error, 0.004);
  }
};

/// Photons that fall at this angle from the west.
Followed follow(const scene::CompiledScene& compiled, double zenith_deg, const std::vector<double>& levels_m) {
  const std::vector<float> curves = plan::sampled_curves(compiled, kAt_um);
  run::PhotonScene scene{compiled, kAt_um.size(), {}, scene::named_count(compiled), {}, {}, levels_m, false, false};
  scene.changing = scene::most_further(compiled) > 0;
  const auto lobes = scene::surface_lobes(compiled);
  const std::size_t records = scene::lobe_records(compiled);
  for (std::size_t m = 0; m < compiled.materials.size(); ++m) {
    const scene::Material& material = compiled.materials[m];
    const auto through = material.transmittance.value;
    const double gloss = material.gloss.number == RC_SHAPE_none ? 0 : 1;
    scene.material.push_back({material.reflectance.value,
                              through.empty() ? run::Spectrum{0, 0} : through,
                              run::Spectrum{gloss, gloss},
                              static_cast<std::uint32_t>(m),
                              material.name == "ground",
                              {},
                              {}});
    for (const auto& part : scene::front_parts(material))
      scene.material.back().front_lobes.push_back({part.shape, plan::sample_curve(material, part.curve, kAt_um)});
    for (const auto& part : scene::gloss_parts(material))
      scene.material.back().gloss_lobes.push_back({part.shape, plan::sample_curve(material, part.curve, kAt_um)});
  }
  for (std::size_t s = 0; s < compiled.surfaces.size(); ++s)
    scene.shaped.push_back(lobes[s * records].shape != RC_SHAPE_lambert || lobes[s * records + 1].share > 0);
  render::PhotonTracer tracer(compiled, {}, plan::surface_scattering(compiled, curves, kAt_um.size()));
  std::mt19937 places(testing::seed32(7));
  std::uniform_real_distribution<float> within(-50, 50);
  const float down = std::cos(static_cast<float>(zenith_deg * std::numbers::pi / 180)),
              east = std::sqrt(1 - down * down);
  Followed out;
  for (std::uint32_t batch = 0; batch < kBatches; ++batch) {
    run::PhotonCount count(scene, false);
    std::vector<shared::Photon> photons(kPhotons);
    for (std::uint32_t i = 0; i < kPhotons; ++i) {
      photons[i].origin = {within(places), within(places), compiled.hi[2] + 1, 1};
      photons[i].way = {east, 0, -down, 0};
      photons[i].number = i;
    }
    count.start(kPhotons);
    for (std::uint32_t level = 1; level <= 1000 && !photons.empty(); ++level) {
      count.set_off(photons);
      tracer.step(photons, level, testing::seed32(batch + 1));
      count.step(photons, level == 1);
    }
    CHECK(photons.empty());
    out.batch.push_back(count.ledger);
  }
  return out;
}

}  // namespace

TEST_CASE("S23 S24 LIGHT 5: photons between a leaf or a plate and the ground are a series at every wavelength") {
  for (const std::uint32_t behind : {RC_SHAPE_leaf, RC_SHAPE_plate}) {
    CAPTURE(behind);
    scene::CompiledScene scene;
    const auto leaf = test::add_material(scene, "leaf", 0), soil = test::add_material(scene, "ground", 0);
    scene.materials[0].behind = {behind};
    scene.materials[0].reflectance = curve(0.1, 0.5), scene.materials[0].transmittance = curve(0.05, 0.4);
    scene.materials[1].reflectance = curve(0.4, 0.3);
    test::place(scene, wide(2, leaf));
    test::place(scene, wide(0, soil));
    scene::finish_top_tree(scene);
    const Followed found = follow(scene, 40, {0, 1, 2, 5});
    const double r[] = {0.1, 0.5}, t[] = {0.05, 0.4}, ground[] = {0.4, 0.3};
    for (std::size_t i = 0; i < 2; ++i) {
      CAPTURE(i);
      const double down = t[i] / (1 - ground[i] * r[i]), up = ground[i] * down;
      using Ledger = const run::PhotonLedger&;
      found.check(r[i] + t[i] * up, [&](Ledger l) { return l.reflected[i]; });
      found.check((1 - r[i] - t[i]) * (1 + up), [&](Ledger l) { return l.absorbed[0][i]; });
      found.check((1 - ground[i]) * down, [&](Ledger l) { return l.absorbed[1][i]; });
      found.check(1 + up, [&](Ledger l) { return l.arrived[0][i]; });
      found.check(down, [&](Ledger l) { return l.ground[i]; });
      found.check(0, [&](Ledger l) { return l.ground_first[i]; });
      for (const std::size_t level : {0u, 1u}) {  // on the ground: just above it
        found.check(down, [&](Ledger l) { return l.down[level][i]; });
        found.check(up, [&](Ledger l) { return l.up[level][i]; });
      }
      for (const std::size_t level : {2u, 3u}) {  // on the leaf, and above all
        found.check(1, [&](Ledger l) { return l.down[level][i]; });
        found.check(r[i] + t[i] * up, [&](Ledger l) { return l.up[level][i]; });
      }
    }
  }
}

TEST_CASE("S23 LIGHT 5: through a plate light goes straight on, and falls onto the ground where it would have") {
  // A strip of dark ground, 10 m wide, lies where light through the pane falls at 60 degrees: all of it meets that.
  scene::CompiledScene scene;
  const auto pane = test::add_material(scene, "pane", 0), strip = test::add_material(scene, "ground", 0),
             rest = test::add_material(scene, "rest", 0);
  scene.materials[0].reflectance = curve(0, 0), scene.materials[0].transmittance = curve(0.9, 0.5);
  scene.materials[0].behind = {RC_SHAPE_plate};
  scene.materials[1].reflectance = scene.materials[2].reflectance = curve(0, 0);
  const double east = 200 * std::tan(60 * std::numbers::pi / 180);
  test::place(scene, wide(200, pane));
  test::place(scene, test::rectangle({east - 60, -60, 1}, {120, 0, 0}, {0, 120, 0}, strip));
  test::place(scene, wide(0, rest));
  scene::finish_top_tree(scene);
  const Followed found = follow(scene, 60, {});
  for (std::size_t i = 0; i < 2; ++i)
    found.check(i == 0 ? 0.9 : 0.5, [&](const run::PhotonLedger& l) { return l.absorbed[1][i]; });
}

TEST_CASE("S21 LIGHT 5: glossy ground keeps what neither its front nor its gloss sends") {
  for (const scene::Shape& gloss : {scene::Shape{RC_SHAPE_gloss, {0.2, 0.1}}, {RC_SHAPE_ward, {0.2, 0.5, 0.4, 30}}})
    for (const double zenith_deg : {20.0, 75.0}) {
      scene::CompiledScene scene;
      const auto soil = test::add_material(scene, "ground", 0);
      scene.materials[0].reflectance = curve(0.2, 0.4), scene.materials[0].gloss = gloss;
      test::place(scene, wide(0, soil));
      scene::finish_top_tree(scene);
      const double zenith = zenith_deg * std::numbers::pi / 180;
      const double mirrored = scene::lobe_albedo(gloss, {-std::sin(zenith), 0, std::cos(zenith)});
      const Followed found = follow(scene, zenith_deg, {});
      for (std::size_t i = 0; i < 2; ++i) {
        using Ledger = const run::PhotonLedger&;
        found.check((i == 0 ? 0.2 : 0.4) + mirrored, [&](Ledger l) { return l.reflected[i]; });
        found.check(1 - (i == 0 ? 0.2 : 0.4) - mirrored, [&](Ledger l) { return l.absorbed[0][i]; });
      }
    }
}

TEST_CASE("S21 LIGHT 5: rough ground keeps what its shape does not send") {
  scene::CompiledScene scene;
  const auto soil = test::add_material(scene, "ground", 0);
  scene.materials[0].reflectance = curve(0.2, 0.6);
  scene.materials[0].front = {RC_SHAPE_oren_nayar, {0.7, 0}};
  test::place(scene, wide(0, soil));
  scene::finish_top_tree(scene);
  const Followed found = follow(scene, 75, {});
  const double zenith = 75 * std::numbers::pi / 180;
  const RcLocal normal{0, 0, 1}, in{-std::sin(zenith), 0, std::cos(zenith)};
  double sent = 0;
  constexpr int kSteps = 400;
  for (int a = 0; a < kSteps; ++a)
    for (int b = 0; b < kSteps; ++b) {
      const double up = std::sqrt((a + 0.5) / kSteps), turn = 2 * std::numbers::pi * (b + 0.5) / kSteps,
                   flat = std::sqrt(1 - up * up);
      const RcLocal out{flat * std::cos(turn), flat * std::sin(turn), up};
      sent += rc_shape_eval(RC_SHAPE_oren_nayar, std::numbers::pi, {{0.7}, nullptr}, rc_angles(normal, in, out)) /
              (kSteps * kSteps);
    }
  for (std::size_t i = 0; i < 2; ++i) {
    const double albedo = (i == 0 ? 0.2 : 0.6) * sent;
    using Ledger = const run::PhotonLedger&;
    found.check(albedo, [&](Ledger l) { return l.reflected[i]; });
    found.check(1 - albedo, [&](Ledger l) { return l.absorbed[0][i]; });
  }
}

TEST_CASE("S21 LIGHT 5: on a tilted plane of shapes that change with wavelength each wavelength keeps by its own") {
  const std::vector<scene::ShapeNode> front = {{0.5, {RC_SHAPE_rpv, {0.8, -0.2, 0.5}}},
                                               {0.8, {RC_SHAPE_rpv, {1.1, 0.1, 1.0}}}};
  const std::vector<scene::ShapeNode> gloss = {{0.5, {RC_SHAPE_gloss, {0.25, 0.1}}},
                                               {0.8, {RC_SHAPE_gloss, {0.4, 0.3}}}};
  scene::CompiledScene scene;
  const auto soil = test::add_material(scene, "ground", 0);
  scene::Material& material = scene.materials[0];
  material.reflectance = curve(0.2, 0.4);
  material.front = front[0].shape, material.front_nodes = front;
  material.gloss = gloss[0].shape, material.gloss_nodes = gloss;
  scene::make_lobes(material);
  // Rises towards the east by 25 degrees: light that comes down at 60 from the west falls onto it at 35.
  const double tilt = 25 * std::numbers::pi / 180;
  test::place(scene, test::rectangle({-5e4 * std::cos(tilt), -5e4, -5e4 * std::sin(tilt)},
                                     {1e5 * std::cos(tilt), 0, 1e5 * std::sin(tilt)}, {0, 1e5, 0}, soil));
  scene::finish_top_tree(scene);
  const Followed found = follow(scene, 60, {});
  const double zenith = 35 * std::numbers::pi / 180;
  const RcLocal in{-std::sin(zenith), 0, std::cos(zenith)};
  for (std::size_t i = 0; i < 2; ++i) {
    const double sent =
        (i == 0 ? 0.2 : 0.4) * scene::lobe_albedo(front[i].shape, in) + scene::lobe_albedo(gloss[i].shape, in);
    found.check(1 - sent, [&](const run::PhotonLedger& l) { return l.absorbed[0][i]; });
  }
}
