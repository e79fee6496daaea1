// View zeniths of one's own: a node's value is the direction's, whatever the other nodes are; more nodes, less error.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "atmos_tables/clear_sky.h"
#include "atmos_tables/compiler/layered_air.h"
#include "atmos_tables/interpolate.h"
#include "host/base/error.h"
#include "tests/support/refusal.h"

using namespace raycube;
using namespace raycube::atmos;
using raycube::testing::refusal;

namespace {

const std::vector<double> kBands_um = {0.45, 0.865, 3.9};

RenderTable table_of(bool layered, const std::vector<double>& view_zenith_deg) {
  scene::AtmosphereSpec spec;
  if (layered) spec.layered.emplace();
  spec.view_zenith_deg = view_zenith_deg;
  scene::Sun sun;
  sun.zenith_deg = 50;
  return layered ? build_layered(spec, sun, 3000, kBands_um, {0}) : build_clear_sky(spec, sun, 3000, kBands_um, {0});
}

/// The largest relative error of path radiance between nodes, over two azimuths, against tables with a node there.
double error_between(bool layered, const std::vector<double>& nodes) {
  const RenderTable table = table_of(layered, nodes);
  double worst = 0;
  for (double zenith : {13.0, 27.0, 52.0, 67.0}) {
    const RenderTable exact = table_of(layered, {0, zenith});
    for (double azimuth : {30.0, 150.0}) {
      const auto found = path_radiance(table, 0, zenith, azimuth), right = path_radiance(exact, 0, zenith, azimuth);
      for (std::size_t i = 0; i < found.size(); ++i) worst = std::max(worst, std::abs(found[i] / right[i] - 1));
    }
  }
  return worst;
}

}  // namespace

TEST_CASE("S18 view zeniths: what is asked for is there, and a node's value does not know of the others") {
  for (bool layered : {true, false}) {
    CAPTURE(layered);
    const RenderTable standing = table_of(layered, {}), asked = table_of(layered, {0, 20, 47.5, 60});
    CHECK(asked.axis("view_zenith").nodes == std::vector<double>{0, 20, 47.5, 60});
    for (double zenith : {0.0, 20.0, 60.0}) {
      CAPTURE(zenith);
      CHECK(view_transmission(asked, 0, zenith) == view_transmission(standing, 0, zenith));
      CHECK(path_radiance(asked, 0, zenith, 60) == path_radiance(standing, 0, zenith, 60));
      if (!layered) continue;
      CHECK(path_radiance_thermal(asked, 0, zenith) == path_radiance_thermal(standing, 0, zenith));
      CHECK(diffuse_view_transmission(asked, 0, zenith) == diffuse_view_transmission(standing, 0, zenith));
    }
    CHECK(sky_radiance(asked, 0, 33, 60) == sky_radiance(standing, 0, 33, 60));
  }
}

TEST_CASE("S18 view zeniths: the error between nodes falls as nodes are added") {
  for (bool layered : {true, false}) {
    CAPTURE(layered);
    const double coarse = error_between(layered, {0, 40, 80}), middle = error_between(layered, {0, 20, 40, 60, 80}),
                 fine = error_between(layered, {0, 10, 20, 30, 40, 50, 60, 70, 80});
    MESSAGE("largest error of path radiance: " << coarse << ", " << middle << ", " << fine);
    // Straight lines: a quarter at half the distance where nodes are close; less so where a glory lies between them.
    CHECK(middle < 0.7 * coarse);
    CHECK(fine < 0.7 * middle);
  }
}

TEST_CASE("S18 view zeniths: bad lists are refused with their value") {
  for (bool layered : {true, false}) {
    CHECK(refusal([&] { table_of(layered, {30}); }).find("must be two or more") != std::string::npos);
    CHECK(refusal([&] { table_of(layered, {0, 40, 20}); }).find("40.0 then 20.0") != std::string::npos);
    CHECK(refusal([&] {
            table_of(layered, {0, 90});
          }).find("must lie in 0 to 89.9 deg (found 90.0") != std::string::npos);
    CHECK(refusal([&] { table_of(layered, {-1, 40}); }).find("found -1.0") != std::string::npos);
  }
}
