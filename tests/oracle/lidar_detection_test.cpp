// Linear and counting detectors: the specification's numbers, moments of drawn records, thresholds against counts of
// exceedance.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "host/lidar/detection.h"
#include "host/lidar/detector.h"
#include "host/lidar/draws.h"
#include "tests/oracle/lidar_detection_cases.h"
#include "tests/support/chance_checks.h"

using namespace raycube;
using namespace raycube::lidar;

TEST_CASE("L-23: excess noise, variance and signal to noise of a linear detector") {
  CHECK(std::abs(excess_noise(100, 0.02) - 3.9502) < 1e-12);
  CHECK(std::abs(excess_noise(20, 0.2) - 5.56) < 1e-12);
  CHECK(excess_noise(1, 0.3) == 1);
  const double variance = linear_variance(100 + 0.5 + 0.1, 5.56, 300, 20);
  CHECK(std::abs(variance - 784.336) < 1e-9);
  CHECK(std::abs(100 / std::sqrt(variance) - 3.570664) < 5.1e-7);
}

TEST_CASE("L-23: drawn waveforms have that mean and variance, with quantum efficiency and quantisation") {
  LidarPlan plan = test::small_plan(400);
  plan.lidar.receiver.quantum_efficiency = 0.5;
  plan.lidar.detector.mode = scene::DetectorMode::linear;
  plan.lidar.detector.gain = 20, plan.lidar.detector.ionization_ratio = 0.2, plan.lidar.detector.readout_noise_e = 300;
  plan.lidar.detector.dark_rate_hz = 1e8;  // 0.1 a bin
  plan.lidar.detector.full_scale_e = 1000, plan.lidar.detector.bits = 14;
  plan.lidar.echoes.threshold_pe = 1e9;  // noise is looked at here, not echoes
  ShotResult shot = test::empty_shot(plan);
  for (float& bin : shot.first) bin = 200;
  shot.background_hz = {1e9};  // 0.5 a bin
  double sum = 0, squares = 0, n = 0;
  for (int pulse = 0; pulse < 500; ++pulse) {
    shot.shot.pulse = pulse;
    const Detection record = detect(plan, shot).front();
    REQUIRE(record.samples.size() == 400);
    for (std::size_t i = 0; i < 400; ++i) {
      REQUIRE(record.waveform_pe[i] == doctest::Approx(record.offset + record.gain * record.samples[i]).epsilon(1e-5));
      sum += record.waveform_pe[i], squares += std::pow(record.waveform_pe[i] - 100.6, 2), ++n;
    }
  }
  const double variance = 784.336 + std::pow((1000 + 120) / 16383.0, 2) / 12;
  CHECK_WITHIN(sum / n - 100.6, 4 * std::sqrt(variance / n));
  CHECK_WITHIN(squares / n / variance - 1, 4 * std::sqrt(2.4 / n));  // kurtosis of a gamma-mixed count 3.4
}

TEST_CASE(
    "L-23: response of the electronics keeps the charge and adds widths in quadrature; full scale clips and says so") {
  const auto taps = response_taps(3e-9, 1e-9);
  double total = 0, second = 0;
  for (std::size_t i = 0; i < taps.size(); ++i) {
    const double at = static_cast<double>(i) - static_cast<double>(taps.size() / 2);
    total += taps[i], second += taps[i] * at * at;
  }
  CHECK(total == doctest::Approx(1).epsilon(1e-15));
  CHECK(
      second ==
      doctest::Approx(std::pow(3 * test::kSigmaOfFwhm, 2) + 1.0 / 12).epsilon(1e-7));  // a bin's own width comes on top
  CHECK(response_taps(0, 1e-9).size() == 1);

  LidarPlan plan = test::small_plan();
  plan.lidar.detector.mode = scene::DetectorMode::linear;
  plan.lidar.detector.response_fwhm_s = 3e-9;
  ShotResult shot = test::empty_shot(plan);
  test::add_return(shot.first, 1e6, 100.3, 4 * test::kSigmaOfFwhm);
  const Detection expected = expected_detections(plan, shot).front();
  REQUIRE(expected.echoes.size() == 1);
  CHECK(expected.echoes[0].fwhm_s ==
        doctest::Approx(std::sqrt(16 + 9 + 1 / (12 * test::kSigmaOfFwhm * test::kSigmaOfFwhm)) * 1e-9).epsilon(1e-3));
  CHECK(expected.echoes[0].energy_pe == doctest::Approx(1e6).epsilon(1e-4));
  CHECK(!expected.truth.saturated);
  plan.lidar.detector.full_scale_e = 1e5, plan.lidar.detector.bits = 12;
  const Detection clipped = detect(plan, shot).front();
  CHECK(clipped.truth.saturated);
  REQUIRE(!clipped.echoes.empty());
  CHECK(clipped.echoes[0].saturated);
  CHECK(*std::max_element(clipped.samples.begin(), clipped.samples.end()) == 4095);
  plan.lidar.detector.full_scale_e = 0;
  const Detection automatic = detect(plan, shot).front();
  CHECK(!automatic.truth.saturated);
  CHECK(std::exp2(std::round(std::log2(automatic.gain * 4095))) ==
        doctest::Approx(automatic.gain * 4095).epsilon(1e-12));
}

TEST_CASE("S38: counts are exact Poisson draws of the expectation, background and dark counts included") {
  LidarPlan plan = test::small_plan(1000);
  plan.lidar.detector.dark_rate_hz = 2e8;
  ShotResult shot = test::empty_shot(plan);
  for (std::size_t i = 0; i < 1000; ++i) shot.first[i] = static_cast<float>(i) * 0.01F;
  plan.lidar.echoes.threshold_pe = 1e9;  // counts are looked at here, not echoes
  shot.multiple.assign(1000, 0.3F), shot.air.assign(1000, 0.2F);
  shot.background_hz = {3e8};
  double sum = 0, chi = 0, n = 0;
  for (int pulse = 0; pulse < 100; ++pulse) {
    shot.shot.pulse = pulse;
    const Detection record = detect(plan, shot).front();
    for (std::size_t i = 0; i < 1000; ++i) {
      const double mean = 0.01 * static_cast<double>(i) + 1, z = record.waveform_pe[i] - mean;
      REQUIRE(record.samples[i] == record.waveform_pe[i]);
      sum += z, chi += z * z / mean, ++n;
    }
  }
  CHECK_WITHIN(sum / n, 4 * std::sqrt(6.0 / n));
  CHECK_WITHIN(chi / n - 1, 4 * std::sqrt((2 + 1.0) / n));  // variance of chi^2 of a count: 2 + 1 / mean
}

TEST_CASE("S38: a record is a function of seed, pulse, pixel and line alone") {
  LidarPlan plan = test::small_plan();
  plan.lidar.receiver.columns = 3;
  plan.lidar.receiver.pixel_pitch_rad = 1e-4;
  plan.lidar.pulse.lines.push_back(plan.lidar.pulse.lines[0]);
  plan.photons = {1e14, 1e14};
  ShotResult shot = test::empty_shot(plan, 11);
  for (float& bin : shot.first) bin = 5;
  const auto all = detect(plan, shot);
  REQUIRE(all.size() == 6);
  for (std::size_t i = 0; i < 6; ++i) {
    CHECK(all[i].pixel == static_cast<int>(i / 2));
    CHECK(all[i].line == static_cast<int>(i % 2));
    for (std::size_t j = 0; j < i; ++j) CHECK(all[i].waveform_pe != all[j].waveform_pe);
  }
  CHECK(detect(plan, shot)[3].waveform_pe == all[3].waveform_pe);
  shot.shot.pulse = 12;
  CHECK(detect(plan, shot)[3].waveform_pe != all[3].waveform_pe);
}

TEST_CASE("S38: probability of detection and false alarms against counted exceedances") {
  for (const auto mode : {scene::DetectorMode::photons, scene::DetectorMode::linear}) {
    LidarPlan plan = test::small_plan(256);
    plan.lidar.detector.mode = mode;
    plan.lidar.detector.dark_rate_hz = 5e8, plan.lidar.echoes.threshold_sigma = 2.5,
    plan.lidar.echoes.method = scene::EchoMethod::peak;
    if (mode == scene::DetectorMode::linear) {
      plan.lidar.detector.readout_noise_e = 40, plan.lidar.detector.gain = 20,
      plan.lidar.detector.ionization_ratio = 0.02;
      plan.lidar.detector.full_scale_e = 200;
    }
    ShotResult shot = test::empty_shot(plan);
    for (std::size_t i = 0; i < 128; ++i) shot.first[i] = 8;
    int seen = 0, alarms = 0;
    constexpr int pulses = 400;
    DetectionTruth truth;
    for (int pulse = 0; pulse < pulses; ++pulse) {
      shot.shot.pulse = pulse;
      const Detection record = detect(plan, shot).front();
      truth = record.truth;
      for (std::size_t i = 0; i < 256; ++i)
        (i < 128 ? seen : alarms) += record.waveform_pe[i] - 0.5 >= truth.threshold_pe;
    }
    const double n = 128.0 * pulses, p = truth.detection_probability, q = truth.false_alarm_rate_hz * 1e-9;
    CAPTURE(static_cast<int>(mode));
    CHECK(truth.background_pe == doctest::Approx(0.5).epsilon(1e-12));
    // The linear detector's sum of carriers is taken as Gaussian: skewness 3 F / 2 / sqrt(8 F) shifts the tail by up to
    // 3 % here.
    const double model = mode == scene::DetectorMode::linear ? 0.03 : 0;
    CHECK_WITHIN(seen / n - p, 4 * std::sqrt(p * (1 - p) / n) + model);
    if (mode == scene::DetectorMode::photons) CHECK_WITHIN(alarms / n - q, 4 * std::sqrt(q * (1 - q) / n));
  }
}

TEST_CASE("S38: probability of counts with speckle: the exact sum against the thermal limit and against many counts") {
  // One mode: P(K >= k) = (N / (1 + N))^k.
  CHECK(count_at_least(5, 3, 0, 1) == doctest::Approx(std::pow(0.75, 5)).epsilon(1e-12));
  CHECK(count_at_least(1, 1.7, 0, 0) == doctest::Approx(-std::expm1(-1.7)).epsilon(1e-12));
  CHECK(count_at_least(1, 1.0, 0.7, 0) == doctest::Approx(-std::expm1(-1.7)).epsilon(1e-12));
  CHECK(count_at_least(5001, 5000, 10, 0) == doctest::Approx(normal_tail(-9.5 / std::sqrt(5010.0))).epsilon(1e-9));
  CHECK(count_at_least(0, 0, 0, 0) == 1);
  CHECK(count_at_least(3, 0, 0, 0) == 0);
}

TEST_CASE("S63: no NaN for zero efficiency, zero pulse width, empty rows and huge ones") {
  for (const auto mode : {scene::DetectorMode::photons, scene::DetectorMode::linear, scene::DetectorMode::geiger})
    for (const double efficiency : {0.0, 1.0})
      for (const double fwhm : {0.0, 4e-9})
        for (const float level : {0.0F, 3.0F, 1e12F}) {
          LidarPlan plan = test::small_plan(64);
          plan.lidar.detector.mode = mode;
          plan.lidar.receiver.quantum_efficiency = efficiency;
          plan.lidar.pulse.fwhm_s = fwhm;
          plan.lidar.speckle.on = true;
          plan.lidar.detector.dead_time_s = 10e-9;
          ShotResult shot = test::empty_shot(plan);
          shot.first[30] = level;
          for (const auto& record : {detect(plan, shot).front(), expected_detections(plan, shot).front()}) {
            for (const float value : record.waveform_pe) REQUIRE(std::isfinite(value));
            for (const Echo& echo : record.echoes) {
              REQUIRE(std::isfinite(echo.time_s));
              REQUIRE(std::isfinite(echo.energy_pe));
              REQUIRE(std::isfinite(echo.fwhm_s));
              REQUIRE(echo.detection_probability >= 0);
              REQUIRE(echo.detection_probability <= 1);
            }
            REQUIRE(std::isfinite(record.truth.detection_probability));
            REQUIRE(std::isfinite(record.truth.false_alarm_rate_hz));
          }
        }
}

TEST_CASE("S38: a detector's memory of records before leaves no trace, and dark bins left out are those that are 0") {
  LidarPlan plan = test::small_plan(600);
  for (const auto mode : {scene::DetectorMode::photons, scene::DetectorMode::linear})
    for (const double response_s : {0.0, 3e-9})
      for (const double dark_hz : {0.0, 1e7}) {
        plan.lidar.detector.mode = mode;
        plan.lidar.detector.response_fwhm_s = response_s;
        plan.lidar.echoes.method = response_s > 0 ? scene::EchoMethod::gaussian : scene::EchoMethod::constant_fraction;
        plan.lidar.detector.dark_rate_hz = dark_hz;
        plan.lidar.detector.bits = 12;
        Detecting detecting(plan);
        std::vector<Detection> records;
        for (int pulse = 0; pulse < 6; ++pulse) {
          ShotResult shot = test::empty_shot(plan, pulse);
          if (pulse == 3) shot.first[223] = 50;  // one bin alone: first and last that are not dark
          // Each beside the stronger one before it.
          if (pulse != 3) test::add_return(shot.first, 30000 / (1 + 10 * pulse), 200 + 9 * pulse, 1.7);
          if (pulse % 2 == 0) test::add_return(shot.first, 50, 580, 1.7);
          detecting.expect(shot, records);
          const Detection expected = expected_detections(plan, shot).front();
          REQUIRE(records.front().echoes.size() == expected.echoes.size());
          for (std::size_t i = 0; i < expected.echoes.size(); ++i) {
            CHECK(records.front().echoes[i].time_s == expected.echoes[i].time_s);
            CHECK(records.front().echoes[i].energy_pe == expected.echoes[i].energy_pe);
          }
          detecting.detect(shot, records);
          const Detection fresh = detect(plan, shot).front(), &kept = records.front();
          CHECK(kept.waveform_pe == fresh.waveform_pe);
          CHECK(kept.samples == fresh.samples);
          REQUIRE(kept.echoes.size() == fresh.echoes.size());
          for (std::size_t i = 0; i < kept.echoes.size(); ++i) CHECK(kept.echoes[i].time_s == fresh.echoes[i].time_s);
          CHECK(kept.truth.detection_probability == fresh.truth.detection_probability);
          CHECK(kept.truth.false_alarm_rate_hz == fresh.truth.false_alarm_rate_hz);
          if (mode == scene::DetectorMode::photons) {  // bin by bin, by the draws' definition
            const double dark = dark_hz * plan.lidar.gate.bin_s;
            for (std::size_t i = 0; i < kept.waveform_pe.size(); ++i)
              CHECK(kept.waveform_pe[i] == static_cast<float>(Stream(plan.seed, draw_key(plan, pulse, 0),
                                                                     static_cast<std::uint32_t>(i), DrawFor::counts, 0)
                                                                  .poisson(shot.first[i] + dark)));
          }
        }
      }
}
