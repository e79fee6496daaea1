#include "host/sensors/group_finder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <utility>

#include "host/base/interrupt.h"
#include "host/base/units.h"
#include "host/sensors/ray_groups.h"

namespace raycube::sensors {

namespace {

using glm::dvec3;

constexpr std::size_t kRun = 16;  ///< leaves of a run; bounds of single leaves are made when they are asked for
constexpr std::size_t kLeavesPerLook = 4096;  ///< between two looks for a signal
/// Rays are rounded to floats (2^-24 of the origin and, at the distance of a point, of the way there): this
/// times either is 16 times that and more.
constexpr double kRounding = 1e-6;
constexpr double kMostStretch = 0.5;  ///< of a distance, by the motion while a line is exposed

dvec3 exact(const shared::rc_float4& v) { return {v.x, v.y, v.z}; }

double largest(const dvec3& v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); }

bool finite(const dvec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

}  // namespace

/// A box may lie in front of and inside the rays where all five functions can be positive.
struct GroupFinder::Test {
  Box origin_m;
  std::array<Box, 5> inside;
  bool wild = false;

  bool passes(const Box& box) const {
    if (wild) return true;
    const Box w = away(box, origin_m);
    return std::all_of(inside.begin(), inside.end(), [&](const Box& n) { return !(upper(n, w) < 0); });
  }
};

/// Where a box lies as seen from the origins, with the rounding of the rays.
GroupFinder::Box GroupFinder::away(const Box& box, const Box& origin_m) {
  const Box w{box.lo - origin_m.hi, box.hi - origin_m.lo};
  const dvec3 error_m(kRounding *
                      (std::max(largest(origin_m.lo), largest(origin_m.hi)) + std::max(largest(w.lo), largest(w.hi))));
  return {w.lo - error_m, w.hi + error_m};
}

/// The largest dot product of a vector of each.
double GroupFinder::upper(const Box& n, const Box& w) {
  double out = 0;
  for (int c = 0; c < 3; ++c)
    out += std::max({n.lo[c] * w.lo[c], n.lo[c] * w.hi[c], n.hi[c] * w.lo[c], n.hi[c] * w.hi[c]});
  return out;
}

/// x + times y.
GroupFinder::Box GroupFinder::sum(const Box& x, const Box& y, double times) {
  const dvec3 lo = times * (times < 0 ? y.hi : y.lo), hi = times * (times < 0 ? y.lo : y.hi);
  return {x.lo + lo, x.hi + hi};
}

/// Of the rays between two places along the line, i in pixels from its middle.
GroupFinder::Test GroupFinder::test(const Rays& rays, double first_px, double last_px) {
  Test out;
  out.origin_m = rays.origin_m, out.wild = rays.wild;
  const Box negative_u{-rays.u.hi, -rays.u.lo}, negative_v{-rays.v.hi, -rays.v.lo};
  // U.w = T (i + what b adds), and A.w is T but for the stretch.
  const double first = first_px - rays.beside_px, last = last_px + rays.beside_px;
  const double least = first / (first < 0 ? 1 - rays.stretch : 1 + rays.stretch),
               most = last / (last < 0 ? 1 + rays.stretch : 1 - rays.stretch);
  out.inside = {rays.a, sum(rays.u, rays.a, -least), sum(negative_u, rays.a, most), sum(rays.v, rays.a, rays.reach_b),
                sum(negative_v, rays.a, rays.reach_b)};
  return out;
}

GroupFinder::Rays GroupFinder::both(const Rays& x, const Rays& y) {
  const auto hull = [](const Box& p, const Box& q) { return Box{glm::min(p.lo, q.lo), glm::max(p.hi, q.hi)}; };
  return {hull(x.origin_m, y.origin_m),
          hull(x.a, y.a),
          hull(x.u, y.u),
          hull(x.v, y.v),
          std::max(x.reach_b, y.reach_b),
          std::max(x.beside_px, y.beside_px),
          std::max(x.stretch, y.stretch),
          x.wild || y.wild};
}

GroupFinder::GroupFinder(const scene::Instrument& settled, double reach_px, double widest_px)
    : instrument_(settled),
      reach_px_(reach_px),
      // All of a box's corners lie so near a line that it reaches; 1.25: a distance may be so far from
      // settled (SmallObjectPixels' kUnsettled).
      reach_moving_px_(1.25 * (reach_px + widest_px)),
      moving_(pose_moves(settled)),
      scanner_(settled.kind != scene::InstrumentKind::framing),
      width_(pixels_per_group(settled)),
      per_line_(groups_per_line(settled)),
      per_leaf_(settled.kind == scene::InstrumentKind::whiskbroom ? 1 : per_line_),
      leaves_(static_cast<std::size_t>(settled.lines) * static_cast<std::size_t>(per_line_ / per_leaf_)),
      top_level_(0) {
  while ((kRun << top_level_) < leaves_) ++top_level_;
  if (scanner_) build();
}

GroupFinder::Rays GroupFinder::leaf(std::size_t index) const {
  const std::size_t of_line = static_cast<std::size_t>(per_line_ / per_leaf_);
  const int line = static_cast<int>(index / of_line), group = static_cast<int>(index % of_line) * per_leaf_;
  const shared::RayGroup first = make_ray_group(instrument_, line, group, moving_),
                         last =
                             per_leaf_ > 1 ? make_ray_group(instrument_, line, group + per_leaf_ - 1, moving_) : first;
  const dvec3 d = 0.5 * (exact(first.d0) + exact(last.d0)), dv_first = exact(first.dv), dv_last = exact(last.dv);
  const dvec3 du =
      per_leaf_ > 1 ? (exact(last.d0) - exact(first.d0)) / (double(per_leaf_ - 1) * double(width_)) : exact(first.du);
  const dvec3 normal = glm::cross(d, du);
  const dvec3 third = moving_ ? normal * (glm::length(du) / glm::length(normal)) : dv_first;
  const glm::dmat3 inverse = glm::inverse(glm::dmat3(d, du, third));
  const auto row = [&](int r) { return dvec3(inverse[0][r], inverse[1][r], inverse[2][r]); };
  const dvec3 a = row(0), u = row(1), v = row(2), origin_m = exact(first.origin);
  Rays out{{origin_m, origin_m}, {a, a}, {u, u}, {v, v}, reach_px_, 0, 0, false};
  if (moving_) {
    const auto most = [&](const dvec3& n) {
      return reach_moving_px_ * std::max(std::abs(glm::dot(n, dv_first)), std::abs(glm::dot(n, dv_last)));
    };
    const dvec3 way_m = reach_moving_px_ * glm::abs(exact(first.ov));
    out.origin_m = {origin_m - way_m, origin_m + way_m};
    out.stretch = most(a), out.beside_px = most(u);
    out.reach_b = most(v) / (1 - std::min(out.stretch, kMostStretch));
  }
  out.wild = !(finite(a) && finite(u) && finite(v) && finite(origin_m) && std::isfinite(out.beside_px) &&
               std::isfinite(out.reach_b) && out.stretch <= kMostStretch);
  return out;
}

/// Of a whisk-broom's pixels the mirror and the pose turn d, du and dv as one, and with them the rows: by no
/// more than the sum of the angles, and a vector by no more than that times its length. So one pixel's rows
/// and the poses bound those of the pixels about it.
GroupFinder::Rays GroupFinder::turned(std::size_t first, std::size_t end) const {
  const std::size_t middle = (first + end) / 2;
  const scene::Pose& about = instrument_.poses[middle];
  const auto pixels = static_cast<std::size_t>(per_line_);
  Rays out = leaf(middle);
  double turn_rad = 0;
  for (std::size_t i = first; i < end; ++i) {
    const scene::Pose& pose = instrument_.poses[i];
    const double steps = std::abs(double(i % pixels) - double(middle % pixels));
    turn_rad = std::max(turn_rad, base::rad_from_deg(std::abs(pose.roll_deg - about.roll_deg) +
                                                     std::abs(pose.pitch_deg - about.pitch_deg) +
                                                     std::abs(pose.heading_deg - about.heading_deg)) +
                                      steps * instrument_.ifov_across_rad);
    const dvec3 origin_m(pose.x_m, pose.y_m, pose.z_m);
    out.origin_m = {glm::min(out.origin_m.lo, origin_m), glm::max(out.origin_m.hi, origin_m)};
  }
  for (Box* row : {&out.a, &out.u, &out.v}) {
    const dvec3 reach(turn_rad * glm::length(row->lo));
    *row = {row->lo - reach, row->hi + reach};
  }
  return out;
}

GroupFinder::Rays GroupFinder::run(std::size_t first, std::size_t end) const {
  if (instrument_.kind == scene::InstrumentKind::whiskbroom) return turned(first, end);
  Rays out = leaf(first);
  for (std::size_t i = first + 1; i < end; ++i) out = both(out, leaf(i));
  return out;
}

/// Poses of a scanner may be anything, so that its spans are bounded from each of them.
void GroupFinder::build() {
  std::vector<Rays>& runs = levels_.emplace_back();
  runs.reserve((leaves_ + kRun - 1) / kRun);
  for (std::size_t first = 0; first < leaves_; first += kRun) {
    if (first % kLeavesPerLook == 0) base::throw_if_interrupted();
    runs.push_back(run(first, std::min(first + kRun, leaves_)));
  }
  for (std::size_t level = 0; level < top_level_; ++level) {
    const std::vector<Rays>& below = levels_[level];
    std::vector<Rays> here;
    here.reserve((below.size() + 1) / 2);
    for (std::size_t i = 0; i < below.size(); i += 2)
      here.push_back(i + 1 < below.size() ? both(below[i], below[i + 1]) : below[i]);
    levels_.push_back(std::move(here));
  }
}

GroupFinder::Rays GroupFinder::bounds(std::size_t level, std::size_t index) const {
  if (scanner_) return levels_[level][index];
  const std::size_t first = index * (kRun << level), end = std::min(first + (kRun << level), leaves_);
  return both(leaf(first), leaf(end - 1));
}

void GroupFinder::visit(std::span<const SceneObject> objects, const Look& look) const {
  base::throw_if_interrupted();
  std::vector<std::uint32_t> all(objects.size());
  for (std::uint32_t i = 0; i < all.size(); ++i) all[i] = i;
  descend(top_level_, 0, objects, all, look);
}

void GroupFinder::descend(std::size_t level, std::size_t index, std::span<const SceneObject> objects,
                          const std::vector<std::uint32_t>& from_above, const Look& look) const {
  const double half_px = 0.5 * per_leaf_ * width_ - 0.5 + reach_px_;
  const Test inside = test(bounds(level, index), -half_px, half_px);
  std::vector<std::uint32_t> here;
  for (const std::uint32_t i : from_above)
    if (inside.passes({objects[i].lo_m, objects[i].hi_m})) here.push_back(i);
  if (here.empty()) return;
  if (level == 0) {
    for (std::size_t i = index * kRun; i < std::min((index + 1) * kRun, leaves_); ++i) look_at(i, objects, here, look);
    return;
  }
  for (const std::size_t half : {2 * index, 2 * index + 1})
    if (half * (kRun << (level - 1)) < leaves_) descend(level - 1, half, objects, here, look);
}

/// Along a line the corners of a box tell their places themselves.
void GroupFinder::look_at(std::size_t index, std::span<const SceneObject> objects,
                          const std::vector<std::uint32_t>& of_run, const Look& look) const {
  base::throw_if_interrupted();
  const Rays rays = leaf(index);
  const double middle = 0.5 * (per_leaf_ - 1), reach_px = 0.5 * width_ - 0.5 + reach_px_;
  const Test inside = test(rays, -middle * width_ - reach_px, middle * width_ + reach_px);
  std::vector<std::pair<int, int>> runs;  // of groups
  for (const std::uint32_t i : of_run) {
    if (!inside.passes({objects[i].lo_m, objects[i].hi_m})) continue;
    double lo = std::numeric_limits<double>::infinity(), hi = -lo;
    for (const dvec3& corner : objects[i].corners_m) {
      const Box w = away({corner, corner}, rays.origin_m), minus{-w.hi, -w.lo};
      const double t_least = -upper(rays.a, minus), t_most = upper(rays.a, w);
      if (rays.wild || !(t_least > 0)) {
        lo = -std::numeric_limits<double>::infinity(), hi = -lo;
        break;
      }
      const double left = -upper(rays.u, minus), right = upper(rays.u, w);
      const double least = left / (left < 0 ? t_least : t_most), most = right / (right < 0 ? t_most : t_least);
      lo = std::min(lo, least * (least < 0 ? 1 + rays.stretch : 1 - rays.stretch) - rays.beside_px);
      hi = std::max(hi, most * (most < 0 ? 1 - rays.stretch : 1 + rays.stretch) + rays.beside_px);
    }
    const double first = std::ceil((lo - reach_px) / width_ + middle),
                 last = std::floor((hi + reach_px) / width_ + middle);
    if (!(first < per_leaf_ && last >= 0 && first <= last)) continue;
    runs.emplace_back(static_cast<int>(std::max(first, 0.0)), static_cast<int>(std::min(last, per_leaf_ - 1.0)));
  }
  std::sort(runs.begin(), runs.end());
  const std::size_t of_line = static_cast<std::size_t>(per_line_ / per_leaf_);
  const int line = static_cast<int>(index / of_line), from = static_cast<int>(index % of_line) * per_leaf_;
  int next = 0;
  for (const auto& [first, last] : runs)
    for (next = std::max(next, first); next <= last; ++next) look(line, from + next);
}

}  // namespace raycube::sensors
