// Scalar optics of a LIDAR in double: what a receiver sees of a point, and what a surface sends there.
#pragma once

#include <glm/vec3.hpp>

#include "host/lidar/lidar_plan.h"

namespace raycube::reference {

/// Area common to two circles of radii a and b whose centres are d apart, all >= 0: two circular segments, each by a
/// form that keeps its digits when the lens is thin (Kahan, "Miscalculating area and angles of a needle-like triangle",
/// 2014).
double lens_area(double a, double b, double d);

/// Share of the clear pupil through which a point `range_m` along the axis and `offset_m` off it passes the field stop.
double pupil_share(const scene::LidarReceiver& receiver, double range_m, double offset_m);

/// Clear area of the pupil, m2, with the thin camera's factor 4F^2 / (1 + 4F^2), F = focal length / diameter, where it
/// is asked for.
double collecting_area(const scene::LidarReceiver& receiver);

/// Scattering matter of a hit at one line: area means over the surface's materials.
struct LidarMatter {
  double reflectance = 0;  ///< diffuse
  double leaf = 0;         ///< transmitted, diffuse into the half-space behind
  double plate = 0;        ///< goes straight on
  double gloss = 0;        ///< mirrored at normal incidence
  double scattered() const { return reflectance + leaf + gloss; }
  double absorbed() const { return 1 - scattered() - plate; }
};
LidarMatter matter_of(const scene::CompiledScene& scene, const lidar::LidarPlan& plan, std::uint32_t surface, int line);

/// How a surface spreads what it reflects, 1/sr, by the closed forms of kernels/materials. Light comes from `in` and
/// leaves to `out`, both unit vectors away from the surface.
struct SurfaceLobes {
  double front = 0;  ///< per unit of its reflectance
  double gloss = 0;  ///< area mean of its materials' gloss
};
SurfaceLobes lobes_of(const scene::CompiledScene& scene, const lidar::LidarPlan& plan, std::uint32_t surface, int line,
                      const glm::dvec3& normal, const glm::dvec3& in, const glm::dvec3& out);

/// A direction about the surface's normal, or behind it, by its shape; in: where light comes from, same frame.
RcLocal draw_direction(const scene::CompiledScene& scene, std::uint32_t surface, bool front, const RcLocal& in,
                       double u, double v);

/// A direction by the surface's gloss; z < 0: into it, where paths end. Then f cos / density of one, as above.
RcLocal draw_mirrored(const scene::CompiledScene& scene, std::uint32_t surface, const RcLocal& in, double u, double v);
double mirrored_weight(const scene::CompiledScene& scene, const lidar::LidarPlan& plan, std::uint32_t surface, int line,
                       const glm::dvec3& normal, const glm::dvec3& in, const glm::dvec3& out);

/// f cos / density of a direction drawn by the surface's shape, per unit of its reflectance: 1 by Lambert's law.
double drawn_weight(const scene::CompiledScene& scene, const lidar::LidarPlan& plan, std::uint32_t surface, int line,
                    const glm::dvec3& normal, const glm::dvec3& in, const glm::dvec3& out);

}  // namespace raycube::reference
