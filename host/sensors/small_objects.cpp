#include "host/sensors/small_objects.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vec2.hpp>
#include <limits>
#include <unordered_map>

#include "host/sensors/group_finder.h"
#include "host/sensors/ray_groups.h"

namespace raycube::sensors {

namespace {

using glm::dvec2;
using glm::dvec3;

constexpr double kFootprintMargin = 1.5;  ///< on the widest pixel found at a few lines, for the lines between
constexpr double kEdge_px = 1e-3;         ///< an object this near a pixel belongs to it: rounding of rays and boxes
constexpr double kBoxFill = 0.785398163397448;  ///< pi / 4: of a projected box that what it holds fills
constexpr int kMotionRounds = 4;  ///< of the distance of a point, which tells how far a moving origin reaches
/// A last round that moves the distance by more, of it, has found no place: GroupFinder counts on that.
constexpr double kUnsettled = 0.25;

dvec3 exact_place(const shared::rc_float4& v) { return {v.x, v.y, v.z}; }

/// Places of points in a group's image plane: (a, b) of RayGroup, pixels about the group's centre.
class GroupPlane {
 public:
  explicit GroupPlane(const shared::RayGroup& g)
      : d_(exact_place(g.d0)),
        du_(exact_place(g.du)),
        dv_(exact_place(g.dv)),
        ov_(exact_place(g.ov)),
        sensor_(exact_place(g.origin) - double{g.d0.w} * exact_place(g.d0)),
        moves_(ov_ != dvec3{0}),
        inverse_(moves_ ? glm::dmat3(1) : glm::inverse(glm::dmat3(d_, du_, dv_))) {}

  /// False behind the sensor, and where a moving one's place is not to be found.
  bool project(const dvec3& point, dvec2& at) const {
    const dvec3 way = point - sensor_;
    dvec3 x = inverse_ * way;  // (T, T a, T b)
    if (moves_) x = dvec3{glm::dot(way, d_) / glm::dot(d_, d_), 0, 0};
    double before = x.x;
    for (int round = 0; moves_ && x.x > 0 && round < kMotionRounds; ++round) {
      before = x.x;
      x = glm::inverse(glm::dmat3(d_, du_, dv_ + ov_ / before)) * way;
    }
    if (!(x.x > 0) || !(std::abs(x.x - before) <= kUnsettled * before)) return false;
    at = {x.y / x.x, x.z / x.x};
    return std::isfinite(at.x) && std::isfinite(at.y);
  }

  /// Where the ray of (a, b) meets a height; the sensor's own place where that lies above it.
  dvec2 meets(double a, double b, double z_m) const {
    const dvec3 o = sensor_ + b * ov_, d = d_ + a * du_ + b * dv_;
    const double t = d.z < 0 ? std::max(0.0, (z_m - o.z) / d.z) : 0.0;
    return {o.x + t * d.x, o.y + t * d.y};
  }

  /// Largest side of a pixel seen end on at a height, m.
  double pixel_m(double z_m) const {
    const double t = d_.z < 0 ? std::max(0.0, (z_m - sensor_.z) / d_.z) : 0.0;
    return std::max({t * glm::length(du_), t * glm::length(dv_) + glm::length(ov_)});
  }

 private:
  dvec3 d_, du_, dv_, ov_, sensor_;
  bool moves_;
  glm::dmat3 inverse_;
};

double cross(const dvec2& a, const dvec2& b) { return a.x * b.y - a.y * b.x; }

/// Area of the convex hull of a few points.
double hull_area(std::vector<dvec2> points) {
  std::sort(points.begin(), points.end(),
            [](const dvec2& a, const dvec2& b) { return a.x != b.x ? a.x < b.x : a.y < b.y; });
  std::vector<dvec2> hull;
  for (int side = 0; side < 2; ++side) {
    const std::size_t first = hull.size();
    for (const dvec2& p : points) {
      while (hull.size() >= first + 2 && cross(hull.back() - hull[hull.size() - 2], p - hull.back()) <= 0)
        hull.pop_back();
      hull.push_back(p);
    }
    hull.pop_back();
    std::reverse(points.begin(), points.end());
  }
  double twice = 0;
  for (std::size_t i = 0; i < hull.size(); ++i) twice += cross(hull[i], hull[(i + 1) % hull.size()]);
  return 0.5 * std::abs(twice);
}

bool is_small(const dvec2& lo, const dvec2& hi, const std::array<int, 2>& cells) {
  return hi.x - lo.x <= kWidest_px * cells[0] && hi.y - lo.y <= kWidest_px * cells[1];
}

/// Length of [lo, hi] that lies in [from, to], as a share of it; a length of nothing lies in it whole.
double share_inside(double lo, double hi, double from, double to) {
  if (hi <= lo) return lo >= from && lo <= to ? 1 : 0;
  return std::max(0.0, std::min(hi, to) - std::max(lo, from)) / (hi - lo);
}

}  // namespace

int finest_level(const scene::Instrument& instrument) {
  constexpr std::size_t levels = std::size(kFineLevels);
  return kFineLevels[instrument.psf_support_px > 1 ? levels - 1 : levels - 2];
}

scene::Instrument with_fine_samples(const scene::Instrument& instrument, int samples) {
  scene::Instrument fine = instrument;
  fine.first_samples = 0;
  fine.small_objects = scene::SmallObjects::off;
  const bool box = instrument.box_pixels();
  const int side = static_cast<int>(std::lround(std::sqrt(samples)));
  fine.sampler = box ? scene::SamplerKind::lattice : scene::SamplerKind::jittered;
  fine.samples_u = box ? samples : side, fine.samples_v = box ? 1 : side, fine.replicates = 1;
  return fine;
}

struct SmallObjectPixels::State {
  State(KnownObjects& known, const scene::Instrument& given) : scene(known.scene()), instrument(given) {
    instrument.motion = pose_moves(given) ? scene::PoseMotion::moving : scene::PoseMotion::held;
    half_px = 0.5 * std::max(1.0, instrument.psf_support_px);
    area = 4 * half_px * half_px;
    of_pixel = instrument.cells_of_pixel;
    window_px = {std::max(half_px, 0.5 * of_pixel[0]), std::max(half_px, 0.5 * of_pixel[1])};
    if (scene.instances.empty()) return;
    const double widest = kWidest_px * widest_pixel_m() * widest_cells();
    known_objects = known.small(widest);
    cell_m = std::max(widest, 1e-3);
    for (std::uint32_t i = 0; i < objects().size(); ++i) file(i);
  }

  /// Widest pixel at a few places of the image, seen from where it lies lowest.
  double widest_pixel_m() const {
    double widest = 0;
    const int per_line = groups_per_line(instrument);
    for (const int line : {0, instrument.lines / 2, instrument.lines - 1}) {
      const auto groups = make_ray_groups(instrument, scene, line, 1);
      for (const int group : {0, per_line / 2, per_line - 1})
        widest = std::max(widest, GroupPlane(groups[static_cast<std::size_t>(group)]).pixel_m(scene.lo[2]));
    }
    return kFootprintMargin * widest;
  }

  double cell_count() const { return static_cast<double>(of_pixel[0]) * of_pixel[1]; }
  /// Times more points where an object's lie in several cells, m: errors of k / m points in each add up to m^1/4 times
  /// that of k points in one, and points are worth the power 3/4 of their number.
  double for_cells(double share) const {
    const double across = 1 + std::sqrt(share * cell_count());
    return cell_count() > 1 ? std::cbrt(across * across) : 1;
  }
  int widest_cells() const { return std::max(of_pixel[0], of_pixel[1]); }

  std::uint64_t cell(std::int64_t x, std::int64_t y) const {
    return static_cast<std::uint64_t>(x) * 0x9e3779b97f4a7c15ull ^
           static_cast<std::uint64_t>(y) * 0xc2b2ae3d27d4eb4full;
  }
  std::int64_t cell_of(double at_m) const { return static_cast<std::int64_t>(std::floor(at_m / cell_m)); }

  void file(std::uint32_t i) {
    const SceneObject& object = objects()[i];
    low_m = std::min(low_m, object.lo_m.z), high_m = std::max(high_m, object.hi_m.z);
    for (std::int64_t y = cell_of(object.lo_m.y); y <= cell_of(object.hi_m.y); ++y)
      for (std::int64_t x = cell_of(object.lo_m.x); x <= cell_of(object.hi_m.x); ++x) cells[cell(x, y)].push_back(i);
  }

  /// Objects whose boxes may project into the group, ascending.
  std::vector<std::uint32_t> near(const GroupPlane& plane, int used) const {
    const double half_line = 0.5 * (pixels_per_group(instrument) - 1);
    const double from = -half_line - window_px.x, to = -half_line + used - 1 + window_px.x;
    dvec2 lo{std::numeric_limits<double>::infinity()}, hi{-lo};
    for (const double a : {from, to})
      for (const double b : {-window_px.y, window_px.y})
        for (const double z : {low_m, high_m}) {
          const dvec2 at = plane.meets(a, b, z);
          lo = {std::min(lo.x, at.x), std::min(lo.y, at.y)}, hi = {std::max(hi.x, at.x), std::max(hi.y, at.y)};
        }
    std::vector<std::uint32_t> found;
    const double cells_across = ((hi.x - lo.x) / cell_m + 1) * ((hi.y - lo.y) / cell_m + 1);
    if (cells_across > static_cast<double>(cells.size())) {  // a view along the ground: every object's turn
      for (std::uint32_t i = 0; i < objects().size(); ++i) found.push_back(i);
      return found;
    }
    for (std::int64_t y = cell_of(lo.y); y <= cell_of(hi.y); ++y)
      for (std::int64_t x = cell_of(lo.x); x <= cell_of(hi.x); ++x)
        if (const auto at = cells.find(cell(x, y)); at != cells.end())
          found.insert(found.end(), at->second.begin(), at->second.end());
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    return found;
  }

  /// Area of an object's outline over a pixel's: of its triangles, or of its box where they are many; never
  /// more than the box's.
  double share_of(const SceneObject& object, const GroupPlane& plane, const std::vector<dvec2>& corners) const {
    const double box = hull_area(corners);
    if (object.triangles.empty()) return kBoxFill * box;
    double sum = 0;
    dvec3 open{0};
    double surface = 0;
    for (const std::uint32_t primitive : object.triangles) {
      const auto p = triangle_of(scene, object.placement.instance, primitive);
      dvec2 at[3];
      for (int i = 0; i < 3; ++i)
        if (!plane.project(p[static_cast<std::size_t>(i)], at[i])) return box;
      sum += 0.5 * std::abs(cross(at[1] - at[0], at[2] - at[0]));
      const dvec3 normal = glm::cross(p[1] - p[0], p[2] - p[0]);
      open += normal, surface += glm::length(normal);
    }
    const bool closed = glm::length(open) < 1e-4 * surface;  // the areas of a closed surface add up to nothing
    return std::min(box, closed ? 0.5 * sum : sum);
  }

  const std::vector<SceneObject>& objects() const { return known_objects->objects; }

  const scene::CompiledScene& scene;
  scene::Instrument instrument;       ///< with automatic motion settled
  double half_px = 0.5, area = 1;     ///< of the square that the samples cover, pixels
  std::array<int, 2> of_pixel{1, 1};  ///< cells
  dvec2 window_px{0.5, 0.5};          ///< half of what an object's share is of
  std::shared_ptr<const SceneObjects> known_objects = std::make_shared<const SceneObjects>();
  double cell_m = 1, low_m = std::numeric_limits<double>::infinity(), high_m = -std::numeric_limits<double>::infinity();
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> cells;
};

SmallObjectPixels::SmallObjectPixels(const scene::CompiledScene& scene, const scene::Instrument& instrument) {
  KnownObjects known(scene);
  state_ = std::make_unique<State>(known, instrument);
}
SmallObjectPixels::SmallObjectPixels(KnownObjects& known, const scene::Instrument& instrument)
    : state_(std::make_unique<State>(known, instrument)) {}
SmallObjectPixels::~SmallObjectPixels() = default;
SmallObjectPixels::SmallObjectPixels(SmallObjectPixels&&) noexcept = default;

std::string SmallObjectPixels::name(std::uint32_t object) const {
  return object_name(state_->scene, state_->objects()[object]);
}

void SmallObjectPixels::set_samples(const scene::Instrument& instrument) {
  scene::Instrument& own = state_->instrument;
  own.sampler = instrument.sampler;
  own.samples_u = instrument.samples_u, own.samples_v = instrument.samples_v;
  own.replicates = instrument.replicates;
  own.first_samples = instrument.first_samples;
}

bool SmallObjectPixels::empty() const { return state_->objects().empty(); }
const SceneObjects& SmallObjectPixels::objects() const { return *state_->known_objects; }

std::vector<ObjectInPixel> SmallObjectPixels::in_group(const shared::RayGroup& group, int used) const {
  const State& s = *state_;
  std::vector<ObjectInPixel> seen;
  if (empty()) return seen;
  const GroupPlane plane(group);
  const double half_line = 0.5 * (pixels_per_group(s.instrument) - 1);
  for (const std::uint32_t i : s.near(plane, used)) {
    const SceneObject& object = s.objects()[i];
    std::vector<dvec2> corners(8);
    dvec2 lo{std::numeric_limits<double>::infinity()}, hi{-lo};
    bool ahead = true;
    for (std::size_t c = 0; ahead && c < 8; ++c) {
      ahead = plane.project(object.corners_m[c], corners[c]);
      lo = {std::min(lo.x, corners[c].x), std::min(lo.y, corners[c].y)},
      hi = {std::max(hi.x, corners[c].x), std::max(hi.y, corners[c].y)};
    }
    if (!ahead || !is_small(lo, hi, s.of_pixel)) continue;
    const auto beyond = [&](double centre, const dvec2& half) {
      return hi.y < -half.y - kEdge_px || lo.y > half.y + kEdge_px || hi.x < centre - half.x - kEdge_px ||
             lo.x > centre + half.x + kEdge_px;
    };
    double share = -1;
    for (int lane = 0; lane < used; ++lane) {
      const double centre = lane - half_line;
      if (beyond(centre, s.window_px)) continue;
      if (share < 0) share = s.share_of(object, plane, corners) / s.cell_count();
      const double part = share_inside(lo.x, hi.x, centre - s.window_px.x, centre + s.window_px.x) *
                          share_inside(lo.y, hi.y, -s.window_px.y, s.window_px.y);
      if (share > 0) seen.push_back({i, lane, share, part, !beyond(centre, dvec2(s.half_px))});
    }
  }
  return seen;
}

void SmallObjectPixels::visit_groups(const LookAtGroup& look) const {
  const State& s = *state_;
  if (empty()) return;
  const bool moving = s.instrument.motion == scene::PoseMotion::moving;
  GroupFinder(s.instrument, s.half_px + kEdge_px, kWidest_px * s.widest_cells())
      .visit(s.objects(), [&](int line, int group) {
        look(line, group, make_ray_group(s.instrument, s.scene, line, group, moving));
      });
}

std::vector<double> SmallObjectPixels::covers(std::span<const ObjectInPixel> seen) const {
  const State& s = *state_;
  struct Cover {
    double largest = 0, sum = 0;
    double share() const { return std::min(1.0, std::max(largest, sum)); }
  };
  std::map<std::pair<int, std::uint64_t>, Cover> of_kind;
  const auto kind = [&](const ObjectInPixel& one) { return std::pair{one.lane, s.objects()[one.object].kind}; };
  for (const ObjectInPixel& one : seen) {
    Cover& cover = of_kind[kind(one)];
    cover.largest = std::max(cover.largest, one.share), cover.sum += one.share * one.part;
  }
  std::vector<double> out;
  for (const ObjectInPixel& one : seen) out.push_back(of_kind[kind(one)].share());
  return out;
}

double SmallObjectPixels::needed(std::span<const ObjectInPixel> seen) const {
  const State& s = *state_;
  const double finest = finest_level(s.instrument) * s.cell_count();
  double needed = 0;
  const std::vector<double> covers = this->covers(seen);
  for (std::size_t i = 0; i < seen.size(); ++i)
    if (seen[i].touches && finest * covers[i] >= s.area)  // else not even the most would find it
      needed = std::max(needed, s.area * kPoints * s.for_cells(covers[i]) * (1 - covers[i]) / covers[i]);
  return needed / s.cell_count();
}

int SmallObjectPixels::samples_of(std::span<const ObjectInPixel> seen) const {
  const State& s = *state_;
  const int ordinary = s.instrument.all_samples(), finest = finest_level(s.instrument);
  const double needed = this->needed(seen);
  if (needed <= ordinary) return 0;
  const auto* const level =
      std::find_if(std::begin(kFineLevels), std::end(kFineLevels), [&](int n) { return n >= needed || n == finest; });
  return *level > ordinary ? *level : 0;
}

int SmallObjectPixels::samples_of(const shared::RayGroup& group, int used) const {
  return samples_of(in_group(group, used));
}

bool SmallObjectPixels::needs_all(std::span<const ObjectInPixel> seen) const {
  return state_->instrument.adaptive() && needed(seen) > state_->instrument.first_samples;
}

bool SmallObjectPixels::needs_all(const shared::RayGroup& group, int used) const {
  return needs_all(in_group(group, used));
}

SmallObjectSurvey survey_small_objects(const scene::CompiledScene& scene, const scene::Instrument& instrument,
                                       bool on) {
  return survey_small_objects(SmallObjectPixels(scene, instrument), instrument, on);
}

SmallObjectSurvey survey_small_objects(SmallObjectPixels small, const scene::Instrument& instrument, bool on) {
  small.set_samples(instrument);
  SmallObjectSurvey survey;
  survey.on = on;
  survey.textures = small.objects().textures;
  if (small.empty()) return survey;
  // Of adaptive samples a pixel surely has those of the first look.
  const int width = pixels_per_group(instrument), whole = instrument.all_samples(),
            ordinary = instrument.adaptive() ? instrument.first_samples : whole;
  const double cells = static_cast<double>(instrument.cells_of_pixel[0]) * instrument.cells_of_pixel[1],
               area = std::max(1.0, instrument.psf_support_px) * std::max(1.0, instrument.psf_support_px) / cells;
  std::map<std::uint32_t, SmallObjectSurvey::Object> objects;
  small.visit_groups([&](int line, int group, const shared::RayGroup& rays) {
    ++survey.looked_at;
    const int used = std::min(width, instrument.pixels - group * width);
    const auto seen = small.in_group(rays, used);
    if (std::none_of(seen.begin(), seen.end(), [](const ObjectInPixel& one) { return one.touches; })) return;
    const int fine = small.samples_of(seen);
    const int samples = on && fine > 0 ? fine : on && small.needs_all(seen) ? whole : ordinary;
    if (on && fine > 0) {
      survey.groups.push_back({line, group * width, fine});
      survey.levels[fine] += static_cast<std::uint64_t>(used), survey.pixels += static_cast<std::uint64_t>(used);
      survey.more_samples += static_cast<double>(fine) * used;
    }
    const std::vector<double> covers = small.covers(seen);
    for (std::size_t i = 0; i < seen.size(); ++i) {
      const ObjectInPixel& one = seen[i];
      if (!one.touches) continue;
      const auto [at, anew] = objects.try_emplace(one.object);
      SmallObjectSurvey::Object& object = at->second;
      const double points = samples * covers[i] / area;
      if (anew) object.line = line, object.sample = group * width + one.lane, object.points = points;
      object.points = std::min(object.points, points);
      object.share = std::max(object.share, one.share);
      ++object.pixels;
    }
  });
  survey.objects = objects.size();
  for (auto& [index, object] : objects) {
    survey.scarce += ordinary * object.share / area < kPoints * (1 - std::min(1.0, object.share));
    if (object.points >= kFewestPoints * (1 - std::min(1.0, object.share))) continue;
    const SceneObject& what = small.objects().objects[index];
    object.name = small.name(index);
    const dvec3 size = what.hi_m - what.lo_m;
    object.size_m = {size.x, size.y, size.z};
    survey.missed.push_back(std::move(object));
  }
  std::stable_sort(survey.missed.begin(), survey.missed.end(),
                   [](const auto& a, const auto& b) { return a.points < b.points; });
  return survey;
}

}  // namespace raycube::sensors
