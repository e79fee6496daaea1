// False returns: thresholds relative to noise, background and the air's return, against drawn noise.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "host/lidar/detection.h"
#include "host/lidar/detector.h"
#include "host/lidar/draws.h"
#include "tests/oracle/lidar_detection_cases.h"
#include "tests/support/chance_checks.h"

using namespace raycube;
using namespace raycube::lidar;

namespace {

constexpr double kSigmaBins = 4 * test::kSigmaOfFwhm;
constexpr int kBins = 800;

/// Air that fades from 300 to 1 photo-electron a bin and ends at the ground, as a survey's gate from the exit
/// on sees it.
LidarPlan airy_plan(scene::DetectorMode mode) {
  LidarPlan plan = test::small_plan(kBins);
  plan.lidar.detector.mode = mode;
  plan.lidar.detector.dark_rate_hz = 3e8;
  plan.lidar.echoes.method = scene::EchoMethod::peak;
  plan.lidar.echoes.air_is_background = true;
  if (mode == scene::DetectorMode::linear) {
    plan.lidar.detector.gain = 20, plan.lidar.detector.ionization_ratio = 0.2, plan.lidar.detector.readout_noise_e = 60;
    plan.lidar.detector.full_scale_e = 4000;
  }
  return plan;
}

ShotResult airy_shot(const LidarPlan& plan) {
  ShotResult shot = test::empty_shot(plan);
  shot.air.assign(shot.first.size(), 0.0F);
  for (int i = 0; i < kBins - 100; ++i)
    shot.air[static_cast<std::size_t>(i)] = static_cast<float>(300 * std::exp(-i / 120.0));
  return shot;
}

int echoes_of(const LidarPlan& plan, ShotResult& shot, int pulses) {
  int found = 0;
  for (int pulse = 0; pulse < pulses; ++pulse) {
    shot.shot.pulse = pulse;
    found += static_cast<int>(detect(plan, shot).front().echoes.size());
  }
  return found;
}

}  // namespace

TEST_CASE("false returns of a record stay below what was asked for, in air and out of it") {
  for (const auto mode : {scene::DetectorMode::photons, scene::DetectorMode::linear}) {
    LidarPlan plan = airy_plan(mode);
    ShotResult shot = airy_shot(plan);
    constexpr int pulses = 1500;
    for (const double wanted : {0.5, 0.05}) {
      plan.lidar.echoes.false_returns = wanted;
      const int found = echoes_of(plan, shot, pulses);
      CAPTURE(static_cast<int>(mode));
      CAPTURE(wanted);
      // Four standard errors of the count; a linear bin's chance is known to 40 %.
      const double most = wanted * pulses * (mode == scene::DetectorMode::linear ? 1.4 : 1);
      CHECK_BELOW(found, most + 4 * std::sqrt(most));
      // Not by being blind: counts come in steps and crossings beside each other are one return.
      CHECK_ABOVE(found, 0.2 * wanted * pulses);
    }
  }
}

TEST_CASE("air that is no background makes returns of its own") {
  LidarPlan plan = airy_plan(scene::DetectorMode::photons);
  plan.lidar.echoes.false_returns = 0.01;
  ShotResult shot = airy_shot(plan);
  const int background = echoes_of(plan, shot, 50);
  plan.lidar.echoes.air_is_background = false;
  CHECK(background <= 3);
  CHECK(echoes_of(plan, shot, 50) > 50);
}

TEST_CASE(
    "surfaces behind and in the air are found where they are, with what they sent back, as often as "
    "foretold") {
  for (const auto mode : {scene::DetectorMode::photons, scene::DetectorMode::linear}) {
    LidarPlan plan = airy_plan(mode);
    plan.lidar.echoes.false_returns = 0.01, plan.lidar.echoes.method = scene::EchoMethod::gaussian;
    for (const double at : {60.3, 400.6, 750.2}) {
      ShotResult shot = airy_shot(plan);
      test::add_return(shot.first, 4000, at, kSigmaBins);
      double mean_m = 0, energy = 0;
      constexpr int pulses = 200;
      for (int pulse = 0; pulse < pulses; ++pulse) {
        shot.shot.pulse = pulse;
        const auto echoes = detect(plan, shot).front().echoes;
        const auto strongest = std::max_element(echoes.begin(), echoes.end(),
                                                [](const Echo& a, const Echo& b) { return a.energy_pe < b.energy_pe; });
        REQUIRE(strongest != echoes.end());
        REQUIRE(strongest->chance < 1e-9F);
        mean_m += ((strongest->time_s - plan.lidar.gate.start_s) / 1e-9 - at) / pulses;
        energy += static_cast<double>(strongest->energy_pe) / pulses;
      }
      CAPTURE(static_cast<int>(mode));
      CAPTURE(at);
      // sigma / sqrt(N) of the photons over all pulses, twice for excess noise and the air's own.
      CHECK_WITHIN(mean_m, 4 * 2.4 * kSigmaBins / std::sqrt(4000.0 * pulses) * (at < 100 ? 2 : 1));
      CHECK_WITHIN(energy / 4000 - 1, 0.02);
    }
    // Weak ones: the probability of detection of the highest bin, where a neighbour can make up for it.
    ShotResult shot = airy_shot(plan);
    test::add_return(shot.first, mode == scene::DetectorMode::linear ? 1400 : 350, 200.5, kSigmaBins);
    int seen = 0;
    double foretold = 0;
    constexpr int pulses = 400;
    for (int pulse = 0; pulse < pulses; ++pulse) {
      shot.shot.pulse = pulse;
      const Detection record = detect(plan, shot).front();
      foretold = record.truth.detection_probability;
      seen += std::any_of(record.echoes.begin(), record.echoes.end(), [&](const Echo& e) {
        return std::abs((e.time_s - plan.lidar.gate.start_s) / 1e-9 - 200.5) < 6;
      });
    }
    CAPTURE(static_cast<int>(mode));
    CHECK(foretold > 0.1);
    CHECK_ABOVE(seen / static_cast<double>(pulses), foretold - 4 * std::sqrt(0.25 / pulses));
    CHECK_BELOW(seen / static_cast<double>(pulses), std::min(1.0, 3 * foretold) + 4 * std::sqrt(0.25 / pulses));
  }
}

TEST_CASE("chance of a linear detector's noise, against drawn avalanches: not a Gaussian's") {
  scene::Lidar lidar = airy_plan(scene::DetectorMode::linear).lidar;
  lidar.echoes.false_returns = 0.01;
  constexpr int draws = 1000000;
  for (const double carriers : {0.3, 3.0, 30.0})
    for (const double readout_e : {0.0, 100.0}) {
      lidar.detector.readout_noise_e = readout_e;
      DetectorNoise noise = detector_noise(lidar, carriers, 1000);
      std::vector<double> values(draws);
      const double spread = noise.excess - 1;
      for (int i = 0; i < draws; ++i) {
        Stream counts(raycube::testing::seed(1), static_cast<std::uint32_t>(i), 0, DrawFor::counts),
            gains(raycube::testing::seed(1), static_cast<std::uint32_t>(i), 0, DrawFor::gain);
        Stream floor(raycube::testing::seed(1), static_cast<std::uint32_t>(i), 0, DrawFor::readout);
        const double n = counts.poisson(carriers);
        values[static_cast<std::size_t>(i)] =
            (n > 0 ? spread * gains.gamma(n / spread) : 0) - carriers + noise.floor * floor.normal();
      }
      for (const double sigmas : {3.0, 4.5}) {
        const double level = sigmas * noise.rms();
        const double seen =
            static_cast<double>(std::count_if(values.begin(), values.end(), [&](double v) { return v >= level; })) /
            draws;
        const double chance = noise_chance(lidar, noise, 0, level);
        CAPTURE(carriers);
        CAPTURE(readout_e);
        CAPTURE(sigmas);
        CHECK_WITHIN(chance - seen, 0.4 * seen + 4 * std::sqrt(seen / draws));
        CHECK_ABOVE(chance, 1.5 * normal_tail(sigmas));
      }
      // The threshold is where chance is what was asked for.
      CHECK(noise_chance(lidar, noise, 0, noise.threshold) == doctest::Approx(noise.bin_chance).epsilon(1e-4));
    }
}

TEST_CASE(
    "the chance of a return is that of its highest bin in all of a record, and expectations have none of "
    "noise") {
  LidarPlan plan = airy_plan(scene::DetectorMode::photons);
  plan.lidar.echoes.false_returns = 100;
  ShotResult shot = airy_shot(plan);
  int doubtful = 0, firm = 0;
  for (int pulse = 0; pulse < 200; ++pulse) {
    shot.shot.pulse = pulse;
    for (const Echo& echo : detect(plan, shot).front().echoes) {
      REQUIRE(echo.chance > 0);
      REQUIRE(echo.chance <= 100 * (1 + 1e-6));
      (echo.chance > 0.05F ? doubtful : firm) += 1;
    }
  }
  // Of 200 records without any return 0.05 each are that unlikely.
  CHECK_ABOVE(doubtful, 200);
  CHECK_BELOW(firm, 10 + 4 * std::sqrt(10.0));
  plan.lidar.echoes.false_returns = 0.01;
  CHECK(expected_detections(plan, shot).front().echoes.empty());
  test::add_return(shot.first, 4000, 300, kSigmaBins);
  CHECK(expected_detections(plan, shot).front().echoes.size() == 1);
}

TEST_CASE("a threshold between two counts takes the higher one, in air and out of it") {
  LidarPlan plan = airy_plan(scene::DetectorMode::photons);
  plan.lidar.echoes.false_returns = 1e3;  // every bin's noise may pass: the threshold alone decides
  plan.lidar.echoes.threshold_pe = 5.4;
  DetectorNoise noise = detector_noise(plan.lidar, 1.0, 100);
  noise.air = {0.0, 0.5};
  for (const std::size_t bin : {std::size_t{0}, std::size_t{1}}) {
    const double below = noise.background + noise.air_at(bin);  // values are counts less what is expected
    CHECK_FALSE(reaches_threshold(plan.lidar, noise, bin, 5 - below));
    CHECK(reaches_threshold(plan.lidar, noise, bin, 6 - below));
  }
}
