// Light scattered more than once: the Lambert corner (L-16), reciprocity (I3), the ledger of mixed scenes (I1).
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/chance_checks.h"
#include "tests/support/lidar_device.h"
#include "tests/support/lidar_kit.h"

using namespace raycube;
using namespace raycube::test;

namespace {

/// The corner of L-16: a narrow beam from far along (1, 0, 1) / sqrt 2 hits plate A at (1, 0, 0). Apex at distance L.
constexpr double kApex_m = 20000;
scene::Lidar corner_lidar(int bounces, int subrays) {
  scene::Lidar lidar = topographic_lidar();
  lidar.pulse.half_divergence_rad = 0;
  lidar.pulse.fwhm_s = 0;
  lidar.transport.subrays = subrays;
  lidar.transport.max_bounces = bounces;
  lidar.gate = {2 * kApex_m / kLightSpeed - 20e-9, 0.1e-9, 10000};
  return lidar;
}
scene::CompiledScene corner(double rho_a, double rho_b, double length_m, double height_m, double half_width_m) {
  scene::CompiledScene scene = scene_of({rho_a, rho_b});
  add_corner(scene, 0, 1, length_m, height_m, half_width_m);
  scene::finish_top_tree(scene);
  return scene;
}
lidar::Shot corner_shot(const scene::Lidar& lidar) {
  const double c = std::sqrt(0.5);
  return shot_from(lidar, {kApex_m * c + 0.5, 0, kApex_m * c - 0.5}, {-c, 0, -c});
}
lidar::LidarPlan pencil_plan(const scene::Lidar& lidar, const scene::CompiledScene& scene) {
  lidar::LidarPlan plan = hand_plan(lidar, scene);
  std::fill(plan.footprint.a.begin(), plan.footprint.a.end(), 0.0f);
  std::fill(plan.footprint.b.begin(), plan.footprint.b.end(), 0.0f);
  return plan;
}

}  // namespace

TEST_CASE("L-16: a Lambert corner: energies of the orders, first arrival and spread of the second") {
  constexpr int kRays = 65536;
  scene::Lidar lidar = corner_lidar(2, kRays);
  const auto scene = corner(0.5, 0.4, 3000, 3000, 3000);
  const auto shot = corner_shot(lidar);
  const auto two = render_shots(scene, pencil_plan(lidar, scene), {shot}).at(0);
  const double first = total(two.first), second = total(two.multiple);
  // Hits of B are a coin of chance 1/2; what misses the finite plates: F is 0.4998 of 0.5.
  CHECK_WITHIN(second / first / (0.4 * 0.5) - 1, 4 / std::sqrt(double(kRays)) + 5e-4);
  CHECK(std::abs(two.ledger[0].emitted_error()) <= 1e-6);

  const auto first_bin = [](const std::vector<float>& row) {
    return std::find_if(row.begin(), row.end(), [](float x) { return x > 0; }) - row.begin();
  };
  const double bin_m = 0.1e-9 * kLightSpeed;
  // Order 2 begins at the apex range, sqrt 2 m of path after order 1.
  const auto one_at = first_bin(two.first), two_at = first_bin(two.multiple);
  CHECK(std::abs((two_at - one_at) * bin_m - std::sqrt(2.0)) <=
        bin_m + 1e-3);  // earliest of 26 000 hits is 1e-4 m late
  const double quantile[5] = {0.10, 0.25, 0.50, 0.75, 0.90}, excess_m[5] = {1.46817, 1.57064, 1.89960, 2.9995, 6.372};
  // Density of the excess at those quantiles, from their neighbours: 4 standard errors sqrt(q (1 - q) / hits) /
  // density.
  const double density[5] = {1.6, 1.25, 0.42, 0.11, 0.02};
  // Order 1 comes 20 ns after the gate opens less the way of the two sqrt(1/2) m by which A is nearer than the apex,
  // which is no whole number of bins; inside a bin the sum rises evenly but for half a bin.
  double sum = 0, before = 0;
  std::size_t bin = 0;
  for (int i = 0; i < 5; ++i) {
    for (; sum < quantile[i] * second; ++bin) before = sum, sum += two.multiple[bin];
    const double inside = (quantile[i] * second - before) / (sum - before);
    const double got_m = (static_cast<double>(bin) - 1 + inside - 200) * bin_m + std::sqrt(2.0);
    CHECK_WITHIN(got_m - excess_m[i],
                 0.5 * bin_m + 4 * std::sqrt(quantile[i] * (1 - quantile[i]) / (0.5 * kRays)) / density[i]);
  }

  lidar.transport.max_bounces = 12;
  const auto all = render_shots(scene, pencil_plan(lidar, scene), {shot}).at(0);
  const double collected = all.ledger[0].collected;
  const double one_share = first / hand_plan(lidar, scene).photons[0];
  CHECK_WITHIN(collected / one_share / 1.263157895 - 1, 4 * 0.4 * 0.5 / std::sqrt(double(kRays)) + 2e-3);
  CHECK(std::abs(all.ledger[0].emitted_error()) <= 1e-6);
}

TEST_CASE("L-16: what stands behind the receiver hides nothing from it") {
  const scene::Lidar lidar = corner_lidar(2, 4096);
  const auto shot = corner_shot(lidar);
  const auto alone = corner(0.5, 0.4, 3000, 3000, 3000);
  const auto free = render_shots(alone, pencil_plan(lidar, alone), {shot}).at(0);
  // 300 m past the receiver, across every way that light takes to it.
  scene::CompiledScene walled = scene_of({0.5, 0.4});
  add_corner(walled, 0, 1, 3000, 3000, 3000);
  const double away_m = (kApex_m + 300) * std::sqrt(0.5);
  add_plane(walled, 0, {away_m, 0, away_m}, 3000, std::atan(1.0));
  scene::finish_top_tree(walled);
  const auto before_wall = render_shots(walled, pencil_plan(lidar, walled), {shot}).at(0);
  REQUIRE(total(free.multiple) > 0);
  // The wall scatters nothing into a pupil that looks away from it; vertices move by roundings of the scene's size.
  CHECK(total(before_wall.first) == doctest::Approx(total(free.first)).epsilon(1e-5));
  CHECK(total(before_wall.multiple) == doctest::Approx(total(free.multiple)).epsilon(1e-5));
}

TEST_CASE("L-16: a finite plate B takes its form factor") {
  constexpr int kRays = 65536;
  for (const auto& [half_m, expected] : {std::pair{5.0, 0.3887500640}, {10.0, 0.4434773417}, {50.0, 0.4886362870}}) {
    const scene::Lidar lidar = corner_lidar(2, kRays);
    const auto scene = corner(0.5, 0.4, 3000, half_m, half_m);
    const auto result = render_shots(scene, pencil_plan(lidar, scene), {corner_shot(lidar)}).at(0);
    CHECK_WITHIN(total(result.multiple) / total(result.first) / 0.4 - expected, 4 * 0.5 / std::sqrt(double(kRays)));
  }
}

TEST_CASE(
    "I1, S36: the ledger of a mixed scene with bounces, air, leaves and plates closes; bins are what was collected") {
  scene::CompiledScene scene = scene_of({0.6, 0.3, 0.2});
  scene.materials[1].transmittance = {{0.3, 4.0}, {0.4, 0.4}};
  scene.materials[2].transmittance = {{0.3, 4.0}, {0.7, 0.7}};
  scene.materials[2].behind.number = RC_SHAPE_plate;
  add_plane(scene, 0, {0, 0, 0}, 30, 0.1);
  add_rectangle(scene, 0, {-0.3, -5, -1}, {0, 10, 0}, {0, 0, 4});
  add_plane(scene, 1, {0.1, 0, 3}, 0.2, 0.5);
  add_plane(scene, 2, {-0.1, 0.1, 5}, 0.3, -0.2);
  scene::finish_top_tree(scene);
  scene::Lidar lidar = topographic_lidar();
  lidar.pulse.lines.push_back({"second", 0.532, 0, 50e-6});
  lidar.transport.max_bounces = 4;
  lidar.transport.overlap = scene::LidarOverlap::exact;
  lidar::LidarPlan plan = hand_plan(lidar, scene);
  set_air(plan, 2e-4, 0, -10, 800);
  plan.matter[1] = {0.4, 0};  // lines differ
  const auto result = render_shots(scene, plan, {shot_from(lidar, {0, 0, 1000}, {0, 0, -1})}).at(0);
  REQUIRE(result.ledger.size() == 2);
  for (std::size_t line = 0; line < 2; ++line) {
    const lidar::Ledger& ledger = result.ledger[line];
    CHECK(std::abs(ledger.emitted_error()) <= 1e-6);
    CHECK(ledger.absorbed > 0.1);
    CHECK(ledger.air > 0.1);
    CHECK(ledger.escaped > 0.01);
    CHECK(ledger.truncated > 1e-4);
    const auto from = static_cast<std::ptrdiff_t>(line * 1000);
    const double bins = total({result.first.begin() + from, result.first.begin() + from + 1000}) +
                        total({result.multiple.begin() + from, result.multiple.begin() + from + 1000});
    CHECK(bins / plan.photons[line] + ledger.early + ledger.late + ledger.near ==
          doctest::Approx(ledger.collected).epsilon(5e-6));
    for (const float x : result.multiple) REQUIRE(x >= 0);
  }
  CHECK(total({result.multiple.begin(), result.multiple.begin() + 1000}) > 0);
}

TEST_CASE("I3: transmitter and receiver may change places") {
  // A small exit and a small pupil over a corner; beam and field uniform and alike. Sub-rays one way, samples the
  // other.
  const auto scene = corner(0.5, 0.4, 30, 30, 30);
  scene::Lidar lidar = topographic_lidar();
  lidar.pulse.profile = scene::BeamProfile::gaussian;
  lidar.pulse.half_divergence_rad = 5e-3;
  lidar.transport.subrays = 16384;
  lidar.transport.max_bounces = 2;
  lidar.receiver.columns = 1, lidar.receiver.rows = 1;
  lidar.receiver.pixel_pitch_rad = 20e-3;
  lidar.receiver.half_fov_rad =
      1;  // wide open: all of the beam is seen one way; the samples' square holds the beam the other way
  lidar.gate = {600e-9, 1e-9, 2000};
  const auto shot = shot_from(lidar, {100, 0, 100}, {-98, 0, -99.0});
  auto apart = shot;
  place_pupil(apart, {98, 4, 103}, {-96, -4, -102.0});
  const auto forward = render_shots(scene, hand_plan(lidar, scene), {apart}).at(0);
  lidar.transport.sampling = scene::LidarSampling::receiver;
  const auto backward = render_shots(scene, hand_plan(lidar, scene), {apart}).at(0);
  CHECK(total(forward.first) ==
        doctest::Approx(total(backward.first))
            .epsilon(5e-3));  // edges of the beam against 16384 samples, each ray 4 beams' share
  // Scattered light: the pixel's field cuts what comes from beyond it, which sub-rays see whole.
  CHECK(total(backward.multiple) < total(forward.multiple));
  CHECK(total(backward.multiple) > 0);
}
