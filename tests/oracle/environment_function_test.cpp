// The environment functions (S4.9) against their published figures, the laws they must keep, and single scattering
// integrated here along the line of sight; the molecules' share of the diffuse transmission against exact first-order
// scattering.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "atmos_tables/environment_function.h"
#include "atmos_tables/interpolate.h"
#include "atmos_tables/rayleigh.h"
#include "atmos_tables/synthetic.h"
#include "host/base/error.h"

namespace {

using namespace raycube::atmos;
constexpr double kPi = std::numbers::pi;

/// Light of a Lambertian ground within `radius` that air of one density under `height` scatters into a nadir path, by
/// Simpson's rule: ground at r lights the air at z by cos dA / d^2, which turns by the angle of cos = z / d.
template <class Phase>
double scattered(double radius, double height, Phase phase) {
  constexpr int n = 400;
  double sum = 0;
  for (int i = 0; i < n; ++i) {
    const double z = height * (i + 0.5) / n;
    double inner = 0;  // over c = z / d, from 1 (below) to the edge of the disc: r dr z / d^3 = -dc
    const double edge = z / std::hypot(radius, z);
    constexpr int m = 200;
    for (int k = 0; k <= m; ++k) inner += (k == 0 || k == m ? 1 : k % 2 ? 4 : 2) * phase(edge + (1 - edge) * k / m);
    sum += inner * (1 - edge) / (3 * m) * height / n;
  }
  return sum;
}

}  // namespace

TEST_CASE("S4.9 environment functions: the published figures at their nodes, between and beyond them") {
  // 6S user guide, ENVIRO: sensor above the air, r = 1 and 5 km (last node of its table).
  const auto air = [](double r) { return environment_function(Scatterer::aerosol, r, 100, 1); };
  const auto molecules = [](double r) { return environment_function(Scatterer::molecules, r, 100, 1); };
  for (const double r : {0.1, 1.0, 5.0, 20.0}) {
    CHECK(air(r) == doctest::Approx(1 - 0.448 * std::exp(-0.27 * r) - 0.552 * std::exp(-2.83 * r)).epsilon(1e-12));
    CHECK(molecules(r) ==
          doctest::Approx(1 - 0.070 * std::exp(-0.868 * r) - 0.93 * std::exp(-0.08 * r)).epsilon(1e-12));
  }
  CHECK(environment_function(Scatterer::molecules, 1, 1.5, 1) ==
        doctest::Approx(1 - 0.683 * std::exp(-1.1775) - 0.317 * std::exp(-0.08)).epsilon(1e-12));
  // Below 0.5 km one length is left: the height.
  CHECK(environment_function(Scatterer::aerosol, 0.02, 0.1, 1) ==
        doctest::Approx(environment_function(Scatterer::aerosol, 0.1, 0.5, 1)));
}

TEST_CASE("S4.9 environment functions rise from 0 to 1 at every height and view, and their radii invert them") {
  for (const Scatterer s : {Scatterer::molecules, Scatterer::aerosol})
    for (const double height : {0.01, 0.3, 0.61, 1.4, 3.0, 9.0, 30.0, 700.0})
      for (const double view_deg : {0.0, 20.0, 40.0, 60.0}) {
        const double mu = std::cos(view_deg * kPi / 180);
        double last = environment_function(s, 0, height, mu);
        CHECK(last == 0);
        for (double r = 1e-4; r < 300; r *= 1.05) {
          const double f = environment_function(s, r, height, mu);
          CHECK_MESSAGE(f >= last - 1e-12, "height " << height << " km, view " << view_deg << " deg, r " << r << " km");
          last = f;
        }
        CHECK(last == doctest::Approx(1).epsilon(1e-6));
        for (const double share : {0.01, 0.3, 0.9})
          CHECK(environment_function(s, environment_radius_km(s, share, height, mu), height, mu) ==
                doctest::Approx(share).epsilon(1e-9));
      }
}

TEST_CASE(
    "S4.9 the molecules' environment function lies below single scattering of a nadir path at 0.5 km, by at most "
    "0.14") {
  // Light scattered more than once comes from farther away, so that single scattering bounds F from above: the fit's
  // second exponential (0.08 per km) is that light, a tenth of all from beyond 2 km. Aerosol scatters forward, which
  // draws F in.
  const auto phase = [](double c) { return phase_rayleigh(0.0283, c); };
  const double all = scattered(1e6, 0.5, phase);
  for (const double r : {0.05, 0.1, 0.2, 0.4, 0.8, 2.0}) {
    const double share = scattered(r, 0.5, phase) / all, fit = environment_function(Scatterer::molecules, r, 0.5, 1);
    MESSAGE("r " << r << " km: single scattering " << share << ", molecules " << fit << ", aerosol "
                 << environment_function(Scatterer::aerosol, r, 0.5, 1));
    CHECK(fit < share);
    CHECK(share - fit < 0.14);
    CHECK(environment_function(Scatterer::aerosol, r, 0.5, 1) > fit);
  }
}

TEST_CASE("S4.9 molecular diffuse transmission: first order in thin air, none without air, energy below 1") {
  // Isotropic upward radiance 1 scattered once into a vertical path of depth tau from below: half of tau (the phase
  // function is symmetric), minus nothing yet lost.
  const double t = molecular_diffuse_transmission(2.0, 1013.25, 0, 1000, 1);
  const double depth = rayleigh_depth(2.0, 1013.25) * (1 - std::exp(-1.0 / 8));
  CHECK(t == doctest::Approx(depth / 2).epsilon(1e-4));  // next order: tau^2
  CHECK(molecular_diffuse_transmission(0.4, 1013.25, 500, 500, 1) == 0);
  CHECK(molecular_diffuse_transmission(0.4, 1013.25, 900, 500, 1) == 0);
  for (const double mu : {0.3, 0.7, 1.0}) {
    const double blue = molecular_diffuse_transmission(0.35, 1013.25, 0, 1e5, mu);
    CHECK(blue > 0);
    CHECK(blue + std::exp(-rayleigh_depth(0.35, 1013.25) / mu) < 1);
  }
}

TEST_CASE("S5.1 S, T_dif and t are read linearly; a table without them says so by name") {
  UniformAir air;
  CHECK(!has_ground_coupling(uniform_table(air, {0.4, 0.5})));
  CHECK_THROWS_WITH_AS(spherical_albedo(uniform_table(air, {0.4, 0.5}), 0), doctest::Contains("spherical_albedo"),
                       raycube::base::Error);
  air.spherical_albedo = [](double) { return 0.25; };
  air.diffuse_view_transmission = [](double um) { return um; };
  air.diffuse_return = [](double) { return 0.25; };
  RenderTable table = uniform_table(air, {0.4, 0.5});
  CHECK(has_ground_coupling(table));
  CHECK(diffuse_view_transmission(table, 100, 30)[1] == doctest::Approx(0.5));
  table.axes.at("sky_zenith").nodes = {0, 60};
  auto& row = table.rows.at("diffuse_return");
  row.values = {0.2f, 0.4f, 0.1f, 0.1f};
  CHECK(diffuse_return(table, 0, 15)[0] == doctest::Approx(0.25));
  CHECK(spherical_albedo(table, 0)[0] == doctest::Approx(0.25));
}
