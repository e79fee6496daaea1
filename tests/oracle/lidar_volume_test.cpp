// kernels/lidar/volume.h on the host, against closed forms and quadrature in double; and on every device against the
// host.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "host/cl/kernel.h"
#include "host/lidar/volumes.h"
#include "kernels/lidar/volume.h"
#include "tests/support/probes.h"

using namespace raycube;
using scene::Volume;

namespace {

struct Line {
  double from[3], direction[3], length;
};

Line line(std::array<double, 3> from, std::array<double, 3> to) {
  Line out{{from[0], from[1], from[2]}, {to[0] - from[0], to[1] - from[1], to[2] - from[2]}, 0};
  out.length = std::hypot(out.direction[0], out.direction[1], out.direction[2]);
  // The device sees floats: what they round away is no error of the integration.
  for (double& d : out.direction) d = static_cast<double>(static_cast<float>(d / out.length));
  for (double& v : out.from) v = static_cast<double>(static_cast<float>(v));
  return out;
}

shared::rc_float4 four(const double (&v)[3]) {
  return {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2]), 0};
}

/// Gas along a line, ppm m.
double column(const Volume& volume, const Line& l) {
  const auto flat = lidar::flatten_volumes({volume});
  const shared::LidarVolume& v = flat.volumes.at(0);
  return v.gas ? static_cast<double>(v.strength.x * shared::rc_volume_path(&v, flat.values.data(), four(l.from),
                                                                           four(l.direction), 0,
                                                                           static_cast<float>(l.length)))
               : 0;
}

Volume methane_plume() {
  Volume v;
  v.shape = Volume::Shape::plume;
  v.gas = "ch4";
  v.source_g_s = 1, v.wind_m_s = 3, v.sigma_y_m = 10, v.sigma_z_m = 5;
  return v;
}

Volume box(double ppm) {
  Volume v;
  v.gas = "ch4", v.concentration_ppm = ppm;
  v.position_m = {100, 50, 2}, v.size_m = {30, 20, 10};
  return v;
}

double sigma(double x, double a, double b, double constant) {
  return constant > 0 ? constant : a * x / std::sqrt(1 + b * x);
}

/// The plume's ppm at a point: the formula, written a second time, in double.
double plume_ppm(const Volume& v, double east, double north, double up) {
  const double yaw = v.yaw_deg * M_PI / 180, px = east - v.position_m[0], py = north - v.position_m[1],
               z = up - v.position_m[2], h = v.release_height_m;
  const double x = px * std::sin(yaw) + py * std::cos(yaw), y = px * std::cos(yaw) - py * std::sin(yaw);
  if (x <= 0 || x > v.length_m || z < 0) return 0;
  const double sy = sigma(x, v.sigma_y_a, v.sigma_y_b, v.sigma_y_m),
               sz = sigma(x, v.sigma_z_a, v.sigma_z_b, v.sigma_z_m);
  const double g_m3 = v.source_g_s / (2 * M_PI * v.wind_m_s * sy * sz) * std::exp(-y * y / (2 * sy * sy)) *
                      (std::exp(-(z - h) * (z - h) / (2 * sz * sz)) + std::exp(-(z + h) * (z + h) / (2 * sz * sz)));
  return g_m3 / v.molar_mass_g * 6.02214076e23 / 2.479371580e19;  // per m3 over 1e-6 of 2.479e25 per m3
}

/// The grid's value at a point: trilinear between the centres of cells, written a second time, in double.
double grid_value(const Volume& v, double east, double north, double up) {
  const double yaw = v.yaw_deg * M_PI / 180, px = east - v.position_m[0], py = north - v.position_m[1];
  const double at[3] = {px * std::cos(yaw) - py * std::sin(yaw) + v.size_m[0] / 2,
                        px * std::sin(yaw) + py * std::cos(yaw) + v.size_m[1] / 2, up - v.position_m[2]};
  double sum = 0, low[3], share[3];
  for (int axis = 0; axis < 3; ++axis) {
    if (at[axis] < 0 || at[axis] > v.size_m[axis]) return 0;
    const double centre = std::clamp(at[axis] / v.size_m[axis] * v.cells[axis] - 0.5, 0.0, v.cells[axis] - 1.0);
    low[axis] = std::floor(centre), share[axis] = centre - low[axis];
  }
  for (int corner = 0; corner < 8; ++corner) {
    double weight = 1;
    std::size_t cell[3];
    for (int axis = 0; axis < 3; ++axis) {
      const bool upper = corner >> axis & 1;
      weight *= upper ? share[axis] : 1 - share[axis];
      cell[axis] = std::min(static_cast<std::size_t>(low[axis]) + upper, static_cast<std::size_t>(v.cells[axis]) - 1);
    }
    sum +=
        weight *
        static_cast<double>(
            v.values[(cell[2] * static_cast<std::size_t>(v.cells[1]) + cell[1]) * static_cast<std::size_t>(v.cells[0]) +
                     cell[0]]);
  }
  return sum;
}

/// Midpoint rule with so many points that its error is below 1e-6 for bells wider than the line / 20000.
/// The line must end below the plume's foot, where the sum ends: a step inside it would cost half a point.
double summed(const Volume& v, Line l, int points = 400000) {
  double sum = 0;
  l.length = (v.position_m[2] - l.from[2]) / l.direction[2];
  for (int i = 0; i < points; ++i) {
    const double t = (i + 0.5) / points * l.length;
    sum += plume_ppm(v, l.from[0] + t * l.direction[0], l.from[1] + t * l.direction[1], l.from[2] + t * l.direction[2]);
  }
  return sum * l.length / points;
}

}  // namespace

TEST_CASE(
    "L-11: a vertical beam through a Gaussian plume that the ground reflects finds Q / (sqrt(2 pi) u sigma_y), 20.1338 "
    "ppm m, whatever sigma_z and height") {
  for (const double sigma_z_m : {0.5, 5.0, 40.0, 150.0})
    for (const double height_m : {0.0, 3.0, 60.0}) {
      Volume v = methane_plume();
      v.sigma_z_m = sigma_z_m, v.release_height_m = height_m;
      const double found = column(v, line({0, 200, 1500}, {0, 200, -10}));
      // Float arithmetic in about 60 terms; the specification's figure has six digits.
      CHECK(found == doctest::Approx(20.1338).epsilon(5e-6));
      // Two-way transmission at 1.061033e-18 cm2.
      CHECK(std::exp(-2 * found * lidar::kMoleculesPerPpmM * 1.061032954e-18) ==
            doctest::Approx(0.8994859510).epsilon(2e-6));
    }
  // Off the axis by two sigma_y: times exp(-2).
  CHECK(column(methane_plume(), line({20, 200, 1500}, {20, 200, -10})) ==
        doctest::Approx(20.13380 * std::exp(-2.0)).epsilon(1e-5));
}

TEST_CASE(
    "L-11: a horizontal beam across the plume, and oblique ones through widths that grow, against sums in double") {
  Volume v = methane_plume();
  v.position_m = {300, -200, 40}, v.yaw_deg = 30, v.release_height_m = 4, v.sigma_y_m = 0, v.sigma_z_m = 0;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(0, 1);
  double near = 0, far = 0, largest = 0;
  for (int i = 0; i < 80; ++i) {
    // Through a random point near the axis, 5 to 900 m downwind.
    const double x = 5 * std::pow(180.0, unit(random)), y = (unit(random) - 0.5) * 0.3 * x,
                 z = 4 + 0.1 * x * unit(random);
    const double yaw = M_PI / 6;
    const std::array<double, 3> at{300 + x * std::sin(yaw) + y * std::cos(yaw),
                                   -200 + x * std::cos(yaw) - y * std::sin(yaw), 40 + z};
    const double azimuth = 2 * M_PI * unit(random), slope = 0.3 + unit(random);
    const Line l = line({at[0] + 600 * std::sin(azimuth), at[1] + 600 * std::cos(azimuth), at[2] + 600 * slope},
                        {at[0] - 100 * std::sin(azimuth), at[1] - 100 * std::cos(azimuth), at[2] - 100 * slope});
    const double expected = summed(v, l), found = column(v, l);
    if (expected < 1e-3) continue;
    largest = std::max(largest, expected);
    double& worst = x < 60 ? near : far;
    worst = std::max(worst, std::abs(found / expected - 1));
  }
  MESSAGE("largest column " << largest << " ppm m, worst relative error " << near << " nearer than 60 m, " << far
                            << " beyond");
  CHECK(largest > 10);
  // Single precision places a ray that starts 700 m away within half an ulp, 0.03 mm, and a few of them add up; the
  // plume is 0.3 m wide at 5 m and 3.6 m at 60 m, and a column changes by up to two of its parts per width.
  CHECK(near < 1e-4);
  CHECK(far < 2e-5);
}

TEST_CASE("box: the chord times the concentration, from any side, from 20 km away, and cut where the piece ends") {
  Volume v = box(40);
  CHECK(column(v, line({100, 50, 500}, {100, 50, 0})) == doctest::Approx(400).epsilon(1e-6));
  CHECK(column(v, line({100, 50, 500}, {100, 50, 7})) == doctest::Approx(200).epsilon(1e-5));
  CHECK(column(v, line({0, 50, 5}, {500, 50, 5})) == doctest::Approx(1200).epsilon(1e-6));
  CHECK(column(v, line({100, 50, 5}, {500, 50, 5})) == doctest::Approx(600).epsilon(1e-6));
  CHECK(column(v, line({0, 80, 5}, {500, 80, 5})) == 0);
  CHECK(column(v, line({0, 50, 5}, {50, 50, 5})) == 0);
  // A diagonal of the base.
  CHECK(column(v, line({100 - 30, 50 - 20, 5}, {100 + 30, 50 + 20, 5})) ==
        doctest::Approx(40 * std::hypot(30, 20)).epsilon(1e-6));
  const double tilt = std::sqrt(1 + 0.01);
  CHECK(column(v, line({100 - 2000, 50, 7 + 20000}, {100 + 2000, 50, 7 - 20000})) ==
        doctest::Approx(40 * 10 * tilt).epsilon(1e-5));
  v.yaw_deg = 90;  // its y axis points east
  CHECK(column(v, line({0, 50, 5}, {500, 50, 5})) == doctest::Approx(800).epsilon(1e-6));
  v.gas.clear();
  CHECK(column(v, line({0, 50, 5}, {500, 50, 5})) == 0);
  const auto flat = lidar::flatten_volumes({v});
  CHECK(shared::rc_volume_path(flat.volumes.data(), flat.values.data(), {0, 50, 5, 0}, {1, 0, 0, 0}, 0, 500) ==
        doctest::Approx(20).epsilon(1e-6));
}

TEST_CASE("grid: a trilinear field is integrated exactly, cell by cell; the outer half cells keep the border's value") {
  Volume v;
  v.shape = Volume::Shape::grid;
  v.gas = "ch4", v.concentration_ppm = 2;
  v.size_m = {40, 30, 20}, v.cells = {8, 6, 4}, v.position_m = {-5, 10, 100};
  const auto at = [&](const std::function<double(double, double, double)>& field) {
    v.values.clear();
    for (int k = 0; k < 4; ++k)
      for (int j = 0; j < 6; ++j)
        for (int i = 0; i < 8; ++i)
          v.values.push_back(static_cast<float>(field(-17.5 + 5 * i, -12.5 + 5 * j, 2.5 + 5 * k)));
  };
  // Linear: along a line between cell centres, the mean of its ends times its length.
  at([](double x, double y, double z) { return 50 + x + 0.5 * y - 2 * z; });
  const auto inside = [](double x, double y, double z) { return std::array<double, 3>{x - 5, y + 10, z + 100}; };
  const Line l = line(inside(-15, -10, 4), inside(13, 11, 15));
  CHECK(column(v, l) == doctest::Approx(2 * l.length * (50 - 1 + 0.25 - 19)).epsilon(1e-6));
  // x y z: a cubic along the ray. Integral over s of (a + s u)(b + s v)(c + s w).
  at([](double x, double y, double z) { return x * y * z + 5000; });
  const double p[3] = {-15, -10, 4}, d[3] = {l.direction[0], l.direction[1], l.direction[2]}, s = l.length;
  const double cubic = p[0] * p[1] * p[2] * s +
                       (d[0] * p[1] * p[2] + p[0] * d[1] * p[2] + p[0] * p[1] * d[2]) * s * s / 2 +
                       (d[0] * d[1] * p[2] + d[0] * p[1] * d[2] + p[0] * d[1] * d[2]) * s * s * s / 3 +
                       d[0] * d[1] * d[2] * s * s * s * s / 4;
  CHECK(column(v, l) == doctest::Approx(2 * (cubic + 5000 * s)).epsilon(1e-6));
  // Along an axis through centres: the sum of the values times the cell, border halves included.
  std::mt19937 random(3);
  v.values.assign(8 * 6 * 4, 0);
  for (float& value : v.values) value = static_cast<float>(random() % 1000);
  double sum = 0;
  for (std::size_t i = 0; i < 8; ++i) sum += 5.0 * static_cast<double>(v.values[(2 * 6 + 3) * 8 + i]);
  CHECK(column(v, line(inside(-100, 2.5, 12.5), inside(100, 2.5, 12.5))) == doctest::Approx(2 * sum).epsilon(1e-6));
  CHECK(column(v, line(inside(100, 2.5, 12.5), inside(-100, 2.5, 12.5))) == doctest::Approx(2 * sum).epsilon(1e-6));
  // Any line, through the grid as it lies and turned: a midpoint sum over the field.
  for (int i = 0; i < 40; ++i) {
    v.yaw_deg = i < 20 ? 0 : 35;
    const auto coordinate = [&](double half) { return half * (static_cast<double>(random() % 2001) / 1000 - 1); };
    const Line any = line(inside(coordinate(30), coordinate(25), 10 + coordinate(20)),
                          inside(coordinate(30), coordinate(25), 10 + coordinate(20)));
    double expected = 0;
    for (int n = 0; n < 20000; ++n) {
      const double t = (n + 0.5) / 20000 * any.length;
      expected += grid_value(v, any.from[0] + t * any.direction[0], any.from[1] + t * any.direction[1],
                             any.from[2] + t * any.direction[2]);
    }
    expected *= 2 * any.length / 20000;
    // The field's step at the box's sides, up to 1000 at each of two, falls between two points of the sum.
    CHECK(std::abs(column(v, any) - expected) < 2 * 1000 * any.length / 20000 + 1e-5 * expected);
  }
  // One cell is a box.
  v.yaw_deg = 0, v.cells = {1, 1, 1}, v.values = {3};
  CHECK(column(v, line(inside(-100, 2.5, 12.5), inside(100, 2.5, 12.5))) == doctest::Approx(2 * 3 * 40).epsilon(1e-6));
}

TEST_CASE("mass: a plane across the wind catches the source, column by column") {
  // Integral of vertical columns over the crosswind coordinate times wind = source (g/s), 5 to 950 m downwind.
  Volume v = methane_plume();
  v.sigma_y_m = v.sigma_z_m = 0, v.release_height_m = 20, v.source_g_s = 7;
  const auto flat = lidar::flatten_volumes({v});
  for (const double x : {5.0, 50.0, 300.0, 950.0}) {
    const double sy = sigma(x, v.sigma_y_a, v.sigma_y_b, 0), step = 0.25 * sy;
    double sum = 0;
    for (int i = -30; i <= 30; ++i)
      sum += step * static_cast<double>(shared::rc_volume_path(
                        flat.volumes.data(), flat.values.data(),
                        {static_cast<float>(i * step), static_cast<float>(x), 2000, 0}, {0, 0, -1, 0}, 0, 2000));
    CHECK(sum * v.wind_m_s == doctest::Approx(7).epsilon(1e-5));
  }
}

TEST_CASE("every device integrates volumes as the host does") {
  std::vector<Volume> volumes = {methane_plume(), box(12), box(3)};
  volumes[0].sigma_y_m = volumes[0].sigma_z_m = 0, volumes[0].yaw_deg = 40;
  volumes[2].shape = Volume::Shape::grid, volumes[2].cells = {3, 4, 2}, volumes[2].yaw_deg = 15;
  for (int i = 0; i < 24; ++i) volumes[2].values.push_back(static_cast<float>(i * 7 % 11));
  const auto flat = lidar::flatten_volumes(volumes);
  std::mt19937 random(11);
  std::uniform_real_distribution<float> unit(-1, 1);
  constexpr std::size_t kRays = 300;
  std::vector<shared::rc_float4> rays;
  for (std::size_t i = 0; i < kRays; ++i) {
    const double from[3] = {static_cast<double>(100 + 200 * unit(random)), static_cast<double>(50 + 200 * unit(random)),
                            300};
    const double to[3] = {static_cast<double>(100 + 30 * unit(random)), static_cast<double>(50 + 20 * unit(random)), 0};
    const Line l = line({from[0], from[1], from[2]}, {to[0], to[1], to[2]});
    rays.push_back(four(l.from)), rays.push_back(four(l.direction));
    rays.back().w = static_cast<float>(l.length);
  }
  for (cl::Device& device : cl::list_devices()) {
    CAPTURE(device.name());
    const cl::Context context(std::move(device));
    const auto program = test::probes(context);
    cl::Kernel kernel(*program, "columns");
    const cl::Buffer<shared::LidarVolume> volume_buffer(context, flat.volumes, cl::Access::read_only, "volumes");
    const cl::Buffer<float> values(context, flat.values, cl::Access::read_only, "values");
    const cl::Buffer<shared::rc_float4> ray_buffer(context, rays, cl::Access::read_only, "rays");
    cl::Buffer<float> out(context, kRays * volumes.size(), cl::Access::read_write, "columns");
    kernel.arguments(volume_buffer, values, ray_buffer, static_cast<std::uint32_t>(volumes.size()), out);
    context.launch(kernel, kRays * volumes.size());
    const auto found = out.read_all();
    double total = 0;
    for (std::size_t i = 0; i < found.size(); ++i) {
      const std::size_t ray = i / volumes.size();
      const shared::LidarVolume& v = flat.volumes[i % volumes.size()];
      const float expected = v.strength.x * shared::rc_volume_path(&v, flat.values.data(), rays[2 * ray],
                                                                   rays[2 * ray + 1], 0, rays[2 * ray + 1].w);
      // exp and sqrt may differ by 3 ulp, in exponents of up to 21.
      CHECK(static_cast<double>(found[i]) == doctest::Approx(static_cast<double>(expected)).epsilon(2e-5).scale(0.01));
      total += static_cast<double>(expected);
    }
    CHECK(total > 0);
  }
}
