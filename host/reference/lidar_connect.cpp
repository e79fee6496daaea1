// What vertices, air and particles send to the other end of a path.
#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "host/reference/lidar_walk.h"
#include "host/reference/sampled_pixel.h"

namespace raycube::reference::lidar_walk {

std::vector<double> Walk::open_share(const glm::dvec3& from, const LidarConnection& way, const Hit& leaving,
                                     const glm::dvec3& lift_m) {
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

void Walk::connect(const Path& path, double piece_m, const LidarConnection& way, const std::vector<double>& sent,
                   const std::vector<double>& depth, const std::vector<double>& plates, std::vector<double>& rows) {
  const double time_s =
      plan_.lidar.transport.group_index * (path.length_m + piece_m + way.length_m) / base::kLightSpeed_m_s;
  const int pixel = way.pixel >= 0 ? way.pixel : path.start.pixel;
  for (std::size_t line = 0; line < lines_; ++line) {
    const double photons = plan_.photons[line] * path.weight * path.share[line] * plates[line] * sent[line] *
                           way.factor * transmission(line, depth);
    if (!(photons > 0)) continue;
    const double pupil_m =
        ends_.receiver_sampling() ? (path.order == 0 ? path.length_m + piece_m : path.first_m) : way.pupil_m;
    if (pupil_m < plan_.lidar.transport.minimum_range_m) {
      result_.ledger[line].collected += photons / plan_.photons[line];
      result_.ledger[line].near += photons / plan_.photons[line];
      continue;
    }
    gate_.deposit(rows, pixel, static_cast<int>(line), time_s, photons, result_.ledger[line]);
  }
}

bool Walk::retraces(const Path& path) const { return path.order == 0 && shot_.exit_m == shot_.pupil_m; }

void Walk::count_uncertain(const glm::dvec3& point, const LidarConnection& way, const LidarHit& hit,
                           const glm::dvec3& normal) {
  ++result_.connections;
  if (!options_.count_uncertain) return;
  const glm::dvec3 origin = point + hit.clear_m * normal;
  const double slack_m = kOriginSlackUlp / kOffsetUlp * hit.clear_m;
  if (judge_.visibility({origin, way.direction, slack_m}, hit.hit) == Visibility::uncertain) ++result_.uncertain;
}

void Walk::connect_surface(const Path& path, const LidarHit& hit) {
  const auto way = ends_.connect(hit.point);
  if (way && way->edge) ++result_.uncertain;
  if (!way || !(way->factor > 0)) return;
  const double cosine = glm::dot(hit.normal, way->direction);
  std::vector<double> sent(lines_, 0);
  double most = 0;
  for (std::size_t line = 0; line < lines_; ++line) {
    const SurfaceLobes lobes =
        lobes_of(scene_, plan_, hit.surface, static_cast<int>(line), hit.normal, -path.direction, way->direction);
    const LidarMatter matter = matter_of(scene_, plan_, hit.surface, static_cast<int>(line));
    sent[line] = cosine > 0 ? (matter.reflectance * lobes.front + lobes.gloss) * cosine : matter.leaf / M_PI * -cosine;
    most = std::max(most, sent[line]);
  }
  if (!(most > 0)) return;
  std::vector<double> depth = path.depth, plates = plates_;
  if (!retraces(path)) {
    const glm::dvec3 side = cosine > 0 ? hit.normal : -hit.normal;
    count_uncertain(hit.point, *way, hit, side);
    plates = open_share(hit.point, *way, hit.hit, hit.clear_m * side);
    if (plates.empty()) return;
    // What the ray itself went through on its way here is in the path's share.
  }
  add_depths({hit.point, way->direction, way->length_m}, depth);
  connect(path, hit.t_m, *way, sent, depth, plates, path.order == 0 ? result_.rows.first : result_.rows.multiple);
}

void Walk::scatter_on_the_way(const Path& path, double from, double to) {
  const bool air = scatters_air(), particles = scatters_particles();
  if (!air && !particles) return;
  const double n_c = plan_.lidar.transport.group_index / base::kLightSpeed_m_s;
  // Smooth air needs two cells a bin; volumes have edges.
  const double cell_s = gate_.bin_s() / (particles ? options_.cells_per_bin : 2);
  const glm::dvec3 apart = path.origin - ends_.far_end();
  const double squared = glm::dot(apart, apart), along = glm::dot(apart, path.direction), base = std::sqrt(squared);
  // s + |P(s) - end| = whole way, solved for s.
  const auto where = [&](double time_s) {
    const double way = time_s / n_c;
    return way <= base ? 0.0 : (way * way - squared) / (2 * (way + along));
  };
  const double first =
      std::max(std::floor((gate_.earliest_s() - gate_.start_s()) / cell_s), -gate_.start_s() / cell_s - 1);
  const double last = std::ceil((gate_.latest_s() - gate_.start_s()) / cell_s);
  std::vector<double> depth = path.depth, sent(lines_);
  double reached = from;
  const auto advance = [&](double s) {
    add_depths({path.origin + reached * path.direction, path.direction, s - reached}, depth);
    reached = s;
  };
  // No step straddles a cell's edge, a volume's edge or the surface, and none is longer than 1/500 of its distance.
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
    const double cell_end = where(gate_.start_s() + (cell + 1) * cell_s),
                 edge = *std::upper_bound(edges.begin(), edges.end(), s_from);
    const double s_to = std::min({to, cell_end, edge, s_from + std::max(0.002 * s_from, 1e-3)});
    if (s_to >= cell_end) ++cell;
    if (s_to > s_from) {
      const double step = s_to - s_from, s = 0.5 * (s_from + s_to);
      s_from = s_to;
      const glm::dvec3 point = path.origin + s * path.direction;
      const auto way = ends_.connect(point);
      if (!way || !(way->factor > 0) || way->pupil_m < plan_.lidar.transport.minimum_range_m) continue;
      advance(s);
      std::vector<double> total = depth, open = plates_;
      if (!retraces(path)) {
        open = open_share(point, *way, {}, glm::dvec3(0));
        if (open.empty()) continue;
      }
      if (path.origin == ends_.far_end()) {
        for (double& d : total) d *= 2;
      } else {
        add_depths({point, way->direction, way->length_m}, total);
      }
      if (air) {
        for (std::size_t line = 0; line < lines_; ++line)
          sent[line] = air_.backscatter(static_cast<int>(line), point.z) * step;
        connect(path, s, *way, sent, total, open, result_.rows.air);
      }
      double beta = 0;
      for (std::size_t v = 0; v < volumes_.size(); ++v)
        if (scene_.volumes[v].extinction_per_m > 0)
          beta +=
              scene_.volumes[v].extinction_per_m / scene_.volumes[v].lidar_ratio_sr * volumes_[v].particles_at(point);
      if (!(beta > 0)) continue;
      sent.assign(lines_, beta * step);
      connect(path, s, *way, sent, total, open, result_.rows.particles);
    }
  }
}

}  // namespace raycube::reference::lidar_walk
