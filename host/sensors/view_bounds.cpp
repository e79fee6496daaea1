#include "host/sensors/view_bounds.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <utility>
#include <vector>

#include "host/base/error.h"
#include "host/base/interrupt.h"
#include "host/sensors/ray_groups.h"

namespace raycube::sensors {
namespace {

using Vec = glm::dvec3;

Vec exact_vector(const shared::rc_float4& v) { return {v.x, v.y, v.z}; }

// A component of a unit vector along a straight line of the image plane is a sine of the angle. Rounding to
// floats moves it by less than 4e-7 of its size, so further than sqrt(2 x 4e-7) = 9e-4 rad from its highest
// place no pixel can be higher, and as far from an end only the end itself. Twice that and some pixels:
constexpr double kFlat_rad = 2e-3, kFloatStep = 4e-7;
constexpr int kFlat_px = 16;
/// Of a longer run so many are looked at. Runs are flat, below 0.2 rad all together: from one to the next the view
/// turns by h = 1e-4 rad at most, and no place between them is higher by more than h^2 / 8, which is below rounding.
constexpr int kMostOfRun = 2048;

/// First and last of a run of places along a line or down the image, and how far apart those are that are looked at.
struct Run {
  int first = 0, last = 0, step = 1;
};

/// Of long runs their ends whole, and some of what lies between.
std::vector<Run> thinned_out(const std::vector<Run>& runs) {
  std::vector<Run> out;
  for (const Run& run : runs) {
    const int length = run.last - run.first + 1;
    if (length <= kMostOfRun) {
      out.push_back(run);
      continue;
    }
    out.push_back({run.first, run.first + kFlat_px - 1});
    out.push_back({run.first + kFlat_px, run.last - kFlat_px, (length + kMostOfRun - 1) / kMostOfRun});
    out.push_back({run.last - kFlat_px + 1, run.last});
  }
  return out;
}

/// Runs that hold every place of 0 .. count - 1 where x, y or z of the unit vector along a + s b can be
/// extreme, whichever of the rays (a, b) it is.
std::vector<Run> extreme_runs(const std::vector<std::pair<Vec, Vec>>& rays, int count) {
  double step_rad = 1;  // the least angle from one place to the next
  for (const auto& [a, b] : rays) {
    const Vec end = a + double(count - 1) * b;
    step_rad = std::min(step_rad, glm::length(glm::cross(a, b)) / std::max(glm::dot(a, a), glm::dot(end, end)));
  }
  const double reach = step_rad > 0 ? kFlat_rad / step_rad + kFlat_px : count;
  if (3 * reach >= count) return thinned_out({{0, count - 1}});
  const int wide = static_cast<int>(std::ceil(reach));
  std::vector<Run> runs = {{0, wide}, {count - 1 - wide, count - 1}};
  for (const auto& [a, b] : rays)
    for (int c = 0; c < 3; ++c) {
      // d/ds of (a + s b)_c / |a + s b| = 0.
      const double aa = glm::dot(a, a), ab = glm::dot(a, b), bb = glm::dot(b, b);
      const double place = (a[c] * ab - b[c] * aa) / (b[c] * ab - a[c] * bb);
      if (place > -reach && place < count + reach)
        runs.push_back(
            {std::max(0, static_cast<int>(place) - wide), std::min(count - 1, static_cast<int>(place) + wide)});
    }
  std::sort(runs.begin(), runs.end(), [](const Run& x, const Run& y) { return x.first < y.first; });
  std::vector<Run> apart = {runs.front()};
  for (const Run& run : runs)
    if (run.first <= apart.back().last + 1)
      apart.back().last = std::max(apart.back().last, run.last);
    else
      apart.push_back(run);
  return thinned_out(apart);
}

class Look {
 public:
  explicit Look(const scene::Instrument& instrument)
      : instrument_(instrument),
        moving_(pose_moves(instrument)),
        half_(0.5 * std::max(1.0, instrument.psf_support_px)),
        places_{{{0, 0}, {-half_, -half_}, {-half_, half_}, {half_, -half_}, {half_, half_}}} {}

  /// Lines that can hold an extreme: all of a scanner's but those that look as the one before does; of a
  /// camera those where one of its edges, or its view straight down, has one.
  std::vector<Run> lines() const {
    const int last = instrument_.lines - 1, end = instrument_.pixels - 1;
    if (instrument_.kind != scene::InstrumentKind::framing || last == 0) return {{0, last}};
    std::vector<std::pair<Vec, Vec>> edges;
    for (const int sample : {0, end})
      for (const auto& [u, v] : places_) edges.push_back(between(ray(0, sample, u, v), ray(last, sample, u, v), last));
    // Straight down is where x and y of a + s b + l c vanish: the column through that place has the least
    // zenith angle in it.
    const Vec a = ray(0, 0, 0, 0), b = end > 0 ? (ray(0, end, 0, 0) - a) / double(end) : Vec(0),
              c = (ray(last, 0, 0, 0) - a) / double(last);
    const double determinant = b.x * c.y - c.x * b.y;
    if (determinant != 0) edges.push_back({a + b * ((c.x * a.y - a.x * c.y) / determinant), c});
    return extreme_runs(edges, instrument_.lines);
  }

  std::vector<Run> samples(int line) const {
    const int last = instrument_.pixels - 1;
    // A whiskbroom has a pose for every pixel: no line of it is straight.
    if (instrument_.kind == scene::InstrumentKind::whiskbroom || last == 0) return {{0, last}};
    std::vector<std::pair<Vec, Vec>> rays;
    for (const auto& [u, v] : places_) rays.push_back(between(ray(line, 0, u, v), ray(line, last, u, v), last));
    return extreme_runs(rays, instrument_.pixels);
  }

  /// True where this line's rays have the directions of the line before: directions depend on attitudes
  /// alone, moving ones on the neighbours' too.
  bool as_before(int line) const {
    if (instrument_.kind != scene::InstrumentKind::pushbroom || line < 3 || line + 1 >= instrument_.lines) return false;
    const auto same = [&](int one, int other) {
      const scene::Pose &p = instrument_.poses[static_cast<std::size_t>(one)],
                        &q = instrument_.poses[static_cast<std::size_t>(other)];
      return p.roll_deg == q.roll_deg && p.pitch_deg == q.pitch_deg && p.heading_deg == q.heading_deg;
    };
    return same(line - 2, line - 1) && same(line - 1, line) && same(line, line + 1);
  }

  void take(int line, const Run& run, plan::ViewBounds& bounds) const {
    const int width = pixels_per_group(instrument_);
    int made = -1;
    shared::RayGroup group{};
    for (int sample = run.first; sample <= run.last; sample += run.step) {
      if (const int index = sample / width; index != made) {
        group = make_ray_group(instrument_, line, index, moving_);
        made = index;
      }
      for (const auto& [u, v] : places_)
        take(line, sample,
             exact_vector(group.d0) + (sample % width - 0.5 * (width - 1) + u) * exact_vector(group.du) +
                 v * exact_vector(group.dv),
             bounds);
    }
  }

 private:
  Vec ray(int line, int sample, double u, double v) const {
    return pixel_ray(instrument_, line, sample, u, v).direction;
  }
  static std::pair<Vec, Vec> between(const Vec& first, const Vec& last, int steps) {
    return {first, (last - first) / double(steps)};
  }

  void take(int line, int sample, const Vec& d, plan::ViewBounds& bounds) const {
    if (!(d.z < 0))
      throw base::Error(base::Fault::input, "instrument '" + instrument_.name + "': line " + std::to_string(line) +
                                                ", sample " + std::to_string(sample) +
                                                " looks up or level (direction z " + std::to_string(d.z) +
                                                "); every ray must look down: reduce roll, pitch or the field of view");
    const Vec to_sensor = -d / glm::length(d);
    const double sec = 1.0 / to_sensor.z;
    bounds.sec_min = std::min(bounds.sec_min, sec);
    bounds.sec_max = std::max(bounds.sec_max, sec);
    bounds.x_min = std::min(bounds.x_min, to_sensor.x);
    bounds.x_max = std::max(bounds.x_max, to_sensor.x);
    bounds.y_min = std::min(bounds.y_min, to_sensor.y);
    bounds.y_max = std::max(bounds.y_max, to_sensor.y);
  }

  const scene::Instrument& instrument_;
  bool moving_;
  double half_;
  std::array<std::pair<double, double>, 5> places_;  ///< of a pixel, where its rays are looked at
};

/// Places that were not looked at may be higher by rounding.
void widen(plan::ViewBounds& bounds) {
  bounds.sec_min = std::max(1.0, bounds.sec_min * (1 - kFloatStep)), bounds.sec_max *= 1 + kFloatStep;
  bounds.x_min -= kFloatStep, bounds.x_max += kFloatStep;
  bounds.y_min -= kFloatStep, bounds.y_max += kFloatStep;
}

}  // namespace

plan::ViewBounds view_bounds(const scene::Instrument& given) {
  scene::Instrument instrument = given;  // with `automatic` motion settled once, not once per line
  instrument.motion = pose_moves(given) ? scene::PoseMotion::moving : scene::PoseMotion::held;
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  plan::ViewBounds bounds{kInfinity, -kInfinity, kInfinity, -kInfinity, kInfinity, -kInfinity, 0};
  make_ray_groups(instrument, 0, 0);  // refuses poses that do not match the image
  const Look look(instrument);
  bool not_all = false;
  for (const Run& lines : look.lines())
    for (int line = lines.first; line <= lines.last; line += lines.step) {
      base::throw_if_interrupted();
      if (look.as_before(line)) continue;
      for (const Run& run : look.samples(line)) {
        look.take(line, run, bounds);
        not_all = not_all || lines.step > 1 || run.step > 1;
      }
    }
  if (not_all) widen(bounds);
  bounds.sensor_x_min = bounds.sensor_y_min = kInfinity;
  bounds.sensor_x_max = bounds.sensor_y_max = -kInfinity;
  for (const auto& pose : instrument.poses) {
    bounds.sensor_x_min = std::min(bounds.sensor_x_min, pose.x_m),
    bounds.sensor_x_max = std::max(bounds.sensor_x_max, pose.x_m);
    bounds.sensor_y_min = std::min(bounds.sensor_y_min, pose.y_m),
    bounds.sensor_y_max = std::max(bounds.sensor_y_max, pose.y_m);
  }
  for (const auto& pose : instrument.poses)
    bounds.sensor_height_m += pose.z_m / static_cast<double>(instrument.poses.size());
  return bounds;
}

}  // namespace raycube::sensors
