#include "host/plan/sky_rays.h"

#include <cmath>
#include <limits>
#include <vector>

#include "host/base/units.h"
#include "host/plan/sky_basis.h"

namespace raycube::plan {

namespace {

constexpr double kCosineShares[] = {1.0, 0.7, 0.5, kLeastCosineShare};
constexpr double kSunShares[] = {0.0, 0.25, 0.5, 0.75};
constexpr double kAsymmetries[] = {0.5, 0.7, 0.85};
constexpr double kTilts_deg[] = {0, 30, 60, 90, 120};
constexpr double kTurns_deg[] = {0, 90, 180};  ///< of the normal from the sun
/// Directions of the fit: rays of the law that has no cosine, half about the sun: a grid wide enough to be quick
/// misses the aureole, whose rays are those that would weigh most.
constexpr int kFitRays = 2048;
constexpr float kFitSunShare = 0.5f, kFitAsymmetry = 0.85f;
/// A law replaces a simpler one where it leaves less than this of its variance: where it is not worth a lobe, the
/// cosine alone is kept, whose noise vanishes over an even sky.
constexpr double kWorth = 0.95;

struct Seen {
  double x, y, z, light;
  double weight_sr;  ///< solid angle that the direction stands for
};

/// The mean map's light over the upper hemisphere.
std::vector<Seen> seen_sky(const SkyBasis& basis, double sun_azimuth_rad, const std::array<float, 3>& sun) {
  const SkyDensity law{0.0f, kFitSunShare, kFitAsymmetry, sun[0], sun[1], sun[2]};
  std::vector<Seen> out;
  for (int i = 0; i < kFitRays; ++i) {
    const SkyRay ray = rc_sky_ray(law, 0u, 0u, static_cast<std::uint32_t>(i), 0.0f, 0.0f, 1.0f);
    if (!(ray.z > 0)) continue;
    const double x = ray.x, y = ray.y, z = ray.z;
    out.push_back({x, y, z, sky_value(basis, sun_azimuth_rad, x, y, z)[0], 1 / (kFitRays * double{ray.density})});
  }
  return out;
}

/// E[X^2] / E[X]^2 - 1 of the light that one ray brings, X = L cosine / density, mean over the normals.
double spread_of(const SkyDensity& law, const std::vector<Seen>& sky, double sun_azimuth_rad) {
  double sum = 0;
  int normals = 0;
  for (const double tilt_deg : kTilts_deg)
    for (const double turn_deg : kTurns_deg) {
      const double tilt = base::rad_from_deg(tilt_deg), azimuth = sun_azimuth_rad + base::rad_from_deg(turn_deg);
      const double nx = std::sin(tilt) * std::sin(azimuth), ny = std::sin(tilt) * std::cos(azimuth),
                   nz = std::cos(tilt);
      double mean = 0, square = 0;
      for (const Seen& s : sky) {
        const double facing = nx * s.x + ny * s.y + nz * s.z;
        if (!(facing > 0)) continue;
        const double density = static_cast<double>(rc_sky_density(law, static_cast<float>(s.x), static_cast<float>(s.y),
                                                                  static_cast<float>(s.z), static_cast<float>(facing)));
        const double light = s.light * facing;
        mean += light * s.weight_sr, square += light * light / density * s.weight_sr;
      }
      if (!(mean > 0)) continue;
      sum += square / (mean * mean) - 1, ++normals;
    }
  return normals > 0 ? sum / normals : 0;
}

}  // namespace

SkyRays make_sky_rays(const SkyBasis& basis, const Thermal& thermal, double sun_azimuth_rad,
                      const std::array<float, 3>& sun_direction, int rays) {
  SkyRays out;
  if (basis.empty() && !thermal.on) return out;
  out.rays = rays;
  out.sun_azimuth_rad = sun_azimuth_rad;
  const std::vector<Seen> sky = seen_sky(basis.empty() ? thermal.basis : basis, sun_azimuth_rad, sun_direction);
  const auto law_of = [&](double cosine, double sun, double g) {
    return SkyDensity{static_cast<float>(cosine), static_cast<float>(sun), static_cast<float>(g),
                      sun_direction[0],           sun_direction[1],        sun_direction[2]};
  };
  double least = spread_of(law_of(1, 0, kAsymmetries[0]), sky, sun_azimuth_rad);
  out.asymmetry = kAsymmetries[0];
  for (const double cosine : kCosineShares)
    for (const double sun : kSunShares)
      for (const double g : kAsymmetries) {
        if (cosine == 1 || (sun == 0 && g != kAsymmetries[0])) continue;
        const double spread = spread_of(law_of(cosine, sun, g), sky, sun_azimuth_rad);
        if (!(spread < kWorth * least)) continue;
        least = spread;
        out.cosine_share = cosine, out.sun_share = sun, out.asymmetry = g;
      }
  out.spread = least;
  return out;
}

SkyDensity sky_density(const Plan& plan) {
  return {static_cast<float>(plan.sky.cosine_share),
          static_cast<float>(plan.sky.sun_share),
          static_cast<float>(plan.sky.asymmetry),
          plan.sun_direction[0],
          plan.sun_direction[1],
          plan.sun_direction[2]};
}

std::vector<float> searched_nodes(const std::vector<double>& nodes) {
  std::vector<float> out(nodes.begin(), nodes.end());
  out.resize((nodes.size() + 15) / 16 * 16, std::numeric_limits<float>::infinity());
  return out;
}

}  // namespace raycube::plan
