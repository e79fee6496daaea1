#include "host/analysis/ground_match.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/base/error.h"

namespace raycube::analysis {
namespace {

constexpr double kPixelsPerBin = 2;
constexpr std::int64_t kMostRings = 40;  ///< of bins, where pixels are oblong or most see no ground
/// Of a pixel's size, from its middle: corners lie 0.71 away, and middles of what is seen are not middles of pixels.
constexpr double kInside = 0.75;
constexpr double kHidden = 1.5;  ///< of the larger pixel's size, in space: farther away it is something else

}  // namespace

std::array<std::size_t, 3> place_layers(const products::EnviHeader& header, const std::string& path) {
  for (const auto& names : {std::array{"x_m", "y_m", "z_m"}, std::array{"easting", "northing", "height"}}) {
    std::array<std::size_t, 3> out{};
    int found = 0;
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t b = 0; b < header.band_names.size(); ++b)
        if (header.band_names[b].substr(0, header.band_names[b].find(' ')) == names[i]) out[i] = b, ++found;
    if (found == 3) return out;
  }
  throw base::Error(base::Fault::input,
                    path +
                        ": no layers say where its pixels look; give a render's truth.img (x_m, y_m, z_m) or "
                        "location.img (easting, northing, height)");
}

GroundMatch::GroundMatch(const Cube& places, const Pass& pass)
    : samples_(places.samples()), lines_(places.lines()), place_(3 * places.pixels(), std::nanf("")) {
  if (places.pixels() > std::numeric_limits<std::uint32_t>::max())
    throw base::Error(base::Fault::input, places.path() + ": has more than 4e9 pixels; cut it");
  // Eastings and northings have more digits than a float: the first place that is known is the origin.
  Pixels one;
  bool known = false;
  for (std::int64_t l = 0; l < lines_ && !known; ++l) {
    places.read(l, 1, one);
    for (std::size_t p = 0; p < one.count() && !known; ++p)
      if (one.counts[p]) origin_ = {one.at(p)[0], one.at(p)[1], one.at(p)[2]}, known = true;
  }
  if (!known) throw base::Error(base::Fault::input, places.path() + ": none of its pixels meets the ground");
  for_each_part(places, pass, [&](std::size_t, const Pixels& pixels) {
    float* to = place_.data() + 3 * pixels.first_line * samples_;
    for (std::size_t p = 0; p < pixels.count(); ++p, to += 3)
      for (std::size_t i = 0; pixels.counts[p] && i < 3; ++i) to[i] = static_cast<float>(pixels.at(p)[i] - origin_[i]);
  });
  std::array<double, 2> high{-1e300, -1e300};
  low_ = {1e300, 1e300};
  const auto count = static_cast<std::uint32_t>(places.pixels());
  std::uint64_t placed = 0;
  for (std::uint32_t p = 0; p < count; ++p) placed += std::isfinite(place_[3 * std::size_t{p}]);
  for (std::uint32_t p = 0; p < count; ++p)
    for (std::size_t i = 0; i < 2; ++i)
      if (const double v = double{place_[3 * std::size_t{p} + i]}; std::isfinite(v))
        low_[i] = std::min(low_[i], v), high[i] = std::max(high[i], v);
  const double area = std::max(1e-12, (high[0] - low_[0]) * (high[1] - low_[1]));
  const double side = std::max(std::sqrt(area * kPixelsPerBin / static_cast<double>(placed)), 1e-9);
  for (std::size_t i = 0; i < 2; ++i) {
    step_[i] = side;
    bins_[i] = std::clamp<std::int64_t>(static_cast<std::int64_t>((high[i] - low_[i]) / side) + 1, 1, 1 << 14);
    step_[i] = std::max(side, (high[i] - low_[i]) / static_cast<double>(bins_[i]) * (1 + 1e-9));
  }
  std::vector<std::uint32_t> bin(count, UINT32_MAX);
  first_.assign(static_cast<std::size_t>(bins_[0] * bins_[1]) + 1, 0);
  for (std::uint32_t p = 0; p < count; ++p) {
    const float* v = place_.data() + 3 * std::size_t{p};
    if (!std::isfinite(v[0])) continue;
    const auto [x, y] = bin_of(double{v[0]}, double{v[1]});
    bin[p] = static_cast<std::uint32_t>(y * bins_[0] + x);
    ++first_[bin[p] + 1];
  }
  for (std::size_t b = 1; b < first_.size(); ++b) first_[b] += first_[b - 1];
  pixel_.resize(first_.back());
  std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
  for (std::uint32_t p = 0; p < count; ++p)
    if (bin[p] != UINT32_MAX) pixel_[next[bin[p]]++] = p;
}

std::array<std::int64_t, 2> GroundMatch::bin_of(double x, double y) const {
  const auto along = [&](double v, std::size_t i) {
    return std::clamp<std::int64_t>(static_cast<std::int64_t>(std::floor((v - low_[i]) / step_[i])), 0, bins_[i] - 1);
  };
  return {along(x, 0), along(y, 1)};
}

/// Way on the ground from a pixel to the next, across or along: the shorter of those to its neighbours, so that a jump
/// in depth on one side is none of the pixel's.
std::array<double, 3> GroundMatch::slope(std::int64_t line, std::int64_t sample, int across) const {
  std::array<double, 3> out{};
  double least = 1e300;
  for (const int step : {-1, 1}) {
    const std::int64_t l = line + (across ? 0 : step), s = sample + (across ? step : 0);
    if (l < 0 || l >= lines_ || s < 0 || s >= samples_ || !std::isfinite(*at(l, s))) continue;
    std::array<double, 3> way{};
    for (std::size_t i = 0; i < 3; ++i) way[i] = step * (double{at(l, s)[i]} - double{at(line, sample)[i]});
    if (const double length = std::hypot(way[0], way[1], way[2]); length < least) least = length, out = way;
  }
  return out;
}

std::optional<ImagePlace> GroundMatch::find(const double* place, double of_place) const {
  const std::array<double, 3> p{place[0] - origin_[0], place[1] - origin_[1], place[2] - origin_[2]};
  if (!std::isfinite(p[0] + p[1] + p[2])) return std::nullopt;
  const auto [bx, by] = bin_of(p[0], p[1]);
  double nearest = 1e300;
  std::uint32_t found = 0;
  // Rings of bins about the place, until what is nearest lies nearer than the next ring.
  for (std::int64_t ring = 0; ring <= kMostRings && !(nearest <= std::pow(static_cast<double>(ring - 1) * step_[0], 2));
       ++ring)
    for (std::int64_t y = std::max<std::int64_t>(0, by - ring); y <= std::min(bins_[1] - 1, by + ring); ++y)
      for (std::int64_t x = std::max<std::int64_t>(0, bx - ring); x <= std::min(bins_[0] - 1, bx + ring); ++x) {
        if (std::max(std::abs(x - bx), std::abs(y - by)) != ring) continue;
        const auto b = static_cast<std::size_t>(y * bins_[0] + x);
        for (std::uint32_t i = first_[b]; i < first_[b + 1]; ++i) {
          const float* v = place_.data() + 3 * std::size_t{pixel_[i]};
          double square = 0;
          for (std::size_t k = 0; k < 3; ++k) square += (p[k] - double{v[k]}) * (p[k] - double{v[k]});
          if (square < nearest) nearest = square, found = pixel_[i];
        }
      }
  if (nearest == 1e300) return std::nullopt;
  const std::int64_t line = found / samples_, sample = found % samples_;
  const auto u = slope(line, sample, 1), v = slope(line, sample, 0);
  const double determinant = u[0] * v[1] - u[1] * v[0];
  const double size = std::max({of_place, std::hypot(u[0], u[1], u[2]), std::hypot(v[0], v[1], v[2])});
  if (determinant == 0 || nearest > kHidden * kHidden * size * size) return std::nullopt;
  const double dx = p[0] - double{at(line, sample)[0]}, dy = p[1] - double{at(line, sample)[1]};
  const double ds = (dx * v[1] - dy * v[0]) / determinant, dl = (u[0] * dy - u[1] * dx) / determinant;
  if (std::abs(ds) > kInside || std::abs(dl) > kInside) return std::nullopt;
  return ImagePlace{static_cast<double>(sample) + ds, static_cast<double>(line) + dl};
}

}  // namespace raycube::analysis
