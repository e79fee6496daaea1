#include "host/reference/lidar_shot.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "host/reference/double_trace.h"
#include "host/reference/lidar_ends.h"
#include "host/reference/lidar_path.h"
#include "host/reference/sampled_pixel.h"
#include "kernels/sampling/sampler.h"

namespace raycube::reference {

namespace {

constexpr double kLight_m_s = 299792458.0;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Light on its way: from the last vertex (or the start) along a direction.
struct Path {
  LidarRay start;
  glm::dvec3 origin{0}, direction{0}, lift_m{0};
  Hit leaving;
  double length_m = 0;          ///< of all pieces before `origin`
  int order = 0;                ///< scatterings so far
  double weight = 1;            ///< same for all lines
  std::vector<double> share;    ///< [line], of the photons: what each vertex before left
  std::vector<double> depth;    ///< [node], of all pieces before
};

class Walk {
 public:
  Walk(const scene::CompiledScene& scene, const EmbreeScene& embree, const lidar::LidarPlan& plan, const lidar::Shot& shot,
       const LidarShotOptions& options)
      : scene_(scene), plan_(plan), shot_(shot), options_(options), tracer_(scene, embree), judge_(scene), ends_(plan, shot), gate_(plan), air_(plan.air),
        lines_(static_cast<std::size_t>(plan.lines())) {
    for (const scene::Volume& volume : scene.volumes) volumes_.emplace_back(volume);
    const std::size_t size = static_cast<std::size_t>(plan.pixels()) * lines_ * static_cast<std::size_t>(plan.lidar.gate.bins);
    result_.rows = {std::vector<double>(size), std::vector<double>(size), std::vector<double>(size)};
    result_.ledger.resize(lines_);
    const scene::LidarTransport& transport = plan.lidar.transport;
    reach_m_ = transport.range_limit_m > 0 ? transport.range_limit_m : kInfinity;
  }

  LidarReference run() {
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
      path.depth.assign(plan_.nodes.size(), 0);
      ledger_share_ = each / pixels;
      follow(path, &result_.hits[i]);
    }
    return std::move(result_);
  }

 private:
  /// Transmission of a line at depths of all nodes.
  double transmission(std::size_t line, const std::vector<double>& depth) const {
    double sum = 0;
    for (int n = plan_.first_node[line]; n < plan_.first_node[line + 1]; ++n)
      sum += plan_.nodes[static_cast<std::size_t>(n)].weight * std::exp(-depth[static_cast<std::size_t>(n)]);
    return sum;
  }

  std::vector<double> air_depth(const Straight& piece) const {
    std::vector<double> depth(plan_.nodes.size(), 0);
    air_.add_depth(piece, depth);
    return depth;
  }

  std::vector<double> volume_depth(const Straight& piece) const {
    std::vector<double> depth(plan_.nodes.size(), 0);
    for (std::size_t v = 0; v < volumes_.size(); ++v) {
      const double column = volumes_[v].column_cm2(piece), particles = scene_.volumes[v].extinction_per_m * volumes_[v].particles_m(piece);
      for (std::size_t n = 0; n < depth.size(); ++n) depth[n] += column * plan_.cross_section_cm2[v * depth.size() + n] + particles;
    }
    return depth;
  }

  /// Goes on along a piece: losses to the ledger, depths to the path.
  void travel(Path& path, const Straight& piece) {
    const std::vector<double> air = air_depth(piece), volumes = volume_depth(piece);
    for (std::size_t line = 0; line < lines_; ++line)
      for (auto n = static_cast<std::size_t>(plan_.first_node[line]); n < static_cast<std::size_t>(plan_.first_node[line + 1]); ++n) {
        const double both = air[n] + volumes[n];
        if (!(both > 0)) continue;
        const double lost = ledger_share_ * path.share[line] * plan_.nodes[n].weight * std::exp(-path.depth[n]) * -std::expm1(-both);
        result_.ledger[line].air += lost * air[n] / both;
        result_.ledger[line].volumes += lost * volumes[n] / both;
      }
    for (std::size_t n = 0; n < path.depth.size(); ++n) path.depth[n] += air[n] + volumes[n];
  }

  /// What is left of each line between two points: plates on the way; empty when something opaque is there.
  std::vector<double> open_share(const glm::dvec3& from, const LidarConnection& way, const Hit& leaving, const glm::dvec3& lift_m) {
    std::vector<double> share(lines_, 1);
    Hit last = leaving;
    glm::dvec3 lift = lift_m;
    for (double t = 0;;) {
      const auto hit = tracer_.next(from, way.direction, t, way.length_m, last, lift);
      if (!hit) return share;
      bool open = false;
      for (std::size_t line = 0; line < lines_; ++line) {
        share[line] *= matter_of(scene_, plan_, hit->surface, static_cast<int>(line)).plate;
        open |= share[line] > 0;
      }
      if (!open) return {};
      last = hit->hit, lift = glm::dvec3(0);
      t = hit->t_m + hit->clear_m / std::max(1e-3, -glm::dot(hit->normal, way.direction));
    }
  }

  /// Light scattered at a point reaches the other end: `sent` per line is f_r cos(theta) (1/sr) or backscatter times a length.
  void connect(const Path& path, double piece_m, const LidarConnection& way, const std::vector<double>& sent,
               const std::vector<double>& depth, const std::vector<double>& plates, std::vector<double>& rows) {
    const double time_s = plan_.lidar.transport.group_index * (path.length_m + piece_m + way.length_m) / kLight_m_s;
    const int pixel = way.pixel >= 0 ? way.pixel : path.start.pixel;
    for (std::size_t line = 0; line < lines_; ++line) {
      const double photons = plan_.photons[line] * path.weight * path.share[line] * plates[line] * sent[line] * way.factor * transmission(line, depth);
      if (!(photons > 0)) continue;
      if (way.pupil_m < plan_.lidar.transport.minimum_range_m) {
        result_.ledger[line].collected += photons / plan_.photons[line];
        result_.ledger[line].near += photons / plan_.photons[line];
        continue;
      }
      gate_.deposit(rows, pixel, static_cast<int>(line), time_s, photons, result_.ledger[line]);
    }
  }

  /// The way out is the way back: from the start itself to the start.
  bool retraces(const Path& path) const { return path.order == 0 && path.origin == ends_.far_end(); }

  void count_uncertain(const glm::dvec3& point, const LidarConnection& way, const LidarHit& hit, const glm::dvec3& normal) {
    ++result_.connections;
    if (!options_.count_uncertain) return;
    const glm::dvec3 origin = point + hit.clear_m * normal;
    const double slack_m = kOriginSlackUlp / kOffsetUlp * hit.clear_m;
    if (judge_.visibility({origin, way.direction, slack_m}, hit.hit) == Visibility::uncertain) ++result_.uncertain;
  }

  void connect_surface(const Path& path, const LidarHit& hit) {
    const auto way = ends_.connect(hit.point);
    if (!way) return;
    const double cosine = glm::dot(hit.normal, way->direction);
    std::vector<double> sent(lines_, 0);
    double most = 0;
    for (std::size_t line = 0; line < lines_; ++line) {
      const LidarMatter matter = matter_of(scene_, plan_, hit.surface, static_cast<int>(line));
      sent[line] = cosine > 0 ? (matter.reflectance / M_PI + gloss_of(scene_, hit.surface, hit.normal, -path.direction, way->direction)) * cosine
                              : matter.leaf / M_PI * -cosine;
      most = std::max(most, sent[line]);
    }
    if (!(most > 0)) return;
    std::vector<double> depth = path.depth, plates = plates_;
    if (retraces(path)) {
      for (double& d : depth) d *= 2;
    } else {
      const glm::dvec3 side = cosine > 0 ? hit.normal : -hit.normal;
      count_uncertain(hit.point, *way, hit, side);
      plates = open_share(hit.point, *way, hit.hit, hit.clear_m * side);
      if (plates.empty()) return;
      const Straight back{hit.point, way->direction, way->length_m};
      const std::vector<double> air = air_depth(back), volumes = volume_depth(back);
      for (std::size_t n = 0; n < depth.size(); ++n) depth[n] += air[n] + volumes[n];
    }
    connect(path, hit.t_m, *way, sent, depth, plates, path.order == 0 ? result_.rows.first : result_.rows.multiple);
  }

  /// Cosine-distributed way about a surface's side; the random numbers are those of bounce `path.order`.
  void bounce(const Path& path, const LidarHit& hit) {
    const auto seed = static_cast<rc_u32>(options_.own_seed ? options_.seed : plan_.seed);
    const rc_u32 key = lidar::draw_key(plan_, shot_.pulse, path.start.pixel);
    const auto draw = [&](int j) {
      return (static_cast<double>(rc_hash(seed, key, static_cast<rc_u32>(path.start.number), static_cast<rc_u32>(8 * path.order + j)) >> 8) + 0.5) / 16777216.0;
    };
    // One choice for all lines, by the mean of their matter; each line's weight makes up for it.
    double reflect = 0, scatter = 0;
    for (std::size_t line = 0; line < lines_; ++line) {
      const LidarMatter matter = matter_of(scene_, plan_, hit.surface, static_cast<int>(line));
      reflect += matter.reflectance, scatter += matter.scattered();
    }
    if (!(scatter > 0)) return;
    const double probability = reflect / scatter;
    const bool up = draw(0) < probability;
    Path next = path;
    next.order = path.order + 1;
    next.length_m = path.length_m + hit.t_m;
    next.origin = hit.point, next.leaving = hit.hit;
    const glm::dvec3 normal = up ? hit.normal : -hit.normal;
    next.lift_m = hit.clear_m * normal;
    const double cos2 = draw(2), turn = 2 * M_PI * draw(1);
    const glm::dvec3 helper = std::abs(normal.z) < 0.7 ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0);
    const glm::dvec3 x = glm::normalize(glm::cross(helper, normal)), y = glm::cross(normal, x);
    next.direction = std::sqrt(1 - cos2) * (std::cos(turn) * x + std::sin(turn) * y) + std::sqrt(cos2) * normal;
    for (std::size_t line = 0; line < lines_; ++line) {
      const LidarMatter matter = matter_of(scene_, plan_, hit.surface, static_cast<int>(line));
      next.share[line] *= up ? matter.reflectance / probability : matter.leaf / (1 - probability);
    }
    const std::vector<double> plates = plates_;
    follow(next, nullptr);
    plates_ = plates;
  }

  void follow(Path path, Hit* first_hit) {
    double from = 0;
    glm::dvec3 lift = path.lift_m;
    Hit leaving = path.leaving;
    plates_.assign(lines_, 1);
    for (double travelled = 0;;) {
      const auto hit = tracer_.next(path.origin, path.direction, from, reach_m_, leaving, lift);
      if (first_hit) *first_hit = hit ? hit->hit : Hit{};
      first_hit = nullptr;
      const double end = hit ? hit->t_m : reach_m_;
      if (path.order == 0) scatter_on_the_way(path, travelled, end);
      if (end < kInfinity) travel(path, {path.origin + travelled * path.direction, path.direction, end - travelled});
      if (!hit) {
        for (std::size_t line = 0; line < lines_; ++line)
          result_.ledger[line].escaped += ledger_share_ * path.share[line] * transmission(line, path.depth);
        return;
      }
      connect_surface(path, *hit);
      const bool last = path.order + 1 >= plan_.lidar.transport.max_bounces;
      bool open = false;
      for (std::size_t line = 0; line < lines_; ++line) {
        const LidarMatter matter = matter_of(scene_, plan_, hit->surface, static_cast<int>(line));
        const double arrived = ledger_share_ * path.share[line] * transmission(line, path.depth);
        result_.ledger[line].absorbed += arrived * matter.absorbed();
        if (last) result_.ledger[line].truncated += arrived * matter.scattered();
        open |= matter.plate > 0;
      }
      if (!last) bounce(path, *hit);
      if (!open) return;
      for (std::size_t line = 0; line < lines_; ++line) {
        const double plate = matter_of(scene_, plan_, hit->surface, static_cast<int>(line)).plate;
        path.share[line] *= plate, plates_[line] *= plate;
      }
      travelled = hit->t_m, leaving = hit->hit, lift = glm::dvec3(0);
      from = hit->t_m + hit->clear_m / std::max(1e-3, -glm::dot(hit->normal, path.direction));
    }
  }

  void scatter_on_the_way(const Path& path, double from, double to);

  const scene::CompiledScene& scene_;
  const lidar::LidarPlan& plan_;
  const lidar::Shot& shot_;
  const LidarShotOptions& options_;
  LidarTracer tracer_;
  DoubleTracer judge_;
  LidarEnds ends_;
  LidarGate gate_;
  AirPath air_;
  std::vector<VolumePath> volumes_;
  std::size_t lines_;
  double reach_m_ = kInfinity, ledger_share_ = 0;
  std::vector<double> plates_;  ///< [line], of the plates that the ray at hand went through
  LidarReference result_;
};

/// Air and particles send light back from all along the first ray.
void Walk::scatter_on_the_way(const Path& path, double from, double to) {
  const bool air = plan_.lidar.transport.air_return && plan_.air.posts > 0;
  bool particles = false;
  for (const scene::Volume& volume : scene_.volumes) particles |= volume.extinction_per_m > 0;
  if (!air && !particles) return;
  const double n_c = plan_.lidar.transport.group_index / kLight_m_s;
  const double cell_s = gate_.bin_s() / options_.cells_per_bin;
  const glm::dvec3 apart = path.origin - ends_.far_end();
  const double squared = glm::dot(apart, apart), along = glm::dot(apart, path.direction), base = std::sqrt(squared);
  // s + |P(s) - end| = whole way, solved for s.
  const auto where = [&](double time_s) {
    const double way = time_s / n_c;
    return way <= base ? 0.0 : (way * way - squared) / (2 * (way + along));
  };
  const double first = std::max(std::floor((gate_.earliest_s() - gate_.start_s()) / cell_s), -gate_.start_s() / cell_s - 1);
  const double last = std::ceil((gate_.latest_s() - gate_.start_s()) / cell_s);
  std::vector<double> depth = path.depth, sent(lines_), plates(lines_, 1);
  double reached = from;
  const auto advance = [&](double s) {
    const Straight piece{path.origin + reached * path.direction, path.direction, s - reached};
    const std::vector<double> of_air = air_depth(piece), of_volumes = volume_depth(piece);
    for (std::size_t n = 0; n < depth.size(); ++n) depth[n] += of_air[n] + of_volumes[n];
    reached = s;
  };
  // No step straddles a cell's edge, a volume's edge or the surface, and none is longer than a fiftieth of its distance.
  std::vector<double> edges;
  for (std::size_t v = 0; v < volumes_.size(); ++v) {
    if (scene_.volumes[v].extinction_per_m <= 0) continue;
    const auto [enter, leave] = volumes_[v].clip({path.origin, path.direction, to});
    if (leave > enter) edges.push_back(enter), edges.push_back(leave);
  }
  std::sort(edges.begin(), edges.end());
  edges.push_back(kInfinity);
  double s_from = std::max(from, where(gate_.start_s() + first * cell_s));
  for (double cell = first; cell < last && s_from < to;) {
    const double cell_end = where(gate_.start_s() + (cell + 1) * cell_s), edge = *std::upper_bound(edges.begin(), edges.end(), s_from);
    const double s_to = std::min({to, cell_end, edge, s_from + std::max(0.02 * s_from, 1e-3)});
    if (s_to >= cell_end) ++cell;
    if (s_to > s_from) {
      const double step = s_to - s_from, s = 0.5 * (s_from + s_to);
      s_from = s_to;
      const glm::dvec3 point = path.origin + s * path.direction;
      const auto way = ends_.connect(point);
      if (!way || way->pupil_m < plan_.lidar.transport.minimum_range_m) continue;
      advance(s);
      std::vector<double> total = depth, open = plates_;
      if (retraces(path)) {
        for (double& d : total) d *= 2;
      } else {
        const Straight back{point, way->direction, way->length_m};
        const std::vector<double> of_air = air_depth(back), of_volumes = volume_depth(back);
        for (std::size_t n = 0; n < total.size(); ++n) total[n] += of_air[n] + of_volumes[n];
        open = open_share(point, *way, {}, glm::dvec3(0));
        if (open.empty()) continue;
      }
      if (air) {
        for (std::size_t line = 0; line < lines_; ++line) sent[line] = air_.backscatter(static_cast<int>(line), point.z) * step;
        connect(path, s, *way, sent, total, open, result_.rows.air);
      }
      double beta = 0;
      for (std::size_t v = 0; v < volumes_.size(); ++v)
        if (scene_.volumes[v].extinction_per_m > 0)
          beta += scene_.volumes[v].extinction_per_m / scene_.volumes[v].lidar_ratio_sr * volumes_[v].particles_at(point);
      if (!(beta > 0)) continue;
      sent.assign(lines_, beta * step);
      connect(path, s, *way, sent, total, open, result_.rows.first);
    }
  }
}

}  // namespace

LidarReference reference_shot(const scene::CompiledScene& scene, const EmbreeScene& embree, const lidar::LidarPlan& plan, const lidar::Shot& shot,
                              const LidarShotOptions& options) {
  return Walk(scene, embree, plan, shot, options).run();
}

}  // namespace raycube::reference
