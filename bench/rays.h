// Rays and their comparison, for every group of figures.
#pragma once

#include <vector>

#include "bench/embree_baseline.h"
#include "scene_compiler/simulation.h"

namespace raycube::bench {

/// The instrument's samples on the given groups, as the kernels place them (grid and lattice of pixel 0).
PrimaryRays primary_rays(const scene::Instrument& instrument, const std::vector<shared::RayGroup>& groups);

/// Share of rays whose instance or primitive differ.
double differing(const std::vector<RayResult>& a, const std::vector<RayResult>& b);
/// Those rays.
std::vector<std::size_t> which_differ(const std::vector<RayResult>& a, const std::vector<RayResult>& b);
/// Share of rays that hit in one and miss in the other.
double hit_or_miss(const std::vector<RayResult>& a, const std::vector<RayResult>& b);

/// Rays of which ours and theirs differ, judged in double on the same fp32 ray (at most `most` of them, evenly chosen).
struct Judgement {
  std::size_t differ = 0, judged = 0;
  std::size_t unexplained = 0;  ///< ours lies outside every rounding bound of host/reference/contact.h
  std::size_t theirs_unexplained =
      0;  ///< Embree's does: it inverts instance matrices in fp32, which no bound of ours holds
  std::size_t ours_right = 0, theirs_right = 0;  ///< agree with the hit in double
};
Judgement judge(const scene::CompiledScene& scene, const PrimaryRays& rays, const std::vector<RayResult>& ours,
                const std::vector<RayResult>& theirs, std::size_t most);

/// Shadow rays that differ, judged in double: `hits` name the surfaces they leave. wrong: double arithmetic is certain
/// and contradicts ours.
struct ShadowJudgement {
  std::size_t differ = 0, ours_wrong = 0;
};
ShadowJudgement judge(const scene::CompiledScene& scene, const ShadowRays& rays, const std::vector<RayResult>& hits,
                      const std::vector<RayResult>& ours, const std::vector<RayResult>& theirs);

/// Triangles per pixel that can hold one of the instrument's samples: [group * width + i].
std::vector<std::uint32_t> candidates(const scene::CompiledScene& scene, const scene::Instrument& instrument,
                                      const std::vector<shared::RayGroup>& groups, int threads);
/// Groups of the image all of whose pixels have at least `least` candidates, in image order.
std::vector<shared::RayGroup> groups_with_candidates(const scene::CompiledScene& scene,
                                                     const scene::Instrument& instrument, std::uint32_t least,
                                                     int threads);
double mean(const std::vector<std::uint32_t>& counts);

}  // namespace raycube::bench
