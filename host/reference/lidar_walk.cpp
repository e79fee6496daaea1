#include "host/reference/lidar_walk.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "kernels/sampling/lidar_draws.h"

namespace raycube::reference::lidar_walk {

Walk::Walk(const scene::CompiledScene& scene, const EmbreeScene& embree, const lidar::LidarPlan& plan,
           const lidar::Shot& shot, const LidarShotOptions& options)
    : scene_(scene),
      plan_(plan),
      shot_(shot),
      options_(options),
      tracer_(scene, embree),
      judge_(scene),
      ends_(plan, shot),
      gate_(plan, options.slope_s),
      air_(plan.air),
      lines_(static_cast<std::size_t>(plan.lines())) {
  for (const scene::Volume& volume : scene.volumes) volumes_.emplace_back(volume);
  const std::size_t size =
      static_cast<std::size_t>(plan.pixels()) * lines_ * static_cast<std::size_t>(plan.lidar.gate.bins);
  result_.rows.first.resize(size);
  if (plan.lidar.transport.max_bounces > 1) result_.rows.multiple.resize(size);
  if (scatters_air() && !options.scattered_only) result_.rows.air.resize(size);
  if (scatters_particles() && !options.scattered_only) result_.rows.particles.resize(size);
  result_.ledger.resize(lines_);
  const scene::LidarTransport& transport = plan.lidar.transport;
  reach_m_ = transport.range_limit_m > 0 ? transport.range_limit_m : kInfinity;
}

bool Walk::scatters_air() const {
  return plan_.lidar.transport.air_return && plan_.air.posts > 0 && !plan_.air.backscatter_per_m_sr.empty();
}

bool Walk::scatters_particles() const {
  return std::any_of(scene_.volumes.begin(), scene_.volumes.end(),
                     [](const scene::Volume& volume) { return volume.extinction_per_m > 0; });
}

LidarReference Walk::run() {
  const std::vector<LidarRay> rays = lidar_rays(plan_, shot_);
  const double each = 1.0 / static_cast<double>(plan_.footprint.a.size());
  const double pixels = ends_.receiver_sampling() ? plan_.pixels() : 1;
  result_.hits.resize(rays.size());
  for (std::size_t i = 0; i < rays.size(); ++i) {
    Path path;
    path.start = rays[i];
    path.origin = rays[i].origin, path.direction = rays[i].direction;
    // Receiver sampling: the ledger's whole is all that is followed backwards, so a share is of all pixels' samples.
    path.weight = each * ends_.weight(rays[i]);
    path.share.assign(lines_, 1);
    path.energy.assign(lines_, 1);
    path.depth.assign(plan_.nodes.size(), 0);
    ledger_share_ = each / pixels;
    follow(path, &result_.hits[i]);
  }
  return std::move(result_);
}

std::vector<double> Walk::air_depth(const Straight& piece) const {
  std::vector<double> depth(plan_.nodes.size(), 0);
  air_.add_depth(piece, depth);
  return depth;
}

std::vector<double> Walk::volume_depth(const Straight& piece) const {
  std::vector<double> depth(plan_.nodes.size(), 0);
  for (std::size_t v = 0; v < volumes_.size(); ++v) {
    const double column = volumes_[v].column_cm2(piece),
                 particles = scene_.volumes[v].extinction_per_m * volumes_[v].particles_m(piece);
    for (std::size_t n = 0; n < depth.size(); ++n)
      depth[n] += column * plan_.cross_section_cm2[v * depth.size() + n] + particles;
  }
  return depth;
}

double Walk::transmission(std::size_t line, const std::vector<double>& depth) const {
  double sum = 0;
  for (int n = plan_.first_node[line]; n < plan_.first_node[line + 1]; ++n)
    sum += plan_.nodes[static_cast<std::size_t>(n)].weight * std::exp(-depth[static_cast<std::size_t>(n)]);
  return sum;
}

void Walk::add_depths(const Straight& piece, std::vector<double>& depth) const {
  const std::vector<double> of_air = air_depth(piece), of_volumes = volume_depth(piece);
  for (std::size_t n = 0; n < depth.size(); ++n) depth[n] += of_air[n] + of_volumes[n];
}

void Walk::travel(Path& path, const Straight& piece) {
  const std::vector<double> air = air_depth(piece), volumes = volume_depth(piece);
  for (std::size_t line = 0; line < lines_; ++line)
    for (auto n = static_cast<std::size_t>(plan_.first_node[line]);
         n < static_cast<std::size_t>(plan_.first_node[line + 1]); ++n) {
      const double both = air[n] + volumes[n];
      if (!(both > 0)) continue;
      const double lost =
          ledger_share_ * path.energy[line] * plan_.nodes[n].weight * std::exp(-path.depth[n]) * -std::expm1(-both);
      result_.ledger[line].air += lost * air[n] / both;
      result_.ledger[line].volumes += lost * volumes[n] / both;
    }
  for (std::size_t n = 0; n < path.depth.size(); ++n) path.depth[n] += air[n] + volumes[n];
}

void Walk::book(Path& path, const LidarHit& hit, bool last) {
  for (std::size_t line = 0; line < lines_; ++line) {
    const LidarMatter matter = matter_of(scene_, plan_, hit.surface, static_cast<int>(line));
    const double arrived = ledger_share_ * path.energy[line] * transmission(line, path.depth);
    result_.ledger[line].absorbed += arrived * matter.absorbed();
    if (last) result_.ledger[line].truncated += arrived * matter.scattered();
  }
}

void Walk::escape(const Path& path) {
  for (std::size_t line = 0; line < lines_; ++line)
    result_.ledger[line].escaped += ledger_share_ * path.energy[line] * transmission(line, path.depth);
}

void Walk::truncate(const Path& path) {
  for (std::size_t line = 0; line < lines_; ++line)
    result_.ledger[line].truncated += ledger_share_ * path.energy[line] * transmission(line, path.depth);
}

namespace {

/// Branchless basis about a unit normal of Duff et al. 2017.
struct Basis {
  glm::dvec3 x, y, n;
  explicit Basis(const glm::dvec3& normal) : n(normal) {
    const double sign = std::copysign(1.0, n.z), a = -1 / (sign + n.z), c = n.x * n.y * a;
    x = {1 + sign * n.x * n.x * a, sign * c, -sign * n.x}, y = {c, sign + n.y * n.y * a, -n.y};
  }
  RcLocal into(const glm::dvec3& v) const { return {glm::dot(v, x), glm::dot(v, y), glm::dot(v, n)}; }
  glm::dvec3 out_of(const RcLocal& v) const { return v.x * x + v.y * y + v.z * n; }
};

}  // namespace

Walk::Chances Walk::chances(const LidarHit& hit, bool diffuse, bool straight) const {
  Chances of;
  for (std::size_t line = 0; line < lines_; ++line) {
    const LidarMatter matter = matter_of(scene_, plan_, hit.surface, static_cast<int>(line));
    if (diffuse) of.up += matter.reflectance, of.down += matter.leaf, of.mirrored += matter.gloss;
    if (straight) of.on += matter.plate;
  }
  return of;
}

std::optional<Walk::Drawn> Walk::draw(const Path& path, const LidarHit& hit, unsigned step, bool diffuse,
                                      bool straight) const {
  const auto seed = static_cast<rc_u32>(options_.own_seed ? options_.seed : plan_.seed);
  const rc_u32 key = lidar::draw_key(plan_, shot_.pulse, path.start.pixel),
               number = static_cast<rc_u32>(path.start.number);
  const auto unit = [&](rc_u32 dimension) {
    return static_cast<double>(rc_unit_float(rc_hash(seed, key, number, dimension)));
  };
  const Chances of = chances(hit, diffuse, straight);
  const double all = of.up + of.down + of.on + of.mirrored;
  if (!(all > 0)) return {};
  const double lobe = unit(RC_DRAW_LOBE(step)) * all, u = unit(RC_DRAW_RADIUS(step)), v = unit(RC_DRAW_ANGLE(step));
  const bool mirrored = of.mirrored > 0 && lobe >= of.up + of.down + of.on, up = !mirrored && lobe < of.up;
  Drawn out;
  out.direction = path.direction;
  out.scattered = mirrored || lobe < of.up + of.down || of.on == 0;
  const glm::dvec3 n = up || mirrored ? hit.normal : -hit.normal, from = -path.direction;
  if (out.scattered) {
    const Basis basis(n);
    out.direction = basis.out_of(mirrored ? draw_mirrored(scene_, hit.surface, basis.into(from), u, v)
                                          : draw_direction(scene_, hit.surface, up, basis.into(from), u, v));
  }
  const double chance = (mirrored ? of.mirrored : !out.scattered ? of.on : up ? of.up : of.down) / all;
  for (std::size_t line = 0; line < lines_; ++line) {
    const LidarMatter matter = matter_of(scene_, plan_, hit.surface, static_cast<int>(line));
    const auto at = static_cast<int>(line);
    double sent = out.scattered ? matter.leaf : matter.plate;
    if (mirrored) sent = mirrored_weight(scene_, plan_, hit.surface, at, n, from, out.direction);
    if (up) sent = matter.reflectance * drawn_weight(scene_, plan_, hit.surface, at, n, from, out.direction);
    out.factor.push_back(sent / chance);
  }
  out.ends = mirrored && !(glm::dot(out.direction, n) > 0);
  return out;
}

void Walk::scatter(Path path, LidarHit hit) {
  for (unsigned step = 1;; ++step) {
    const bool first = step == 1, last = path.order + 1 >= plan_.lidar.transport.max_bounces;
    if (!first) book(path, hit, last);
    const auto drawn = draw(path, hit, step, !last, !first);
    if (!drawn) return;
    for (std::size_t line = 0; line < lines_; ++line) {
      const LidarMatter matter = matter_of(scene_, plan_, hit.surface, static_cast<int>(line));
      path.share[line] *= drawn->factor[line];
      path.energy[line] *= (last ? 0 : matter.scattered()) + (first ? 0 : matter.plate);
    }
    if (drawn->ends) return truncate(path);
    if (path.order == 0) path.first_m = path.length_m + hit.t_m;
    if (drawn->scattered) ++path.order;
    path.length_m += hit.t_m;
    path.origin = hit.point, path.leaving = hit.hit, path.direction = drawn->direction;
    path.lift_m = (glm::dot(hit.normal, path.direction) > 0 ? hit.clear_m : -hit.clear_m) * hit.normal;
    const auto next = tracer_.next(path.origin, path.direction, 0, kInfinity, path.leaving, path.lift_m);
    if (!next) return escape(path);
    travel(path, {path.origin, path.direction, next->t_m});
    hit = *next;
    connect_surface(path, hit);
  }
}

void Walk::follow(Path path, Hit* first_hit) {
  double from = 0;
  plates_.assign(lines_, 1);
  for (double travelled = 0;;) {
    const auto hit = tracer_.next(path.origin, path.direction, from, kInfinity, path.leaving, glm::dvec3(0));
    if (first_hit) *first_hit = hit ? hit->hit : Hit{};
    if (hit) result_.deepest_m = std::max(result_.deepest_m, hit->t_m - tracer_.entry_m(path.origin, path.direction));
    first_hit = nullptr;
    if (!options_.scattered_only && path.start.pixel % options_.air_pixel_step == 0)
      scatter_on_the_way(path, travelled, std::min(reach_m_, hit ? hit->t_m : kInfinity));
    if (!hit || hit->t_m > reach_m_) return escape(path);
    travel(path, {path.origin + travelled * path.direction, path.direction, hit->t_m - travelled});
    connect_surface(path, *hit);
    const bool last = plan_.lidar.transport.max_bounces == 1;
    book(path, *hit, last);
    if (!last) scatter(path, *hit);
    bool open = false;
    for (std::size_t line = 0; line < lines_; ++line) {
      const double plate = matter_of(scene_, plan_, hit->surface, static_cast<int>(line)).plate;
      path.share[line] *= plate, path.energy[line] *= plate, plates_[line] *= plate;
      open |= plate > 0;
    }
    if (!open) return;
    travelled = hit->t_m, path.leaving = hit->hit;
    from = hit->t_m + hit->clear_m / std::max(1e-3, -glm::dot(hit->normal, path.direction));
  }
}

}  // namespace raycube::reference::lidar_walk
