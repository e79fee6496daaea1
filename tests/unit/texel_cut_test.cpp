// Triangles cut along the texels of images. Oracles: areas, places in texels, and that pieces meet corner to corner.
#include <doctest/doctest.h>

#include <cmath>
#include <map>
#include <random>
#include <set>

#include "scene_compiler/texel_cut.h"

using namespace raycube;
using scene::ImageCorner;

namespace {

using Piece = std::vector<ImageCorner>;
using Triangle = std::array<ImageCorner, 3>;

struct Cut {
  Piece corners;
  std::uint32_t number;
};

std::vector<Cut> cut(const Triangle& triangle, const scene::TexelCounts& counts, bool join,
                     const std::function<std::uint32_t(double, double)>& of) {
  std::vector<Cut> out;
  scene::cut_by_texels(triangle, counts, join, of, [&](const Piece& piece, std::uint32_t number) {
    out.push_back({piece, number});
  });
  return out;
}

std::array<double, 3> cross(const std::array<double, 3>& a, const std::array<double, 3>& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
std::array<double, 3> minus(const std::array<double, 3>& a, const std::array<double, 3>& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

double area(const Piece& piece) {
  double sum = 0;
  for (std::size_t k = 2; k < piece.size(); ++k) {
    const auto n = cross(minus(piece[k - 1].position, piece[0].position), minus(piece[k].position, piece[0].position));
    sum += 0.5 * std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
  }
  return sum;
}

constexpr auto kAnyNumber = [](double, double) { return 7u; };

/// Number of the texel (u, v) lies in, of `columns` x `rows` to an image.
auto texel_number(int columns, int rows) {
  return [=](double u, double v) {
    return static_cast<std::uint32_t>(1000 * (50 + std::floor(v * rows)) + 50 + std::floor(u * columns));
  };
}

}  // namespace

TEST_CASE("texel cut: pieces make up the triangle, each lies in one texel and has its number") {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int n = 0; n < 200; ++n) {
    Triangle triangle;
    for (auto& corner : triangle) {
      for (double& x : corner.position) x = 10 * unit(random);
      for (double& x : corner.in_image) x = 2 * unit(random);
    }
    const auto of = texel_number(5, 4);
    double sum = 0;
    for (const Cut& piece : cut(triangle, {{{5}, {4}}}, false, of)) {
      sum += area(piece.corners);
      double u = 0, v = 0;
      for (const ImageCorner& corner : piece.corners) {
        u += corner.in_image[0] / static_cast<double>(piece.corners.size());
        v += corner.in_image[1] / static_cast<double>(piece.corners.size());
      }
      CHECK(of(u, v) == piece.number);
      for (const ImageCorner& corner : piece.corners) {
        CHECK(std::abs(corner.in_image[0] - (std::floor(u * 5) + 0.5) / 5) <= 0.1 + 1e-12);
        CHECK(std::abs(corner.in_image[1] - (std::floor(v * 4) + 0.5) / 4) <= 0.125 + 1e-12);
      }
    }
    CHECK(sum == doctest::Approx(area({triangle.begin(), triangle.end()})).epsilon(1e-12));
  }
}

TEST_CASE("texel cut: neighbours meet corner to corner, within a triangle and across the side of two") {
  std::mt19937 random(8);
  std::uniform_real_distribution<float> unit(0, 1);
  for (int n = 0; n < 50; ++n) {
    std::array<ImageCorner, 4> square;
    const double sides[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    for (std::size_t k = 0; k < 4; ++k) {
      square[k].position = {sides[k][0] + 0.3 * double{unit(random)}, sides[k][1] + 0.3 * double{unit(random)},
                            double{unit(random)}};
      square[k].in_image = {double{unit(random)} + 2 * sides[k][0], double{unit(random)} + sides[k][1]};
    }
    using Place = std::array<float, 3>;
    std::map<std::pair<Place, Place>, int> edges;
    for (const Triangle& triangle : {Triangle{square[0], square[1], square[2]}, {square[0], square[2], square[3]}})
      for (const Cut& piece : cut(triangle, {{{7, 3}, {5}}}, false, texel_number(7, 5)))
        for (std::size_t k = 0; k < piece.corners.size(); ++k) {
          const auto place = [&](std::size_t i) {
            const auto& p = piece.corners[i % piece.corners.size()].position;
            return Place{static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])};
          };
          const Place a = place(k), b = place(k + 1);
          if (a != b) ++edges[{std::min(a, b), std::max(a, b)}];
        }
    // What is used once lies on the square's outer sides, whose length it adds up to.
    double once = 0, around = 0;
    for (const auto& [edge, times] : edges) {
      CHECK(times <= 2);
      if (times == 1)
        once += std::hypot(double{edge.first[0]} - edge.second[0], double{edge.first[1]} - edge.second[1],
                           double{edge.first[2]} - edge.second[2]);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      const auto side = minus(square[(k + 1) % 4].position, square[k].position);
      around += std::hypot(side[0], side[1], side[2]);
    }
    CHECK(once == doctest::Approx(around).epsilon(1e-6));  // places are rounded to floats
  }
}

TEST_CASE("texel cut: equal texels are joined, and keep their area") {
  constexpr int kTexels = 64;
  const auto in_disc = [](double u, double v) { return std::hypot(u - 0.5, v - 0.5) < 0.4 ? 1u : 0u; };
  const auto of = [&](double u, double v) {
    return in_disc((std::floor(u * kTexels) + 0.5) / kTexels, (std::floor(v * kTexels) + 0.5) / kTexels);
  };
  const Triangle low{{{{0, 0, 0}, {0, 0}}, {{2, 0, 0}, {1, 0}}, {{2, 3, 0}, {1, 1}}}};
  const Triangle high{{{{0, 0, 0}, {0, 0}}, {{2, 3, 0}, {1, 1}}, {{0, 3, 0}, {0, 1}}}};
  double filled = 0;
  std::size_t pieces = 0;
  for (const Triangle& triangle : {low, high})
    for (const Cut& piece : cut(triangle, {{{kTexels}, {kTexels}}}, true, of)) {
      filled += piece.number * area(piece.corners);
      ++pieces;
    }
  int texels = 0;
  for (int i = 0; i < kTexels; ++i)
    for (int j = 0; j < kTexels; ++j) texels += static_cast<int>(in_disc((i + 0.5) / kTexels, (j + 0.5) / kTexels));
  CHECK(filled == doctest::Approx(6.0 * texels / (kTexels * kTexels)).epsilon(1e-12));
  CHECK(pieces < kTexels * kTexels / 4);
}

TEST_CASE("texel cut: places in images that span no area") {
  const auto at = [](double u0, double v0, double u1, double v1, double u2, double v2) {
    return Triangle{{{{0, 0, 0}, {u0, v0}}, {{1, 0, 0}, {u1, v1}}, {{0, 1, 0}, {u2, v2}}}};
  };
  const auto of = texel_number(4, 4);
  const auto point = cut(at(0.3, 0.6, 0.3, 0.6, 0.3, 0.6), {{{4}, {4}}}, false, of);
  REQUIRE(point.size() == 1);
  CHECK(point[0].number == of(0.3, 0.6));
  CHECK(area(point[0].corners) == 0.5);
  double sum = 0;
  std::set<std::uint32_t> numbers;
  for (const Cut& piece : cut(at(0.1, 0.6, 0.9, 0.6, 0.5, 0.6), {{{4}, {4}}}, false, of))
    sum += area(piece.corners), numbers.insert(piece.number);
  CHECK(sum == doctest::Approx(0.5).epsilon(1e-14));
  CHECK(numbers == std::set<std::uint32_t>{of(0.1, 0.6), of(0.3, 0.6), of(0.6, 0.6), of(0.9, 0.6)});
  // Corners on the texels' edges make no pieces beyond them.
  const auto whole = cut(at(0.25, 0.5, 0.5, 0.5, 0.25, 0.75), {{{4}, {4}}}, false, of);
  REQUIRE(whole.size() == 1);
  CHECK(whole[0].number == of(0.3, 0.6));
  CHECK(scene::texel_cells(at(0, 0, 2, 0, 0, 1), {{{4}, {4}}}) == 9 * 5);
  CHECK(cut(at(0, 0, 2, 0, 0, 1), {{{4}, {4}}}, true, kAnyNumber).size() == 1);
}
