#include "host/plan/sky_sets.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "kernels/sampling/sampler.h"

namespace raycube::plan {

namespace {

/// Share of uniform directions in the density p(d) = (1 - u) cos/pi + u/(2 pi). Pure cosine weighting (u = 0) lets
/// max(0, n.d)/p grow without bound near the horizon, which makes walls and leaves noisy; half of each is as good as it
/// on horizontal ground (4.5 against 4.8 % rms at 16 directions beside a wall) and 3.5 times better on a vertical surface.
constexpr double kUniformShare = 0.5;
constexpr int kDirectionsInAll = 1 << 17;
constexpr int kFewestSets = 64, kMostSets = 4096;

}  // namespace

SkySets make_sky_sets(const SkyBasis& basis, double sun_azimuth_rad, int directions, std::uint64_t seed) {
  SkySets out;
  if (basis.empty()) return out;
  out.directions = directions;
  out.sets = std::clamp(kDirectionsInAll / directions, kFewestSets, kMostSets);
  const auto total = static_cast<std::size_t>(out.sets) * static_cast<std::size_t>(directions);
  out.direction.reserve(total);
  out.weight.reserve(total);

  // Sunflower lattice: point k lies in ring k of equal probability, golden-angle apart (Vogel, Math. Biosci. 44, 1979). A set
  // shifts it within the rings and turns it; the pairs (shift, turn) follow the R2 sequence (Roberts 2018: powers of the
  // plastic number) from a start made of the seed, so that the mean over all sets is far closer than independent shifts.
  constexpr double golden = std::numbers::phi - 1, plastic = 1.32471795724474602596;
  const auto low = static_cast<rc_u32>(seed), high = static_cast<rc_u32>(seed >> 32);
  const double start_shift = rc_hash(low, high, 0u, 31u) * 0x1p-32, start_turn = rc_hash(low, high, 1u, 31u) * 0x1p-32;
  for (int set = 0; set < out.sets; ++set) {
    double whole = 0;
    const double shift = std::modf(start_shift + (set + 1) / plastic, &whole);
    const double turn = std::modf(start_turn + (set + 1) / (plastic * plastic), &whole);
    for (int k = 0; k < directions; ++k) {
      const double outside = 1 - (k + shift) / directions;  // probability of a direction nearer the horizon
      const double u = kUniformShare, z = (std::sqrt(u * u + 4 * (1 - u) * outside) - u) / (2 * (1 - u));
      const double azimuth = 2 * std::numbers::pi * std::modf(k * golden + turn, &whole);
      const double horizontal = std::sqrt(std::max(0.0, 1 - z * z));
      const double x = horizontal * std::sin(azimuth), y = horizontal * std::cos(azimuth);
      const double density = (1 - u) * z / std::numbers::pi + u / (2 * std::numbers::pi);
      const double solid_angle = 1 / (density * directions);
      const auto a = sky_value(basis, sun_azimuth_rad, x, y, z);
      out.direction.push_back({static_cast<float>(x), static_cast<float>(y), static_cast<float>(z), 0});
      out.weight.push_back({static_cast<float>(a[0] * solid_angle), static_cast<float>(a[1] * solid_angle),
                            static_cast<float>(a[2] * solid_angle), static_cast<float>(a[3] * solid_angle)});
    }
  }
  return out;
}

}  // namespace raycube::plan
