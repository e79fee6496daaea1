// Rays of an instrument's pixels: computed in double from the poses, rounded once to the groups the kernels read.
#pragma once

#include <glm/vec3.hpp>
#include <limits>
#include <vector>

#include "kernels/shared/structs.h"
#include "scene_compiler/simulation.h"

namespace raycube::sensors {

/// Pixels of one line that share an origin and a traversal: RC_GROUP_WIDTH, or 1 for a whiskbroom (one pose per pixel).
/// Pixel i of a group lies at a = i - (width - 1) / 2.0 from the group's centre.
int pixels_per_group(const scene::Instrument& instrument);

/// ceil(pixels / pixels_per_group). The last group of a line may reach past the line's end; those pixels are not
/// rendered.
int groups_per_line(const scene::Instrument& instrument);

/// A pixel's place in the image, line * pixels + sample: what its random numbers are keyed by.
std::uint32_t pixel_number(const scene::Instrument& instrument, int line, int sample);

/// Groups of lines first_line .. first_line + line_count - 1, line by line. Each depends on its line alone, so any
/// split of the image into tiles gives the same bits. `top_m`: nothing of the scene lies above this height (scene
/// frame); rays of a sensor far above start there, where fp32 is fine (RayGroup.d0.w); by default at the sensor. All
/// that must see the same rays, bit for bit, give the same. Throws Error(input) when the poses do not match the image,
/// Error(bug) when the lines lie outside it.
std::vector<shared::RayGroup> make_ray_groups(const scene::Instrument& instrument, int first_line, int line_count,
                                              double top_m = std::numeric_limits<double>::infinity());
/// The same for a scene's own top.
std::vector<shared::RayGroup> make_ray_groups(const scene::Instrument& instrument, const scene::CompiledScene& scene,
                                              int first_line, int line_count);
/// Of each line only groups first_group .. first_group + group_count - 1: a few of a wide line cost a few.
std::vector<shared::RayGroup> make_ray_groups(const scene::Instrument& instrument, const scene::CompiledScene& scene,
                                              int first_line, int line_count, int first_group, int group_count);

/// One of these groups, from the sensor; `moving` as pose_moves() says.
shared::RayGroup make_ray_group(const scene::Instrument& instrument, int line, int group, bool moving);
/// The same from a scene's own top: bit for bit the one that make_ray_groups makes.
shared::RayGroup make_ray_group(const scene::Instrument& instrument, const scene::CompiledScene& scene, int line,
                                int group, bool moving);

/// A ray o + t d in the scene frame; d lies on the image plane at distance 1 and is not normalised.
struct Ray {
  glm::dvec3 origin_m{0};
  glm::dvec3 direction{0};
};

/// The ray through a place in a pixel: u along the line and v across lines, pixels from the pixel's centre, -0.5..0.5
/// inside it. Double, before any rounding: what the groups approximate and what tests and reports may use.
Ray pixel_ray(const scene::Instrument& instrument, int line, int sample, double u, double v);

/// True when v is time: a pushbroom whose pose moves while a line is exposed. Then the slit is narrow and sweeps: the
/// pixel's extent across lines is the way flown from line - 1/2 to line + 1/2, and ifov_along_rad is not used. Held:
/// the pose stands still and the extent is ifov_along_rad. PoseMotion::automatic becomes moving when the two differ on
/// the ground z = 0 by more than `share_px` pixels at a line's ends or centre; resolve it once when calling per tile.
bool pose_moves(const scene::Instrument& instrument, double share_px = 0.05);

}  // namespace raycube::sensors
