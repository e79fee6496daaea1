// Closest hits of the tracing kernels against brute force in double over the same fp32 rays (DESIGN section 7).
#include <doctest/doctest.h>

#include <cmath>
#include <string>

#include "tests/support/double_trace.h"
#include "tests/support/test_scenes.h"
#include "tests/support/trace_chain.h"

using namespace raycube;
using test::DoubleTracer;
using test::TraceShape;

namespace {

// A hit may differ from the double oracle only where the ray passes within this many units of 2^-24 (times the size of the
// coordinates that entered) of an edge, or two surfaces lie that close in depth. 16 = the sum of the roundings of the map
// into the mesh frame (4), the vertex difference (1), the direction (3), the shear (3) and the edge product (3), rounded up.
constexpr double kBoundUlp = 16;

const cl::Context& context() {
  static const cl::Context instance{cl::Device(cl::list_devices().front()())};
  return instance;
}

struct Count {
  std::size_t rays = 0, hits = 0, explained = 0, wrong = 0;
};

Count compare(const scene::CompiledScene& scene, const TraceShape& shape, const std::vector<shared::RayGroup>& groups) {
  test::TraceChain chain(context(), scene, shape);
  const auto hits = chain.primary(groups);
  const DoubleTracer oracle(scene);
  Count count;
  for (std::uint32_t line = 0; line < shape.lines; ++line)
    for (std::uint32_t column = 0; column < shape.columns; ++column)
      for (std::uint32_t s = 0; s < shape.samples(); ++s) {
        const std::uint32_t pixel = line * shape.columns + column, p = column % shape.group_pixels;
        const std::uint32_t number = (shape.first_line + line) * shape.pixels_per_line + shape.first_column + column;
        const auto ray = test::host_ray(groups[line * shape.groups_per_line() + column / shape.group_pixels], shape, number, p, s);
        const std::uint32_t instance = hits[pixel * 2 * shape.npad() + s], primitive = hits[(pixel * 2 + 1) * shape.npad() + s];
        const auto truth = oracle.closest(ray.origin, ray.direction);
        ++count.rays;
        count.hits += instance != RC_NONE;
        const auto verdict = oracle.judge(truth, instance, primitive, ray.origin, ray.direction, kBoundUlp);
        count.explained += verdict == DoubleTracer::Verdict::explained;
        if (verdict == DoubleTracer::Verdict::wrong && ++count.wrong <= 3) {
          const auto own = instance == RC_NONE ? test::DoubleTest{} : oracle.test(instance, primitive, ray.origin, ray.direction);
          MESSAGE("pixel " << pixel << " sample " << s << ": kernel " << instance << "/" << primitive << " t " << own.t << " edge "
                           << own.edge_ulp << " ulp; double " << truth.instance << "/" << truth.primitive << " t " << truth.t);
        }
      }
  return count;
}

TraceShape tile(std::uint32_t columns, std::uint32_t lines, int nu, int nv) {
  TraceShape shape;
  shape.nu = nu, shape.nv = nv;
  shape.columns = shape.pixels_per_line = columns, shape.lines = lines;
  return shape;
}

}  // namespace

TEST_CASE("S7: soup of triangles, large and small, seen through instances") {
  scene::CompiledScene scene;
  const auto small = scene::append_mesh(scene, "small", test::triangle_soup(300, 1.5, 0.3, 1));
  const auto large = scene::append_mesh(scene, "large", test::triangle_soup(40, 6, 5, 2));
  for (std::uint32_t i = 0; i < 12; ++i)
    scene::append_instance(scene, small, test::placement(0.7 * i, 0.3 * i, 0.5 + 0.2 * i, 10 * test::unit_random(5, i, 0) - 5,
                                                         10 * test::unit_random(5, i, 1) - 5, 4 * test::unit_random(5, i, 2)), i);
  scene::append_instance(scene, large, test::kIdentity, 100);
  scene::append_instance(scene, large, test::placement(0.3, -0.2, 1.1, 1, 2, -4), 101);
  scene::finish_top_tree(scene);
  TraceShape shape = tile(29, 12, 8, 8);
  const auto groups = test::nadir_groups(shape, 0.3, -0.2, 60, 0.4, 60, 0.01);
  const Count count = compare(scene, shape, groups);
  MESSAGE("rays " << count.rays << ", hits " << count.hits << ", explained " << count.explained);
  CHECK(count.hits > count.rays / 10);
  CHECK(count.wrong == 0);
}
