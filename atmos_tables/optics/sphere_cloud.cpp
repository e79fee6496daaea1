#include "atmos_tables/optics/sphere_cloud.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "atmos_tables/optics/mie_angles.h"
#include "host/base/error.h"
#include "host/base/units.h"

namespace raycube::atmos {

namespace {

constexpr double kLargestSize = 5000;
constexpr std::size_t kFirstSizes = 64, kMostSizes = std::size_t{1} << 15;

struct Range {
  double first, last;  ///< ln(r / um)
};

/// The part of the distribution that matters. Below: no more than `part` of r^2 n(r) is left out, where efficiencies
/// are at most twice those of large spheres. Above: no more than `part` of r^2 min(1, x^4) n(r), the shape of
/// scattering (absorption is less steep).
Range range_that_matters(const SizeDistribution& sizes, double wavenumber, double part) {
  const int steps = 4000;
  const double first = sizes.first_log_radius(), step = (sizes.last_log_radius() - first) / steps;
  std::vector<double> area(steps + 1), scattering(steps + 1);
  double area_sum = 0, scattering_sum = 0;
  for (int i = 0; i <= steps; ++i) {
    const double u = first + i * step, x = wavenumber * std::exp(u);
    area[i] = sizes.per_log_radius(u) * std::exp(2 * u);
    scattering[i] = area[i] * std::min(1.0, x * x * x * x);
    area_sum += area[i], scattering_sum += scattering[i];
  }
  Range out{first, sizes.last_log_radius()};
  double below = 0, above = 0;
  for (int i = 0; i <= steps && (below += area[i]) <= part * area_sum; ++i) out.first = first + i * step;
  for (int i = steps; i >= 0 && (above += scattering[i]) <= part * scattering_sum; --i) out.last = first + i * step;
  return out;
}

/// Sums over sizes, in order of accumulation (deterministic); each is an integral over ln r once times the step.
struct Sums {
  double extinction = 0, scattering = 0, asymmetry = 0;  ///< um2, um2, cosine times um2
  std::vector<double> forward, backward;                 ///< intensity at +-nodes
  std::vector<double> forward_angle, backward_angle;     ///< at +-|cosine| of the angles
};

void check(const SphereCloudRequest& request) {
  base::Problems problems;
  const base::Where where{"", 0, 0, "cloud of spheres"};
  if (!(request.wavelength_um >= 0.01 && request.wavelength_um <= 1e5))
    problems.add(where, "the wavelength must lie in 0.01 to 1e5 um", std::to_string(request.wavelength_um),
                 "give it in um");
  if (!(request.tolerance >= 1e-8 && request.tolerance <= 0.1))
    problems.add(where, "the tolerance must lie in 1e-8 to 0.1", std::to_string(request.tolerance), "1e-4 serves most");
  if (request.last_moment > 20000)
    problems.add(where, "at most 20000 moments", std::to_string(request.last_moment), "ask for fewer");
  for (double angle : request.angle_deg)
    if (!(angle >= 0 && angle <= 180))
      problems.add(where, "scattering angles must lie in 0 to 180 deg", std::to_string(angle), "correct the angle");
  problems.throw_if_any();
}

}  // namespace

SphereCloudOptics integrate_spheres(const SizeDistribution& sizes, const SphereCloudRequest& request) {
  check(request);
  const double wavenumber = 2 * base::kPi / request.wavelength_um;  // um-1
  const Range range = range_that_matters(sizes, wavenumber, request.tolerance / 20);
  const double largest = wavenumber * std::exp(range.last);
  if (!(largest <= kLargestSize))
    throw base::Error(base::Fault::input, "cloud of spheres: spheres of size parameter up to " +
                                              std::to_string(largest) +
                                              " matter, the limit is 5000; use a longer wavelength or smaller spheres");
  SphereCloudOptics out;
  out.rule = gauss_legendre_rule(mie_nodes(mie_terms(largest), request.last_moment));
  const std::size_t half = out.rule.node.size() / 2, angles = request.angle_deg.size();
  const std::vector<double> nodes(out.rule.node.begin() + static_cast<std::ptrdiff_t>(half), out.rule.node.end());
  std::vector<double> cosines(angles);
  for (std::size_t i = 0; i < angles; ++i) cosines[i] = std::abs(std::cos(base::rad_by_division(request.angle_deg[i])));

  Sums sums;
  sums.forward.resize(half), sums.backward.resize(half);
  sums.forward_angle.resize(angles), sums.backward_angle.resize(angles);
  const auto add = [&](double log_radius, double weight) {
    const double radius = std::exp(log_radius), number = weight * sizes.per_log_radius(log_radius);
    const MieSphere sphere(std::max(kMinSizeParameter, wavenumber * radius), request.index);
    const MieEfficiencies& q = sphere.efficiencies();
    const double area = number * base::kPi * radius * radius;
    sums.extinction += area * q.extinction, sums.scattering += area * q.scattering;
    sums.asymmetry += area * q.scattering * q.asymmetry;
    add_mie_intensity(sphere, nodes, number, sums.forward, sums.backward);
    add_mie_intensity(sphere, cosines, number, sums.forward_angle, sums.backward_angle);
    ++out.spheres;
  };

  double step = (range.last - range.first) / kFirstSizes;
  for (std::size_t i = 0; i <= kFirstSizes; ++i)
    add(range.first + static_cast<double>(i) * step, i == 0 || i == kFirstSizes ? 0.5 : 1);
  std::vector<double> phase(2 * half);
  for (std::size_t sizes_now = kFirstSizes;; sizes_now *= 2) {
    // Intensity is 4 pi / k^2 per unit of scattering cross-section; the step cancels.
    const double unit = 4 * base::kPi / (wavenumber * wavenumber * sums.scattering);
    for (std::size_t i = 0; i < half; ++i) {
      phase[half + i] = unit * sums.forward[i];
      phase[half - 1 - i] = unit * sums.backward[i];
    }
    const double extinction = step * sums.extinction, scattering = step * sums.scattering;
    const double asymmetry = sums.asymmetry / sums.scattering;
    double change = 1;
    if (sizes_now > kFirstSizes) {
      double phase_change = 0;
      for (std::size_t i = 0; i < 2 * half; ++i)
        phase_change += 0.5 * out.rule.weight[i] * std::abs(phase[i] - out.phase[i]);
      change = std::max({std::abs(extinction / out.extinction_um2 - 1), std::abs(scattering / out.scattering_um2 - 1),
                         std::abs(asymmetry - out.asymmetry), phase_change});
    }
    out.extinction_um2 = extinction, out.scattering_um2 = scattering, out.asymmetry = asymmetry;
    out.phase = phase, out.change = change;
    if (change <= request.tolerance) break;
    if (sizes_now >= kMostSizes)
      throw base::Error(base::Fault::input, "cloud of spheres: " + std::to_string(out.spheres) +
                                                " sizes leave a change of " + std::to_string(change) +
                                                "; ask for a larger tolerance");
    for (std::size_t i = 0; i < sizes_now; ++i) add(range.first + (static_cast<double>(i) + 0.5) * step, 1);
    step /= 2;
  }
  out.single_scattering_albedo = out.scattering_um2 / out.extinction_um2;
  out.moments = legendre_moments(out.rule, out.phase, request.last_moment);
  const double unit = 4 * base::kPi / (wavenumber * wavenumber * sums.scattering);
  for (std::size_t i = 0; i < angles; ++i)
    out.phase_at_angle.push_back(unit * (request.angle_deg[i] <= 90 ? sums.forward_angle[i] : sums.backward_angle[i]));
  return out;
}

}  // namespace raycube::atmos
