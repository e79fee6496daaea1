// Plans made by hand for the reference's tests.
#pragma once

#include <cmath>
#include <numbers>

#include <glm/vec3.hpp>
#include <glm/geometric.hpp>

#include "host/plan/plan.h"
#include "host/reference/sampled_pixel.h"

namespace raycube::test {

inline constexpr double kPi = std::numbers::pi;

inline void set_sun(plan::Plan& plan, double zenith_deg, double azimuth_deg) {
  const double z = zenith_deg * kPi / 180, a = azimuth_deg * kPi / 180;
  plan.sun_direction = {static_cast<float>(std::sin(z) * std::sin(a)), static_cast<float>(std::sin(z) * std::cos(a)),
                        static_cast<float>(std::cos(z))};
}

/// One node everywhere, two bands over five wavelengths, unit sun spectrum (1/pi inside), no sky, no path.
inline plan::Plan sun_plan(double zenith_deg = 0, double azimuth_deg = 0) {
  plan::Plan plan;
  plan.wavelength_um = {0.4, 0.5, 0.6, 0.7, 0.8};
  plan.bands = {{0, {0.25, 0.5, 0.25}}, {2, {0.25, 0.5, 0.25}}};
  set_sun(plan, zenith_deg, azimuth_deg);
  plan.source_spectrum = {std::vector<double>(5, 1 / kPi)};
  plan.path_spectrum = {std::vector<double>(5, 0.0)};
  return plan;
}

/// Adds a sky of radiance 1 everywhere: E(n) = pi (1 + n_z) / 2 on an octahedral map, and so many rays a pixel, by the
/// cosine about the normal.
inline void add_uniform_sky(plan::Plan& plan, int map_size, int rays) {
  plan.sky_components = 1;
  plan.source_spectrum.push_back(std::vector<double>(plan.wavelength_um.size(), 1 / kPi));
  plan.irradiance.size = map_size;
  for (int j = 0; j < map_size; ++j)
    for (int i = 0; i < map_size; ++i) {
      double x = 2.0 * i / (map_size - 1) - 1, y = 2.0 * j / (map_size - 1) - 1;
      const double z = 1 - std::abs(x) - std::abs(y);
      if (z < 0) {
        const double folded = (1 - std::abs(y)) * (x < 0 ? -1 : 1);
        y = (1 - std::abs(x)) * (y < 0 ? -1 : 1), x = folded;
      }
      shared::rc_float4 value;
      value.x = static_cast<float>(kPi * (1 + glm::normalize(glm::dvec3(x, y, z)).z) / 2);
      plan.irradiance.value.push_back(value);
    }
  plan.sky_basis.zenith_rad = {0, kPi / 2};
  plan.sky_basis.azimuth_rad = {0, kPi};
  plan.sky_basis.value.assign(4, {1, 0, 0, 0});
  plan.sky.rays = rays;
}

/// A framing camera at (x, y, height) looking straight down, pixels of `gsd` metres on z = 0, one pixel per group.
struct NadirPixel {
  scene::Instrument instrument;
  reference::PixelAddress address;
};

inline NadirPixel nadir_pixel(double x, double y, double height, double gsd, int samples = 10) {
  NadirPixel out;
  out.instrument.name = "camera";
  out.instrument.pixels = out.instrument.lines = 1;
  out.instrument.samples_u = out.instrument.samples_v = samples;
  out.address.group_width = 1;
  shared::RayGroup& group = out.address.group;
  group.origin = {static_cast<float>(x), static_cast<float>(y), static_cast<float>(height), 0};
  group.d0 = {0, 0, -1, 0};
  group.du = {static_cast<float>(gsd / height), 0, 0, 0};
  group.dv = {0, static_cast<float>(gsd / height), 0, 0};
  return out;
}

}  // namespace raycube::test
