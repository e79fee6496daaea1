// What shapes send of an even light towards one direction (scene_compiler/lobe_albedo.h), generated over materials.def.
// Oracles: the sum over a fine grid of directions, Lambert's law, and that a gloss that mirrors half loses no more.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "kernels/shared/tile_layout.h"
#include "scene_compiler/lobe_albedo.h"
#include "scene_compiler/shape_list.h"
#include "tests/support/full.h"
#include "tests/support/shape_cases.h"

namespace {

using namespace raycube;
constexpr double kPi = std::numbers::pi;

RcLocal towards(double cosine, double azimuth_rad) {
  const double sine = std::sqrt(1 - cosine * cosine);
  return {sine * std::sin(azimuth_rad), sine * std::cos(azimuth_rad), cosine};
}

/// Integral of f cos over the hemisphere that light comes from: midpoints in cosine and azimuth.
double summed(const scene::Shape& shape, const RcLocal& out) {
  constexpr int n = 500;
  static const std::vector<RcLocal> level = [] {
    std::vector<RcLocal> all;
    for (int j = 0; j < n; ++j) all.push_back(towards(0, 2 * kPi * (j + 0.5) / n));
    return all;
  }();
  double sum = 0;
  for (int i = 0; i < n; ++i) {
    const double cosine = (i + 0.5) / n, sine = std::sqrt(1 - cosine * cosine);
    for (const RcLocal& turned : level) {
      const RcAngles angles = rc_angles({0, 0, 1}, {sine * turned.x, sine * turned.y, cosine}, out);
      sum += cosine * rc_shape_eval(shape.number, 1, shape.parameters(), angles);
    }
  }
  return 2 * kPi * sum / n / n;
}

/// Every shape that reflects, near the lower end, of all cases in the middle, and at the upper end of its parameters'
/// ranges; facets no narrower than cameras take them.
std::vector<scene::Shape> reflecting_shapes() {
  std::vector<scene::Shape> out;
  for (const auto& entry : scene::shape_entries()) {
    if (entry.role == scene::ShapeRole::behind) continue;
    for (const double part : {0.1, 0.4, 1.0}) {
      if (part == 0.4 && !testing::full()) continue;
      scene::Shape shape = test::shape_at(entry, part);
      if (entry.number == RC_SHAPE_ward) shape.parameter[2] = std::min(1.0, 2 * shape.parameter[0]);
      out.push_back(shape);
    }
  }
  return out;
}

}  // namespace

TEST_CASE("S21 S4.8 what a shape sends of an even light is the sum over directions; its table lies between") {
  CHECK(scene::lobe_albedo({RC_SHAPE_lambert}, towards(0.3, 1)) == 1);
  for (const scene::Shape& shape : reflecting_shapes()) {
    CAPTURE(scene::shape_entry(shape.number).name);
    const scene::LobeAlbedo table(shape, RC_ALBEDO_ZENITHS, RC_ALBEDO_AZIMUTHS);
    double worst = 0, worst_table = 0;
    for (const double cosine : {0.995, 0.71, 0.318, 0.153})
      for (const double azimuth : {0.3, 2.1}) {
        if (azimuth > 1 && shape.number != RC_SHAPE_ward && !testing::full()) continue;  // the others have no grain
        const RcLocal out = towards(cosine, azimuth);
        const double want = summed(shape, out), found = scene::lobe_albedo(shape, out);
        CAPTURE(cosine);
        CAPTURE(want);
        CAPTURE(found);
        worst = std::max(worst, std::abs(found - want) / std::max(1.0, want));
        worst_table = std::max(worst_table, std::abs(table.at(out) - want) / std::max(1.0, want));
        const RcLocal turned{-out.x, -out.y, out.z};  // half round is the same
        CHECK(table.at(turned) == doctest::Approx(table.at(out)).epsilon(1e-6));
      }
    MESSAGE(std::string(scene::shape_entry(shape.number).name)
            << " " << shape.parameter[0] << ": by draws " << worst << ", by the table " << worst_table);
    CHECK(worst < 1.5e-3);        // 1597 draws of each law
    CHECK(worst_table < 2.5e-3);  // and lines between nodes
  }
}

TEST_CASE("S21 a gloss that mirrors a share r of all that comes sends at most r of an even light") {
  for (const double roughness : {0.1, 0.3, 1.0})
    for (int i = 1; i <= 20; ++i) {
      const scene::Shape half{RC_SHAPE_ward, {roughness, 0.5, roughness, 0}};
      CHECK(scene::lobe_albedo(half, towards(i / 20.0 * 0.999, 0.5)) < 0.5 + 1e-3);
    }
}
