// The rays by which a pixel looks for its sky: their law, the samples that send them, and what they find, against
// integrals over the sphere, chi-squared and closed forms.
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <doctest/doctest.h>

#include "host/plan/irradiance_map.h"
#include "host/plan/quadrature.h"
#include "host/plan/sky_rays.h"
#include "host/sensors/psf.h"
#include "kernels/sampling/sky_rays.h"
#include "tests/support/chance_checks.h"
#include "tests/support/chi_square.h"
#include "tests/support/skies.h"

using namespace raycube;

namespace {

using base::kPi;
using Vector = std::array<double, 3>;

Vector unit(double tilt_deg, double azimuth_deg) {
  const double t = base::rad_from_deg(tilt_deg), a = base::rad_from_deg(azimuth_deg);
  return {std::sin(t) * std::sin(a), std::sin(t) * std::cos(a), std::cos(t)};
}
double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

constexpr double kSunAzimuth = 0.4;  // rad

/// A law as the plan fits it to a clear sky, or of given shares.
struct Law {
  std::string name;
  SkyDensity density;
};
std::array<float, 3> sun_at(double zenith_deg) {
  const Vector s = unit(zenith_deg, base::deg_from_rad(kSunAzimuth));
  return {static_cast<float>(s[0]), static_cast<float>(s[1]), static_cast<float>(s[2])};
}
SkyDensity density_of(const plan::SkyRays& rays, const std::array<float, 3>& sun) {
  return {static_cast<float>(rays.cosine_share),
          static_cast<float>(rays.sun_share),
          static_cast<float>(rays.asymmetry),
          sun[0],
          sun[1],
          sun[2]};
}
plan::SkyRays fitted(double sun_zenith_deg) {
  return plan::make_sky_rays(test::factors_of(test::clear_sky(sun_zenith_deg), 4).basis, {}, kSunAzimuth,
                             sun_at(sun_zenith_deg), 64);
}
std::vector<Law> laws() {
  std::vector<Law> out = {{"cosine alone", {1, 0, 0.5f, 0, 0, 1}}};
  for (const double zenith_deg : {10.0, 40.0, 75.0})
    out.push_back(
        {"clear sky, sun at " + std::to_string(zenith_deg), density_of(fitted(zenith_deg), sun_at(zenith_deg))});
  const auto low = sun_at(80);
  out.push_back({"all three, narrow", {0.3f, 0.75f, 0.85f, low[0], low[1], low[2]}});
  out.push_back({"no lobe", {0.5f, 0, 0.5f, low[0], low[1], low[2]}});
  return out;
}
/// Level ground, a roof, walls, overhangs and the underside of a leaf, by tilt and azimuth in degrees.
const std::vector<std::array<double, 2>> kNormals = {{0, 0},    {35, 200}, {60, 20}, {90, 23},
                                                     {90, 300}, {120, 23}, {180, 0}};

double density_at(const SkyDensity& law, const Vector& d, const Vector& n) {
  return double{rc_sky_density(law, float(d[0]), float(d[1]), float(d[2]), float(dot(d, n)))};
}
SkyRay ray_of(const SkyDensity& law, rc_u32 seed, rc_u32 pixel, rc_u32 number, const Vector& n) {
  return rc_sky_ray(law, seed, pixel, number, float(n[0]), float(n[1]), float(n[2]));
}

/// Integral of f over the sphere in rings about `axis`, split at its equator: 2 x 64 Gauss points of the cosine, 128
/// turns.
template <class F>
double over_sphere(const Vector& axis, F f) {
  static const auto rule = plan::gauss_legendre(64);
  const Vector aside = std::abs(axis[2]) < 0.9 ? Vector{-axis[1], axis[0], 0} : Vector{0, axis[2], -axis[1]};
  const double length = std::sqrt(dot(aside, aside));
  const Vector t = {aside[0] / length, aside[1] / length, aside[2] / length};
  const Vector b = {axis[1] * t[2] - axis[2] * t[1], axis[2] * t[0] - axis[0] * t[2], axis[0] * t[1] - axis[1] * t[0]};
  double sum = 0;
  for (const double half : {-0.5, 0.5})
    for (const auto& [node, weight] : rule)
      for (int j = 0; j < 128; ++j) {
        const double up = half + 0.5 * node, out = std::sqrt(1 - up * up), phi = 2 * kPi * (j + 0.5) / 128;
        Vector d;
        for (std::size_t k = 0; k < 3; ++k) d[k] = up * axis[k] + out * (std::cos(phi) * t[k] + std::sin(phi) * b[k]);
        sum += 0.5 * weight * 2 * kPi / 128 * f(d);
      }
  return sum;
}

}  // namespace

TEST_CASE(
    "S16 the density's parts integrate to 1 over the hemisphere, the sphere and the sky, and any mixture is theirs") {
  for (const auto& [tilt, azimuth] : kNormals) {
    const Vector n = unit(tilt, azimuth), up = {0, 0, 1};
    // 1e-5: densities are floats, and a point of the rule may be rounded across the edge of a hemisphere
    CHECK(over_sphere(n, [&](const Vector& d) {
            return density_at({1, 0, 0.5f, 0, 0, 1}, d, n);
          }) == doctest::Approx(1).epsilon(1e-5));
    CHECK(over_sphere(up, [&](const Vector& d) {
            return density_at({0, 0, 0.5f, 0, 0, 1}, d, n);
          }) == doctest::Approx(1).epsilon(1e-5));
    for (const float g : {0.5f, 0.7f, 0.85f})
      for (const double zenith_deg : {10.0, 75.0}) {
        const auto sun = sun_at(zenith_deg);
        const Vector axis = unit(zenith_deg, base::deg_from_rad(kSunAzimuth));
        CHECK(over_sphere(axis, [&](const Vector& d) {
                return density_at({0, 1, g, sun[0], sun[1], sun[2]}, d, n);
              }) == doctest::Approx(1).epsilon(1e-5));
      }
  }
  for (const Law& law : laws()) {
    INFO(law.name);
    const SkyDensity& p = law.density;
    for (int k = 0; k < 200; ++k) {
      const Vector n = unit(0.9 * k, 97.0 * k), d = unit(180 * std::fmod(k * 0.618034, 1), 61.0 * k);
      const auto part = [&](float cosine, float sun) {
        return density_at({cosine, sun, p.g, p.sun_x, p.sun_y, p.sun_z}, d, n);
      };
      const double mixed = double{p.cosine} * part(1, 0) +
                           (1 - double{p.cosine}) * (double{p.sun} * part(0, 1) + (1 - double{p.sun}) * part(0, 0));
      CHECK(density_at(p, d, n) == doctest::Approx(mixed).epsilon(1e-5));
      // Light may come from wherever the surface faces, and there a ray can go.
      if (dot(n, d) > 1e-6) CHECK(density_at(p, d, n) >= 0.29 * dot(n, d) / kPi);
    }
  }
}

TEST_CASE("S16 rays go where the density says: chi-squared over 288 cells of the sphere") {
  constexpr int kRings = 12, kTurns = 24, kDrawn = 100'000, kInside = 24;
  for (const Law& law : laws())
    for (const auto& [tilt, azimuth] : kNormals) {
      INFO(law.name << ", normal at " << tilt << ", " << azimuth);
      const Vector n = unit(tilt, azimuth);
      std::vector<double> counted(kRings * kTurns, 0), expected(kRings * kTurns, 0);
      int wrong = 0;
      for (int i = 0; i < kDrawn; ++i) {
        // The first rays of as many pixels, and later ones of others: each ray of any pixel follows the law.
        const SkyRay ray = ray_of(law.density, testing::seed32(3), rc_u32(i), rc_u32(i % 7 * 5), n);
        const double x = double{ray.x}, y = double{ray.y}, z = double{ray.z};
        wrong += std::abs(x * x + y * y + z * z - 1) > 1e-6;
        wrong += std::abs(double{ray.facing} - dot({x, y, z}, n)) > 3e-7;
        wrong += ray.density != rc_sky_density(law.density, ray.x, ray.y, ray.z, ray.facing);
        wrong += !(ray.density > 0) && ray.facing > 1e-6f;
        const int ring = std::clamp(int((z + 1) / 2 * kRings), 0, kRings - 1),
                  turn = std::clamp(int((std::atan2(y, x) / (2 * kPi) + 0.5) * kTurns), 0, kTurns - 1);
        counted[std::size_t(ring * kTurns + turn)] += 1;
      }
      CHECK(wrong == 0);
      for (int ring = 0; ring < kRings; ++ring)
        for (int turn = 0; turn < kTurns; ++turn)
          for (int i = 0; i < kInside; ++i)
            for (int j = 0; j < kInside; ++j) {
              const double z = -1 + 2 * (ring + (i + 0.5) / kInside) / kRings,
                           phi = 2 * kPi * ((turn + (j + 0.5) / kInside) / kTurns - 0.5), flat = std::sqrt(1 - z * z);
              expected[std::size_t(ring * kTurns + turn)] +=
                  density_at(law.density, {flat * std::cos(phi), flat * std::sin(phi), z}, n) * 4 * kPi / kRings /
                  kTurns / kInside / kInside * kDrawn;
            }
      double chi = 0, few_counted = 0, few_expected = 0;
      int cells = 0;
      for (std::size_t i = 0; i < counted.size(); ++i) {
        if (expected[i] < 20) {
          few_counted += counted[i], few_expected += expected[i];
          continue;
        }
        chi += std::pow(counted[i] - expected[i], 2) / expected[i], ++cells;
      }
      if (few_expected >= 5)
        chi += std::pow(few_counted - few_expected, 2) / few_expected, ++cells;
      else
        CHECK(few_counted < 20);
      INFO("chi-squared " << chi << " of " << cells << " cells");
      // One of some forty, each of which may be unusual: p above 1e-6. They share draws: their sum tells no more.
      CHECK_BELOW(chi, testing::chi_square_limit(cells - 1, 4.75));
    }
}

TEST_CASE("S16 an even sky is looked at by the cosine alone; a clear one also about its sun, the cosine keeping 0.3") {
  const auto even = plan::make_sky_rays(test::uniform_sky(), {}, kSunAzimuth, sun_at(40), 48);
  CHECK(even.rays == 48);
  CHECK(even.cosine_share == 1);
  // Every ray above the horizon brings the same: only those that a tilted surface sends below it spread, by
  // 2 / (1 + cos tilt) - 1. That is 0, 0.072, 1/3, 1 and 3 for the tilts of the fit, 0.881 on their mean.
  CHECK(even.spread == doctest::Approx(0.8810).epsilon(0.005));
  for (const double zenith_deg : {10.0, 40.0, 60.0, 75.0, 85.0}) {
    const auto basis = test::factors_of(test::clear_sky(zenith_deg), 4).basis;
    const auto rays = plan::make_sky_rays(basis, {}, kSunAzimuth, sun_at(zenith_deg), 64);
    CHECK(rays.cosine_share >= plan::kLeastCosineShare);
    CHECK(rays.cosine_share < 1);
    CHECK(rays.sun_share > 0);
    // The spread is what drawn rays have over the normals of the fit, and less than the cosine alone leaves.
    const SkyDensity drawn[] = {density_of(rays, sun_at(zenith_deg)), {1, 0, 0.5f, 0, 0, 1}};
    double spread[2] = {0, 0};
    constexpr rc_u32 kDrawn = 20'000;
    for (const double tilt : {0, 30, 60, 90, 120})
      for (const double turn : {0, 90, 180})
        for (const int law : {0, 1}) {
          const Vector n = unit(tilt, base::deg_from_rad(kSunAzimuth) + turn);
          double mean = 0, square = 0;
          for (rc_u32 i = 0; i < kDrawn; ++i) {
            const SkyRay ray = ray_of(drawn[law], testing::seed32(1), i, 0, n);
            if (!(ray.facing > 0) || !(ray.z > 0)) continue;
            const double light = plan::sky_value(basis, kSunAzimuth, double{ray.x}, double{ray.y}, double{ray.z})[0] *
                                 double{ray.facing} / double{ray.density};
            mean += light / kDrawn, square += light * light / kDrawn;
          }
          spread[law] += (square / (mean * mean) - 1) / 15;
        }
    MESSAGE("sun at " << zenith_deg << ": cosine " << rays.cosine_share << ", about the sun " << rays.sun_share
                      << " of asymmetry " << rays.asymmetry << "; variance of a ray over its mean's square "
                      << rays.spread << ", drawn " << spread[0] << ", by the cosine alone " << spread[1]);
    CHECK_WITHIN(spread[0] / rays.spread - 1, 0.05);
    CHECK(spread[0] < spread[1]);
  }
  CHECK(plan::make_sky_rays({}, {}, 0, {0, 0, 1}, 64).rays == 0);
}

TEST_CASE("S16 S18 many rays of an open sky sum to the irradiance map, whatever the normal, band by band, to 1e-4") {
  const auto factors = test::factors_of(test::clear_sky(40), 4);
  const plan::SkyIrradiance exact(factors.basis);
  const auto law = density_of(plan::make_sky_rays(factors.basis, {}, kSunAzimuth, sun_at(40), 64), sun_at(40));
  constexpr rc_u32 kRays = 1u << 22;
  double worst = 0;
  for (const auto& [tilt, azimuth] :
       std::vector<std::array<double, 2>>{{0, 0}, {40, 30}, {75, 230}, {90, 10}, {130, 20}}) {
    const Vector n = unit(tilt, azimuth);
    std::array<double, 4> sum{};
    for (rc_u32 i = 0; i < kRays; ++i) {
      const SkyRay ray = ray_of(law, 5, i % 2, i / 2, n);
      if (!(ray.facing > 0) || !(ray.z > 0)) continue;
      const auto light = plan::sky_value(factors.basis, kSunAzimuth, double{ray.x}, double{ray.y}, double{ray.z});
      for (std::size_t m = 0; m < 4; ++m) sum[m] += light[m] * double{ray.facing} / double{ray.density} / kRays;
    }
    const auto want = exact.at(std::acos(n[2]), std::atan2(n[0], n[1]) - kSunAzimuth);
    for (std::size_t l = 0; l < factors.spectra[0].size(); ++l) {
      const auto mixture = test::mixture_of(factors, l);
      double apart = 0;
      for (std::size_t m = 0; m < 4; ++m) apart += mixture[m] * (sum[m] - want[m]);
      worst = std::max(worst, std::abs(apart));
    }
  }
  MESSAGE(kRays << " rays of two pixels: worst difference " << worst << " of the horizontal irradiance");
  CHECK(worst < 1e-4);
}

namespace {

/// A wall beside level ground, seen from its foot: it hides what lies below the plane through its top.
struct Wall {
  double azimuth, elevation;  // rad; towards the wall
  bool hides(double x, double y, double z) const {
    const double towards = x * std::sin(azimuth) + y * std::cos(azimuth);
    return towards > 0 && z * std::cos(elevation) < towards * std::sin(elevation);
  }
};

struct Found {
  double mean = 0, rms = 0, standard_error = 0;
};
/// By `rays` rays of each of `pixels` pixels: irradiance less `want`. light: of a direction; open: irradiance without a
/// wall; known: the share of it that is taken for granted.
template <class Light>
Found found_beside(const Wall& wall, const SkyDensity& law, int rays, int pixels, double known, double open,
                   double want, Light light) {
  double sum = 0, square = 0;
  for (int pixel = 0; pixel < pixels; ++pixel) {
    double met = 0;
    for (int i = 0; i < rays; ++i) {
      const SkyRay ray = ray_of(law, testing::seed32(11), rc_u32(pixel), rc_u32(i), {0, 0, 1});
      if (!(ray.facing > 0) || !(ray.z > 0)) continue;
      const double x = double{ray.x}, y = double{ray.y}, z = double{ray.z};
      const double seen = wall.hides(x, y, z) ? 0 : 1;
      if (seen != known) met += (seen - known) * light(x, y, z) * double{ray.facing} / double{ray.density} / rays;
    }
    const double error = known * open + met - want;
    sum += error, square += error * error;
  }
  const double mean = sum / pixels;
  return {mean, std::sqrt(square / pixels), std::sqrt(std::max(0.0, square / pixels - mean * mean) / (pixels - 1))};
}

}  // namespace

TEST_CASE("S16 even sky blocked by a wall: unbiased whatever is taken for granted; rms by the number of rays") {
  // An infinite wall of elevation e hides (1 - cos e) / 2 of the irradiance (Hottel's crossed strings). The cosine
  // alone brings the same by each ray, so the share taken for granted moves nothing but the mean's offset.
  const auto law = density_of(plan::make_sky_rays(test::uniform_sky(), {}, kSunAzimuth, sun_at(40), 64), sun_at(40));
  struct Bar {
    int rays, pixels;
    double rms;
  };
  for (const Bar bar : {Bar{1, 4096, 0.52},
                        {4, 4096, 0.18},
                        {16, 4096, 0.075},
                        {64, 2048, 0.028},
                        {256, 512, 0.009},
                        {1024, 256, 0.003}}) {
    double worst = 0;
    for (const double e_deg : {15.0, 30.0, 45.0, 60.0, 75.0, 90.0})
      for (const double azimuth : {0.0, 1.0})
        for (const double known : {0.0, 0.5, 1.0}) {
          const Wall wall{azimuth, base::rad_from_deg(e_deg)};
          const auto found = found_beside(wall, law, bar.rays, bar.pixels, known, 1, (1 + std::cos(wall.elevation)) / 2,
                                          [](double, double, double) { return 1 / kPi; });
          CAPTURE(bar.rays);
          CAPTURE(e_deg);
          CAPTURE(known);
          CHECK_WITHIN(found.mean, 4 * found.standard_error + 1e-6);
          worst = std::max(worst, found.rms);
        }
    MESSAGE(bar.rays << " rays: worst rms " << worst << " of the sky irradiance");
    CHECK_BELOW(worst, bar.rms);
  }
}

TEST_CASE("S16 real clear sky blocked by a wall: unbiased band by band whatever is taken for granted; rms by rays") {
  // Level ground, wall of 45 degrees towards the sun, across it and away from it: what is left is the integral of the
  // maps over the rest of the sky, by brute force.
  const auto factors = test::factors_of(test::clear_sky(40), 4);
  const auto law = density_of(plan::make_sky_rays(factors.basis, {}, kSunAzimuth, sun_at(40), 64), sun_at(40));
  const auto open_beside = [&](const Wall& wall) {
    std::array<double, 4> sum{};
    constexpr int n = 400;
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < 4 * n; ++j) {
        const double t = kPi / 2 * (i + 0.5) / n, f = 2 * kPi * (j + 0.5) / (4 * n);
        const Vector d = {std::sin(t) * std::sin(f), std::sin(t) * std::cos(f), std::cos(t)};
        if (wall.hides(d[0], d[1], d[2])) continue;
        const double w = std::cos(t) * std::sin(t) * (kPi / 2 / n) * (2 * kPi / (4 * n));
        const auto a = plan::sky_value(factors.basis, kSunAzimuth, d[0], d[1], d[2]);
        for (std::size_t m = 0; m < 4; ++m) sum[m] += w * a[m];
      }
    return sum;
  };
  struct Bar {
    int rays, pixels;
    double rms[3];  // by what is taken for granted: nothing, half, all
  };
  constexpr double kKnown[] = {0, 0.5, 1};
  for (const Bar bar : {Bar{4, 4096, {0.43, 0.3, 0.36}},
                        {16, 4096, {0.17, 0.12, 0.12}},
                        {64, 1024, {0.055, 0.048, 0.048}},
                        {1024, 128, {0.008, 0.008, 0.008}}}) {
    double worst[3] = {0, 0, 0};
    for (const double offset : {0.0, 1.5, kPi}) {
      const Wall wall{kSunAzimuth + offset, kPi / 4};
      const auto left = open_beside(wall);
      for (const std::size_t l : {std::size_t{3}, std::size_t{24}, std::size_t{60}}) {
        const auto mixture = test::mixture_of(factors, l);
        double want = 0;
        for (std::size_t m = 0; m < 4; ++m) want += mixture[m] * left[m];
        for (std::size_t k = 0; k < 3; ++k) {
          const auto found =
              found_beside(wall, law, bar.rays, bar.pixels, kKnown[k], 1, want, [&](double x, double y, double z) {
                const auto a = plan::sky_value(factors.basis, kSunAzimuth, x, y, z);
                return mixture[0] * a[0] + mixture[1] * a[1] + mixture[2] * a[2] + mixture[3] * a[3];
              });
          CAPTURE(bar.rays);
          CAPTURE(offset);
          CAPTURE(l);
          CAPTURE(kKnown[k]);
          // 2e-4: the brute-force rule, whose points straddle the wall's edge and the aureole
          CHECK_WITHIN(found.mean, 4 * found.standard_error + 2e-4);
          worst[k] = std::max(worst[k], found.rms);
        }
      }
    }
    MESSAGE(bar.rays << " rays under a clear sky: worst rms " << worst[0] << ", " << worst[1] << ", " << worst[2]
                     << " of the sky irradiance, nothing, half and all of it taken for granted");
    for (std::size_t k = 0; k < 3; ++k) CHECK_BELOW(worst[k], bar.rms[k]);
  }
}

TEST_CASE("S16 a pixel's rays: each from a sample of its own part, shares sum, and every sample is as likely") {
  struct Pixel {
    int sampler, nu, nv;
    rc_u32 rays;
  };
  std::vector<Pixel> cases;
  for (const auto& [nu, nv] : std::vector<std::array<int, 2>>{
           {1, 1}, {2, 1}, {3, 1}, {1, 5}, {2, 2}, {3, 2}, {4, 4}, {5, 3}, {7, 7}, {6, 9}, {11, 11}})
    for (const rc_u32 rays : {1u, 2u, 3u, 4u, 7u, 16u, 48u, 121u, 250u})
      for (const int sampler : {RC_SAMPLER_GRID, RC_SAMPLER_LATTICE, RC_SAMPLER_JITTERED})
        cases.push_back({sampler, nu, nv, rays});
  for (const Pixel& c : cases) {
    INFO("sampler " << c.sampler << ", " << c.nu << " x " << c.nv << " samples, " << c.rays << " rays");
    const auto nu = rc_u32(c.nu), nv = rc_u32(c.nv), samples = nu * nv, parts = rc_sky_parts(samples, c.rays);
    CHECK(parts == (samples < 4 || c.rays < 4 ? 1u : unsigned{sensors::kSampleSubsets}));
    scene::Instrument instrument;
    instrument.samples_u = c.nu, instrument.samples_v = c.nv;
    instrument.sampler = static_cast<scene::SamplerKind>(c.sampler);
    const sensors::SampleWeights weights(instrument);
    constexpr int kPixels = 2000;
    std::vector<double> stood(samples, 0), squares(samples, 0), extra(parts, 0);
    int wrong = 0;
    for (rc_u32 pixel = 0; pixel < kPixels; ++pixel) {
      std::vector<double> here(samples, 0);
      std::vector<int> numbered(c.rays, 0);
      rc_u32 sent = 0, of_parts = 0;
      double scales = 0;
      for (rc_u32 part = 0; part < parts; ++part) {
        const SkyPart share = rc_sky_shares(c.sampler, nu, nv, c.rays, testing::seed32(9), pixel, part);
        sent += share.rays, of_parts += share.samples;
        wrong += share.rays != c.rays / parts && share.rays != c.rays / parts + 1;
        extra[part] += share.rays - double(c.rays) / parts;
        std::vector<int> of_sample(samples, 0);
        for (rc_u32 ray = 0; ray < share.rays; ++ray) {
          const rc_u32 s = rc_sky_sample(share, nu, samples, c.rays, testing::seed32(9), pixel, part, ray);
          if (s >= samples) {
            ++wrong;
            continue;
          }
          wrong += parts > 1 && weights.subset_of(s) != int(part);
          here[s] += double{share.scale}, scales += double{share.scale};
          ++of_sample[s];
          // Other rays' numbers are others: no two go by the same point of the sequence.
          const rc_u32 number = rc_sky_number(samples, c.rays, part, ray);
          wrong += number >= c.rays + 2 * parts || (number < c.rays && numbered[number]++ > 0);
        }
        // Spread: no sample has two rays more than another needs; in a stretch lies one ray.
        const int most = *std::max_element(of_sample.begin(), of_sample.end());
        wrong += most > int((share.rays + share.samples - 1) / share.samples) + 1;
      }
      wrong += sent != c.rays || of_parts != samples;
      wrong += std::abs(scales - samples) > 1e-5 * samples;
      for (rc_u32 s = 0; s < samples; ++s) stood[s] += here[s], squares[s] += here[s] * here[s];
    }
    CHECK(wrong == 0);
    // The variance is that of all samples of a part: of one ray for 121 a sample stands for 17 pixels of 2000, and one
    // that stands for 4 would think itself known to half of what it is.
    const auto part_of = [&](rc_u32 s) { return parts > 1 ? static_cast<std::size_t>(weights.subset_of(s)) : 0; };
    std::vector<double> variance(parts, 0), of_part(parts, 0);
    for (rc_u32 s = 0; s < samples; ++s)
      variance[part_of(s)] += squares[s] / kPixels - std::pow(stood[s] / kPixels, 2), of_part[part_of(s)] += 1;
    double worst = 0;
    for (rc_u32 s = 0; s < samples; ++s) {
      const double of_one = std::max(variance[part_of(s)] / of_part[part_of(s)], 1e-12);
      worst = std::max(worst, (std::abs(stood[s] / kPixels - 1) - 1e-6) / std::sqrt(of_one / kPixels));
    }
    CHECK_BELOW(worst, 5.5);  // standard errors, of the most unusual of some ten thousand samples in all
    // A ray more than the others' goes to each part alike.
    for (const double sum : extra) CHECK_WITHIN(sum, 4 * 0.5 * std::sqrt(double(kPixels)));
  }
}
