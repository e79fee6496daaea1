#include "host/lidar/apply_turbulence.h"

#include <algorithm>
#include <cmath>

#include "host/base/units.h"
#include "host/lidar/pulse_taps.h"
#include "host/lidar/scintillation.h"
#include "host/lidar/turbulence.h"

namespace raycube::lidar {

namespace {

Vec3 over_length(const Vec3& a) {
  const double size = length(a);
  return {a[0] / size, a[1] / size, a[2] / size};
}

/// Tips an axis by small angles towards u and v = axis x u; u stays perpendicular to it.
void tip(Vec3& axis, Vec3& u, const std::array<double, 2>& angle_rad) {
  const Vec3 v = cross(axis, u);
  Vec3 tipped;
  for (std::size_t i = 0; i < 3; ++i)
    tipped[i] = axis[i] + std::tan(angle_rad[0]) * u[i] + std::tan(angle_rad[1]) * v[i];
  axis = over_length(tipped);
  const double along = dot(u, axis);
  for (std::size_t i = 0; i < 3; ++i) u[i] -= along * axis[i];
  u = over_length(u);
}

/// Over uneven ground a piece of a path is at most this long on the map; its 24 nodes then lie some 10 m
/// apart.
constexpr double kPiece_m = 200;
constexpr int kMostPieces = 64;

TurbulentPath path_of(const scene::Lidar& lidar, const ShotSurroundings& around, const Shot& shot) {
  const Vec3 &exit = shot.exit_m, &axis = shot.exit_axis;
  const double height = exit[2] - around.ground_at(exit[0], exit[1]);
  double length = 0.5 * base::kLightSpeed_m_s * (lidar.gate.start_s + lidar.gate.bins * lidar.gate.bin_s) /
                  lidar.transport.group_index;
  if (around.surface_range_m > 0)
    length = std::min(length, around.surface_range_m);
  else if (axis[2] < 0 && height > 0)
    length = std::min(length, -height / axis[2]);
  if (!around.ground_z_m) return {length, height, height + axis[2] * length};
  // `around` outlives the path.
  const auto height_m = [&ground = around.ground_z_m, exit, axis](double z) {
    return exit[2] + axis[2] * z - ground(exit[0] + axis[0] * z, exit[1] + axis[1] * z);
  };
  const double across_m = std::hypot(axis[0], axis[1]) * length;
  return {length, height, height_m(length), height_m,
          std::clamp(static_cast<int>(std::ceil(across_m / kPiece_m)), 1, kMostPieces)};
}

/// Radius of the beam at a range without turbulence, 1/e2 or edge.
double beam_radius_m(const scene::LidarPulse& pulse, double half_divergence_rad, double range_m) {
  const double grown = std::tan(half_divergence_rad) * range_m;
  return pulse.profile == scene::BeamProfile::gaussian ? std::hypot(pulse.exit_radius_m, grown)
                                                       : pulse.exit_radius_m + grown;
}

/// Half divergence that makes the beam so wide at a range.
double divergence_for(const scene::LidarPulse& pulse, double radius_m, double range_m) {
  const double grown = pulse.profile == scene::BeamProfile::gaussian
                           ? std::sqrt(std::max(0.0, radius_m * radius_m - pulse.exit_radius_m * pulse.exit_radius_m))
                           : radius_m - pulse.exit_radius_m;
  return std::atan(std::max(0.0, grown) / range_m);
}

/// Whether the air has changed from one line of a shot to the next; without wind it stands still.
bool draws_apart(const scene::Lidar& lidar, const TurbulenceTruth& truth) {
  return truth.correlation_s > 0 && lidar.pulse.separation_s > truth.correlation_s;
}

void warn_where_stretched(const scene::Lidar& lidar, const TurbulentPath& path, TurbulenceTruth& truth) {
  const auto warn = [&](bool when, const char* text) {
    if (when) truth.warnings.emplace_back(text);
  };
  warn(truth.rytov_plane > 25, "turbulence: Rytov variance above 25, gamma-gamma is extrapolated");
  warn(truth.rytov_plane > 1, "turbulence: Rytov variance above 1, aperture averaging is that of weak turbulence");
  warn(path.length_m > 10e3 && std::min(path.start_height_m, path.end_height_m) < 100 &&
           std::max(path.start_height_m, path.end_height_m) < 1000,
       "turbulence: more than 10 km of path near the ground");
  warn(truth.spread_clamped,
       "turbulence: the beam is much narrower than the coherence length, so wander takes all its spread; the "
       "short-term spot keeps the beam's own width");
  const auto& lines = lidar.pulse.lines;
  warn(lines.size() > 1 && draws_apart(lidar, truth) && (lidar.turbulence.wander || lidar.turbulence.blur),
       "turbulence: lines of a shot are further apart than the correlation time: they scintillate apart but share "
       "wander and tilt");
  warn(std::any_of(
           lines.begin(), lines.end(),
           [&](const auto& line) { return std::abs(line.wavelength_um / lines.front().wavelength_um - 1) > 0.05; }),
       "turbulence: wavelengths of a shot differ by more than 5 %: spread and blur are the first line's, scintillation "
       "each line's own");
}

/// Of one wavelength, over a footprint and an aperture of these diameters.
LineScintillation scintillation_of(const PathNodes& nodes, double wavelength_m, double footprint_m, double aperture_m) {
  LineScintillation out;
  out.rytov_plane = rytov_plane(nodes, wavelength_m), out.rytov_spherical = rytov_spherical(nodes, wavelength_m);
  out.gamma_gamma = out.rytov_plane >= kGammaGammaFrom;
  const double point =
      gamma_gamma_spherical(out.rytov_spherical).scintillation_index();  // the variance itself where it is small
  const auto averaged = [&](double width_m) {
    return point * aperture_averaging_spherical(2 * M_PI / wavelength_m * width_m * width_m / (4 * nodes.length_m));
  };
  out.index_down = averaged(footprint_m), out.index_up = averaged(aperture_m);
  return out;
}

double draw_gain(Stream draws, const LineScintillation& line) {
  const GammaGamma shape = gamma_gamma_spherical(line.rytov_spherical);
  double gain = 1;
  for (const double index : {line.index_down, line.index_up}) {
    const GammaGamma averaged = with_index(shape, index);
    gain *= draw_irradiance(draws, index, line.gamma_gamma ? &averaged : nullptr);
  }
  return gain;
}

}  // namespace

TurbulenceTruth turbulence_statistics(const LidarPlan& plan, const ShotSurroundings& around, const Shot& shot) {
  const scene::Lidar& lidar = plan.lidar;
  const scene::LidarTurbulence& turbulence = lidar.turbulence;
  TurbulenceTruth truth;
  if (turbulence.profile == scene::TurbulenceProfile::none) return truth;
  const TurbulentPath path = path_of(lidar, around, shot);
  const PathNodes nodes = path_nodes(turbulence, path);
  const double wavelength_m = lidar.pulse.lines.front().wavelength_um * 1e-6, length = path.length_m;
  truth.path_m = length, truth.start_height_m = path.start_height_m, truth.end_height_m = path.end_height_m;
  truth.rytov_plane = rytov_plane(nodes, wavelength_m), truth.rytov_spherical = rytov_spherical(nodes, wavelength_m);
  truth.beam_radius_m = truth.long_term_m = truth.short_term_m =
      beam_radius_m(lidar.pulse, shot.half_divergence_rad, length);
  if (!(truth.rytov_plane > 0)) return truth;  // no turbulence on the way
  truth.fried_m = fried_at_start_m(nodes, wavelength_m), truth.fried_plane_m = fried_plane_m(nodes, wavelength_m);
  truth.isoplanatic_rad = isoplanatic_angle_rad(nodes, wavelength_m);
  truth.long_term_m = long_term_radius_m(nodes, wavelength_m, truth.beam_radius_m);
  // A beam from a point is no narrower than diffraction lets it.
  const double exit_m = lidar.pulse.exit_radius_m > 0  ? lidar.pulse.exit_radius_m
                        : shot.half_divergence_rad > 0 ? wavelength_m / (M_PI * std::tan(shot.half_divergence_rad))
                                                       : 0;
  truth.wander_sigma_m = wander_sigma_m(nodes, exit_m, shot.half_divergence_rad, turbulence.andrews_wander);
  const ShortTerm short_term = short_term_radius(truth.long_term_m, truth.wander_sigma_m, truth.beam_radius_m);
  truth.short_term_m = short_term.radius_m, truth.spread_clamped = short_term.clamped;
  const double diameter = 2 * lidar.receiver.aperture_radius_m;
  truth.tilt_sigma_rad = diameter > 0 ? image_tilt_rad(wavelength_m, truth.fried_m, diameter) : 0;
  truth.blur_fwhm_rad = 0.98 * wavelength_m / truth.fried_m;
  for (const auto& line : lidar.pulse.lines)
    truth.lines.push_back(scintillation_of(nodes, line.wavelength_um * 1e-6, 2 * truth.short_term_m, diameter));
  const LineScintillation& first = truth.lines.front();
  truth.gamma_gamma = first.gamma_gamma, truth.index_down = first.index_down, truth.index_up = first.index_up;
  truth.index_total = (1 + truth.index_down) * (1 + truth.index_up) - 1;
  truth.broadening_s2 = broadening_s2(nodes, turbulence.outer_scale_m);
  truth.correlation_s = turbulence.wind_m_s > 0 ? std::max(truth.short_term_m, truth.fried_m) / turbulence.wind_m_s : 0;
  warn_where_stretched(lidar, path, truth);
  return truth;
}

TurbulenceTruth apply_turbulence(const LidarPlan& plan, const ShotSurroundings& around, Shot& shot) {
  TurbulenceTruth truth = turbulence_statistics(plan, around, shot);
  if (!(truth.rytov_plane > 0)) return truth;
  const scene::LidarTurbulence& turbulence = plan.lidar.turbulence;
  const std::uint32_t key = static_cast<std::uint32_t>(shot.pulse),
                      high = static_cast<std::uint32_t>(static_cast<std::uint64_t>(shot.pulse) >> 32);
  const auto stream = [&](DrawFor purpose) { return Stream(plan.seed, key, high, purpose); };
  if (turbulence.spread)
    shot.half_divergence_rad =
        divergence_for(plan.lidar.pulse, turbulence.wander ? truth.short_term_m : truth.long_term_m, truth.path_m);
  if (turbulence.wander) {
    Stream draws = stream(DrawFor::wander);
    for (double& angle : truth.wander_rad) angle = truth.wander_sigma_m / truth.path_m * draws.normal();
    tip(shot.exit_axis, shot.exit_u, truth.wander_rad);
  }
  if (turbulence.blur) {
    Stream draws = stream(DrawFor::tilt);
    for (double& angle : truth.tilt_rad) angle = truth.tilt_sigma_rad * draws.normal();
    tip(shot.pupil_axis, shot.pupil_u, truth.tilt_rad);
  }
  if (turbulence.scintillation) {
    const bool apart = draws_apart(plan.lidar, truth);
    std::vector<double> gains;
    for (std::size_t line = 0; line < truth.lines.size(); ++line)
      gains.push_back(draw_gain(
          Stream(plan.seed, key, high, DrawFor::scintillation, apart ? static_cast<int>(line) : 0), truth.lines[line]));
    truth.gain = gains.front();
    if (gains.size() == 1)
      shot.gain *= truth.gain;
    else
      shot.line_gain = std::move(gains);
  }
  return truth;
}

void apply_line_gain(const LidarPlan& plan, ShotResult& result) {
  const std::vector<double>& gain = result.shot.line_gain;
  if (gain.empty()) return;
  const auto bins = static_cast<std::size_t>(plan.lidar.gate.bins);
  for (std::vector<float>* rows : {&result.first, &result.multiple, &result.air, &result.particles})
    for (std::size_t i = 0; i < rows->size(); ++i)
      (*rows)[i] = static_cast<float>((*rows)[i] * gain[i / bins % gain.size()]);
  for (std::size_t line = 0; line < result.ledger.size(); ++line) {
    Ledger& ledger = result.ledger[line];
    for (double* part : {&ledger.collected, &ledger.early, &ledger.late, &ledger.near}) *part *= gain[line];
  }
}

bool broaden_pulse(LidarPlan& plan, double broadening_s2) {
  scene::LidarPulse& pulse = plan.lidar.pulse;
  if (!plan.lidar.turbulence.broadening || pulse.shape != scene::PulseShape::gaussian || !(pulse.fwhm_s > 0))
    return false;
  const double fwhm_s = broadened_fwhm_s(pulse.fwhm_s, broadening_s2);
  if (!(fwhm_s > pulse.fwhm_s * (1 + 1e-6))) return false;
  pulse.fwhm_s = fwhm_s;
  plan.taps = make_taps(pulse, plan.lidar.gate.bin_s);
  return true;
}

}  // namespace raycube::lidar
