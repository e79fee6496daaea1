#include "host/lidar/turbulence.h"

#include <algorithm>
#include <cmath>

#include "host/base/units.h"
#include "host/lidar/quadrature.h"

namespace raycube::lidar {

namespace {

double wave_number(double wavelength_m) { return 2 * M_PI / wavelength_m; }

template <class Weight>
double path_integral(const PathNodes& path, Weight&& weight) {
  double sum = 0;
  for (std::size_t i = 0; i < path.z_m.size(); ++i) sum += path.cn2_dz[i] * weight(path.z_m[i]);
  return sum;
}

double fried_m(double wavelength_m, double integral) {
  return std::pow(0.423 * std::pow(wave_number(wavelength_m), 2) * integral, -0.6);
}

double five_thirds(double x) { return std::pow(std::max(0.0, x), 5.0 / 3); }
double five_sixths(double x) { return std::pow(std::max(0.0, x), 5.0 / 6); }

double tilt_rad(double coefficient, double wavelength_m, double fried_m, double diameter_m) {
  return std::sqrt(coefficient) * wavelength_m / diameter_m * std::pow(diameter_m / fried_m, 5.0 / 6);
}

}  // namespace

double cn2_at(const scene::LidarTurbulence& turbulence, double height_m) {
  if (turbulence.profile == scene::TurbulenceProfile::none) return 0;
  if (turbulence.profile == scene::TurbulenceProfile::constant) return turbulence.cn2;
  const double h = std::max(0.0, height_m), v = turbulence.wind_m_s / 27;
  return 0.00594 * v * v * std::pow(1e-5 * h, 10) * std::exp(-h / 1000) + 2.7e-16 * std::exp(-h / 1500) +
         turbulence.ground_cn2 * std::exp(-h / 100);
}

PathNodes path_nodes(const scene::LidarTurbulence& turbulence, const TurbulentPath& path) {
  static const atmos::GaussRule rule = atmos::gauss_legendre_rule(24);
  PathNodes nodes{path.length_m, {}, {}};
  std::vector<double> breaks{0, path.length_m};
  const double climb = path.end_height_m - path.start_height_m;
  if (turbulence.profile == scene::TurbulenceProfile::hufnagel_valley && climb != 0)
    for (const double height : {0.0, 60.0, 150.0, 300.0, 600.0, 1200.0, 2500.0, 5000.0, 7500.0, 10000.0, 13000.0,
                                17000.0, 25000.0, 40000.0, 70000.0}) {
      const double z = (height - path.start_height_m) / climb * path.length_m;
      if (z > 0 && z < path.length_m) breaks.push_back(z);
    }
  for (int piece = 1; piece < path.pieces; ++piece) breaks.push_back(path.length_m * piece / path.pieces);
  std::sort(breaks.begin(), breaks.end());
  for (std::size_t piece = 1; piece < breaks.size(); ++piece) {
    const double middle = 0.5 * (breaks[piece] + breaks[piece - 1]), half = 0.5 * (breaks[piece] - breaks[piece - 1]);
    for (std::size_t i = 0; i < rule.node.size(); ++i) {
      const double t = 0.5 * M_PI * rule.node[i],
                   z = middle + half * std::sin(t);  // ends are branch points, see integrate_branch_ends
      const double height_m = path.height_m ? path.height_m(z) : path.start_height_m + climb * z / path.length_m;
      nodes.z_m.push_back(z);
      nodes.cn2_dz.push_back(rule.weight[i] * half * 0.5 * M_PI * std::cos(t) * cn2_at(turbulence, height_m));
    }
  }
  return nodes;
}

double fried_plane_m(const PathNodes& path, double wavelength_m) {
  return fried_m(wavelength_m, path_integral(path, [](double) { return 1.0; }));
}

double fried_at_start_m(const PathNodes& path, double wavelength_m) {
  return fried_m(wavelength_m, path_integral(path, [&](double z) { return five_thirds(1 - z / path.length_m); }));
}

double fried_at_end_m(const PathNodes& path, double wavelength_m) {
  return fried_m(wavelength_m, path_integral(path, [&](double z) { return five_thirds(z / path.length_m); }));
}

double isoplanatic_angle_rad(const PathNodes& path, double wavelength_m) {
  return std::pow(
      2.914 * std::pow(wave_number(wavelength_m), 2) * path_integral(path, [](double z) { return five_thirds(z); }),
      -0.6);
}

double rytov_plane(const PathNodes& path, double wavelength_m) {
  return 2.25 * std::pow(wave_number(wavelength_m), 7.0 / 6) *
         path_integral(path, [&](double z) { return five_sixths(path.length_m - z); });
}

double rytov_spherical(const PathNodes& path, double wavelength_m) {
  return 2.25 * std::pow(wave_number(wavelength_m), 7.0 / 6) *
         path_integral(path, [&](double z) { return five_sixths(z * (path.length_m - z) / path.length_m); });
}

double long_term_radius_m(const PathNodes& path, double wavelength_m, double beam_radius_m) {
  const double integral = path_integral(path, [&](double z) { return five_thirds(1 - z / path.length_m); });
  const double k = wave_number(wavelength_m), rho0 = std::pow(1.46 * k * k * integral, -0.6);
  return std::hypot(beam_radius_m, std::sqrt(8.0) * path.length_m / (k * rho0));
}

double wander_sigma_m(const PathNodes& path, double exit_radius_m, double half_divergence_rad, bool andrews) {
  const double slope = std::tan(half_divergence_rad);
  if (!(exit_radius_m > 0) && !(slope > 0)) return 0;
  return std::sqrt((andrews ? 3.63 : 2.284) * path_integral(path, [&](double z) {
                     const double left = path.length_m - z;
                     return left * left * std::pow(std::hypot(exit_radius_m, slope * z), -1.0 / 3);
                   }));
}

ShortTerm short_term_radius(double long_term_m, double wander_m, double beam_radius_m) {
  const double square = long_term_m * long_term_m - 4 * wander_m * wander_m;
  if (square < beam_radius_m * beam_radius_m) return {beam_radius_m, true};
  return {std::sqrt(square), false};
}

double long_exposure_mtf(double cycles_per_rad, double wavelength_m, double fried_m) {
  return std::exp(-3.44 * five_thirds(wavelength_m * cycles_per_rad / fried_m));
}

double short_exposure_mtf(double cycles_per_rad, double wavelength_m, double fried_m, double diameter_m) {
  const double x = std::min(1.0, wavelength_m * cycles_per_rad / diameter_m);
  return std::exp(-3.44 * five_thirds(wavelength_m * cycles_per_rad / fried_m) * (1 - std::cbrt(x)));
}

double image_tilt_rad(double wavelength_m, double fried_m, double diameter_m) {
  return tilt_rad(0.170, wavelength_m, fried_m, diameter_m);
}

double wave_tilt_rad(double wavelength_m, double fried_m, double diameter_m) {
  return tilt_rad(0.182, wavelength_m, fried_m, diameter_m);
}

double broadening_s2(const PathNodes& path, double outer_scale_m) {
  return 8 * 0.391 * path_integral(path, [](double) { return 1.0; }) * five_thirds(outer_scale_m) /
         (base::kLightSpeed_m_s * base::kLightSpeed_m_s);
}

double broadened_fwhm_s(double fwhm_s, double broadening_s2) {
  // exp(-2 t^2 / T^2) of power: full width at half maximum T sqrt(2 ln 2).
  return std::sqrt(fwhm_s * fwhm_s + 2 * M_LN2 * broadening_s2);
}

}  // namespace raycube::lidar
