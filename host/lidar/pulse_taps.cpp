#include "host/lidar/pulse_taps.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "host/base/error.h"
#include "host/base/units.h"

namespace raycube::lidar {

namespace {

constexpr int kMostPhases = 4096, kMostTaps = 2048;

/// Phi(b) - Phi(a) without cancellation in either tail.
double normal_between(double a, double b) {
  if (a > 0) return 0.5 * (std::erfc(a * M_SQRT1_2) - std::erfc(b * M_SQRT1_2));
  if (b < 0) return 0.5 * (std::erfc(-b * M_SQRT1_2) - std::erfc(-a * M_SQRT1_2));
  return 0.5 * (std::erf(b * M_SQRT1_2) - std::erf(a * M_SQRT1_2));
}

double table_between(const std::vector<double>& time, const std::vector<double>& power, double begin, double end) {
  double sum = 0;
  for (std::size_t i = 0; i + 1 < time.size(); ++i) {
    const double from = std::max(begin, time[i]), to = std::min(end, time[i + 1]);
    if (!(to > from)) continue;
    const double slope = (power[i + 1] - power[i]) / (time[i + 1] - time[i]);
    sum += (to - from) * (power[i] + slope * (0.5 * (from + to) - time[i]));
  }
  return sum;
}

/// Phases that put a kink at `fraction` of a bin on a node, at least `least`.
int phases_for(double fraction, int least) {
  int best = kMostPhases;
  double worst = 1;
  for (int q = least; q <= kMostPhases; ++q) {
    const double off = std::abs(q * fraction - std::round(q * fraction)) / q;
    if (off < worst - 1e-12) worst = off, best = q;
    if (worst < 1e-12) break;
  }
  return best;
}

int phases_of(const scene::LidarPulse& pulse, double bin_s) {
  if (pulse.shape == scene::PulseShape::rectangular) {
    const double half = 0.5 * pulse.fwhm_s / bin_s;
    return phases_for(half - std::floor(half), 256);
  }
  if (pulse.shape == scene::PulseShape::tabulated) return kMostPhases;
  // Error of linear interpolation h^2/8 |S''|: S'' over the peak is below 1/s^2 for wide pulses and 0.49/s^2 for narrow
  // ones.
  const double sigma_bins = base::kSigmaOfFwhm * pulse.fwhm_s / bin_s;
  return std::clamp(static_cast<int>(std::ceil(250.0 / sigma_bins)), 64, kMostPhases);
}

}  // namespace

double pulse_share(const scene::LidarPulse& pulse, double begin_s, double end_s) {
  if (pulse.shape == scene::PulseShape::tabulated)
    return table_between(pulse.shape_time_s, pulse.shape_power, begin_s, end_s);
  if (pulse.fwhm_s == 0) return begin_s <= 0 && end_s > 0 ? 1 : 0;
  if (pulse.shape == scene::PulseShape::rectangular)
    return std::max(0.0, std::min(end_s, 0.5 * pulse.fwhm_s) - std::max(begin_s, -0.5 * pulse.fwhm_s)) / pulse.fwhm_s;
  const double sigma = base::kSigmaOfFwhm * pulse.fwhm_s;
  return normal_between(begin_s / sigma, end_s / sigma);
}

PulseSpan pulse_span(const scene::LidarPulse& pulse) {
  if (pulse.shape == scene::PulseShape::tabulated) return {pulse.shape_time_s.front(), pulse.shape_time_s.back()};
  const double half = (pulse.shape == scene::PulseShape::rectangular ? 0.5 : 6 * base::kSigmaOfFwhm) * pulse.fwhm_s;
  return {-half, half};
}

double pulse_centroid_s(const scene::LidarPulse& pulse) {
  if (pulse.shape != scene::PulseShape::tabulated) return 0;
  double area = 0, first = 0;
  for (std::size_t i = 1; i < pulse.shape_time_s.size();
       ++i) {  // straight pieces: Simpson's rule is exact for time times power
    const double a = pulse.shape_time_s[i - 1], b = pulse.shape_time_s[i], p = pulse.shape_power[i - 1],
                 q = pulse.shape_power[i];
    area += (b - a) * 0.5 * (p + q), first += (b - a) / 6 * (p * a + (p + q) * (a + b) + q * b);
  }
  return area > 0 ? first / area : 0;
}

PulseTaps make_taps(const scene::LidarPulse& pulse, double bin_s) {
  PulseTaps out;
  const PulseSpan span = pulse_span(pulse);
  if (span.begin_s == 0 && span.end_s == 0) {  // an impulse: all of it in the bin it falls in
    out.phases = 1, out.taps = 1, out.share = {1, 1};
    return out;
  }
  const double bins = (span.end_s - span.begin_s) / bin_s;
  if (!(bins <= kMostTaps))
    throw base::Error(base::Fault::input, "a LIDAR's pulse is too long for the gate's bins (found " +
                                              std::to_string((span.end_s - span.begin_s) * 1e9) +
                                              " ns from end to end in bins of " + std::to_string(bin_s * 1e9) +
                                              " ns, more than " + std::to_string(kMostTaps) +
                                              " bins); give wider bins (bin_ns) or a shorter pulse");
  out.phases = phases_of(pulse, bin_s);
  out.first = static_cast<int>(std::floor(span.begin_s / bin_s));
  out.taps = static_cast<int>(std::floor(span.end_s / bin_s + 1)) - out.first + 1;
  out.share.resize(static_cast<std::size_t>(out.phases + 1) * static_cast<std::size_t>(out.taps));
  std::vector<double> row(static_cast<std::size_t>(out.taps));
  for (int q = 0; q <= out.phases; ++q) {
    double sum = 0;
    for (int i = 0; i < out.taps; ++i) {
      const double begin = (out.first + i - static_cast<double>(q) / out.phases) * bin_s;
      sum += row[static_cast<std::size_t>(i)] = pulse_share(pulse, begin, begin + bin_s);
    }
    for (int i = 0; i < out.taps; ++i)
      out.share[static_cast<std::size_t>(q) * static_cast<std::size_t>(out.taps) + static_cast<std::size_t>(i)] =
          static_cast<float>(row[static_cast<std::size_t>(i)] / sum);
  }
  return out;
}

}  // namespace raycube::lidar
