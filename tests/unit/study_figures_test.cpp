// The error that `tolerance` means, in closed form; the Pareto front; waveforms.
#include <doctest/doctest.h>

#include <cmath>
#include <limits>

#include "host/base/error.h"
#include "host/study/error_figures.h"
#include "host/study/lidar_converged.h"
#include "host/study/pareto.h"

using namespace raycube;
using doctest::Approx;

TEST_CASE("S64 error of a band: rms over pixels over the band's mean, the floor of 1e-4, the worst band") {
  study::Converged reference;
  reference.bands = 3;
  // Means 2, 4 and 1e-5: the last is judged against 4e-4.
  reference.radiance = {1, 2, 1e-5, 3, 6, 1e-5};
  reference.half.assign(6, 0.0);
  const std::vector<float> found = {1.25f, 2, 5e-5f, 3, 6.5f, 1e-5f};
  const study::ErrorFigures e = study::error_of(reference, found);
  const double first = std::sqrt(0.0625 / 2) / 2, second = std::sqrt(0.25 / 2) / 4,
               third = std::sqrt(16e-10 / 2) / 4e-4;
  CHECK(e.band == 0);
  CHECK(e.worst == Approx(first));
  CHECK(second == Approx(first));  // the first of equals
  CHECK(e.rms == Approx(std::sqrt((first * first + second * second + third * third) / 3)));
  CHECK(e.p95 == Approx(0.125));  // the larger of two
  CHECK(e.own == 0);
  CHECK(e.low <= e.worst);
  CHECK(e.high >= e.worst);
}

TEST_CASE("S64 error bars: the reference's variance is taken off, and equal errors leave no spread") {
  study::Converged reference;
  reference.bands = 1;
  reference.radiance = {10, 10, 10, 10};
  reference.half = {0.3, -0.3, 0.3, -0.3};
  CHECK(study::own_error(reference) == Approx(0.03));
  const study::ErrorFigures e = study::error_of(reference, {10.5f, 9.5f, 10.5f, 9.5f});
  CHECK(e.worst == Approx(0.05));
  CHECK(e.own == Approx(0.03));
  CHECK(e.low == Approx(0.04));  // sqrt(0.05^2 - 0.03^2)
  CHECK(e.high == Approx(0.05));
  CHECK(study::error_of(reference, {10, 10, 10, 10}).low == 0);
  CHECK_THROWS_AS(study::error_of(reference, {1, 2}), base::Error);
}

TEST_CASE("S64 other figures than the rms: percentile and worst, and pixels by what they weigh") {
  study::Converged reference;
  reference.bands = 1;
  std::vector<float> found;
  for (int p = 0; p < 200; ++p) reference.radiance.push_back(2), found.push_back(2 + 0.01f * static_cast<float>(p));
  reference.half.assign(200, 0.0);
  reference.figure = scene::ErrorFigure::p99;  // 198 of 200 are at most the 198th: 1.97 / 2
  study::ErrorFigures e = study::error_of(reference, found);
  CHECK(e.worst == Approx(0.985));
  CHECK(e.low == Approx(0.98));    // 0.7 % of 200 are 1.4 pixels less: the 197th
  CHECK(e.high == Approx(0.995));  // and more: the 200th
  reference.figure = scene::ErrorFigure::worst;
  CHECK(study::error_of(reference, found).worst == Approx(0.995));
  // The first hundred pixels alone, of which the mean is then taken too.
  for (int p = 0; p < 200; ++p) reference.weight.push_back(p < 100 ? 0.5f : 0.0f);
  for (std::size_t p = 100; p < 200; ++p) reference.radiance[p] = 50;
  CHECK(study::error_of(reference, found).worst == Approx(0.495));
  reference.figure = scene::ErrorFigure::rms;
  e = study::error_of(reference, found);
  CHECK(e.worst == Approx(std::sqrt(99.0 * 199 / 6) * 0.01 / 2));  // sum of squares to 99: 99 100 199 / 6
  CHECK(e.p95 == Approx(0.47));
}

TEST_CASE("S64 Pareto front: what nothing beats in time and error, in order of time") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  //                       beaten by 2   front     front     as 2, later  beaten by 1  none      slower, same error as 2
  CHECK(study::pareto_front({{3, 0.3}, {1, 0.5}, {2, 0.2}, {2, 0.2}, {1, 0.6}, {nan, 0.0}, {5, 0.2}, {9, 0.1}}) ==
        std::vector<std::size_t>{1, 2, 7});
  CHECK(study::pareto_front({}).empty());
}

TEST_CASE("S64 waveforms: rms over the rms of peaks; coarse bins are spread over the reference's") {
  study::ConvergedPulses reference;
  reference.bins = 4;
  reference.bin_s = 1e-9;
  reference.photons = {0, 3, 1, 0, 0, 0, 4, 0};  // peaks 3 and 4
  reference.half.assign(8, 0.0);
  const double peaks = 25;
  CHECK(study::pulse_error(reference, {0, 3, 1, 0, 0, 0, 4, 0}, 4, 1e-9).rms == 0);
  CHECK(study::pulse_error(reference, {0, 3, 1, 0, 0, 0, 2, 1}, 4, 1e-9).rms == Approx(std::sqrt((4 + 1) / peaks)));
  // Two bins of 2 ns, spread: {1.5, 1.5, 0.5, 0.5}, {0, 0, 2, 2}.
  CHECK(study::pulse_error(reference, {3, 1, 0, 4}, 2, 2e-9).rms ==
        Approx(std::sqrt((2.25 + 2.25 + 0.25 + 0.25 + 4 + 4) / peaks)));
  // Bins of 3 ns reach past the gate: {1, 1, 1, 0.5}, {4/3, 4/3, 4/3, 0}.
  CHECK(study::pulse_error(reference, {3, 1.5f, 4, 0}, 2, 3e-9).rms ==
        Approx(std::sqrt((1 + 4 + 0 + 0.25 + 16.0 / 9 * 2 + 64.0 / 9) / peaks)));
  CHECK_THROWS_AS(study::pulse_error(reference, {1, 2, 3}, 2, 2e-9), base::Error);
}
