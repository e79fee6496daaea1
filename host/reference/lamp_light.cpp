#include "host/reference/lamp_light.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

#include "host/base/units.h"
#include "host/reference/spread.h"
#include "kernels/sampling/lamp_draws.h"

namespace raycube::reference {

namespace {

constexpr int kPointsAlong = 8;        ///< of a surface, along each side
constexpr double kOwnRounding = 2e-5;  ///< of the device's irradiance, places apart
constexpr double kLampEdge = 1e-5;     ///< of all chances: sums rounded otherwise may draw the next lamp
constexpr double kPlaceUlp = 16;       ///< of a hit's place, in roundings of its coordinates

glm::dvec3 xyz(const shared::rc_float4& v) { return {v.x, v.y, v.z}; }
bool flat(const shared::Lamp& lamp) { return lamp.shape == RC_LAMP_RECTANGLE || lamp.shape == RC_LAMP_DISC; }

/// A table between two ascending nodes.
struct BetweenNodes {
  std::size_t low = 0;
  double f = 0;
};
BetweenNodes between_nodes(const float* nodes, std::size_t count, double x) {
  BetweenNodes out;
  while (out.low + 2 < count && static_cast<double>(nodes[out.low + 1]) <= x) ++out.low;
  const double a = nodes[out.low], b = nodes[out.low + 1];
  out.f = std::clamp((x - a) / (b - a), 0.0, 1.0);
  return out;
}

/// Intensity towards a direction over the largest.
double shines(const plan::Lamps& lamps, const shared::Lamp& lamp, const glm::dvec3& to) {
  const double up = glm::dot(xyz(lamp.axis), to);
  if (lamp.shape == RC_LAMP_SPOT) {
    const double inner = lamp.across.w, outer = lamp.along.w;
    return std::pow(std::clamp((up - outer) / (inner - outer), 0.0, 1.0), 2);
  }
  if (lamp.verticals == 0) return 1;
  const std::size_t rows = lamp.verticals, columns = lamp.horizontals;
  const float *vertical = lamps.distribution.data() + lamp.distribution, *horizontal = vertical + rows,
              *value = horizontal + columns;
  const double angle = base::deg_from_rad(std::acos(std::clamp(up, -1.0, 1.0)));
  if (angle < static_cast<double>(vertical[0]) || angle > static_cast<double>(vertical[rows - 1])) return 0;
  const BetweenNodes v = between_nodes(vertical, rows, angle);
  const auto along_plane = [&](std::size_t plane) {
    const float* from = value + plane * rows + v.low;
    return (1 - v.f) * static_cast<double>(from[0]) + v.f * static_cast<double>(from[1]);
  };
  if (columns == 1) return along_plane(0);
  double turn = base::deg_from_rad(std::atan2(glm::dot(xyz(lamp.along), to), glm::dot(xyz(lamp.across), to)));
  if (turn < 0) turn += 360;
  const BetweenNodes h = between_nodes(horizontal, columns, turn);
  return (1 - h.f) * along_plane(h.low) + h.f * along_plane(h.low + 1);
}

/// By how much that may differ for directions that are rounded: up to `angle` apart, rad.
double rounding_of(const plan::Lamps& lamps, const shared::Lamp& lamp, const glm::dvec3& to, double angle) {
  if (flat(lamp) || (lamp.shape == RC_LAMP_POINT && lamp.verticals == 0)) return 0;
  const double here = shines(lamps, lamp, to);
  const glm::dvec3 other = std::abs(to.x) < 0.6 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
  const glm::dvec3 a = glm::normalize(glm::cross(to, other)), b = glm::cross(to, a);
  double most = 0;
  for (int k = 0; k < 8; ++k) {
    const double turn = std::numbers::pi / 4 * k;
    const glm::dvec3 near = glm::normalize(to + angle * (std::cos(turn) * a + std::sin(turn) * b));
    most = std::max(most, std::abs(shines(lamps, lamp, near) - here));
  }
  return most;
}

/// How far apart directions may be rounded, rad: by places, and by an angle from a cosine in float, of which little is
/// left near the axis.
double rounded_angle(const shared::Lamp& lamp, const glm::dvec3& to, double places) {
  const double across = glm::length(glm::cross(xyz(lamp.axis), to));
  return places + std::min(std::sqrt(4 * kUlp), 4 * kUlp / std::max(across, 1e-9));
}

/// Of all draws, what goes to this lamp (not normalised).
double chance_of(const plan::Lamps& lamps, const shared::Lamp& lamp, const Sample& side) {
  const glm::dvec3 way = xyz(lamp.position) - side.point;
  const double d = glm::length(way), radius = lamp.axis.w;
  if (!(d > 0)) return 0;
  const double facing = std::min(1.0, glm::dot(way, side.normal) / d + radius / d);
  const double sent =
      flat(lamp) ? std::min(1.0, -glm::dot(way, xyz(lamp.axis)) / d + radius / d) : shines(lamps, lamp, -way / d);
  if (!(facing > 0) || !(sent > 0)) return 0;
  return static_cast<double>(lamp.position.w) * sent * facing / (d * d + radius * radius);
}

/// Irradiance by a point of a lamp that stands for all of it.
double irradiance_from(const plan::Lamps& lamps, const shared::Lamp& lamp, const glm::dvec3& at, const Sample& side) {
  const glm::dvec3 way = at - side.point;
  const double d = glm::length(way), facing = glm::dot(way, side.normal) / d;
  const double sent = flat(lamp) ? -glm::dot(way, xyz(lamp.axis)) / d : shines(lamps, lamp, -way / d);
  return facing > 0 && sent > 0 ? static_cast<double>(lamp.position.w) * sent * facing / (d * d) : 0;
}

/// A point of a lamp, v and w in [0, 1).
glm::dvec3 point_of(const shared::Lamp& lamp, double v, double w) {
  if (!flat(lamp)) return xyz(lamp.position);
  double a = 2 * v - 1, b = 2 * w - 1;
  if (lamp.shape == RC_LAMP_DISC)
    a = std::sqrt(v) * std::cos(2 * std::numbers::pi * w), b = std::sqrt(v) * std::sin(2 * std::numbers::pi * w);
  return xyz(lamp.position) + a * xyz(lamp.across) + b * xyz(lamp.along);
}

/// By how much roundings may put off the irradiance by a point of a lamp, W m-2, with shapes times pi f.
double slack_of(const ReferenceScene& scene, const plan::Lamps& lamps, const shared::Lamp& lamp, const glm::dvec3& at,
                const Sample& side) {
  const glm::dvec3 way = at - side.point;
  const double d = std::max(glm::length(way), 1e-9);
  const double size_m = glm::length(side.point) + glm::length(side.point - start_of(side.ray)) + glm::length(at);
  const double places = kPlaceUlp * kUlp * size_m / d, shone = flat(lamp) ? 1 : shines(lamps, lamp, -way / d);
  return static_cast<double>(lamp.position.w) / (d * d) *
         (shone * (kOwnRounding + 4 * places) +
          2 * rounding_of(lamps, lamp, -way / d, rounded_angle(lamp, -way / d, places))) *
         std::max(1.0, spread(scene.compiled, side, way / d));
}

double limit_of(const shared::Lamp& lamp, const glm::dvec3& way) {
  return 1 - static_cast<double>(lamp.clear) / glm::length(way);
}

}  // namespace

LampDraws lamp_draws(const ReferenceScene& scene, const plan::Plan& plan, std::uint64_t seed, std::uint32_t pixel,
                     std::uint32_t number, std::uint32_t source, const Sample& side) {
  const std::size_t first = plan.lamps.first[source], end = plan.lamps.first[source + 1];
  float u = 0, v = 0, w = 0;
  rc_lamp_draws(plan.sky.hash_seed(seed), pixel, source, side.rays, number, &u, &v, &w);
  LampDraws out;
  double all = 0;
  std::vector<double> upto;  // of the lamps' chances
  for (std::size_t i = first; i < end; ++i) {
    const shared::Lamp& lamp = plan.lamps.lamp[i];
    out.bound += slack_of(scene, plan.lamps, lamp, xyz(lamp.position), side);
    upto.push_back(all += chance_of(plan.lamps, lamp, side));
  }
  if (!(all > 0)) return out;
  const double wanted = static_cast<double>(u) * all, unsure = kLampEdge * all + out.bound;
  const auto take = [&](std::size_t i) {
    const shared::Lamp& lamp = plan.lamps.lamp[first + i];
    const double chance = upto[i] - (i > 0 ? upto[i - 1] : 0);
    if (!(chance > 0)) return;
    DrawnLamp& drawn = out.lamps.emplace_back();
    drawn.at = point_of(lamp, static_cast<double>(v), static_cast<double>(w));
    const glm::dvec3 way = drawn.at - side.point;
    drawn.direction = glm::normalize(way), drawn.limit = limit_of(lamp, way);
    drawn.irradiance = all / chance * irradiance_from(plan.lamps, lamp, drawn.at, side);
    drawn.open = drawn.irradiance > 0 && scene.sees(side, way, drawn.limit);
    out.bound += all / chance * slack_of(scene, plan.lamps, lamp, drawn.at, side);
  };
  const auto at = static_cast<std::size_t>(std::upper_bound(upto.begin(), upto.end(), wanted) - upto.begin());
  take(at);
  for (std::size_t i = 0; i < upto.size(); ++i)
    if (i != at && upto[i] > wanted - unsure && (i > 0 ? upto[i - 1] : 0) < wanted + unsure) take(i);
  return out;
}

std::vector<LampLight> some_lamplight(const ReferenceScene& scene, const plan::Plan& plan, const Sample& side, double v,
                                      double w) {
  std::vector<LampLight> out;
  for (const shared::Lamp& lamp : plan.lamps.lamp) {
    const glm::dvec3 at = point_of(lamp, v, w), way = at - side.point;
    const double irradiance = irradiance_from(plan.lamps, lamp, at, side);
    if (irradiance > 0 && scene.sees(side, way, limit_of(lamp, way)))
      out.push_back({lamp.source, irradiance, glm::normalize(way)});
  }
  return out;
}

std::vector<double> all_lamplight(const ReferenceScene& scene, const plan::Plan& plan, const Sample& side) {
  std::vector<double> out(static_cast<std::size_t>(plan.lamps.sources()), 0.0);
  for (const shared::Lamp& lamp : plan.lamps.lamp) {
    const int along = flat(lamp) ? kPointsAlong : 1;
    for (int i = 0; i < along * along; ++i) {
      const glm::dvec3 at = point_of(lamp, (i % along + 0.5) / along, (i / along + 0.5) / along), way = at - side.point;
      const double irradiance = irradiance_from(plan.lamps, lamp, at, side);
      if (!(irradiance > 0) || !scene.sees(side, way, limit_of(lamp, way))) continue;
      out[lamp.source] += irradiance * spread(scene.compiled, side, glm::normalize(way)) / (along * along);
    }
  }
  return out;
}

}  // namespace raycube::reference
