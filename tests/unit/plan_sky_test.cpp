// The sky of a plan: factors, unoccluded irradiance and direction sets, against closed forms and brute force.
#include <algorithm>
#include <cmath>
#include <numbers>

#include <doctest/doctest.h>

#include "atmos_tables/clear_sky.h"
#include "atmos_tables/interpolate.h"
#include "atmos_tables/table_rows.h"
#include "host/plan/irradiance_map.h"
#include "host/plan/quadrature.h"
#include "host/plan/sky_factors.h"
#include "host/plan/sky_sets.h"
#include "kernels/sampling/sampler.h"

using namespace raycube;

namespace {

constexpr double kPi = std::numbers::pi;

plan::SkyBasis uniform_sky() {  // A_0 = 1/pi: irradiance 1 on horizontal ground
  plan::SkyBasis basis;
  for (int i = 0; i <= 12; ++i) basis.zenith_rad.push_back(kPi / 2 * i / 12);
  for (int j = 0; j <= 6; ++j) basis.azimuth_rad.push_back(kPi * j / 6);
  basis.value.assign(basis.nodes(), {1 / kPi, 0, 0, 0});
  return basis;
}

atmos::RenderTable clear_sky(double sun_zenith_deg) {
  scene::Sun sun;
  sun.zenith_deg = sun_zenith_deg;
  return atmos::build_clear_sky({}, sun, 610, atmos::clear_sky_wavelengths(0.38, 2.48, 0.02), {0, 60});
}

plan::SkyFactors factors_of(const atmos::RenderTable& table, int rank) {
  const std::size_t count = table.axis("wavelength").nodes.size();
  const plan::TableSpectra air(table, false, true, 0, count);
  const plan::SkyFactorizer sky(air, 0, table.sun_zenith_deg * kPi / 180);
  const auto per_wavelength = [&](const plan::SkySpectra& s) {
    std::vector<plan::Mixture> out(count, plan::Mixture{});
    for (std::size_t l = 0; l < count; ++l)
      for (std::size_t m = 0; m < 4; ++m) out[l][m] = s[m][l] / s[0][l];
    return out;
  };
  return sky.factor(rank, plan::Spectrum(count, 1.0), per_wavelength);
}

/// Integral of A_m max(0, n.d) by brute force, cell by cell of the maps: 4 x 4 Gauss points where the cell is wholly
/// before or behind the plane, 96 x 96 midpoints where the plane cuts it.
std::array<double, 4> brute(const plan::SkyBasis& basis, double sun_azimuth, double x, double y, double z) {
  static const auto gauss = plan::gauss_legendre(4);
  std::vector<std::pair<double, double>> midpoints;
  for (int i = 0; i < 96; ++i) midpoints.emplace_back(-1 + (2 * i + 1) / 96.0, 2 / 96.0);
  std::array<double, 4> sum{};
  const auto& t = basis.zenith_rad;
  const auto& f = basis.azimuth_rad;
  for (std::size_t i = 0; i + 1 < t.size(); ++i)
    for (std::size_t j = 0; j + 1 < f.size(); ++j)
      for (const double side : {1.0, -1.0}) {
        const auto facing = [&](double zenith, double azimuth) {
          const double a = sun_azimuth + side * azimuth;
          return x * std::sin(zenith) * std::sin(a) + y * std::sin(zenith) * std::cos(a) + z * std::cos(zenith);
        };
        int before = 0;
        for (int u = 0; u <= 8; ++u)
          for (int v = 0; v <= 8; ++v)
            before += facing(t[i] + (t[i + 1] - t[i]) * u / 8, f[j] + (f[j + 1] - f[j]) * v / 8) > 0;
        const auto& rule = before == 0 || before == 81 ? gauss : midpoints;
        for (const auto& [nu, wu] : rule)
          for (const auto& [nv, wv] : rule) {
            const double zenith = 0.5 * (t[i] + t[i + 1] + nu * (t[i + 1] - t[i])),
                         azimuth = 0.5 * (f[j] + f[j + 1] + nv * (f[j + 1] - f[j]));
            const double c = facing(zenith, azimuth);
            if (c <= 0) continue;
            const double a = sun_azimuth + side * azimuth,
                         w = 0.25 * wu * wv * (t[i + 1] - t[i]) * (f[j + 1] - f[j]) * std::sin(zenith) * c;
            const auto value = plan::sky_value(basis, sun_azimuth, std::sin(zenith) * std::sin(a),
                                               std::sin(zenith) * std::cos(a), std::cos(zenith));
            for (std::size_t m = 0; m < 4; ++m) sum[m] += w * value[m];
          }
      }
  return sum;
}

}  // namespace

TEST_CASE("S16 uniform sky on a tilted plane: (1 + cos b)/2 of the horizontal, exact integral and map") {
  const auto basis = uniform_sky();
  const plan::SkyIrradiance exact(basis);
  for (int i = 0; i <= 36; ++i)
    for (const double azimuth : {0.0, 0.7, 2.5, kPi}) {
      const double tilt = kPi * i / 36;
      CHECK(std::abs(exact.at(tilt, azimuth)[0] - (1 + std::cos(tilt)) / 2) < 1e-7);  // of the horizontal irradiance
    }
  const plan::IrradianceGrid grid(exact, 0.3);
  const auto map = plan::make_irradiance_map(grid, plan::kMapSizes.back());
  double worst = 0;
  for (int k = 0; k < 5000; ++k) {
    const double z = 1 - (2 * k + 1.0) / 5000, f = 2.39996 * k, r = std::sqrt(1 - z * z);
    worst = std::max(worst, std::abs(plan::read_map(map, r * std::sin(f), r * std::cos(f), z)[0] - (1 + z) / 2));
  }
  CHECK(worst < 5e-6);
  MESSAGE("worst difference " << worst << " of the horizontal irradiance");
}

TEST_CASE("S16 one bright azimuth sector: exact integral against its closed form") {
  // A = 1 for |azimuth| < a, 0 elsewhere (steep ramp of 1e-6 rad). Horizontal: a; vertical plane facing it (n = north,
  // sun in the north): integral of sin^2(t) cos(f) dt df = (pi/4) 2 sin(a).
  const double a = 1.1;
  plan::SkyBasis basis;
  basis.zenith_rad = {0, 1e-9, kPi / 4, kPi / 2};
  basis.azimuth_rad = {0, a - 0.5e-6, a + 0.5e-6, kPi};
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < 4; ++j) basis.value.push_back({i > 0 && j < 2 ? 1.0 : 0.0, 0, 0, 0});
  const plan::SkyIrradiance exact(basis);
  CHECK(exact.at(0, 0, 8)[0] == doctest::Approx(a).epsilon(1e-9));
  CHECK(exact.at(kPi / 2, 0, 8)[0] == doctest::Approx(kPi / 2 * std::sin(a)).epsilon(1e-9));
}

TEST_CASE("S16 real clear sky: exact integral against brute force, and the map between its nodes") {
  const auto table = clear_sky(40);
  const auto factors = factors_of(table, 4);
  REQUIRE(factors.rank >= 2);
  const double sun_azimuth = 160 * kPi / 180;
  const plan::SkyIrradiance exact(factors.basis);
  for (const auto& n :
       {std::array{0.0, 0.0, 1.0}, {0.6, 0.0, 0.8}, {-0.48, 0.6, 0.64}, {0.8, -0.6, 0.0}, {0.36, 0.48, -0.8}}) {
    const auto want = brute(factors.basis, sun_azimuth, n[0], n[1], n[2]);
    const auto found = exact.at(std::acos(n[2]), std::atan2(n[0], n[1]) - sun_azimuth);
    // midpoints in cut cells: about 1e-7
    for (std::size_t m = 0; m < 4; ++m) CHECK(std::abs(found[m] - want[m]) < 5e-7);
    const auto finer = exact.at(std::acos(n[2]), std::atan2(n[0], n[1]) - sun_azimuth, 8);
    for (std::size_t m = 0; m < 4; ++m) CHECK(std::abs(found[m] - finer[m]) < 1e-7);
  }
  const plan::IrradianceGrid grid(exact, sun_azimuth);
  const auto map = plan::make_irradiance_map(grid, 1025);
  double between = 0, smooth = 0;
  for (int k = 0; k < 3000; ++k) {
    const double z = 1 - (2 * k + 1.0) / 3000, f = 2.39996 * k, r = std::sqrt(1 - z * z), x = r * std::sin(f),
                 y = r * std::cos(f);
    const auto want = exact.at(std::acos(z), f - sun_azimuth), found = plan::read_map(map, x, y, z),
               cubic = grid.at(x, y, z);
    for (std::size_t m = 0; m < 4; ++m) smooth = std::max(smooth, std::abs(cubic[m] - want[m]));
    for (std::size_t l = 0; l < factors.spectra[0].size(); ++l) {
      double difference = 0;
      for (std::size_t m = 0; m < 4; ++m)
        difference += factors.spectra[m][l] / factors.spectra[0][l] * (found[m] - want[m]);
      between = std::max(between, std::abs(difference));
    }
  }
  MESSAGE("nodes off by " << smooth << ", between nodes by " << between << " of the horizontal irradiance");
  CHECK(smooth < 1e-6);
  CHECK(between < 5e-6);
}

TEST_CASE("S18 sky factors: component 0 carries the irradiance, the others none, sums stay positive") {
  const auto table = clear_sky(55);
  const std::size_t count = table.axis("wavelength").nodes.size();
  double last = 1;
  for (int rank = 1; rank <= 4; ++rank) {
    const auto factors = factors_of(table, rank);
    REQUIRE(factors.rank == rank);
    const auto q = plan::cosine_weights(factors.basis);
    std::array<double, 4> flux{};
    for (std::size_t i = 0; i < q.size(); ++i)
      for (std::size_t m = 0; m < 4; ++m) flux[m] += q[i] * factors.basis.value[i][m];
    CHECK(flux[0] == doctest::Approx(1).epsilon(1e-12));
    for (std::size_t m = 1; m < 4; ++m) CHECK(std::abs(flux[m]) < 1e-12);
    // irradiance of the maps' sky is the table's diffuse irradiance: 1 % is the sky's own interpolation between its
    // nodes
    const auto diffuse = atmos::diffuse_irradiance(table, 0);
    double worst = 0;
    for (std::size_t l = 0; l < count; ++l) {
      CHECK(factors.spectra[0][l] == doctest::Approx(diffuse[l]).epsilon(0.01));
      worst = std::max(worst, factors.occluder_error[l]);
    }
    MESSAGE("components " << rank << ": worst obstacle error " << worst << " of the sky irradiance");
    CHECK(worst < last);
    last = worst;
  }
  CHECK(last < 0.05);
}

TEST_CASE(
    "S4.9 where light goes between ground and air, shading's sky carries the very flux that lights the ground around") {
  auto table = clear_sky(55);
  const auto fill = [&](const char* name, float value) {
    std::vector<float>& values = atmos::add_row(table, name, "test").values;
    std::fill(values.begin(), values.end(), value);
  };
  fill("spherical_albedo", 0.1f), fill("diffuse_view_transmission", 0.05f), fill("diffuse_return", 0.1f);
  const std::size_t count = table.axis("wavelength").nodes.size();
  const plan::TableSpectra air(table, false, true, 0, count, plan::Spectrum(count, 0.3));
  const plan::SkyFactorizer sky(air, 30, 55 * kPi / 180);
  const auto flux = air.diffuse_irradiance(30);
  const auto scale = plan::sky_flux_scale(air, 30, 55 * kPi / 180);
  for (std::size_t l = 0; l < count; ++l) {
    CHECK(sky.irradiance()[l] == doctest::Approx(flux[l]).epsilon(1e-12));
    CHECK(sky.sampled_irradiance()[l] == doctest::Approx(flux[l]).epsilon(0.01));  // its interpolation between nodes
    CHECK(sky.sampled_irradiance()[l] * scale[l] == doctest::Approx(flux[l]).epsilon(1e-12));
  }
  const auto factors = sky.factor(2, plan::Spectrum(count, 1.0), [&](const plan::SkySpectra& s) {
    return std::vector<plan::Mixture>(s[0].size(), plan::Mixture{1, 0, 0, 0});
  });
  for (std::size_t l = 0; l < count; ++l) CHECK(factors.spectra[0][l] == doctest::Approx(flux[l]).epsilon(1e-12));
  // At another height: the flux there.
  const auto above = plan::sky_spectra(factors, air, 60);
  const auto there = air.diffuse_irradiance(60);
  for (std::size_t l = 0; l < count; ++l) CHECK(above[0][l] == doctest::Approx(there[l]).epsilon(1e-12));
}

TEST_CASE("S4.9 a sky is brought to its flux without steps, by no more than 2, and not at all where either is dark") {
  CHECK(plan::same_sky_scale(2.0, 2.02) == doctest::Approx(1.01).epsilon(1e-15));
  CHECK(plan::same_sky_scale(2.0, 2.2) == doctest::Approx(1.1).epsilon(1e-15));
  CHECK(plan::same_sky_scale(2.0, 9.0) == 2);
  CHECK(plan::same_sky_scale(9.0, 2.0) == 0.5);
  CHECK(plan::same_sky_scale(2.0, 0.0) == 1);
  CHECK(plan::same_sky_scale(0.0, 0.0) == 1);
}

TEST_CASE("S18 the sky sampled at once follows the table's own reading at every direction") {
  const auto table = clear_sky(40);
  const std::size_t count = table.axis("wavelength").nodes.size();
  const plan::TableSpectra air(table, false, true, 0, count);
  const std::vector<double> zenith = {0, 0.05, 0.6981, 1.2, 1.55, kPi / 2}, azimuth = {0, 0.03, 1, 2.2, kPi};
  const auto grid = air.sky_grid(17, zenith, azimuth);
  for (std::size_t i = 0; i < zenith.size(); ++i)
    for (std::size_t j = 0; j < azimuth.size(); ++j) {
      const auto want = atmos::sky_radiance(table, 17, zenith[i] * 180 / kPi, azimuth[j] * 180 / kPi);
      for (std::size_t l = 0; l < count; ++l)
        CHECK(grid[(i * azimuth.size() + j) * count + l] == doctest::Approx(want[l]).epsilon(1e-9));
    }
}

TEST_CASE("S16 sky blocked by a wall: unbiased over the sets, rms below 6 % at 16 and 0.3 % at 1024 directions") {
  // Infinite wall of elevation angle e beside horizontal ground: it hides (1 - cos e)/2 of a uniform sky's irradiance
  // (Hottel's crossed strings). Beside the wall the plane of its top edge is y tan(e) = z.
  const auto basis = uniform_sky();
  struct Bar {
    int directions;
    double rms;
  };
  for (const Bar bar : {Bar{16, 0.06}, Bar{1024, 0.003}}) {
    double worst = 0;
    for (const std::uint64_t seed : {1u, 77u}) {
      const auto sets = plan::make_sky_sets(basis, 0.4, bar.directions, seed);
      REQUIRE(sets.sets * bar.directions >= 1 << 16);
      for (const double e_deg : {15.0, 30.0, 45.0, 60.0, 75.0, 90.0})
        for (const double wall_azimuth : {0.0, 1.0}) {
          const double e = e_deg * kPi / 180, hidden = (1 - std::cos(e)) / 2;
          double sum = 0, squares = 0;
          for (int s = 0; s < sets.sets; ++s) {
            double blocked = 0;
            for (int k = 0; k < bar.directions; ++k) {
              const auto i = static_cast<std::size_t>(s * bar.directions + k);
              const auto& d = sets.direction[i];
              const double towards = double{d.x} * std::sin(wall_azimuth) + double{d.y} * std::cos(wall_azimuth);
              if (towards > 0 && double{d.z} * std::cos(e) < towards * std::sin(e))
                blocked += double{sets.weight[i].x} * double{d.z};
            }
            sum += blocked - hidden;
            squares += (blocked - hidden) * (blocked - hidden);
          }
          const double mean = sum / sets.sets, rms = std::sqrt(squares / sets.sets);
          worst = std::max(worst, rms);
          CHECK(rms < bar.rms);
          CHECK(std::abs(mean) < 4 * rms / std::sqrt(static_cast<double>(sets.sets)));
        }
    }
    MESSAGE(bar.directions << " directions: worst rms " << worst << " of the sky irradiance");
  }
}

TEST_CASE("S16 real clear sky blocked by a wall: unbiased over the sets, band by band") {
  // Level ground, wall of 45 deg elevation towards the sun, across it and away from it: what the wall hides is the
  // integral of the maps over it, by brute force (a plane through the origin: the hidden part is the horizontal flux
  // minus the flux that arrives from before the wall's plane).
  const auto table = clear_sky(40);
  const auto factors = factors_of(table, 4);
  const double sun_azimuth = 0.4;
  const auto hidden_by = [&](double wall_azimuth, double elevation) {
    std::array<double, 4> sum{};
    constexpr int n = 300;
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < 4 * n; ++j) {
        const double t = kPi / 2 * (i + 0.5) / n, f = 2 * kPi * (j + 0.5) / (4 * n);
        if (std::cos(t) * std::cos(elevation) >= std::sin(t) * std::cos(f - wall_azimuth) * std::sin(elevation))
          continue;
        const double w = std::cos(t) * std::sin(t) * (kPi / 2 / n) * (2 * kPi / (4 * n));
        const auto a = plan::sky_value(factors.basis, sun_azimuth, std::sin(t) * std::sin(f), std::sin(t) * std::cos(f),
                                       std::cos(t));
        for (std::size_t m = 0; m < 4; ++m) sum[m] += w * a[m];
      }
    return sum;
  };
  for (const int directions : {16, 1024}) {
    const auto sets = plan::make_sky_sets(factors.basis, sun_azimuth, directions, 3);
    double worst = 0;
    for (const double offset : {0.0, 1.5, kPi})
      for (const std::size_t l : {std::size_t{3}, std::size_t{24}, std::size_t{60}}) {
        const double wall_azimuth = sun_azimuth + offset, elevation = kPi / 4;
        const auto want = hidden_by(wall_azimuth, elevation);
        double truth = 0, sum = 0, squares = 0;
        std::array<double, 4> mix{};
        for (std::size_t m = 0; m < 4; ++m) {
          mix[m] = factors.spectra[m][l] / factors.spectra[0][l];
          truth += mix[m] * want[m];
        }
        for (int s = 0; s < sets.sets; ++s) {
          double blocked = 0;
          for (int k = 0; k < directions; ++k) {
            const auto i = static_cast<std::size_t>(s * directions + k);
            const auto &d = sets.direction[i], &w = sets.weight[i];
            const double towards = double{d.x} * std::sin(wall_azimuth) + double{d.y} * std::cos(wall_azimuth);
            if (double{d.z} * std::cos(elevation) < towards * std::sin(elevation))
              blocked += d.z * (mix[0] * w.x + mix[1] * w.y + mix[2] * w.z + mix[3] * w.w);
          }
          sum += blocked - truth;
          squares += (blocked - truth) * (blocked - truth);
        }
        const double mean = sum / sets.sets, rms = std::sqrt(squares / sets.sets);
        worst = std::max(worst, rms);
        // 1e-4: the brute-force rule, whose points straddle the wall's edge
        CHECK(std::abs(mean) < 4 * rms / std::sqrt(static_cast<double>(sets.sets)) + 1e-4);
      }
    MESSAGE(directions << " directions under a clear sky: worst rms " << worst << " of the sky irradiance");
    CHECK(worst < (directions == 16 ? 0.06 : 0.003));
  }
}

TEST_CASE(
    "S16 sharing out: every direction is looked into by one part, parts are equally large, and each goes round the "
    "horizon") {
  for (const int directions : {16, 48, 96, 1024})
    for (const int share : {1, 2, 3, 4, 8, 16}) {
      if (directions % share != 0) continue;
      CAPTURE(directions);
      CAPTURE(share);
      std::vector<int> looked(static_cast<std::size_t>(directions), 0);
      const double golden = std::numbers::phi - 1;
      double farthest = 0;
      for (rc_u32 part = 0; part < rc_u32(share); ++part) {
        double x = 0, y = 0;
        for (rc_u32 j = 0; j < rc_u32(directions / share); ++j) {
          const rc_u32 k = rc_sky_direction(part, j, rc_u32(share));
          REQUIRE(k < rc_u32(directions));
          ++looked[k];
          x += std::cos(2 * kPi * k * golden) * share / directions,
              y += std::sin(2 * kPi * k * golden) * share / directions;
        }
        farthest = std::max(farthest, std::hypot(x, y));
      }
      CHECK(std::count(looked.begin(), looked.end(), 1) == directions);
      if (directions / share >= 6) CHECK(farthest < 0.35);  // 1: all in one azimuth; every eighth of 48 gives 0.8
    }
  // Samples: as evenly as can be, and all parts in any 16 neighbours.
  for (const rc_u32 share : {2u, 4u, 8u, 16u})
    for (rc_u32 pixel = 0; pixel < 50; ++pixel) {
      std::vector<int> samples(share, 0);
      for (rc_u32 s = 0; s < 121; ++s) ++samples[rc_sky_part(5, pixel, s, share)];
      CHECK(*std::max_element(samples.begin(), samples.end()) - *std::min_element(samples.begin(), samples.end()) <= 1);
    }
}

TEST_CASE("S16 the share by rule: a power of two that divides the directions and leaves each of them 8 samples") {
  CHECK(plan::sky_share(0, 121, 48) == 8);
  CHECK(plan::sky_share(0, 128, 48) == 16);
  CHECK(plan::sky_share(0, 16, 48) == 2);
  CHECK(plan::sky_share(0, 15, 48) == 1);
  CHECK(plan::sky_share(0, 1024, 12) == 4);
  CHECK(plan::sky_share(0, 1024, 5) == 1);
  CHECK(plan::sky_share(3, 1, 48) == 3);
  CHECK_THROWS(plan::sky_share(5, 100, 48));
}

TEST_CASE("S16 direction sets are unit, above the horizon, finite, and sum to the irradiance of tilted planes") {
  const auto table = clear_sky(40);
  const auto factors = factors_of(table, 3);
  const double sun_azimuth = 2.0;
  const plan::SkyIrradiance exact(factors.basis);
  for (const int directions : {1, 16, 100, 4096}) {
    const auto sets = plan::make_sky_sets(factors.basis, sun_azimuth, directions, 9);
    std::array<double, 3> tilted{}, tilted_squares{}, level{}, level_squares{};
    const double tilt = 1.0, psi = 0.5, x = std::sin(tilt) * std::sin(sun_azimuth + psi),
                 y = std::sin(tilt) * std::cos(sun_azimuth + psi), z = std::cos(tilt);
    for (int set = 0; set < sets.sets; ++set) {
      std::array<double, 3> one_tilted{}, one_level{};
      for (int k = 0; k < directions; ++k) {
        const auto i = static_cast<std::size_t>(set * directions + k);
        const auto& d = sets.direction[i];
        const double length = std::sqrt(double{d.x} * d.x + double{d.y} * d.y + double{d.z} * d.z);
        REQUIRE(std::abs(length - 1) < 1e-6);
        REQUIRE(d.z > 0);
        const std::array<double, 3> w = {sets.weight[i].x, sets.weight[i].y, sets.weight[i].z};
        for (std::size_t m = 0; m < 3; ++m) {
          REQUIRE(std::isfinite(w[m]));
          one_tilted[m] += w[m] * std::max(0.0, x * d.x + y * d.y + z * d.z);
          one_level[m] += w[m] * d.z;
        }
      }
      for (std::size_t m = 0; m < 3; ++m) {
        tilted[m] += one_tilted[m] / sets.sets;
        level[m] += one_level[m] / sets.sets;
        tilted_squares[m] += one_tilted[m] * one_tilted[m] / sets.sets;
        level_squares[m] += one_level[m] * one_level[m] / sets.sets;
      }
    }
    // four standard errors of independent sets; the sets are better than independent. 1e-6: float weights
    const auto want = exact.at(tilt, psi), flat = exact.at(0, 0);
    for (std::size_t m = 0; m < 3; ++m) {
      CHECK(std::abs(tilted[m] - want[m]) <
            4 * std::sqrt(std::max(0.0, tilted_squares[m] - tilted[m] * tilted[m]) / sets.sets) + 1e-6);
      CHECK(std::abs(level[m] - flat[m]) <
            4 * std::sqrt(std::max(0.0, level_squares[m] - level[m] * level[m]) / sets.sets) + 1e-6);
    }
  }
}
