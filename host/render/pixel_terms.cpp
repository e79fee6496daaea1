#include "host/render/pixel_terms.h"

#include <map>

#include "host/render/tile_worker.h"
#include "kernels/shared/tile_layout.h"

namespace raycube::render {

std::vector<double> sum_of_terms(const plan::Plan& plan, const scene::CompiledScene& scene, const PixelTerms& terms) {
  std::vector<double> radiance(plan.bands.size(), 0.0);
  std::map<std::uint64_t, std::vector<float>> rows;
  for (const Term& term : terms) {
    std::vector<float>& row = rows[term.key];
    if (row.empty()) row = plan::bake_row(plan, scene, term.key);
    const float* e = row.data() + term.channel * static_cast<std::size_t>(RC_PADDED(plan.columns()));
    for (std::size_t b = 0; b < radiance.size(); ++b) radiance[b] += term.weight * double{e[b]};
  }
  return radiance;
}

void TileWorker::file_terms(std::size_t first, std::size_t count, const std::vector<std::uint32_t>& pixels,
                            RowBuffers& rows, PixelTerms* terms) const {
  const std::vector<std::uint64_t> key = table_.keys_by_row();
  const auto channels = static_cast<std::uint32_t>(setup_.shape.channels);
  const std::vector<std::uint32_t> used = rows.term_count.read_all();
  for (std::size_t i = first; i < first + count; ++i) {
    std::vector<std::uint32_t> row(used[i]);
    std::vector<float> weight(used[i]);
    rows.term_row.read(row, i * rows.term_capacity);
    rows.term_weight.read(weight, i * rows.term_capacity);
    PixelTerms& to = terms[pixels[i]];
    to.clear();
    for (std::size_t t = 0; t < row.size(); ++t)
      to.push_back({key[row[t] / channels], row[t] % channels, double{weight[t]}});
  }
}

}  // namespace raycube::render
