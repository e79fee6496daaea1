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
constexpr int kPoints = 6;         ///< that pixels between pixels are interpolated from, along each axis
constexpr int kCheckPoints = 8;    ///< that tell what six leave
constexpr std::size_t kPatch = 8;  ///< pixels of a patch: what is left over is taken for alike inside of one

/// Shift along one axis: whole pixels, and the weights of as many neighbours as Lagrange's polynomial goes through,
/// with their derivatives by the shift.
struct Reach {
  std::int64_t first = 0;  ///< neighbour of pixel 0 that has the first weight
  std::vector<double> weight, slope;
};

Reach reach_of(double shift, int points) {
  const double whole = std::floor(shift), t = shift - whole;
  Reach out;
  out.first = static_cast<std::int64_t>(whole) - (points / 2 - 1);
  for (int i = 0; i < points; ++i) {
    const auto from = [&](int j) { return t - (j - (points / 2 - 1)); };
    double weight = 1, slope = 0;
    for (int j = 0; j < points; ++j) {
      if (j == i) continue;
      double rest = 1.0 / (i - j);
      for (int k = 0; k < points; ++k)
        if (k != i && k != j) rest *= from(k) / (i - k);
      slope += rest, weight *= from(j) / (i - j);
    }
    out.weight.push_back(weight), out.slope.push_back(slope);
  }
  return out;
}

struct Point {
  double value = kNoPixel, along_x = 0, along_y = 0;
};

/// The picture and its slopes between pixels; not a number where a neighbour is none. Pixels that the widest
/// interpolation does not reach are left out by all, so that all are of the same pixels.
Point interpolated(const Picture& p, std::size_t sample, std::size_t line, const Reach& x, const Reach& y) {
  const auto spare = (kCheckPoints - static_cast<std::int64_t>(x.weight.size())) / 2;
  const auto left = static_cast<std::int64_t>(sample) + x.first, top = static_cast<std::int64_t>(line) + y.first;
  const auto points = static_cast<std::int64_t>(x.weight.size());
  if (left < spare || top < spare || left + points + spare > static_cast<std::int64_t>(p.samples) ||
      top + points + spare > static_cast<std::int64_t>(p.lines))
    return {};
  Point out{0, 0, 0};
  for (std::size_t j = 0; j < y.weight.size(); ++j) {
    double value = 0, slope = 0;
    for (std::size_t i = 0; i < x.weight.size(); ++i) {
      const double v = p.at(static_cast<std::size_t>(top) + j, static_cast<std::size_t>(left) + i);
      value += x.weight[i] * v, slope += x.slope[i] * v;
    }
    out.value += y.weight[j] * value, out.along_x += y.weight[j] * slope, out.along_y += y.slope[j] * value;
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

using Row = Eigen::Matrix<double, 5, 1>;

/// Calls on(row, patch, here, there) for each pixel of the box that both have; a row is linear in the shift's change, c
/// and g: b(x + d) + slopes change = c + g a(x).
template <class On>
void for_each_row(const Picture& a, const Picture& b, const std::array<std::size_t, 4>& box, double dx, double dy,
                  int points, const On& on) {
  const auto [left, top, samples, lines] = box;
  const Reach x = reach_of(dx, points), y = reach_of(dy, points);
  const std::size_t patches = (samples + kPatch - 1) / kPatch;
  for (std::size_t line = 0; line < lines; ++line)
    for (std::size_t sample = 0; sample < samples; ++sample) {
      const Point there = interpolated(b, left + sample, top + line, x, y);
      const double here = a.at(top + line, left + sample);
      if (std::isnan(there.value) || std::isnan(here)) continue;
      Row row;
      row << -there.along_x, -there.along_y, 1, here, there.value;
      on(row, line / kPatch * patches + sample / kPatch, here, there.value);
    }
}

Step step_of(const Picture& a, const Picture& b, const std::array<std::size_t, 4>& box, double dx, double dy,
             int points = kPoints) {
  Eigen::Matrix<double, 5, 5> sums = Eigen::Matrix<double, 5, 5>::Zero();
  double n = 0, x = 0, y = 0, xx = 0, yy = 0, xy = 0;
  for_each_row(a, b, box, dx, dy, points, [&](const Row& row, std::size_t, double here, double there) {
    sums.selfadjointView<Eigen::Lower>().rankUpdate(row);
    ++n, x += here, y += there, xx += here * here, yy += there * there, xy += here * there;
  });
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

/// Standard errors of the shift: of the least squares, by what is left over, pixel by pixel or patch by patch,
/// whichever is more (what edges and waves leave is alike in neighbours); and what six points are off by, the step that
/// eight would still make.
std::array<double, 2> errors_of(const Picture& a, const Picture& b, const std::array<std::size_t, 4>& box,
                                const Shift& shift, const Step& last) {
  std::vector<Eigen::Vector4d> patch(((box[2] + kPatch - 1) / kPatch) * ((box[3] + kPatch - 1) / kPatch),
                                     Eigen::Vector4d::Zero());
  for_each_row(a, b, box, shift.samples, shift.lines, kPoints,
               [&](const Row& row, std::size_t which, double, double there) {
                 patch[which] += row.head<4>() * (there - row.head<4>().dot(last.change));
               });
  Eigen::Matrix4d squares = Eigen::Matrix4d::Zero();
  for (const Eigen::Vector4d& one : patch) squares += one * one.transpose();
  const Eigen::Matrix4d inverse = last.normal.ldlt().solve(Eigen::Matrix4d::Identity()),
                        by_patch = inverse * squares * inverse;
  const Step finer = step_of(a, b, box, shift.samples, shift.lines, kCheckPoints);
  const double variance = last.squares / std::max(1.0, last.count - 4);
  std::array<double, 2> out{};
  for (int k = 0; k < 2; ++k)
    out[static_cast<std::size_t>(k)] =
        std::sqrt(std::max({0.0, variance * inverse(k, k), by_patch(k, k)}) + finer.change[k] * finer.change[k]);
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
  Step step;
  for (int k = 0; k < kMostSteps; ++k) {
    step = step_of(first, second, box, out.samples, out.lines);
    if (!(step.count > 16) || !step.change.allFinite()) return {};
    const double most = std::max(std::abs(step.change[0]), std::abs(step.change[1])), part = std::min(1.0, 0.5 / most);
    out.samples += part * step.change[0], out.lines += part * step.change[1];
    if (most < kSettled_px) break;
  }
  step = step_of(first, second, box, out.samples, out.lines);
  if (!(step.count > 16) || !step.change.allFinite()) return {};
  const auto errors = errors_of(first, second, box, out, step);
  out.samples_error = errors[0], out.lines_error = errors[1], out.correlation = step.correlation;
  out.found = std::abs(out.samples - whole_x) <= 1.5 && std::abs(out.lines - whole_y) <= 1.5;
  return out;
}

}  // namespace raycube::analysis
