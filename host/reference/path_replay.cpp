#include "host/reference/path_replay.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

#include "host/base/interrupt.h"
#include "kernels/sampling/sky_rays.h"
#include "scene_compiler/matter.h"

namespace raycube::reference {

namespace {

constexpr std::uint32_t kPathDimension = 25, kFirstWays = 0x2545f491;  ///< of rc_hash; of the seed of first directions
constexpr double kAtTheChance = 1e-6;  ///< a draw so near to a chance may fall to either side of it
constexpr float kGrazing = 1e-5f;      ///< cosine of a ray that roundings may turn into the surface
constexpr double kFrameTurns = 0.83;   ///< height of a normal where rc_about takes another frame
constexpr double kStartOffUlp = 256;   ///< off its surface, or along it, where a ray may start, in ulp of its place
constexpr double kGlossOffUlp = 64;    ///< of a mirrored way's weight, over the cosines that it divides by
constexpr double kNormalOffUlp = 16;   ///< of a triangle's normal, times how slender it is
constexpr double kLeastLight = 1e-9;   ///< of the light together: where that is darker, sources have no share of it
constexpr double kLeastLine = 1e-3;    ///< of a pixel's brightest wavelength: what is darker is held against that
constexpr double kLeastGlow = 1e-30;  ///< of the light together: nearer to the least that floats tell, they lose digits
constexpr double kOfGloss = 10;       ///< mirrored ways carry the rounding of the way to the viewer, too

glm::dvec3 start_of(const shared::PathStep& step) { return {step.start.x, step.start.y, step.start.z}; }
glm::dvec3 way_of(const shared::PathStep& step) { return {step.way.x, step.way.y, step.way.z}; }
double largest(const glm::dvec3& v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); }

/// Chance of the side that a path leaves.
double chance_of(rc_id side, double near, double gloss) {
  if (side == RC_GLOSS_SIDE) return gloss;
  return (side == RC_FAR_SIDE ? 1 - near : near) * (1 - gloss);
}

/// The side of a surface by which a path goes on; null: it has none.
const Sample* side_of(const SampledPixel& at, rc_id number) {
  const std::vector<Sample>& sides = number == RC_NEAR_SIDE  ? at.samples
                                     : number == RC_FAR_SIDE ? at.far_sides
                                                             : at.glosses;
  return sides.empty() || sides.front().hit.miss() ? nullptr : &sides.front();
}

/// The plan at the wavelengths along its paths.
plan::Plan at_lines(const plan::Plan& plan) {
  plan::Plan out = plan;
  out.wavelength_um.clear();
  for (const std::size_t i : plan.bounces.skeleton) out.wavelength_um.push_back(plan.wavelength_um[i]);
  return out;
}

}  // namespace

struct PathReplay::Pixel {
  SampledPixel sampled;
  ReplayReport found;
  bool excluded = false;
  Spectrum sum, size;  ///< of what the paths bring; without regard to its sign

  void wrong(std::uint64_t& count) { ++count, excluded = true; }
  /// How far a direction or a weight of about 1 is off its own.
  void compare_way(double off, double most = ReplayReport::kMostWayOff) {
    found.worst_way = std::max(found.worst_way, off * ReplayReport::kMostWayOff / most);
    if (!(off <= most)) wrong(found.ways_wrong);
  }
};

struct PathReplay::Path {
  std::uint32_t number = 0;  ///< of the pixel's
  std::size_t sample = 0;
  double scale = 0, reach = 1;
  std::span<const shared::PathStep> steps;
  PathGains light;
};

PathReplay::PathReplay(const ReferenceScene& scene, const plan::Plan& plan, const scene::Instrument& instrument,
                       std::uint64_t seed)
    : scene_(scene),
      plan_(plan),
      instrument_(instrument),
      seed_(plan.sky.hash_seed(seed)),
      sample_seed_(seed),
      lines_(at_lines(plan)),
      light_(scene, lines_) {
  const auto middle = static_cast<std::size_t>(plan.height.count / 2 * plan.view.count),
             nodes = static_cast<std::size_t>(plan.height.count * plan.view.count);
  const std::vector<double>& together = plan.bounces.together[middle];
  const double least = kLeastLight * *std::max_element(together.begin(), together.end());
  const auto share_of = [&](const std::vector<double>& light) {
    Spectrum out;
    for (const std::size_t i : plan.bounces.skeleton) out.push_back(together[i] > least ? light[i] / together[i] : 0);
    return out;
  };
  for (std::size_t s = 0; s < static_cast<std::size_t>(plan.first_lamp()); ++s)
    share_.push_back(share_of(plan.source_spectrum[s * nodes + middle]));
  emitted_share_ =
      plan.thermal.on ? share_of(plan.transmission_spectrum[middle]) : Spectrum(plan.bounces.skeleton.size(), 0.0);
}

float PathReplay::draw(const Pixel& pixel, const Path& path, int level, std::uint32_t what) const {
  return rc_unit_float(rc_hash(seed_, pixel.sampled.number, (path.number << 8) + static_cast<std::uint32_t>(level),
                               kPathDimension + what));
}

PathReplay::Law PathReplay::law_of(const Hit& hit) const {
  const shared::rc_float4& law = plan_.bounces.scattering[scene::surface_of(scene_.compiled, hit.primitive)];
  return {static_cast<double>(law.x), static_cast<double>(law.y),
          plan_.matter.glossy ? static_cast<double>(law.z) : 0.0};
}

rc_id PathReplay::side_by_draw(Pixel& pixel, double u, const Law& law, rc_id device) const {
  const double through = law.gloss + law.near * (1 - law.gloss);
  const rc_id own = u < law.gloss ? RC_GLOSS_SIDE : law.near >= 1 || u < through ? RC_NEAR_SIDE : RC_FAR_SIDE;
  if (device > RC_GLOSS_SIDE) return own;
  ++pixel.found.decisions;
  if (own == device) return own;
  if (std::min(std::abs(u - law.gloss), std::abs(u - through)) < kAtTheChance)
    ++pixel.found.decisions_near;
  else
    pixel.wrong(pixel.found.decisions_wrong);
  return device;
}

bool PathReplay::open(Pixel& pixel, const Sample& from, const glm::dvec3& way, bool device) const {
  ++pixel.found.asked;
  if (scene_.sees(from, way) == device) return device;
  if (scene_.sees_in_double(from, way) == Visibility::uncertain)
    ++pixel.found.asked_explained;
  else
    pixel.wrong(pixel.found.asked_unexplained);
  return device;
}

/// Off the surface on the side that it leaves, and near the point; seen slantingly that slides along the surface.
void PathReplay::compare_start(Pixel& pixel, const Sample& side, const shared::PathStep& step) const {
  const glm::dvec3 off = start_of(step) - side.point;
  const double along = glm::dot(off, side.normal), most = kStartOffUlp * scene_.point_ulp_m(side),
               cosine = std::abs(glm::dot(side.normal, glm::normalize(to_double(side.ray.direction))));
  if (!(along > 0 && along <= most && glm::length(off - along * side.normal) <= most / std::max(cosine, 1e-6)))
    pixel.wrong(pixel.found.ways_wrong);
  // A flat triangle is not met by a ray that leaves it.
  if (step.instance == side.hit.instance && step.primitive == side.hit.primitive) pixel.wrong(pixel.found.ways_wrong);
}

double PathReplay::slender(const Hit& hit) const {
  const glm::dvec3 a = vertex(scene_.compiled, hit.primitive, 0), e1 = vertex(scene_.compiled, hit.primitive, 1) - a,
                   e2 = vertex(scene_.compiled, hit.primitive, 2) - a;
  return glm::length(e1) * glm::length(e2) / std::max(glm::length(glm::cross(e1, e2)), 1e-300);
}

::SkyRay PathReplay::own_way(const Sample& side, float u, float v) const {
  const SkyDensity cosine = {1.0f, 0.0f, 0.5f, 0.0f, 0.0f, 1.0f};
  const glm::vec3 n(side.normal), viewer(-glm::normalize(to_double(side.ray.direction)));
  if (side.side != RC_GLOSS_SIDE) return rc_sky_way(cosine, u, v, n.x, n.y, n.z);
  const scene::Shape& shape = *scene::gloss_of(scene_.compiled, side.hit.primitive);
  const auto roughness = static_cast<float>(rc_shape_roughness(shape.number, shape.parameters()));
  return rc_mirrored_way(cosine, roughness, u, v, n.x, n.y, n.z, viewer.x, viewer.y, viewer.z);
}

double PathReplay::leaving_weight(Pixel& pixel, const Sample& side, float u, float v,
                                  const shared::PathStep& step) const {
  const glm::dvec3 way = way_of(step);
  const bool mirrored = side.side == RC_GLOSS_SIDE;
  const ::SkyRay own = own_way(side, u, v);
  compare_start(pixel, side, step);
  const double rounded = kNormalOffUlp * kUlp * slender(side.hit) + 4 * kUlp / std::sqrt(std::max(double{u}, 1e-8));
  if (std::abs(std::abs(side.normal.z) - kFrameTurns) > kAtTheChance)
    pixel.compare_way(largest(way - glm::dvec3(own.x, own.y, own.z)),
                      (mirrored ? kOfGloss : 1) * (ReplayReport::kMostWayOff + rounded));
  if (!mirrored) return 1;
  const double facing = std::max(0.0, glm::dot(way, side.normal)),
               density = 0.5 * (facing / std::numbers::pi + mirrored_density(scene_.compiled, side, way));
  return facing / (std::numbers::pi * density);
}

void PathReplay::add_sun(Pixel& pixel, Path& path, const SampledPixel& at, bool lit) const {
  const glm::dvec3 sun = to_double(plan_.sun_direction);
  bool asked = false;
  for (const Sample* side : sides_of(at)) {
    if (!plan_.sun_up || plan_.sun_sources == 0) continue;
    if (std::abs(side->cos_sun) < kAtTheChance) asked = true;  // the sun in the surface: to either side, by rounding
    if (!(side->cos_sun > 0)) continue;
    if (side->side != RC_GLOSS_SIDE) open(pixel, *side, sun, lit);
    asked = true;
    if (lit) path.light.add(0, side->cos_sun, light_.scattered(*side, sun));
  }
  if (lit && !asked) pixel.wrong(pixel.found.asked_unexplained);
}

/// False: no ray was sent, or nothing hides what it sees, so that its light was scattered once.
bool PathReplay::begin(Pixel& pixel, Path& path) const {
  const shared::PathStep& step = path.steps[0];
  const Sample& near = pixel.sampled.samples[path.sample];
  const bool sent = step.decided & RC_STEP_SENT;
  if (near.hit.miss() || (sent && step.slot >> 2 != path.sample)) {
    if (sent) pixel.wrong(pixel.found.decisions_wrong);
    return false;
  }
  const Law law = law_of(near.hit);
  const rc_id number =
      side_by_draw(pixel, static_cast<double>(draw(pixel, path, 0, 0)), law, sent ? step.slot & 3u : RC_STEP_ENDS);
  SampledPixel here;
  here.samples = {near};
  if (!pixel.sampled.far_sides.empty()) here.far_sides = {pixel.sampled.far_sides[path.sample]};
  if (!pixel.sampled.glosses.empty()) here.glosses = {pixel.sampled.glosses[path.sample]};
  const Sample* there = side_of(here, number);
  if (!there) {
    pixel.wrong(pixel.found.decisions_wrong);
    return false;
  }
  const Sample& side = *there;
  float u, v;
  rc_sky_draws(seed_ ^ kFirstWays, pixel.sampled.number, path.number, &u, &v);
  if (!sent) {  // only what would go into the surface is not
    if (own_way(side, u, v).facing > kGrazing) pixel.wrong(pixel.found.decisions_wrong);
    return false;
  }
  const double weight = leaving_weight(pixel, side, u, v, step) / chance_of(number, law.near, law.gloss);
  const glm::dvec3 way = way_of(step);
  double most = ReplayReport::kMostWayOff;
  if (number == RC_GLOSS_SIDE) {  // by floats: the cosine with the normal, and the facet between the ways
    const glm::dvec3 viewer = -glm::normalize(to_double(side.ray.direction));
    const scene::Shape& shape = *scene::gloss_of(scene_.compiled, side.hit.primitive);
    const double facing = std::max(1e-9, glm::dot(way, side.normal)),
                 facet =
                     std::max(1e-9, rc_shape_roughness(shape.number, shape.parameters()) * glm::length(way + viewer));
    most = kOfGloss * most + kGlossOffUlp * kUlp * (1 / facing + 1 / facet);
  }
  pixel.compare_way(std::abs(static_cast<double>(step.start.w) / weight - 1), most);
  const double usual = 1e-6 / static_cast<double>(pixel.sampled.samples.size());
  pixel.compare_way(std::abs(static_cast<double>(step.way.w) - path.scale) / std::max(path.scale, usual));
  const bool met = step.decided & RC_STEP_MET;
  if (!(way.z > 0) && !met) pixel.wrong(pixel.found.decisions_wrong);  // the ground around lies there
  if (way.z > 0 && open(pixel, side, way, !met)) return false;
  path.light = light_.unit();
  path.reach = number == RC_GLOSS_SIDE ? 1 : law.most;
  return path.light.carry(weight, light_.scattered(side, way));
}

/// From the surface where a step ended; false: the path ends there.
bool PathReplay::go_on(Pixel& pixel, Path& path, const SampledPixel& at, int level) const {
  const auto l = static_cast<std::size_t>(level);
  const rc_id device = path.steps[l - 1].decided >> RC_STEP_SIDE & 3u;
  const bool went = device != RC_STEP_ENDS;
  const Law law = law_of(at.samples[0].hit);
  const rc_id number = side_by_draw(pixel, static_cast<double>(draw(pixel, path, level, 0)), law, device);
  double chance = chance_of(number, law.near, law.gloss);
  path.reach *= number == RC_GLOSS_SIDE ? 1 : law.most;
  bool survives = true;
  if (level > 1) {
    const double goes_on = std::min(1.0, path.reach), u = static_cast<double>(draw(pixel, path, level, 1));
    survives = u < goes_on;
    ++pixel.found.decisions;
    const bool near = std::abs(u - goes_on) < kAtTheChance * std::max(1.0, static_cast<double>(level));
    if (survives != went && near) survives = went, ++pixel.found.decisions_near;
    chance *= goes_on, path.reach /= goes_on;
  }
  const Sample* there = side_of(at, number);
  const float u = draw(pixel, path, level, 2), v = draw(pixel, path, level, 3);
  // A mirrored way may point into the surface: then it ends as well.
  const bool inwards = there && number == RC_GLOSS_SIDE && !(own_way(*there, u, v).facing > kGrazing);
  if (!there || (survives != went && !(survives && inwards))) pixel.wrong(pixel.found.decisions_wrong);
  if (!went || !there) return false;
  const Sample& side = *there;
  const shared::PathStep& next = path.steps[l];
  const double weight = leaving_weight(pixel, side, u, v, next) / chance;
  path.light.carry(weight, light_.scattered(side, way_of(next)));
  if (level == plan_.bounces.levels && next.way.z > 0 && open(pixel, side, way_of(next), !(next.decided & RC_STEP_MET)))
    light_.add_sky(way_of(next), path.light);
  return level < plan_.bounces.levels;
}

void PathReplay::follow(Pixel& pixel, Path& path) const {
  for (int level = 1;; ++level) {
    const shared::PathStep& step = path.steps[static_cast<std::size_t>(level - 1)];
    const Ray ray{{step.start.x, step.start.y, step.start.z}, {step.way.x, step.way.y, step.way.z}, {}};
    const Hit hit{step.instance, step.primitive};
    const Cause cause = scene_.tracer.explain(ray, hit, scene_.embree.intersect(ray));
    ++pixel.found.hits[static_cast<std::size_t>(cause)], ++pixel.found.steps;
    if (cause == Cause::unexplained) {
      pixel.excluded = true;
      return;
    }
    if (hit.miss()) {
      if (!(step.way.z > 0))
        light_.add_ground(start_of(step), path.light);
      else if (level > 1)
        light_.add_sky(way_of(step), path.light);
      return;
    }
    const SampledPixel at = light_.stand(ray, hit);
    add_sun(pixel, path, at, step.decided & RC_STEP_LIT);
    light_.add_heat(at.samples[0], path.light);
    if (!go_on(pixel, path, at, level)) return;
  }
}

ReplayReport PathReplay::replay(const PixelAddress& address, std::span<const Hit> hits,
                                std::span<const shared::PathStep> steps, std::span<const double> glow) const {
  Pixel pixel;
  pixel.sampled = scene_.sample_pixel(instrument_, plan_, sample_seed_, address);
  for (std::size_t s = 0; s < hits.size(); ++s) {
    pixel.sampled.samples[s].hit = hits[s];
    scene_.place(pixel.sampled, s, plan_);
  }
  const std::size_t lines = lines_.wavelength_um.size(), each = static_cast<std::size_t>(plan_.bounces.levels + 1);
  pixel.sum.assign(lines, 0.0), pixel.size.assign(lines, 0.0);
  const auto nu = static_cast<rc_u32>(instrument_.samples_u), samples = nu * static_cast<rc_u32>(instrument_.samples_v),
             paths = static_cast<rc_u32>(plan_.paths()), number = pixel.sampled.number;
  for (rc_u32 part = 0; part < rc_sky_parts(samples, paths); ++part) {
    const SkyPart share =
        rc_sky_shares(static_cast<int>(instrument_.sampler), nu, samples / nu, paths, seed_, number, part);
    for (rc_u32 ray = 0; ray < share.rays; ++ray) {
      base::throw_if_interrupted();
      Path path;
      path.number = rc_sky_number(samples, paths, part, ray);
      path.sample = rc_sky_sample(share, nu, samples, paths, seed_, number, part, ray);
      path.scale = static_cast<double>(share.scale) * pixel.sampled.samples[path.sample].weight;
      path.steps = steps.subspan(path.number * each, each);
      ++pixel.found.paths;
      if (!begin(pixel, path)) continue;
      follow(pixel, path);
      for (std::size_t m = 0; m < lines; ++m) {
        const auto add = [&](double light) {
          pixel.sum[m] += path.scale * light, pixel.size[m] += path.scale * std::abs(light);
        };
        for (std::size_t s = 0; s < share_.size(); ++s) add(path.light.gained[s][m] * share_[s][m]);
        add(path.light.emitted[m] * emitted_share_[m]);
      }
    }
  }
  pixel.found.pixels = 1, pixel.found.excluded_pixels = pixel.excluded;
  pixel.found.worst_line = address.line, pixel.found.worst_sample = address.sample;
  const double brightest = *std::max_element(pixel.size.begin(), pixel.size.end());
  for (std::size_t m = 0; m < lines && !pixel.excluded; ++m) {
    const double off = std::abs(glow[m] - pixel.sum[m]);
    if (!(off <= 0))
      pixel.found.worst =
          std::isfinite(off)
              ? std::max(pixel.found.worst, off / std::max({pixel.size[m], kLeastLine * brightest, kLeastGlow}))
              : NAN;
  }
  return pixel.found;
}

}  // namespace raycube::reference
