#include "host/lidar/speckle.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "host/base/units.h"
#include "host/lidar/draws.h"
#include "host/lidar/incomplete_gamma.h"
#include "host/lidar/overlap.h"
#include "host/lidar/quadrature.h"

namespace raycube::lidar {

namespace {

/// Length of the pulse as speckle knows it, s.
double pulse_length_s(const scene::LidarPulse& pulse) {
  if (pulse.shape == scene::PulseShape::tabulated && !pulse.shape_time_s.empty())
    return pulse.shape_time_s.back() - pulse.shape_time_s.front();
  return pulse.fwhm_s;
}

}  // namespace

double pupil_autocorrelation(double pupil_m, double obscuration_m, double shift_m) {
  return circle_overlap(pupil_m, pupil_m, shift_m) - 2 * circle_overlap(pupil_m, obscuration_m, shift_m) +
         circle_overlap(obscuration_m, obscuration_m, shift_m);
}

double spatial_modes(double pupil_m, double obscuration_m, bool gaussian, double spot_m, double wavelength_m,
                     double range_m) {
  const double area = M_PI * (pupil_m * pupil_m - obscuration_m * obscuration_m);
  if (!(area > 0) || !(spot_m > 0) || !(range_m > 0)) return 1;
  const double scale = M_PI * spot_m / (wavelength_m * range_m);  // 1/m
  const auto coherence = [&](double s) {
    const double x = scale * s;
    if (gaussian) return std::exp(-x * x);
    const double airy = x < 1e-6 ? 1 : std::cyl_bessel_j(1.0, 2 * x) / x;
    return airy * airy;
  };
  // Kinks of the annulus' autocorrelation, and parts no longer than the speckle's size as far as it matters.
  std::vector<double> breaks{0, pupil_m - obscuration_m, 2 * obscuration_m, pupil_m + obscuration_m, 2 * pupil_m};
  // A Gaussian is gone at 7 of its radii; the rings of a disc fade as s^-3, (x = 400: 1e-8 of the integral left out).
  const double end = std::min(2 * pupil_m, (gaussian ? 7.0 : 400.0) / scale);
  const int parts = std::clamp(static_cast<int>(std::ceil(end * scale / (gaussian ? 3.5 : 20))), 1, 64);
  for (int i = 1; i <= parts; ++i) breaks.push_back(end * i / parts);
  std::sort(breaks.begin(), breaks.end());
  double integral = 0;
  for (std::size_t i = 1; i < breaks.size() && breaks[i - 1] < end; ++i)
    integral += integrate_branch_ends(
        [&](double s) { return 2 * M_PI * s * pupil_autocorrelation(pupil_m, obscuration_m, s) / area * coherence(s); },
        breaks[i - 1], std::min(end, breaks[i]));
  return std::max(1.0, area / integral);
}

double effective_area_m2(const std::vector<double>& energy, const std::vector<double>& cell_m2) {
  double sum = 0, squares = 0;
  for (std::size_t i = 0; i < energy.size(); ++i) {
    if (!(energy[i] > 0)) continue;
    sum += energy[i], squares += energy[i] * energy[i] / cell_m2[i];
  }
  return squares > 0 ? sum * sum / squares : 0;
}

double temporal_modes(double width_hz, double pulse_s) { return std::hypot(1.0, width_hz * pulse_s); }

double line_width_hz(double wavelength_um, double fwhm_um) {
  return base::kLightSpeed_m_s * fwhm_um * 1e-6 / (wavelength_um * wavelength_um * 1e-12);
}

double speckle_modes(const scene::Lidar& lidar, int line, double half_divergence_rad, double range_m) {
  const scene::LidarLine& at = lidar.pulse.lines[static_cast<std::size_t>(line)];
  const bool gaussian = lidar.pulse.profile == scene::BeamProfile::gaussian;
  const double grown = std::tan(half_divergence_rad) * range_m;
  double spot = gaussian ? std::hypot(lidar.pulse.exit_radius_m, grown) : lidar.pulse.exit_radius_m + grown;
  bool spot_gaussian = gaussian;
  if (lidar.receiver.columns * lidar.receiver.rows > 1 || lidar.receiver.pixel_pitch_rad > 0) {
    // A pixel sees its own field of the target alone; a square is near enough to the disc of its area.
    const double pixel = lidar.receiver.pixel_pitch_rad * range_m / std::sqrt(M_PI);
    if (pixel < spot) spot = pixel, spot_gaussian = false;
  }
  return spatial_modes(lidar.receiver.aperture_radius_m, lidar.receiver.obscuration_radius_m, spot_gaussian, spot,
                       at.wavelength_um * 1e-6, range_m) *
         lidar.speckle.polarization_modes *
         temporal_modes(line_width_hz(at.wavelength_um, at.fwhm_um), pulse_length_s(lidar.pulse));
}

SpeckleRow speckle_row(const LidarPlan& plan, const Shot& shot, int pixel, int line,
                       const std::vector<double>& expected) {
  const scene::Lidar& lidar = plan.lidar;
  SpeckleRow row{std::vector<double>(expected.size(), 1.0), 0};
  if (!lidar.speckle.on) return row;
  const double bin_s = lidar.gate.bin_s;
  const auto pulse_bins = static_cast<std::size_t>(std::max(1.0, std::round(pulse_length_s(lidar.pulse) / bin_s)));
  const std::uint32_t key = draw_key(plan, shot.pulse, pixel);
  double strongest = 0;
  // Modes change slowly with range: exact at steps of 10 %, between them a power of the range (within 1e-3 of the exact
  // integral).
  constexpr double kStep = 0.1;
  std::map<int, double> log_modes;
  const auto modes_at = [&](double range_m) {
    const double position = std::log(range_m) / kStep;
    const int below = static_cast<int>(std::floor(position));
    const auto node = [&](int i) {
      const auto [at, fresh] = log_modes.try_emplace(i, 0.0);
      if (fresh) at->second = std::log(speckle_modes(lidar, line, shot.half_divergence_rad, std::exp(kStep * i)));
      return at->second;
    };
    const double low = node(below);
    return std::exp(low + (position - below) * (node(below + 1) - low));
  };
  const auto draw = [&](std::size_t first, std::size_t last) {  // [first, last)
    double sum = 0, moment = 0;
    for (std::size_t i = first; i < last; ++i)
      sum += expected[i], moment += expected[i] * (static_cast<double>(i) + 0.5);
    if (!(sum > 0)) return;
    const double time_s = lidar.gate.start_s + bin_s * moment / sum;
    const double modes = modes_at(std::max(1e-3, 0.5 * base::kLightSpeed_m_s * time_s / lidar.transport.group_index));
    if (sum > strongest) strongest = sum, row.strongest_modes = modes;
    Stream stream(plan.seed, key, static_cast<std::uint32_t>(first), DrawFor::speckle, line);
    const double factor = stream.gamma(modes) / modes;
    for (std::size_t i = first; i < last; ++i) row.factor[i] = factor;
  };
  for (std::size_t i = 0; i < expected.size();) {
    if (!(expected[i] > 0)) {
      ++i;
      continue;
    }
    // Down a return and into its dip: the minimum after which the row doubles again.
    double top = expected[i], low = expected[i];
    std::size_t end = i + 1, lowest = i + 1;
    for (; end < expected.size() && expected[end] > 0; ++end) {
      if (top > 2 * low && expected[end] > 2 * low) break;
      if (expected[end] > top && !(top > 2 * low)) top = low = expected[end], lowest = end + 1;
      if (expected[end] <= low) low = expected[end], lowest = end + 1;
    }
    const std::size_t stop = end < expected.size() && expected[end] > 0 ? lowest : end;
    double sum = 0, squares = 0;
    for (std::size_t k = i; k < stop; ++k) sum += expected[k], squares += expected[k] * expected[k];
    // sum^2 / squares is 1.5 lengths of a Gaussian pulse and 1 of a rectangular one, whatever its faint tails.
    const std::size_t cut = sum * sum / squares > 3.0 * static_cast<double>(pulse_bins) + 1 ? pulse_bins : stop - i;
    for (std::size_t first = i; first < stop; first += cut) draw(first, std::min(first + cut, stop));
    i = stop;
  }
  return row;
}

double negative_binomial_probability(double k, double mean, double modes) {
  if (!(mean > 0)) return k == 0 ? 1 : 0;
  if (!(modes > 0)) return std::exp(k * std::log(mean) - mean - log_gamma(k + 1));
  return std::exp(log_gamma(k + modes) - log_gamma(k + 1) - log_gamma(modes) - k * std::log1p(modes / mean) -
                  modes * std::log1p(mean / modes));
}

}  // namespace raycube::lidar
