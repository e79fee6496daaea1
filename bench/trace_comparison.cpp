#include "bench/trace_comparison.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "bench/rays.h"
#include "host/base/units.h"

namespace raycube::bench {

std::array<float, 3> sun_vector(const scene::Sun& sun) {
  const double zenith = base::rad_by_division(sun.zenith_deg), azimuth = base::rad_by_division(sun.azimuth_deg);
  return {static_cast<float>(std::sin(zenith) * std::sin(azimuth)),
          static_cast<float>(std::sin(zenith) * std::cos(azimuth)), static_cast<float>(std::cos(zenith))};
}

std::array<float, 3> bench_sun() {
  scene::Sun sun;
  sun.zenith_deg = 34;
  sun.azimuth_deg = 135;
  return sun_vector(sun);
}

Comparison compare_traces(const scene::CompiledScene& scene, const scene::Instrument& instrument,
                          const std::vector<shared::RayGroup>& groups, const std::array<float, 3>& sun, bool all_modes,
                          const Limits& limits, const Settings& settings, Report& report, const std::string& label) {
  const PrimaryRays rays = primary_rays(instrument, groups);
  const EmbreeBaseline embree(scene);
  TraceRig rig(scene, instrument, groups.size(), sun, settings.threads);
  rig.set_groups(groups);
  rig.run();
  const std::vector<RayResult> ours = rig.hits(), ours_sun = rig.sun();
  const ShadowRays shadows = rig.shadow_rays();

  std::vector<RayResult> theirs(rays.rays()), theirs_sun(rays.rays());
  const std::size_t modes = all_modes ? std::size(kEmbreeModes) : 1;
  for (std::size_t m = 0; m < modes; ++m) {  // also the warm-up of each mode
    embree.primary(rays, kEmbreeModes[m], settings.threads, theirs.data());
    embree.to_scene(theirs.data(), theirs.size());
    const std::string mode = label + ", Embree " + mode_name(kEmbreeModes[m]);
    const Judgement verdict = judge(scene, rays, ours, theirs, 2000);
    std::printf(
        "  %s: %.3g of the rays hit another primitive; of %zu of them judged in double ours are right in %zu, Embree's "
        "in %zu\n",
        mode.c_str(), differing(ours, theirs), verdict.judged, verdict.ours_right, verdict.theirs_right);
    std::printf("  %s: %zu of them lie outside every rounding bound on Embree's side\n", mode.c_str(),
                verdict.theirs_unexplained);
    report.validate(mode + ": rays of ours that double contradicts beyond rounding",
                    static_cast<double>(verdict.unexplained), 0);
    const double off =
        verdict.judged ? 1 - static_cast<double>(verdict.ours_right) / static_cast<double>(verdict.judged) : 0;
    report.validate(mode + ": rays where double arithmetic is not with us", off * differing(ours, theirs),
                    limits.ours_off);
    embree.shadow(shadows, kEmbreeModes[m], settings.threads, theirs_sun.data());
    const ShadowJudgement shade = judge(scene, shadows, ours, ours_sun, theirs_sun);
    report.validate(mode + ": shadow rays that differ",
                    static_cast<double>(shade.differ) / static_cast<double>(rays.rays()), limits.shadows_off);
    report.validate(mode + ": shadow rays of ours that are wrong in double", static_cast<double>(shade.ours_wrong), 0);
  }

  Comparison result;
  result.program_hash = rig.program_hash();
  for (int pair = 0; pair < kPairs; ++pair) {
    double primary_best = 1e300, shadow_best = 1e300, primary_s = 0, shadow_s = 0;
    for (std::size_t m = 0; m < modes; ++m) {
      const double p = seconds_of([&] { embree.primary(rays, kEmbreeModes[m], settings.threads, theirs.data()); });
      const double s =
          seconds_of([&] { embree.shadow(shadows, kEmbreeModes[m], settings.threads, theirs_sun.data()); });
      primary_best = std::min(primary_best, p);
      shadow_best = std::min(shadow_best, s);
      if (m == 0) {
        primary_s = p;
        shadow_s = s;
      }
    }
    const TraceRig::Times times = rig.run();
    result.primary.reference_s.push_back(primary_s);
    result.primary_best.reference_s.push_back(primary_best);
    result.shadow.reference_s.push_back(shadow_s);
    result.shadow_best.reference_s.push_back(shadow_best);
    for (Pairs* p : {&result.primary, &result.primary_best}) p->ours_s.push_back(times.primary_s);
    for (Pairs* p : {&result.shadow, &result.shadow_best}) p->ours_s.push_back(times.sun_s);
  }
  return result;
}

}  // namespace raycube::bench
