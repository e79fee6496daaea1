#include "host/reference/lidar_compare.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "host/reference/parallel.h"

namespace raycube::reference {

struct LidarComparison::Result {
  std::int64_t pulse = 0;
  std::uint64_t rays = 0;
  std::array<std::uint64_t, kCauses> hits{};
  bool parted = false, edge = false;
  std::uint32_t unexplained_ray = 0;
  double worst = 0, air = 0;
  int line = 0, bin = 0;
  bool scattered_same = true;
  double closure = 0, ledger = 0;
  std::vector<std::vector<double>> scattered;  ///< [device, replica ...][line * bins]
};

namespace {

/// The ray as the judge takes it: from where it enters the scene's box, with room for two ways of rounding it there.
DoubleRay judged(const scene::CompiledScene& scene, const LidarRay& ray) {
  glm::dvec3 size(0), middle(0);
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    size[axis] = static_cast<double>(scene.hi[a]) - static_cast<double>(scene.lo[a]);
    middle[axis] = 0.5 * (static_cast<double>(scene.hi[a]) + static_cast<double>(scene.lo[a]));
  }
  const double radius = 0.5 * glm::length(size) + 1e-3;
  const double start = std::max(0.0, glm::dot(middle - ray.origin, ray.direction) - radius);
  const glm::dvec3 origin = ray.origin + start * ray.direction;
  return {origin, ray.direction, 8 * kUlp * (glm::length(origin) + 2 * radius)};
}

double largest(const std::vector<double>& a, const std::vector<double>& b, std::size_t from, std::size_t count) {
  double most = 0;
  for (std::size_t i = from; i < from + count; ++i) most = std::max(most, a[i] + b[i]);
  return most;
}

double difference(const lidar::Ledger& a, const lidar::Ledger& b) {
  return std::max({std::abs(a.absorbed - b.absorbed), std::abs(a.air - b.air), std::abs(a.volumes - b.volumes), std::abs(a.escaped - b.escaped),
                   std::abs(a.truncated - b.truncated)});
}

/// Sum of rows over pixels: [line * bins].
template <typename Number>
std::vector<double> over_pixels(const std::vector<Number>& rows, std::size_t width) {
  std::vector<double> out(width, 0.0);
  for (std::size_t i = 0; i < rows.size(); ++i) out[i % width] += static_cast<double>(rows[i]);
  return out;
}

}  // namespace

LidarComparison::LidarComparison(const scene::CompiledScene& scene, const lidar::LidarPlan& plan, const LidarCompareOptions& options)
    : scene_(scene), plan_(plan), options_(options), embree_(scene), judge_(scene) {}
LidarComparison::~LidarComparison() = default;

LidarComparison::Result LidarComparison::compare(const lidar::ShotResult& device) const {
  Result result;
  result.pulse = device.shot.pulse;
  const LidarReference reference = reference_shot(scene_, embree_, plan_, device.shot);
  const std::vector<LidarRay> rays = lidar_rays(plan_, device.shot);
  result.rays = rays.size();
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const Hit hit = i < device.hits.size() ? Hit{device.hits[i].instance, device.hits[i].primitive} : Hit{};
    const Cause cause = hit == reference.hits[i] ? Cause::agree : judge_.explain(judged(scene_, rays[i]), hit, reference.hits[i]);
    if (cause == Cause::unexplained && result.hits[static_cast<std::size_t>(cause)] == 0) result.unexplained_ray = static_cast<std::uint32_t>(i);
    ++result.hits[static_cast<std::size_t>(cause)];
    result.parted |= cause != Cause::agree;
  }
  const auto bins = static_cast<std::size_t>(plan_.lidar.gate.bins), lines = static_cast<std::size_t>(plan_.lines());
  const auto pixels = static_cast<std::size_t>(plan_.pixels());
  for (std::size_t line = 0; line < lines; ++line) {
    result.closure = std::max(result.closure, std::abs(device.ledger[line].emitted_error()));
    result.ledger = std::max(result.ledger, difference(device.ledger[line], reference.ledger[line]));
    double peak = 0, air_peak = 0;
    for (std::size_t pixel = 0; pixel < pixels; ++pixel) {
      const std::size_t row = (pixel * lines + line) * bins;
      peak = std::max(peak, largest(reference.rows.first, reference.rows.multiple, row, bins));
      for (std::size_t i = row; i < row + bins; ++i) air_peak = std::max(air_peak, reference.rows.air[i]);
    }
    for (std::size_t pixel = 0; pixel < pixels; ++pixel)
      for (std::size_t bin = 0; bin < bins; ++bin) {
        const std::size_t i = (pixel * lines + line) * bins + bin;
        const double off = std::abs(static_cast<double>(device.first[i]) - reference.rows.first[i]);
        // A bin of less than 1e-9 photons in a pulse without an echo has no peak to be measured by.
        const double relative = off / std::max(peak, 1e-9);
        if (relative > result.worst) result.worst = relative, result.line = static_cast<int>(line), result.bin = static_cast<int>(bin);
        if (!device.multiple.empty())
          result.scattered_same &= std::abs(static_cast<double>(device.multiple[i]) - reference.rows.multiple[i]) <= options_.limits.bin * std::max(peak, 1e-9);
        if (!device.air.empty() && air_peak > 0)
          result.air = std::max(result.air, std::abs(static_cast<double>(device.air[i]) - reference.rows.air[i]) / air_peak);
      }
  }
  if (!result.parted && result.worst > options_.limits.bin) {
    LidarShotOptions again;
    again.count_uncertain = true;
    result.edge = reference_shot(scene_, embree_, plan_, device.shot, again).uncertain > 0;
  }
  if (!device.multiple.empty()) {
    result.scattered.push_back(over_pixels(device.multiple, lines * bins));
    for (int replica = 0; replica < options_.replicas; ++replica) {
      LidarShotOptions own;
      own.own_seed = true;
      own.seed = plan_.seed + 0x9E3779B9u * static_cast<std::uint64_t>(replica + 1);
      own.scattered_only = true;
      result.scattered.push_back(over_pixels(reference_shot(scene_, embree_, plan_, device.shot, own).rows.multiple, lines * bins));
    }
  }
  return result;
}

void LidarComparison::add(const std::vector<lidar::ShotResult>& shots) {
  std::vector<Result> fresh(shots.size());
  for_each_index(shots.size(), options_.threads, [&](std::size_t i) { fresh[i] = compare(shots[i]); });
  for (Result& result : fresh) {
    if (scattered_.empty()) scattered_.resize(result.scattered.size());
    for (std::size_t r = 0; r < result.scattered.size(); ++r) {
      scattered_[r].resize(result.scattered[r].size(), 0.0);
      for (std::size_t i = 0; i < result.scattered[r].size(); ++i) scattered_[r][i] += result.scattered[r][i];
    }
    result.scattered.clear();
    results_.push_back(std::move(result));
  }
}

LidarScattered LidarComparison::scattered() const {
  LidarScattered out;
  if (scattered_.size() < 8) return out;
  const double count = static_cast<double>(scattered_.size() - 1);
  struct Group {
    double device = 0, mean = 0, variance = 0;
  };
  const auto group_of = [&](std::size_t from, std::size_t to) {
    std::vector<double> sums(scattered_.size(), 0.0);
    for (std::size_t r = 0; r < scattered_.size(); ++r)
      for (std::size_t i = from; i < to; ++i) sums[r] += scattered_[r][i];
    Group g;
    g.device = sums[0];
    for (std::size_t r = 1; r < sums.size(); ++r) g.mean += sums[r] / count;
    for (std::size_t r = 1; r < sums.size(); ++r) g.variance += (sums[r] - g.mean) * (sums[r] - g.mean) / (count - 1);
    return g;
  };
  // t^2 of one draw against `count` of them: mean and variance of F(1, count - 1).
  const double freedom = count - 1, t2_mean = freedom / (freedom - 2);
  const double t2_variance = 2 * freedom * freedom * (freedom - 1) / ((freedom - 2) * (freedom - 2) * (freedom - 4));
  const auto t2 = [&](const Group& g) { return (g.device - g.mean) * (g.device - g.mean) / (g.variance * (1 + 1 / count)); };
  const std::size_t bins = static_cast<std::size_t>(plan_.lidar.gate.bins), lines = scattered_[0].size() / bins;
  // Neighbouring bins share a pulse's light: groups are several pulses wide, and wide enough for 20 % noise.
  const auto least = static_cast<std::size_t>(std::max(4.0, std::ceil(4 * plan_.lidar.pulse.fwhm_s / plan_.lidar.gate.bin_s)));
  double sum = 0;
  for (std::size_t line = 0; line < lines; ++line)
    for (std::size_t from = line * bins, to = from; to < (line + 1) * bins; from = to) {
      Group g;
      do {
        to = std::min(to + least, (line + 1) * bins);
        g = group_of(from, to);
      } while (to < (line + 1) * bins && !(g.mean > 0 && g.variance < 0.04 * g.mean * g.mean));
      if (!(g.mean > 0 && g.variance > 0 && g.variance < 0.04 * g.mean * g.mean)) continue;
      ++out.groups;
      sum += t2(g);
    }
  const Group all = group_of(0, lines * bins);
  out.energy_ratio = all.mean > 0 ? all.device / all.mean : 1;
  out.energy_z = all.variance > 0 ? (all.device - all.mean) / std::sqrt(all.variance * (1 + 1 / count) * t2_mean) : 0;
  if (out.groups > 0) {
    const double groups = static_cast<double>(out.groups);
    out.chi_square = sum / groups;
    out.chi_z = (sum - groups * t2_mean) / std::sqrt(groups * t2_variance);
  }
  return out;
}

LidarReport LidarComparison::report() const {
  LidarReport out;
  out.limits = options_.limits;
  out.has_air = plan_.lidar.transport.air_return && plan_.air.posts > 0;
  out.has_scattered = !scattered_.empty();
  std::vector<double> worst, air;
  out.scattered = scattered();
  for (const Result& r : results_) {
    ++out.pulses;
    out.rays += r.rays;
    for (std::size_t c = 0; c < kCauses; ++c) out.hits[c] += r.hits[c];
    if (r.hits[static_cast<std::size_t>(Cause::unexplained)] > 0 && out.unexplained_pulse < 0)
      out.unexplained_pulse = r.pulse, out.unexplained_ray = r.unexplained_ray;
    out.ledger_closure = std::max(out.ledger_closure, r.closure);
    if (out.has_scattered) ++out.scattered.pulses, out.scattered.same_draws += !r.parted && r.scattered_same;
    if (r.parted) {
      ++out.parted_pulses;
      continue;
    }
    if (r.edge) {
      ++out.edge_pulses;
      continue;
    }
    ++out.compared_pulses;
    out.beyond_pulses += r.worst > out.limits.bin;
    worst.push_back(r.worst);
    air.push_back(r.air);
    if (!out.has_scattered) out.ledger_difference = std::max(out.ledger_difference, r.ledger);
    if (r.worst >= out.worst) out.worst = r.worst, out.worst_pulse = r.pulse, out.worst_line = r.line, out.worst_bin = r.bin;
    out.air_worst = std::max(out.air_worst, r.air);
  }
  const auto median = [](std::vector<double> values) {
    if (values.empty()) return 0.0;
    std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
    return values[values.size() / 2];
  };
  out.median = median(worst), out.air_median = median(air);
  return out;
}

}  // namespace raycube::reference
