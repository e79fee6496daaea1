// Sky that a wall hides, through the whole chain (S15, S16, S18): a plane beside a tall long wall. Oracles: the same
// rays into the sky summed here in double, each judged against the wall in closed form; and the closed view factor of a
// rectangle that stands on the plane of a small level element (Howell, A Catalog of Radiation Heat Transfer
// Configuration Factors, B-4).
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "atmos_tables/clear_sky.h"
#include "host/base/units.h"
#include "atmos_tables/synthetic.h"
#include "host/plan/sky_rays.h"
#include "host/render/truth.h"
#include "host/sensors/ray_groups.h"
#include "kernels/sampling/sampler.h"
#include "kernels/sampling/sky_rays.h"
#include "tests/support/chance_checks.h"
#include "tests/support/render_kit.h"

namespace {

using namespace raycube;
constexpr double kPi = std::numbers::pi;
constexpr double kReflectance = 0.4, kSkyRadiance = 30;

/// Stands on z = 0 through the origin; its front looks towards azimuth `facing_deg`.
struct Wall {
  double facing_deg, half_length_m = 150, height_m = 30;
  double nx() const { return std::sin(base::rad_from_deg(facing_deg)); }
  double ny() const { return std::cos(base::rad_from_deg(facing_deg)); }
  double distance(double x, double y) const { return x * nx() + y * ny(); }
  double along(double x, double y) const { return x * ny() - y * nx(); }

  enum class Answer { free, blocked, edge };
  /// From a ground point in front towards (dx, dy, dz). `edge`: nearer to the wall's edge than the 1e-4 m to which fp32
  /// knows a ground point 1000 m below the camera, times what the slope of the ray makes of it.
  Answer ask(double x, double y, double dx, double dy, double dz) const {
    const double approach = -(dx * nx() + dy * ny());
    if (approach <= 1e-9) return Answer::free;
    const double t = distance(x, y) / approach, z = t * dz, side = std::abs(along(x, y) + t * along(dx, dy));
    const double inside = std::min(height_m - z, half_length_m - side);
    if (std::abs(inside) < 1e-4 * (1 + 1 / approach)) return Answer::edge;
    return inside > 0 ? Answer::blocked : Answer::free;
  }
  /// Share of the irradiance of a uniform sky that the wall takes from a level element at (x, y).
  double view_factor(double x, double y) const {
    const double c = distance(x, y), s = std::hypot(c, height_m);
    const auto half = [&](double b) { return (std::atan(b / c) - c / s * std::atan(b / s)) / (2 * kPi); };
    return half(half_length_m - along(x, y)) + half(half_length_m + along(x, y));
  }
};

/// 64 x 64 pixels of 0.25 m, one sample each, 1.2 to 24 m before the wall.
scene::Simulation wall_scene(const Wall& wall, int rays) {
  scene::Simulation simulation;
  const auto ground = test::add_material(simulation.scene, "ground", kReflectance);
  const double l = wall.half_length_m, nx = wall.nx(), ny = wall.ny();
  test::place(simulation.scene, test::rectangle({-400, -400, 0}, {800, 0, 0}, {0, 800, 0}, ground));
  test::place(simulation.scene,
              test::rectangle({-l * ny, l * nx, 0}, {2 * l * ny, -2 * l * nx, 0}, {0, 0, wall.height_m}, ground));
  finish_top_tree(simulation.scene);
  simulation.sky_directions = rays;
  auto camera = test::nadir_camera(64, 64, 1000, 0.25, 12.6 * nx, 12.6 * ny);
  camera.samples_u = camera.samples_v = 1;
  simulation.instruments = {camera};
  return simulation;
}

/// Where the ray of a pixel's centre meets z = 0, from the very rays the kernels get.
struct GroundPoint {
  double x, y, sec;
};
/// groups: of the pixel's line; (u, v): from the pixel's centre, in pixels.
GroundPoint ground_point(const std::vector<shared::RayGroup>& groups, int pixel, double u = 0, double v = 0) {
  const auto& group = groups.at(std::size_t(pixel) / RC_GROUP_WIDTH);
  const double a = pixel % RC_GROUP_WIDTH - 0.5 * (RC_GROUP_WIDTH - 1) + u;
  const double dx = group.d0.x + a * group.du.x + v * group.dv.x, dy = group.d0.y + a * group.du.y + v * group.dv.y,
               dz = group.d0.z + a * group.du.z + v * group.dv.z;
  const double t = -double(group.origin.z) / dz;
  return {group.origin.x + t * dx, group.origin.y + t * dy, std::sqrt(dx * dx + dy * dy + dz * dz) / -dz};
}

/// Irradiance per sky component that a pixel's rays bring to level ground beyond what is taken for granted, mean of
/// its samples, and how many of them passed too close to an edge to tell.
struct Met {
  std::array<double, 4> sum{};
  int edges = 0, hidden = 0;
};
Met met_sky(const Wall& wall, const plan::Plan& plan, const scene::Simulation& simulation,
            const std::vector<shared::RayGroup>& groups, int line, int pixel) {
  const auto& camera = simulation.instruments[0];
  const auto nu = rc_u32(camera.samples_u), nv = rc_u32(camera.samples_v), samples = nu * nv,
             rays = rc_u32(plan.sky.rays), number = rc_u32(line * camera.pixels + pixel),
             seed = plan.sky.hash_seed(testing::seed(simulation.seed));
  const int sampler = static_cast<int>(camera.sampler);
  const double known = double{plan.sky.known(0)};
  Met out;
  for (rc_u32 part = 0; part < rc_sky_parts(samples, rays); ++part) {
    const SkyPart share = rc_sky_shares(sampler, nu, nv, rays, seed, number, part);
    for (rc_u32 i = 0; i < share.rays; ++i) {
      const auto ray =
          rc_sky_ray(plan::sky_density(plan), seed, number, rc_sky_number(samples, rays, part, i), 0, 0, 1);
      if (!(ray.z > 0)) continue;
      float u, v;
      rc_sample_uv(sampler, int(nu), int(nv), 1, static_cast<rc_u32>(testing::seed(simulation.seed)), number,
                   int(rc_sky_sample(share, nu, samples, rays, seed, number, part, i)), &u, &v);
      const auto at = ground_point(groups, pixel, double{u}, double{v});
      const auto answer = wall.ask(at.x, at.y, double{ray.x}, double{ray.y}, double{ray.z});
      out.edges += answer == Wall::Answer::edge, out.hidden += answer == Wall::Answer::blocked;
      const double open = answer == Wall::Answer::blocked ? 0 : 1;
      const auto light =
          plan::sky_value(plan.sky_basis, plan.sky.sun_azimuth_rad, double{ray.x}, double{ray.y}, double{ray.z});
      for (std::size_t m = 0; m < 4; ++m)
        out.sum[m] +=
            double{share.scale} / samples * (open - known) * light[m] * double{ray.facing} / double{ray.density};
    }
  }
  return out;
}

/// Everything of a scene takes this share of the open sky for granted.
std::function<void(plan::Plan&)> taking(float share) {
  return [share](plan::Plan& plan) { plan.sky.open_share = {share}; };
}

}  // namespace

TEST_CASE(
    "S16 uniform sky blocked by a wall equals the same rays summed in double to 1e-6, however they are shared out") {
  struct Case {
    double facing_deg;  // an axis-parallel or an oblique wall
    scene::SamplerKind sampler;
    int columns, lines, rays;
    float known;
  };
  using enum scene::SamplerKind;
  for (const Case& c : {Case{90, grid, 1, 1, 16, 1},
                        {217, grid, 1, 1, 16, 0.5f},
                        {217, grid, 4, 4, 16, 1},
                        {217, lattice, 5, 3, 7, 0.25f},
                        {90, jittered, 11, 11, 48, 0},
                        {217, grid, 6, 5, 3, 1},
                        {217, lattice, 4, 4, 100, 0.5f}}) {
    const Wall wall{c.facing_deg};
    auto simulation = wall_scene(wall, c.rays);
    auto& camera = simulation.instruments[0];
    camera.samples_u = c.columns, camera.samples_v = c.lines, camera.sampler = c.sampler;
    const auto image =
        test::render_image(simulation, atmos::uniform_sky_table(0, kSkyRadiance, {0.3, 1.0, 4.0}), {}, taking(c.known));
    REQUIRE(image.plan.sky.rays == c.rays);
    double worst = 0;
    int judged = 0, shaded = 0;
    const int step = c.columns > 1 ? 3 : 1;
    for (int line = 0; line < 64; line += step) {
      const auto groups = sensors::make_ray_groups(camera, line, 1);
      for (int pixel = 0; pixel < 64; ++pixel) {
        const auto met = met_sky(wall, image.plan, simulation, groups, line, pixel);
        if (met.edges) continue;
        ++judged, shaded += met.hidden > 0;
        for (int band = 0; band < image.bands; ++band)
          worst = std::max(worst, std::abs(image.at(line, pixel, band) / (kReflectance * kSkyRadiance) -
                                           (double{c.known} + met.sum[0])));
      }
    }
    MESSAGE(c.rays << " rays of " << c.columns << " x " << c.lines << " samples: worst difference " << worst
                   << " of the open sky, " << judged << " pixels judged, " << shaded << " shaded");
    CHECK(worst < 1e-6);
    CHECK(judged > (c.columns > 1 ? 1350 : 4050));  // a ray in 1e4 is too close to an edge
    CHECK(shaded > judged / 2);
  }
}

TEST_CASE("S18 clear sky and sun beside a wall equal the same rays summed in double to 1e-5") {
  for (const double sun_azimuth_deg : {80.0, 265.0}) {  // in front of the wall, and behind it: shadow 18 m long
    const Wall wall{90};
    auto simulation = wall_scene(wall, 16);
    simulation.sun.zenith_deg = 31;
    simulation.sun.azimuth_deg = sun_azimuth_deg;
    const auto table = atmos::build_clear_sky(simulation.atmosphere, simulation.sun, 1000.0,
                                              atmos::wavelength_grid(0.45, 0.95, 0.005), {0.0});
    const float known = sun_azimuth_deg < 180 ? 1.0f : 0.5f;
    const auto image = test::render_image(simulation, table, {}, [known](plan::Plan& plan) {
      plan.sky.open_share = {known};
      plan.sky.cosine_share = 0.4, plan.sky.sun_share = 0.5, plan.sky.asymmetry = 0.7;  // every part of the law
    });
    REQUIRE(image.plan.sky_components > 1);
    const auto& view = image.plan.view;
    const auto source = plan::bake_row(image.plan, simulation.scene, 1),
               path = plan::bake_row(image.plan, simulation.scene, 0);
    const auto& s = image.plan.sun_direction;
    const int middle = (image.plan.irradiance.size - 1) / 2;
    const auto& open = image.plan.irradiance.value[std::size_t(middle) * image.plan.irradiance.size + middle];
    const double open_sky[4] = {open.x, open.y, open.z, open.w};
    REQUIRE(image.plan.path_channels() == 1);  // a field of one degree
    double worst = 0;
    int judged = 0, sunlit = 0;
    for (int line = 0; line < 64; ++line) {
      const auto groups = sensors::make_ray_groups(simulation.instruments[0], line, 1);
      for (int pixel = 0; pixel < 64; ++pixel) {
        const auto at = ground_point(groups, pixel);
        const auto met = met_sky(wall, image.plan, simulation, groups, line, pixel);
        const auto sun = wall.ask(at.x, at.y, s[0], s[1], s[2]);
        if (met.edges || sun == Wall::Answer::edge) continue;
        ++judged;
        sunlit += sun == Wall::Answer::free;
        const double t = view.count > 1 ? std::clamp((at.sec - view.first) / view.step, 0.0, view.count - 1.0) : 0.0;
        const int v = std::min(int(t), std::max(0, view.count - 2));
        for (int band = 0; band < image.bands; ++band) {
          const auto baked = [&](int k) {  // of source k on the ground (height node 0), between the view nodes
            const auto e = [&](int node) {
              return double{source[std::size_t(k * image.plan.height.count * view.count + node) * 16 + band]};
            };
            return view.count > 1 ? e(v) * (1 - (t - v)) + e(v + 1) * (t - v) : e(0);
          };
          double expected = path[band] + (sun == Wall::Answer::free ? baked(0) * s[2] : 0.0),
                 whole = path[band] + baked(0) * s[2];
          for (int m = 0; m < image.plan.sky_components; ++m) {
            expected += baked(1 + m) * (double{known} * open_sky[m] + met.sum[std::size_t(m)]);
            whole += baked(1 + m) * open_sky[m];
          }
          worst = std::max(worst, std::abs(image.at(line, pixel, band) - expected) / whole);
        }
        CHECK(image.layer(line, pixel, render::truth::sun_fraction) == (sun == Wall::Answer::free ? 1.0f : 0.0f));
      }
    }
    MESSAGE("sun at azimuth " << sun_azimuth_deg << ": worst difference " << worst << " of the open radiance, "
                              << judged << " pixels judged, " << sunlit << " sunlit, " << image.plan.sky_components
                              << " components");
    CHECK(worst < 1e-5);
    CHECK(judged > 4000);
    CHECK((sun_azimuth_deg < 180 ? sunlit == judged : sunlit > 500 && sunlit < judged - 500));
  }
}

TEST_CASE("S16 sky beside a wall: mean within 4 standard errors of the view factor, rms by rays, whatever is granted") {
  struct Case {
    int samples, rays;  // along and across, and of the pixel
    double limit;
  };
  for (const auto& [samples, rays, limit] :
       {Case{1, 1, 0.5}, {1, 4, 0.17}, {1, 16, 0.06}, {1, 64, 0.02}, {1, 1024, 0.0026}, {4, 16, 0.06}, {8, 64, 0.02}})
    for (const float known : {1.0f, 0.5f, 0.0f}) {
      if (known < 1 && rays > 64) continue;
      const Wall wall{90};
      auto simulation = wall_scene(wall, rays);
      simulation.instruments[0].samples_u = simulation.instruments[0].samples_v = samples;
      const auto image =
          test::render_image(simulation, atmos::uniform_sky_table(0, kSkyRadiance, {0.3, 1.0, 4.0}), {}, taking(known));
      double sum = 0, square = 0;
      for (int line = 0; line < 64; ++line) {
        const auto groups = sensors::make_ray_groups(simulation.instruments[0], line, 1);
        for (int pixel = 0; pixel < 64; ++pixel) {
          double view_factor = 0;
          for (int s = 0; s < samples; ++s) {  // along the wall it does not change
            const auto at = ground_point(groups, pixel, (s + 0.5) / samples - 0.5);
            view_factor += wall.view_factor(at.x, at.y) / samples;
          }
          const double error = image.at(line, pixel, 0) / (kReflectance * kSkyRadiance) - (1 - view_factor);
          sum += error;
          square += error * error;
        }
      }
      const double mean = sum / 4096, rms = std::sqrt(square / 4096),
                   standard_error = std::sqrt((square / 4096 - mean * mean) / 4095);
      MESSAGE(rays << " rays of " << samples << " x " << samples << " samples, " << known
                   << " taken for granted: mean error " << mean / standard_error << " standard errors, rms "
                   << 100 * rms << " % of the open sky");
      CHECK_WITHIN(mean, 4 * standard_error);
      CHECK_BELOW(rms, limit);
    }
}
