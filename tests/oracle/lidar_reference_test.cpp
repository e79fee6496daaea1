// The LIDAR reference against closed forms and published numbers: if it is wrong, every comparison with the device is.
#include <doctest/doctest.h>

#include <cmath>

#include <glm/geometric.hpp>

#include "host/reference/lidar_optics.h"
#include "tests/oracle/lidar_reference_kit.h"
#include "tests/support/chance_checks.h"

using namespace raycube;
using namespace raycube::test;

namespace {

/// One pencil ray of the L-01 LIDAR.
scene::Lidar pencil() {
  scene::Lidar lidar = topographic_lidar();
  lidar.transport.subrays = 1;
  return lidar;
}

/// A plane of reflectance 0.3 at z = 0.
scene::CompiledScene ground(double tilt_rad = 0, double reflectance = 0.3) {
  scene::CompiledScene scene = scene_of({reflectance});
  add_plane(scene, 0, {0, 0, 0}, 50, tilt_rad);
  scene::finish_top_tree(scene);
  return scene;
}

void closes(const reference::LidarReference& result, const lidar::LidarPlan& plan) {
  for (std::size_t line = 0; line < result.ledger.size(); ++line) {
    const lidar::Ledger& l = result.ledger[line];
    CHECK(std::abs(l.emitted_error()) < 1e-12);
    double recorded = 0;
    for (const auto* row : {&result.rows.first, &result.rows.multiple, &result.rows.air, &result.rows.particles})
      recorded += row_sum(*row);
    if (plan.lines() == 1)
      CHECK(std::abs(recorded / plan.photons[0] + l.early + l.late + l.near - l.collected) <= 1e-12 * l.collected);
  }
}

}  // namespace

TEST_CASE("L-01: link budget of one ray, bin by bin") {
  const auto scene = ground();
  const auto lidar = pencil();
  auto plan = hand_plan(lidar, scene);
  set_air(plan, 1e-4, 0, -100, 2000);
  const auto result = shoot(scene, plan, shot_from(lidar, {0.37, 0.21, 1000}, {0, 0, -1}));
  // Printed to ten digits.
  CHECK(row_sum(result.rows.first) == doctest::Approx(134685.6010).epsilon(1e-9));
  CHECK(0.3 * row_sum(result.rows.first) == doctest::Approx(40405.68031).epsilon(1e-9));
  const double pe[] = {33.4762,   198.7032,  841.2644,  2541.5635, 5480.9961, 8439.5091, 9279.7738,
                       7286.7561, 4085.7507, 1635.5598, 467.2943,  95.2532,   13.8465};
  for (std::size_t i = 0; i < std::size(pe); ++i) CHECK(std::abs(0.3 * result.rows.first[465 + i] - pe[i]) < 6e-5);
  // Sums over bins of a Gaussian's bins keep its centroid; tails beyond 9 deviations are left out.
  CHECK(std::abs(centroid_s(result.rows.first, lidar.gate) - 6671.281903963e-9) < 2e-18);
  closes(result, plan);
  const auto tilted = ground(M_PI / 6);
  const auto slanted = shoot(tilted, plan, shot_from(lidar, {0, 0, 1000}, {0, 0, -1}));
  // The plate's corners are floats: 6e-8 of 50 m off its plane's tilt.
  CHECK(0.3 * row_sum(slanted.rows.first) == doctest::Approx(34992.34561).epsilon(1e-7));
}

TEST_CASE("L-32: the receiver's cosine counts, not the laser's") {
  const auto scene = ground();
  auto lidar = pencil();
  lidar.gate.start_s = 9500e-9;
  const auto plan = hand_plan(lidar, scene);
  // Laser 60 degrees off the normal, receiver on the normal at 1000 m.
  auto shot = shot_from(lidar, {2000 * std::sin(M_PI / 3), 0, 2000 * std::cos(M_PI / 3)},
                        {-std::sin(M_PI / 3), 0, -std::cos(M_PI / 3)});
  place_pupil(shot, {0, 0, 1000}, {0, 0, -1});
  const auto result = shoot(scene, plan, shot);
  const double expected = plan.photons[0] * 0.3 / M_PI * M_PI * (0.05 * 0.05 - 0.015 * 0.015) * 1e-6 * 0.5;
  CHECK(row_sum(result.rows.first) == doctest::Approx(expected).epsilon(1e-9));
  CHECK(centroid_s(result.rows.first, lidar.gate) == doctest::Approx(3000 / kLightSpeed).epsilon(1e-12));
}

TEST_CASE("L-02: DIRSIG's validation plate, both apertures") {
  const auto scene = [] {
    scene::CompiledScene s = scene_of({0.1});
    add_plane(s, 0, {0, 0, 0}, 50);
    scene::finish_top_tree(s);
    return s;
  }();
  auto lidar = topographic_lidar();
  lidar.pulse.lines = {{"laser", 1.064, 0, 150e-6}};
  lidar.pulse.transmit_efficiency = 1;
  lidar.pulse.profile = scene::BeamProfile::uniform;
  lidar.pulse.half_divergence_rad = 8e-3;
  lidar.pulse.shape = scene::PulseShape::rectangular;
  lidar.pulse.fwhm_s = 2e-9;
  lidar.receiver = {};
  lidar.receiver.aperture_radius_m = 0.1;
  lidar.receiver.columns = lidar.receiver.rows = 4;
  lidar.receiver.pixel_pitch_rad = 50e-6 / 0.4;
  lidar.receiver.focal_length_m = 0.4;
  lidar.receiver.efficiency = 0.5;
  lidar.transport.sampling = scene::LidarSampling::receiver;
  lidar.transport.subrays = 4;
  lidar.gate = {13300e-9, 1e-9, 100};
  for (const bool tangent : {false, true}) {
    lidar.receiver.tangent_aperture = tangent;
    const auto plan = hand_plan(lidar, scene);
    const auto result = shoot(scene, plan, shot_from(lidar, {0, 0, 2000}, {0, 0, -1}));
    for (std::size_t pixel = 0; pixel < 16; ++pixel) {
      double photons = 0;
      for (std::size_t bin = 0; bin < 100; ++bin) photons += result.rows.first[pixel * 100 + bin];
      // Seven digits printed; cos^4 across the four pixels is 1e-7.
      CHECK(photons == doctest::Approx(tangent ? 7.345289 : 7.804369).epsilon(4e-7));
    }
    closes(result, plan);
  }
}

TEST_CASE("I1, I4, I6: energy of a footprint, range shift, equal ranges add") {
  const auto scene = ground();
  auto lidar = topographic_lidar();
  const auto plan = hand_plan(lidar, scene);
  const auto near = shoot(scene, plan, shot_from(lidar, {0, 0, 1000}, {0, 0, -1}));
  const auto far = shoot(scene, plan, shot_from(lidar, {0, 0, 1010}, {0, 0, -1}));
  closes(near, plan);
  // The footprint is one cone: every path scales with the range.
  CHECK(centroid_s(far.rows.first, lidar.gate) / centroid_s(near.rows.first, lidar.gate) ==
        doctest::Approx(1.01).epsilon(1e-13));
  CHECK(row_sum(far.rows.first) / row_sum(near.rows.first) == doctest::Approx(1 / (1.01 * 1.01)).epsilon(1e-12));
  // Mean of cos(theta)^3 cos(psi)... over the beam: 1 - 2 <tan^2>, <tan^2> = theta^2 / 2 for a Gaussian of 1/e2 half
  // angle theta.
  const double on_axis = plan.photons[0] * 0.3 * (0.05 * 0.05 - 0.015 * 0.015) * 1e-6 * 0.5;
  CHECK(row_sum(near.rows.first) == doctest::Approx(on_axis * (1 - 2 * 0.5 * 0.25e-3 * 0.25e-3)).epsilon(1e-9));
  lidar.pulse.half_divergence_rad = 0;
  const auto one = shoot(scene, hand_plan(pencil(), scene), shot_from(lidar, {0, 0, 1000}, {0, 0, -1}));
  const auto many = shoot(scene, hand_plan(lidar, scene), shot_from(lidar, {0, 0, 1000}, {0, 0, -1}));
  for (std::size_t i = 0; i < one.rows.first.size(); ++i)
    CHECK(std::abs(one.rows.first[i] - many.rows.first[i]) <= 1e-12 * row_sum(one.rows.first));
}

TEST_CASE("L-31: gate's ends and bin edges") {
  const auto scene = ground();
  auto lidar = pencil();
  const double echo_s = 2000 / kLightSpeed;
  lidar.pulse.fwhm_s = 0.1e-9;
  lidar.gate = {echo_s - 5e-9, 1e-9, 10};
  const auto shot = shot_from(lidar, {0, 0, 1000}, {0, 0, -1});
  const auto halved = shoot(scene, hand_plan(lidar, scene), shot);
  // The edge is met to the rounding of seconds: 1e-21 s of 0.1 ns.
  CHECK(halved.rows.first[4] == doctest::Approx(halved.rows.first[5]).epsilon(1e-9));
  lidar.gate.start_s = echo_s;
  const auto plan = hand_plan(lidar, scene);
  const auto cut = shoot(scene, plan, shot);
  CHECK(cut.ledger[0].early == doctest::Approx(0.5 * cut.ledger[0].collected).epsilon(1e-9));
  closes(cut, plan);
  lidar.gate.start_s = echo_s + 1e-6;
  const auto early = shoot(scene, hand_plan(lidar, scene), shot);
  CHECK(row_sum(early.rows.first) == 0);
  CHECK(early.ledger[0].early == doctest::Approx(early.ledger[0].collected).epsilon(1e-14));
  lidar.transport.minimum_range_m = 2000;
  const auto close = shoot(scene, hand_plan(lidar, scene), shot);
  CHECK(close.ledger[0].near == doctest::Approx(early.ledger[0].collected).epsilon(1e-14));
}

TEST_CASE("L-13: two equal echoes show two maxima only beyond two standard deviations") {
  for (const double step_m : {0.48, 0.54}) {  // 2 s is 0.509 m of range
    scene::CompiledScene scene = scene_of({0.3});
    add_rectangle(scene, 0, {-20, -20, 0}, {20, 0, 0}, {0, 40, 0});
    add_rectangle(scene, 0, {0, -20, step_m}, {20, 0, 0}, {0, 40, 0});
    scene::finish_top_tree(scene);
    auto lidar = topographic_lidar();
    lidar.transport.subrays = 2048;
    lidar.gate = {6640e-9, 0.1e-9, 500};
    const auto row = shoot(scene, hand_plan(lidar, scene), shot_from(lidar, {0, 0, 1000}, {0, 0, -1})).rows.first;
    int maxima = 0;
    for (std::size_t i = 1; i + 1 < row.size(); ++i)
      maxima += row[i] > row[i - 1] && row[i] >= row[i + 1] && row[i] > 1;
    CHECK(maxima == (step_m > 0.509 ? 2 : 1));
  }
}

TEST_CASE("L-14: plates let pulses through twice, leaves not at all") {
  for (const std::uint32_t kind : {RC_SHAPE_plate, RC_SHAPE_leaf}) {
    scene::CompiledScene scene = scene_of({0.45, 0.2});
    scene.materials[0].transmittance = {{0.3, 4.0}, {0.45, 0.45}};
    scene.materials[0].behind.number = kind;
    add_rectangle(scene, 0, {0.03, -20, 10}, {20, 0, 0}, {0, 40, 0});
    add_rectangle(scene, 1, {-50, -50, 0}, {100, 0, 0}, {0, 100, 0});
    scene::finish_top_tree(scene);
    auto lidar = topographic_lidar();
    lidar.pulse.half_divergence_rad = 0.25e-3;
    const auto plan = hand_plan(lidar, scene);
    const auto result = shoot(scene, plan, shot_from(lidar, {0, 0, 1000}, {0, 0, -1}));
    double covered = 0;
    for (const auto& hit : result.hits) covered += hit.instance == 0 ? 1.0 / 256 : 0;
    CHECK(covered > 0.3);
    CHECK(covered < 0.5);
    double layer = 0, floor = 0;
    const auto split = static_cast<std::size_t>(2 * 995 / kLightSpeed / 1e-9 - 6200);
    for (std::size_t i = 0; i < 1000; ++i) (i < split ? layer : floor) += result.rows.first[i];
    const double unit = plan.photons[0] * (0.05 * 0.05 - 0.015 * 0.015) * 0.5;
    // Slant of the cone's rays: 6e-8.
    CHECK(layer * 990 * 990 / unit == doctest::Approx(covered * 0.45).epsilon(3e-7));
    const double through = kind == RC_SHAPE_plate ? covered * 0.45 * 0.45 : 0;
    CHECK(floor * 1e6 / unit == doctest::Approx((through + 1 - covered) * 0.2).epsilon(3e-7));
    closes(result, plan);
  }
}

TEST_CASE("L-15: a mirror dihedral gives the distance of its apex back") {
  scene::CompiledScene scene = scene_of({1, 1});
  add_corner(scene, 0, 1, 10, 10, 5);
  scene::finish_top_tree(scene);
  const reference::EmbreeScene embree(scene);
  const reference::LidarTracer tracer(scene, embree);
  for (const double angle : {0.3, 0.8, 1.2})
    for (const double entry : {0.5, 2.0}) {
      const glm::dvec3 in{-std::cos(angle), 0, -std::sin(angle)};
      const glm::dvec3 from = glm::dvec3(entry, 0.1, 0) - 100.0 * in;
      const auto a = tracer.next(from, in, 0, 1e9, {}, glm::dvec3(0));
      REQUIRE(a);
      const glm::dvec3 between = in - 2 * glm::dot(in, a->normal) * a->normal;
      const auto b = tracer.next(a->point, between, 0, 1e9, a->hit, a->clear_m * a->normal);
      REQUIRE(b);
      const glm::dvec3 out = between - 2 * glm::dot(between, b->normal) * b->normal;
      CHECK(glm::length(out + in) < 1e-14);
      // Back to the source plane, the plane through `from` across the beam.
      const double back = glm::dot(from - b->point, out) / glm::dot(out, out);
      CHECK(a->t_m + b->t_m + back == doctest::Approx(2 * glm::dot(-from, in)).epsilon(1e-13));
    }
}

TEST_CASE("L-16: energy and path of the double bounce in a Lambert corner") {
  const double a = 1, far_m = 1e6;
  auto lidar = pencil();
  lidar.pulse.half_divergence_rad = 0;
  lidar.pulse.fwhm_s = 0;
  lidar.transport.subrays = 20000;
  lidar.transport.max_bounces = 2;
  const double first_s = 2 * far_m / kLightSpeed;
  lidar.gate = {first_s - 1e-9, 0.1e-9, 2000};
  const glm::dvec3 from = glm::dvec3(a, 0, 0) + far_m * glm::dvec3(std::sqrt(0.5), 0, std::sqrt(0.5));
  const auto shot = shot_from(lidar, {from.x, from.y, from.z}, {-1, 0, -1});
  for (const double size : {5.0, 10.0}) {
    scene::CompiledScene scene = scene_of({0.5, 0.4});
    add_corner(scene, 0, 1, 2 * size, size, size);
    scene::finish_top_tree(scene);
    const auto plan = hand_plan(lidar, scene, 7);
    const auto result = shoot(scene, plan, shot);
    const double f = size == 5 ? 0.3887500640 : 0.4434773417;
    const double ratio =
        (row_sum(result.rows.multiple) + result.ledger[0].late * plan.photons[0]) / row_sum(result.rows.first);
    // Four standard errors of a share f of 20000 independent draws; the far receiver is 1e6 m away: 1e-5.
    CHECK_WITHIN(ratio / 0.4 - f, 4 * std::sqrt(f * (1 - f) / 20000));
    CHECK(std::abs(result.ledger[0].emitted_error()) < 1e-12);
    // Nothing before the apex range: sqrt(2) a of path after the first bounce.
    const auto apex = static_cast<std::size_t>((std::sqrt(2.0) * a / kLightSpeed + 1e-9) / 0.1e-9);
    double early = 0, soon = 0;
    for (std::size_t i = 0; i < 2000; ++i) {
      if (i < apex) early += result.rows.multiple[i];
      if (static_cast<double>(i) * 0.1e-9 < 1e-9 + 1.89960 / kLightSpeed) soon += result.rows.multiple[i];
    }
    CHECK(early == 0);
    // Half of an infinite corner's double bounces come within 1.8996 m of path: 0.25 of all that leaves A. Bin: 0.03 m
    // of 1.9.
    if (size == 10)
      CHECK_WITHIN(soon / row_sum(result.rows.first) / 0.4 - 0.25, 4 * std::sqrt(0.25 * 0.75 / 20000) + 0.005);
  }
}

TEST_CASE("L-16: all orders of a wide Lambert corner") {
  auto lidar = pencil();
  lidar.pulse.half_divergence_rad = 0;
  lidar.pulse.fwhm_s = 0;
  lidar.transport.subrays = 20000;
  lidar.transport.max_bounces = 12;
  const double far_m = 1e8;
  lidar.gate = {2 * far_m / kLightSpeed - 1e-9, 1e-6, 1000};
  scene::CompiledScene scene = scene_of({0.5, 0.4});
  add_corner(scene, 0, 1, 20000, 20000, 20000);
  scene::finish_top_tree(scene);
  const auto plan = hand_plan(lidar, scene, 3);
  const auto shot = shot_from(lidar, {1 + far_m * std::sqrt(0.5), 0, far_m * std::sqrt(0.5)}, {-1, 0, -1});
  const auto result = shoot(scene, plan, shot);
  const double sum = (row_sum(result.rows.first) + row_sum(result.rows.multiple)) / row_sum(result.rows.first);
  // A path comes to k plates more with a chance of 2^-(k + 1), and sums 0.4 + 0.4 0.5 + 0.4 0.5 0.4 + .. over them: a
  // mean of 0.263 and a spread of 0.279. Four standard errors; plates of 20 km: 3e-5.
  CHECK_WITHIN(sum - 1.263157895, 4 * 0.279 / std::sqrt(20000.0));
  CHECK(std::abs(result.ledger[0].emitted_error()) < 1e-12);
}

TEST_CASE("I3: rays from the transmitter and rays from the receiver find the same energy in every order") {
  scene::CompiledScene scene = scene_of({0.5, 0.4});
  add_corner(scene, 0, 1, 6, 6, 6);
  scene::finish_top_tree(scene);
  auto lidar = topographic_lidar();
  lidar.pulse.profile = scene::BeamProfile::uniform;
  lidar.pulse.half_divergence_rad = 20e-3;
  lidar.receiver.half_fov_rad = 0;
  lidar.receiver.columns = lidar.receiver.rows = 12;
  lidar.receiver.pixel_pitch_rad = 12e-3;
  lidar.gate = {500e-9, 1e-9, 500};
  lidar.transport.max_bounces = 3;
  auto shot = shot_from(lidar, {80, 0, 70}, {-78, 0, -68});
  place_pupil(shot, {70, 10, 80}, {-68, -10, -78});
  const reference::EmbreeScene embree(scene);
  double mean[2][2] = {}, square[2][2] = {};
  constexpr int kSeeds = 24;  // of fewer the spread itself is known too badly
  for (const bool receiver : {false, true}) {
    lidar.transport.sampling = receiver ? scene::LidarSampling::receiver : scene::LidarSampling::transmitter;
    lidar.transport.subrays = receiver ? 64 : 4096;
    const auto plan = hand_plan(lidar, scene);
    for (int seed = 1; seed <= kSeeds; ++seed) {
      reference::LidarShotOptions options;
      options.own_seed = true, options.seed = testing::seed(static_cast<std::uint64_t>(seed));
      const auto rows = reference::reference_shot(scene, embree, plan, shot, options).rows;
      const double sums[2] = {row_sum(rows.first), row_sum(rows.multiple)};
      for (int order = 0; order < 2; ++order)
        mean[receiver][order] += sums[order] / kSeeds, square[receiver][order] += sums[order] * sums[order] / kSeeds;
    }
  }
  // Once: no chance but the edge of the beam and of plates between samples, 0.5 % of 4096 and of the 1500 samples in
  // the spot.
  CHECK_WITHIN(mean[1][0] / (mean[0][0]) - 1, 0.01);
  double error = 0.005 * 0.005 * mean[0][1] * mean[0][1];
  for (int side = 0; side < 2; ++side) error += (square[side][1] - mean[side][1] * mean[side][1]) / (kSeeds - 1);
  MESSAGE("twice and more: " << mean[0][1] << " " << mean[1][1] << " +- " << std::sqrt(error));
  CHECK(mean[0][1] > 0.05 * mean[0][0]);
  CHECK_WITHIN(mean[1][1] - mean[0][1], 4 * std::sqrt(error));
}

TEST_CASE("LIDAR 4.2, L-04, L-12: lens area, vignetting and gloss of the reference") {
  CHECK(reference::lens_area(1, 1, 1) == doctest::Approx(1.228369699).epsilon(1e-9));
  CHECK(reference::lens_area(2, 1, 1.5) == doctest::Approx(2.392549868).epsilon(1e-9));
  CHECK(reference::lens_area(0.5, 0.3, 0.4) == doctest::Approx(0.1822469466).epsilon(1e-9));
  CHECK(reference::lens_area(1, 1, 2) == 0);
  // A lens h thick between unit circles: (4/3) h^1.5 to first order (chord 2 sqrt(h), two segments of height h/2).
  CHECK(reference::lens_area(1, 1, 2 - 1e-10) == doctest::Approx(4.0 / 3 * 1e-15).epsilon(1e-6));
  scene::LidarReceiver receiver;
  receiver.aperture_radius_m = 0.1, receiver.obscuration_radius_m = 0.04, receiver.half_fov_rad = 0.5e-3;
  CHECK(reference::pupil_share(receiver, 80, 0) == doctest::Approx(0).epsilon(1e-14));
  CHECK(reference::pupil_share(receiver, 100, 0) == doctest::Approx(0.107142857).epsilon(1e-8));
  CHECK(reference::pupil_share(receiver, 150, 0) == doctest::Approx(0.479166667).epsilon(1e-8));
  CHECK(reference::pupil_share(receiver, 200, 0) == doctest::Approx(1).epsilon(1e-14));
  const auto zero_phase = [](double degrees) {
    const RcLocal way{std::sin(degrees * M_PI / 180), 0, std::cos(degrees * M_PI / 180)};
    return rc_gloss_eval(1, {{0.3, 0.04}, nullptr}, rc_angles({0, 0, 1}, way, way));
  };
  CHECK(zero_phase(0) == doctest::Approx(0.0353678).epsilon(2e-6));
  CHECK(zero_phase(80) == doctest::Approx(0.00675587).epsilon(1e-6));
}
