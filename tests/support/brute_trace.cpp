#include "tests/support/brute_trace.h"

#include "tests/support/probes.h"

namespace raycube::test {
std::vector<std::uint32_t> block_ranges(const scene::CompiledScene& scene) {
  std::vector<std::uint32_t> ranges;
  for (const auto& placed : scene.instances) {
    const auto& tree = scene.trees[placed.tree];
    ranges.insert(ranges.end(), {tree.first_block, tree.first_block + tree.block_count});
  }
  return ranges;
}

BruteTrace::BruteTrace(const cl::Context& context, const scene::CompiledScene& scene, const TraceShape& shape)
    : context_(context),
      shape_(shape),
      count_(static_cast<std::uint32_t>(scene.instances.size())),
      program_(probes(context)),
      primary_(*program_, "brute_primary"),
      sun_(*program_, "sun_alone"),
      nodes_(context, scene.nodes, cl::Access::read_only, "nodes"),
      blocks_(context, scene.blocks, cl::Access::read_only, "triangle blocks"),
      instances_(context, scene.instances, cl::Access::read_only, "instances"),
      ranges_(context, block_ranges(scene), cl::Access::read_only, "blocks of instances"),
      groups_(context, shape.groups(), cl::Access::read_only, "ray groups"),
      hits_(context, shape.pixels() * shape.elements().hits, cl::Access::read_write, "hits"),
      points_(context, shape.pixels() * shape.elements().surface, cl::Access::read_only, "surface points"),
      sun_mask_(context, shape.pixels() * shape.elements().sun, cl::Access::read_write, "sun masks") {}

std::vector<std::uint32_t> BruteTrace::primary(std::span<const shared::RayGroup> groups) {
  groups_.write(numbered(groups, shape_));
  primary_.arguments(blocks_, instances_, ranges_, count_, groups_, hits_, shape_.arguments(),
                     static_cast<std::uint32_t>(shape_.sampler), static_cast<std::uint32_t>(shape_.nu),
                     static_cast<std::uint32_t>(shape_.nv), shape_.support, shape_.seed, shape_.columns);
  context_.launch(primary_, shape_.groups());
  context_.finish();
  return hits_.read_all();
}

std::vector<std::uint16_t> BruteTrace::sun(std::span<const float> points, const shared::rc_float4& direction) {
  points_.write(points);
  sun_.arguments(nodes_, blocks_, instances_, ranges_, count_, cl_uint{1}, points_, sun_mask_, shape_.arguments(),
                 direction);
  context_.launch(sun_, shape_.pixels());
  context_.finish();
  return sun_mask_.read_all();
}

}  // namespace raycube::test
