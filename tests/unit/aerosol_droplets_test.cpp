// A user's own spheres. Oracles: the series' exact moments, geometric optics, the measured lidar ratio of water clouds.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "atmos_tables/aerosol/aerosol_column.h"
#include "atmos_tables/optics/size_distribution.h"
#include "atmos_tables/optics/sphere_cloud.h"
#include "atmos_tables/optics/standard_air.h"
#include "host/base/error.h"

using namespace raycube;
using namespace raycube::atmos;

TEST_CASE("S4.5 droplets: a layer of cloud C.1 by Mie has the series' own moments, albedo and backscatter") {
  AerosolSpec spec;
  spec.boundary = AerosolModel::none;
  CloudLayer cloud{0.5, 0.8, 3, CloudKind::stratus,
                   DropletModel{6, 1.5, 1, {{0.5, 1.335, 0}, {0.7, 1.331, 0}, {1.064, 1.326, 1e-5}}}};
  spec.clouds = {cloud};
  const AirProfile air = afgl_profile(AfglModel::midlatitude_summer);
  const AerosolColumn column(spec, air);
  REQUIRE(column.components() == 1);
  CHECK(column.depth_550(0, 0, 5) == doctest::Approx(3).epsilon(1e-12));

  SphereCloudRequest request;
  request.wavelength_um = 0.7, request.index = {1.331, 0}, request.tolerance = 1e-4, request.last_moment = 64;
  const SphereCloudOptics exact = integrate_spheres(SizeDistribution::modified_gamma(6, 1.5, 1), request);
  const AerosolColumn::Optics at = column.optics(0, 0.7);
  const std::vector<double> moments = at.phase->moments(64);
  double worst = 0;
  for (std::size_t k = 0; k <= 64; ++k) worst = std::max(worst, std::abs(moments[k] - exact.moments[k]));
  MESSAGE("largest miss of 64 moments " << worst);
  CHECK(worst <= 2e-3);  // the sum over sizes is good to 1e-3, and so is the cubic between its angles
  CHECK(at.asymmetry == doctest::Approx(exact.asymmetry).epsilon(1e-3));
  CHECK(at.scattering_albedo == doctest::Approx(1).epsilon(1e-9));
  CHECK(column.optics(0, 1.064).scattering_albedo < 1 - 1e-4);
  CHECK(at.extinction_ratio ==
        doctest::Approx(1).epsilon(0.03));  // large spheres block twice their shadow at any wavelength
  // O'Connor et al. (2004): 18.8 sr at 0.532 um for droplets of 5 to 50 um; C.1's are smaller.
  CHECK(std::abs(column.optics(0, 0.532).extinction_ratio / column.backscatter_per_sr(0, 0.532) - 18.8) <= 3);

  CHECK_THROWS_AS(column.optics(0, 2.0), base::Error);
  spec.clouds[0].droplets->index = {{0.7, 1.33, 0}, {0.6, -1, 0}};
  std::string found;
  try {
    AerosolColumn(spec, air);
  } catch (const base::Error& error) {
    found = error.what();
  }
  CHECK(found.find("row 2") != std::string::npos);
  CHECK(found.find("cover 0.55") != std::string::npos);
}
