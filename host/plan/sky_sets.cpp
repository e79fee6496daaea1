#include "host/plan/sky_sets.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "host/base/error.h"
#include "host/base/units.h"
#include "kernels/sampling/sampler.h"
#include "kernels/shared/tile_layout.h"

namespace raycube::plan {

namespace {

/// Share of uniform directions in the density p(d) = (1 - u) A_0 cos + u/(2 pi), A_0 cos being the light that arrives
/// on level ground. Without it (u = 0) max(0, n.d)/p grows without bound near the horizon, which makes walls and leaves
/// noisy; half of each is as good as none on level ground (4.5 against 4.8 % rms at 16 directions beside a wall) and
/// 3.5 times better on a vertical surface.
constexpr double kUniformShare = 0.5;
constexpr int kDirectionsInAll = 1 << 17;

/// Draws directions from p: z = cos(zenith) from a fine step function, then the azimuth from p itself at that zenith,
/// whose parts between the maps' nodes are linear and inverted in closed form.
class SkyDensity {
 public:
  explicit SkyDensity(const SkyBasis& basis) : basis_(basis), ring_(basis.azimuth_rad.size()), below_(kSteps + 1, 0.0) {
    for (std::size_t i = 0; i < kSteps; ++i)
      below_[i + 1] = below_[i] + load_ring(1 - (static_cast<double>(i) + 0.5) / kSteps);
    for (double& b : below_) b /= below_.back();
  }

  struct Draw {
    double z, azimuth, density;  ///< azimuth relative to the sun, -pi .. pi; density per sr
  };
  /// u: 0 at the zenith, 1 at the horizon; v around. Both in [0, 1).
  Draw draw(double u, double v) {
    const auto upper = std::upper_bound(below_.begin() + 1, below_.end() - 1, u);
    const auto step = static_cast<std::size_t>(upper - below_.begin()) - 1;
    const double mass = below_[step + 1] - below_[step];
    const double z = std::max(1 - (static_cast<double>(step) + (u - below_[step]) / mass) / kSteps, 1e-7);
    const double whole = load_ring(z), side = v < 0.5 ? -1 : 1;
    double want = std::abs(2 * v - 1) * 0.5 * whole;  // the ring is even: half of it from azimuth 0 outwards
    const auto& f = basis_.azimuth_rad;
    std::size_t j = 0;
    const auto part = [&](std::size_t k) { return 0.5 * (ring_[k] + ring_[k + 1]) * (f[k + 1] - f[k]); };
    while (j + 2 < f.size() && want > part(j)) want -= part(j++);
    const double slope = (ring_[j + 1] - ring_[j]) / (f[j + 1] - f[j]);
    // ring_j t + slope t^2 / 2 = want, the root that stays finite as slope goes to 0
    const double root = std::sqrt(std::max(0.0, ring_[j] * ring_[j] + 2 * slope * want));
    const double t = std::min(2 * want / (ring_[j] + root), f[j + 1] - f[j]);
    return {z, side * (f[j] + t), mass * kSteps * (ring_[j] + slope * t) / whole};
  }

 private:
  static constexpr std::size_t kSteps = 4096;

  /// p at the azimuth nodes of this zenith into ring_; returns its integral around.
  double load_ring(double z) {
    const Cell zenith = find_cell(basis_.zenith_rad, std::acos(z));
    const std::size_t row = basis_.azimuth_rad.size();
    for (std::size_t j = 0; j < row; ++j) {
      const std::size_t i = zenith.index * row + j;
      const double a = (1 - zenith.fraction) * basis_.value[i][0] + zenith.fraction * basis_.value[i + row][0];
      ring_[j] = (1 - kUniformShare) * a * z + kUniformShare / (2 * base::kPi);
    }
    double around = 0;
    for (std::size_t j = 0; j + 1 < row; ++j)
      around += (ring_[j] + ring_[j + 1]) * (basis_.azimuth_rad[j + 1] - basis_.azimuth_rad[j]);
    return around;
  }

  const SkyBasis& basis_;
  std::vector<double> ring_, below_;
};

/// Solar maps, then those of thermal light, as SkySets has them.
class Weights {
 public:
  Weights(const SkyBasis& basis, double sun_azimuth_rad, int components, const Thermal* thermal)
      : basis_(basis), sun_azimuth_rad_(sun_azimuth_rad), components_(components), thermal_(thermal) {}

  int quads() const { return RC_SKY_PLANES_OF(components_ + (thermal_ ? thermal_->components() : 0)) / 4; }

  void add(SkySets& to, double x, double y, double z, double solid_angle_sr) const {
    std::array<double, 8> a{};
    const auto solar = sky_value(basis_, sun_azimuth_rad_, x, y, z);
    std::copy(solar.begin(), solar.end(), a.begin());
    if (thermal_) {
      const auto emitted = sky_value(thermal_->basis, sun_azimuth_rad_, x, y, z);
      const auto first = static_cast<std::size_t>(components_),
                 sky = static_cast<std::size_t>(thermal_->sky_components);
      std::fill(a.begin() + components_, a.end(), 0.0);
      std::copy(emitted.begin(), emitted.begin() + thermal_->sky_components, a.begin() + components_);
      a[first + sky] = -1;
    }
    to.direction.push_back({static_cast<float>(x), static_cast<float>(y), static_cast<float>(z), 0});
    for (std::size_t q = 0; q < 4 * static_cast<std::size_t>(to.quads); q += 4)
      to.weight.push_back({static_cast<float>(a[q] * solid_angle_sr), static_cast<float>(a[q + 1] * solid_angle_sr),
                           static_cast<float>(a[q + 2] * solid_angle_sr),
                           static_cast<float>(a[q + 3] * solid_angle_sr)});
  }

 private:
  const SkyBasis& basis_;
  double sun_azimuth_rad_;
  int components_;
  const Thermal* thermal_;
};

}  // namespace

SkySets make_sky_sets(const SkyBasis& basis, double sun_azimuth_rad, int directions, std::uint64_t seed, int components,
                      const Thermal* thermal, int most_sets) {
  SkySets out;
  if (basis.empty() && !thermal) return out;
  const SkyBasis& drawn = basis.empty() ? thermal->basis : basis;
  const Weights weights(basis, sun_azimuth_rad, components, thermal);
  out.quads = weights.quads();
  out.directions = directions;
  out.sets = std::clamp(kDirectionsInAll / directions, kFewestSets, most_sets);
  const auto total = static_cast<std::size_t>(out.sets) * static_cast<std::size_t>(directions);
  out.direction.reserve(total);
  out.weight.reserve(total);

  // Sunflower lattice: point k lies in ring k of equal probability, a golden angle further in probability around the
  // ring (Vogel, Math. Biosci. 44, 1979). A set shifts it within the rings and turns it; the pairs (shift, turn) follow
  // the R2 sequence (Roberts 2018: powers of the plastic number) from a start made of the seed, so that the mean over
  // all sets is far closer than with independent shifts.
  constexpr double golden = std::numbers::phi - 1, plastic = 1.32471795724474602596;
  const auto low = static_cast<rc_u32>(seed), high = static_cast<rc_u32>(seed >> 32);
  const double start_shift = rc_hash(low, high, 0u, 31u) * 0x1p-32, start_turn = rc_hash(low, high, 1u, 31u) * 0x1p-32;
  SkyDensity density(drawn);
  for (int set = 0; set < out.sets; ++set) {
    double whole = 0;
    const double shift = std::modf(start_shift + (set + 1) / plastic, &whole);
    const double turn = std::modf(start_turn + (set + 1) / (plastic * plastic), &whole);
    for (int k = 0; k < directions; ++k) {
      const auto d = density.draw((k + shift) / directions, std::modf(k * golden + turn, &whole));
      const double azimuth = sun_azimuth_rad + d.azimuth, horizontal = std::sqrt(std::max(0.0, 1 - d.z * d.z));
      const double x = horizontal * std::sin(azimuth), y = horizontal * std::cos(azimuth);
      weights.add(out, x, y, d.z, 1 / (d.density * directions));
    }
  }
  return out;
}

SkySets sky_set_of(const SkyBasis& basis, double sun_azimuth_rad, const std::vector<std::array<double, 3>>& directions,
                   double solid_angle_sr, int components, const Thermal* thermal) {
  const Weights weights(basis, sun_azimuth_rad, components, thermal);
  SkySets out;
  out.sets = 1;
  out.directions = static_cast<int>(directions.size());
  out.quads = weights.quads();
  for (const auto& d : directions) weights.add(out, d[0], d[1], d[2], solid_angle_sr);
  return out;
}

int sky_share(int given, int samples, int directions) {
  if (given > 0) {
    if (directions % given != 0)
      throw base::Error(base::Fault::bug,
                        fmt::format("a sky share of {} does not divide {} directions", given, directions));
    return given;
  }
  int share = 1;
  while (share < kMostShare && directions % (2 * share) == 0 && samples >= 2 * share * kFewestPoints) share *= 2;
  return share;
}

}  // namespace raycube::plan
