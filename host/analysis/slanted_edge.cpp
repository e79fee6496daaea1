#include "host/analysis/slanted_edge.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>

#include <fmt/format.h>

#include "host/base/error.h"

namespace raycube::analysis {
namespace {

using base::Error;
using base::Fault;

constexpr std::size_t kLeastSide = 8;
constexpr double kLeastStep = 1e-6, kLeastAngle_deg = 0.5, kMostAngle_deg = 40;
constexpr double kNear_px = 3;
constexpr double kMostGap_px = 0.15;  ///< straight lines over such gaps take sinc(f gap)^2: 0.018 of an MTF at Nyquist
constexpr double kEnd_px = 1;         ///< of what is seen on both sides: their means are the levels
constexpr double kFrequencyStep = 0.01, kMostFrequency = 1;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// Rows by columns, the edge running along the columns of numbers: across each row the level goes from low to high.
struct Patch {
  std::size_t rows = 0, columns = 0;
  std::vector<double> value;
  double at(std::size_t r, std::size_t c) const { return value[r * columns + c]; }
};

/// Turned so that the edge crosses each row, and rises.
Patch upright(const std::vector<double>& value, std::size_t rows, std::size_t columns) {
  Patch patch{rows, columns, value};
  double across = 0, along = 0;
  for (std::size_t r = 0; r < rows; ++r) across += patch.at(r, columns - 1) - patch.at(r, 0);
  for (std::size_t c = 0; c < columns; ++c) along += patch.at(rows - 1, c) - patch.at(0, c);
  const bool turned = std::abs(along) / static_cast<double>(columns) > std::abs(across) / static_cast<double>(rows);
  if (turned) {
    for (std::size_t r = 0; r < rows; ++r)
      for (std::size_t c = 0; c < columns; ++c) patch.value[c * rows + r] = value[r * columns + c];
    std::swap(patch.rows, patch.columns);
  }
  if ((turned ? along : across) < 0)
    for (std::size_t r = 0; r < patch.rows; ++r)
      std::reverse(patch.value.begin() + static_cast<std::ptrdiff_t>(r * patch.columns),
                   patch.value.begin() + static_cast<std::ptrdiff_t>((r + 1) * patch.columns));
  return patch;
}

/// Middle of a row's derivative, weighed by a Hann window about where it was before.
double centroid(const Patch& patch, std::size_t row, double middle, double half) {
  double sum = 0, moment = 0;
  for (std::size_t c = 0; c + 1 < patch.columns; ++c) {
    const double at = static_cast<double>(c) + 0.5, off = (at - middle) / half;
    if (std::abs(off) >= 1) continue;
    const double weight = 0.5 + 0.5 * std::cos(std::numbers::pi * off);
    const double slope = weight * (patch.at(row, c + 1) - patch.at(row, c));
    sum += slope, moment += slope * at;
  }
  return moment / sum;
}

/// column = start + slope row, by least squares through the rows' middles, looked for again about the line that was
/// found.
void fit_line(const Patch& patch, double& start, double& slope) {
  const auto rows = static_cast<double>(patch.rows), columns = static_cast<double>(patch.columns);
  start = columns / 2, slope = 0;
  for (int round = 0; round < 3; ++round) {
    double sx = 0, sy = 0, sxx = 0, sxy = 0;
    for (std::size_t r = 0; r < patch.rows; ++r) {
      const double x = static_cast<double>(r), y = centroid(patch, r, start + slope * x, columns * (round ? 0.5 : 2));
      sx += x, sy += y, sxx += x * x, sxy += x * y;
    }
    slope = (rows * sxy - sx * sy) / (rows * sxx - sx * sx), start = (sy - slope * sx) / rows;
  }
}

/// A pixel by its distance from the edge, px, along the normal.
struct EdgePixel {
  double off, level;
};

/// By distance, as far on both sides as every row reaches.
std::vector<EdgePixel> pixels_by_distance(const Patch& patch, double start, double slope, double& reach) {
  const double cosine = 1 / std::hypot(1.0, slope);
  reach = std::numeric_limits<double>::infinity();
  for (const std::size_t r : {std::size_t{0}, patch.rows - 1}) {
    const double at = start + slope * static_cast<double>(r);
    reach = std::min({reach, at * cosine, (static_cast<double>(patch.columns - 1) - at) * cosine});
  }
  std::vector<EdgePixel> out;
  for (std::size_t r = 0; r < patch.rows; ++r)
    for (std::size_t c = 0; c < patch.columns; ++c) {
      const double off = (static_cast<double>(c) - start - slope * static_cast<double>(r)) * cosine;
      if (std::abs(off) <= reach) out.push_back({off, patch.at(r, c)});
    }
  std::stable_sort(out.begin(), out.end(), [](const auto& a, const auto& b) { return a.off < b.off; });
  return out;
}

/// How far neighbours are apart near the edge, the mean over places.
double mean_gap(const std::vector<EdgePixel>& pixels) {
  double squares = 0, whole = 0;
  for (std::size_t i = 1; i < pixels.size(); ++i)
    if (const double wide = pixels[i].off - pixels[i - 1].off; std::abs(pixels[i].off) < kNear_px)
      squares += wide * wide, whole += wide;
  return squares / whole;
}

/// Mean level of the pixels whose distance lies between two.
double mean_level(const std::vector<EdgePixel>& pixels, double from, double to) {
  double sum = 0, count = 0;
  for (const EdgePixel& p : pixels)
    if (p.off >= from && p.off <= to) sum += p.level, ++count;
  return sum / count;
}

/// What is drawn: means of quarter pixels, and their differences.
void bin_edge(const std::vector<EdgePixel>& pixels, double reach, EdgeSpread& out) {
  const int half = static_cast<int>(reach * kEdgeBins);
  std::vector<double> sum(static_cast<std::size_t>(2 * half), 0.0), count(sum.size(), 0.0);
  for (const EdgePixel& p : pixels) {
    const double bin = std::floor(p.off * kEdgeBins) + half;
    if (!(bin >= 0 && bin < 2 * half)) continue;
    sum[static_cast<std::size_t>(bin)] += p.level, ++count[static_cast<std::size_t>(bin)];
  }
  for (std::size_t b = 0; b < sum.size(); ++b) {
    out.at_px.push_back((static_cast<double>(b) - half + 0.5) / kEdgeBins);
    out.spread.push_back(count[b] > 0 ? (sum[b] / count[b] - out.low) / (out.high - out.low)
                         : b > 0      ? out.spread.back()
                                      : 0.0);  // a bin that no phase reaches
  }
  for (std::size_t b = 0; b + 1 < out.spread.size(); ++b) out.line.push_back(out.spread[b + 1] - out.spread[b]);
  double total = 0;
  for (const double l : out.line) total += l;
  for (double& l : out.line) l /= total;
}

double sinc(double x) { return x == 0 ? 1 : std::sin(std::numbers::pi * x) / (std::numbers::pi * x); }

/// Of straight lines from each pixel to the next, in the order of their distances: each step of the level is a box of
/// the derivative as wide as the two are apart. The ends are means, so that one pixel's noise is not the whole step's.
void transfer(const std::vector<EdgePixel>& pixels, double reach, EdgeSpread& out) {
  std::vector<EdgePixel> points = {{-reach, out.low}};
  for (const EdgePixel& p : pixels)
    if (std::abs(p.off) < reach - kEnd_px) points.push_back(p);
  points.push_back({reach, out.high});
  for (double f = 0; f <= kMostFrequency + 1e-9; f += kFrequencyStep) {
    std::complex<double> sum = 0;
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
      const double wide = points[i + 1].off - points[i].off, middle = 0.5 * (points[i + 1].off + points[i].off);
      sum += (points[i + 1].level - points[i].level) * sinc(f * wide) *
             std::polar(1.0, -2 * std::numbers::pi * f * middle);
    }
    out.frequency.push_back(f), out.mtf.push_back(std::abs(sum) / (out.high - out.low));
  }
  out.mtf_nyquist = out.mtf[static_cast<std::size_t>(std::lround(0.5 / kFrequencyStep))];
  out.mtf50 = kNan;
  for (std::size_t k = 1; k < out.mtf.size() && std::isnan(out.mtf50); ++k)
    if (out.mtf[k] < 0.5)
      out.mtf50 = out.frequency[k - 1] + kFrequencyStep * (out.mtf[k - 1] - 0.5) / (out.mtf[k - 1] - out.mtf[k]);
}

double width_at_half(const EdgeSpread& edge) {
  const auto top = static_cast<std::size_t>(std::max_element(edge.line.begin(), edge.line.end()) - edge.line.begin());
  const double half = edge.line[top] / 2;
  const auto crossing = [&](std::ptrdiff_t step) {
    for (auto b = static_cast<std::ptrdiff_t>(top); b + step >= 0 && b + step < std::ssize(edge.line); b += step) {
      const double here = edge.line[static_cast<std::size_t>(b)], next = edge.line[static_cast<std::size_t>(b + step)];
      if (next <= half)
        return edge.at_px[static_cast<std::size_t>(b)] +
               static_cast<double>(step) / kEdgeBins * (here - half) / (here - next);
    }
    return kNan;
  };
  return crossing(1) - crossing(-1);
}

}  // namespace

EdgeSpread slanted_edge(const std::vector<double>& value, std::size_t rows, std::size_t columns,
                        const std::string& what) {
  if (rows < kLeastSide || columns < kLeastSide)
    throw Error(Fault::input, fmt::format("{}: an edge needs {} x {} pixels or more (found {} x {})", what, kLeastSide,
                                          kLeastSide, columns, rows));
  const auto [least, most] = std::minmax_element(value.begin(), value.end());
  if (!(*most - *least > kLeastStep * std::max(std::abs(*least), std::abs(*most))))
    throw Error(Fault::input, fmt::format("{}: has no edge: all is between {:.6g} and {:.6g}", what, *least, *most));
  const Patch patch = upright(value, rows, columns);
  EdgeSpread out;
  double start = 0, slope = 0;
  fit_line(patch, start, slope);
  out.angle_deg = std::atan(slope) * 180 / std::numbers::pi;
  const double last = start + slope * static_cast<double>(patch.rows - 1),
               columns_ = static_cast<double>(patch.columns);
  const bool inside = std::min(start, last) > 2 && std::max(start, last) < columns_ - 3;
  if (!(std::abs(out.angle_deg) >= kLeastAngle_deg && std::abs(out.angle_deg) <= kMostAngle_deg) || !inside)
    throw Error(Fault::input,
                fmt::format("{}: its edge runs at {:.2f} degrees to the pixels, from {:.1f} to {:.1f} of {} pixels; it "
                            "must be straight, at {:g} to {:g} degrees, and leave by two opposite sides",
                            what, out.angle_deg, start, last, patch.columns, kLeastAngle_deg, kMostAngle_deg));
  double reach = 0;
  const std::vector<EdgePixel> pixels = pixels_by_distance(patch, start, slope, reach);
  if (const double gap = mean_gap(pixels); gap > kMostGap_px)
    throw Error(
        Fault::input,
        fmt::format("{}: its pixels lie {:.2f} pixels apart along the edge's normal ({} rows at {:.2f} degrees, "
                    "whose phases repeat or do not fill a pixel), at most {:g} tell the transfer; take more rows, "
                    "or an edge at another angle",
                    what, gap, patch.rows, out.angle_deg, kMostGap_px));
  out.low = mean_level(pixels, -reach, kEnd_px - reach), out.high = mean_level(pixels, reach - kEnd_px, reach);
  transfer(pixels, reach, out);
  bin_edge(pixels, reach, out);
  out.fwhm_px = width_at_half(out);
  return out;
}

std::vector<EdgeSpread> slanted_edge(const Cube& cube, const Region& region) {
  const std::vector<Span>& spans = region.spans();
  const Span& first = spans.front();
  const auto columns = static_cast<std::size_t>(first.last - first.first + 1), rows = spans.size();
  for (std::size_t r = 0; r < rows; ++r)
    if (spans[r].first != first.first || spans[r].last != first.last ||
        spans[r].line != first.line + static_cast<std::int64_t>(r))
      throw Error(Fault::input, fmt::format("region \"{}\": an edge is looked for in a rectangle; give {}=X0:X1,Y0:Y1",
                                            region.name(), region.name()));
  std::vector<std::vector<double>> band(cube.bands(), std::vector<double>(rows * columns));
  Pixels pixels;
  for (std::size_t r = 0; r < rows; ++r) {
    cube.read(first.line + static_cast<std::int64_t>(r), 1, pixels);
    for (std::size_t c = 0; c < columns; ++c) {
      const std::size_t p = static_cast<std::size_t>(first.first) + c;
      if (!pixels.counts[p])
        throw Error(Fault::input, fmt::format("region \"{}\": line {}, sample {} is not finite or left out by the "
                                              "header's ignore value",
                                              region.name(), spans[r].line, p));
      for (std::size_t b = 0; b < cube.bands(); ++b) band[b][r * columns + c] = pixels.at(p)[b];
    }
  }
  std::vector<EdgeSpread> out;
  for (std::size_t b = 0; b < band.size(); ++b)
    out.push_back(slanted_edge(band[b], rows, columns, "band " + cube.band_text(b)));
  return out;
}

}  // namespace raycube::analysis
