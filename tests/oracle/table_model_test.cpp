// The reference on the full tables: closed forms with uniform air, and the built-in sky against its own irradiance row.
#include <doctest/doctest.h>

#include "atmos_tables/clear_sky.h"
#include "atmos_tables/interpolate.h"
#include "atmos_tables/synthetic.h"
#include "host/reference/radiance.h"
#include "tests/oracle/reference_plan.h"
#include "tests/oracle/reference_scene.h"

using namespace raycube;
using namespace raycube::reference;
using namespace raycube::test;
using doctest::Approx;

namespace {

scene::CompiledScene plane_scene(double tilt_rad, float z, bool wall) {
  SceneBuilder builder;
  const std::uint32_t surface = builder.material("grey", {0.3, 1.0}, {0.5, 0.5});
  std::vector<Triangle> list;
  const glm::vec3 along(static_cast<float>(std::cos(tilt_rad)), 0, static_cast<float>(-std::sin(tilt_rad)));
  add_quad(list, -50.0f * along - glm::vec3(0, 60, -z), 100.0f * along, {0, 100, 0}, surface);
  if (wall) add_quad(list, {2, -20, z}, {0, 40, 0}, {0, 0, 3}, surface);
  builder.instance(builder.mesh(list));
  return builder.finish();
}

BandRadiance render(const scene::CompiledScene& compiled, const plan::Plan& plan, const atmos::RenderTable& table,
                    bool no_air, const NadirPixel& at) {
  const ReferenceScene scene(compiled);
  const TableModel model(scene, plan, table, no_air);
  return model.radiance(scene.sample_pixel(at.instrument, plan, 1, at.address));
}

}  // namespace

TEST_CASE("S15 S16: tilted plane in uniform air: sun, sky and path from the tables") {
  atmos::UniformAir air;
  air.solar_irradiance = [](double) { return 1500.0; };
  air.sun_transmission = [](double) { return 0.7; };
  air.view_transmission = [](double um) { return 0.5 + 0.5 * um; };
  air.two_way_factor = [](double) { return 1.1; };
  air.sky_radiance = [](double) { return 80.0; };
  air.path_radiance = [](double um) { return 10 * um; };
  const atmos::RenderTable table = atmos::uniform_table(air, {0.4, 0.5, 0.6, 0.7, 0.8});
  for (double tilt : {0.0, 0.6}) {
    const BandRadiance l =
        render(plane_scene(tilt, 0, false), sun_plan(30, 90), table, false, nadir_pixel(0, 0, 100, 1, 2));
    const double through = (0.5 + 0.5 * 0.5) * 1.1;  // band centre 0.5 um, all linear in wavelength
    CHECK(l.sun[0] == Approx(0.5 / kPi * 1500 * 0.7 * through * std::cos(tilt - 30 * kPi / 180)).epsilon(2e-6));
    // 1024 directions of equal solid angle: the horizon's edge costs 1024^-3/4 / 2 of what it holds.
    CHECK(l.sky[0] == Approx(0.5 * 80 * (1 + std::cos(tilt)) / 2 * through).epsilon(2e-3));
    CHECK(l.path[0] == Approx(5.0).epsilon(2e-6));
    CHECK(l.path[1] == Approx(7.0).epsilon(2e-6));
  }
}

TEST_CASE("S16: sky beside a wall from the tables, 1024 directions") {
  const atmos::RenderTable table = atmos::uniform_sky_table(1000, 50, {0.4, 0.5, 0.6, 0.7, 0.8});
  const double a = 3, b = 20, c = 2, s = std::sqrt(a * a + c * c);
  const double wall = 2 * (std::atan(b / c) - c / s * std::atan(b / s)) / (2 * kPi);
  const BandRadiance l =
      render(plane_scene(0, 0, true), sun_plan(30, 270), table, false, nadir_pixel(0, 0, 100, 0.001, 1));
  CHECK(l.sky[0] == Approx(0.5 * 50 * (1 - wall)).epsilon(5e-3));  // 1024^-3/4 = 5.5e-3 of the hemisphere at an edge
}

TEST_CASE("S18: open ground under the built-in sky sees the table's own diffuse and direct irradiance") {
  scene::AtmosphereSpec spec;
  scene::Sun sun;
  sun.zenith_deg = 40, sun.azimuth_deg = 160;
  const std::vector<double> grid = {0.4, 0.5, 0.6, 0.7, 0.8};
  const atmos::RenderTable table = atmos::build_clear_sky(spec, sun, 610, grid, {0, 30, 200});
  const double z = 30;
  const scene::CompiledScene scene = [&] {
    scene::CompiledScene out = plane_scene(0, static_cast<float>(z), false);
    out.lo[2] = out.hi[2] = static_cast<float>(z);
    return out;
  }();
  plan::Plan plan = sun_plan(40, 160);
  plan.bands = {{1, {1.0}}, {4, {1.0}}};  // the grid's own 0.5 and 0.8 um
  const BandRadiance l = render(scene, plan, table, false, nadir_pixel(0, 0, 610, 1, 1));
  const auto through = atmos::view_transmission(table, z, 0), factor = atmos::two_way_factor(table, z, 0);
  const auto diffuse = atmos::diffuse_irradiance(table, z), direct = atmos::direct_irradiance(table, z);
  const auto path = atmos::path_radiance(table, z, 0, 0);
  for (std::size_t b = 0; b < 2; ++b) {
    const std::size_t i = b == 0 ? 1 : 4;
    CHECK(l.sun[b] == Approx(0.5 / kPi * direct[i] * through[i] * factor[i]).epsilon(1e-5));
    CHECK(l.sky[b] == Approx(0.5 / kPi * diffuse[i] * through[i] * factor[i])
                          .epsilon(5e-3));  // the table's sky is scaled to this row
    CHECK(l.path[b] == Approx(path[i]).epsilon(1e-5));
  }
}

TEST_CASE("S63: no air: L = rho E0 cos / pi, no sky, no path") {
  scene::Sun sun;
  sun.zenith_deg = 30, sun.azimuth_deg = 90;
  const atmos::RenderTable table = atmos::vacuum_table(sun, 100, {0.4, 0.5, 0.6, 0.7, 0.8}, {0});
  for (bool no_air : {true, false}) {
    const BandRadiance l =
        render(plane_scene(0, 0, false), sun_plan(30, 90), table, no_air, nadir_pixel(0, 0, 100, 1, 2));
    const auto e0 = atmos::solar_irradiance(table);
    CHECK(l.sun[0] == Approx(0.5 / kPi * std::cos(30 * kPi / 180) * (e0[0] + 2 * e0[1] + e0[2]) / 4).epsilon(2e-6));
    CHECK(l.sky[0] == 0);
    CHECK(l.path[0] == 0);
  }
}
