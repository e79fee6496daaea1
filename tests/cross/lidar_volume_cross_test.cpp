// Two codes for one thing: kernels/lidar/volume.h in float, and the reference's adaptive quadrature in double.
#include <doctest/doctest.h>

#include <glm/geometric.hpp>
#include <random>

#include "host/lidar/volumes.h"
#include "host/reference/lidar_path.h"
#include "kernels/lidar/volume.h"

using namespace raycube;
using scene::Volume;

namespace {

struct Worst {
  double relative = 0, columns = 0;
  int rays = 0;
};

/// Rays from 200 m up and away to points in a box about the volume; both codes get the same floats. Columns below a
/// thousandth of the largest are left out: at a plume's rim single precision counts, not the rule.
Worst compare(const Volume& volume, glm::dvec3 lo, glm::dvec3 hi) {
  const auto flat = lidar::flatten_volumes({volume});
  const reference::VolumePath path(volume);
  std::mt19937 random(21);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<std::pair<double, double>> both;
  for (int i = 0; i < 400; ++i) {
    const auto to_float = [](const glm::dvec3& v) {
      return shared::rc_float4{static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z), 0};
    };
    const auto to_double = [](const shared::rc_float4& v) {
      return glm::dvec3(static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z));
    };
    const glm::dvec3 to = lo + (hi - lo) * glm::dvec3(unit(random), unit(random), unit(random));
    const shared::rc_float4 from =
        to_float(to + glm::dvec3(400 * (unit(random) - 0.5), 400 * (unit(random) - 0.5), 200));
    const shared::rc_float4 way = to_float(glm::normalize(to - to_double(from)));
    const float length = static_cast<float>((0.5 + unit(random)) * glm::distance(to, to_double(from)));
    const double found =
        static_cast<double>(flat.volumes[0].strength.x *
                            shared::rc_volume_path(flat.volumes.data(), flat.values.data(), from, way, 0, length));
    both.emplace_back(found, path.column_cm2({to_double(from), to_double(way), static_cast<double>(length)}) /
                                 lidar::kMoleculesPerPpmM);
  }
  Worst out;
  for (const auto& [found, expected] : both) out.columns = std::max(out.columns, expected);
  for (const auto& [found, expected] : both) {
    if (expected < 1e-3 * out.columns) {
      CHECK(found < 1.1e-3 * out.columns);
      continue;
    }
    ++out.rays;
    out.relative = std::max(out.relative, std::abs(found / expected - 1));
  }
  MESSAGE(volume.name << ": " << out.rays << " rays, largest column " << out.columns
                      << " ppm m, worst relative difference " << out.relative);
  return out;
}

Volume base(const char* name, Volume::Shape shape) {
  Volume v;
  v.name = name, v.shape = shape, v.gas = "ch4", v.concentration_ppm = 3;
  v.position_m = {30, -20, 5}, v.size_m = {60, 40, 25}, v.yaw_deg = 35;
  return v;
}

}  // namespace

TEST_CASE("S61: device's and reference's columns through box, grid and plumes agree, whole and cut off inside") {
  // Single precision places a ray's entry within 2e-5 m: of columns a few metres long, and of plumes a metre wide,
  // 1e-5.
  const Worst box = compare(base("box", Volume::Shape::box), {-20, -60, 0}, {80, 20, 35});
  CHECK(box.rays > 100);
  CHECK(box.relative < 5e-5);

  Volume grid = base("grid", Volume::Shape::grid);
  grid.cells = {7, 5, 4};
  std::mt19937 random(5);
  for (int i = 0; i < 7 * 5 * 4; ++i) grid.values.push_back(static_cast<float>(random() % 100));
  const Worst cells = compare(grid, {-20, -60, 0}, {80, 20, 35});
  CHECK(cells.rays > 100);
  CHECK(cells.relative < 5e-5);

  Volume plume = base("plume", Volume::Shape::plume);
  plume.source_g_s = 2, plume.wind_m_s = 3, plume.release_height_m = 3, plume.length_m = 150;
  const Worst leak = compare(plume, {30, -20, 5}, {110, 90, 20});
  CHECK(leak.rays > 50);
  CHECK(leak.relative < 5e-5);

  plume.name = "plume of constant width", plume.sigma_y_m = 6, plume.sigma_z_m = 4;
  const Worst even = compare(plume, {30, -20, 5}, {110, 90, 20});
  CHECK(even.rays > 50);
  CHECK(even.relative < 5e-5);
}
