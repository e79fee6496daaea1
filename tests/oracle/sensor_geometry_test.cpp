// Ray generation against closed forms written out here in double with rotation matrices (the program uses quaternions).
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <random>

#include "host/base/error.h"
#include "host/sensors/ray_groups.h"
#include "host/sensors/view_bounds.h"

using namespace raycube;
using Vec = std::array<double, 3>;
using Mat = std::array<Vec, 3>;  // rows

namespace {

constexpr double kDeg = M_PI / 180;

Mat operator*(const Mat& a, const Mat& b) {
  Mat c{};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      for (int k = 0; k < 3; ++k) c[i][j] += a[i][k] * b[k][j];
  return c;
}

// Columns: forward, right, down in east-north-up. Textbook Rz(yaw) Ry(pitch) Rx(roll) from body to north-east-down.
Mat enu_from_body(const scene::Pose& p) {
  const double cy = std::cos(p.heading_deg * kDeg), sy = std::sin(p.heading_deg * kDeg),
               cp = std::cos(p.pitch_deg * kDeg), sp = std::sin(p.pitch_deg * kDeg), cr = std::cos(p.roll_deg * kDeg),
               sr = std::sin(p.roll_deg * kDeg);
  const Mat enu_from_ned{{{0, 1, 0}, {1, 0, 0}, {0, 0, -1}}};
  return enu_from_ned * Mat{{{cy, -sy, 0}, {sy, cy, 0}, {0, 0, 1}}} * Mat{{{cp, 0, sp}, {0, 1, 0}, {-sp, 0, cp}}} *
         Mat{{{1, 0, 0}, {0, cr, -sr}, {0, sr, cr}}};
}

Vec body_direction(const scene::Instrument& c, int line, double sample, double v) {
  const double x = (sample + 0.5 - c.pixels / 2.0) * c.ifov_across_rad;
  if (c.kind == scene::InstrumentKind::framing) return {-(line + v + 0.5 - c.lines / 2.0) * c.ifov_along_rad, x, 1};
  if (c.kind == scene::InstrumentKind::pushbroom) return {v * c.ifov_along_rad, -x, 1};
  return {v * c.ifov_along_rad, -std::sin(x), std::cos(x)};
}

const scene::Pose& pose_of(const scene::Instrument& c, int line, int sample) {
  switch (c.kind) {
    case scene::InstrumentKind::framing:
      return c.poses[0];
    case scene::InstrumentKind::pushbroom:
      return c.poses[line];
    default:
      return c.poses[static_cast<std::size_t>(line) * c.pixels + sample];
  }
}

Vec direction(const scene::Instrument& c, int line, int sample, double u, double v) {
  const Mat m = enu_from_body(pose_of(c, line, sample));
  Vec b = body_direction(c, line, sample + (c.kind == scene::InstrumentKind::whiskbroom ? 0 : u), v);
  if (c.kind ==
      scene::InstrumentKind::whiskbroom) {  // within a pixel the image plane is flat: tangent of the scan circle
    const double x = (sample + 0.5 - c.pixels / 2.0) * c.ifov_across_rad;
    b[1] -= u * c.ifov_across_rad * std::cos(x);
    b[2] -= u * c.ifov_across_rad * std::sin(x);
  }
  Vec d{};
  for (int i = 0; i < 3; ++i) d[i] = m[i][0] * b[0] + m[i][1] * b[1] + m[i][2] * b[2];
  return d;
}

scene::Instrument make(scene::InstrumentKind kind, int pixels, int lines, bool tilted) {
  scene::Instrument c;
  c.name = "camera";
  c.kind = kind;
  c.pixels = pixels;
  c.lines = lines;
  c.ifov_across_rad = 1.0 / 610;
  c.ifov_along_rad = 1.25 / 610;
  c.motion = scene::PoseMotion::held;
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> unit(-1, 1);
  const int poses = kind == scene::InstrumentKind::framing     ? 1
                    : kind == scene::InstrumentKind::pushbroom ? lines
                                                               : lines * pixels;
  for (int i = 0; i < poses; ++i) {
    scene::Pose p{10, -20, 610, 0, 0, 0};
    if (tilted)
      p = {100 * unit(random), 100 * unit(random), 610 + 30 * unit(random),
           12 * unit(random),  9 * unit(random),   180 * unit(random)};
    c.poses.push_back(p);
  }
  return c;
}

struct FloatRay {
  Vec o, d;
};

// What a kernel makes of a group, in the kernel's own float operations.
FloatRay float_ray(const scene::Instrument& c, const shared::RayGroup& g, int sample, float u, float v) {
  const int width = sensors::pixels_per_group(c);
  const float a = static_cast<float>(sample % width - (width - 1) / 2.0) + u;
  return {{g.origin.x + v * g.ov.x, g.origin.y + v * g.ov.y, g.origin.z + v * g.ov.z},
          {g.d0.x + a * g.du.x + v * g.dv.x, g.d0.y + a * g.du.y + v * g.dv.y, g.d0.z + a * g.du.z + v * g.dv.z}};
}

constexpr std::array kKinds{scene::InstrumentKind::framing, scene::InstrumentKind::pushbroom,
                            scene::InstrumentKind::whiskbroom};
constexpr double kHalfUlp = 6e-8;  // relative rounding error of one float operation

}  // namespace

TEST_CASE("S9 every generated ray is the closed form in double, rounded: all kinds, tilted poses, odd widths") {
  for (const auto kind : kKinds) {
    const auto camera = make(kind, 37, 11, true);
    const auto groups = sensors::make_ray_groups(camera, 0, camera.lines);
    const int per_line = sensors::groups_per_line(camera), width = sensors::pixels_per_group(camera);
    REQUIRE(groups.size() == static_cast<std::size_t>(per_line) * camera.lines);
    CHECK(per_line == (kind == scene::InstrumentKind::whiskbroom ? 37 : 10));
    double worst = 0, worst_double = 0, worst_origin = 0;
    for (int line = 0; line < camera.lines; ++line)
      for (int sample = 0; sample < camera.pixels; ++sample)
        for (const auto& [u, v] : {std::array{0.f, 0.f}, {-0.5f, 0.5f}, {0.375f, -0.25f}}) {
          const auto ray = float_ray(camera, groups[line * per_line + sample / width], sample, u, v);
          const auto exact_ray = sensors::pixel_ray(camera, line, sample, u, v);
          const Vec exact = direction(camera, line, sample, u, v);
          const auto& pose = pose_of(camera, line, sample);
          const Vec origin{pose.x_m, pose.y_m, pose.z_m};
          for (int k = 0; k < 3; ++k) {
            worst = std::max(worst, std::abs(ray.d[k] - exact[k]));
            worst_double = std::max(worst_double, std::abs(exact_ray.direction[k] - exact[k]));
            worst_origin = std::max(worst_origin, std::abs(ray.o[k] - origin[k]));
          }
        }
    // |d| < 1.1: d0 rounds once, two products and two sums follow, du and dv are 500 times smaller
    CHECK(worst < 4 * kHalfUlp);
    CHECK(worst_double < 1e-14);
    CHECK(worst_origin < 700 * kHalfUlp);
  }
}

TEST_CASE("S9 rays of sensors 610 m, 20 km and 700 km up start just above the scene, on the closed form's rays") {
  constexpr double kTop_m = 35;
  for (const double height_m : {610.0, 2e4, 7e5})
    for (const auto kind : kKinds) {
      auto camera = make(kind, 37, 11, true);
      camera.psf_support_px = 3;
      camera.ifov_across_rad = 1 / height_m, camera.ifov_along_rad = 1.25 / height_m;
      for (auto& pose : camera.poses) pose.z_m += height_m - 610;
      const auto groups = sensors::make_ray_groups(camera, 0, camera.lines, kTop_m);
      const int per_line = sensors::groups_per_line(camera), width = sensors::pixels_per_group(camera);
      double worst = 0, lowest = 1e9, highest = -1e9;
      for (int line = 0; line < camera.lines; ++line)
        for (int sample = 0; sample < camera.pixels; ++sample)
          for (const auto& [u, v] : {std::array{0.f, 0.f}, {-1.5f, 1.5f}, {1.5f, -1.5f}, {0.375f, -0.25f}}) {
            const auto& g = groups[line * per_line + sample / width];
            const auto ray = float_ray(camera, g, sample, u, v);
            const float a = static_cast<float>(sample % width - (width - 1) / 2.0) + u;
            const double way = g.d0.w;
            const Vec start{ray.o[0] + way * (double{a} * g.du.x + double{v} * g.dv.x),
                            ray.o[1] + way * (double{a} * g.du.y + double{v} * g.dv.y),
                            ray.o[2] + way * (double{a} * g.du.z + double{v} * g.dv.z)};
            lowest = std::min(lowest, start[2]), highest = std::max(highest, start[2]);
            const auto exact = sensors::pixel_ray(camera, line, sample, u, v);
            const double t = -start[2] / ray.d[2], exact_t = -exact.origin_m.z / exact.direction.z;
            // The start rounds by its size, what follows by the few tens of metres left; offsets by theirs.
            const double size = std::abs(start[0]) + std::abs(start[1]) + std::abs(start[2]) + 3 * t;
            for (int k = 0; k < 2; ++k)
              worst = std::max(worst,
                               std::abs(start[k] + t * ray.d[k] - (exact.origin_m[k] + exact_t * exact.direction[k])) /
                                   (kHalfUlp * size));
          }
      INFO("height " << height_m << " m: lowest start " << lowest << ", highest " << highest << " m, worst " << worst
                     << " roundings");
      CHECK(worst < 4);
      CHECK(lowest > kTop_m);
      // A metre and 2e-5 of the height, and what a group's field of 7 x 3 pixels tilts by.
      CHECK(highest < kTop_m + 1 + 2.1e-5 * height_m + 7);
    }
}

TEST_CASE("S9 a sensor among the scene's heights, or no scene: rays start at the sensor") {
  const auto camera = make(scene::InstrumentKind::framing, 37, 11, true);
  for (const double top_m : {650.0, 1e4, std::numeric_limits<double>::infinity()})
    for (const auto& group : sensors::make_ray_groups(camera, 0, camera.lines, top_m)) {
      CHECK(group.d0.w == 0.0f);
      CHECK(group.origin.z == static_cast<float>(camera.poses[0].z_m));
    }
  scene::CompiledScene empty;
  empty.lo = {1, 1, 1}, empty.hi = {-1, -1, -1};
  CHECK(sensors::make_ray_groups(camera, empty, 0, 1).at(0).d0.w == 0.0f);
}

TEST_CASE("S9 round trip: ground point to pixel and back to the ground, roll, pitch and heading") {
  for (const auto kind : kKinds) {
    const auto camera = make(kind, 40, 20, true);
    const auto groups = sensors::make_ray_groups(camera, 0, camera.lines);
    const int width = sensors::pixels_per_group(camera), per_line = sensors::groups_per_line(camera);
    double worst_px = 0, worst_m = 0;
    for (int line = 0; line < camera.lines; ++line)
      for (int sample = 0; sample < camera.pixels; ++sample) {
        // pixel -> ground z = 0 with the float ray
        const float u = 0.3f, v = -0.4f;
        const auto ray = float_ray(camera, groups[line * per_line + sample / width], sample, u, v);
        const double t = -ray.o[2] / ray.d[2];
        const Vec ground{ray.o[0] + t * ray.d[0], ray.o[1] + t * ray.d[1], 0};
        // ground -> pixel: turn into the body frame (transpose) and project
        const auto& pose = pose_of(camera, line, sample);
        const Mat m = enu_from_body(pose);
        Vec b{};
        for (int k = 0; k < 3; ++k)
          b[k] = m[0][k] * (ground[0] - pose.x_m) + m[1][k] * (ground[1] - pose.y_m) + m[2][k] * (ground[2] - pose.z_m);
        double s, across;
        const double middle = camera.pixels / 2.0 - 0.5;
        if (kind == scene::InstrumentKind::framing) {
          s = b[1] / b[2] / camera.ifov_across_rad + middle;
          across = -b[0] / b[2] / camera.ifov_along_rad + camera.lines / 2.0 - 0.5 - line;
        } else if (kind == scene::InstrumentKind::pushbroom) {
          s = -b[1] / b[2] / camera.ifov_across_rad + middle;
          across = b[0] / b[2] / camera.ifov_along_rad;
        } else {  // scan angle of the pixel's centre, then the flat plane tangent to the scan circle there
          const double x = (sample - middle) * camera.ifov_across_rad;
          const double depth = -b[1] * std::sin(x) + b[2] * std::cos(x);
          s = sample + (-b[1] * std::cos(x) - b[2] * std::sin(x)) / depth / camera.ifov_across_rad;
          across = b[0] / depth / camera.ifov_along_rad;
        }
        worst_px = std::max({worst_px, std::abs(s - sample - u), std::abs(across - v)});
        // and back in double, from the pixel found
        const auto again = sensors::pixel_ray(camera, line, sample, s - sample, across);
        const double t2 = -again.origin_m.z / again.direction.z;
        worst_m = std::max({worst_m, std::abs(again.origin_m.x + t2 * again.direction.x - ground[0]),
                            std::abs(again.origin_m.y + t2 * again.direction.y - ground[1])});
      }
    // float directions: 4 half-ulp of 1 over an IFOV of 1.6e-3, and the origin's half ulp (3e-5 m of a 1 m pixel)
    CHECK(worst_px < 4 * kHalfUlp / camera.ifov_across_rad + 1.5 * 640 * kHalfUlp);
    CHECK(worst_m < 640 * kHalfUlp);  // both end on the same ground point but for the rounded origin
  }
}

TEST_CASE("S9 ground sample distance is range times IFOV; which way is up") {
  for (const auto kind : kKinds) {
    auto camera = make(kind, 8, 6, false);
    const auto ground = [&](int line, int sample, double u, double v) {
      const auto r = sensors::pixel_ray(camera, line, sample, u, v);
      const double t = -r.origin_m.z / r.direction.z;
      return Vec{r.origin_m.x + t * r.direction.x, r.origin_m.y + t * r.direction.y, 0};
    };
    const Vec a = ground(2, 4, 0, 0), b = ground(2, 4, 1, 0), c = ground(2, 4, 0, 1);
    const double sense = kind == scene::InstrumentKind::framing ? 1 : -1;
    // The whiskbroom's centre pixel looks half an IFOV off nadir, on a circle: 1 / cos^2 of that, 7e-7.
    CHECK(b[0] - a[0] == doctest::Approx(sense * 610 * camera.ifov_across_rad).epsilon(2e-6));
    CHECK(b[1] == doctest::Approx(a[1]));
    CHECK(c[1] - a[1] == doctest::Approx(-sense * 610 * camera.ifov_along_rad).epsilon(2e-6));
    // Heading 0: a framing image has sample 0 west, line 0 north; scanners are upright at heading 180.
    for (auto& pose : camera.poses) pose.heading_deg = kind == scene::InstrumentKind::framing ? 0 : 180;
    CHECK(ground(0, 0, 0, 0)[0] < ground(0, 7, 0, 0)[0]);
    CHECK(ground(0, 0, 0, -0.5)[1] > ground(0, 0, 0, 0.5)[1]);
  }
  // Right wing down looks to the left wing's side (west at heading 0); nose up looks ahead (north).
  auto camera = make(scene::InstrumentKind::framing, 1, 1, false);
  camera.poses[0].roll_deg = 10;
  auto d = sensors::pixel_ray(camera, 0, 0, 0, 0).direction;
  CHECK(d.x / -d.z == doctest::Approx(-std::tan(10 * kDeg)));
  camera.poses[0] = {0, 0, 610, 0, 10, 0};
  d = sensors::pixel_ray(camera, 0, 0, 0, 0).direction;
  CHECK(d.y / -d.z == doctest::Approx(std::tan(10 * kDeg)));
  camera.poses[0].heading_deg = 90;
  d = sensors::pixel_ray(camera, 0, 0, 0, 0).direction;
  CHECK(d.x / -d.z == doctest::Approx(std::tan(10 * kDeg)));
}

TEST_CASE("S9 whiskbroom: equal scan angles, so off-nadir pixels grow with 1 / cos squared") {
  const auto camera = make(scene::InstrumentKind::whiskbroom, 600, 1, false);
  const auto east = [&](double sample, double u) {
    const auto r = sensors::pixel_ray(camera, 0, static_cast<int>(sample), u, 0);
    return r.origin_m.x - r.direction.x * r.origin_m.z / r.direction.z;
  };
  for (int sample : {0, 100, 300, 599}) {
    const double angle = (sample + 0.5 - 300) * camera.ifov_across_rad;
    CHECK(east(sample, 0) - 10 == doctest::Approx(-610 * std::tan(angle)));
    const double gsd = east(sample, -1e-3) - east(sample, 1e-3);
    CHECK(gsd / 2e-3 == doctest::Approx(610 * camera.ifov_across_rad / std::pow(std::cos(angle), 2)).epsilon(1e-6));
  }
}

TEST_CASE("S10 moving pose: linear in time, continuous from line to line, and the slerp's half-way axes") {
  auto camera = make(scene::InstrumentKind::pushbroom, 9, 12, false);
  for (int line = 0; line < camera.lines; ++line)
    camera.poses[line] = {0.2 * line, 1.0 * line, 610 - 0.1 * line, 0.02 * line, -0.03 * line, 5 + 0.05 * line};
  camera.motion = scene::PoseMotion::moving;
  REQUIRE(sensors::pose_moves(camera));
  const auto groups = sensors::make_ray_groups(camera, 0, camera.lines);
  const int per_line = sensors::groups_per_line(camera);
  for (int line = 0; line < camera.lines; ++line)
    for (int sample = 0; sample < camera.pixels; ++sample) {
      const auto& g = groups[line * per_line + sample / 4];
      CHECK(g.ov.x == doctest::Approx(0.2).epsilon(1e-6));
      CHECK(g.ov.y == doctest::Approx(1.0).epsilon(1e-6));
      CHECK(g.ov.z == doctest::Approx(-0.1).epsilon(1e-6));
      // Axes at line +- 1/2 by the angles themselves: for three small rates slerp and linear angles differ by rate^2 /
      // 8
      const auto begin = sensors::pixel_ray(camera, line, sample, 0, -0.5),
                 end = sensors::pixel_ray(camera, line, sample, 0, 0.5);
      auto half = camera;
      half.motion = scene::PoseMotion::held;
      for (const double v : {-0.5, 0.5}) {
        half.poses[line] = {0, 0, 0, 0.02 * (line + v), -0.03 * (line + v), 5 + 0.05 * (line + v)};
        const Vec expected = direction(half, line, sample, 0, 0);
        const auto ray = sensors::pixel_ray(camera, line, sample, 0, v);
        for (int k = 0; k < 3; ++k) CHECK(std::abs(ray.direction[k] - expected[k]) < 0.25 * std::pow(0.06 * kDeg, 2));
        const auto f = float_ray(camera, g, sample, 0, static_cast<float>(v));
        // cross term: the rotation's dv is taken at the group's centre, up to 1.5 pixels away
        for (int k = 0; k < 3; ++k)
          CHECK(std::abs(f.d[k] - ray.direction[k]) < 4 * kHalfUlp + 1.5 * camera.ifov_across_rad * 0.06 * kDeg * 0.5);
      }
      const auto middle = sensors::pixel_ray(camera, line, sample, 0.2, 0);
      const auto start = sensors::pixel_ray(camera, line, sample, 0.2, -0.5),
                 stop = sensors::pixel_ray(camera, line, sample, 0.2, 0.5);
      for (int k = 0; k < 3; ++k) {
        CHECK(std::abs(middle.origin_m[k] - 0.5 * (start.origin_m[k] + stop.origin_m[k])) < 1e-12);
        CHECK(std::abs(middle.direction[k] - 0.5 * (start.direction[k] + stop.direction[k])) < 1e-12);
      }
      if (line > 0) {  // the last instant of one line is the first of the next (rotation: second order in the rate)
        const auto before = sensors::pixel_ray(camera, line - 1, sample, 0, 0.5);
        for (int k = 0; k < 3; ++k) {
          CHECK(std::abs(before.origin_m[k] - begin.origin_m[k]) < 1e-9);
          CHECK(std::abs(before.direction[k] - begin.direction[k]) < std::pow(0.06 * kDeg, 2));
        }
      }
      CHECK(end.origin_m.y - begin.origin_m.y == doctest::Approx(1.0));
    }
}

TEST_CASE("S9 pushbroom motion: held has no ov, automatic moves only when the footprints part") {
  auto camera = make(scene::InstrumentKind::pushbroom, 8, 10, false);
  camera.ifov_along_rad = camera.ifov_across_rad;
  camera.motion = scene::PoseMotion::automatic;
  for (int line = 0; line < 10; ++line) camera.poses[line].y_m = line;  // 1 m a line, 1 m pixels: the same footprint
  CHECK_FALSE(sensors::pose_moves(camera));
  for (const auto& g : sensors::make_ray_groups(camera, 0, 10)) CHECK(g.ov.y == 0.0f);
  for (int line = 0; line < 10; ++line) camera.poses[line].y_m = 1.5 * line;  // half a pixel more than the slit sees
  CHECK(sensors::pose_moves(camera));
  camera.motion = scene::PoseMotion::held;
  CHECK_FALSE(sensors::pose_moves(camera));
  camera.kind = scene::InstrumentKind::framing;
  camera.motion = scene::PoseMotion::moving;
  CHECK_FALSE(sensors::pose_moves(camera));
}

TEST_CASE("S9 groups do not depend on the split into tiles") {
  for (const auto kind : kKinds)
    for (const auto motion : {scene::PoseMotion::held, scene::PoseMotion::moving}) {
      auto camera = make(kind, 21, 13, true);
      camera.motion = motion;
      const auto whole = sensors::make_ray_groups(camera, 0, 13);
      for (const int tile : {1, 5, 7}) {
        std::vector<shared::RayGroup> joined;
        for (int line = 0; line < 13; line += tile) {
          const auto part = sensors::make_ray_groups(camera, line, std::min(tile, 13 - line));
          joined.insert(joined.end(), part.begin(), part.end());
        }
        REQUIRE(joined.size() == whole.size());
        CHECK(std::memcmp(joined.data(), whole.data(), whole.size() * sizeof(whole[0])) == 0);
      }
    }
}

TEST_CASE("S9 view bounds: closed form of a nadir frame's corners; rays that look up are refused") {
  const auto camera = make(scene::InstrumentKind::framing, 100, 80, false);
  const auto bounds = sensors::view_bounds(camera);
  const double x = 50 * camera.ifov_across_rad, y = 40 * camera.ifov_along_rad;
  CHECK(bounds.sec_max == doctest::Approx(std::sqrt(1 + x * x + y * y)).epsilon(1e-6));
  CHECK(bounds.sec_min == doctest::Approx(1.0).epsilon(1e-6));
  // Towards the sensor: the western edge sees it in the east. The largest x lies where the other axis is 0.
  CHECK(bounds.x_max == doctest::Approx(x / std::sqrt(1 + x * x)).epsilon(1e-5));
  CHECK(bounds.x_min == doctest::Approx(-bounds.x_max).epsilon(1e-5));
  CHECK(bounds.y_max == doctest::Approx(y / std::sqrt(1 + y * y)).epsilon(1e-5));
  CHECK(bounds.sensor_height_m == doctest::Approx(610));

  auto tilted = camera;
  tilted.poses[0].pitch_deg = 86;
  CHECK_THROWS_WITH_AS(sensors::view_bounds(tilted), doctest::Contains("must look down"), base::Error);
}

TEST_CASE("S9 poses that do not match the image and empty images are refused with the counts") {
  auto camera = make(scene::InstrumentKind::pushbroom, 4, 5, false);
  camera.poses.pop_back();
  CHECK_THROWS_WITH_AS(sensors::make_ray_groups(camera, 0, 1), doctest::Contains("found 4 poses, needs 5"),
                       base::Error);
  camera.pixels = 0;
  CHECK_THROWS_WITH_AS(sensors::make_ray_groups(camera, 0, 1), doctest::Contains("0 x 5"), base::Error);
  auto single = make(scene::InstrumentKind::pushbroom, 4, 1, false);
  single.motion = scene::PoseMotion::moving;
  CHECK_THROWS_WITH_AS(sensors::make_ray_groups(single, 0, 1), doctest::Contains("two lines"), base::Error);
  CHECK_THROWS_AS(sensors::make_ray_groups(make(scene::InstrumentKind::framing, 4, 4, false), 3, 2), base::Error);
}
