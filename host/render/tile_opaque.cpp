// What lies behind the leaves of a tile: shares of materials by the first surface on each ray that lets no light
// through.
#include <algorithm>

#include "host/render/tile_worker.h"
#include "host/render/truth.h"
#include "host/sensors/psf.h"
#include "scene_compiler/matter.h"

namespace raycube::render {

bool TileWorker::fills_opaque(const TileOutput& out) const {
  return setup_.instrument.first_opaque &&
         out.layers >= truth::abundance + share_layers(setup_.scene, setup_.instrument);
}

void TileWorker::add_first_opaque(int chunk, std::vector<double>& shares) {
  const StageShape& shape = setup_.shape;
  trace_stages_.run_first_opaque(layout_, chunk, traced_, *opaque_);
  const std::vector<std::uint32_t> primitives = opaque_->read_all();
  const sensors::SampleWeights weights(setup_.instrument);
  const std::size_t first = static_cast<std::size_t>(chunk) * static_cast<std::size_t>(shape.chunk_samples),
                    count = std::min(static_cast<std::size_t>(shape.chunk_samples), weights.count() - first),
                    near = traced_.elements.near, materials = scene::named_count(setup_.scene);
  const std::vector<float> weight = weights.stretch(first, count);
  for (std::size_t p = 0; p < shares.size() / materials; ++p)
    for (std::size_t s = 0; s < count; ++s) {
      const std::uint32_t primitive = primitives[p * near + s];
      if (primitive == RC_NONE) continue;
      const double share = static_cast<double>(weight[s]) / static_cast<double>(weights.count());
      scene::for_each_material(scene::matter_of(setup_.scene, primitive), [&](std::size_t material, float fraction) {
        shares[p * materials + named_[material]] += share * static_cast<double>(fraction);
      });
    }
}

void TileWorker::write_first_opaque(const std::vector<double>& shares, const TileOutput& out) const {
  const std::size_t materials = scene::named_count(setup_.scene);
  for (std::size_t p = 0; p < shares.size() / materials; ++p) {
    float* seen = out.truth + p * out.layers + truth::abundance;
    for (std::size_t m = 0; m < materials; ++m)
      seen[materials + m] = setup_.shape.first_opaque ? static_cast<float>(shares[p * materials + m]) : seen[m];
  }
}

}  // namespace raycube::render
