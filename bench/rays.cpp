#include "bench/rays.h"

#include <algorithm>
#include <numeric>

#include "bench/candidates.h"
#include "host/base/error.h"
#include "host/sensors/ray_groups.h"
#include "kernels/sampling/sampler.h"

namespace raycube::bench {

PrimaryRays primary_rays(const scene::Instrument& instrument, const std::vector<shared::RayGroup>& groups) {
  if (instrument.sampler != scene::SamplerKind::grid)
    throw base::Error(base::Fault::input, "bench: instrument '" + instrument.name + "' must use the grid sampler: both sides share one sample table");
  PrimaryRays rays;
  rays.groups = groups.data();
  rays.group_count = groups.size();
  rays.width = sensors::pixels_per_group(instrument);
  const int count = instrument.samples_u * instrument.samples_v;
  rays.u.resize(static_cast<std::size_t>(count));
  rays.v.resize(static_cast<std::size_t>(count));
  for (int s = 0; s < count; ++s)
    rc_sample_uv(RC_SAMPLER_GRID, instrument.samples_u, instrument.samples_v, static_cast<float>(instrument.psf_support_px), 0u, 0u, s,
                 &rays.u[static_cast<std::size_t>(s)], &rays.v[static_cast<std::size_t>(s)]);
  return rays;
}

double differing(const std::vector<RayResult>& a, const std::vector<RayResult>& b) {
  std::size_t apart = 0;
  for (std::size_t i = 0; i < a.size(); ++i) apart += a[i].instance != b[i].instance || (a[i].instance != RC_NONE && a[i].primitive != b[i].primitive);
  return static_cast<double>(apart) / static_cast<double>(a.size());
}

double hit_or_miss(const std::vector<RayResult>& a, const std::vector<RayResult>& b) {
  std::size_t apart = 0;
  for (std::size_t i = 0; i < a.size(); ++i) apart += (a[i].instance == RC_NONE) != (b[i].instance == RC_NONE);
  return static_cast<double>(apart) / static_cast<double>(a.size());
}

std::vector<std::uint32_t> candidates(const scene::CompiledScene& scene, const scene::Instrument& instrument,
                                      const std::vector<shared::RayGroup>& groups, int threads) {
  const int cells = std::max(instrument.samples_u, instrument.samples_v);
  const double half_px = 0.5 * instrument.psf_support_px * (1.0 - 1.0 / cells);
  return count_candidates(scene, groups, sensors::pixels_per_group(instrument), half_px, threads);
}

double mean(const std::vector<std::uint32_t>& counts) {
  return std::accumulate(counts.begin(), counts.end(), 0.0) / static_cast<double>(counts.size());
}

}  // namespace raycube::bench
