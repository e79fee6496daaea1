// First hits on the terrain of the benchmarks (1 048 600 triangles, closed under every ray of its camera) against
// Embree and double: what `ci/bench check` does with 1.6e7 rays, here with a million. 5e-5 is the limit of differences
// within rounding.
#include <doctest/doctest.h>

#include "bench/scenes/scenes.h"
#include "host/run/check_instrument.h"

using namespace raycube;

TEST_CASE("S7 S8 S61: on closed terrain no hit is unexplained, none is lost, and rounding decides at most 5e-5") {
  const auto scene = bench::compile({bench::terrain_mesh()}, {{bench::kIdentity}});
  render::Renderer renderer(scene, {});
  const reference::HitReport report = run::check_hits(renderer, scene, bench::terrain_camera(), 1, 1000000, 0);
  CHECK(report.rays >= 1000000);
  CHECK(report.of(reference::Cause::unexplained) == 0);
  CHECK(report.hit_miss == 0);
  CHECK(report.hit_miss_double == 0);
  CHECK(report.explained_share() <= 5e-5);
}
