// [lidar.scan], [lidar.transmitter], [lidar.receiver], [lidar.gate] and [lidar.sampling].
#include <cmath>

#include "scene_compiler/document_values.h"
#include "scene_compiler/lidar_parts.h"
#include "host/base/units.h"

namespace raycube::scene::detail {
namespace {}  // namespace

void read_scan(const Record& scan, Lidar& out, const LidarReport& report) {
  const std::string& pattern = scan.text("pattern");
  const std::string because = "pattern = \"" + pattern + "\"";
  LidarScan& s = out.scan;
  const auto cycle = [&](ScanPattern kind) {
    s.pattern = kind;
    want_keys(scan, {"rate_hz", "half_angle_deg"}, because, report);
    refuse_keys(scan, {"columns", "rows", "step_deg"}, because, report);
    s.scan_rate_hz = scan.number("rate_hz");
    s.half_angle_rad = base::rad_from_deg(scan.number("half_angle_deg"));
    const double most_deg = kind == ScanPattern::rotating ? 180 : 89;
    if (s.half_angle_rad > base::rad_from_deg(most_deg))
      report.problems.add(scan.place("half_angle_deg"), "'half_angle_deg' is out of range for " + because,
                          number_text(scan.number("half_angle_deg")), "give at most " + number_text(most_deg));
  };
  if (pattern == "fixed") {
    refuse_keys(scan, {"rate_hz", "half_angle_deg", "columns", "rows", "step_deg"}, because, report);
  } else if (pattern == "raster") {
    s.pattern = ScanPattern::raster;
    want_keys(scan, {"columns", "rows", "step_deg"}, because, report);
    refuse_keys(scan, {"rate_hz", "half_angle_deg"}, because, report);
    s.columns = static_cast<int>(scan.integer("columns")), s.rows = static_cast<int>(scan.integer("rows"));
    s.step_rad = base::rad_from_deg(scan.number("step_deg"));
    if (0.5 * std::max(s.columns, s.rows) * s.step_rad > base::rad_from_deg(89))
      report.problems.add(scan.place("step_deg"), "the raster reaches beyond 89 degrees from the boresight",
                          number_text(scan.number("step_deg")), "lower it, or columns and rows");
  } else {
    cycle(pattern == "line"          ? ScanPattern::line
          : pattern == "oscillating" ? ScanPattern::oscillating
          : pattern == "rotating"    ? ScanPattern::rotating
                                     : ScanPattern::palmer);
  }
}

void read_mount(const Record& mount, LidarMount& out, const LidarReport& report) {
  for (std::size_t i = 0; i < 3; ++i) out.offset_m[i] = mount.numbers("offset_m")[i];
  const auto tilt = [&](const char* deg, const char* mrad) {
    if (count_given(mount, {deg, mrad}) == 2)
      report.problems.add(mount.place(mrad), std::string("'") + deg + "' and '" + mrad + "' exclude each other", "both",
                          "remove one");
    return mount.given(mrad) ? mount.number(mrad) * 1e-3 : base::rad_from_deg(mount.number(deg));
  };
  out.tilt_along_rad = tilt("tilt_along_deg", "tilt_along_mrad");
  out.tilt_across_rad = tilt("tilt_across_deg", "tilt_across_mrad");
}

void read_receiver(const Record& receiver, Lidar& out, const LidarReport& report) {
  auto& problems = report.problems;
  LidarReceiver& r = out.receiver;
  read_mount(receiver, out.receiver_mount, report);
  r.aperture_radius_m = 0.5 * receiver.number("aperture_diameter_m");
  r.obscuration_radius_m = 0.5 * receiver.number("obscuration_diameter_m");
  if (r.obscuration_radius_m >= r.aperture_radius_m)
    problems.add(receiver.place("obscuration_diameter_m"), "the obscuration covers the aperture",
                 number_text(2 * r.obscuration_radius_m) + " m of " + number_text(2 * r.aperture_radius_m) + " m",
                 "make it smaller");
  const Record* array = receiver.table("array");
  if (receiver.given("fov_mrad") == (array != nullptr))
    problems.add(receiver.where, "receiver needs exactly one of fov_mrad and array", array ? "both" : "neither",
                 array ? "an array's field follows from its pixels: remove fov_mrad"
                       : "give the full angle of the field, or the array");
  r.half_fov_rad = array ? 0 : 0.5e-3 * receiver.number("fov_mrad");
  r.focal_length_m = receiver.number("focal_length_mm") * 1e-3;
  if (array) {
    refuse_keys(receiver, {"focal_length_mm"}, "a receiver with array, which has its own", report);
    r.columns = static_cast<int>(array->integer("columns")), r.rows = static_cast<int>(array->integer("rows"));
    if (r.columns * r.rows == 1)
      problems.add(array->where, "an array has at least two pixels", "1 x 1",
                   "give fov_mrad for a single detector, or more columns or rows");
    r.focal_length_m = array->number("focal_length_mm") * 1e-3;
    r.pixel_pitch_rad = array->number("pitch_um") * 1e-6 / r.focal_length_m;
    if (0.5 * std::max(r.columns, r.rows) * r.pixel_pitch_rad > 10)
      problems.add(array->where, "the array reaches beyond 84 degrees from its axis",
                   number_text(r.pixel_pitch_rad) + " pitch over focal length", "correct pitch_um or focal_length_mm");
  }
  r.tangent_aperture = receiver.text("camera_factor") == "tangent";
  if (r.tangent_aperture && r.focal_length_m == 0)
    problems.add(receiver.place("camera_factor"), "camera_factor = \"tangent\" needs the focal length", "none",
                 "give focal_length_mm");
  r.focus_m = receiver.number("focus_m");
  r.efficiency = receiver.number("efficiency");
  r.quantum_efficiency = receiver.number("quantum_efficiency");
  r.filter_fwhm_um = receiver.number("filter_fwhm_nm") * 1e-3;
  r.scans_with_beam = receiver.boolean("scans_with_beam");
}

void read_sampling(const Record& sampling, Lidar& out, const LidarReport&) {
  LidarTransport& t = out.transport;
  const bool array = out.receiver.columns * out.receiver.rows > 1;
  const bool receiver = sampling.given("from") ? sampling.text("from") == "receiver" : array;
  t.sampling = receiver ? LidarSampling::receiver : LidarSampling::transmitter;
  t.subrays_given = sampling.given("subrays");
  if (t.subrays_given) t.subrays = static_cast<int>(sampling.integer("subrays"));
  t.max_bounces = static_cast<int>(sampling.integer("bounces"));
  t.line_nodes = static_cast<int>(sampling.integer("line_nodes"));
  t.group_index = sampling.number("group_index");
  t.overlap = sampling.text("overlap") == "off" ? LidarOverlap::off : LidarOverlap::exact;
  t.air_return = sampling.boolean("air_return");
  t.minimum_range_m = sampling.number("minimum_range_m");
  t.range_limit_m = sampling.number("range_limit_m");
}

void read_gate(const Record& gate, Lidar& out, const LidarReport& report) {
  auto& problems = report.problems;
  const double s_per_m = 2 * out.transport.group_index / base::kLightSpeed_m_s;
  if (count_given(gate, {"start_ns", "start_range_m"}) == 2)
    problems.add(gate.place("start_range_m"), "'start_ns' and 'start_range_m' exclude each other", "both",
                 "remove one");
  out.gate.start_s =
      gate.given("start_range_m") ? gate.number("start_range_m") * s_per_m : gate.number("start_ns") * 1e-9;
  out.gate.bin_s = gate.number("bin_ns") * 1e-9;
  if (count_given(gate, {"bins", "stop_range_m"}) != 1) {
    problems.add(gate.where, "gate needs exactly one of bins and stop_range_m", gate.given("bins") ? "both" : "neither",
                 "remove or add one");
    return;
  }
  if (gate.given("bins")) {
    out.gate.bins = static_cast<int>(gate.integer("bins"));
    return;
  }
  const double bins = std::ceil((gate.number("stop_range_m") * s_per_m - out.gate.start_s) / out.gate.bin_s - 1e-9);
  if (!(bins >= 1 && bins <= 1e6)) {
    problems.add(gate.place("stop_range_m"),
                 bins < 1 ? "the gate is empty: it stops before it starts" : "the gate has more than 1e6 bins",
                 number_text(gate.number("stop_range_m")) + " m",
                 bins < 1 ? "raise stop_range_m" : "lower it, or widen bin_ns");
    return;
  }
  out.gate.bins = static_cast<int>(bins);
}

}  // namespace raycube::scene::detail
