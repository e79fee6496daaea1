#include "bench/rays.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "bench/candidates.h"
#include "host/base/error.h"
#include "host/reference/double_trace.h"
#include "host/sensors/ray_groups.h"
#include "kernels/sampling/sampler.h"

namespace raycube::bench {

PrimaryRays primary_rays(const scene::Instrument& instrument, const std::vector<shared::RayGroup>& groups) {
  if (instrument.sampler != scene::SamplerKind::grid)
    throw base::Error(base::Fault::input, "bench: instrument '" + instrument.name +
                                              "' must use the grid sampler: both sides share one sample table");
  PrimaryRays rays;
  rays.groups = groups.data();
  rays.group_count = groups.size();
  rays.width = sensors::pixels_per_group(instrument);
  const int count = instrument.samples_u * instrument.samples_v;
  rays.u.resize(static_cast<std::size_t>(count));
  rays.v.resize(static_cast<std::size_t>(count));
  for (int s = 0; s < count; ++s)
    rc_sample_uv(RC_SAMPLER_GRID, instrument.samples_u, instrument.samples_v,
                 static_cast<float>(instrument.psf_support_px), 0u, 0u, s, &rays.u[static_cast<std::size_t>(s)],
                 &rays.v[static_cast<std::size_t>(s)]);
  return rays;
}

std::vector<std::size_t> which_differ(const std::vector<RayResult>& a, const std::vector<RayResult>& b) {
  std::vector<std::size_t> out;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (a[i].instance != b[i].instance || (a[i].instance != RC_NONE && a[i].primitive != b[i].primitive))
      out.push_back(i);
  return out;
}

double differing(const std::vector<RayResult>& a, const std::vector<RayResult>& b) {
  return static_cast<double>(which_differ(a, b).size()) / static_cast<double>(a.size());
}

double hit_or_miss(const std::vector<RayResult>& a, const std::vector<RayResult>& b) {
  std::size_t apart = 0;
  for (std::size_t i = 0; i < a.size(); ++i) apart += (a[i].instance == RC_NONE) != (b[i].instance == RC_NONE);
  return static_cast<double>(apart) / static_cast<double>(a.size());
}

namespace {

// One hit, or two triangles of one mesh met at one place: the samples of a pixel's middle row run along the edges of a
// DEM of its spacing.
bool same_place(const scene::CompiledScene& scene, const reference::Ray& ray, const reference::Hit& a,
                const reference::Hit& b) {
  if (a == b) return true;
  if (a.miss() || b.miss() || a.instance != b.instance) return false;
  constexpr double kSame = 1e-9;  // of the way: fp32 vertices part at 6e-8 of theirs
  const auto local = reference::to_local(scene.instances[a.instance], reference::to_double(ray));
  const auto of_a = reference::contact(scene, a.primitive, local), of_b = reference::contact(scene, b.primitive, local);
  return of_a.possible() && of_b.possible() && std::abs(of_a.t - of_b.t) <= kSame * of_b.t;
}

}  // namespace

Judgement judge(const scene::CompiledScene& scene, const PrimaryRays& rays, const std::vector<RayResult>& ours,
                const std::vector<RayResult>& theirs, std::size_t most) {
  const std::vector<std::size_t> differ = which_differ(ours, theirs);
  const reference::DoubleTracer tracer(scene);
  Judgement verdict;
  verdict.differ = differ.size();
  const std::size_t step = differ.size() / most + 1;
  const auto hit = [](const RayResult& r) {
    return r.instance == RC_NONE ? reference::Hit{} : reference::Hit{r.instance, r.primitive};
  };
  for (std::size_t n = 0; n < differ.size(); n += step) {
    const std::size_t i = differ[n], pixel = i / rays.samples(), sample = i % rays.samples(),
                      width = static_cast<std::size_t>(rays.width);
    const shared::RayGroup& g = rays.groups[pixel / width];
    const reference::Ray ray = reference::sample_ray(g, static_cast<int>(pixel % width), static_cast<int>(width),
                                                     rays.u[sample], rays.v[sample]);
    const reference::Hit own = hit(ours[i]), other = hit(theirs[i]), exact = tracer.trace(ray).hit;
    ++verdict.judged;
    verdict.unexplained += tracer.explain(ray, own, exact) == reference::Cause::unexplained;
    verdict.theirs_unexplained += tracer.explain(ray, other, exact) == reference::Cause::unexplained;
    verdict.ours_right += same_place(scene, ray, own, exact);
    verdict.theirs_right += same_place(scene, ray, other, exact);
  }
  return verdict;
}

ShadowJudgement judge(const scene::CompiledScene& scene, const ShadowRays& rays, const std::vector<RayResult>& hits,
                      const std::vector<RayResult>& ours, const std::vector<RayResult>& theirs) {
  const reference::DoubleTracer tracer(scene);
  ShadowJudgement verdict;
  for (std::size_t i = 0; i < ours.size(); ++i) {
    if (ours[i].instance == theirs[i].instance) continue;
    ++verdict.differ;
    const bool own = !rays.dx.empty();
    const reference::DoubleRay ray{{rays.x[i], rays.y[i], rays.z[i]},
                                   {own ? rays.dx[i] : rays.direction[0], own ? rays.dy[i] : rays.direction[1],
                                    own ? rays.dz[i] : rays.direction[2]},
                                   0};
    const auto seen = tracer.visibility(ray, {hits[i].instance, hits[i].primitive});
    const bool ours_lit = ours[i].instance != RC_NONE;
    verdict.ours_wrong +=
        (seen == reference::Visibility::visible && !ours_lit) || (seen == reference::Visibility::blocked && ours_lit);
  }
  return verdict;
}

std::vector<std::uint32_t> candidates(const scene::CompiledScene& scene, const scene::Instrument& instrument,
                                      const std::vector<shared::RayGroup>& groups, int threads) {
  const int cells = std::max(instrument.samples_u, instrument.samples_v);
  const double half_px = 0.5 * instrument.psf_support_px * (1.0 - 1.0 / cells);
  return count_candidates(scene, groups, sensors::pixels_per_group(instrument), half_px, threads);
}

std::vector<shared::RayGroup> groups_with_candidates(const scene::CompiledScene& scene,
                                                     const scene::Instrument& instrument, std::uint32_t least,
                                                     int threads) {
  const auto all = sensors::make_ray_groups(instrument, scene, 0, instrument.lines);
  const auto counts = candidates(scene, instrument, all, threads);
  const auto width = static_cast<std::size_t>(sensors::pixels_per_group(instrument));
  const auto per_line = static_cast<std::size_t>(sensors::groups_per_line(instrument));
  const bool last_is_short = static_cast<std::size_t>(instrument.pixels) % width != 0;
  std::vector<shared::RayGroup> chosen;
  for (std::size_t g = 0; g < all.size(); ++g) {
    if (last_is_short && g % per_line == per_line - 1) continue;
    const auto first = counts.begin() + static_cast<std::ptrdiff_t>(g * width);
    if (std::all_of(first, first + static_cast<std::ptrdiff_t>(width), [least](std::uint32_t n) { return n >= least; }))
      chosen.push_back(all[g]);
  }
  return chosen;
}

double mean(const std::vector<std::uint32_t>& counts) {
  return std::accumulate(counts.begin(), counts.end(), 0.0) / static_cast<double>(counts.size());
}

}  // namespace raycube::bench
