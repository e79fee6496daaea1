// Echoes: time, width and area of known returns by each method; separability; precision against the bound; order and
// count.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "host/lidar/detection.h"
#include "host/lidar/detector.h"
#include "host/lidar/echoes.h"
#include "host/lidar/normal_edges.h"
#include "host/lidar/pulse_taps.h"
#include "tests/oracle/lidar_detection_cases.h"
#include "tests/support/chance_checks.h"

using namespace raycube;
using namespace raycube::lidar;

namespace {

constexpr double kHalfLight = 0.5 * 299792458.0, kSigmaBins = 4 * test::kSigmaOfFwhm;

std::vector<Echo> expected_echoes(LidarPlan& plan, const std::vector<float>& row) {
  ShotResult shot = test::empty_shot(plan);
  shot.first = row;
  return expected_detections(plan, shot).front().echoes;
}

}  // namespace

TEST_CASE("S40: one return of known time, width and area, by every method, at any place within a bin") {
  for (const auto method :
       {scene::EchoMethod::peak, scene::EchoMethod::constant_fraction, scene::EchoMethod::gaussian}) {
    LidarPlan plan = test::small_plan();
    plan.lidar.echoes.method = method;
    // Bins of 0.59 sigma: the logarithm of a bin's integral is a parabola, of variance s^2 + 1/12, but for terms of
    // (bin/s)^4 / 480.
    const double place = method == scene::EchoMethod::gaussian ? 1e-4 : 3e-3;
    for (double f = 0; f < 1; f += 0.125) {
      std::vector<float> row(200, 0.0F);
      test::add_return(row, 5000, 80 + f, kSigmaBins);
      const auto echoes = expected_echoes(plan, row);
      CAPTURE(static_cast<int>(method));
      CAPTURE(f);
      REQUIRE(echoes.size() == 1);
      CHECK(std::abs(echoes[0].time_s / 1e-9 - 6680 - f) < place);
      CHECK(echoes[0].range_m == doctest::Approx(kHalfLight * echoes[0].time_s).epsilon(1e-14));
      CHECK(echoes[0].energy_pe == doctest::Approx(5000).epsilon(method == scene::EchoMethod::gaussian ? 1e-5 : 5e-3));
      CHECK(echoes[0].fwhm_s == doctest::Approx(4e-9).epsilon(method == scene::EchoMethod::gaussian ? 1e-4 : 3e-3));
      CHECK(echoes[0].peak_pe == doctest::Approx(5000 * std::erf(0.5 / (kSigmaBins * std::sqrt(2.0)))).epsilon(0.05));
      CHECK(echoes[0].detection_probability == doctest::Approx(1).epsilon(1e-6));
      CHECK(echoes[0].number == 1);
      CHECK(echoes[0].of == 1);
    }
  }
}

TEST_CASE("L-13: two equal Gaussian echoes show two maxima only if further apart than 2 s") {
  CHECK(std::abs(2 * test::kSigmaOfFwhm * 4e-9 * kHalfLight - 0.509) < 5e-4);
  CHECK(std::abs(kHalfLight * 4e-9 - 0.5996) < 5e-5);
  for (const double apart : {1.8, 1.95, 2.05, 2.2, 3.0}) {
    LidarPlan plan = test::small_plan(800);
    plan.lidar.echoes.method = scene::EchoMethod::peak;
    plan.lidar.pulse.fwhm_s = 40e-9;  // bins of 1/17 sigma
    std::vector<float> row(800, 0.0F);
    const double sigma = 40 * test::kSigmaOfFwhm;
    test::add_return(row, 1e5, 400.5 - 0.5 * apart * sigma, sigma),
        test::add_return(row, 1e5, 400.5 + 0.5 * apart * sigma, sigma);
    CAPTURE(apart);
    CHECK(expected_echoes(plan, row).size() == (apart > 2 ? 2 : 1));
  }
}

TEST_CASE("S40: Gaussian decomposition parts overlapping echoes, also under one maximum") {
  LidarPlan plan = test::small_plan();
  for (const double apart : {1.5, 1.9, 2.5, 4.0, 8.0}) {
    std::vector<float> row(200, 0.0F);
    test::add_return(row, 5000, 90.2, kSigmaBins), test::add_return(row, 3500, 90.2 + apart * kSigmaBins, kSigmaBins);
    const auto echoes = expected_echoes(plan, row);
    CAPTURE(apart);
    REQUIRE(echoes.size() == 2);
    CHECK(std::abs(echoes[0].time_s / 1e-9 - 6690.2) < 2e-2);
    CHECK(std::abs(echoes[1].time_s / 1e-9 - 6690.2 - apart * kSigmaBins) < 2e-2);
    CHECK(echoes[0].energy_pe == doctest::Approx(5000).epsilon(0.02));
    CHECK(echoes[1].energy_pe == doctest::Approx(3500).epsilon(0.02));
    CHECK(echoes[1].number == 2);
    CHECK(echoes[1].of == 2);
  }
  std::vector<float> row(200, 0.0F);
  for (int i = 0; i < 5; ++i) test::add_return(row, 1000 + 500 * i, 60.3 + 5 * i, kSigmaBins);
  const auto five = expected_echoes(plan, row);
  REQUIRE(five.size() == 5);
  for (int i = 0; i < 5; ++i) {
    CHECK(std::abs(five[static_cast<std::size_t>(i)].time_s / 1e-9 - 6660.3 - 5 * i) < 2e-2);
    CHECK(five[static_cast<std::size_t>(i)].energy_pe == doctest::Approx(1000 + 500 * i).epsilon(0.02));
  }
}

TEST_CASE("S40: precision against the bound (c/2) s / sqrt(N), counts drawn") {
  // Every photon is counted, none else: the Gaussian method is maximum likelihood and should reach the bound of binned
  // data, s^2 + bin^2/12 in place of s^2; the others stay within the factor stated. N = 1500 pulses: error of a
  // deviation 1.8 %, 4 of them.
  struct Row {
    scene::EchoMethod method;
    double photons, factor;
  };
  for (const Row& r : {Row{scene::EchoMethod::gaussian, 1000, 1.03}, Row{scene::EchoMethod::gaussian, 1e5, 1.03},
                       Row{scene::EchoMethod::gaussian, 40, 1.12}, Row{scene::EchoMethod::peak, 1000, 1.8},
                       Row{scene::EchoMethod::constant_fraction, 1000, 1.8}}) {
    LidarPlan plan = test::small_plan(60);
    plan.lidar.echoes.method = r.method;
    ShotResult shot = test::empty_shot(plan);
    test::add_return(shot.first, r.photons, 30.4, kSigmaBins);
    double sum = 0, squares = 0, area = 0, area_squares = 0;
    constexpr int pulses = 1500;
    int single = 0;
    for (int pulse = 0; pulse < pulses; ++pulse) {
      shot.shot.pulse = pulse;
      const auto echoes = detect(plan, shot).front().echoes;
      if (echoes.size() != 1) continue;
      ++single;
      const double z = (echoes[0].time_s / 1e-9 - 6630.4) / kSigmaBins;
      sum += z, squares += z * z;
      const double counted = static_cast<double>(echoes[0].energy_pe) / r.photons;
      area += counted, area_squares += counted * counted;
    }
    CAPTURE(static_cast<int>(r.method));
    CAPTURE(r.photons);
    CHECK(single > 0.99 * pulses);
    const double bound = std::sqrt((1 + 1 / (12 * kSigmaBins * kSigmaBins)) / r.photons), mean = sum / single;
    const double deviation = std::sqrt(squares / single - mean * mean);
    CAPTURE(deviation / bound);
    CHECK_BELOW(deviation, bound * r.factor * (1 + 4 / std::sqrt(2.0 * pulses)));
    CHECK_ABOVE(deviation, bound * (1 - 4 / std::sqrt(2.0 * pulses)) * 0.97);
    if (r.method == scene::EchoMethod::gaussian) {
      CHECK_WITHIN(mean, 4 * deviation / std::sqrt(single));
      // Areas of forty photons scatter by 1.4 of what counts do: the fit's width goes with them.
      const double mean_area = area / single, own = std::sqrt(area_squares / single - mean_area * mean_area);
      CHECK_WITHIN(mean_area - 1, 4 * own / std::sqrt(single) + 0.002);
    }
  }
}

TEST_CASE("S40: thresholds from the noise, number of returns, false returns of noise alone") {
  LidarPlan plan = test::small_plan(1000);
  plan.lidar.detector.dark_rate_hz = 2e8;
  const double usual = plan.lidar.echoes.false_returns;
  plan.lidar.echoes.false_returns = 2;  // a record: hundreds in all, of which chance takes little
  ShotResult shot = test::empty_shot(plan);
  int found = 0;
  double alarm_hz = 0;
  constexpr int pulses = 300;
  for (int pulse = 0; pulse < pulses; ++pulse) {
    shot.shot.pulse = pulse;
    const Detection record = detect(plan, shot).front();
    found += static_cast<int>(record.echoes.size()), alarm_hz = record.truth.false_alarm_rate_hz;
  }
  // Each crossing can make one echo at most; crossings are counted by bin, so echoes stay below.
  const double bins = alarm_hz * 1e-6 * pulses;
  CHECK_BELOW(found, bins + 4 * std::sqrt(bins));
  CHECK_ABOVE(found, 0.3 * bins);

  plan.lidar.echoes.false_returns = usual, plan.lidar.echoes.max_returns = 2;
  for (int i = 0; i < 6; ++i) test::add_return(shot.first, 2000.0 + 300 * (i % 4), 100 + 120 * i, kSigmaBins);
  const auto echoes = detect(plan, shot).front().echoes;
  REQUIRE(echoes.size() == 2);
  CHECK(echoes[0].time_s < echoes[1].time_s);
  CHECK(echoes[0].energy_pe > 2400);
  plan.lidar.echoes.max_returns = 15, plan.lidar.echoes.threshold_pe = 40;
  CHECK(detect(plan, shot).front().echoes.size() == 6);
  plan.lidar.echoes.threshold_pe = 5000;
  CHECK(detect(plan, shot).front().echoes.empty());
}

TEST_CASE(
    "S40: air before a strong return is one echo, and a return of 10^8 photo-electrons is not taken apart by its "
    "pulse's faint tails") {
  LidarPlan plan = test::small_plan(120);
  ShotResult shot = test::empty_shot(plan);
  for (std::size_t i = 0; i < 70; ++i) shot.first[i] = 300 - 2 * static_cast<float>(i);
  // A pulse with a tail of 1e-4 of its energy, 1 ns late and half as wide again: no Gaussian is exact.
  test::add_return(shot.first, 1e8, 80.3, kSigmaBins), test::add_return(shot.first, 1e4, 81.3, 1.5 * kSigmaBins);
  int two = 0;
  constexpr int pulses = 300;
  for (int pulse = 0; pulse < pulses; ++pulse) {
    shot.shot.pulse = pulse;
    const auto echoes = detect(plan, shot).front().echoes;
    two += echoes.size() == 2;
    REQUIRE(!echoes.empty());
    // Not the last one: without noise one photon is a return, and in one pulse of a thousand one of the tail falls that
    // far behind.
    const auto strongest = std::max_element(echoes.begin(), echoes.end(),
                                            [](const Echo& a, const Echo& b) { return a.energy_pe < b.energy_pe; });
    REQUIRE(std::abs(strongest->time_s / 1e-9 - 6680.3) < 2e-3);
  }
  CHECK(two > 0.95 * pulses);
}

TEST_CASE("S40: a threshold is reached by a peak of exactly so many photo-electrons") {
  scene::Lidar lidar = test::small_plan().lidar;
  DetectorNoise noise;
  noise.excess = 0, noise.threshold = 40;
  std::vector<float> wave(50, 0.0F);
  for (const auto method :
       {scene::EchoMethod::peak, scene::EchoMethod::constant_fraction, scene::EchoMethod::gaussian}) {
    lidar.echoes.method = method;
    wave[19] = wave[21] = 20, wave[20] = 40;
    CHECK(find_echoes(lidar, wave, noise).size() == 1);
    wave[20] = std::nextafter(40.0F, 0.0F);
    CHECK(find_echoes(lidar, wave, noise).empty());
  }
  lidar.detector.mode = scene::DetectorMode::linear;
  CHECK(bin_detection(lidar, noise, 40, 0) == 1);
  CHECK(bin_detection(lidar, noise, std::nextafter(40.0, 0.0), 0) == 0);
}

TEST_CASE("S40: two plates 1.1 to 2 widths of the pulse apart, by every method, counts drawn") {
  for (const auto method : {scene::EchoMethod::peak, scene::EchoMethod::constant_fraction, scene::EchoMethod::gaussian})
    for (const double apart : {1.1, 1.25, 1.4, 1.6, 2.0}) {
      LidarPlan plan = test::small_plan();
      plan.lidar.echoes.method = method;
      ShotResult shot = test::empty_shot(plan);
      const double first = 80.3, second = first + 4 * apart;
      test::add_return(shot.first, 1e5, first, kSigmaBins), test::add_return(shot.first, 9e4, second, kSigmaBins);
      CAPTURE(static_cast<int>(method));
      CAPTURE(apart);
      for (int pulse = 0; pulse < 20; ++pulse) {
        shot.shot.pulse = pulse;
        const auto echoes = detect(plan, shot).front().echoes;
        REQUIRE(echoes.size() == 2);
        // 2 cm, as ranges are asked for; shot noise is 0.2 cm.
        CHECK(kHalfLight * std::abs(echoes[0].time_s - 6600e-9 - first * 1e-9) < 0.02);
        CHECK(kHalfLight * std::abs(echoes[1].time_s - 6600e-9 - second * 1e-9) < 0.02);
        CHECK(echoes[0].fwhm_s == doctest::Approx(4e-9).epsilon(0.1));
        CHECK(echoes[1].fwhm_s == doctest::Approx(4e-9).epsilon(0.1));
        CHECK(echoes[0].energy_pe == doctest::Approx(1e5).epsilon(0.1));
        CHECK(echoes[1].energy_pe == doctest::Approx(9e4).epsilon(0.1));
      }
    }
}

TEST_CASE("S40: ranges count from the pulse's declared time, whatever its shape, by every method") {
  // A steep rise and a long fall: t^2 exp(-t / 1.2 ns), 4.1 ns wide; its peak lies at 2.4 ns, its centroid at 3.6 ns.
  for (const double zero_ns : {0.0, 2.4, 3.6})
    for (const auto method :
         {scene::EchoMethod::peak, scene::EchoMethod::constant_fraction, scene::EchoMethod::gaussian}) {
      LidarPlan plan = test::small_plan(120);
      plan.lidar.echoes.method = method;
      scene::LidarPulse& pulse = plan.lidar.pulse;
      pulse.shape = scene::PulseShape::tabulated;
      double area = 0;
      for (int i = 0; i <= 300; ++i) {
        const double t = 0.1 * i;
        pulse.shape_time_s.push_back((t - zero_ns) * 1e-9);
        pulse.shape_power.push_back(t * t * std::exp(-t / 1.2));
        area += 0.1e-9 * pulse.shape_power.back();
      }
      for (double& power : pulse.shape_power) power /= area;
      plan.lidar.echoes.threshold_pe = 5;  // above single photons of the tail, each of which would be a return
      ShotResult shot = test::empty_shot(plan);
      for (const double photons : {300.0, 3e4, 3e6}) {
        double sum = 0;
        constexpr int pulses = 64;
        std::size_t returns = 0;
        for (int number = 0; number < pulses; ++number) {
          const double at = 40 + (number + 0.5) / pulses;  // every place within a bin
          for (std::size_t i = 0; i < shot.first.size(); ++i) {
            const double from = static_cast<double>(i) - at;
            shot.first[i] = static_cast<float>(photons * pulse_share(pulse, from * 1e-9, (from + 1) * 1e-9));
          }
          shot.shot.pulse = number;
          const auto echoes = detect(plan, shot).front().echoes;
          returns += echoes.size();
          const auto strongest = std::max_element(
              echoes.begin(), echoes.end(), [](const Echo& a, const Echo& b) { return a.energy_pe < b.energy_pe; });
          sum += strongest->time_s - 6600e-9 - at * 1e-9;
        }
        CAPTURE(zero_ns);
        CAPTURE(static_cast<int>(method));
        CAPTURE(photons);
        // 2 cm; the mean of 64 pulses of 300 photo-electrons is known to 0.3 cm by the best of methods.
        CHECK(std::abs(kHalfLight * sum / pulses) < 0.02);
        CHECK(returns <= pulses + 3);
      }
    }
}

TEST_CASE("S40: a return that the gate cuts says so") {
  LidarPlan plan = test::small_plan(100);
  ShotResult shot = test::empty_shot(plan);
  for (const double at : {-1.5, 0.5, 50.0, 99.0, 101.5}) {
    std::fill(shot.first.begin(), shot.first.end(), 0.0F);
    test::add_return(shot.first, 1e4, at, kSigmaBins);
    CAPTURE(at);
    for (const Echo& echo : detect(plan, shot).front().echoes) CHECK(echo.cut == (at != 50));
  }
}

TEST_CASE("S40: what particles of volumes send back counts as background where air does") {
  LidarPlan plan = test::small_plan(400);
  plan.lidar.echoes.false_returns = 0.01;
  ShotResult shot = test::empty_shot(plan);
  shot.particles.assign(shot.first.size(), 0.0F);
  for (std::size_t i = 50; i < 350; ++i) shot.first[i] = shot.particles[i] = 0.05F;
  test::add_return(shot.first, 500, 200.5, kSigmaBins);
  for (const bool background : {true, false}) {
    plan.lidar.echoes.air_is_background = background;
    std::size_t returns = 0;
    constexpr int pulses = 200;
    for (int pulse = 0; pulse < pulses; ++pulse) {
      shot.shot.pulse = pulse;
      const auto echoes = detect(plan, shot).front().echoes;
      returns += echoes.size();
      CHECK(std::any_of(echoes.begin(), echoes.end(),
                        [](const Echo& echo) { return std::abs(echo.time_s - 6800.5e-9) < 1e-9; }));
    }
    // One is the surface's; asked for are at most 0.05 beside it.
    if (background)
      CHECK(returns <= 1.05 * pulses);
    else
      CHECK(returns > 5 * pulses);
  }
}

TEST_CASE("S39: clusters of time tags are echoes") {
  scene::Lidar lidar = test::small_plan().lidar;
  lidar.detector.mode = scene::DetectorMode::geiger;
  lidar.echoes.threshold_pe = 2;
  const auto echoes = cluster_tags(lidar, {{10e-9, 0}, {50e-9, 0}, {51e-9, 1}, {52.5e-9, 2}, {90e-9, 1}, {91e-9, 0}});
  REQUIRE(echoes.size() == 2);
  CHECK(echoes[0].time_s == doctest::Approx((50 + 51 + 52.5) / 3 * 1e-9).epsilon(1e-12));
  CHECK(echoes[0].energy_pe == 3);
  CHECK(echoes[1].energy_pe == 2);
  CHECK(echoes[1].of == 2);
  CHECK(cluster_tags(lidar, {}).empty());
}

TEST_CASE("S40: the normal at the edges of bins, against the library's error function and exponential") {
  for (const double step : {0.013, 0.4, 3.0}) {
    std::vector<double> tail(901), density(901);
    const double first = -450 * step;
    normal_edges(first, step, tail.size(), tail.data(), density.data());
    for (std::size_t i = 0; i < tail.size(); ++i) {
      const double z = std::min(10.0, std::abs(first + static_cast<double>(i) * step));
      CAPTURE(z);
      CHECK(std::abs(tail[i] / (0.5 * std::erfc(z / std::sqrt(2.0))) - 1) < 3e-14);
      CHECK(std::abs(density[i] * std::sqrt(2 * M_PI) / std::exp(-0.5 * z * z) - 1) < 2e-15);
    }
  }
}

TEST_CASE("S40: a fit has the weighted least squares that its definition asks for, of one echo and of five") {
  // Stationary: no parameter's slope of chi^2 is left, held against differences of chi^2 itself.
  std::vector<double> data(160, 0.0);
  const std::vector<GaussianEcho> truth = {
      {900, 30.3, 1.7}, {400, 40, 2.0}, {1500, 52.8, 1.8}, {300, 60, 1.7}, {2000, 100, 4}};
  for (std::size_t i = 0; i < data.size(); ++i) {
    for (const auto& echo : truth) data[i] += gaussian_bin(echo, static_cast<double>(i));
    data[i] += std::sin(1.7 * static_cast<double>(i)) * std::sqrt(data[i]);
  }
  GaussianFit fit;
  for (const bool one : {true, false}) {
    std::vector<GaussianEcho> echoes = truth;
    if (one) echoes = {{1800, 99, 5}};
    const std::size_t first = one ? 75 : 10, last = one ? 130 : 150;
    fit.roughly(data, first, last, 0.5, 1.0, echoes);
    for (int pass = 0; pass < 6; ++pass) fit.finish(0.5, 1.0, echoes);  // until weights are those of the solution
    const auto model = [&](const std::vector<GaussianEcho>& of, std::size_t i) {
      double sum = 0;
      for (const auto& echo : of) sum += gaussian_bin(echo, static_cast<double>(i));
      return sum;
    };
    const auto chi = [&](const std::vector<GaussianEcho>& of) {
      double sum = 0;
      for (std::size_t i = first; i < last; ++i)
        sum += std::pow(data[i] - model(of, i), 2) / (0.25 + model(echoes, i) + 0.3);
      return sum;
    };
    const double least = chi(echoes);
    for (std::size_t k = 0; k < echoes.size(); ++k)
      for (int parameter = 0; parameter < 3; ++parameter)
        for (const double way : {-1.0, 1.0}) {
          auto moved = echoes;
          if (parameter == 0) moved[k].area *= 1 + 0.01 * way;
          if (parameter == 1) moved[k].position += 0.02 * way;
          if (parameter == 2) moved[k].sigma *= 1 + 0.01 * way;
          CAPTURE(k);
          CAPTURE(parameter);
          CHECK(chi(moved) > least - 2e-3);  // the fit stops where a step would gain 1e-3
        }
  }
}
