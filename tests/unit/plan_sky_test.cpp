// The sky of a plan: its maps, their factors and their unoccluded irradiance, against closed forms and brute force.
#include <algorithm>
#include <cmath>
#include <numbers>

#include <doctest/doctest.h>

#include "atmos_tables/interpolate.h"
#include "atmos_tables/table_rows.h"
#include "host/plan/irradiance_map.h"
#include "host/plan/quadrature.h"
#include "host/plan/sky_factors.h"
#include "tests/support/skies.h"

using namespace raycube;
using test::clear_sky, test::factors_of, test::uniform_sky;

namespace {

constexpr double kPi = std::numbers::pi;

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
  const plan::IrradianceGrid grid(exact, 0.3, plan::kGridTilts.back());
  const auto map = plan::make_irradiance_map(grid, plan::kMapSizes.back());
  double worst = 0;
  for (int k = 0; k < 5000; ++k) {
    const double z = 1 - (2 * k + 1.0) / 5000, f = 2.39996 * k, r = std::sqrt(1 - z * z);
    worst = std::max(worst, std::abs(plan::read_map(map, r * std::sin(f), r * std::cos(f), z)[0] - (1 + z) / 2));
  }
  CHECK(worst < 5e-6);
  MESSAGE("worst difference " << worst << " of the horizontal irradiance");
}

TEST_CASE("planes of one tilt, together and one by one, and maps on any number of threads: the same bits") {
  const auto table = clear_sky(40);
  const plan::SkyIrradiance exact(factors_of(table, 4).basis);
  const std::vector<double> azimuth = {0.3, -2.9, 3.1, 0.0, kPi, 1.7, 6.0, 0.3};
  for (const double tilt : {0.0, 0.2, 1.1, kPi / 2, 1.9, 3.0, kPi}) {
    std::vector<std::array<double, 4>> together(azimuth.size());
    exact.at(tilt, azimuth, together);
    for (std::size_t i = 0; i < azimuth.size(); ++i) CHECK(together[i] == exact.at(tilt, azimuth[i]));
  }
  const auto one = plan::make_irradiance_map(plan::IrradianceGrid(exact, 0.3, 101, 1), 129, 1),
             three = plan::make_irradiance_map(plan::IrradianceGrid(exact, 0.3, 101, 3), 129, 3);
  REQUIRE(one.value.size() == three.value.size());
  for (std::size_t i = 0; i < one.value.size(); ++i)
    CHECK((one.value[i].x == three.value[i].x && one.value[i].y == three.value[i].y &&
           one.value[i].z == three.value[i].z && one.value[i].w == three.value[i].w));
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
  const plan::IrradianceGrid grid(exact, sun_azimuth, plan::kGridTilts.back());
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
  std::vector<double> grid(zenith.size() * azimuth.size() * count);
  air.sky_grid(17, zenith, azimuth, plan::Sky::solar, grid);
  for (std::size_t i = 0; i < zenith.size(); ++i)
    for (std::size_t j = 0; j < azimuth.size(); ++j) {
      const auto want = atmos::sky_radiance(table, 17, zenith[i] * 180 / kPi, azimuth[j] * 180 / kPi);
      for (std::size_t l = 0; l < count; ++l)
        CHECK(grid[(l * zenith.size() + i) * azimuth.size() + j] == doctest::Approx(want[l]).epsilon(1e-9));
    }
}

TEST_CASE("S16 S18 the maps' own light and the irradiance map are one function: 1e-4 over all normals, band by band") {
  // The light of the rays is the maps' own value in their direction; what is taken for granted is the irradiance map.
  // Here the former is summed over every cell of the maps by 4 x 4 squares of 2 x 2 Gauss points.
  constexpr int kNormals = 400, kSquares = 4;
  const double sun_azimuth = 160 * kPi / 180;
  const auto table = clear_sky(40);
  const auto factors = factors_of(table, 4);
  const plan::SkyIrradiance exact(factors.basis);
  const plan::IrradianceGrid grid(exact, sun_azimuth, plan::kGridTilts.back());
  const auto map = plan::make_irradiance_map(grid, plan::kMapSizes.back());
  std::vector<std::array<double, 4>> summed(kNormals, {0, 0, 0, 0});
  std::vector<std::array<double, 3>> normals;
  for (int k = 0; k < kNormals; ++k) {
    // Every fifth is a wall, every other spread evenly over the sphere: 160 look below the horizon.
    const double z = k % 5 == 0 ? 0.0 : 1 - (2 * k + 1.0) / kNormals, f = 2.39996 * k, r = std::sqrt(1 - z * z);
    normals.push_back({r * std::sin(f), r * std::cos(f), z});
  }
  const auto points = [&](const std::vector<double>& nodes) {  // place and width
    std::vector<std::array<double, 2>> out;
    for (std::size_t i = 0; i + 1 < nodes.size(); ++i)
      for (int square = 0; square < kSquares; ++square)
        for (const double at : {0.5 - std::sqrt(1.0 / 12), 0.5 + std::sqrt(1.0 / 12)}) {
          const double width = (nodes[i + 1] - nodes[i]) / kSquares;
          out.push_back({nodes[i] + (square + at) * width, 0.5 * width});
        }
    return out;
  };
  for (const auto& [zenith, zenith_width] : points(factors.basis.zenith_rad)) {
    std::vector<std::array<double, 7>> ring;  // direction, then light times solid angle
    for (const auto& [off, azimuth_width] : points(factors.basis.azimuth_rad))
      for (const double side : {1.0, -1.0}) {
        const double azimuth = sun_azimuth + side * off, each = std::sin(zenith) * zenith_width * azimuth_width;
        const double x = std::sin(zenith) * std::sin(azimuth), y = std::sin(zenith) * std::cos(azimuth);
        const auto light = plan::sky_value(factors.basis, sun_azimuth, x, y, std::cos(zenith));
        ring.push_back({x, y, std::cos(zenith), light[0] * each, light[1] * each, light[2] * each, light[3] * each});
      }
    for (std::size_t k = 0; k < normals.size(); ++k)
      for (const auto& from : ring) {
        const double facing = normals[k][0] * from[0] + normals[k][1] * from[1] + normals[k][2] * from[2];
        if (facing <= 0) continue;
        for (std::size_t m = 0; m < 4; ++m) summed[k][m] += facing * from[3 + m];
      }
  }
  std::vector<plan::Mixture> mixtures;
  for (std::size_t l = 0; l < factors.spectra[0].size(); ++l) mixtures.push_back(test::mixture_of(factors, l));
  double worst = 0, relative = 0, exactly = 0;
  for (std::size_t k = 0; k < normals.size(); ++k) {
    const auto& n = normals[k];
    const auto found = plan::read_map(map, n[0], n[1], n[2]);
    const auto want = exact.at(std::acos(n[2]), std::atan2(n[0], n[1]) - sun_azimuth);
    for (const auto& mixture : mixtures) {
      double apart = 0, here = 0, sum = 0;
      for (std::size_t m = 0; m < 4; ++m) {
        apart += mixture[m] * (summed[k][m] - found[m]), here += mixture[m] * (summed[k][m] - want[m]);
        sum += mixture[m] * summed[k][m];
      }
      worst = std::max(worst, std::abs(apart)), exactly = std::max(exactly, std::abs(here));
      if (n[2] >= 0) relative = std::max(relative, std::abs(apart / sum));
    }
  }
  MESSAGE("map off the maps' own sum by " << worst << " of the horizontal irradiance (the exact integral by " << exactly
                                          << "), at most " << relative << " of a wall's or roof's own");
  CHECK(worst < 1e-4);
  CHECK(relative < 1e-4);
  CHECK(exactly < 3e-5);
}
