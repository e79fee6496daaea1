// Aerosols of the user's own. Oracles: Angstrom's law, Henyey-Greenstein's moments, integrals in closed form, Mie's
// series summed directly.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "atmos_tables/aerosol/aerosol_column.h"
#include "atmos_tables/aerosol/own_aerosol.h"
#include "atmos_tables/optics/profile_scaling.h"
#include "atmos_tables/optics/sphere_cloud.h"
#include "atmos_tables/optics/standard_air.h"
#include "host/base/error.h"
#include "tests/support/refusal.h"

using namespace raycube;
using namespace raycube::atmos;
using raycube::testing::refusal;

namespace {

scene::OwnAerosolSpec stated() {
  scene::OwnAerosolSpec own;
  own.name = "smoke";
  own.optical_depth = 0.3;
  own.angstrom = 1.5, own.single_scattering_albedo = {0.9}, own.asymmetry = {0.65};
  return own;
}

AerosolColumn column_of(const scene::OwnAerosolSpec& own, double ground_km = 0) {
  AerosolSpec spec;
  spec.boundary = AerosolModel::none;
  spec.own = {own};
  return AerosolColumn(spec, cut_at_ground(afgl_profile(AfglModel::us_standard), ground_km));
}

std::vector<double> powers(double g, std::size_t count) {
  std::vector<double> out;
  for (std::size_t k = 0; k < count; ++k) out.push_back(std::pow(g, static_cast<double>(k)));
  return out;
}

bool says(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST_CASE("S4.5 own aerosol: depths follow Angstrom's law from the wavelength where one is stated") {
  scene::OwnAerosolSpec own = stated();
  own.at_um = 0.44;
  const AerosolColumn column = column_of(own);
  REQUIRE(column.components() == 1);
  for (double um : {0.3, 0.44, 0.55, 1.02, 2.2, 10.0}) {
    const double depth = column.depth_550(0, 0, 100) * column.optics(0, um).extinction_ratio;
    CHECK(depth == doctest::Approx(0.3 * std::pow(um / 0.44, -1.5)).epsilon(1e-12));
  }
  CHECK(column.aod_550() == doctest::Approx(0.3 * std::pow(0.55 / 0.44, -1.5)).epsilon(1e-12));
  CHECK(column.optics(0, 0.7).scattering_albedo == doctest::Approx(0.9).epsilon(1e-14));
  // Henyey & Greenstein (1941): chi_l = g^l.
  const std::vector<double> chi = column.optics(0, 0.7).phase->moments(20);
  for (std::size_t l = 0; l <= 20; ++l) CHECK(chi[l] == doctest::Approx(std::pow(0.65, l)).epsilon(1e-12));
}

TEST_CASE("S4.5 own aerosol: a table of optics is met at its wavelengths, power law and straight lines between") {
  scene::OwnAerosolSpec own = stated();
  own.wavelength_um = {0.4, 0.5, 0.8};
  own.extinction = {7, 5, 2};  // any unit
  own.single_scattering_albedo = {0.9, 0.92, 0.98};
  own.asymmetry = {0.7, 0.68, 0.6};
  const AerosolColumn column = column_of(own);
  CHECK(column.optics(0, 0.4).extinction_ratio / column.optics(0, 0.8).extinction_ratio == doctest::Approx(3.5));
  CHECK(column.optics(0, 0.55).extinction_ratio == doctest::Approx(1).epsilon(1e-14));
  const double exponent = std::log(5.0 / 2) / std::log(0.8 / 0.5);
  CHECK(column.optics(0, 0.65).extinction_ratio == doctest::Approx(std::pow(0.65 / 0.55, -exponent)).epsilon(1e-12));
  CHECK(column.optics(0, 0.45).scattering_albedo == doctest::Approx(0.91).epsilon(1e-12));
  CHECK(column.optics(0, 0.65).asymmetry == doctest::Approx(0.64).epsilon(1e-12));
  CHECK(column.optics(0, 0.65).phase->asymmetry() == doctest::Approx(0.64).epsilon(1e-12));
  CHECK(
      says(refusal([&] { column.optics(0, 0.9); }), "aerosol 'smoke': its optics cover 0.4 to 0.8 um (found 0.9 um)"));
  CHECK(says(refusal([&] { column.check_covers(0.35, 0.7); }), "cover 0.4 to 0.8 um, and the table more"));
  CHECK_NOTHROW(column.check_covers(0.4, 0.8));
}

TEST_CASE("S4.5 own aerosol: moments make the phase function whose moments they are") {
  // Those of Henyey-Greenstein, whose closed form is known; 0.6^64 (2 64 + 1) = 8e-13.
  scene::OwnAerosolSpec own = stated();
  own.asymmetry.clear(), own.phase_moments = {powers(0.6, 64)};
  const AerosolColumn column = column_of(own);
  const auto at = column.optics(0, 0.55);
  CHECK(at.asymmetry == doctest::Approx(0.6).epsilon(1e-14));
  for (double cosine : {-1.0, -0.3, 0.0, 0.8, 1.0})
    CHECK(at.phase->value(cosine) ==
          doctest::Approx((1 - 0.36) / std::pow(1 + 0.36 - 1.2 * cosine, 1.5)).epsilon(1e-9));
  CHECK(at.phase->moments(100)[63] == doctest::Approx(std::pow(0.6, 63)).epsilon(1e-12));
  CHECK(at.phase->moments(100)[64] == 0);
  // Between wavelengths moments are linear.
  own.wavelength_um = {0.5, 0.6};
  own.phase_moments = {{1, 0.4, 0.2}, {1, 0.5, 0.25, 0.1}};
  const std::vector<double> mixed = column_of(own).optics(0, 0.55).phase->moments(4);
  const double expected[] = {1, 0.45, 0.225, 0.05, 0};
  for (std::size_t k = 0; k < 5; ++k) CHECK(mixed[k] == doctest::Approx(expected[k]).epsilon(1e-12));
}

TEST_CASE("S4.5 own aerosol: exponential and stated heights carry the depth above the ground, wherever that lies") {
  for (double ground_km : {0.0, 1.3}) {
    CAPTURE(ground_km);
    scene::OwnAerosolSpec own = stated();
    own.scale_height_km = 1.7;
    const AerosolColumn falling = column_of(own, ground_km);
    CHECK(falling.depth_550(0, ground_km, 100) == doctest::Approx(0.3).epsilon(1e-12));
    // exp(-30) of it is left out above 30 scale heights.
    for (double height_km : {0.2, 1.0, 5.0, 20.0})
      CHECK(falling.depth_550(0, ground_km, ground_km + height_km) ==
            doctest::Approx(0.3 * -std::expm1(-height_km / 1.7)).epsilon(1e-9));
    own.height_km = {0, 2, 3}, own.height_extinction = {4, 4, 0};  // a slab that ends linearly
    const AerosolColumn slab = column_of(own, ground_km);
    const double area = 4 * (2 - ground_km) + 2;
    CHECK(slab.depth_550(0, ground_km, 100) == doctest::Approx(0.3).epsilon(1e-12));
    CHECK(slab.depth_550(0, 2.5, 3) == doctest::Approx(0.3 * 0.5 / area).epsilon(1e-12));
    CHECK(slab.extinction_550_per_km(0, 3.1) == 0);
  }
  scene::OwnAerosolSpec own = stated();
  own.height_km = {0, 0.5}, own.height_extinction = {1, 1};
  CHECK(says(refusal([&] { column_of(own, 0.8); }), "none of its extinction_profile lies between the ground, 0.8 km"));
}

TEST_CASE("S4.5 own aerosol: spheres of two lognormal modes have the optics of Mie's series summed directly") {
  scene::OwnAerosolSpec own;
  own.optical_depth = 0.2;
  own.refractive_n = {1.5}, own.refractive_k = {0.01};
  own.median_radius_um = {0.06, 0.5}, own.geometric_sigma = {1.7, 1.9}, own.number_share = {0.999, 0.001};
  const AerosolColumn column = column_of(own);
  const SizeDistribution sizes = SizeDistribution::lognormal({{0.999, 0.06, 1.7}, {0.001, 0.5, 1.9}});
  SphereCloudRequest request;
  request.index = {1.5, 0.01}, request.tolerance = 1e-5, request.last_moment = 16;
  request.wavelength_um = 0.55;
  const double unit = integrate_spheres(sizes, request).extinction_um2;
  for (double um : {0.47, 0.86, 1.61}) {  // between the nodes of the program's own sums, a factor of 1.1 apart
    CAPTURE(um);
    request.wavelength_um = um;
    const SphereCloudOptics exact = integrate_spheres(sizes, request);
    const auto at = column.optics(0, um);
    CHECK(at.extinction_ratio == doctest::Approx(exact.extinction_um2 / unit).epsilon(2e-3));
    CHECK(at.scattering_albedo == doctest::Approx(exact.single_scattering_albedo).epsilon(1e-3));
    CHECK(at.asymmetry == doctest::Approx(exact.asymmetry).epsilon(2e-3));
    const std::vector<double> chi = at.phase->moments(16);
    for (std::size_t k = 0; k <= 16; ++k) CHECK(std::abs(chi[k] - exact.moments[k]) < 3e-3);
  }
  CHECK(says(refusal([&] { column.check_covers(0.3, 50); }), "cover 0.2 to 40 um"));
}

TEST_CASE("S4.5 own aerosol: what physics forbids is refused by name") {
  scene::OwnAerosolSpec own = stated();
  own.asymmetry.clear();
  own.phase_moments = {{1, 0.9, 0.3}};
  CHECK(says(refusal([&] { column_of(own); }), "aerosol 'smoke': its moments make a phase function that is negative"));
  own.phase_moments = {{3, 0.9, 0.3}};
  CHECK(says(refusal([&] { column_of(own); }), "chi_0, must be 1 (found 3)"));
  own = stated();
  own.wavelength_um = {0.6, 0.8}, own.single_scattering_albedo = {0.9, 0.9};
  CHECK(says(refusal([&] { column_of(own); }), "must cover 0.55 um"));
  AerosolSpec twice;
  twice.boundary = AerosolModel::none;
  twice.own = {stated(), stated()};
  CHECK(says(refusal([&] { AerosolColumn(twice, afgl_profile(AfglModel::us_standard)); }), "another component"));
}
