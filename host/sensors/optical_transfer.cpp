#include "host/sensors/optical_transfer.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "host/base/interrupt.h"

namespace raycube::sensors {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kSigmas = 4.5;        ///< of a Gaussian
constexpr double kAiry_lambda_n = 20;  ///< of diffraction, in wavelengths times f-number
constexpr int kPerRing = 8;            ///< steps of the integral between two rings, at least
constexpr double kPerWave = 12;        ///< and in a wave of the highest frequency
constexpr double kRingPoints = 24;     ///< frequencies per cycle over the outermost radius, for linear interpolation

double gaussian(double sigma, double f) { return std::exp(-2 * kPi * kPi * sigma * sigma * f * f); }

/// Transfer of rings at one frequency, not normalised: integral of h(r) J0(2 pi f r) r dr, by Simpson's rule on a grid
/// that has every ring as a node.
double ring_integral(const std::vector<double>& radius, const std::vector<double>& h, double f) {
  double sum = 0;
  for (std::size_t i = 1; i < radius.size(); ++i) {
    const double width = radius[i] - radius[i - 1];
    const int steps = 2 * std::max(kPerRing / 2, static_cast<int>(std::ceil(0.5 * kPerWave * f * width)));
    for (int s = 0; s <= steps; ++s) {
      const double t = static_cast<double>(s) / steps, r = radius[i - 1] + t * width;
      const double weight = s == 0 || s == steps ? 1 : s % 2 ? 4 : 2;
      // ::j0 of libm: std::cyl_bessel_j takes a time that grows with its argument, 40 s for rings out to 20 pixels.
      sum += weight * width / (3 * steps) * (h[i - 1] + t * (h[i] - h[i - 1])) * ::j0(2 * kPi * f * r) * r;
    }
  }
  return sum;
}

}  // namespace

double sinc(double x) { return x == 0 ? 1 : std::sin(kPi * x) / (kPi * x); }

double diffraction_mtf(double v, double e) {
  const auto lens = [](double x) { return x < 1 ? 2 / kPi * (std::acos(x) - x * std::sqrt(1 - x * x)) : 0; };
  if (v >= 1) return 0;
  double sum = lens(v);
  if (e > 0) {
    sum += e * e * lens(v / e);
    if (v <= (1 - e) / 2) {
      sum -= 2 * e * e;
    } else if (v < (1 + e) / 2) {
      const double phi = std::acos(std::clamp((1 + e * e - 4 * v * v) / (2 * e), -1.0, 1.0));
      sum += 2 * e / kPi * std::sin(phi) + (1 + e * e) / kPi * phi -
             2 * (1 - e * e) / kPi * std::atan2((1 + e) * std::sin(phi / 2), (1 - e) * std::cos(phi / 2)) - 2 * e * e;
    }
  }
  return sum / (1 - e * e);
}

OpticalTransfer::OpticalTransfer(const scene::FocalPlane& plane, double highest) : plane_(plane) {
  const scene::SpreadTable& table = plane.spread;
  if (!table.rings()) return;
  step_ = 1 / (kRingPoints * table.radius_px.back());
  const auto count = static_cast<std::size_t>(std::ceil(std::sqrt(2.0) * highest / step_)) + 2;
  for (const auto& h : table.value) {
    auto& row = rings_.emplace_back(count);
    for (std::size_t i = 0; i < count; ++i) {
      if (i % 64 == 0) base::throw_if_interrupted();
      row[i] = ring_integral(table.radius_px, h, static_cast<double>(i) * step_);
    }
    const double all = row.front();
    for (double& v : row) v /= all;
  }
}

double OpticalTransfer::rings(double um, double f) const {
  const auto at = [&](std::size_t w) {
    const double x = std::min(f / step_, static_cast<double>(rings_[w].size() - 1));
    const auto i = std::min(static_cast<std::size_t>(x), rings_[w].size() - 2);
    return std::lerp(rings_[w][i], rings_[w][i + 1], x - static_cast<double>(i));
  };
  const auto& known = plane_.spread.wavelength_um;
  const auto above = std::lower_bound(known.begin(), known.end(), um);
  if (above == known.begin()) return at(0);
  if (above == known.end()) return at(known.size() - 1);
  const auto i = static_cast<std::size_t>(above - known.begin());
  return std::lerp(at(i - 1), at(i), (um - known[i - 1]) / (known[i] - known[i - 1]));
}

std::complex<double> OpticalTransfer::grid(double fu, double fv) const {
  const scene::SpreadTable& table = plane_.spread;
  std::complex<double> sum = 0;
  double all = 0;
  for (std::size_t i = 0; i < table.grid_value.size(); ++i) {
    sum += std::polar(table.grid_value[i], -2 * kPi * (fu * table.x_px[i] + fv * table.y_px[i]));
    all += table.grid_value[i];
  }
  return sum / all;
}

std::complex<double> OpticalTransfer::operator()(double um, double fu, double fv) const {
  const scene::FocalPlane& p = plane_;
  std::complex<double> out = sinc(p.detector_px[0] * fu) * sinc(p.detector_px[1] * fv) * sinc(p.smear_px[0] * fu) *
                             sinc(p.smear_px[1] * fv) * gaussian(p.sigma_px[0], fu) * gaussian(p.sigma_px[1], fv) *
                             gaussian(p.jitter_px, std::hypot(fu, fv));
  if (p.f_number > 0) out *= diffraction_mtf(std::hypot(fu, fv) * um * p.f_number / p.pitch_um, p.obscuration);
  if (p.spread.rings())
    out *= rings(um, std::hypot(fu, fv));
  else if (!p.spread.empty())
    out *= grid(fu, fv);
  return out;
}

std::array<double, 2> OpticalTransfer::reach_px(double um) const {
  const scene::FocalPlane& p = plane_;
  std::array<double, 2> out{};
  const auto& spread = p.spread;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    out[axis] = 0.5 * (p.detector_px[axis] + p.smear_px[axis]) + kSigmas * std::hypot(p.sigma_px[axis], p.jitter_px);
    if (p.f_number > 0) out[axis] += kAiry_lambda_n * um * p.f_number / (p.pitch_um * (1 - p.obscuration));
    if (spread.rings()) out[axis] += spread.radius_px.back();
    double farthest = 0;
    for (const double x : axis == 0 ? spread.x_px : spread.y_px) farthest = std::max(farthest, std::abs(x));
    out[axis] += farthest;
  }
  return out;
}

}  // namespace raycube::sensors
