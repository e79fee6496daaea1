// Sky that a wall hides, through the whole chain (S15, S16, S18): a plane beside a tall long wall. Oracles: the same
// sky directions summed here in double, each judged against the wall in closed form; and the closed view factor of a
// rectangle that stands on the plane of a small level element (Howell, A Catalog of Radiation Heat Transfer
// Configuration Factors, B-4).
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "atmos_tables/clear_sky.h"
#include "host/base/units.h"
#include "atmos_tables/synthetic.h"
#include "host/sensors/ray_groups.h"
#include "kernels/sampling/sampler.h"
#include "host/render/truth.h"
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
scene::Simulation wall_scene(const Wall& wall, int directions) {
  scene::Simulation simulation;
  const auto ground = test::add_material(simulation.scene, "ground", kReflectance);
  const double l = wall.half_length_m, nx = wall.nx(), ny = wall.ny();
  test::place(simulation.scene, test::rectangle({-400, -400, 0}, {800, 0, 0}, {0, 800, 0}, ground));
  test::place(simulation.scene,
              test::rectangle({-l * ny, l * nx, 0}, {2 * l * ny, -2 * l * nx, 0}, {0, 0, wall.height_m}, ground));
  finish_top_tree(simulation.scene);
  simulation.sky_directions = directions;
  auto camera = test::nadir_camera(64, 64, 1000, 0.25, 12.6 * nx, 12.6 * ny);
  camera.samples_u = camera.samples_v = 1;
  simulation.instruments = {camera};
  return simulation;
}

/// Where the ray of a pixel's centre meets z = 0, from the very rays the kernels get.
struct GroundPoint {
  double x, y, sec;
};
/// (u, v): from the pixel's centre, in pixels.
GroundPoint ground_point(const scene::Instrument& camera, int line, int pixel, double u = 0, double v = 0) {
  const auto group = sensors::make_ray_groups(camera, line, 1).at(std::size_t(pixel) / RC_GROUP_WIDTH);
  const double a = pixel % RC_GROUP_WIDTH - 0.5 * (RC_GROUP_WIDTH - 1) + u;
  const double dx = group.d0.x + a * group.du.x + v * group.dv.x, dy = group.d0.y + a * group.du.y + v * group.dv.y,
               dz = group.d0.z + a * group.du.z + v * group.dv.z;
  const double t = -double(group.origin.z) / dz;
  return {group.origin.x + t * dx, group.origin.y + t * dy, std::sqrt(dx * dx + dy * dy + dz * dz) / -dz};
}

/// Irradiance per sky component on level ground that the pixel's directions lose to the wall, and whether one of them
/// was too close to an edge to tell.
struct Blocked {
  std::array<double, 4> sum{};
  int edges = 0;
};
/// Part of the directions that sample s looks into (each `share` times): as many as there are over `share`, and no two
/// samples' parts meet.
bool shares(int share, std::uint64_t seed, std::uint32_t number, int s, int k) {
  const int turn =
      share == 1 ? 0 : int(rc_hash(static_cast<std::uint32_t>(seed), number, 1u, 21u) % std::uint32_t(share));
  const int part = (s + s / share + turn) % share;
  return (share < 8 ? k : k + k / share) % share == part;
}

Blocked blocked_sky(const Wall& wall, const plan::Plan& plan, std::uint64_t seed, std::uint32_t number,
                    const GroundPoint& at, int s = 0) {
  const std::uint32_t set =
      rc_hash(static_cast<std::uint32_t>(seed), number, 0u, 21u) % static_cast<std::uint32_t>(plan.sky.sets);
  Blocked out;
  for (int k = 0; k < plan.sky.directions; ++k) {
    if (!shares(plan.sky.share, seed, number, s, k)) continue;
    const std::size_t i = std::size_t(set) * plan.sky.directions + k;
    const auto& d = plan.sky.direction[i];
    const auto& w = plan.sky.weight[i];
    const auto answer = wall.ask(at.x, at.y, d.x, d.y, d.z);
    out.edges += answer == Wall::Answer::edge;
    if (answer != Wall::Answer::blocked) continue;
    const float component[4] = {w.x, w.y, w.z, w.w};
    for (int m = 0; m < 4; ++m) out.sum[m] += plan.sky.share * double{component[m]} * d.z;
  }
  return out;
}

}  // namespace

TEST_CASE("S16 uniform sky blocked by a wall equals the same directions summed in double to 1e-5") {
  for (const double facing_deg : {90.0, 217.0}) {  // an axis-parallel and an oblique wall
    const Wall wall{facing_deg};
    const auto simulation = wall_scene(wall, 16);
    const auto image = test::render_image(simulation, atmos::uniform_sky_table(0, kSkyRadiance, {0.3, 1.0, 4.0}));
    double worst = 0;
    int judged = 0, shaded = 0;
    for (int line = 0; line < 64; ++line)
      for (int pixel = 0; pixel < 64; ++pixel) {
        const auto at = ground_point(simulation.instruments[0], line, pixel);
        const auto blocked = blocked_sky(wall, image.plan, simulation.seed, std::uint32_t(line * 64 + pixel), at);
        if (blocked.edges) continue;
        ++judged;
        shaded += blocked.sum[0] > 0;
        for (int band = 0; band < image.bands; ++band)
          worst = std::max(
              worst, std::abs(image.at(line, pixel, band) / (kReflectance * kSkyRadiance) - (1 - blocked.sum[0])));
      }
    MESSAGE("wall facing " << facing_deg << ": worst difference " << worst << " of the open sky, " << judged
                           << " pixels judged");
    CHECK(worst < 1e-5);
    CHECK(judged > 4050);  // a direction in 1e4 is too close to an edge
    CHECK(shaded > 4000);
  }
}

TEST_CASE("S16 directions shared out among a pixel's samples equal each sample's own, summed in double, to 1e-5") {
  for (const auto& [share, columns, lines] : {std::array{2, 4, 4}, {4, 5, 3}, {8, 11, 11}, {16, 6, 6}, {3, 4, 4}}) {
    const Wall wall{217};
    auto simulation = wall_scene(wall, 48);
    simulation.sky_share = share;
    auto& camera = simulation.instruments[0];
    camera.samples_u = columns, camera.samples_v = lines;
    const auto image = test::render_image(simulation, atmos::uniform_sky_table(0, kSkyRadiance, {0.3, 1.0, 4.0}));
    REQUIRE(image.plan.sky.share == share);
    double worst = 0;
    int judged = 0;
    for (int line = 0; line < 64; line += 3)
      for (int pixel = 0; pixel < 64; ++pixel) {
        double sum = 0;
        int edges = 0;
        for (int s = 0; s < columns * lines; ++s) {
          const auto at =
              ground_point(camera, line, pixel, (s % columns + 0.5) / columns - 0.5, (s / columns + 0.5) / lines - 0.5);
          const auto blocked = blocked_sky(wall, image.plan, simulation.seed, std::uint32_t(line * 64 + pixel), at, s);
          edges += blocked.edges, sum += blocked.sum[0] / (columns * lines);
        }
        if (edges) continue;
        ++judged;
        worst = std::max(worst, std::abs(image.at(line, pixel, 0) / (kReflectance * kSkyRadiance) - (1 - sum)));
      }
    MESSAGE("share " << share << " of " << columns << " x " << lines << " samples: worst difference " << worst
                     << " of the open sky, " << judged << " pixels judged");
    CHECK(worst < 1e-5);
    CHECK(judged > 900);
  }
}

TEST_CASE("S18 clear sky and sun beside a wall equal the same directions summed in double to 1e-5") {
  for (const double sun_azimuth_deg : {80.0, 265.0}) {  // in front of the wall, and behind it: shadow 18 m long
    const Wall wall{90};
    auto simulation = wall_scene(wall, 16);
    simulation.sun.zenith_deg = 31;
    simulation.sun.azimuth_deg = sun_azimuth_deg;
    const auto table = atmos::build_clear_sky(simulation.atmosphere, simulation.sun, 1000.0,
                                              atmos::wavelength_grid(0.45, 0.95, 0.005), {0.0});
    const auto image = test::render_image(simulation, table);
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
    for (int line = 0; line < 64; ++line)
      for (int pixel = 0; pixel < 64; ++pixel) {
        const auto at = ground_point(simulation.instruments[0], line, pixel);
        const auto blocked = blocked_sky(wall, image.plan, simulation.seed, std::uint32_t(line * 64 + pixel), at);
        const auto sun = wall.ask(at.x, at.y, s[0], s[1], s[2]);
        if (blocked.edges || sun == Wall::Answer::edge) continue;
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
            expected += baked(1 + m) * (open_sky[m] - blocked.sum[m]);
            whole += baked(1 + m) * open_sky[m];
          }
          worst = std::max(worst, std::abs(image.at(line, pixel, band) - expected) / whole);
        }
        CHECK(image.layer(line, pixel, render::truth::sun_fraction) == (sun == Wall::Answer::free ? 1.0f : 0.0f));
      }
    MESSAGE("sun at azimuth " << sun_azimuth_deg << ": worst difference " << worst << " of the open radiance, "
                              << judged << " pixels judged, " << sunlit << " sunlit, " << image.plan.sky_components
                              << " components");
    CHECK(worst < 1e-5);
    CHECK(judged > 4000);
    CHECK((sun_azimuth_deg < 180 ? sunlit == judged : sunlit > 500 && sunlit < judged - 500));
  }
}

TEST_CASE("S16 sky beside a wall: mean within 4 standard errors of the view factor, rms below 6 % and 0.3 %") {
  struct Case {
    int directions, share;
    double limit;
  };
  // One sample a pixel, so that a share of 8 leaves it 2 directions of 16, which part the pixel's hash says: noisy, yet
  // without bias.
  for (const auto& [directions, share, limit] : {Case{16, 1, 0.06}, {1024, 1, 0.003}, {16, 8, 0.6}, {1024, 16, 0.03}}) {
    const Wall wall{90};
    auto simulation = wall_scene(wall, directions);
    simulation.sky_share = share;
    const auto image = test::render_image(simulation, atmos::uniform_sky_table(0, kSkyRadiance, {0.3, 1.0, 4.0}));
    double sum = 0, square = 0;
    for (int line = 0; line < 64; ++line)
      for (int pixel = 0; pixel < 64; ++pixel) {
        const auto at = ground_point(simulation.instruments[0], line, pixel);
        const double error =
            image.at(line, pixel, 0) / (kReflectance * kSkyRadiance) - (1 - wall.view_factor(at.x, at.y));
        sum += error;
        square += error * error;
      }
    const double mean = sum / 4096, rms = std::sqrt(square / 4096),
                 standard_error = std::sqrt((square / 4096 - mean * mean) / 4095);
    MESSAGE(directions << " directions, share " << share << ": mean error " << mean / standard_error
                       << " standard errors, rms " << 100 * rms << " % of the open sky");
    CHECK(std::abs(mean) < 4 * standard_error);
    CHECK(rms < limit);
  }
}
