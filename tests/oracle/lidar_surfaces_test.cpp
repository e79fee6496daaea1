// LIDAR on the device: receiver sampling, bistatic geometry, gloss, plates and leaves, long ranges, order of triangles.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/lidar_device.h"
#include "tests/support/lidar_kit.h"

using namespace raycube;
using namespace raycube::test;

namespace {

scene::CompiledScene plane(double reflectance, double tilt_rad = 0, double half_m = 20) {
  scene::CompiledScene scene = scene_of({reflectance});
  add_plane(scene, 0, {0, 0, 0}, half_m, tilt_rad);
  scene::finish_top_tree(scene);
  return scene;
}

lidar::ShotResult one(const scene::Lidar& lidar, const scene::CompiledScene& scene, const lidar::Shot& shot) {
  return render_shots(scene, hand_plan(lidar, scene), {shot}).at(0);
}

}  // namespace

TEST_CASE("L-02: DIRSIG's published photons per pixel with its camera, and A / R^2 with ours") {
  const auto scene = plane(0.10, 0, 40);
  scene::Lidar lidar = flash_lidar();
  const auto shot = shot_from(lidar, {0, 0, 2000}, {0, 0, -1});
  const auto aperture = one(lidar, scene, shot);
  lidar.receiver.tangent_aperture = true;
  const auto tangent = one(lidar, scene, shot);
  REQUIRE(aperture.first.size() == 900);
  for (std::size_t pixel = 0; pixel < 9; ++pixel) {
    const auto sum = [&](const lidar::ShotResult& result) {
      return total({result.first.begin() + pixel * 100, result.first.begin() + pixel * 100 + 100});
    };
    CHECK(sum(aperture) == doctest::Approx(7.804369).epsilon(2e-6));
    CHECK(sum(tangent) == doctest::Approx(7.345289).epsilon(2e-6));
    CHECK(sum(tangent) == doctest::Approx(7.34537).epsilon(2e-5));  // as published
  }
}

TEST_CASE("S34: sub-rays into an array and samples of its pixels agree") {
  const auto scene = plane(0.10, 0.2, 40);
  scene::Lidar lidar = flash_lidar();
  lidar.receiver.columns = 4, lidar.receiver.rows = 2;
  lidar.receiver.pixel_pitch_rad = 2e-3;
  lidar.pulse.profile = scene::BeamProfile::gaussian;
  lidar.transport.subrays = 256;
  auto shot = shot_from(lidar, {0, 0, 2000}, {0.001, 0, -1});
  place_pupil(shot, {0.5, 0, 2000}, {0, 0, -1});
  const auto samples = one(lidar, scene, shot);
  lidar.transport.sampling = scene::LidarSampling::transmitter;
  lidar.transport.subrays = 16384;
  const auto rays = one(lidar, scene, shot);
  CHECK(samples.ledger[0].collected == doctest::Approx(rays.ledger[0].collected).epsilon(1e-3));
  for (std::size_t pixel = 0; pixel < 8; ++pixel) {
    const Moments a = moments({samples.first.begin() + pixel * 100, samples.first.begin() + pixel * 100 + 100});
    const Moments b = moments({rays.first.begin() + pixel * 100, rays.first.begin() + pixel * 100 + 100});
    CHECK(a.sum == doctest::Approx(b.sum).epsilon(0.01));  // about 1500 sub-rays a pixel: edges, 3.2
    CHECK(a.mean_bin == doctest::Approx(b.mean_bin).epsilon(0.01));
  }
}

TEST_CASE("L-32: the receiver's cosine counts, not the transmitter's") {
  // Normal towards the receiver, light at 60 degrees; then the other way round.
  const auto scene = plane(0.3);
  scene::Lidar lidar = pencil_lidar();
  lidar.gate = {6600e-9, 1e-9, 200};
  const double whole = total(one(lidar, scene, shot_from(lidar, {0, 0, 1000}, {0, 0, -1})).first);
  const lidar::Vec3 slant{1000 * std::sin(M_PI / 3), 0, 1000 * std::cos(M_PI / 3)}, down{-slant[0], 0, -slant[2]};
  auto shot = shot_from(lidar, slant, down);
  place_pupil(shot, {0, 0, 1000}, {0, 0, -1});
  CHECK(total(one(lidar, scene, shot).first) == doctest::Approx(whole).epsilon(2e-6));
  shot = shot_from(lidar, {0, 0, 1000}, {0, 0, -1});
  place_pupil(shot, slant, down);
  CHECK(total(one(lidar, scene, shot).first) == doctest::Approx(0.5 * whole).epsilon(2e-6));
}

TEST_CASE("S34: a wall between hides a bistatic receiver, a plate dims it") {
  const auto with = [](double transmittance, bool wall) {
    scene::CompiledScene scene = scene_of({0.3, 0.0});
    scene.materials[1].transmittance = {{0.3, 4.0}, {transmittance, transmittance}};
    scene.materials[1].behind.number = RC_SHAPE_plate;
    add_plane(scene, 0, {0, 0, 0}, 20);
    if (wall) add_rectangle(scene, 1, {5, -20, 0.5}, {0, 40, 0}, {0, 0, 20});
    scene::finish_top_tree(scene);
    scene::Lidar lidar = pencil_lidar();
    auto shot = shot_from(lidar, {0, 0, 1000}, {0, 0, -1});
    place_pupil(shot, {500, 0, 866.0254}, {-0.5, 0, -0.8660254});
    return total(one(lidar, scene, shot).first);
  };
  const double open = with(0, false);
  CHECK(open > 0);
  CHECK(with(0, true) == 0);
  CHECK(with(0.4, true) == doctest::Approx(0.4 * open).epsilon(2e-6));
}

TEST_CASE("L-12: gloss at zero phase masks once") {
  for (const auto& [tilt_deg, expected] : {std::pair{0.0, 0.0353678}, {80.0, 0.00675587}}) {
    scene::CompiledScene scene = plane(0.2, tilt_deg * M_PI / 180);
    const double matt = total(one(pencil_lidar(), scene, shot_from(pencil_lidar(), {0, 0, 1000}, {0, 0, -1})).first);
    scene.materials[0].gloss = {RC_SHAPE_gloss, {0.3, 0.04}};
    const double shiny = total(one(pencil_lidar(), scene, shot_from(pencil_lidar(), {0, 0, 1000}, {0, 0, -1})).first);
    CHECK((shiny / matt - 1) * 0.2 / M_PI == doctest::Approx(expected).epsilon(5e-6));  // printed digits
  }
}

TEST_CASE("L-14: plates dim twice and let go on, leaves do not; the return retraces its way") {
  for (const double cover : {0.3, 0.5, 1.0})
    for (const bool plate : {true, false}) {
      scene::CompiledScene scene = scene_of({0.45, 0.20});
      scene.materials[0].transmittance = {{0.3, 4.0}, {0.45, 0.45}};
      scene.materials[0].behind.number = plate ? RC_SHAPE_plate : RC_SHAPE_leaf;
      // Strips that cover a share of the layer, far finer than the footprint.
      const int strips = 400;
      scene::TriangleMesh layer;
      for (int i = 0; i < strips; ++i) {
        const float x = -2 + 4.0f * i / strips, w = static_cast<float>(4.0 * cover / strips);
        const auto base = static_cast<std::uint32_t>(layer.vertices.size());
        layer.vertices.insert(layer.vertices.end(), {{x, -2, 10}, {x + w, -2, 10}, {x + w, 2, 10}, {x, 2, 10}});
        layer.triangles.insert(layer.triangles.end(), {{base, base + 1, base + 2}, {base, base + 2, base + 3}});
      }
      layer.surface.assign(layer.triangles.size(), 0);
      layer.user_face.assign(layer.triangles.size(), 0);
      scene::append_instance(scene, scene::append_mesh(scene, "layer", layer), {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}, 0);
      add_plane(scene, 1, {0, 0, 0}, 5);
      scene::finish_top_tree(scene);
      scene::Lidar lidar = topographic_lidar();
      lidar.transport.subrays = 1024;
      lidar.gate = {6500e-9, 1e-9, 300};
      const auto result = one(lidar, scene, shot_from(lidar, {0, 0, 1000}, {0, 0, -1}));
      const double unit = total(one(pencil_lidar(), plane(1.0), shot_from(lidar, {0, 0, 1000}, {0, 0, -1})).first);
      const double upper = total({result.first.begin(), result.first.begin() + 140}) / unit * std::pow(990.0 / 1000, 2);
      const double ground = total({result.first.begin() + 140, result.first.end()}) / unit;
      const double sampling =
          cover < 1 ? 0.02 : 2e-5;  // strips against 1024 sub-rays: 0.5 / sqrt(1024) of a random cover
      CHECK(std::abs(upper - cover * 0.45) <= sampling);
      CHECK(std::abs(ground - (plate ? (cover * 0.45 * 0.45 + 1 - cover) * 0.20 : (1 - cover) * 0.20)) <=
            sampling * 0.2);
      CHECK(std::abs(result.ledger[0].emitted_error()) <= 1e-6);
    }
}

TEST_CASE("L-29: 400 km away, sub-millimetre slopes of a plane, no staircase") {
  // Slope of 1 mm per 1 m, pulses 0.1 m apart: 0.1 mm steps of range, 0.0067 bins of 0.1 ns.
  scene::CompiledScene scene = scene_of({0.3});
  add_plane(scene, 0, {0, 0, 100}, 30, 1e-3);
  scene::finish_top_tree(scene);
  scene::Lidar lidar = topographic_lidar();
  lidar.pulse.half_divergence_rad = 5e-6;
  lidar.pulse.fwhm_s = 1e-9;
  lidar.gate = {2 * 399900 / kLightSpeed - 10e-9, 0.1e-9, 200};
  std::vector<lidar::Shot> shots;
  for (int i = 0; i < 60; ++i) shots.push_back(shot_from(lidar, {-3 + 0.1 * i, 0.37, 400000}, {0, 0, -1}, i));
  const auto results = render_shots(scene, hand_plan(lidar, scene), shots);
  for (int i = 0; i < 60; ++i) {
    const double range_m = 400000 - (100 - 1e-3 * (-3 + 0.1 * i));  // tan(1e-3) = 1e-3 (1 + 3e-7)
    const double expected = (2 * range_m / kLightSpeed - lidar.gate.start_s) / 0.1e-9;
    const double got = moments(results[static_cast<std::size_t>(i)].first).mean_bin;
    CHECK(std::abs(got - expected) < 2.7e-3);  // 40 um of range; a float of 400 km steps by 31 mm
  }
}

TEST_CASE("L-30: neither the order of triangles nor of sub-rays changes a bin beyond rounding") {
  scene::CompiledScene forward = scene_of({0.3, 0.6, 0.1}), backward = scene_of({0.3, 0.6, 0.1});
  const auto add = [](scene::CompiledScene& scene, int i) {
    add_plane(scene, static_cast<std::uint32_t>(i % 3), {0.1 * i - 0.5, 0.03 * i, 0.7 * i}, 0.15 + 0.2 / (i + 1),
              0.1 * i - 0.4);
  };
  for (int i = 0; i < 10; ++i) add(forward, i);
  for (int i = 9; i >= 0; --i) add(backward, i);
  scene::finish_top_tree(forward);
  scene::finish_top_tree(backward);
  const scene::Lidar lidar = topographic_lidar();
  const auto shot = shot_from(lidar, {0, 0, 1000}, {0, 0, -1});
  const auto a = one(lidar, forward, shot), b = one(lidar, backward, shot);
  lidar::LidarPlan plan = hand_plan(lidar, forward);
  std::reverse(plan.footprint.a.begin(), plan.footprint.a.end());
  std::reverse(plan.footprint.b.begin(), plan.footprint.b.end());
  const auto c = render_shots(forward, plan, {shot}).at(0);
  const double peak = *std::max_element(a.first.begin(), a.first.end());
  CHECK(peak > 0);
  CHECK(a.first == b.first);
  for (std::size_t i = 0; i < a.first.size(); ++i)
    CHECK(std::abs(a.first[i] - c.first[i]) <= 256 * 6e-8 * peak);  // sums of at most 256 terms
}

TEST_CASE("I2: a split triangle changes nothing beyond rounding") {
  scene::CompiledScene whole = plane(0.3, 0.3), split = scene_of({0.3});
  const double c = std::cos(0.3), s = std::sin(0.3);
  for (int i = 0; i < 8; ++i)
    for (int j = 0; j < 8; ++j)
      add_rectangle(split, 0, {(-20 + 5 * i) * c, -20.0 + 5 * j, -(-20 + 5 * i) * s}, {5 * c, 0, -5 * s}, {0, 5, 0});
  scene::finish_top_tree(split);
  const scene::Lidar lidar = topographic_lidar();
  const auto shot = shot_from(lidar, {0.3, 0.2, 1000}, {0.001, 0, -1});
  const auto a = one(lidar, whole, shot), b = one(lidar, split, shot);
  const double peak = *std::max_element(a.first.begin(), a.first.end());
  for (std::size_t i = 0; i < a.first.size(); ++i)
    CHECK(std::abs(a.first[i] - b.first[i]) <= 2e-5 * peak);  // vertices rounded to 1e-6 m
}

TEST_CASE("L-04: a coaxial obscured receiver is blind near by and full beyond r / phi") {
  scene::Lidar lidar = pencil_lidar();
  lidar.receiver.aperture_radius_m = 0.10;
  lidar.receiver.obscuration_radius_m = 0.04;
  lidar.receiver.half_fov_rad = 0.5e-3;
  lidar.gate = {0, 2e-9, 1000};
  const auto scene = plane(0.3);
  for (const auto& [range_m, eta] :
       {std::pair{60.0, 0.0}, {80.0, 0.0}, {100.0, 0.107142857}, {150.0, 0.479166667}, {200.0, 1.0}, {250.0, 1.0}}) {
    const auto shot = shot_from(lidar, {0, 0, range_m}, {0, 0, -1});
    lidar.transport.overlap = scene::LidarOverlap::off;
    const double all = total(one(lidar, scene, shot).first);
    lidar.transport.overlap = scene::LidarOverlap::exact;
    CHECK(total(one(lidar, scene, shot).first) / all == doctest::Approx(eta).epsilon(1e-5));
  }
}

TEST_CASE("S34: many ways at once: a wall hides half of a footprint, what lies past the receiver hides nothing") {
  // From a roof 30 m up, under another roof or none: beside the laser, the receiver sees the half of the footprint that
  // a low wall along its middle leaves open.
  const auto with = [](bool wall, bool roof) {
    scene::CompiledScene scene = scene_of({0.3, 0.0});
    add_plane(scene, 0, {0, 0, 0}, 20);
    if (wall) add_rectangle(scene, 1, {0, -20, 0.05}, {0, 40, 0}, {0, 0, 3});
    if (roof) add_plane(scene, 1, {0, 0, 40}, 20);
    scene::finish_top_tree(scene);
    scene::Lidar lidar = pencil_lidar();
    lidar.pulse.half_divergence_rad = 0.02;
    lidar.pulse.profile = scene::BeamProfile::uniform;
    lidar.transport.subrays = 1024;
    lidar.gate = {0, 1e-9, 400};
    auto shot = shot_from(lidar, {0, 0, 30}, {0, 0, -1});
    place_pupil(shot, {15, 0, 30}, {-0.4472136, 0, -0.8944272});
    return total(one(lidar, scene, shot).first);
  };
  const double open = with(false, false);
  CHECK(open > 0);
  CHECK(with(false, true) == doctest::Approx(open).epsilon(1e-6));
  // The half at x < 0 lies behind the wall, but for what its foot leaves of 0.05 m: at this slope 0.025 m of 0.6. The
  // nearer half is 2 % brighter by distance and cosine.
  for (const bool roof : {false, true}) CHECK(std::abs(with(true, roof) / open - 0.5) < 0.04);
}

TEST_CASE("L-03: a tilted biaxial beam seen through the stop, each hit by its own share") {
  scene::Lidar lidar = topographic_lidar();
  lidar.receiver.aperture_radius_m = 0.10;
  lidar.receiver.obscuration_radius_m = 0;
  lidar.receiver.half_fov_rad = 0.2e-3;
  lidar.pulse.exit_radius_m = 0.010;
  lidar.pulse.half_divergence_rad = 0.1e-3;
  lidar.transport.subrays = 4096;
  lidar.transport.overlap = scene::LidarOverlap::exact;
  lidar.gate = {0, 4e-9, 2000};
  const auto scene = plane(0.3);
  for (const auto& [range_m, o] : {std::pair{425.0, 0.088138},
                                   {450.0, 0.317491},
                                   {475.0, 0.606800},
                                   {500.0, 0.798252},
                                   {525.0, 0.679700},
                                   {550.0, 0.442462},
                                   {600.0, 0.064448},
                                   {1000.0, 0.0}}) {
    auto shot = shot_from(lidar, {1.0, 0, range_m}, {-2e-3, 0, -1});
    place_pupil(shot, {0, 0, range_m}, {0, 0, -1});
    lidar.transport.overlap = scene::LidarOverlap::exact;
    const double seen = one(lidar, scene, shot).ledger[0].collected;
    lidar.transport.overlap = scene::LidarOverlap::off;
    const double all = one(lidar, scene, shot).ledger[0].collected;
    CHECK(std::abs(seen / all - o) <=
          4 * 0.001);  // 4096 sub-rays across a stop's edge: 0.0006 rms (2.1), exits from a second spiral
  }
}

TEST_CASE("S34: no combination of zeros makes a NaN") {
  const auto scene = plane(0.0);
  for (const int zero : {0, 1, 2, 3, 4, 5}) {
    scene::Lidar lidar = topographic_lidar();
    lidar.transport.overlap = scene::LidarOverlap::exact;
    if (zero == 0) lidar.pulse.half_divergence_rad = 0;
    if (zero == 1) lidar.receiver.half_fov_rad = 0;
    if (zero == 2) lidar.pulse.fwhm_s = 0;
    if (zero == 3) lidar.pulse.lines[0].energy_J = 0;
    if (zero == 4) lidar.receiver.efficiency = 0;
    const auto shot = shot_from(lidar, {0, 0, zero == 5 ? 0.0 : 1000.0}, {0, 0, -1});
    for (const auto& lit : {scene, plane(0.3)}) {
      const auto result = one(lidar, lit, shot);
      for (const float x : result.first) REQUIRE(std::isfinite(x));
      CHECK(std::isfinite(result.ledger[0].collected));
      CHECK(std::abs(result.ledger[0].emitted_error()) <= 1e-6);
    }
  }
}
