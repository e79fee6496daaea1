// S22: which spectrum of a family a texel has, worked by hand.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "scene_compiler/texture.h"

using namespace raycube;
using scene::TexelChoice;

TEST_CASE("S22 texture: by rank texels are shared evenly, and a brighter one is never darker") {
  // Four members, darkest first 2, 0, 3, 1; eight texels.
  const std::vector<double> bright{0.2, 0.4, 0.1, 0.3};
  CHECK(scene::choose_members({1, 2, 3, 4, 5, 6, 7, 8}, bright, TexelChoice::rank) ==
        std::vector<std::uint16_t>{2, 2, 0, 0, 3, 3, 1, 1});
  CHECK(scene::choose_members({-9, 800, 3, 4}, bright, TexelChoice::rank) == std::vector<std::uint16_t>{2, 1, 0, 3});
  // Equal texels: chance gives each member as many.
  auto equal = scene::choose_members(std::vector<double>(4000, 7.0), bright, TexelChoice::rank);
  CHECK(!std::is_sorted(equal.begin(), equal.end()));
  for (const int member : {0, 1, 2, 3}) CHECK(std::count(equal.begin(), equal.end(), member) == 1000);
}

TEST_CASE("S22 texture: by deviations the member as far from the family's mean as the texel from the image's") {
  // Members' mean 0.3, deviation sqrt(0.02) = 0.1414; texels' mean 5, deviation 2: z = -1.5, 0, 0.5, 1.
  const std::vector<double> bright{0.1, 0.2, 0.3, 0.4, 0.5};
  const std::vector<double> texels{2, 5, 6, 7};
  const double mean = 5, sd = std::sqrt((9 + 0 + 1 + 4) / 4.0);  // 1.871: wanted 0.0732, 0.3, 0.3756, 0.4512
  REQUIRE(std::abs(0.3 + (7 - mean) / sd * std::sqrt(0.02) - 0.4512) < 1e-4);
  CHECK(scene::choose_members(texels, bright, TexelChoice::deviations) == std::vector<std::uint16_t>{0, 2, 3, 4});
  CHECK(scene::choose_members({3, 3}, bright, TexelChoice::deviations) == std::vector<std::uint16_t>{2, 2});
}

TEST_CASE("S22 texture: the first row lies uppermost, and the image repeats on all sides") {
  const scene::Texture texture(3, 2, 0.5, {0, 1, 2, 3, 4, 5});
  CHECK(texture.at(0.1, 0.6) == 0);
  CHECK(texture.at(1.4, 0.9) == 2);
  CHECK(texture.at(0.6, 0.2) == 4);
  CHECK(texture.at(0.6 + 1.5 * 7, 0.2 - 1.0 * 9) == 4);
  CHECK(texture.at(-0.1, -0.1) == 2);
  // By texture coordinates the whole image lies between 0 and 1.
  const scene::Texture mapped(3, 2, 0, {0, 1, 2, 3, 4, 5});
  CHECK(mapped.at(0.1, 0.9) == 0);
  CHECK(mapped.at(0.9, 0.6) == 2);
  CHECK(mapped.at(0.5, 0.1) == 4);
  CHECK(mapped.at(4.5, -6.9) == 4);
}

TEST_CASE("S22 texture: by a map of reflectances the nearest member in all bands") {
  const std::vector<std::vector<double>> members{{0.1, 0.5, 0.5}, {0.1, 0.1, 0.5}};  // two bands of three members
  CHECK(scene::nearest_members({{0.1, 0.45, 0.9, 0.31}, {0.2, 0.1, 0.9, 0.1}}, members) ==
        std::vector<std::uint16_t>{0, 1, 2, 1});
  CHECK(scene::nearest_members({{0.375, 0.375}, {0.1, 0.1}}, {{0.25, 0.5}, {0.1, 0.1}}) ==
        std::vector<std::uint16_t>{0, 0});  // of equals the first
}

TEST_CASE("S22 texture: a spectrum is as bright as its mean over the band") {
  const scene::Curve curve{{0.4, 0.5, 0.7}, {0.2, 0.4, 0.0}};
  CHECK(scene::mean_between(curve, 0.4, 0.5) == doctest::Approx(0.3).epsilon(1e-12));
  CHECK(scene::mean_between(curve, 0.45, 0.6) == doctest::Approx((0.35 * 0.05 + 0.3 * 0.1) / 0.15).epsilon(1e-12));
  CHECK(scene::mean_between(curve, 0.4, 0.7) == doctest::Approx((0.03 + 0.04) / 0.3).epsilon(1e-12));
}
