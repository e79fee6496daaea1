// Ours against Embree on the same rays: validate, then time in turn.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "bench/cases.h"
#include "bench/timing.h"
#include "bench/trace_rig.h"

namespace raycube::bench {

/// Largest shares of rays, with their reasons at the caller.
struct Limits {
  double ours_off =
      0;  ///< our hit is not the one of double arithmetic (but within rounding: beyond it, none is allowed)
  double shadows_off = 0;  ///< shadow rays that differ from Embree's
};

struct Comparison {
  Pairs primary, primary_best, shadow,
      shadow_best;           ///< reference: 16 coherent; the fastest of Embree's modes in each round
  std::string program_hash;  ///< of the tracing programs that were timed
};

/// modes: which of Embree's modes take part (16 coherent always does).
Comparison compare_traces(const scene::CompiledScene& scene, const scene::Instrument& instrument,
                          const std::vector<shared::RayGroup>& groups, const std::array<float, 3>& sun, bool all_modes,
                          const Limits& limits, const Settings& settings, Report& report, const std::string& label);

/// Unit vector towards a sun at 34 degrees from the zenith, south-east.
std::array<float, 3> bench_sun();
std::array<float, 3> sun_vector(const scene::Sun& sun);

}  // namespace raycube::bench
