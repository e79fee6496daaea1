// Shadow geometry and grazing views through the whole chain (S15, S63): a box on a plane, suns from the zenith to below
// the horizon, views almost level. Oracles in double, in closed form: each sample's hit on box or plane and the slab
// test of its way to the sun; the shadow's edge lies height * tan(zenith) behind the box.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "atmos_tables/synthetic.h"
#include "host/base/units.h"
#include "host/sensors/ray_groups.h"
#include "kernels/sampling/sampler.h"
#include "host/render/truth.h"
#include "tests/support/render_kit.h"

namespace {

using namespace raycube;
constexpr double kPi = std::numbers::pi;
constexpr double kHalf = 2, kHeight = 4;  // of the box, m
constexpr int kSide = 11;                 // samples

struct Vec {
  double x, y, z;
};

/// How far inside the box the ray o + t d (t > 0) comes: largest clearance over the ray of min(distance to each face),
/// m; positive: it hits. Piecewise linear and concave in t, so the best t is where two of the faces' clearances cross,
/// or t = 0.
double depth_in_box(const Vec& o, const Vec& d) {
  const double offset[6] = {kHalf - o.x, kHalf + o.x, kHalf - o.y, kHalf + o.y, kHeight - o.z, o.z};
  const double slope[6] = {-d.x, d.x, -d.y, d.y, -d.z, d.z};
  const auto clearance = [&](double t) {
    double least = 1e300;
    for (int i = 0; i < 6; ++i) least = std::min(least, offset[i] + t * slope[i]);
    return least;
  };
  double best = clearance(0);
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < i; ++j)
      if (const double t = (offset[j] - offset[i]) / (slope[i] - slope[j]); t > 0 && std::isfinite(t))
        best = std::max(best, clearance(t));
  return best;
}

scene::Simulation box_scene(double sun_zenith_deg, double sun_azimuth_deg, int pixels, int lines, double gsd_m,
                            double x_m, bool with_box = true) {
  scene::Simulation simulation;
  const auto ground = test::add_material(simulation.scene, "ground", 0.3),
             top = test::add_material(simulation.scene, "box", 0.6);
  // Shadow rays start off the surface by an error bound that grows with the triangle: 1.4 cm on one of 60 km, 50 um on
  // 200 m.
  const double reach = with_box ? 100 : 30000;
  test::place(simulation.scene, test::rectangle({-reach, -reach, 0}, {2 * reach, 0, 0}, {0, 2 * reach, 0}, ground));
  if (with_box) test::place(simulation.scene, test::box({-kHalf, -kHalf, 0}, {kHalf, kHalf, kHeight}, top));
  finish_top_tree(simulation.scene);
  simulation.sun.zenith_deg = sun_zenith_deg;
  simulation.sun.azimuth_deg = sun_azimuth_deg;
  simulation.sky_directions = 1;
  auto camera = test::nadir_camera(pixels, lines, 500, gsd_m, x_m, 0);
  camera.samples_u = camera.samples_v = kSide;
  simulation.instruments = {camera};
  return simulation;
}

test::Image rendered(const scene::Simulation& simulation, double sun = 1000, double sky = 0) {
  return test::render_image(simulation, atmos::uniform_sky_table(sun, sky, {0.3, 1.0, 4.0}, simulation.sun.zenith_deg,
                                                                 simulation.sun.azimuth_deg));
}

Vec to_sun(const scene::Sun& sun) {
  const double s = std::sin(base::rad_from_deg(sun.zenith_deg));
  return {s * std::sin(base::rad_from_deg(sun.azimuth_deg)), s * std::cos(base::rad_from_deg(sun.azimuth_deg)),
          std::cos(base::rad_from_deg(sun.zenith_deg))};
}

/// Whether the face of the box that the ray meets first is lit: 1 or 0 (nothing shades a face turned to the sun), -1
/// when the ray passes within 2 mm of an edge between faces.
int box_face(const Vec& o, const Vec& d, const Vec& sun) {
  const double top = (kHeight - o.z) / d.z, x = o.x + top * d.x, y = o.y + top * d.y;
  const double beyond = std::max(std::abs(x), std::abs(y)) - kHalf;
  if (std::abs(beyond) < 2e-3 || std::abs(std::abs(x) - std::abs(y)) < 2e-3) return -1;
  if (beyond < 0) return sun.z > 0;
  return (std::abs(x) > std::abs(y) ? x * sun.x : y * sun.y) > 0;
}

/// Lit samples of a pixel in closed form, and those within 2 mm of an outline of box or shadow (fp32 rays from 500 m
/// know the ground to 0.1 mm; the sun's direction in fp32 and the offset of shadow rays add to that along long
/// shadows).
struct Count {
  int lit = 0, near = 0;
};
Count count_pixel(const scene::Simulation& simulation, const shared::RayGroup& group, int pixel) {
  Count count;
  const Vec sun = to_sun(simulation.sun);
  for (int s = 0; s < kSide * kSide; ++s) {
    float u, v;
    rc_sample_uv(RC_SAMPLER_GRID, kSide, kSide, 1.0f, 0u, 0u, s, &u, &v);
    const double a = pixel % RC_GROUP_WIDTH - 1.5 + u;
    const Vec o{group.origin.x, group.origin.y, group.origin.z};
    const Vec d{group.d0.x + a * group.du.x + v * group.dv.x, group.d0.y + a * group.du.y + v * group.dv.y,
                group.d0.z + a * group.du.z + v * group.dv.z};
    const double depth = depth_in_box(o, d);
    if (std::abs(depth) < 2e-3) {
      ++count.near;
    } else if (depth > 0) {
      const int face = box_face(o, d, sun);
      if (face < 0)
        ++count.near;
      else
        count.lit += face;
    } else {
      const double t = -o.z / d.z, shade = depth_in_box({o.x + t * d.x, o.y + t * d.y, 0}, sun);
      if (std::abs(shade) < 2e-3)
        ++count.near;
      else
        count.lit += shade < 0;
    }
  }
  return count;
}

}  // namespace

TEST_CASE("S15 S63 shadow of a box: every sample as in closed form, edge at height times tan zenith") {
  for (const auto& [zenith_deg, azimuth_deg] :
       {std::pair{0.0, 0.0}, {30.0, 270.0}, {60.0, 270.0}, {78.0, 270.0}, {50.0, 217.0}, {50.0, 10.0}, {70.0, 135.0}}) {
    const double gsd = 0.5;
    const auto simulation = box_scene(zenith_deg, azimuth_deg, 66, 24, gsd, 8);
    const auto image = rendered(simulation);
    double worst = 0;
    int near = 0, dark_pixels = 0;
    for (int line = 0; line < image.lines; ++line) {
      const auto groups = sensors::make_ray_groups(simulation.instruments[0], line, 1);
      for (int pixel = 0; pixel < image.pixels; ++pixel) {
        const auto count = count_pixel(simulation, groups[std::size_t(pixel) / RC_GROUP_WIDTH], pixel);
        const double lit = image.layer(line, pixel, render::truth::sun_fraction) * kSide * kSide;
        near += count.near;
        dark_pixels += lit < 0.5;
        worst = std::max({worst, count.lit - lit, lit - count.lit - count.near});
      }
    }
    MESSAGE("sun " << zenith_deg << ", " << azimuth_deg << ": worst difference " << worst << " samples, " << near
                   << " of " << image.lines * image.pixels * kSide * kSide << " too close to tell, " << dark_pixels
                   << " pixels in full shadow");
    CHECK(worst < 1e-3);
    CHECK(near < 0.01 * image.lines * image.pixels * kSide * kSide);
    if (zenith_deg > 0) CHECK(dark_pixels > 10);
    if (azimuth_deg == 270) {  // shadow to the east: its length along the middle line, from the dark part of the pixels
      double length = 0;
      for (int pixel = 0; pixel < image.pixels; ++pixel)
        length += (1 - image.layer(12, pixel, render::truth::sun_fraction)) * gsd;
      const double expected = kHeight * std::tan(base::rad_from_deg(zenith_deg));
      MESSAGE("shadow " << length << " m long, closed form " << expected);
      // the camera, 8 m east, sees the dark east face as well; each end falls between two samples
      CHECK(std::abs(length - (expected + (8 - kHalf) * kHeight / (500 - kHeight))) < gsd / kSide);
    }
  }
}

TEST_CASE("S63 sun just above, at and below the horizon on a plane: cosine of the zenith, then the sky alone") {
  for (const double zenith_deg : {85.0, 89.9, 89.99}) {  // the plane never shades itself
    const auto image = rendered(box_scene(zenith_deg, 200, 12, 4, 1, 0, false), 1000, 2);
    const double expected = 0.3 * (1000 * std::cos(base::rad_from_deg(zenith_deg)) / kPi + 2);
    for (int line = 0; line < 4; ++line)
      for (int pixel = 0; pixel < 12; ++pixel) {
        CHECK(image.layer(line, pixel, render::truth::sun_fraction) == doctest::Approx(1).epsilon(1e-6));
        CHECK(image.at(line, pixel, 1) == doctest::Approx(expected).epsilon(1e-5));
      }
  }
  for (const double zenith_deg : {90.0, 95.0, 120.0, 180.0}) {
    const auto image = rendered(box_scene(zenith_deg, 200, 12, 4, 1, 0, false), 1000, 2);
    for (int line = 0; line < 4; ++line)
      for (int pixel = 0; pixel < 12; ++pixel) {
        CHECK(image.layer(line, pixel, render::truth::sun_fraction) == 0);
        CHECK(image.at(line, pixel, 1) == doctest::Approx(0.3 * 2).epsilon(1e-6));
      }
  }
}

TEST_CASE("S63 S9 views 80 to 89 degrees off nadir hit the plane where the rays of the kernels meet it in double") {
  for (const double off_nadir_deg : {80.0, 85.0, 88.0, 89.0}) {
    auto simulation = box_scene(40, 160, 8, 8, 1, 0, false);
    auto& camera = simulation.instruments[0];
    camera.poses[0].pitch_deg = off_nadir_deg;
    camera.poses[0].heading_deg = 30;
    camera.ifov_along_rad = camera.ifov_across_rad = 2e-5;
    camera.samples_u = camera.samples_v = 1;
    atmos::UniformAir air;
    air.sky_radiance = [](double) { return 20.0; };
    air.path_radiance = [](double) { return 3.0; };
    air.sun_zenith_deg = 40;
    air.sun_azimuth_deg = 160;
    const auto image = test::render_image(simulation, atmos::uniform_table(air, {0.3, 1.0, 4.0}));
    const double expected = 0.3 * (1000 * std::cos(base::rad_from_deg(40)) / kPi + 20) + 3;
    double worst_place = 0, worst_range = 0, worst_radiance = 0, largest = 0;
    for (int line = 0; line < 8; ++line) {
      const auto groups = sensors::make_ray_groups(camera, line, 1);
      for (int pixel = 0; pixel < 8; ++pixel) {
        const auto& g = groups[std::size_t(pixel) / RC_GROUP_WIDTH];
        const double a = pixel % RC_GROUP_WIDTH - 1.5, dx = g.d0.x + a * g.du.x, dy = g.d0.y + a * g.du.y,
                     dz = g.d0.z + a * g.du.z;
        const double t = g.origin.z / -dz, range = t * std::sqrt(dx * dx + dy * dy + dz * dz);
        worst_place = std::max({worst_place, std::abs(image.layer(line, pixel, render::truth::x_m) - t * dx) / range,
                                std::abs(image.layer(line, pixel, render::truth::y_m) - t * dy) / range});
        worst_range = std::max(worst_range, std::abs(image.layer(line, pixel, render::truth::range_m) / range - 1));
        worst_radiance = std::max(worst_radiance, std::abs(image.at(line, pixel, 0) / expected - 1));
        largest = std::max(largest, range);
        CHECK(image.layer(line, pixel, render::truth::sun_fraction) == doctest::Approx(1).epsilon(1e-6));
        CHECK(image.layer(line, pixel, render::truth::view_zenith_deg) == doctest::Approx(off_nadir_deg).epsilon(1e-4));
      }
    }
    MESSAGE(off_nadir_deg << " degrees off nadir, " << largest << " m: worst place " << worst_place << " and range "
                          << worst_range << " of the range, radiance " << worst_radiance);
    CHECK(worst_place < 1e-5);  // direction in fp32: 6e-8 / cos(89 deg) = 3.4e-6
    CHECK(worst_range < 1e-5);
    CHECK(worst_radiance < 1e-5);
  }
}

TEST_CASE("S63 a view that meets the horizon is refused with a clear message") {
  auto simulation = box_scene(40, 160, 8, 8, 1, 0, false);
  simulation.instruments[0].poses[0].pitch_deg = 89.9;
  CHECK_THROWS_WITH_AS(rendered(simulation), doctest::Contains("looks up or level"), std::runtime_error);
}
