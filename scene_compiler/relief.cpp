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

/// Fourier's transform of rows and columns of an image, in place.
void transform(std::vector<Complex>& image, int columns, int rows, bool back) {
  Eigen::FFT<double> fft;
  std::vector<Complex> line, out;
  const auto of = [&](int count, std::size_t first, std::size_t step) {
    line.resize(static_cast<std::size_t>(count));
    for (std::size_t i = 0; i < line.size(); ++i) line[i] = image[first + i * step];
    back ? fft.inv(out, line) : fft.fwd(out, line);
    for (std::size_t i = 0; i < line.size(); ++i) image[first + i * step] = out[i];
  };
  const auto width = static_cast<std::size_t>(columns);
  for (std::size_t j = 0; j < static_cast<std::size_t>(rows); ++j) of(columns, j * width, 1);
  for (std::size_t i = 0; i < width; ++i) of(rows, i, width);
}

/// Angular frequency of wave i of n, per texel; 0 of a wave of two texels, whose slope is not seen at the texels.
double frequency(int i, int n) {
  if (2 * i == n) return 0;
  return 2 * std::numbers::pi * (2 * i < n ? i : i - n) / n;
}

double texel_of(const Record& record) { return record.given("texel_m") ? record.number("texel_m") : 0; }

std::optional<Relief> read_bump(const Record& record, Problems& problems) {
  const auto image = read_image(record, 1, problems);
  if (!image) return std::nullopt;
  const std::vector<double>& value = image->bands[0];
  const auto [low, high] = std::minmax_element(value.begin(), value.end());
  if (!(*high > *low)) {
    problems.add(record.place("image"), "the image has one value everywhere, and so no relief", number_text(*low),
                 "give another image or band, or remove bump");
    return std::nullopt;
  }
  const std::vector<double>& ends_m = record.numbers("height_m");
  std::vector<double> height_m;
  for (const double v : value) height_m.push_back(ends_m[0] + (v - *low) / (*high - *low) * (ends_m[1] - ends_m[0]));
  return Relief(image->columns, image->rows, texel_of(record), false, std::move(height_m));
}

/// The value of an image that stands for 1.
double one_of(const Raster& image) {
  const double white = white_of(image);
  return white > 0 ? white : 1;
}

std::optional<Relief> read_normals(const Record& record, Problems& problems) {
  const auto image = read_image(record, 3, problems);
  if (!image) return std::nullopt;
  const double one = one_of(*image), down = record.text("green") == "down" ? -1 : 1;
  std::vector<double> to_right, up;
  for (std::size_t t = 0; t < image->bands[0].size(); ++t) {
    std::array<double, 3> n{};
    for (std::size_t k = 0; k < 3; ++k) n[k] = one > 1 ? 2 * image->bands[k][t] / one - 1 : image->bands[k][t];
    const double length = std::hypot(n[0], n[1], n[2]);
    if (!(n[2] > kLeastUpright * length)) {
      problems.add(record.place("image"), "a normal does not point out of the surface",
                   number_text(n[0]) + ", " + number_text(n[1]) + ", " + number_text(n[2]) + " in column " +
                       std::to_string(t % static_cast<std::size_t>(image->columns)) + ", row " +
                       std::to_string(t / static_cast<std::size_t>(image->columns)),
                   "give a picture of normals whose third band points outwards; of heights write bump instead");
      return std::nullopt;
    }
    to_right.push_back(-n[0] / n[2]);
    up.push_back(-down * n[1] / n[2]);
  }
  auto height = heights_of_slopes(image->columns, image->rows, to_right, up);
  const double texel_m = texel_of(record);
  if (texel_m > 0)
    for (double& h : height) h *= texel_m;
  return Relief(image->columns, image->rows, texel_m, texel_m == 0, std::move(height));
}

}  // namespace

Relief::Relief(int columns, int rows, double texel_m, bool in_texels, std::vector<double> height)
    : columns_(columns), rows_(rows), texel_m_(texel_m), in_texels_(in_texels), height_(std::move(height)) {}

double Relief::at(double u, double v) const {
  const double x = (by_coordinates() ? u * columns_ : u / texel_m_) - 0.5,
               y = (by_coordinates() ? v * rows_ : v / texel_m_) - 0.5;
  const double i = std::floor(x), j = std::floor(y), f = x - i, g = y - j;
  const auto wrap = [](double place, int n) {
    return static_cast<std::size_t>(std::clamp(place - std::floor(place / n) * n, 0.0, n - 1.0));
  };
  const auto height = [&](double column, double above) {
    return height_[(static_cast<std::size_t>(rows_) - 1 - wrap(above, rows_)) * static_cast<std::size_t>(columns_) +
                   wrap(column, columns_)];
  };
  return (1 - g) * ((1 - f) * height(i, j) + f * height(i + 1, j)) +
         g * ((1 - f) * height(i, j + 1) + f * height(i + 1, j + 1));
}

std::vector<double> heights_of_slopes(int columns, int rows, const std::vector<double>& to_right,
                                      const std::vector<double>& up) {
  std::vector<Complex> p(to_right.begin(), to_right.end()), q(up.begin(), up.end());
  transform(p, columns, rows, false);
  transform(q, columns, rows, false);
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      const auto at = static_cast<std::size_t>(j) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(i);
      const double wx = frequency(i, columns), wy = -frequency(j, rows);  // rows go down
      const double square = wx * wx + wy * wy;
      p[at] = square > 0 ? -Complex(0, 1) * (wx * p[at] + wy * q[at]) / square : 0;
    }
  transform(p, columns, rows, true);
  std::vector<double> out;
  for (const Complex& h : p) out.push_back(h.real());
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
