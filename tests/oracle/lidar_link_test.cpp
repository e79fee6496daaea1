// LIDAR on the device against the link budget of the specification (L-01) and the invariants I4 to I7.
#include <doctest/doctest.h>

#include <cmath>
#include <set>

#include "tests/support/lidar_device.h"
#include "tests/support/lidar_kit.h"

using namespace raycube;
using namespace raycube::test;

namespace {

scene::CompiledScene ground(double reflectance, double z_m = 0, double tilt_rad = 0, double half_m = 20) {
  scene::CompiledScene scene = scene_of({reflectance});
  add_plane(scene, 0, {0, 0, z_m}, half_m, tilt_rad);
  scene::finish_top_tree(scene);
  return scene;
}

lidar::ShotResult nadir(const scene::Lidar& lidar, const scene::CompiledScene& scene, double z_m = 1000,
                        double extinction_per_m = 0, double x_m = 0) {
  lidar::LidarPlan plan = hand_plan(lidar, scene);
  if (extinction_per_m > 0) set_air(plan, extinction_per_m, 0, 0, 2000);
  return render_shots(scene, plan, {shot_from(lidar, {x_m, 0, z_m}, {0, 0, -1})}).at(0);
}

}  // namespace

TEST_CASE("L-01: link budget of an airborne pulse, energy, time and bins") {
  scene::Lidar lidar = pencil_lidar();
  lidar.gate = {6600e-9, 1e-9, 200};
  const auto result = nadir(lidar, ground(0.3), 1000, 1e-4);
  const Moments m = moments(result.first);
  CHECK(m.sum == doctest::Approx(134685.6010).epsilon(2e-6));  // float weights and 13 float shares
  CHECK(m.sum * lidar.receiver.quantum_efficiency == doctest::Approx(40405.68031).epsilon(2e-6));
  CHECK(m.mean_bin + 6600 == doctest::Approx(6671.281903963).epsilon(1e-8));  // 0.07 ps: position's float, 1e-5 bins
  const double expected[13] = {33.4762,   198.7032,  841.2644,  2541.5635, 5480.9961, 8439.5091, 9279.7738,
                               7286.7561, 4085.7507, 1635.5598, 467.2943,  95.2532,   13.8465};
  for (std::size_t i = 0; i < 13;
       ++i)  // 5e-6 of a bin in position times the steepest slope, 3.3 per bin, and five printed digits
    CHECK(result.first[65 + i] * 0.3 == doctest::Approx(expected[i]).epsilon(3e-5));
  const lidar::Ledger& ledger = result.ledger.at(0);
  CHECK(std::abs(ledger.emitted_error()) <= 1e-6);
  CHECK(ledger.air == doctest::Approx(1 - std::exp(-0.1)).epsilon(1e-6));
  CHECK(ledger.absorbed == doctest::Approx(0.7 * std::exp(-0.1)).epsilon(1e-6));
  CHECK(ledger.truncated == doctest::Approx(0.3 * std::exp(-0.1)).epsilon(1e-6));
  CHECK(ledger.collected * 0.9 * 5.356300028e14 == doctest::Approx(134685.6010).epsilon(2e-6));
}

TEST_CASE("L-01: a tilt of 30 degrees costs the receiver's cosine") {
  scene::Lidar lidar = pencil_lidar();
  const auto result = nadir(lidar, ground(0.3, 0, M_PI / 6), 1000, 1e-4);
  CHECK(moments(result.first).sum * 0.3 == doctest::Approx(34992.34561).epsilon(2e-6));
}

TEST_CASE("S27: a beam of many sub-rays keeps the energy of the pencil") {
  const auto result = nadir(topographic_lidar(), ground(0.3), 1000, 1e-4);
  // Sub-rays off the axis: cosines and ranges to fourth order, (0.25 mrad)^2 times a few.
  CHECK(moments(result.first).sum == doctest::Approx(134685.6010).epsilon(2e-6));
  CHECK(result.ledger[0].collected * 0.9 * 5.356300028e14 == doctest::Approx(moments(result.first).sum).epsilon(5e-6));
  CHECK(std::abs(result.ledger[0].emitted_error()) <= 1e-6);
}

TEST_CASE("I4: a move along the beam shifts the centroid by 2 dR / c and scales by 1 / R^2") {
  const auto scene = ground(0.3);
  const scene::Lidar lidar = pencil_lidar();
  const Moments near = moments(nadir(lidar, scene, 1000).first), far = moments(nadir(lidar, scene, 1037.25).first);
  CHECK(far.mean_bin - near.mean_bin == doctest::Approx(2 * 37.25 / kLightSpeed * 1e9).epsilon(1e-7));
  CHECK(far.sum / near.sum == doctest::Approx(std::pow(1000 / 1037.25, 2)).epsilon(1e-6));
}

TEST_CASE("I5: twice the energy doubles every bin to the bit") {
  const auto scene = ground(0.3);
  scene::Lidar lidar = topographic_lidar();
  const auto once = nadir(lidar, scene);
  lidar.pulse.lines[0].energy_J *= 2;
  const auto twice = nadir(lidar, scene);
  for (std::size_t i = 0; i < once.first.size(); ++i) REQUIRE(twice.first[i] == 2 * once.first[i]);
}

TEST_CASE("I6: returns at equal range add, none overwrites another") {
  // Sub-rays at equal angles from the axis meet a level plane at equal ranges.
  const auto scene = ground(0.3);
  scene::Lidar lidar = topographic_lidar();
  lidar.transport.subrays = 64;
  lidar::LidarPlan plan = hand_plan(lidar, scene);
  for (std::size_t k = 0; k < 64; ++k) {
    plan.footprint.a[k] = k % 2 ? 0.5f : -0.5f;
    plan.footprint.b[k] = k % 4 < 2 ? 0.5f : -0.5f;
  }
  const auto shot = shot_from(lidar, {0, 0, 1000}, {0, 0, -1});
  const auto all = render_shots(scene, plan, {shot}).at(0);
  CHECK(moments(all.first).sum == doctest::Approx(moments(nadir(pencil_lidar(), scene).first).sum).epsilon(2e-6));
}

TEST_CASE("I7: coarse bins are sums of fine ones") {
  const auto scene = ground(0.3, 0, 0.3);
  scene::Lidar lidar = topographic_lidar();
  lidar.gate = {6600e-9, 1e-9, 160};
  const auto coarse = nadir(lidar, scene);
  lidar.gate = {6600e-9, 0.25e-9, 640};
  const auto fine = nadir(lidar, scene);
  for (std::size_t i = 0; i < coarse.first.size(); ++i) {
    const double sum =
        double(fine.first[4 * i]) + fine.first[4 * i + 1] + fine.first[4 * i + 2] + fine.first[4 * i + 3];
    // Position's rounding in bins times the steepest slope, and the taps' linear phases.
    CHECK(std::abs(coarse.first[i] - sum) <= 2e-6 * moments(coarse.first).sum);
  }
}

TEST_CASE("L-31: a pulse on a bin's edge, an impulse, a pulse that hangs over the gate") {
  // Path 2 R of 2000 bins of 1 ns to the last bit: R = 1000 bins of c / 2 ns.
  const double range_m = 1000 * kLightSpeed * 1e-9 / 2 * 2;
  const auto scene = ground(0.3);
  scene::Lidar lidar = pencil_lidar();
  lidar.gate = {1900e-9, 1e-9, 200};
  lidar.pulse.fwhm_s = 0.1e-9;
  const auto split = nadir(lidar, scene, range_m);
  const double whole = split.ledger[0].collected * hand_plan(lidar, scene).photons[0];
  CHECK(split.first[99] / whole == doctest::Approx(0.5).epsilon(2e-3));  // 1e-5 bins of position, slope 9.4 per bin
  CHECK(split.first[100] / whole == doctest::Approx(0.5).epsilon(2e-3));

  lidar.pulse.fwhm_s = 0;
  lidar.gate.start_s = 1899.5e-9;
  const auto impulse = nadir(lidar, scene, range_m);
  for (std::size_t i = 0; i < impulse.first.size(); ++i)
    CHECK(impulse.first[i] == (i == 100 ? doctest::Approx(whole).epsilon(1e-6) : doctest::Approx(0)));

  lidar.pulse.fwhm_s = 4e-9;
  lidar.gate = {2000e-9, 1e-9, 100};
  const auto half = nadir(lidar, scene, range_m);
  CHECK(moments(half.first).sum / whole == doctest::Approx(0.5).epsilon(1e-4));
  CHECK(half.ledger[0].early / half.ledger[0].collected == doctest::Approx(0.5).epsilon(1e-4));
  CHECK(half.ledger[0].early + half.ledger[0].late + moments(half.first).sum / whole * half.ledger[0].collected ==
        doctest::Approx(half.ledger[0].collected).epsilon(5e-6));

  lidar.gate = {3000e-9, 1e-9, 100};
  const auto early = nadir(lidar, scene, range_m);
  CHECK(early.ledger[0].early == early.ledger[0].collected);
  lidar.gate = {100e-9, 1e-9, 100};
  const auto late = nadir(lidar, scene, range_m);
  CHECK(late.ledger[0].late == late.ledger[0].collected);
}

TEST_CASE("S27: the axis misses and part of the footprint hits; near hits are counted, not recorded") {
  // A half plane x > 0.125 m = w / 2: 1 - Phi(1) = 0.158655 of the energy.
  scene::CompiledScene scene = scene_of({0.3});
  add_rectangle(scene, 0, {0.125, -20, 0}, {20, 0, 0}, {0, 40, 0});
  scene::finish_top_tree(scene);
  scene::Lidar lidar = topographic_lidar();
  lidar.transport.subrays = 1024;
  const auto part = nadir(lidar, scene), all = nadir(lidar, ground(0.3));
  CHECK(moments(part.first).sum / moments(all.first).sum ==
        doctest::Approx(0.158655254).epsilon(4 * 0.00161 / 0.158655));  // 4 rms of 1024 sub-rays
  CHECK(part.ledger[0].escaped == doctest::Approx(1 - 0.158655254).epsilon(4 * 0.00161));
  lidar.transport.minimum_range_m = 1001;
  const auto near = nadir(lidar, ground(0.3));
  CHECK(near.ledger[0].near == doctest::Approx(near.ledger[0].collected).epsilon(1e-6));
  CHECK(*std::max_element(near.first.begin(), near.first.end()) == 0.0f);
}

TEST_CASE("S27: partial targets take their share of a Gaussian footprint") {
  scene::Lidar lidar = topographic_lidar();
  lidar.transport.subrays = 1024;
  const double all = moments(nadir(lidar, ground(0.3)).first).sum;
  const double share[5] = {0.977249868, 0.841344746, 0.5, 0.158655254, 0.022750132};
  for (int i = 0; i < 5; ++i) {
    scene::CompiledScene scene = scene_of({0.3});
    add_rectangle(scene, 0, {(i - 2) * 0.125, -20, 0}, {20, 0, 0}, {0, 40, 0});
    scene::finish_top_tree(scene);
    CHECK(std::abs(moments(nadir(lidar, scene).first).sum / all - share[i]) <= 4 * 0.00161);  // 4 rms of 1024 sub-rays
  }
}

TEST_CASE("S27: a tilted plane broadens the echo by the footprint's depth") {
  scene::Lidar lidar = topographic_lidar();
  lidar.transport.subrays = 4096;
  lidar.gate.bin_s = 0.25e-9;
  lidar.gate.start_s = 6600e-9;
  const double expected_ns[4] = {1.704996, 1.765557, 1.892299, 2.229711}, tilt_deg[4] = {10, 30, 45, 60};
  for (int i = 0; i < 4; ++i) {
    const Moments m = moments(nadir(lidar, ground(0.3, 0, tilt_deg[i] * M_PI / 180)).first);
    const double deviation_ns =
        std::sqrt(m.deviation_bins * m.deviation_bins - 1.0 / 12) * 0.25;  // less the bin's own width
    CHECK(deviation_ns ==
          doctest::Approx(expected_ns[i]).epsilon(1e-3));  // collimated formula: footprint / range, 2.5e-4
  }
}

TEST_CASE("S27: results do not depend on batches, threads, work-groups or order of shots") {
  scene::CompiledScene scene = scene_of({0.3, 0.6});
  add_plane(scene, 0, {0, 0, 0}, 30, 0.2);
  add_plane(scene, 1, {0.1, 0, 3}, 0.4, -0.3);
  scene::finish_top_tree(scene);
  scene::Lidar lidar = topographic_lidar();
  lidar.transport.air_return = true;
  lidar.transport.overlap = scene::LidarOverlap::exact;
  lidar::LidarPlan plan = hand_plan(lidar, scene);
  set_air(plan, 1e-4, 2e-6, -10, 1100);
  std::vector<lidar::Shot> shots;
  for (int i = 0; i < 40; ++i)
    shots.push_back(shot_from(lidar, {0.05 * i - 1, 0.02 * i, 1000}, {0.0001 * i, 0, -1}, i));
  for (std::size_t i = 0; i < shots.size(); ++i) shots[i].exit_m[0] += 0.02 * static_cast<double>(i % 5);  // five beams
  render::RenderOptions few;
  few.threads = 1;
  few.memory_bytes = 400u << 10;  // some shots a batch
  const auto all = render_shots(scene, plan, shots), small = render_shots(scene, plan, shots, few);
  render::RenderOptions grouped;
  grouped.tuning = render::DeviceTuning{{16, {{"lidar_air", 7}, {"lidar_beam", 3}}, true}};
  const auto groups = render_shots(scene, plan, shots, grouped);
  REQUIRE(groups.size() == 40);
  CHECK(std::set<std::vector<float>>{all[0].air, all[20].air, all[39].air}.size() == 3);
  CHECK(!all[0].air.empty());
  std::vector<lidar::Shot> turned(shots.rbegin(), shots.rend());
  const auto back = render_shots(scene, plan, turned);
  REQUIRE(all.size() == 40);
  REQUIRE(small.size() == 40);
  for (std::size_t i = 0; i < 40; ++i) {
    CHECK(all[i].first == small[i].first);
    CHECK(all[i].first == back[39 - i].first);
    CHECK(all[i].first == groups[i].first);
    CHECK(all[i].air == groups[i].air);
    CHECK(all[i].ledger[0].collected == groups[i].ledger[0].collected);
    CHECK(all[i].shot.pulse == static_cast<std::int64_t>(i));
    CHECK(all[i].ledger[0].collected == small[i].ledger[0].collected);
  }
}
