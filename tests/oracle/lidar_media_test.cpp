// Gas on the way of pulses on the device: lines averaged after the exponential (L-09), plumes (L-11), the ledger's
// share.
#include <doctest/doctest.h>

#include <cmath>

#include "host/lidar/make_lidar_plan.h"
#include "tests/support/lidar_device.h"
#include "tests/support/lidar_kit.h"

using namespace raycube;
using namespace raycube::test;

namespace {

/// A pencil straight down on ground, with a layer of gas of 10 m between.
struct Layer {
  scene::CompiledScene scene = scene_of({0.3});
  scene::Lidar lidar = topographic_lidar();
  Layer() {
    add_plane(scene, 0, {0, 0, 0}, 100);
    scene::finish_top_tree(scene);
    lidar.pulse.half_divergence_rad = 0;
    lidar.transport.subrays = 1;
  }
  lidar::ShotResult shoot(const lidar::LidarPlan& plan) const {
    return render_shots(scene, plan, {shot_from(lidar, {0, 0, 1000}, {0, 0, -1})}).at(0);
  }
};

}  // namespace

TEST_CASE("L-09: a laser line on an absorption line is averaged after the exponential") {
  const double centre_cm = 1e4 / 3.3, strength = 2.0e-19, half_width_cm = 0.06;
  for (const auto& [ppm_m, fwhm_cm, on, off] : {std::array{100.0, 0.0, 0.5908820, 0.999160},
                                                {100.0, 0.05, 0.6221263, 0.999160},
                                                {100.0, 0.10, 0.6757258, 0.999160},
                                                {1000.0, 0.0, 5.188089e-3, 0.991630},
                                                {1000.0, 0.05, 1.061674e-2, 0.991630},
                                                {1000.0, 0.10, 3.897977e-2, 0.991630}}) {
    Layer layer;
    scene::Volume gas;
    gas.name = "gas", gas.gas = "synthetic";
    gas.position_m = {0, 0, 100}, gas.size_m = {50, 50, 10};
    gas.concentration_ppm = ppm_m / 10;
    layer.scene.volumes.push_back(gas);
    const double centre_um = 1e4 / centre_cm, off_um = 1e4 / (centre_cm - 1.5);
    layer.lidar.pulse.lines = {{"on", centre_um, fwhm_cm * centre_um * centre_um / 1e4, 1e-4},
                               {"off", off_um, 0, 1e-4}};
    layer.lidar.transport.line_nodes = 64;
    lidar::LidarPlan plan = hand_plan(layer.lidar, layer.scene);
    plan.nodes = lidar::make_nodes(layer.lidar);
    plan.first_node = {0, static_cast<int>(plan.nodes.size()) - 1, static_cast<int>(plan.nodes.size())};
    plan.cross_section_cm2.clear();
    for (const auto& node : plan.nodes) {
      const double away_cm = 1e4 / node.wavelength_um - centre_cm;
      plan.cross_section_cm2.push_back(strength * half_width_cm /
                                       (M_PI * (away_cm * away_cm + half_width_cm * half_width_cm)));
    }
    const auto seen = layer.shoot(plan);
    std::fill(plan.cross_section_cm2.begin(), plan.cross_section_cm2.end(), 0.0);
    const auto clear = layer.shoot(plan);
    const auto share = [&](std::ptrdiff_t line) {
      return total({seen.first.begin() + line * 1000, seen.first.begin() + line * 1000 + 1000}) /
             total({clear.first.begin() + line * 1000, clear.first.begin() + line * 1000 + 1000});
    };
    CHECK(share(0) ==
          doctest::Approx(on).epsilon(
              2e-5));  // depth 5.3 in float, to 3 ulp; the line's shape even in wavelength, not in wavenumber
    CHECK(share(1) == doctest::Approx(off).epsilon(2e-6));
    // What the gas took on the way down, for the ledger.
    CHECK(std::abs(seen.ledger[1].volumes - (1 - std::sqrt(off))) <= 2e-6);
    CHECK(seen.ledger[1].air == 0);
    CHECK(std::abs(seen.ledger[0].emitted_error()) <= 1e-6);
  }
}

TEST_CASE("L-11: a nadir pulse through a Gaussian plume, whatever its height and rise") {
  for (const double sigma_z_m : {2.0, 10.0, 40.0}) {
    Layer layer;
    scene::Volume plume;
    plume.shape = scene::Volume::Shape::plume;
    plume.name = "plume", plume.gas = "CH4";
    plume.position_m = {-50, 0, 0}, plume.yaw_deg = 90;
    plume.source_g_s = 1, plume.wind_m_s = 3, plume.release_height_m = 20, plume.molar_mass_g = 16.0425;
    plume.sigma_y_m = 10, plume.sigma_z_m = sigma_z_m, plume.length_m = 500;
    layer.scene.volumes.push_back(plume);
    lidar::LidarPlan plan = hand_plan(layer.lidar, layer.scene);
    plan.cross_section_cm2 = {1.061032954e-18};
    const auto seen = layer.shoot(plan);
    plan.cross_section_cm2 = {0};
    const auto clear = layer.shoot(plan);
    CHECK(total(seen.first) / total(clear.first) == doctest::Approx(0.8994859510).epsilon(2e-6));
    CHECK(seen.ledger[0].volumes == doctest::Approx(1 - std::sqrt(0.8994859510)).epsilon(1e-4));
  }
}

TEST_CASE("S33: air and gas share what they took in the ratio of their depths") {
  Layer layer;
  scene::Volume haze;
  haze.name = "haze";
  haze.position_m = {0, 0, 0}, haze.size_m = {50, 50, 1000};
  haze.extinction_per_m = 3e-4, haze.lidar_ratio_sr = 50;
  layer.scene.volumes.push_back(haze);
  lidar::LidarPlan plan = hand_plan(layer.lidar, layer.scene);
  set_air(plan, 1e-4, 0, 0, 2000);
  const auto result = layer.shoot(plan);
  CHECK(result.ledger[0].air == doctest::Approx(0.25 * (1 - std::exp(-0.4))).epsilon(1e-5));
  CHECK(result.ledger[0].volumes == doctest::Approx(0.75 * (1 - std::exp(-0.4))).epsilon(1e-5));
  CHECK(std::abs(result.ledger[0].emitted_error()) <= 1e-6);
}

TEST_CASE("S33: a bounced path pays for every piece of its way") {
  // Corner in a box of haze: order 2 through a uniform medium is dimmer by exp(-extinction path) of each path.
  const auto shoot = [](double extinction_per_m) {
    scene::CompiledScene scene = scene_of({0.5, 0.4});
    add_corner(scene, 0, 1, 50, 50, 50);
    scene::finish_top_tree(scene);
    scene::Lidar lidar = topographic_lidar();
    lidar.transport.subrays = 4096;
    lidar.transport.max_bounces = 2;
    lidar.pulse.fwhm_s = 0;
    lidar.gate = {600e-9, 1e-9, 1000};
    lidar::LidarPlan plan = hand_plan(lidar, scene);
    if (extinction_per_m > 0) set_air(plan, extinction_per_m, 0, -100, 300);
    return render_shots(scene, plan, {shot_from(lidar, {101, 0, 100}, {-1, 0, -1})}).at(0);
  };
  const auto clear = shoot(0), hazy = shoot(1e-3);
  for (std::size_t i = 0; i < 1000; ++i) {
    if (!(clear.multiple[i] > 0)) continue;
    const double way_m = (600 + static_cast<double>(i) + 0.5) * 1e-9 * kLightSpeed;
    CHECK(
        hazy.multiple[i] / clear.multiple[i] ==
        doctest::Approx(std::exp(-1e-3 * way_m)).epsilon(0.5 * 1e-3 * kLightSpeed * 1e-9 + 1e-5));  // half a bin's way
  }
}
