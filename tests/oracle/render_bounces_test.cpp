// Light between surfaces (LIGHT 2, 3 and 6) against closed forms: the corner of two endless half planes, a hollow
// sphere, leaves among leaves; bits that do not depend on tiles, chunks or memory.
#include <doctest/doctest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <numbers>

#include "atmos_tables/synthetic.h"
#include "host/plan/irradiance_map.h"
#include "tests/support/chance_checks.h"
#include "tests/support/lit_scenes.h"
#include "tests/support/render_kit.h"
#include "tests/support/test_scenes.h"

namespace {

using namespace raycube;
using test::at, test::check_mean, test::kCentres, test::kSunIrradiance, test::lit, test::mean_of, test::narrow,
    test::wavy;
constexpr double kPi = std::numbers::pi, kSkyRadiance = 30;

/// Radiosity of two half planes that each see half of the other, first order in `a` and `b`: the sum over so many
/// levels of what leaves the first.
double exchanged(double a, double b, double rho_a, double rho_b, int levels) {
  double sum = a;
  for (int level = 0; level < levels; ++level) {
    const double next_a = rho_a * b / 2, next_b = rho_b * a / 2;
    sum += next_a, a = next_a, b = next_b;
  }
  return sum;
}

constexpr double kFar_m = 2e4;

/// The ground east of an endless wall, seen from above 2 to 3 m before it; the sun 40 degrees from the zenith. The wall
/// of 20 km lacks 1.5e-4 of its half of the sky.
struct Corner {
  scene::Simulation simulation;
  double sun_azimuth_deg = 90;
  Corner() {
    const auto ground = test::add_material(simulation.scene, "ground", 0.5),
               wall = test::add_material(simulation.scene, "wall", 0.5);
    simulation.scene.materials[0].reflectance = wavy(0.45, 0.3, 9);
    simulation.scene.materials[1].reflectance = wavy(0.5, 0.25, 14);
    test::place(simulation.scene, test::rectangle({0, -kFar_m, 0}, {kFar_m, 0, 0}, {0, 2 * kFar_m, 0}, ground));
    test::place(simulation.scene, test::rectangle({0, -kFar_m, 0}, {0, 2 * kFar_m, 0}, {0, 0, kFar_m}, wall));
    finish_top_tree(simulation.scene);
    simulation.sky_directions = 64;
    auto camera = test::nadir_camera(24, 24, 20, 0.04, 2.5, 0);
    camera.bands = narrow();
    camera.samples_u = camera.samples_v = 4;
    simulation.instruments = {camera};
  }
  test::Image image(int levels, const render::RenderOptions& options = {}) {
    return lit(simulation, levels, 40, sun_azimuth_deg, kSkyRadiance, options);
  }
  double rho(int material, double l) const { return at(simulation.scene.materials[material].reflectance, l); }
};

}  // namespace

TEST_CASE("S16 bounces: the corner of two endless half planes under sun and even sky is a geometric series per band") {
  // Every point of either plane sees the other in half of its hemisphere, by the cosine, and half of the sky in the
  // rest: radiosity B_g = rho_g (E_g + B_w / 2), B_w likewise, level by level.
  for (const int levels : {1, 2, 6}) {
    Corner corner;
    const auto image = corner.image(levels);
    const double c = std::cos(40 * kPi / 180), s = std::sin(40 * kPi / 180), sky = kPi * kSkyRadiance / 2;
    for (std::size_t b = 0; b < kCentres.size(); ++b) {
      const double rg = corner.rho(0, kCentres[b]), rw = corner.rho(1, kCentres[b]);
      const double seen = exchanged(rg * (kSunIrradiance * c + sky), rw * (kSunIrradiance * s + sky), rg, rw, levels);
      CAPTURE(levels);
      CAPTURE(kCentres[b]);
      check_mean(mean_of(image, static_cast<int>(b)), seen / kPi, 5e-4);
    }
    MESSAGE("skeleton of " << image.plan.bounces.skeleton.size() << " wavelengths, error " << image.plan.bounces.error
                           << ", amplifies " << image.plan.bounces.amplified);
  }
}

TEST_CASE("S23 bounces: through a wall that is a leaf the sun behind it lights the ground") {
  for (const int levels : {1, 3}) {
    Corner corner;
    corner.sun_azimuth_deg = 270;
    auto& wall = corner.simulation.scene.materials[1];
    wall.transmittance = wavy(0.2, 0.1, 5);
    const auto image = corner.image(levels);
    const double s = std::sin(40 * kPi / 180), sky = kPi * kSkyRadiance / 2;
    for (std::size_t b = 0; b < kCentres.size(); ++b) {
      const double rg = corner.rho(0, kCentres[b]), rw = corner.rho(1, kCentres[b]),
                   tw = at(wall.transmittance, kCentres[b]);
      const double seen = exchanged(rg * sky, rw * sky + tw * (kSunIrradiance * s + sky), rg, rw, levels);
      CAPTURE(levels);
      CAPTURE(kCentres[b]);
      check_mean(mean_of(image, static_cast<int>(b)), seen / kPi, 5e-4);
    }
  }
}

TEST_CASE("S24 bounces: a leaf spread over the ground is a pile of plates") {
  // R E + T^2 rho_g (1 + R rho_g + ..) E: two levels for the first of them and two for each that follows.
  for (const int levels : {1, 2, 4, 12}) {
    scene::Simulation simulation;
    const auto ground = test::add_material(simulation.scene, "ground", 0.5),
               leaf = test::add_material(simulation.scene, "leaf", 0.5);
    simulation.scene.materials[0].reflectance = wavy(0.5, 0.3, 9);
    simulation.scene.materials[1].reflectance = wavy(0.3, 0.2, 14);
    simulation.scene.materials[1].transmittance = wavy(0.3, 0.15, 11);
    for (const auto& [z, surface] : {std::pair{0.0, ground}, std::pair{1.0, leaf}})
      test::place(simulation.scene,
                  test::rectangle({-kFar_m / 4, -kFar_m / 4, z}, {kFar_m / 2, 0, 0}, {0, kFar_m / 2, 0}, surface));
    finish_top_tree(simulation.scene);
    simulation.sky_directions = 64;
    auto camera = test::nadir_camera(24, 24, 50, 0.5);
    camera.bands = narrow();
    camera.samples_u = camera.samples_v = 4;
    simulation.instruments = {camera};
    const auto image = lit(simulation, levels, 35, 150, kSkyRadiance);
    const double down = kSunIrradiance * std::cos(35 * kPi / 180) + kPi * kSkyRadiance;
    for (std::size_t b = 0; b < kCentres.size(); ++b) {
      const double rg = at(simulation.scene.materials[0].reflectance, kCentres[b]),
                   r = at(simulation.scene.materials[1].reflectance, kCentres[b]),
                   t = at(simulation.scene.materials[1].transmittance, kCentres[b]);
      double seen = r, again = t * t * rg;
      for (int level = 2; level <= levels; level += 2) seen += again, again *= r * rg;
      CAPTURE(levels);
      CAPTURE(kCentres[b]);
      check_mean(mean_of(image, static_cast<int>(b)), seen * down / kPi, 5e-4);
    }
  }
}

TEST_CASE("S16 bounces: in a hollow sphere every point is lit alike by what was scattered") {
  // The sun shines through a hole in the top; what is seen is the bottom, beside the beam. Of a flux F that enters,
  // E_1 = rho F / (4 pi r^2) everywhere, and each level more brings rho (1 - hole) times as much.
  const double radius = 10, zenith = 20 * kPi / 180;
  const glm::dvec3 sun(std::sin(zenith), 0, std::cos(zenith));
  scene::Simulation simulation;
  const auto white = test::add_material(simulation.scene, "white", 0.5);
  simulation.scene.materials[0].reflectance = wavy(0.6, 0.3, 9);
  const scene::TriangleMesh sphere = test::sphere(5, radius, 0);
  scene::TriangleMesh walls{sphere.vertices, {}, {}, {}};
  double flux = 0, removed_m2 = 0, all_m2 = 0;
  for (const auto& corner : sphere.triangles) {
    const auto vertex = [&](int i) {
      const auto& v = sphere.vertices[corner[static_cast<std::size_t>(i)]];
      return glm::dvec3(v[0], v[1], v[2]);
    };
    const glm::dvec3 area = 0.5 * glm::cross(vertex(1) - vertex(0), vertex(2) - vertex(0));
    all_m2 += glm::length(area);
    if ((vertex(0).z + vertex(1).z + vertex(2).z) / 3 < 0.96 * radius) {
      walls.user_face.push_back(static_cast<std::uint32_t>(walls.triangles.size()));
      walls.triangles.push_back(corner), walls.surface.push_back(white);
      continue;
    }
    removed_m2 += glm::length(area);
    flux += kSunIrradiance * glm::dot(area, sun);
  }
  test::place(simulation.scene, walls);
  finish_top_tree(simulation.scene);
  simulation.sky_directions = 320;
  auto camera = test::nadir_camera(32, 32, 60, 0.03);
  camera.bands = narrow();
  camera.samples_u = camera.samples_v = 4;
  simulation.instruments = {camera};
  for (const int levels : {1, 4, 20}) {
    const auto image = lit(simulation, levels, 20, 90, 0);
    for (std::size_t b = 0; b < kCentres.size(); ++b) {
      const double rho = at(simulation.scene.materials[0].reflectance, kCentres[b]);
      double level_light = rho * flux / all_m2, sum = 0;
      for (int level = 0; level < levels; ++level) sum += level_light, level_light *= rho * (1 - removed_m2 / all_m2);
      CAPTURE(levels);
      CAPTURE(kCentres[b]);
      check_mean(mean_of(image, static_cast<int>(b)), rho * sum / kPi, 1e-3);
    }
  }
}

TEST_CASE("S16 bounces: a steep roof over ground that the scene does not hold sees the ground around") {
  // Of a plane tilted by b a hemisphere's share (1 - cos b) / 2 lies below the horizon: level ground under sun and sky,
  // whether a triangle of the scene is met there or the ground around. Without light between ground and air that is
  // black, and the triangles alone count.
  constexpr double kTilt = 60 * kPi / 180, kHigh_m = 100, kHalf_m = 150;
  scene::Simulation simulation;
  const auto ground = test::add_material(simulation.scene, "ground", 0.4),
             roof = test::add_material(simulation.scene, "roof", 0.5);
  simulation.scene.materials[0].reflectance = wavy(0.4, 0.25, 9);
  simulation.scene.materials[1].reflectance = wavy(0.5, 0.2, 14);
  test::place(simulation.scene,
              test::rectangle({-kHalf_m, -kHalf_m, 0}, {2 * kHalf_m, 0, 0}, {0, 2 * kHalf_m, 0}, ground));
  test::place(simulation.scene, test::rectangle({-2, -4, kHigh_m}, {4, 0, 4 * std::tan(kTilt)}, {0, 8, 0}, roof));
  finish_top_tree(simulation.scene);
  simulation.sky_directions = 2048;
  simulation.plan.height_nodes = simulation.plan.view_nodes = 1;
  simulation.tolerance = 0.5;  // one node of each is asked for, whatever it errs
  auto camera = test::nadir_camera(12, 12, 500, 0.25);
  camera.bands = narrow();
  camera.samples_u = camera.samples_v = 2;
  simulation.instruments = {camera};
  simulation.sun.zenith_deg = 40, simulation.sun.azimuth_deg = 200;
  atmos::UniformAir air;
  air.solar_irradiance = [](double) { return kSunIrradiance; };
  air.sky_radiance = [](double) { return kSkyRadiance; };
  air.sun_zenith_deg = 40, air.sun_azimuth_deg = 200;
  auto table = atmos::uniform_table(air, atmos::wavelength_grid(0.35, 1.0, 0.005));
  test::add_ground_coupling(table);
  const auto between = [&](scene::Adjacency adjacency) {
    simulation.atmosphere.adjacency = adjacency;
    simulation.bounces = 0;
    const auto once = test::render_image(simulation, table);
    simulation.bounces = 1;
    auto image = test::render_image(simulation, table);
    for (std::size_t i = 0; i < image.radiance.size(); ++i) image.radiance[i] -= once.radiance[i];
    return image;
  };
  // The field's part of the hemisphere, from the roof's middle, by the cosine.
  const double high = kHigh_m + 2 * std::tan(kTilt), s = std::sin(kTilt), c = std::cos(kTilt);
  constexpr int kSteps = 600;
  double field = 0;
  for (int i = 0; i < kSteps; ++i)
    for (int j = 0; j < kSteps; ++j) {
      const double r = std::sqrt((i + 0.5) / kSteps), up = std::sqrt(1 - r * r), turn = 2 * kPi * (j + 0.5) / kSteps;
      const double x = r * std::cos(turn) * c - up * s, y = r * std::sin(turn), z = r * std::cos(turn) * s + up * c;
      if (z < 0 && std::abs(x / z * high) < kHalf_m && std::abs(y / z * high) < kHalf_m)
        field += 1.0 / (kSteps * kSteps);
    }
  const auto check_share = [&](scene::Adjacency adjacency, double share, double unlike) {
    const auto image = between(adjacency);
    const plan::Plan& plan = image.plan;
    REQUIRE(plan.height.count * plan.view.count == 1);
    const auto open = plan::read_map(plan.irradiance, 0, 0, 1);
    for (std::size_t b = 0; b < kCentres.size(); ++b) {
      const auto& band = plan.bands[b];
      double want = 0;
      for (std::size_t i = 0; i < band.weight.size(); ++i) {
        const double l = plan.wavelength_um[band.first + i];
        double light = std::cos(40 * kPi / 180) * plan.source_spectrum[0][band.first + i];
        for (std::size_t n = 0; n < static_cast<std::size_t>(plan.sky_components); ++n)
          light += open[n] * plan.source_spectrum[1 + n][band.first + i];
        want += band.weight[i] * at(simulation.scene.materials[0].reflectance, l) *
                at(simulation.scene.materials[1].reflectance, l) * share * light;
      }
      CAPTURE(kCentres[b]);
      check_mean(mean_of(image, static_cast<int>(b)), want, unlike);
    }
  };
  check_share(scene::Adjacency::local, (1 - c) / 2, 2e-3);  // the roof's own share of the mean ground is 4e-4
  check_share(scene::Adjacency::off, field, 1e-2);          // of the roof's middle for all of it, 3 % in height
}

TEST_CASE("S43 bounces: standard errors know of the paths") {
  // Of the ground in the shade of a wall that lets light through nearly all light has come by it, and nearly all noise
  // is the paths'. Stated over what 16 seeds scatter by, whose 256 pixels know that to 1 %: 0.8 to 1.25.
  Corner corner;
  corner.sun_azimuth_deg = 270;
  corner.simulation.scene.materials[1].transmittance = wavy(0.3, 0.1, 5);
  auto& camera = corner.simulation.instruments[0];
  camera.pixels = 16, camera.lines = 16;
  camera.standard_error = scene::StandardError::bands;
  constexpr int kSeeds = 16;
  double stated = 0;
  std::vector<double> sum, square;
  for (int seed = 0; seed < kSeeds; ++seed) {
    corner.simulation.seed = static_cast<std::uint64_t>(1000 + seed);
    const auto image = corner.image(2);
    sum.resize(image.radiance.size()), square.resize(image.radiance.size());
    for (std::size_t i = 0; i < image.radiance.size(); ++i) {
      const double l = image.radiance[i], e = image.band_error[i];
      sum[i] += l, square[i] += l * l, stated += e * e;
    }
  }
  double scattered = 0;
  for (std::size_t i = 0; i < sum.size(); ++i) scattered += (square[i] - sum[i] * sum[i] / kSeeds) / (kSeeds - 1);
  const double ratio = std::sqrt(stated / kSeeds / scattered);
  MESSAGE("standard error stated over scattered: " << ratio);
  CHECK_ABOVE(ratio, 0.8);
  CHECK_BELOW(ratio, 1.25);
}

TEST_CASE("S43 bounces: the same bits for any tile, row capacity and memory") {
  Corner corner;
  const auto whole = corner.image(3);
  render::RenderOptions lines;
  lines.tile_lines = 5;
  CHECK(corner.image(3, lines).radiance == whole.radiance);
  render::RenderOptions little;
  little.memory_bytes = std::size_t{32} << 20;
  CHECK(corner.image(3, little).radiance == whole.radiance);
}
