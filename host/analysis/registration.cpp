#include "host/analysis/registration.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/Core>

namespace raycube::analysis {
namespace {

constexpr double kNoPixel = std::numeric_limits<double>::quiet_NaN();
constexpr int kMostSteps = 30;
constexpr double kSettled_px = 1e-5;
constexpr double kLeastCorrelation = 0.1;

/// Keys' cubic with a = -1/2 at a distance of 1 + t, t, 1 - t, 2 - t, and its derivative by t.
void keys(double t, std::array<double, 4>& weight, std::array<double, 4>& slope) {
  weight = {((-0.5 * t + 1) * t - 0.5) * t, (1.5 * t - 2.5) * t * t + 1, ((-1.5 * t + 2) * t + 0.5) * t,
            (0.5 * t - 0.5) * t * t};
  slope = {(-1.5 * t + 2) * t - 0.5, (4.5 * t - 5) * t, (-4.5 * t + 4) * t + 0.5, (1.5 * t - 1) * t};
}

struct Point {
  double value = kNoPixel, along_x = 0, along_y = 0;
};

/// The picture and its slopes between pixels; not a number where a neighbour is none.
Point interpolated(const Picture& p, double x, double y) {
  const double left = std::floor(x), top = std::floor(y);
  if (left < 1 || top < 1 || left + 3 > static_cast<double>(p.samples) || top + 3 > static_cast<double>(p.lines))
    return {};
  std::array<double, 4> wx, wy, sx, sy;
  keys(x - left, wx, sx), keys(y - top, wy, sy);
  Point out{0, 0, 0};
  for (std::size_t j = 0; j < 4; ++j)
    for (std::size_t i = 0; i < 4; ++i) {
      const double v = p.at(static_cast<std::size_t>(top) + j - 1, static_cast<std::size_t>(left) + i - 1);
      out.value += wy[j] * wx[i] * v, out.along_x += wy[j] * sx[i] * v, out.along_y += sy[j] * wx[i] * v;
    }
  return out;
}

/// Of pixels that both have, the second shifted by whole pixels.
double correlation_at(const Picture& a, const Picture& b, const std::array<std::size_t, 4>& box, int dx, int dy) {
  double n = 0, x = 0, y = 0, xx = 0, yy = 0, xy = 0;
  const auto [left, top, samples, lines] = box;
  const double first = a.at(top, left);  // near the values: sums of squares lose less
  for (std::size_t line = top; line < top + lines; ++line)
    for (std::size_t sample = left; sample < left + samples; ++sample) {
      const auto l = static_cast<std::int64_t>(line) + dy, s = static_cast<std::int64_t>(sample) + dx;
      if (l < 0 || s < 0 || l >= static_cast<std::int64_t>(b.lines) || s >= static_cast<std::int64_t>(b.samples))
        continue;
      const double u = a.at(line, sample) - first,
                   v = b.at(static_cast<std::size_t>(l), static_cast<std::size_t>(s)) - first;
      if (std::isnan(u) || std::isnan(v)) continue;
      ++n, x += u, y += v, xx += u * u, yy += v * v, xy += u * v;
    }
  const double va = xx - x * x / n, vb = yy - y * y / n;
  const bool enough = n * 2 >= static_cast<double>(samples * lines);
  return enough && va > 0 && vb > 0 ? (xy - x * y / n) / std::sqrt(va * vb) : -1;
}

/// One step of the least squares of b(x + d) = c + g a(x) for d, c and g; rms of the rest, and how many pixels.
struct Step {
  Eigen::Vector4d change = Eigen::Vector4d::Zero();
  Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
  double squares = 0, count = 0, correlation = 0;
};

Step step_of(const Picture& a, const Picture& b, const std::array<std::size_t, 4>& box, double dx, double dy) {
  const auto [left, top, samples, lines] = box;
  // Linear in the shift's change, c and g: b(x + d) + slopes change = c + g a(x).
  Eigen::Matrix<double, 5, 5> sums = Eigen::Matrix<double, 5, 5>::Zero();
  double n = 0, x = 0, y = 0, xx = 0, yy = 0, xy = 0;
  for (std::size_t line = top; line < top + lines; ++line)
    for (std::size_t sample = left; sample < left + samples; ++sample) {
      const Point there = interpolated(b, static_cast<double>(sample) + dx, static_cast<double>(line) + dy);
      const double here = a.at(line, sample);
      if (std::isnan(there.value) || std::isnan(here)) continue;
      Eigen::Matrix<double, 5, 1> row;
      row << -there.along_x, -there.along_y, 1, here, there.value;
      sums.selfadjointView<Eigen::Lower>().rankUpdate(row);
      ++n, x += here, y += there.value, xx += here * here, yy += there.value * there.value, xy += here * there.value;
    }
  Step out;
  out.count = n;
  const Eigen::Matrix<double, 5, 5> whole = sums.selfadjointView<Eigen::Lower>();
  out.normal = whole.topLeftCorner<4, 4>();
  const Eigen::Vector4d right = whole.block<4, 1>(0, 4);
  out.change = out.normal.ldlt().solve(right);
  out.squares = std::max(0.0, whole(4, 4) - right.dot(out.change));
  out.correlation = (xy - x * y / n) / std::sqrt((xx - x * x / n) * (yy - y * y / n));
  return out;
}

}  // namespace

Picture averaged(const Picture& picture, std::size_t factor) {
  Picture out{picture.samples / factor, picture.lines / factor, {}};
  for (std::size_t line = 0; line < out.lines; ++line)
    for (std::size_t sample = 0; sample < out.samples; ++sample) {
      double sum = 0;
      for (std::size_t j = 0; j < factor; ++j)
        for (std::size_t i = 0; i < factor; ++i) sum += picture.at(line * factor + j, sample * factor + i);
      out.value.push_back(sum / static_cast<double>(factor * factor));
    }
  return out;
}

Shift shift_of(const Picture& first, const Picture& second, std::size_t left, std::size_t top, std::size_t samples,
               std::size_t lines, int reach) {
  const std::array<std::size_t, 4> box = {left, top, samples, lines};
  Shift out;
  double best = -1;
  for (int dy = -reach; dy <= reach; ++dy)
    for (int dx = -reach; dx <= reach; ++dx)
      if (const double alike = correlation_at(first, second, box, dx, dy); alike > best)
        best = alike, out.samples = dx, out.lines = dy;
  if (!(best > kLeastCorrelation)) return out;
  const double whole_x = out.samples, whole_y = out.lines;
  for (int k = 0; k < kMostSteps; ++k) {
    const Step step = step_of(first, second, box, out.samples, out.lines);
    if (!(step.count > 16) || !step.change.allFinite()) return {};
    const double most = std::max(std::abs(step.change[0]), std::abs(step.change[1])), part = std::min(1.0, 0.5 / most);
    out.samples += part * step.change[0], out.lines += part * step.change[1];
    const Eigen::Matrix4d inverse = step.normal.ldlt().solve(Eigen::Matrix4d::Identity());
    const double variance = step.squares / std::max(1.0, step.count - 4);
    out.samples_error = std::sqrt(std::max(0.0, variance * inverse(0, 0)));
    out.lines_error = std::sqrt(std::max(0.0, variance * inverse(1, 1)));
    out.correlation = step.correlation;
    if (most < kSettled_px) break;
  }
  out.found = std::abs(out.samples - whole_x) <= 1.5 && std::abs(out.lines - whole_y) <= 1.5;
  return out;
}

}  // namespace raycube::analysis
