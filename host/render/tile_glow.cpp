// Light between surfaces of a pixel that is summed on the host.
#include <algorithm>
#include <span>

#include "host/render/tile_worker.h"
#include "kernels/shared/tile_layout.h"

namespace raycube::render {

void TileWorker::add_glow(std::uint32_t pixel, const std::vector<double>& path, std::vector<double>& radiance,
                          PixelTerms* terms) const {
  const StageShape& shape = setup_.shape;
  const plan::Plan& plan = setup_.plan;
  const auto [view, fraction] = view_nodes(pixel);
  const std::size_t padded = static_cast<std::size_t>(shape.skeleton_padded()), lines = plan.bounces.skeleton.size();
  std::vector<double> sum(static_cast<std::size_t>(1 + shape.lamps) * padded, 0.0);
  std::vector<float> glow(traced_.elements.glow);
  traced_.glow.read(std::span(glow), pixel * glow.size());
  for (std::size_t i = 0; i < glow.size(); ++i) sum[i % sum.size()] += static_cast<double>(glow[i]);
  for (std::size_t row = 0; row < plan.skeleton_rows(); ++row) {
    const double scattered = sum[row / lines * padded + row % lines];
    const auto baked = plan::bake_row(plan, setup_.scene, plan::kSkeletonKey | row);
    for (int h = 0; h < shape.heights; ++h)
      for (int v = view; v < std::min(view + 2, shape.views); ++v) {
        const double weight =
            scattered * path[static_cast<std::size_t>(h)] * (v == view ? 1.0 - double{fraction} : double{fraction});
        const auto channel = static_cast<std::size_t>(h * shape.views + v);
        if (terms) terms->push_back({plan::kSkeletonKey | row, static_cast<std::uint32_t>(channel), weight});
        const float* e = baked.data() + channel * static_cast<std::size_t>(shape.bands_padded);
        for (std::size_t b = 0; b < radiance.size(); ++b) radiance[b] += weight * double{e[b]};
      }
  }
}

}  // namespace raycube::render
