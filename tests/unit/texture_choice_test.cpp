// S22: which spectrum of a family a texel has, worked by hand.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "scene_compiler/counter_random.h"
#include "scene_compiler/texture.h"

using namespace raycube;
using scene::NumberType;
using scene::TexelChoice;

TEST_CASE("S22 texture: by rank texels are shared evenly, and a brighter one is never darker") {
  // Four members, darkest first 2, 0, 3, 1; eight texels.
  const std::vector<double> bright{0.2, 0.4, 0.1, 0.3};
  CHECK(scene::choose_members(std::vector<double>{1, 2, 3, 4, 5, 6, 7, 8}, bright, TexelChoice::rank) ==
        std::vector<std::uint16_t>{2, 2, 0, 0, 3, 3, 1, 1});
  CHECK(scene::choose_members(std::vector<double>{-9, 800, 3, 4}, bright, TexelChoice::rank) ==
        std::vector<std::uint16_t>{2, 1, 0, 3});
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
  CHECK(scene::choose_members(std::vector<double>{3, 3}, bright, TexelChoice::deviations) ==
        std::vector<std::uint16_t>{2, 2});
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
  const auto nearest = [](const std::vector<std::vector<double>>& values, double white, const auto& means) {
    return scene::nearest_members({values.begin(), values.end()}, white, means);
  };
  CHECK(nearest({{0.1, 0.45, 0.9, 0.31}, {0.2, 0.1, 0.9, 0.1}}, 1, members) == std::vector<std::uint16_t>{0, 1, 2, 1});
  CHECK(nearest({{25.5, 114.75, 229.5, 79.05}, {51, 25.5, 229.5, 25.5}}, 255, members) ==
        std::vector<std::uint16_t>{0, 1, 2, 1});
  const std::vector<std::vector<double>> two{{0.25, 0.5}, {0.1, 0.1}};
  CHECK(nearest({{0.375, 0.375}, {0.1, 0.1}}, 1, two) == std::vector<std::uint16_t>{0, 0});  // of equals the first
}

TEST_CASE("S22 texture: a spectrum is as bright as its mean over the band") {
  const scene::Curve curve{{0.4, 0.5, 0.7}, {0.2, 0.4, 0.0}};
  CHECK(scene::mean_between(curve, 0.4, 0.5) == doctest::Approx(0.3).epsilon(1e-12));
  CHECK(scene::mean_between(curve, 0.45, 0.6) == doctest::Approx((0.35 * 0.05 + 0.3 * 0.1) / 0.15).epsilon(1e-12));
  CHECK(scene::mean_between(curve, 0.4, 0.7) == doctest::Approx((0.03 + 0.04) / 0.3).epsilon(1e-12));
}

TEST_CASE("S22 texture: by rank bytes, floats and doubles give what sorting all texels gives") {
  // Independent: all texels in one order, by value, by chance, by place (docs/scene_format.md).
  const auto sorted = [](const std::vector<double>& values, const std::vector<double>& bright) {
    std::vector<std::size_t> place(values.size()), member(bright.size());
    for (std::size_t i = 0; i < place.size(); ++i) place[i] = i;
    for (std::size_t i = 0; i < member.size(); ++i) member[i] = i;
    std::sort(member.begin(), member.end(), [&](std::size_t a, std::size_t b) { return bright[a] < bright[b]; });
    std::sort(place.begin(), place.end(), [&](std::size_t a, std::size_t b) {
      return std::tuple(values[a], scene::counter_uniform(0x7e97, 0, a, 0), a) <
             std::tuple(values[b], scene::counter_uniform(0x7e97, 0, b, 0), b);
    });
    std::vector<std::uint16_t> out(values.size());
    for (std::size_t r = 0; r < place.size(); ++r)
      out[place[r]] = static_cast<std::uint16_t>(member[(2 * r + 1) * member.size() / (2 * place.size())]);
    return out;
  };
  for (const std::size_t members : {1, 2, 5, 31, 700})
    for (const double scale : {1.0, -0.25, 1e-30}) {  // the last makes all texels equal: offset 3 takes it in
      std::vector<double> bright, numbers, values;
      for (std::size_t m = 0; m < members; ++m) bright.push_back(scene::counter_uniform(1, 2, m, 0));
      for (std::size_t t = 0; t < 601; ++t) numbers.push_back(std::floor(7 * scene::counter_uniform(1, 3, t, 0)));
      for (const double number : numbers) values.push_back(scale * number + 3);
      const auto want = sorted(values, bright);
      CHECK(scene::choose_members(values, bright, TexelChoice::rank) == want);
      for (const NumberType type : {NumberType::u8, NumberType::i16, NumberType::i32, NumberType::f32}) {
        scene::BandValues held(scale, 3, type, numbers.size());
        held.append(scene::packed(numbers, type));
        REQUIRE(held.type() == type);
        CHECK(scene::choose_members(held, bright, TexelChoice::rank) == want);
      }
    }
}

TEST_CASE(
    "S22 texture: numbers keep their bits in the type of their file, and in doubles where that does not hold them") {
  struct Case {
    NumberType wanted, type;
    std::vector<double> numbers;
  };
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  for (const Case& one :
       {Case{NumberType::u8, NumberType::u8, {0, 255}}, Case{NumberType::u8, NumberType::f64, {0, 256}},
        Case{NumberType::u8, NumberType::f64, {0.5, 3}}, Case{NumberType::u8, NumberType::f64, {-0.0, 3}},
        Case{NumberType::u16, NumberType::f64, {nan, 3}}, Case{NumberType::i8, NumberType::i8, {-128, 127}},
        Case{NumberType::i16, NumberType::i16, {-32768, 32767}},
        Case{NumberType::u32, NumberType::u32, {0, 4294967295.0}},
        Case{NumberType::i32, NumberType::f64, {-2147483649.0, 0}},
        Case{NumberType::f32, NumberType::f32, {0.5, -0.0, nan, infinity, 1e-45f}},
        Case{NumberType::f32, NumberType::f64, {0.1, 1}}, Case{NumberType::f32, NumberType::f64, {1e300, 1}}}) {
    const auto packed = scene::packed(one.numbers, one.wanted);
    CHECK(packed.type == one.type);
    scene::BandValues held(1, 0, one.wanted, 4);
    held.append(scene::packed({1, 2}, one.wanted));  // a piece that fits before one that may not
    held.append(packed);
    held.append(scene::packed({3}, one.wanted));
    REQUIRE(held.size() == one.numbers.size() + 3);
    CHECK(held.type() == one.type);
    CHECK((held[0] == 1 && held[1] == 2 && held[held.size() - 1] == 3));
    for (std::size_t i = 0; i < one.numbers.size(); ++i)
      CHECK((held[i + 2] == one.numbers[i] || (std::isnan(held[i + 2]) && std::isnan(one.numbers[i]))));
  }
  scene::BandValues turned(std::vector<double>{5, 6, 7});
  turned.reorder([](std::size_t i) { return 2 - i; });
  CHECK((turned[0] == 7 && turned[1] == 6 && turned[2] == 5));
  CHECK(turned.least_and_most() == std::pair(5.0, 7.0));
}
