#include "host/lidar/overlap.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "host/lidar/bessel.h"
#include "host/lidar/quadrature.h"

namespace raycube::lidar {

namespace {

/// Twice the area of a segment of half angle `angle` in a unit circle: 2 angle - sin(2 angle), without cancellation at
/// small angles.
double twice_segment(double angle) {
  const double x = 2 * angle;
  if (x > 0.5) return x - std::sin(x);
  const double q = x * x;  // x^3/3! - x^5/5! + ...: seven terms leave 1e-17 of the first at x = 0.5
  double sum = 0;
  for (const double n : {17.0, 15.0, 13.0, 11.0, 9.0, 7.0, 5.0, 3.0}) sum = (1 - sum) * q / (n * (n - 1));
  return sum * x;
}

/// Density of the distance rho from the receiver's axis to a point of the beam, 1/m.
double distance_density(bool gaussian, double beam_m, double offset_m, double rho_m) {
  if (gaussian) {
    const double t = (rho_m - offset_m) / beam_m;  // Rice distribution, 1/e2 radius = 2 sigma
    return 4 * rho_m / (beam_m * beam_m) * scaled_bessel_i0(4 * rho_m * offset_m / (beam_m * beam_m)) *
           std::exp(-2 * t * t);
  }
  if (rho_m + offset_m <= beam_m) return 2 * rho_m / (beam_m * beam_m);
  // Half angle of the arc of radius rho inside the disc, about the disc's direction.
  const double across = (rho_m + offset_m + beam_m) * (rho_m + offset_m - beam_m) * (rho_m + beam_m - offset_m) *
                        (beam_m + offset_m - rho_m);
  const double along = rho_m * rho_m + offset_m * offset_m - beam_m * beam_m;
  return 2 * rho_m * std::atan2(std::sqrt(std::max(0.0, across)), along) / (M_PI * beam_m * beam_m);
}

/// Mean over the beam of a function of the distance to the receiver's axis that is 0 beyond `end_m` and smooth between
/// `breaks_m`.
template <class F>
double beam_mean(bool gaussian, double beam_m, double offset_m, double end_m, std::vector<double> breaks_m,
                 F&& weight) {
  if (beam_m <= 0) return weight(offset_m);
  double lo = 0, hi = end_m;
  if (gaussian) {
    // Parts of half a beam radius, from the point nearest to the beam's centre outwards, until what is left cannot be
    // seen.
    const double nearest = std::min(offset_m, end_m);
    lo = std::max(0.0, nearest - 8 * beam_m), hi = std::min(end_m, nearest + 8 * beam_m);
    const int parts = static_cast<int>(std::ceil(2 * (hi - lo) / beam_m));
    for (int i = 1; i < parts; ++i) breaks_m.push_back(lo + (hi - lo) * i / parts);
    // Far in a tail the density falls within beam^2 / (4 distance): a few parts more where it begins.
    const double reach = beam_m * beam_m / (4 * std::max(beam_m, offset_m - end_m));
    for (double step = reach; step < 0.5 * beam_m; step *= 4) breaks_m.push_back(hi - step);
  } else {
    lo = std::max(0.0, offset_m - beam_m), hi = std::min(end_m, offset_m + beam_m);
    breaks_m.push_back(std::abs(offset_m - beam_m));
  }
  if (!(lo < hi)) return 0;
  breaks_m.push_back(lo), breaks_m.push_back(hi);
  std::sort(breaks_m.begin(), breaks_m.end());
  double sum = 0;
  for (std::size_t i = 1; i < breaks_m.size(); ++i) {
    const double a = std::max(lo, breaks_m[i - 1]), b = std::min(hi, breaks_m[i]);
    if (a < b)
      sum += integrate_branch_ends(
          [&](double rho) { return weight(rho) * distance_density(gaussian, beam_m, offset_m, rho); }, a, b);
  }
  return std::clamp(sum, 0.0, 1.0);
}

}  // namespace

double circle_overlap(double a, double b, double d) {
  if (!(a > 0) || !(b > 0) || d >= a + b) return 0;
  const double small = std::min(a, b);
  if (d <= std::abs(a - b)) return M_PI * small * small;
  // Half angles of the two segments by tangents: defined everywhere, where acos fails just above d = |a - b|.
  const auto side = [](double x) {
    return std::sqrt(std::max(0.0, x));
  };  // one by one: their product underflows at d near 0
  const double root = side((a + b - d) * (d + a + b)) * side(d + (a - b)) * side(d - (a - b));
  const double at_a = std::atan2(root, (d - b) * (d + b) + a * a), at_b = std::atan2(root, (d - a) * (d + a) + b * b);
  return std::clamp(0.5 * (a * a * twice_segment(at_a) + b * b * twice_segment(at_b)), 0.0, M_PI * small * small);
}

double vignetting(const Stop& stop, double range_m, double offset_m) {
  // Angles of section 4.3 times the range, so that range 0 is no special case.
  const double field = stop.half_fov_rad * std::max(0.0, range_m);
  const double defocus = stop.focus_m > 0 ? std::abs(1 - range_m / stop.focus_m) : 1;
  const double outer = stop.pupil_m * defocus, inner = std::min(stop.obscuration_m, stop.pupil_m) * defocus;
  const double clear = M_PI * (outer - inner) * (outer + inner);
  if (!(range_m > 0)) return 0;
  if (!(outer > 1e-9 * field) || !(clear > 0)) return offset_m < field ? 1 : 0;
  return std::clamp((circle_overlap(field, outer, offset_m) - circle_overlap(field, inner, offset_m)) / clear, 0.0,
                    1.0);
}

double beam_overlap(const Stop& stop, bool gaussian, double beam_radius_m, double range_m, double offset_m) {
  if (!(range_m > 0)) return 0;
  const double field = stop.half_fov_rad * range_m;
  const double defocus = stop.focus_m > 0 ? std::abs(1 - range_m / stop.focus_m) : 1;
  const double outer = stop.pupil_m * defocus, inner = stop.obscuration_m * defocus;
  const double end = outer > 1e-9 * field ? field + outer : field;
  return beam_mean(gaussian, beam_radius_m, offset_m, end,
                   {std::abs(field - outer), std::abs(field - inner), field + inner},
                   [&](double rho) { return vignetting(stop, range_m, rho); });
}

double gaussian_circle_overlap(double beam_radius_m, double circle_m, double offset_m) {
  return beam_mean(true, beam_radius_m, offset_m, circle_m, {}, [&](double rho) { return rho < circle_m ? 1.0 : 0.0; });
}

double uniform_circle_overlap(double beam_radius_m, double circle_m, double offset_m) {
  if (beam_radius_m <= 0) return offset_m < circle_m ? 1 : 0;
  return circle_overlap(circle_m, beam_radius_m, offset_m) / (M_PI * beam_radius_m * beam_radius_m);
}

}  // namespace raycube::lidar
