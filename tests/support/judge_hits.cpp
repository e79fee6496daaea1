#include "tests/support/judge_hits.h"

#include <doctest/doctest.h>

#include "tests/support/double_trace.h"

namespace raycube::test {

HitCount judge_hits(const cl::Context& context, const scene::CompiledScene& scene, const TraceShape& shape,
                    const std::vector<shared::RayGroup>& groups) {
  TraceChain chain(context, scene, shape);
  const auto hits = chain.primary(groups);
  const DoubleTracer oracle(scene);
  HitCount count;
  for (std::uint32_t line = 0; line < shape.lines; ++line)
    for (std::uint32_t column = 0; column < shape.columns; ++column)
      for (std::uint32_t s = 0; s < shape.samples(); ++s) {
        const std::uint32_t pixel = line * shape.columns + column, p = column % shape.pixels_per_group;
        const std::uint32_t number = (shape.first_line + line) * shape.pixels_per_line + shape.first_column + column;
        const auto ray =
            host_ray(groups[line * shape.groups_per_line() + column / shape.pixels_per_group], shape, number, p, s);
        const std::uint32_t instance = hits[shape.hits_at(pixel, RC_HIT_INSTANCE, s)],
                            primitive = hits[shape.hits_at(pixel, RC_HIT_PRIMITIVE, s)];
        const auto truth = oracle.closest(ray.origin, ray.direction);
        ++count.rays;
        count.hits += instance != RC_NONE;
        const auto verdict = oracle.judge(truth, instance, primitive, ray.origin, ray.direction, kBoundUlp);
        count.explained += verdict == DoubleTracer::Verdict::explained;
        if (verdict == DoubleTracer::Verdict::wrong && ++count.wrong <= 3) {
          const auto own =
              instance == RC_NONE ? DoubleTest{} : oracle.test(instance, primitive, ray.origin, ray.direction);
          MESSAGE("pixel " << pixel << " sample " << s << ": kernel " << instance << "/" << primitive << " t " << own.t
                           << " edge " << own.edge_ulp << " ulp; double " << truth.instance << "/" << truth.primitive
                           << " t " << truth.t);
        }
      }
  return count;
}

}  // namespace raycube::test
