#include "scene_compiler/relief.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <utility>

#include <unsupported/Eigen/FFT>

#include "scene_compiler/document_values.h"
#include "scene_compiler/raster.h"
#include "scene_compiler/texture.h"

namespace raycube::scene {
namespace {

using base::Problems;
using Complex = std::complex<double>;

constexpr double kLeastUpright = 0.05;  ///< of a normal: steeper than 87 degrees no height has slopes

/// Angular frequency of wave i of n, per texel; 0 of a wave of two texels, whose slope is not seen at the texels.
double frequency(int i, int n) {
  if (2 * i == n) return 0;
  return 2 * std::numbers::pi * (2 * i < n ? i : i - n) / n;
}

double texel_of(const Record& record) { return record.given("texel_m") ? record.number("texel_m") : 0; }

std::optional<Relief> read_bump(const Record& record, Problems& problems) {
  auto image = read_image(record, 1, 0, problems);
  if (!image) return std::nullopt;
  const auto [low, high] = image->bands[0].least_and_most();
  if (!(high > low)) {
    problems.add(record.place("image"), "the image has one value everywhere, and so no relief", number_text(low),
                 "give another image or band, or remove bump");
    return std::nullopt;
  }
  const std::vector<double>& ends_m = record.numbers("height_m");
  return Relief(
      image->columns, image->rows, texel_of(record), false,
      [value = std::move(image->bands[0]), least = low, span = high - low, first_m = ends_m[0],
       rise_m = ends_m[1] - ends_m[0]](std::size_t t) { return first_m + (value[t] - least) / span * rise_m; });
}

/// The value of an image that stands for 1.
double one_of(const Raster& image) {
  const double white = white_of(image);
  return white > 0 ? white : 1;
}

std::optional<Relief> read_normals(const Record& record, Problems& problems) {
  const auto image = read_image(record, 3, sizeof(Complex), problems);
  if (!image) return std::nullopt;
  const double one = one_of(*image), down = record.text("green") == "down" ? -1 : 1;
  const auto normal = [&](std::size_t t) {
    std::array<double, 3> n{};
    for (std::size_t k = 0; k < 3; ++k) n[k] = one > 1 ? 2 * image->bands[k][t] / one - 1 : image->bands[k][t];
    return n;
  };
  for (std::size_t t = 0; t < image->bands[0].size(); ++t) {
    const auto n = normal(t);
    const double length = std::hypot(n[0], n[1], n[2]);
    if (!(n[2] > kLeastUpright * length)) {
      problems.add(record.place("image"), "a normal does not point out of the surface",
                   number_text(n[0]) + ", " + number_text(n[1]) + ", " + number_text(n[2]) + " in column " +
                       std::to_string(t % static_cast<std::size_t>(image->columns)) + ", row " +
                       std::to_string(t / static_cast<std::size_t>(image->columns)),
                   "give a picture of normals whose third band points outwards; of heights write bump instead");
      return std::nullopt;
    }
  }
  auto height = heights_of_slopes(image->columns, image->rows, [&](std::size_t t) {
    const auto n = normal(t);
    return Slope{-n[0] / n[2], -down * n[1] / n[2]};
  });
  const double texel_m = texel_of(record);
  if (texel_m > 0)
    for (double& h : height) h *= texel_m;
  return Relief(image->columns, image->rows, texel_m, texel_m == 0,
                [height = std::move(height)](std::size_t t) { return height[t]; });
}

}  // namespace

Relief::Relief(int columns, int rows, double texel_m, bool in_texels, std::function<double(std::size_t)> height)
    : columns_(columns), rows_(rows), texel_m_(texel_m), in_texels_(in_texels), height_(std::move(height)) {}

double Relief::at(double u, double v) const {
  const double x = (by_coordinates() ? u * columns_ : u / texel_m_) - 0.5,
               y = (by_coordinates() ? v * rows_ : v / texel_m_) - 0.5;
  const double i = std::floor(x), j = std::floor(y), f = x - i, g = y - j;
  const auto wrap = [](double place, int n) {
    return static_cast<std::size_t>(std::clamp(place - std::floor(place / n) * n, 0.0, n - 1.0));
  };
  const auto height = [&](double column, double above) {
    return height_((static_cast<std::size_t>(rows_) - 1 - wrap(above, rows_)) * static_cast<std::size_t>(columns_) +
                   wrap(column, columns_));
  };
  return (1 - g) * ((1 - f) * height(i, j) + f * height(i + 1, j)) +
         g * ((1 - f) * height(i, j + 1) + f * height(i + 1, j + 1));
}

std::vector<double> heights_of_slopes(int columns, int rows, const std::function<Slope(std::size_t)>& slope) {
  Eigen::FFT<double> fft;
  const auto width = static_cast<std::size_t>(columns), count = static_cast<std::size_t>(rows);
  // Spectra of real numbers: waves above the half are the conjugates of those below, and are not held.
  const std::size_t half = width / 2 + 1;
  std::vector<Complex> p(half * count), q(half * count), line(width), wave;
  for (std::size_t j = 0; j < count; ++j) {
    for (std::size_t i = 0; i < width; ++i) {
      const Slope at = slope(j * width + i);
      line[i] = {at.to_right, at.up};
    }
    fft.fwd(wave, line);  // of both at once, which their symmetries tell apart
    for (std::size_t i = 0; i < half; ++i) {
      const Complex here = wave[i], mirrored = std::conj(wave[(width - i) % width]);
      p[j * half + i] = 0.5 * (here + mirrored), q[j * half + i] = Complex(0, -0.5) * (here - mirrored);
    }
  }
  std::vector<Complex> of_p(count), of_q(count), sums(count);
  for (std::size_t i = 0; i < half; ++i) {
    for (std::size_t j = 0; j < count; ++j) of_p[j] = p[j * half + i], of_q[j] = q[j * half + i];
    fft.fwd(sums, of_p), of_p = sums;
    fft.fwd(sums, of_q), of_q = sums;
    const double wx = frequency(static_cast<int>(i), columns);
    for (std::size_t j = 0; j < count; ++j) {
      const double wy = -frequency(static_cast<int>(j), rows);  // rows go down
      const double square = wx * wx + wy * wy;
      of_p[j] = square > 0 ? -Complex(0, 1) * (wx * of_p[j] + wy * of_q[j]) / square : 0;
    }
    fft.inv(sums, of_p);
    for (std::size_t j = 0; j < count; ++j) p[j * half + i] = sums[j];
  }
  std::vector<Complex>().swap(q);
  std::vector<double> out;
  out.reserve(width * count);
  for (std::size_t j = 0; j < count; ++j) {
    for (std::size_t i = 0; i < half; ++i) line[(width - i) % width] = std::conj(p[j * half + i]);
    for (std::size_t i = 0; i < half; ++i) line[i] = p[j * half + i];
    fft.inv(wave, line);
    for (const Complex& height : wave) out.push_back(height.real());
  }
  return out;
}

std::optional<Relief> read_relief(const Record& material, Problems& problems) {
  const Record *bump = material.table("bump"), *normals = material.table("normals");
  if (bump && normals) {
    problems.add(normals->where, "a material has one relief", "bump and normals", "remove one");
    return std::nullopt;
  }
  if (bump) return bump->sound ? read_bump(*bump, problems) : std::nullopt;
  return normals && normals->sound ? read_normals(*normals, problems) : std::nullopt;
}

}  // namespace raycube::scene
