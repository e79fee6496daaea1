#include "scene_compiler/placed_box.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/base/text.h"
#include "scene_compiler/document_values.h"

namespace raycube::scene {

namespace {

constexpr float kFar = std::numeric_limits<float>::max();
constexpr PlacedBox kNothing{{kFar, kFar, kFar}, {-kFar, -kFar, -kFar}};
constexpr double kNoticeAbove = 1e-3, kErrorAbove = 0.1;

void widen(PlacedBox& box, std::size_t axis, float lo, float hi) {
  box.lo[axis] = std::min(box.lo[axis], lo), box.hi[axis] = std::max(box.hi[axis], hi);
}

/// Distance of neighbouring floats at the coordinate farthest from the origin, m.
double spacing_m(const PlacedBox& box) {
  double far = 0;
  for (std::size_t i = 0; i < 3; ++i)
    far = std::max({far, std::abs(static_cast<double>(box.lo[i])), std::abs(static_cast<double>(box.hi[i]))});
  return far > 0 ? std::ldexp(1.0, std::ilogb(far) - 23) : 0;
}

/// In the scene or in the object's own file, whichever is coarser.
double spacing_of(const PlacedBox& box) { return std::max(spacing_m(box), box.own_spacing_m); }

}  // namespace

std::vector<PlacedBox> placed_boxes(const SceneParts& parts) {
  std::vector<PlacedBox> of_mesh;
  for (const auto& mesh : parts.meshes) {
    PlacedBox& box = of_mesh.emplace_back(kNothing);
    for (const auto& vertex : mesh.mesh.vertices)
      for (std::size_t i = 0; i < 3; ++i) widen(box, i, vertex[i], vertex[i]);
  }
  std::vector<PlacedBox> out;
  for (const auto& placed : parts.placed) {
    PlacedBox& world = out.emplace_back(kNothing);
    const PlacedBox& box = of_mesh[placed.mesh];
    if (box.empty()) continue;
    const auto& m = placed.scene_from_mesh;
    double scale = 0;
    for (std::size_t i = 0; i < 3; ++i) scale = std::max(scale, std::hypot(m[i], m[4 + i], m[8 + i]));
    world.own_spacing_m = scale * spacing_m(box);
    for (std::size_t row = 0; row < 3; ++row) {
      // Each column of the matrix brings the least and the most by one end of the box.
      double lo = m[4 * row + 3], hi = lo;
      for (std::size_t i = 0; i < 3; ++i) {
        const double a = m[4 * row + i] * static_cast<double>(box.lo[i]),
                     b = m[4 * row + i] * static_cast<double>(box.hi[i]);
        lo += std::min(a, b), hi += std::max(a, b);
      }
      widen(world, row, static_cast<float>(lo), static_cast<float>(hi));
      world.size_m = std::max(world.size_m, hi - lo);
    }
  }
  return out;
}

PlacedBox box_around(const std::vector<PlacedBox>& boxes) {
  PlacedBox out = kNothing;
  for (const auto& box : boxes)
    if (!box.empty())
      for (std::size_t i = 0; i < 3; ++i) widen(out, i, box.lo[i], box.hi[i]);
  return out;
}

void check_resolution(const SceneParts& parts, const std::vector<PlacedBox>& boxes, const std::string& file,
                      std::vector<std::string>& notices, base::Problems& problems) {
  double worst = 0;
  std::size_t at = 0, coarse = 0;
  // Terrains' meshes come first; their placements may be repeated.
  const auto is_terrain = [&](std::size_t i) { return parts.placed[i].mesh < parts.terrains.size(); };
  const auto size_of = [&](std::size_t i) {
    const std::size_t mesh = parts.placed[i].mesh;
    return is_terrain(i) ? std::sqrt(parts.terrains[mesh].cell_area_m2()) / parts.terrain_refine[mesh]
                         : boxes[i].size_m;
  };
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    if (boxes[i].empty()) continue;
    // No size at all: its own file's coordinates, single precision too, have made one point of it.
    const double size = size_of(i), spacing = spacing_of(boxes[i]),
                 share = size > 0      ? spacing / size
                         : spacing > 0 ? std::numeric_limits<double>::infinity()
                                       : 0;
    coarse += share > kNoticeAbove;
    if (share > worst) worst = share, at = i;
  }
  if (!(worst > kNoticeAbove)) return;
  const PlacedBox& box = boxes[at];
  const auto place = [&](std::size_t i) {
    return number_text(std::round(0.5 * (static_cast<double>(box.lo[i]) + static_cast<double>(box.hi[i]))));
  };
  const std::string what = "'" + parts.meshes[parts.placed[at].mesh].name + "'";
  const std::string found = (is_terrain(at) ? "cells of " : "") + number_text(size_of(at)) + " m at " + place(0) +
                            ", " + place(1) + ", " + place(2) + ", where coordinates are " +
                            number_text(spacing_of(box)) + " m apart" +
                            (box.own_spacing_m > spacing_m(box) ? " in its own file" : "");
  const std::string way_out =
      "move the scene to its origin: subtract easting and northing from positions and meshes and state them as "
      "scene.origin";
  if (worst > kErrorAbove)
    problems.add({file, 0, 0, ""}, "single precision does not resolve " + what + " so far from the scene's origin",
                 found, way_out);
  else
    notices.push_back(file + ": " + base::counted(coarse, "object or terrain lies", "objects or terrains lie") +
                      " so far from the scene's origin that single precision shows in shadows (by up to 7 times the "
                      "spacing of coordinates), worst " +
                      what + ": " + found + "; " + way_out);
}

std::vector<std::uint32_t> find_buried(const SceneParts& parts, const std::vector<PlacedBox>& boxes,
                                       const std::string& file, std::vector<std::string>& notices) {
  std::vector<std::uint32_t> out;
  double ground_m = 0;
  for (std::size_t i = 0; i < boxes.size() && !parts.terrains.empty(); ++i) {
    const PlacedBox& box = boxes[i];
    if (box.empty() || parts.placed[i].mesh < parts.terrains.size()) continue;
    const double west = box.lo[0], east = box.hi[0], south = box.lo[1], north = box.hi[1];
    double lowest_m = std::numeric_limits<double>::infinity();
    for (const auto& [x, y] : {std::pair{west, south}, std::pair{west, north}, std::pair{east, south},
                               std::pair{east, north}, std::pair{0.5 * (west + east), 0.5 * (south + north)}})
      lowest_m = std::min(lowest_m, parts.terrain_height_m(x, y).value_or(-std::numeric_limits<double>::infinity()));
    if (!(static_cast<double>(box.hi[2]) < lowest_m)) continue;
    if (out.empty()) ground_m = lowest_m;
    out.push_back(static_cast<std::uint32_t>(i));
  }
  if (out.empty()) return out;
  const bool one = out.size() == 1;
  notices.push_back(file + ": " + std::to_string(out.size()) + (one ? " object lies" : " objects lie") +
                    " under the terrain, where nothing above sees " + (one ? "it" : "them") + ": '" +
                    parts.meshes[parts.placed[out.front()].mesh].name + "' reaches up to " +
                    number_text(static_cast<double>(boxes[out.front()].hi[2])) + " m, the ground there lies at " +
                    number_text(ground_m) + " m or higher; on_terrain = true counts its z from the ground");
  return out;
}

void tell_of_buried(const SceneParts& parts, const Simulation& simulation, std::vector<std::string>& notices) {
  const auto told = [&](const std::string& who, double x_m, double y_m, double z_m, const char* way_out) {
    const auto ground_m = parts.terrain_height_m(x_m, y_m);
    if (!ground_m || z_m >= *ground_m) return false;
    notices.push_back(simulation.file + ": " + who + " stands under the terrain: at z = " + short_text(z_m) +
                      " m, where the ground lies at " + short_text(*ground_m) + " m" + way_out);
    return true;
  };
  for (const Instrument& one : simulation.instruments)
    for (const Pose& pose : one.poses)
      if (told("instrument '" + one.name + "'", pose.x_m, pose.y_m, pose.z_m,
               "; it sees the ground from below: raise it, or give altitude_agl_m"))
        break;
  for (const Lidar& one : simulation.lidars)
    for (const LidarPose& pose : one.trajectory)
      if (told("LIDAR '" + one.name + "'", pose.x_m, pose.y_m, pose.z_m,
               "; its pulses meet the ground from below: raise it, or give altitude_agl_m"))
        break;
  for (const Lamp& one : simulation.lamps)
    for (const auto& at : one.position_m)
      if (told("lamp '" + one.name + "'", at[0], at[1], at[2],
               ", and lights nothing above it; on_terrain = true counts its z from the ground"))
        break;
}

}  // namespace raycube::scene
