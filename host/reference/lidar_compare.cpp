#include "host/reference/lidar_compare.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "host/base/units.h"
#include "host/base/parallel.h"

namespace raycube::reference {

struct LidarComparison::Result {
  std::int64_t pulse = 0;
  std::uint64_t rays = 0;
  std::array<std::uint64_t, kCauses> hits{};
  bool parted = false, edge = false, rounded = false, has_air = false;
  std::uint32_t unexplained_ray = 0;
  double worst = 0, air = 0, air_end = 0, float_path_m = 0;
  int line = 0, bin = 0;
  bool scattered_same = true;
  double closure = 0, ledger = 0;
  std::vector<std::vector<double>> scattered;  ///< [device, replica ...][line * bins]
};

namespace {

/// Rays of an array that air and volumes are integrated along: 1e4 steps each.
constexpr int kAirRays = 256;
/// A bin with so much of a pulse's peak from surfaces holds an echo.
constexpr double kEcho = 1e-9;
/// Roundings of floats in a path, each relative to the way from the scene's edge to the surface: the vertex, the ways
/// to both ends, and twice that their sum and its bins.
constexpr double kRoundings = 6;
double float_path_m(const LidarReference& reference) { return kRoundings * kUlp * reference.deepest_m; }

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

double at(const std::vector<double>& row, std::size_t i) { return row.empty() ? 0 : row[i]; }
double at(const std::vector<float>& row, std::size_t i) { return row.empty() ? 0 : static_cast<double>(row[i]); }

double difference(const lidar::Ledger& a, const lidar::Ledger& b) {
  return std::max({std::abs(a.absorbed - b.absorbed), std::abs(a.air - b.air), std::abs(a.volumes - b.volumes),
                   std::abs(a.escaped - b.escaped), std::abs(a.truncated - b.truncated)});
}

/// Sum of rows over pixels: [line * bins].
template <typename Number>
std::vector<double> over_pixels(const std::vector<Number>& rows, std::size_t width) {
  std::vector<double> out(width, 0.0);
  for (std::size_t i = 0; i < rows.size(); ++i) out[i % width] += static_cast<double>(rows[i]);
  return out;
}

}  // namespace

LidarComparison::LidarComparison(const scene::CompiledScene& scene, const lidar::LidarPlan& plan,
                                 const LidarCompareOptions& options)
    : scene_(scene), plan_(plan), options_(options), embree_(scene), judge_(scene) {}
LidarComparison::~LidarComparison() = default;

LidarComparison::Result LidarComparison::compare(const lidar::ShotResult& device) const {
  Result result;
  result.pulse = device.shot.pulse;
  const std::vector<LidarRay> rays = lidar_rays(plan_, device.shot);
  LidarShotOptions options;
  if (plan_.lidar.transport.sampling == scene::LidarSampling::receiver)
    options.air_pixel_step = std::max(1, static_cast<int>(rays.size()) / kAirRays);
  const LidarReference reference = reference_shot(scene_, embree_, plan_, device.shot, options);
  result.rays = rays.size();
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const Hit hit = i < device.hits.size() ? Hit{device.hits[i].instance, device.hits[i].primitive} : Hit{};
    const Cause cause =
        hit == reference.hits[i] ? Cause::agree : judge_.explain(judged(scene_, rays[i]), hit, reference.hits[i]);
    if (cause == Cause::unexplained && result.hits[static_cast<std::size_t>(cause)] == 0)
      result.unexplained_ray = static_cast<std::uint32_t>(i);
    ++result.hits[static_cast<std::size_t>(cause)];
    result.parted |= cause != Cause::agree;
  }
  const auto bins = static_cast<std::size_t>(plan_.lidar.gate.bins), lines = static_cast<std::size_t>(plan_.lines());
  const auto pixels = static_cast<std::size_t>(plan_.pixels());
  const LidarRows& rows = reference.rows;
  for (std::size_t line = 0; line < lines; ++line) {
    result.closure = std::max(result.closure, std::abs(device.ledger[line].emitted_error()));
    result.ledger = std::max(result.ledger, difference(device.ledger[line], reference.ledger[line]));
    double peak = 0, air_peak = 0, particle_peak = 0;
    for (std::size_t pixel = 0; pixel < pixels; ++pixel)
      for (std::size_t i = (pixel * lines + line) * bins, end = i + bins; i < end; ++i) {
        peak = std::max(peak, rows.first[i] + at(rows.multiple, i));
        air_peak = std::max(air_peak, at(rows.air, i));
        particle_peak = std::max(particle_peak, at(rows.particles, i));
      }
    result.has_air |= particle_peak > 0 || (!device.air.empty() && air_peak > 0);
    for (std::size_t pixel = 0; pixel < pixels; ++pixel) {
      const bool with_air = pixel % static_cast<std::size_t>(options.air_pixel_step) == 0;
      for (std::size_t bin = 0; bin < bins; ++bin) {
        const std::size_t i = (pixel * lines + line) * bins + bin;
        // Where a surface's echo is, the air ends.
        double& worst_air = rows.first[i] > kEcho * peak ? result.air_end : result.air;
        if (with_air && !device.air.empty() && air_peak > 0)
          worst_air = std::max(worst_air, std::abs(at(device.air, i) - at(rows.air, i)) / air_peak);
        if (!rows.particles.empty() && !with_air) continue;
        double off = std::abs(at(device.first, i) - rows.first[i] - at(rows.particles, i));
        // Particles share the surfaces' row on the device; a bin that holds some is judged by their limit.
        if (at(rows.particles, i) > options_.limits.bin * peak) {
          worst_air = std::max(worst_air, off / particle_peak);
          continue;
        }
        // A bin of less than 1e-9 photons in a pulse without an echo has no peak to be measured by.
        off /= std::max(peak, 1e-9);
        if (off > result.worst)
          result.worst = off, result.line = static_cast<int>(line), result.bin = static_cast<int>(bin);
        result.scattered_same &= device.multiple.empty() || std::abs(at(device.multiple, i) - at(rows.multiple, i)) <=
                                                                options_.limits.bin * std::max(peak, 1e-9);
      }
    }
  }
  if (!result.parted && result.worst > options_.limits.bin) {
    result.float_path_m = float_path_m(reference);
    result.rounded = within_rounding(device, reference);
    if (!result.rounded) {
      options.count_uncertain = true;
      options.air_pixel_step = plan_.pixels();
      result.edge = reference_shot(scene_, embree_, plan_, device.shot, options).uncertain > 0;
    }
  }
  if (!device.multiple.empty()) {
    result.scattered.push_back(over_pixels(device.multiple, lines * bins));
    for (int replica = 0; replica < options_.replicas; ++replica) {
      LidarShotOptions own;
      own.own_seed = true;
      own.seed = plan_.seed + 0x9E3779B9u * static_cast<std::uint64_t>(replica + 1);
      own.scattered_only = true;
      result.scattered.push_back(
          over_pixels(reference_shot(scene_, embree_, plan_, device.shot, own).rows.multiple, lines * bins));
    }
  }
  return result;
}

/// Every bin is within the limit and what the rounding of paths in floats may change: the pulse's slope is the
/// reference's own.
bool LidarComparison::within_rounding(const lidar::ShotResult& device, const LidarReference& reference) const {
  const LidarRows& rows = reference.rows;
  LidarShotOptions options;
  options.slope_s = 1e-3 * plan_.lidar.gate.bin_s;
  options.air_pixel_step = plan_.pixels();
  const double shifts =
      float_path_m(reference) * plan_.lidar.transport.group_index / base::kLightSpeed_m_s / options.slope_s;
  const LidarRows changes = reference_shot(scene_, embree_, plan_, device.shot, options).rows;
  const auto bins = static_cast<std::size_t>(plan_.lidar.gate.bins), lines = static_cast<std::size_t>(plan_.lines());
  std::vector<double> peak(lines, 0.0);
  for (std::size_t i = 0; i < rows.first.size(); ++i)
    peak[i / bins % lines] = std::max(peak[i / bins % lines], rows.first[i] + at(rows.multiple, i));
  for (std::size_t i = 0; i < rows.first.size(); ++i) {
    if (at(rows.particles, i) > 0) continue;
    if (std::abs(at(device.first, i) - rows.first[i]) >
        options_.limits.bin * peak[i / bins % lines] + shifts * changes.first[i])
      return false;
  }
  return true;
}

void LidarComparison::add(const std::vector<lidar::ShotResult>& shots) {
  std::vector<Result> fresh(shots.size());
  base::for_each_index(shots.size(), options_.threads, [&](std::size_t i) { fresh[i] = compare(shots[i]); });
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

double footprint_noise(const lidar::LidarPlan& plan) {
  const scene::LidarTransport& transport = plan.lidar.transport;
  const bool edges = transport.sampling == scene::LidarSampling::transmitter &&
                     (plan.pixels() > 1 || transport.overlap == scene::LidarOverlap::exact);
  return edges ? 4 * 0.0151 * std::pow(64.0 / static_cast<double>(plan.footprint.a.size()), 0.79) : 0;
}

LidarReport LidarComparison::report() const {
  LidarReport out;
  out.limits = options_.limits;
  out.limits.air += footprint_noise(plan_), out.limits.air_end += footprint_noise(plan_);
  out.has_scattered = !scattered_.empty();
  std::vector<double> worst, air;
  out.scattered = compare_scattered(scattered_, plan_.lidar);
  for (const Result& r : results_) {
    ++out.pulses;
    out.has_air |= r.has_air;
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
    out.rounded_pulses += r.rounded;
    if (r.rounded)
      out.rounded_worst = std::max(out.rounded_worst, r.worst),
      out.float_path_m = std::max(out.float_path_m, r.float_path_m);
    if (r.edge) {
      ++out.edge_pulses;
      continue;
    }
    ++out.compared_pulses;
    out.beyond_pulses += r.worst > out.limits.bin && !r.rounded;
    worst.push_back(r.worst);
    air.push_back(r.air);
    if (!out.has_scattered) out.ledger_difference = std::max(out.ledger_difference, r.ledger);
    if (r.worst >= out.worst)
      out.worst = r.worst, out.worst_pulse = r.pulse, out.worst_line = r.line, out.worst_bin = r.bin;
    out.air_worst = std::max(out.air_worst, r.air), out.air_end_worst = std::max(out.air_end_worst, r.air_end);
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
