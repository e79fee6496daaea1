// The ground around each pixel of a tile: nodes of the plan's map, their rows of the band table, their weights.
#include <algorithm>
#include <cmath>

#include "host/render/tile_worker.h"
#include "kernels/atmosphere/nodes.h"
#include "kernels/shared/tile_layout.h"

namespace raycube::render {

std::array<plan::EnvironmentWeight, 4> TileWorker::environment_of(std::uint32_t pixel, const float* truth_sums) const {
  const plan::Plan& plan = setup_.plan;
  if (const double hit = truth_sums[RC_TRUTH_HIT]; hit > 0)
    return plan::environment_at(plan.environment, truth_sums[RC_TRUTH_X] / hit, truth_sums[RC_TRUTH_Y] / hit);
  const auto d = centre_direction(pixel);
  const auto& group = groups_[layout_.group_of(pixel)];
  // d - d0 is the pixel's place in its group: its ray starts that much beside the group's, times the way ahead.
  const double ahead = group.d0.w,
               t = (double{plan.height.first} - (group.origin.z + ahead * (d[2] - group.d0.z))) / d[2];
  return plan::environment_at(plan.environment, group.origin.x + ahead * (d[0] - group.d0.x) + t * d[0],
                              group.origin.y + ahead * (d[1] - group.d0.y) + t * d[1]);
}

void TileWorker::write_environment(std::span<const std::array<plan::EnvironmentWeight, 4>> around,
                                   std::size_t first_item, RowBuffers& rows) {
  std::vector<std::uint32_t> row;
  std::vector<float> weight;
  for (const auto& pixel : around)
    for (const auto& node : pixel) {
      row.push_back(node.weight > 0 ? table_.row_of(plan::kEnvironmentKey | node.node) : 0);
      weight.push_back(static_cast<float>(node.weight));
    }
  rows.environment_row.write(row, RC_ENVIRONMENT_NODES * first_item);
  rows.environment_weight.write(weight, RC_ENVIRONMENT_NODES * first_item);
}

void TileWorker::add_environment(std::uint32_t pixel, const float* truth_sums, const std::vector<double>& path,
                                 std::vector<double>& radiance, PixelTerms* terms) const {
  const StageShape& shape = setup_.shape;
  const plan::Plan& plan = setup_.plan;
  const auto [view, fraction] = view_nodes(pixel);
  for (const auto& node : environment_of(pixel, truth_sums)) {
    if (node.weight == 0) continue;
    const auto baked = plan::bake_row(plan, setup_.scene, plan::kEnvironmentKey | node.node);
    for (int h = 0; h < shape.heights; ++h)
      for (int v = view; v < std::min(view + 2, shape.views); ++v) {
        const double weight =
            path[static_cast<std::size_t>(h)] * node.weight * (v == view ? 1.0 - double{fraction} : double{fraction});
        if (terms)
          terms->push_back(
              {plan::kEnvironmentKey | node.node, static_cast<std::uint32_t>(h * shape.views + v), weight});
        const float* e = baked.data() + static_cast<std::size_t>(h * shape.views + v) * shape.bands_padded;
        for (std::size_t b = 0; b < radiance.size(); ++b) radiance[b] += weight * e[b];
      }
  }
}

}  // namespace raycube::render
