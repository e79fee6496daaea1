// Gloss seen by cameras (S21): GGX beside the diffuse reflectance, of the sun and of the sky. Oracles: the lobe's
// closed form at each pixel's own directions, its quadrature over an even sky, and what a wall leaves of that.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "atmos_tables/synthetic.h"
#include "host/render/truth.h"
#include "kernels/materials/shapes.h"
#include "scene_compiler/matter.h"
#include "tests/support/chance_checks.h"
#include "tests/support/render_kit.h"

namespace {

using namespace raycube;
constexpr double kPi = std::numbers::pi, kReflectance = 0.3, kSunIrradiance = 1500, kHeight_m = 100;

/// GGX with Schlick's Fresnel term from its papers, apart from the kernels' code: D of Trowbridge and Reitz by slopes,
/// Smith's masking of each way joined by azimuth (Heitz 2014, equations 72 and 96).
double ggx(double a, double f0, const RcLocal& n, const RcLocal& in, const RcLocal& out) {
  const auto dot = [](const RcLocal& p, const RcLocal& q) { return p.x * q.x + p.y * q.y + p.z * q.z; };
  const double ci = dot(n, in), co = dot(n, out);
  if (ci <= 0 || co <= 0) return 0;
  RcLocal h{in.x + out.x, in.y + out.y, in.z + out.z};
  const double length = std::sqrt(dot(h, h)), ch = dot(n, h) / length, turn = dot(in, h) / length;
  const double tan2 = (1 - ch * ch) / (ch * ch),
               facets = 1 / (kPi * a * a * std::pow(ch, 4) * std::pow(1 + tan2 / (a * a), 2));
  const auto lambda = [&](double c) { return (std::sqrt(1 + a * a * (1 - c * c) / (c * c)) - 1) / 2; };
  const auto flat = [&](const RcLocal& v, double c) { return RcLocal{v.x - c * n.x, v.y - c * n.y, v.z - c * n.z}; };
  const RcLocal p = flat(in, ci), q = flat(out, co);
  const double size = std::sqrt(dot(p, p) * dot(q, q)),
               phi = size > 0 ? std::acos(std::clamp(dot(p, q) / size, -1.0, 1.0)) : 0;
  const double join = 4.41 * phi / (4.41 * phi + 1), x = lambda(ci), y = lambda(co);
  const double fresnel = f0 + (1 - f0) * std::pow(1 - turn, 5);
  return fresnel * facets / (1 + std::max(x, y) + join * std::min(x, y)) / (4 * ci * co);
}

/// A plate of 80 m through the origin that rises towards the west, below a camera whose pixels see it from all angles
/// up to 20 degrees.
struct GlossyPlate {
  double tilt, roughness, f0;
  scene::Simulation simulation;
  std::uint32_t board = 0;
  GlossyPlate(double tilt_deg, double roughness_, double f0_)
      : tilt(tilt_deg * kPi / 180), roughness(roughness_), f0(f0_) {
    auto& scene = simulation.scene;
    const auto plate = test::add_material(scene, "plate", kReflectance);
    scene.materials[0].gloss = {RC_SHAPE_gloss, {roughness, f0}};
    board = test::add_material(scene, "board", 0.0);
    const double s = std::sin(tilt), c = std::cos(tilt);
    test::place(scene, test::rectangle({-40 * c, -40, 40 * s}, {80 * c, 0, -80 * s}, {0, 80, 0}, plate));
    simulation.instruments = {test::nadir_camera(12, 12, kHeight_m, 6)};
    simulation.instruments[0].bands = test::gaussian_bands({0.55}, 0.01);
    simulation.instruments[0].samples_u = simulation.instruments[0].samples_v = 1;
    simulation.bounces = 0, simulation.bounces_given = true;
  }
  RcLocal normal() const { return {std::sin(tilt), 0, std::cos(tilt)}; }
  static RcLocal viewer(const test::Image& image, int line, int pixel) {
    const double x = -image.layer(line, pixel, render::truth::x_m), y = -image.layer(line, pixel, render::truth::y_m),
                 z = kHeight_m - image.layer(line, pixel, render::truth::z_m);
    const double length = std::sqrt(x * x + y * y + z * z);
    return {x / length, y / length, z / length};
  }
  /// What an even sky of radiance 1 sends to the viewer by the gloss, its part below `cut` of azimuth left out.
  double of_even_sky(const RcLocal& out) const {
    constexpr int kRows = 600, kColumns = 1200;
    double sum = 0;
    for (int i = 0; i < kRows; ++i)
      for (int j = 0; j < kColumns; ++j) {
        const double z = (i + 0.5) / kRows, r = std::sqrt(1 - z * z), turn = 2 * kPi * (j + 0.5) / kColumns;
        const RcLocal in{r * std::cos(turn), r * std::sin(turn), z}, n = normal();
        sum += ggx(roughness, f0, n, in, out) * std::max(0.0, n.x * in.x + n.y * in.y + n.z * in.z);
      }
    return sum * 2 * kPi / kRows / kColumns;
  }
};

}  // namespace

// 2e-5: of a lobe of roughness 0.1 a float's 6e-8 in the facets' cosine are 1.2e-5 (gloss.h), and of the view's truth
// layers, rounded to floats, as much again.
TEST_CASE("S21 gloss: the sun's glint is the lobe at each pixel's own directions, beside the diffuse part") {
  for (const double roughness : {0.1, 0.3, 0.8})
    for (const double tilt_deg : {0.0, 15.0}) {
      GlossyPlate scene(tilt_deg, roughness, 0.05);
      finish_top_tree(scene.simulation.scene);
      scene.simulation.sun.zenith_deg = 35, scene.simulation.sun.azimuth_deg = 90;
      atmos::UniformAir air;
      air.solar_irradiance = [](double) { return kSunIrradiance; };
      air.sun_zenith_deg = 35, air.sun_azimuth_deg = 90;
      const auto image =
          test::render_image(scene.simulation, atmos::uniform_table(air, atmos::wavelength_grid(0.5, 0.6, 0.01)));
      const RcLocal sun{std::sin(35 * kPi / 180), 0, std::cos(35 * kPi / 180)}, n = scene.normal();
      const double cosine = sun.x * n.x + sun.z * n.z;
      double brightest = 0, worst = 0;
      for (int line = 0; line < image.lines; ++line)
        for (int pixel = 0; pixel < image.pixels; ++pixel) {
          const double lobe = ggx(roughness, 0.05, n, sun, GlossyPlate::viewer(image, line, pixel));
          const double want = kSunIrradiance * cosine * (kReflectance / kPi + lobe);
          worst = std::max(worst, std::abs(image.at(line, pixel, 0) / want - 1));
          brightest = std::max(brightest, lobe * kPi / kReflectance);
        }
      CAPTURE(roughness);
      CAPTURE(tilt_deg);
      CHECK(worst < 2e-5);
      if (roughness < 0.2 && tilt_deg > 0) CHECK(brightest > 1);  // a glint is in view, brighter than all else
      CHECK(image.layer(1, 1, render::truth::abundance) == doctest::Approx(1).epsilon(1e-6));
    }
}

TEST_CASE("S21 gloss: an even sky is the lobe's own integral, within the rays' noise, and a wall takes its part") {
  for (const double roughness : {0.1, 0.3, 0.8})
    for (const bool walled : {false, true}) {
      GlossyPlate scene(walled ? 0 : 20, roughness, 0.3);
      // To the west of x = -45 a black wall hides the sky from the horizon to the zenith's west: nothing of it is seen.
      if (walled)
        test::place(scene.simulation.scene, test::rectangle({-45, -5e6, 0}, {0, 1e7, 0}, {0, 0, 1e7}, scene.board));
      finish_top_tree(scene.simulation.scene);
      scene.simulation.sun.zenith_deg = 120;
      scene.simulation.sky_directions = 1024;
      auto& camera = scene.simulation.instruments[0];
      camera.samples_u = camera.samples_v = 32, camera.pixels = camera.lines = 2;
      camera.ifov_across_rad = camera.ifov_along_rad = 0.01 / kHeight_m;  // one view angle
      const auto image = test::render_image(scene.simulation, atmos::uniform_sky_table(0, 1.0, {0.3, 1.0, 4.0}, 120));
      const double up = (1 + std::cos(scene.tilt)) / 2;
      const double gloss = scene.of_even_sky({0, 0, 1}), share = walled ? 0.5 : 1;
      double sum = 0, squares = 0;
      for (const float l : image.radiance) sum += l, squares += double{l} * l;
      const double mean = sum / 4, error = std::sqrt(std::max(1e-18, squares / 4 - mean * mean) / 3);
      CAPTURE(roughness);
      CAPTURE(walled);
      CAPTURE(gloss);
      CAPTURE(error);
      // Four pixels of 1024 rays: their spread knows the error to 40 %, so 5 of it and 1e-3 of the whole beside.
      CHECK_WITHIN(mean - share * (kReflectance * up + gloss), 5 * error + 1e-3);
      CHECK_BELOW(error, 0.01 * mean);  // rays go where the lobe is
    }
}

// Every way to the west from the ground meets the wall, so that its light is the same everywhere: an integral over a
// quarter of a sphere. 1e-3 of the whole is the quadrature's.
TEST_CASE("S21 gloss: a wall that is gloss alone sends the sun on to the ground before it") {
  for (const double roughness : {0.2, 0.6}) {
    scene::Simulation simulation;
    const auto ground = test::add_material(simulation.scene, "ground", kReflectance),
               wall = test::add_material(simulation.scene, "wall", 0.0);
    simulation.scene.materials[1].gloss = {RC_SHAPE_gloss, {roughness, 0.5}};
    test::place(simulation.scene, test::rectangle({0, -1e5, 0}, {1e5, 0, 0}, {0, 2e5, 0}, ground));
    test::place(simulation.scene, test::rectangle({0, -1e5, 0}, {0, 2e5, 0}, {0, 0, 1e5}, wall));
    finish_top_tree(simulation.scene);
    simulation.sun.zenith_deg = 55, simulation.sun.azimuth_deg = 70;
    simulation.bounces = 1, simulation.bounces_given = true, simulation.sky_directions = 1024;
    simulation.tolerance = 0.01;
    scene::Instrument camera = test::nadir_camera(4, 4, 300, 1);
    camera.samples_u = camera.samples_v = 16;
    for (auto& pose : camera.poses) pose.x_m += 10;
    camera.bands = test::gaussian_bands({0.55}, 0.01);
    simulation.instruments = {camera};
    atmos::UniformAir air;
    air.solar_irradiance = [](double) { return kSunIrradiance; };
    air.sun_zenith_deg = 55, air.sun_azimuth_deg = 70;
    const auto image =
        test::render_image(simulation, atmos::uniform_table(air, atmos::wavelength_grid(0.5, 0.6, 0.01)));
    const double z = 55 * kPi / 180, a = 70 * kPi / 180;
    const RcLocal sun{std::sin(z) * std::sin(a), std::sin(z) * std::cos(a), std::cos(z)}, east{1, 0, 0};
    double sum = 0;
    constexpr int kRows = 300, kColumns = 600;
    for (int i = 0; i < kRows; ++i)
      for (int j = 0; j < kColumns; ++j) {
        // From the ground a way to the west, up; the wall sees where it came from.
        const double up = (i + 0.5) / kRows, r = std::sqrt(1 - up * up), turn = kPi * (j + 0.5) / kColumns;
        const RcLocal back{r * std::sin(turn), -r * std::cos(turn), -up};
        sum += up * ggx(roughness, 0.5, east, sun, back) * sun.x;
      }
    const double by_wall = sum * kPi / (kRows * kColumns), want = kReflectance / kPi * (sun.z + by_wall);
    double mean = 0, squares = 0;
    for (const float l : image.radiance) mean += l / 16, squares += double{l} * l / 16;
    const double error = std::sqrt(std::max(0.0, squares - mean * mean) / 15);
    CAPTURE(roughness);
    CAPTURE(by_wall);
    CAPTURE(error);
    CHECK_WITHIN(mean / kSunIrradiance - want, 5 * error / kSunIrradiance + 1e-3 * want);
    CHECK(by_wall > 0.02);
    CHECK_BELOW(error, 0.01 * mean);
  }
}

TEST_CASE("S21 gloss: a leaf has it beside both of its sides, and dull scenes keep their slots") {
  GlossyPlate scene(50, 0.3, 0.05);
  auto& plate = scene.simulation.scene.materials[0];
  CHECK(scene::camera_matter(scene.simulation.scene).sides() == 2);
  plate.transmittance = {plate.reflectance.wavelength_um,
                         std::vector<double>(plate.reflectance.wavelength_um.size(), 0.25)};
  CHECK(scene::camera_matter(scene.simulation.scene).sides() == 3);
  finish_top_tree(scene.simulation.scene);
  for (const double azimuth_deg : {90.0, 270.0}) {
    scene.simulation.sun.zenith_deg = 60, scene.simulation.sun.azimuth_deg = azimuth_deg;
    atmos::UniformAir air;
    air.solar_irradiance = [](double) { return kSunIrradiance; };
    air.sun_zenith_deg = 60, air.sun_azimuth_deg = azimuth_deg;
    const auto image =
        test::render_image(scene.simulation, atmos::uniform_table(air, atmos::wavelength_grid(0.5, 0.6, 0.01)));
    const double east = std::sin(60 * kPi / 180) * (azimuth_deg == 90 ? 1 : -1);
    const RcLocal sun{east, 0, std::cos(60 * kPi / 180)}, n = scene.normal();
    const double cosine = sun.x * n.x + sun.z * n.z, lobe = ggx(0.3, 0.05, n, sun, GlossyPlate::viewer(image, 5, 5));
    const double want = cosine > 0 ? cosine * (kReflectance / kPi + lobe) : -cosine * 0.25 / kPi;
    CHECK(image.at(5, 5, 0) == doctest::Approx(kSunIrradiance * want).epsilon(2e-5));
  }
  plate.gloss = {}, plate.transmittance = {};
  CHECK(scene::camera_matter(scene.simulation.scene).sides() == 1);
}
