// What is known of a LIDAR's records before its first pulse: whether the gate can hold a return of the scene
// at all.
#include <algorithm>
#include <cmath>
#include <limits>

#include "scene_compiler/document_values.h"
#include "scene_compiler/lidar_parts.h"
#include "scene_compiler/lidar_reach.h"

namespace raycube::scene::detail {

namespace {

/// A gate, or what returns, in metres of range.
struct Span {
  double from_m = 0, to_m = 0;
  bool meets(const Span& other) const { return from_m <= other.to_m && other.from_m <= to_m; }
  std::string text() const { return number_text(from_m) + " to " + number_text(to_m) + " m"; }
};

/// Half the way that light goes in a second.
double metres_per_s(const Lidar& lidar) { return 0.5 * base::kLightSpeed_m_s / lidar.transport.group_index; }

/// How far from its middle a pulse still has power: a Gaussian's 1e-10 lies 2.9 of its full width at half
/// maximum away.
double pulse_reach_s(const LidarPulse& pulse) {
  if (pulse.shape == PulseShape::tabulated && !pulse.shape_time_s.empty())
    return std::max(std::abs(pulse.shape_time_s.front()), std::abs(pulse.shape_time_s.back()));
  return 3 * pulse.fwhm_s;
}

Span gate_of(const Lidar& lidar, double periods_later) {
  const double start_s = lidar.gate.start_s + periods_later / lidar.prf_hz;
  return {metres_per_s(lidar) * start_s, metres_per_s(lidar) * (start_s + lidar.gate.bins * lidar.gate.bin_s)};
}

/// Whether a gate so many periods after (before: below 0) its own pulse's holds any of the returns, for a
/// pulse that is fired.
bool earlier_pulses_meet(const Lidar& lidar, const Span& returns) {
  const double period_m = metres_per_s(lidar) / lidar.prf_hz, most = static_cast<double>(lidar.pulses - 1);
  const Span own = gate_of(lidar, 0);
  const double first = std::max(-most, std::ceil((returns.from_m - own.to_m) / period_m));
  return first <= most && first <= std::floor((returns.to_m - own.from_m) / period_m);
}

void note_gate_without_returns(const Record& record, const PlacedBox& box, const SceneParts& parts, const Lidar& lidar,
                               const LidarReport& report) {
  const Reach reach = reach_of(box.lo, box.hi, parts.volumes, lidar);
  if (!(reach.farthest_m > 0)) return;  // nothing is placed
  if (reach.farthest_m < reach.nearest_m) {
    report.notice(record.table("sampling")->place("range_limit_m"),
                  "rays end " + number_text(lidar.transport.range_limit_m) + " m away, but the scene begins " +
                      number_text(reach.nearest_m) +
                      " m from the platform: no surface can send light back; raise range_limit_m");
    return;
  }
  const double slack_m = metres_per_s(lidar) * pulse_reach_s(lidar.pulse);
  // Light that scatters more than once can come back however late.
  const Span returns{reach.nearest_m - slack_m, lidar.transport.max_bounces > 1
                                                    ? std::numeric_limits<double>::infinity()
                                                    : reach.farthest_m + slack_m};
  const Span gate = gate_of(lidar, 0);
  if (gate.meets(returns) || (lidar.fold_ambiguous && earlier_pulses_meet(lidar, returns))) return;
  std::string text = "the gate holds ranges of " + gate.text() + ", but everything in the scene lies " +
                     Span{reach.nearest_m, reach.farthest_m}.text() +
                     " from the platform: no surface's return can be recorded; ";
  const double period_m = metres_per_s(lidar) / lidar.prf_hz;
  if (!lidar.fold_ambiguous && lidar.pulses > 1 && reach.nearest_m > period_m && earlier_pulses_meet(lidar, returns))
    text += "those of earlier pulses fall into it, since pulses are " + number_text(period_m) +
            " m of range apart: set fold_ambiguous = true to record them, or move the gate";
  else
    text += "set start_range_m and stop_range_m";
  report.notice(record.table("gate")->where, text);
}

/// Hufnagel-Valley heights count from z = 0 where there is no terrain; a tenth of its lowest layer, 10 m,
/// changes Cn2 by a tenth.
void note_unsure_ground(const Record& record, const PlacedBox& box, const SceneParts& parts, const Lidar& lidar,
                        const LidarReport& report) {
  const LidarTurbulence& turbulence = lidar.turbulence;
  if (turbulence.profile != TurbulenceProfile::hufnagel_valley || turbulence.ground_z_m || !parts.terrains.empty())
    return;
  if (box.empty() || std::abs(box.lo[2]) <= 10) return;
  report.notice(record.table("turbulence")->where,
                "without [[terrain]] the ground of hufnagel_valley is z = 0, but the scene's lowest surface "
                "lies at z = " +
                    number_text(box.lo[2]) + " m; give ground_z_m");
}

}  // namespace

void check_before_first_pulse(const Record& record, const SceneParts& parts, const PlacedBox& box, const Lidar& lidar,
                              const LidarReport& report) {
  const auto& receiver = lidar.receiver;
  if (receiver.columns * receiver.rows == 1 && !(receiver.half_fov_rad > 0) &&
      lidar.transport.overlap == LidarOverlap::exact)
    report.problems.add(record.table("receiver")->place("fov_mrad"), "a field of view of 0 sees nothing", "0",
                        "give the full angle of the field, or sampling = { overlap = \"off\" } for a "
                        "receiver that sees every point");
  note_gate_without_returns(record, box, parts, lidar, report);
  note_unsure_ground(record, box, parts, lidar, report);
}

}  // namespace raycube::scene::detail
