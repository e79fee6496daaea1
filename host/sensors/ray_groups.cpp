#include "host/sensors/ray_groups.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/geometric.hpp>

#include "host/base/error.h"
#include "host/base/interrupt.h"
#include "host/sensors/camera_frame.h"
#include "kernels/shared/tile_layout.h"

namespace raycube::sensors {
namespace {

using scene::InstrumentKind;

struct Plane {  // a pixel's rays are d + a du + b dv, o + b ov, a and b in pixels from the pixel's centre
  glm::dvec3 origin_m{0}, d{0}, du{0}, dv{0}, ov{0};
};

// Lines of a scanner come in time order, so its image plane is a framing camera's turned by 180 degrees
// (docs/conventions.md): +1 when samples run to the right wing and lines to the tail, -1 when they run to the left wing
// and to the nose.
double image_sense(const scene::Instrument& instrument) {
  return instrument.kind == InstrumentKind::framing ? 1.0 : -1.0;
}

std::size_t poses_needed(const scene::Instrument& instrument) {
  const auto lines = static_cast<std::size_t>(instrument.lines), pixels = static_cast<std::size_t>(instrument.pixels);
  switch (instrument.kind) {
    case InstrumentKind::framing:
      return 1;
    case InstrumentKind::pushbroom:
      return lines;
    case InstrumentKind::whiskbroom:
      return lines * pixels;
  }
  throw base::Error(base::Fault::bug, "instrument kind outside its enum");
}

void check_poses(const scene::Instrument& instrument) {
  if (instrument.pixels <= 0 || instrument.lines <= 0)
    throw base::Error(base::Fault::input, "instrument '" + instrument.name +
                                              "': an image has at least one pixel, found " +
                                              std::to_string(instrument.pixels) + " x " +
                                              std::to_string(instrument.lines) + "; give pixels and lines");
  const std::size_t needed = poses_needed(instrument);
  if (instrument.poses.size() != needed)
    throw base::Error(base::Fault::input,
                      "instrument '" + instrument.name + "': found " + std::to_string(instrument.poses.size()) +
                          " poses, needs " + std::to_string(needed) +
                          " (framing: one; pushbroom: one per line; whiskbroom: one per pixel, line by line)");
  if (instrument.kind == InstrumentKind::pushbroom && instrument.motion == scene::PoseMotion::moving &&
      instrument.lines < 2)
    throw base::Error(base::Fault::input,
                      "instrument '" + instrument.name +
                          "': a moving pose needs at least two lines to move between, found one; use a "
                          "held pose");
}

// Position along a line, pixels from its middle.
double across_px(const scene::Instrument& instrument, double sample) {
  return sample + 0.5 - 0.5 * static_cast<double>(instrument.pixels);
}

CameraFrame frame_in_line(const scene::Instrument& instrument, int line, double fraction) {
  const auto& poses = instrument.poses;
  const int last = instrument.lines - 1;
  const int from = fraction < 0 ? std::max(line - 1, 0) : std::min(line, std::max(last - 1, 0));
  const int to = std::min(from + 1, last);
  return interpolate(poses[from], poses[to], line - from + fraction);
}

// Plane about the place `sample` (a pixel's centre or a group's, so halves occur) of a line.
Plane plane_at(const scene::Instrument& instrument, int line, double sample, bool moving) {
  const double sense = image_sense(instrument);
  const double x = across_px(instrument, sample) * instrument.ifov_across_rad;
  Plane plane;
  if (instrument.kind == InstrumentKind::whiskbroom) {
    // The mirror turns by equal angles: sample s looks at the angle x from the boresight, about the nose.
    const std::size_t index = static_cast<std::size_t>(line) * instrument.pixels + static_cast<std::size_t>(sample);
    const CameraFrame frame = frame_of(instrument.poses[index]);
    plane.origin_m = frame.origin_m;
    plane.d = std::cos(x) * frame.boresight + sense * std::sin(x) * frame.right;
    plane.du = instrument.ifov_across_rad * (sense * std::cos(x) * frame.right - std::sin(x) * frame.boresight);
    plane.dv = -sense * instrument.ifov_along_rad * frame.forward;
    return plane;
  }
  const bool framing = instrument.kind == InstrumentKind::framing;
  const CameraFrame frame = frame_of(instrument.poses[framing ? 0 : line]);
  const double y = framing ? (line + 0.5 - 0.5 * instrument.lines) * instrument.ifov_along_rad : 0.0;
  plane.origin_m = frame.origin_m;
  plane.d = frame.boresight + sense * (x * frame.right - y * frame.forward);
  plane.du = sense * instrument.ifov_across_rad * frame.right;
  if (!moving) {
    plane.dv = -sense * instrument.ifov_along_rad * frame.forward;
    return plane;
  }
  const CameraFrame begin = frame_in_line(instrument, line, -0.5), end = frame_in_line(instrument, line, 0.5);
  plane.ov = end.origin_m - begin.origin_m;
  plane.dv = end.boresight + sense * x * end.right - (begin.boresight + sense * x * begin.right);
  return plane;
}

shared::rc_float4 rounded(const glm::dvec3& v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z), 0.0f};
}

constexpr double kClearance = 1e-5,
                 kClearance_m = 1;  // rays start this far above the scene: a part of the sensor's height, and

// How far ahead of the sensor, in units of d, the rays of a group may start with all of its field still above top_m.
float ahead_of(const Plane& plane, double top_m, double half_a, double half_b) {
  const double lowest = plane.origin_m.z - half_b * std::abs(plane.ov.z);
  const double steepest = -plane.d.z + half_a * std::abs(plane.du.z) + half_b * std::abs(plane.dv.z);
  const double way = lowest - top_m - kClearance_m - kClearance * std::abs(lowest);
  if (!(way > 0 && steepest > 0 && plane.d.z < 0)) return 0;
  return static_cast<float>(way / steepest * (1 - kClearance));
}

shared::RayGroup group_at(const scene::Instrument& instrument, int line, int group, int width, bool moving,
                          double top_m) {
  const Plane plane = plane_at(instrument, line, group * width + 0.5 * (width - 1), moving);
  const double half = 0.5 * std::max(1.0, instrument.psf_support_px);
  const float ahead = ahead_of(plane, top_m, 0.5 * (width - 1) + half, half);
  shared::RayGroup out{rounded(plane.origin_m + static_cast<double>(ahead) * plane.d), rounded(plane.d),
                       rounded(plane.du), rounded(plane.dv), rounded(plane.ov)};
  out.d0.w = ahead;
  out.origin.w = std::bit_cast<float>(pixel_number(instrument, line, group * width));
  return out;
}

/// Height that nothing of a scene lies above; infinity where it holds nothing.
double top_of(const scene::CompiledScene& scene) {
  return scene.lo[2] <= scene.hi[2] ? scene.hi[2] : std::numeric_limits<double>::infinity();
}

std::vector<shared::RayGroup> groups_in(const scene::Instrument& instrument, int first_line, int line_count,
                                        int first_group, int group_count, double top_m) {
  check_poses(instrument);
  if (first_line < 0 || line_count < 0 || line_count > instrument.lines - first_line || first_group < 0 ||
      group_count < 0 || group_count > groups_per_line(instrument) - first_group)
    throw base::Error(base::Fault::bug, "instrument '" + instrument.name + "': lines " + std::to_string(first_line) +
                                            " + " + std::to_string(line_count) + ", groups " +
                                            std::to_string(first_group) + " + " + std::to_string(group_count) +
                                            " lie outside the image of " + std::to_string(instrument.lines) +
                                            " lines of " + std::to_string(groups_per_line(instrument)) + " groups");
  const bool moving = pose_moves(instrument);
  const int width = pixels_per_group(instrument);
  std::vector<shared::RayGroup> groups;
  groups.reserve(static_cast<std::size_t>(group_count) * static_cast<std::size_t>(line_count));
  for (int line = first_line; line < first_line + line_count; ++line)
    for (int group = first_group; group < first_group + group_count; ++group)
      groups.push_back(group_at(instrument, line, group, width, moving, top_m));
  return groups;
}

}  // namespace

int pixels_per_group(const scene::Instrument& instrument) {
  return instrument.kind == InstrumentKind::whiskbroom ? 1 : RC_GROUP_WIDTH;
}

int groups_per_line(const scene::Instrument& instrument) {
  return static_cast<int>(shared::rc_groups_per_line(static_cast<std::uint32_t>(instrument.pixels),
                                                     static_cast<std::uint32_t>(pixels_per_group(instrument))));
}

std::uint32_t pixel_number(const scene::Instrument& instrument, int line, int sample) {
  return static_cast<std::uint32_t>(line) * static_cast<std::uint32_t>(instrument.pixels) +
         static_cast<std::uint32_t>(sample);
}

std::vector<shared::RayGroup> make_ray_groups(const scene::Instrument& instrument, int first_line, int line_count,
                                              double top_m) {
  return groups_in(instrument, first_line, line_count, 0, groups_per_line(instrument), top_m);
}

shared::RayGroup make_ray_group(const scene::Instrument& instrument, int line, int group, bool moving) {
  return group_at(instrument, line, group, pixels_per_group(instrument), moving,
                  std::numeric_limits<double>::infinity());
}

shared::RayGroup make_ray_group(const scene::Instrument& instrument, const scene::CompiledScene& scene, int line,
                                int group, bool moving) {
  return group_at(instrument, line, group, pixels_per_group(instrument), moving, top_of(scene));
}

std::vector<shared::RayGroup> make_ray_groups(const scene::Instrument& instrument, const scene::CompiledScene& scene,
                                              int first_line, int line_count) {
  return make_ray_groups(instrument, first_line, line_count, top_of(scene));
}

std::vector<shared::RayGroup> make_ray_groups(const scene::Instrument& instrument, const scene::CompiledScene& scene,
                                              int first_line, int line_count, int first_group, int group_count) {
  return groups_in(instrument, first_line, line_count, first_group, group_count, top_of(scene));
}

Ray pixel_ray(const scene::Instrument& instrument, int line, int sample, double u, double v) {
  check_poses(instrument);
  const Plane plane = plane_at(instrument, line, sample, pose_moves(instrument));
  return {plane.origin_m + v * plane.ov, plane.d + u * plane.du + v * plane.dv};
}

bool pose_moves(const scene::Instrument& instrument, double share_px) {
  if (instrument.kind != InstrumentKind::pushbroom || instrument.motion == scene::PoseMotion::held) return false;
  if (instrument.motion == scene::PoseMotion::moving) return true;
  check_poses(instrument);
  if (instrument.lines < 2) return false;
  const auto ground = [](const glm::dvec3& o, const glm::dvec3& d) { return o - d * (o.z / d.z); };
  for (int line = 0; line < instrument.lines; ++line) {
    if (line % 1024 == 0) base::throw_if_interrupted();
    for (const double sample : {0.0, 0.5 * (instrument.pixels - 1), instrument.pixels - 1.0}) {
      const Plane held = plane_at(instrument, line, sample, false), moving = plane_at(instrument, line, sample, true);
      if (held.d.z >= 0) continue;  // view_bounds refuses rays that look up
      const double pixel_m = glm::length(held.d) * (held.origin_m.z / -held.d.z) * instrument.ifov_across_rad;
      for (const double v : {-0.5, 0.5}) {
        const glm::dvec3 apart = ground(held.origin_m, held.d + v * held.dv) -
                                 ground(moving.origin_m + v * moving.ov, moving.d + v * moving.dv);
        if (glm::length(apart) > share_px * pixel_m) return true;
      }
    }
  }
  return false;
}

}  // namespace raycube::sensors
