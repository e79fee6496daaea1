#include "host/lidar/dial.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>

#include "host/base/error.h"
#include "host/lidar/detector.h"

namespace raycube::lidar {

namespace {

/// ln(counts / photons) that is defined for every input: at least one count, or one standard deviation.
struct LogReturn {
  double value = 0, variance = 0;
  bool seen = false;
};

LogReturn log_return(const NetCounts& n) {
  const double deviation = std::sqrt(std::max(0.0, n.variance));
  LogReturn out;
  // Below 1e-30 of what was fired light counts as gone (12.3).
  out.seen = n.counts > std::max(deviation, 1e-30 * n.photons);
  const double counts = out.seen ? n.counts : std::max({deviation, n.variance > 0 ? 1.0 : 0.0, 1e-30 * n.photons});
  out.value = std::log(counts / n.photons);
  out.variance = out.seen ? n.variance / (n.counts * n.counts) : 1;
  return out;
}

void require_fired(const NetCounts& n) {
  if (!(n.photons > 0))
    throw base::Error(base::Fault::input, "DIAL: a line that fires no photons (" + std::to_string(n.photons) +
                                              ") has no return to compare");
}

}  // namespace

DialColumn dial_column(const NetCounts& on, const NetCounts& off, double d_sigma_cm2, double extra_variance) {
  require_fired(on), require_fired(off);
  if (!(d_sigma_cm2 > 0))
    throw base::Error(base::Fault::input,
                      "DIAL: the cross-section on the line must exceed that off it, but differs by " +
                          std::to_string(d_sigma_cm2) + " cm2");
  const LogReturn a = log_return(on), b = log_return(off);
  if (!b.seen) return {};
  return {(b.value - a.value) / (2 * d_sigma_cm2),
          std::sqrt(a.variance + b.variance + extra_variance) / (2 * d_sigma_cm2),
          a.seen ? DialState::good : DialState::saturated};
}

double LineSection::transmission(double column_cm2) const {
  double sum = 0;
  for (std::size_t i = 0; i < weight.size(); ++i) sum += weight[i] * std::exp(-2 * sigma_cm2[i] * column_cm2);
  return sum;
}

double LineSection::mean_sigma_cm2() const {
  double sum = 0;
  for (std::size_t i = 0; i < weight.size(); ++i) sum += weight[i] * sigma_cm2[i];
  return sum;
}

DialColumn dial_column_of_line(const NetCounts& on, const NetCounts& off, const LineSection& on_line,
                               const LineSection& off_line, double extra_variance) {
  require_fired(on), require_fired(off);
  const LogReturn a = log_return(on), b = log_return(off);
  if (!b.seen) return {};
  // ln T_off(C) - ln T_on(C) rises from 0; negative ratios (noise) go on along the tangent at 0.
  const double target = b.value - a.value, slope_at_zero = 2 * (on_line.mean_sigma_cm2() - off_line.mean_sigma_cm2());
  if (!(slope_at_zero > 0))
    throw base::Error(base::Fault::input, "DIAL: the on line absorbs no more than the off line; exchange them");
  const auto depth = [&](double column) {
    const double on_t = on_line.transmission(column), off_t = off_line.transmission(column);
    return on_t > 0 && off_t > 0 ? std::log(off_t / on_t) : 1e300;
  };
  double lo = 0, hi = target / slope_at_zero, column = hi;
  if (target > 0) {
    while (depth(hi) < target && hi < 1e24) lo = hi, hi *= 2;
    for (int step = 0; step < 100 && hi - lo > 1e-14 * hi; ++step) {
      column = 0.5 * (lo + hi);
      (depth(column) < target ? lo : hi) = column;
    }
  }
  const double step = std::max(1e-6 * std::abs(column), 1e-9 / slope_at_zero);
  const double slope =
      target > 0
          ? std::max((depth(column + step) - depth(std::max(0.0, column - step))) / (step + std::min(step, column)),
                     1e-12 * slope_at_zero)
          : slope_at_zero;
  return {column, std::sqrt(a.variance + b.variance + extra_variance) / slope,
          a.seen ? DialState::good : DialState::saturated};
}

DialGases dial_gases(const std::vector<NetCounts>& returns, const std::vector<std::vector<double>>& sigma_cm2) {
  if (returns.size() != sigma_cm2.size() || sigma_cm2.empty() || sigma_cm2.front().empty())
    throw base::Error(base::Fault::input, "DIAL: " + std::to_string(returns.size()) +
                                              " returns but cross-sections at " + std::to_string(sigma_cm2.size()) +
                                              " wavelengths");
  const auto gases = static_cast<Eigen::Index>(sigma_cm2.front().size());
  std::vector<std::size_t> used;
  DialGases out;
  for (std::size_t i = 0; i < returns.size(); ++i) {
    require_fired(returns[i]);
    if (log_return(returns[i]).seen) used.push_back(i);
  }
  if (used.empty()) return out;
  out.state = DialState::saturated;
  if (static_cast<Eigen::Index>(used.size()) < gases + 1) return out;
  // Columns in units of the inverse mean cross-section keep the matrix near 1.
  double scale = 0;
  for (const auto& row : sigma_cm2)
    for (const double sigma : row) scale = std::max(scale, sigma);
  if (!(scale > 0)) throw base::Error(base::Fault::input, "DIAL: all cross-sections are zero");
  Eigen::MatrixXd a(static_cast<Eigen::Index>(used.size()), gases + 1);
  Eigen::VectorXd y(a.rows());
  bool noisy = false;
  for (Eigen::Index i = 0; i < a.rows(); ++i) {
    const std::size_t row = used[static_cast<std::size_t>(i)];
    const LogReturn r = log_return(returns[row]);
    noisy = noisy || r.variance > 0;
    const double weight = r.variance > 0 ? 1 / std::sqrt(r.variance) : 1;
    a(i, 0) = weight, y[i] = weight * r.value;
    for (Eigen::Index g = 0; g < gases; ++g)
      a(i, g + 1) = -2 * weight * sigma_cm2[row][static_cast<std::size_t>(g)] / scale;
  }
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(a);
  if (qr.rank() < a.cols()) return out;  // the wavelengths left cannot tell the gases apart
  const Eigen::VectorXd x = qr.solve(y);
  const Eigen::MatrixXd covariance = (a.transpose() * a).inverse();
  out.state = DialState::good;
  for (Eigen::Index g = 1; g <= gases; ++g) {
    out.column_cm2.push_back(x[g] / scale);
    out.error_cm2.push_back(noisy ? std::sqrt(covariance(g, g)) / scale : 0);
  }
  return out;
}

std::vector<DialColumn> dial_profile(const std::vector<NetCounts>& on, const std::vector<NetCounts>& off,
                                     double d_sigma_cm2, double bin_m, int bins_apart) {
  std::vector<DialColumn> out;
  const auto apart = static_cast<std::size_t>(std::max(1, bins_apart));
  const double length_cm = 100 * bin_m * static_cast<double>(apart);
  for (std::size_t i = 0; i + apart < std::min(on.size(), off.size()); ++i) {
    const LogReturn near_on = log_return(on[i]), near_off = log_return(off[i]), far_on = log_return(on[i + apart]),
                    far_off = log_return(off[i + apart]);
    DialColumn cell;
    if (near_on.seen && near_off.seen && far_off.seen) {
      cell.state = far_on.seen ? DialState::good : DialState::saturated;
      cell.column_cm2 = (far_off.value + near_on.value - far_on.value - near_off.value) / (2 * d_sigma_cm2 * length_cm);
      cell.error_cm2 = std::sqrt(near_on.variance + near_off.variance + far_on.variance + far_off.variance) /
                       (2 * d_sigma_cm2 * length_cm);
    } else if (near_off.seen && far_off.seen) {
      cell.state = DialState::saturated;
    }
    out.push_back(cell);
  }
  return out;
}

LineSection line_section(const LidarPlan& plan, int volume, int line) {
  LineSection out;
  const auto at = static_cast<std::size_t>(line);
  for (int node = plan.first_node[at]; node < plan.first_node[at + 1]; ++node) {
    out.weight.push_back(plan.nodes[static_cast<std::size_t>(node)].weight);
    out.sigma_cm2.push_back(
        plan.cross_section_cm2[static_cast<std::size_t>(volume) * plan.nodes.size() + static_cast<std::size_t>(node)]);
  }
  return out;
}

const Echo* strongest_echo(const Detection& record) {
  const auto found = std::max_element(record.echoes.begin(), record.echoes.end(),
                                      [](const Echo& a, const Echo& b) { return a.energy_pe < b.energy_pe; });
  return found == record.echoes.end() ? nullptr : &*found;
}

NetCounts net_counts(const LidarPlan& plan, const Detection& record, double time_s) {
  const scene::Lidar& lidar = plan.lidar;
  const double middle = (time_s - lidar.gate.start_s) / lidar.gate.bin_s,
               half = std::max(1.5, 3 * recorded_sigma_s(lidar) / lidar.gate.bin_s);
  const auto bins = static_cast<double>(record.waveform_pe.size());
  const auto first = static_cast<std::size_t>(std::clamp(std::floor(middle - half), 0.0, bins)),
             last = static_cast<std::size_t>(std::clamp(std::ceil(middle + half), 0.0, bins));
  const bool linear = lidar.detector.mode == scene::DetectorMode::linear;
  const double excess = linear ? excess_noise(lidar.detector.gain, lidar.detector.ionization_ratio) : 1;
  const double readout = linear ? lidar.detector.readout_noise_e / lidar.detector.gain : 0;
  NetCounts out;
  out.photons = plan.photons[static_cast<std::size_t>(record.line)];
  double total = 0;
  for (std::size_t i = first; i < last; ++i) total += record.waveform_pe[i];
  const double width = static_cast<double>(last - first);
  out.counts = total - width * record.truth.background_pe;
  out.variance = excess * std::max(total, 0.0) + width * readout * readout;
  return out;
}

}  // namespace raycube::lidar
