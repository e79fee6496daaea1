// The pulse's shape over the bins of a gate.
#pragma once

#include "host/lidar/lidar_plan.h"

namespace raycube::lidar {

/// Share of a pulse's energy that arrives between two times about its centre (s, begin <= end), to 1e-15 in the tails:
/// erfc differences (gaussian), overlap (rectangular), exact integral of the linear pieces (tabulated).
double pulse_share(const scene::LidarPulse& pulse, double begin_s, double end_s);

/// Times about the centre beyond which less than 2e-9 of the energy lies: 6 standard deviations; the ends otherwise.
/// Seconds.
struct PulseSpan {
  double begin_s = 0, end_s = 0;
};
PulseSpan pulse_span(const scene::LidarPulse& pulse);

/// Centroid of the pulse's power, s: 0 but for a tabulated one whose file says otherwise.
double pulse_centroid_s(const scene::LidarPulse& pulse);

/// Shares for every phase. Linear between phases: off by at most 2e-6 of the largest share for a Gaussian, with as many
/// phases as that takes (at most 4096; reached at a FWHM of 0.35 bin); a rectangle's corners lie on phases where 4096
/// allow it. Energy is kept exactly. A pulse that spans more than 2048 bins is refused (base::Error, input): the device
/// adds every bin of it at every hit.
PulseTaps make_taps(const scene::LidarPulse& pulse, double bin_s);

}  // namespace raycube::lidar
