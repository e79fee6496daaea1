// A placed mesh under sun, uniform sky and path radiance, in a hundred bands: the whole chain against a
// closed form (S3, S11, S15, S26). Geometry: one sloping rectangle, turned, tilted, moved and scaled by 1.5,
// 0.6 and 2, framing camera 1000 m above, pixels of 20 m, 3 x 3 samples. Its normal comes from the cross
// product of its moved edges: no inverse matrix enters. Reflectance is linear in wavelength, so a symmetric
// band sees its centre's value. Tolerance of radiance 1e-5: that of the plane that is not moved; of places
// and ranges 5e-4 m: 8 roundings of 1000 m in fp32; of angles 1e-4 deg: the same seen from there.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "atmos_tables/synthetic.h"
#include "host/base/units.h"
#include "host/render/truth.h"
#include "host/sensors/ray_groups.h"
#include "tests/support/render_kit.h"

namespace {

using namespace raycube;
constexpr double kPi = std::numbers::pi;
using Vec = std::array<double, 3>;

/// Rows of the placement: turn about the vertical, tilt about x, unequal scale, move.
std::array<double, 12> placement() {
  const double c = std::cos(0.7), s = std::sin(0.7), ct = std::cos(0.3), st = std::sin(0.3);
  const double turn[3][3] = {{c, -s * ct, s * st}, {s, c * ct, -c * st}, {0, st, ct}}, scale[3] = {1.5, 0.6, 2.0};
  const double move[3] = {3, -2, 20};
  std::array<double, 12> m{};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) m[std::size_t(4 * i + j)] = turn[i][j] * scale[j];
    m[std::size_t(4 * i + 3)] = move[i];
  }
  return m;
}

Vec moved(const std::array<double, 12>& m, const Vec& v) {
  Vec out;
  for (std::size_t i = 0; i < 3; ++i) out[i] = m[4 * i] * v[0] + m[4 * i + 1] * v[1] + m[4 * i + 2] * v[2];
  return out;
}

double dot(const Vec& a, const Vec& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/// Truth layer by name.
double layer(const test::Image& image, const scene::CompiledScene& scene, const char* name, int line, int pixel) {
  const auto names = render::truth_layer_names(scene);
  for (std::size_t i = 0; i < names.size(); ++i)
    if (names[i].name == name) return image.layer(line, pixel, static_cast<int>(i));
  FAIL("no truth layer " << name);
  return 0;
}

}  // namespace

TEST_CASE(
    "S3 S11 S15 S26 a mesh turned, tilted and scaled unequally: radiance of 100 bands and truth equal their "
    "closed forms") {
  const Vec a{400, 0, 140}, b{0, 400, -80};
  const auto m = placement();
  scene::Simulation simulation;
  const auto surface = test::add_material(simulation.scene, "sloping", 0.0);
  simulation.scene.materials[0].reflectance = {{0.3, 4.0}, {0.1, 0.9}};
  const auto mesh = append_mesh(simulation.scene, "slope", test::rectangle({-200, -200, -30}, a, b, surface));
  append_instance(simulation.scene, mesh, m, 0);
  finish_top_tree(simulation.scene);
  simulation.sun.zenith_deg = 35;
  simulation.sun.azimuth_deg = 250;
  auto camera = test::nadir_camera(5, 3, 1000, 20);
  camera.samples_u = camera.samples_v = 3;
  std::vector<double> centers_um;
  for (int band = 0; band < 100; ++band) centers_um.push_back(0.4 + 0.02 * band);
  camera.bands = test::gaussian_bands(centers_um, 0.015);
  simulation.instruments = {camera};

  const double view = 0.7, factor = 1.04, sun_down = 1500 * 0.8, sky = 30, path = 5;
  const atmos::UniformAir air = test::uniform_air({1500, 0.8, 0.7, 1.04, 30, 5}, simulation.sun);
  const auto image = test::render_image(simulation, atmos::uniform_table(air, atmos::wavelength_grid(0.3, 2.6, 0.01)));

  const Vec e = moved(m, a), f = moved(m, b);
  Vec n{e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]};
  const double length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
  for (double& x : n) x /= length;
  REQUIRE(n[2] > 0.5);
  const double zenith = base::rad_from_deg(simulation.sun.zenith_deg),
               azimuth = base::rad_from_deg(simulation.sun.azimuth_deg);
  const double cosine =
      dot(n, {std::sin(zenith) * std::sin(azimuth), std::sin(zenith) * std::cos(azimuth), std::cos(zenith)});
  REQUIRE(cosine > 0.2);
  double worst = 0;
  for (int band = 0; band < image.bands; ++band) {
    const double rho = 0.1 + 0.8 * (centers_um[std::size_t(band)] - 0.3) / 3.7;
    const double expected = rho * view * factor * (sun_down * cosine / kPi + sky * (1 + n[2]) / 2) + path;
    for (int line = 0; line < image.lines; ++line)
      for (int pixel = 0; pixel < image.pixels; ++pixel)
        worst = std::max(worst, std::abs(image.at(line, pixel, band) / expected - 1));
  }
  MESSAGE("largest relative error " << worst);
  CHECK(worst < 1e-5);

  const Vec centre{m[3], m[7], m[11]};  // the rectangle's middle is the mesh's origin
  for (int line = 0; line < image.lines; ++line)
    for (int pixel = 0; pixel < image.pixels; ++pixel) {
      Vec mean{};
      double range = 0;
      for (int k = 0; k < 9; ++k) {
        const auto ray = sensors::pixel_ray(camera, line, pixel, (k % 3 - 1) / 3.0, (k / 3 - 1) / 3.0);
        const Vec o{ray.origin_m.x, ray.origin_m.y, ray.origin_m.z},
            d{ray.direction.x, ray.direction.y, ray.direction.z};
        const double t = dot(n, {centre[0] - o[0], centre[1] - o[1], centre[2] - o[2]}) / dot(n, d);
        for (std::size_t i = 0; i < 3; ++i) mean[i] += (o[i] + t * d[i]) / 9;
        range += t * std::sqrt(dot(d, d)) / 9;
      }
      const auto truth = [&](const char* name) { return layer(image, simulation.scene, name, line, pixel); };
      CHECK(truth("hit_fraction") == doctest::Approx(1).epsilon(1e-6));
      CHECK(truth("sun_fraction") == doctest::Approx(1).epsilon(1e-6));
      CHECK(std::abs(truth("x_m") - mean[0]) < 5e-4);
      CHECK(std::abs(truth("y_m") - mean[1]) < 5e-4);
      CHECK(std::abs(truth("z_m") - mean[2]) < 5e-4);
      CHECK(std::abs(truth("range_m") - range) < 5e-4);
      CHECK(std::abs(truth("sun_incidence_deg") - base::deg_from_rad(std::acos(cosine))) < 1e-4);
      const auto ray = sensors::pixel_ray(camera, line, pixel, 0, 0);
      const double across = std::hypot(ray.direction.x, ray.direction.y);
      CHECK(std::abs(truth("view_zenith_deg") - base::deg_from_rad(std::atan2(across, -ray.direction.z))) < 1e-4);
      if (across < 1e-3) continue;  // straight down has no azimuth
      const double view_azimuth =
          base::deg_from_rad(std::atan2(-ray.direction.x, -ray.direction.y));  // from the ground to the sensor
      CHECK(std::abs(std::remainder(truth("view_azimuth_deg") - view_azimuth, 360)) < 1e-3);
    }
}

// A shadow ray's start is lifted off the surface by the error bound of its place, 2e-7 of the mesh: 2 cm on a plane of
// 90 km. Truth must not tell that. Level ground at height 0 is met at z = 0 exactly; range over 3 km rounds by 1 ulp of
// it (2.4e-4 m) in each of a few steps, of 9 samples' mean.
TEST_CASE("S26 height and range on a plane of 90 km are the surface's own, not those of its shadow rays") {
  scene::Simulation simulation;
  const auto surface = test::add_material(simulation.scene, "plain", 0.3);
  test::place(simulation.scene, test::rectangle({-45000, -45000, 0}, {90000, 0, 0}, {0, 90000, 0}, surface));
  finish_top_tree(simulation.scene);
  simulation.sun.zenith_deg = 30;
  auto camera = test::nadir_camera(6, 2, 3000, 2);
  camera.samples_u = camera.samples_v = 3;
  camera.bands = test::gaussian_bands({0.55}, 0.01);
  camera.poses[0].x_m = camera.poses[0].y_m = 20000;
  simulation.instruments = {camera};
  atmos::UniformAir air;
  air.sun_zenith_deg = 30;
  const auto table = atmos::uniform_table(air, atmos::wavelength_grid(0.3, 2.6, 0.05));
  const auto image = test::render_image(simulation, table);
  double worst_z_m = 0, worst_range_m = 0;
  for (int line = 0; line < image.lines; ++line)
    for (int pixel = 0; pixel < image.pixels; ++pixel) {
      double range_m = 0;
      for (int k = 0; k < 9; ++k) {
        const auto d = sensors::pixel_ray(camera, line, pixel, (k % 3 - 1) / 3.0, (k / 3 - 1) / 3.0).direction;
        range_m += 3000 * std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z) / -d.z / 9;
      }
      worst_z_m = std::max(worst_z_m, std::abs(double{layer(image, simulation.scene, "z_m", line, pixel)}));
      const double found_m = layer(image, simulation.scene, "range_m", line, pixel);
      worst_range_m = std::max(worst_range_m, std::abs(found_m - range_m));
    }
  MESSAGE("height " << worst_z_m << " m, range " << worst_range_m << " m");
  CHECK(worst_z_m < 1e-6);
  CHECK(worst_range_m < 1e-3);
}

// The way back undoes the rounding away from the surface too, 2 ulp of a coordinate (1.2e-4 m each at 2000 m).
TEST_CASE("S26 height of level ground high above the scene's origin, to one rounding of it") {
  scene::Simulation simulation;
  const auto surface = test::add_material(simulation.scene, "plain", 0.3);
  test::place(simulation.scene, test::rectangle({-30, -30, 2000}, {60, 0, 0}, {0, 60, 0}, surface));
  finish_top_tree(simulation.scene);
  simulation.sun.zenith_deg = 30;
  auto camera = test::nadir_camera(6, 2, 3000, 2);
  camera.samples_u = camera.samples_v = 1;
  camera.bands = test::gaussian_bands({0.55}, 0.01);
  simulation.instruments = {camera};
  atmos::UniformAir air;
  air.sun_zenith_deg = 30;
  const auto table = atmos::uniform_table(air, atmos::wavelength_grid(0.3, 2.6, 0.05));
  const auto image = test::render_image(simulation, table);
  for (int line = 0; line < image.lines; ++line)
    for (int pixel = 0; pixel < image.pixels; ++pixel)
      CHECK(std::abs(double{layer(image, simulation.scene, "z_m", line, pixel)} - 2000) <= 0x1p-13);
}
