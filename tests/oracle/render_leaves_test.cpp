// Leaves seen by cameras (LIGHT 1 and 4, S23): light that falls onto the far side goes to the viewer by the
// transmittance. Oracles: closed forms of one tilted leaf under sun and even sky, and Kirchhoff's law in a world of one
// temperature.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "atmos_tables/synthetic.h"
#include "host/base/planck.h"
#include "host/render/truth.h"
#include "scene_compiler/matter.h"
#include "tests/support/render_kit.h"

namespace {

using namespace raycube;
constexpr double kPi = std::numbers::pi, kReflectance = 0.35, kTransmittance = 0.25, kSunIrradiance = 1500;
constexpr double kHeight_m = 1000;

void let_through(scene::Material& material, double transmittance) {
  material.transmittance = {material.reflectance.wavelength_um,
                            std::vector<double>(material.reflectance.wavelength_um.size(), transmittance)};
}

/// A leaf of 200 m through the origin that rises towards the west: its upper normal is (sin, 0, cos).
struct TiltedLeaf {
  double tilt;
  scene::Simulation simulation;
  std::uint32_t leaf = 0, opaque = 0;
  explicit TiltedLeaf(double tilt_deg) : tilt(tilt_deg * kPi / 180) {
    leaf = test::add_material(simulation.scene, "leaf", kReflectance);
    let_through(simulation.scene.materials[0], kTransmittance);
    opaque = test::add_material(simulation.scene, "board", 0.0);
    simulation.instruments = {test::nadir_camera(4, 4, kHeight_m, 0.5)};
    simulation.instruments[0].bands = test::gaussian_bands({0.55}, 0.01);
    simulation.instruments[0].samples_u = simulation.instruments[0].samples_v = 3;
  }
  /// A square of the leaf's plane, moved along its upper normal.
  scene::TriangleMesh square(double half, double off, std::uint32_t surface) const {
    const double s = std::sin(tilt), c = std::cos(tilt);
    return test::rectangle({off * s - half * c, -half, off * c + half * s}, {2 * half * c, 0, -2 * half * s},
                           {0, 2 * half, 0}, surface);
  }
  test::Image under_sun(double zenith_deg, double azimuth_deg) {
    finish_top_tree(simulation.scene);
    simulation.sun.zenith_deg = zenith_deg, simulation.sun.azimuth_deg = azimuth_deg;
    atmos::UniformAir air;
    air.solar_irradiance = [](double) { return kSunIrradiance; };
    air.sun_zenith_deg = zenith_deg, air.sun_azimuth_deg = azimuth_deg;
    return test::render_image(simulation, atmos::uniform_table(air, atmos::wavelength_grid(0.5, 0.6, 0.01)));
  }
  /// Cosine between the upper normal and the sun.
  double facing(double zenith_deg, double azimuth_deg) const {
    const double z = zenith_deg * kPi / 180, a = azimuth_deg * kPi / 180;
    return std::sin(tilt) * std::sin(z) * std::sin(a) + std::cos(tilt) * std::cos(z);
  }
};

}  // namespace

// 1e-6: a dozen roundings of fp32, 6e-8 each.
TEST_CASE("S23 leaves: sunlight on the side that is seen goes by R, on the other side by T") {
  for (const double azimuth_deg : {90.0, 270.0, 200.0})
    for (const double zenith_deg : {20.0, 60.0}) {
      TiltedLeaf scene(50);
      test::place(scene.simulation.scene, scene.square(100, 0, scene.leaf));
      const double cosine = scene.facing(zenith_deg, azimuth_deg);
      const double want = (cosine > 0 ? kReflectance * cosine : -kTransmittance * cosine) * kSunIrradiance / kPi;
      const auto image = scene.under_sun(zenith_deg, azimuth_deg);
      CAPTURE(azimuth_deg);
      CAPTURE(zenith_deg);
      CAPTURE(cosine);
      CHECK(test::worst_relative(image, {want}) < 1e-6);
      CHECK(image.layer(1, 1, image.layers - 2) == doctest::Approx(1).epsilon(1e-6));  // abundance of the leaf: once
    }
}

TEST_CASE("S23 leaves: each side has its own shadow") {
  const double zenith_deg = 60, behind_deg = 270, before_deg = 90;
  for (const double off : {-2.0, 2.0}) {  // a board below the leaf, or above it beside what is seen
    for (const double azimuth_deg : {before_deg, behind_deg}) {
      TiltedLeaf scene(50);
      test::place(scene.simulation.scene, scene.square(100, 0, scene.leaf));
      // Above, the board is moved aside by the way of the sun's rays, so that it hides the sun and not the view.
      const double along = off > 0 ? 2 / scene.facing(zenith_deg, before_deg) : 0;
      auto board = scene.square(off > 0 ? 1.4 : 60, off, scene.opaque);
      if (off > 0)
        board = test::rectangle(
            {along * std::sin(zenith_deg * kPi / 180) - 0.2, -1.5, along * std::cos(zenith_deg * kPi / 180) - 1.5},
            {0, 0, 3}, {0, 3, 0}, scene.opaque);
      test::place(scene.simulation.scene, board);
      const double cosine = scene.facing(zenith_deg, azimuth_deg);
      const bool hidden = (off > 0) == (cosine > 0);
      const auto image = scene.under_sun(zenith_deg, azimuth_deg);
      CAPTURE(off);
      CAPTURE(azimuth_deg);
      const double want = (cosine > 0 ? kReflectance * cosine : -kTransmittance * cosine) * kSunIrradiance / kPi;
      if (hidden)
        CHECK(image.at(1, 1, 0) == 0);
      else
        CHECK(image.at(1, 1, 0) == doctest::Approx(want).epsilon(1e-6));
    }
  }
}

TEST_CASE("S16 S23 leaves: an even sky falls onto both sides of a tilted leaf") {
  for (const double tilt_deg : {0.0, 30.0, 70.0}) {
    TiltedLeaf scene(tilt_deg);
    test::place(scene.simulation.scene, scene.square(100, 0, scene.leaf));
    finish_top_tree(scene.simulation.scene);
    scene.simulation.sun.zenith_deg = 120;
    scene.simulation.sky_directions = 9;
    const auto image = test::render_image(scene.simulation, atmos::uniform_sky_table(0, 1.0, {0.3, 1.0, 4.0}, 120));
    const double up = (1 + std::cos(scene.tilt)) / 2;
    CAPTURE(tilt_deg);
    // The map of irradiance is off by 5e-5 at most between its nodes.
    CHECK(test::worst_relative(image, {kReflectance * up + kTransmittance * (1 - up)}) < 1e-4);
  }
}

TEST_CASE("S16 S23 leaves: among matter, air and sky of one temperature a leaf shows that temperature") {
  const double kelvin = 288.15;
  scene::Simulation simulation;
  simulation.file = "leaves.toml";
  auto& scene = simulation.scene;
  const auto warm = [&](const std::string& name, double reflectance, double transmittance) {
    const auto surface = test::add_material(scene, name, reflectance);
    scene.materials.back().reflectance = {{0.3, 20.0}, {reflectance, reflectance}};
    scene.materials.back().temperature_K = kelvin;
    if (transmittance > 0) let_through(scene.materials.back(), transmittance);
    return surface;
  };
  const auto leaf = warm("leaf", 0.3, 0.4), ground = warm("ground", 0.6, 0), clear = warm("clear leaf", 0.0, 1.0);
  shared::Surface mixed{};  // a third of it lets light through
  mixed.material[0] = 1, mixed.material[1] = 2, mixed.fraction[0] = 0.375f, mixed.fraction[1] = 0.625f;
  scene.surfaces.push_back(mixed);
  const auto mix = static_cast<std::uint32_t>(scene.surfaces.size() - 1);
  test::place(scene, test::rectangle({-60, -60, 0}, {120, 0, 0}, {0, 120, 0}, ground));
  test::place(scene, test::rectangle({-6, -6, 1}, {6, 0, 3}, {0, 6, 0}, leaf));
  test::place(scene, test::rectangle({0, -6, 2}, {6, 0, -1}, {0, 6, 1}, mix));
  test::place(scene, test::rectangle({-6, 0, 0.5}, {6, 0, 0}, {0, 6, 4}, clear));
  finish_top_tree(scene);
  simulation.sun.zenith_deg = 120;
  simulation.sky_directions = 16;
  simulation.instruments = {test::nadir_camera(16, 16, kHeight_m, 1)};
  simulation.instruments[0].bands = test::gaussian_bands({10.0}, 0.05);
  atmos::UniformAir air;
  air.solar_irradiance = [](double) { return 0.0; };
  air.sun_zenith_deg = 120;
  air.thermal_sky_radiance = [&](double l) { return base::planck_radiance(l, kelvin); };
  air.thermal_path_radiance = [](double) { return 0.0; };
  const auto image = test::render_image(simulation, atmos::uniform_table(air, atmos::wavelength_grid(9, 11, 0.002)));
  const double want = base::planck_radiance(10.0, kelvin);  // whose mean in the band is off by 2e-5
  double lowest = 1e9, highest = 0;
  for (const float l : image.radiance)
    lowest = std::min(lowest, static_cast<double>(l)), highest = std::max(highest, static_cast<double>(l));
  CHECK(lowest == doctest::Approx(want).epsilon(1e-4));
  CHECK(highest / lowest - 1 < 5e-6);
}

TEST_CASE("S23 leaves: a plate's straight way is of pulses alone, and opaque scenes keep one side") {
  TiltedLeaf scene(50);
  test::place(scene.simulation.scene, scene.square(100, 0, scene.leaf));
  CHECK(scene::camera_matter(scene.simulation.scene).sides() == 2);
  scene.simulation.scene.materials[0].behind.number = RC_SHAPE_plate;
  CHECK(scene::camera_matter(scene.simulation.scene).sides() == 1);
  scene.simulation.scene.materials[0].behind.number = RC_SHAPE_leaf;
  scene.simulation.scene.materials[0].transmittance = {};
  CHECK(scene::camera_matter(scene.simulation.scene).sides() == 1);
}
