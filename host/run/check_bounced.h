// Light between surfaces: the device's sums over some pixels against paths of the reference, and the device's own
// paths, replayed.
#pragma once

#include <functional>

#include "host/reference/bounced_report.h"
#include "host/reference/replay_report.h"
#include "host/run/check_instrument.h"

namespace raycube::run {

/// Of kBouncedPixels pixels, or as many as the options ask where those are fewer; empty where the plan has none. The
/// device renders them kBouncedDraws times, each with other paths, and as often without any: by what these scatter its
/// own error is known.
inline constexpr std::uint64_t kBouncedPixels = 256;
inline constexpr std::uint32_t kBouncedPaths = 256;  ///< of the reference, a pixel
inline constexpr std::uint32_t kBouncedDraws = 16;
reference::BouncedReport check_bounced(render::Renderer& renderer, const scene::Simulation& simulation,
                                       const scene::Instrument& instrument, const plan::Plan& plan,
                                       const CheckOptions& options,
                                       const std::function<void(std::uint64_t)>& progress = {});

/// The device's own paths on some pixels, walked again: of kReplayedPixels, or of as many as the options ask where
/// those are fewer, or as their paths have kMostSteps. Nothing where the plan has none, or where some go through
/// plates.
inline constexpr std::uint64_t kReplayedPixels = 64, kMostSteps = std::uint64_t{1} << 21;
reference::ReplayReport replay_paths(render::Renderer& renderer, const scene::Simulation& simulation,
                                     const scene::Instrument& instrument, const plan::Plan& plan,
                                     const CheckOptions& options,
                                     const std::function<void(std::uint64_t)>& progress = {});

}  // namespace raycube::run
