// Scenes at the edge of what can be rendered (REQUIREMENTS section 4): nothing, one triangle, slivers, the inside of a
// box, UTM-sized origins, reflectance 0 and 1, path radiance alone. Oracles: closed forms, and equality with the plain
// case.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "atmos_tables/clear_sky.h"
#include "atmos_tables/synthetic.h"
#include "host/sensors/ray_groups.h"
#include "host/sensors/view_bounds.h"
#include "kernels/sampling/sampler.h"
#include "scene_compiler/load_simulation.h"
#include "host/render/truth.h"
#include "tests/support/chance_checks.h"
#include "tests/support/render_kit.h"
#include "tests/support/same_bytes.h"
#include "tests/unit/test_folder.h"

namespace {

using namespace raycube;
using raycube::test::same_bytes;
constexpr double kPi = std::numbers::pi;
constexpr double kSun = 1000, kSky = 30, kPath = 5;

/// Sun at the zenith, uniform sky, transmission 0.9 to the sensor, path radiance.
atmos::RenderTable hazy_table() {
  atmos::UniformAir air;
  air.solar_irradiance = [](double) { return kSun; };
  air.view_transmission = [](double) { return 0.9; };
  air.sky_radiance = [](double) { return kSky; };
  air.path_radiance = [](double) { return kPath; };
  return atmos::uniform_table(air, {0.3, 1.0, 4.0});
}
double plane_radiance(double reflectance) { return 0.9 * reflectance * (kSun / kPi + kSky) + kPath; }

scene::Simulation scene_of(const scene::TriangleMesh& mesh, scene::Simulation simulation) {
  if (!mesh.triangles.empty()) test::place(simulation.scene, mesh);
  finish_top_tree(simulation.scene);
  simulation.instruments = {test::nadir_camera(9, 7, 500, 1.0)};
  return simulation;
}

}  // namespace

TEST_CASE("S63 an empty scene shows path radiance alone; S17 truth says that nothing was hit") {
  for (const bool material : {true, false}) {
    scene::Simulation simulation;
    if (material) test::add_material(simulation.scene, "unused", 0.5);
    const auto image = test::render_image(scene_of({}, simulation), hazy_table());
    for (int line = 0; line < 7; ++line)
      for (int pixel = 0; pixel < 9; ++pixel) {
        for (int band = 0; band < image.bands; ++band)
          CHECK(image.at(line, pixel, band) == doctest::Approx(kPath).epsilon(1e-6));
        CHECK(image.layer(line, pixel, render::truth::material_id) == 0);
        CHECK(image.layer(line, pixel, render::truth::hit_fraction) == 0);
        CHECK(image.layer(line, pixel, render::truth::sun_fraction) == 0);
        for (const int layer : {3, 4, 5, 6, 11}) CHECK(std::isnan(image.layer(line, pixel, layer)));
      }
  }
}

TEST_CASE("S15 reflectance 0, tiny and 1: path radiance alone, and the closed form") {
  for (const double reflectance : {0.0, 1e-6, 1.0}) {
    scene::Simulation simulation;
    const auto surface = test::add_material(simulation.scene, "m", reflectance);
    const auto image = test::render_image(
        scene_of(test::rectangle({-50, -50, 0}, {100, 0, 0}, {0, 100, 0}, surface), simulation), hazy_table());
    for (const float l : image.radiance) CHECK(l == doctest::Approx(plane_radiance(reflectance)).epsilon(1e-6));
  }
}

TEST_CASE("S63 a scene of one triangle: hit fraction and radiance by counting samples in double") {
  scene::Simulation simulation;
  const auto surface = test::add_material(simulation.scene, "m", 0.4);
  scene::TriangleMesh mesh;
  const std::array<float, 3> corner[3] = {{-3.1f, -2.3f, 0}, {3.7f, -0.6f, 0}, {-0.4f, 2.9f, 0}};
  mesh.vertices.assign(corner, corner + 3);
  mesh.triangles = {{0, 1, 2}};
  mesh.surface = {surface};
  mesh.user_face = {0};
  simulation = scene_of(mesh, simulation);
  simulation.instruments[0].samples_u = simulation.instruments[0].samples_v = 11;
  const auto image = test::render_image(simulation, hazy_table());
  int partly = 0;
  for (int line = 0; line < 7; ++line) {
    const auto groups = sensors::make_ray_groups(simulation.instruments[0], line, 1);
    for (int pixel = 0; pixel < 9; ++pixel) {
      const auto& g = groups[std::size_t(pixel) / RC_GROUP_WIDTH];
      int inside = 0, near = 0;
      for (int s = 0; s < 121; ++s) {
        float u, v;
        rc_sample_uv(RC_SAMPLER_GRID, 11, 11, 1.0f, 0u, 0u, s, &u, &v);
        const double a = pixel % RC_GROUP_WIDTH - 1.5 + u, dz = g.d0.z + a * g.du.z + v * g.dv.z, t = g.origin.z / -dz;
        const double x = t * (g.d0.x + a * g.du.x + v * g.dv.x), y = t * (g.d0.y + a * g.du.y + v * g.dv.y);
        double least = 1e9;
        for (int e = 0; e < 3; ++e) {
          const auto &p = corner[e], &q = corner[(e + 1) % 3];
          const double ex = double(q[0]) - p[0], ey = double(q[1]) - p[1];
          least = std::min(least, (ex * (y - p[1]) - ey * (x - p[0])) / std::hypot(ex, ey));
        }
        if (std::abs(least) < 1e-4)
          ++near;  // m: fp32 rays from 500 m
        else
          inside += least > 0;
      }
      const double hit = image.layer(line, pixel, render::truth::hit_fraction);
      CHECK(hit * 121 > inside - 1e-3);
      CHECK(hit * 121 < inside + near + 1e-3);
      CHECK(image.at(line, pixel, 0) == doctest::Approx(kPath + hit * (plane_radiance(0.4) - kPath)).epsilon(1e-6));
      partly += inside > 0 && inside < 121;
    }
  }
  CHECK(partly > 10);
}

TEST_CASE("S63 a plane cut into slivers of 1 to 100 000 shows the plane's radiance: no leak, no own shadow") {
  scene::Simulation simulation;
  const auto surface = test::add_material(simulation.scene, "m", 0.4);
  scene::TriangleMesh mesh;
  constexpr int kStrips = 20000;  // 1 mm wide, 100 m long, two triangles each
  for (int i = 0; i <= kStrips; ++i)
    for (const float y : {-50.0f, 50.0f}) mesh.vertices.push_back({float(i * 1e-3 - 10), y, 0});
  for (std::uint32_t i = 0; i < kStrips; ++i) {
    mesh.triangles.push_back({2 * i, 2 * i + 2, 2 * i + 3});
    mesh.triangles.push_back({2 * i, 2 * i + 3, 2 * i + 1});
  }
  mesh.surface.assign(mesh.triangles.size(), surface);
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) mesh.user_face.push_back(i);
  simulation = scene_of(mesh, simulation);
  simulation.instruments[0].samples_u = simulation.instruments[0].samples_v = 11;
  const auto image = test::render_image(simulation, hazy_table());
  for (int line = 0; line < 7; ++line)
    for (int pixel = 0; pixel < 9; ++pixel) {
      CHECK(image.layer(line, pixel, render::truth::hit_fraction) == 1);
      CHECK(image.layer(line, pixel, render::truth::sun_fraction) == 1);
      CHECK(image.at(line, pixel, 0) == doctest::Approx(plane_radiance(0.4)).epsilon(1e-6));
    }
}

TEST_CASE("S63 sensor inside a closed box: no sun at all, no sky within 4 standard errors, path radiance stays") {
  scene::Simulation simulation;
  const auto surface = test::add_material(simulation.scene, "m", 0.5);
  simulation = scene_of(test::box({-20, -15, -1}, {20, 15, 30}, surface), simulation);
  auto& camera = simulation.instruments[0];
  camera = test::nadir_camera(32, 20, 25, 0.7);
  camera.samples_u = camera.samples_v = 2;
  const auto image = test::render_image(simulation, hazy_table());
  const double open = 0.9 * 0.5 * kSky;
  double sum = 0, square = 0;
  for (int line = 0; line < 20; ++line)
    for (int pixel = 0; pixel < 32; ++pixel) {
      CHECK(image.layer(line, pixel, render::truth::hit_fraction) == 1);
      CHECK(image.layer(line, pixel, render::truth::sun_fraction) == 0);
      CHECK(image.layer(line, pixel, render::truth::z_m) == doctest::Approx(-1).epsilon(1e-5));
      const double sky =
          (image.at(line, pixel, 0) - kPath) / open;  // share of the open sky: all 16 directions are subtracted
      sum += sky;
      square += sky * sky;
    }
  const double mean = sum / 640, rms = std::sqrt(square / 640), error = std::sqrt((square / 640 - mean * mean) / 639);
  MESSAGE("sky inside the box: mean " << mean << ", standard error " << error << ", rms " << rms << " of the open sky");
  CHECK_WITHIN(mean, 4 * error + 1e-7);  // radiances are floats, 6e-8 of them
  CHECK_BELOW(rms, 0.06);  // S16's bound for 16 directions
}

TEST_CASE("S63 the same terrain at UTM northing 4.7e6 m and at the origin gives the same bytes") {
  testing::TestFolder folder;
  std::string heights;
  for (int j = 0; j < 40; ++j) {
    for (int i = 0; i < 40; ++i) heights += std::to_string(3 * std::sin(0.3 * i) * std::cos(0.2 * j)) + " ";
    heights += "\n";
  }
  const auto scene_at = [&](const std::string& name, double easting, double northing, const std::string& corner_x,
                            const std::string& corner_y) {
    folder.write(name + ".asc",
                 "ncols 40\nnrows 40\nxllcorner " + corner_x + "\nyllcorner " + corner_y + "\ncellsize 1\n" + heights);
    folder.write(name + ".toml",
                 "format = 1\nmaterial = [ { name = \"soil\", reflectance = 0.3, source = \"test\" } "
                 "]\n[scene]\norigin = { easting_m = " +
                     std::to_string(easting) + ", northing_m = " + std::to_string(northing) +
                     " }\n[[terrain]]\nraster = \"" + name +
                     ".asc\"\nmaterial = \"soil\"\n[time]\nsun = { zenith_deg = 60.0, azimuth_deg = 150.0 "
                     "}\n[[instrument]]\nname = "
                     "\"camera\"\n"
                     "kind = \"framing\"\naltitude_agl_m = 500.0\ngsd_m = 1.0\npixels = 30\nlines = 30\nsamples = { "
                     "grid = [4, 4] }\n"
                     "bands = { first_nm = 500.0, step_nm = 100.0, count = 4, fwhm_nm = 10.0 }\n");
    const auto simulation = scene::load_simulation(folder / (name + ".toml"));
    return test::render_image(simulation, atmos::uniform_sky_table(kSun, kSky, {0.3, 1.0, 4.0}, 60, 150));
  };
  const auto here = scene_at("here", 0, 0, "-20", "-20");
  const auto utm = scene_at("utm", 276000, 4753000, "275980", "4752980");
  CHECK(here.layer(15, 15, render::truth::hit_fraction) == 1);
  CHECK(std::abs(here.layer(10, 10, render::truth::sun_fraction) - here.layer(20, 5, render::truth::sun_fraction)) +
            std::abs(here.at(3, 20, 0) - here.at(20, 3, 0)) >
        0);  // relief shows
  CHECK(same_bytes(here.radiance, utm.radiance));
  CHECK(same_bytes(here.truth, utm.truth));
}
