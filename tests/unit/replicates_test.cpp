// Means of replicates: what a mean over images has of radiance and truth, and what their spread says of it.
#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "host/render/replicates.h"
#include "host/render/truth.h"
#include "tests/support/chance_checks.h"

namespace {

using namespace raycube::render;
constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

/// Layers of a pixel of two materials; x, y, z and range are `place`, of which nothing is left where nothing was hit.
std::vector<float> layers_of(float hit, float sun, float place, float incidence_deg, float first, float second) {
  std::vector<float> out(truth::abundance + 2);
  out[truth::material_id] = 9;  // the mean's is found anew
  out[truth::hit_fraction] = hit, out[truth::sun_fraction] = sun;
  out[truth::x_m] = out[truth::y_m] = out[truth::z_m] = out[truth::range_m] = place;
  out[truth::view_zenith_deg] = 3, out[truth::view_azimuth_deg] = 200;
  out[truth::sun_zenith_deg] = 40, out[truth::sun_azimuth_deg] = 150;
  out[truth::sun_incidence_deg] = incidence_deg;
  out[truth::abundance] = first, out[truth::abundance + 1] = second;
  return out;
}

std::vector<float> mean_of(const std::vector<std::vector<float>>& images) {
  std::vector<double> sums(images[0].size());
  for (const auto& layers : images) add_truth(layers.data(), 2, sums.data());
  std::vector<float> out(images[0].size());
  mean_truth(sums.data(), static_cast<int>(images.size()), 2, 2, out.data());
  return out;
}

}  // namespace

TEST_CASE("truth of a mean: fractions and abundances are means, what is told of hits is weighted by them") {
  const auto mean = mean_of({layers_of(0.5f, 1, 10, 60, 0.5f, 0), layers_of(1, 0.25f, 40, 0, 0.25f, 0.75f)});
  CHECK(mean[truth::hit_fraction] == 0.75f);
  CHECK(mean[truth::sun_fraction] == 0.5f);  // (0.5 x 1 + 1 x 0.25) / 1.5
  for (const auto layer : {truth::x_m, truth::y_m, truth::z_m, truth::range_m}) CHECK(mean[layer] == 30);
  // Cosines: (0.5 x 0.5 + 1 x 1) / 1.5.
  CHECK(std::abs(mean[truth::sun_incidence_deg] - std::acos(1.25 / 1.5) * 180 / std::acos(-1.0)) < 1e-4);
  CHECK(mean[truth::abundance] == 0.375f);
  CHECK(mean[truth::abundance + 1] == 0.375f);
  CHECK(mean[truth::material_id] == 1);  // a tie goes to the lower number
  CHECK(mean[truth::view_zenith_deg] == 3);
  CHECK(mean[truth::view_azimuth_deg] == 200);
  CHECK(mean[truth::sun_zenith_deg] == 40);
  CHECK(mean[truth::sun_azimuth_deg] == 150);
}

TEST_CASE("truth of a mean: an image that hits nothing leaves what the others say of their hits") {
  const auto none = layers_of(0, 0, kNone, kNone, 0, 0), some = layers_of(0.5f, 0.5f, 7, 30, 0, 0.5f);
  const auto mean = mean_of({none, some});
  CHECK(mean[truth::hit_fraction] == 0.25f);
  CHECK(mean[truth::x_m] == 7);
  CHECK(std::abs(mean[truth::sun_incidence_deg] - 30) < 1e-4);
  CHECK(mean[truth::abundance + 1] == 0.25f);
  CHECK(mean[truth::material_id] == 2);
  const auto empty = mean_of({none, none});
  CHECK(empty[truth::material_id] == 0);
  CHECK(empty[truth::sun_fraction] == 0);
  CHECK(std::isnan(empty[truth::range_m]));
  CHECK(std::isnan(empty[truth::sun_incidence_deg]));
}

TEST_CASE("the spread of replicates is what their mean errs, and says how well it is known") {
  // Gaussian draws of deviation 3 (first band) and 1 about 10: the mean of R errs by 9 / R and 1 / R in the square.
  constexpr std::size_t kPixels = 8000, kBands = 2;
  std::mt19937_64 random(raycube::testing::seed(5));
  for (const int replicates : {2, 4, 8}) {
    ReplicateSums sums(kPixels, kBands, 1, 1);
    const std::vector<float> layers(kPixels * (truth::abundance + 1), 0.0f);
    for (int r = 0; r < replicates; ++r) {
      std::vector<float> radiance;
      for (std::size_t p = 0; p < kPixels; ++p)
        for (const float deviation : {3.0f, 1.0f})
          radiance.push_back(std::normal_distribution<float>(10, deviation)(random));
      sums.add(0, kPixels / 4, radiance.data(), layers.data(), truth::abundance + 1);
      sums.add(kPixels / 4, kPixels - kPixels / 4, radiance.data() + kPixels / 4 * kBands, layers.data(),
               truth::abundance + 1);
      sums.next();
    }
    CHECK(sums.count() == replicates);
    const ReplicateSpread spread = sums.spread();
    CAPTURE(replicates);
    const double degrees = static_cast<double>(kPixels) * (replicates - 1);
    for (std::size_t b = 0; b < kBands; ++b) {
      const double want = (b == 0 ? 9.0 : 1.0) / replicates, found = spread.square[b] / spread.pixels;
      // Chi-square of so many degrees: five of its standard deviations; of the noise's own mean a tenth.
      const double deviation = want * std::sqrt(2 / degrees);
      CHECK_WITHIN(found - want, 5 * deviation);
      CHECK_WITHIN(std::sqrt(spread.noise[b]) / spread.pixels - deviation, 0.1 * deviation);
      CHECK_WITHIN(spread.radiance[b] / spread.pixels - 10, 5 * std::sqrt(want / kPixels));
    }
    std::vector<float> mean(kBands), truth(truth::abundance + 1);
    sums.mean(7, 1, mean.data(), truth.data(), truth.size());
    CHECK_WITHIN(mean[0] - 10, 5 * 3 / std::sqrt(static_cast<double>(replicates)));
  }
}

TEST_CASE("spreads of two halves of an image add") {
  ReplicateSpread whole;
  whole.add({2, {1, 2}, {3, 4}, {5, 6}});
  whole.add({3, {10, 20}, {30, 40}, {50, 60}});
  CHECK(whole.pixels == 5);
  CHECK(whole.radiance == std::vector<double>{11, 22});
  CHECK(whole.square == std::vector<double>{33, 44});
  CHECK(whole.noise == std::vector<double>{55, 66});
}
