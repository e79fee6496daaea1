// One shot's walk along its rays; a part of reference_shot, not for others.
#pragma once

#include <limits>
#include <optional>
#include <vector>

#include "host/base/units.h"
#include "host/reference/double_trace.h"
#include "host/reference/lidar_ends.h"
#include "host/reference/lidar_path.h"

namespace raycube::reference::lidar_walk {

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Light on its way: from the last vertex (or the start) along a direction.
struct Path {
  LidarRay start;
  glm::dvec3 origin{0}, direction{0}, lift_m{0};
  Hit leaving;
  double length_m = 0;         ///< of all pieces before `origin`
  int order = 0;               ///< scatterings so far
  double first_m = 0;          ///< from the start to the first vertex
  double weight = 1;           ///< same for all lines
  std::vector<double> share;   ///< [line], of the photons: what each vertex before left
  std::vector<double> energy;  ///< [line], the same for the ledger: all that may go on, whichever lobe was drawn
  std::vector<double> depth;   ///< [node], of all pieces before
};

class Walk {
 public:
  Walk(const scene::CompiledScene& scene, const EmbreeScene& embree, const lidar::LidarPlan& plan,
       const lidar::Shot& shot, const LidarShotOptions& options);
  LidarReference run();

 private:
  bool scatters_air() const;
  bool scatters_particles() const;
  /// Transmission of a line at depths of all nodes.
  double transmission(std::size_t line, const std::vector<double>& depth) const;
  std::vector<double> air_depth(const Straight& piece) const;
  std::vector<double> volume_depth(const Straight& piece) const;
  void add_depths(const Straight& piece, std::vector<double>& depth) const;
  /// Goes on along a piece: losses to the ledger, depths to the path.
  void travel(Path& path, const Straight& piece);
  /// What is left of each line between two points: plates on the way; empty when something opaque is there.
  std::vector<double> open_share(const glm::dvec3& from, const LidarConnection& way, const Hit& leaving,
                                 const glm::dvec3& lift_m);
  /// Light scattered at a point reaches the other end: `sent` per line is f_r cos(theta) (1/sr) or backscatter times a
  /// length.
  void connect(const Path& path, double piece_m, const LidarConnection& way, const std::vector<double>& sent,
               const std::vector<double>& depth, const std::vector<double>& plates, std::vector<double>& rows);
  /// The way out is the way back, and what let light out lets it back. Exits of their own (Footprint::exit_a) count as
  /// the middle.
  bool retraces(const Path& path) const;
  void count_uncertain(const glm::dvec3& point, const LidarConnection& way, const LidarHit& hit,
                       const glm::dvec3& normal);
  void connect_surface(const Path& path, const LidarHit& hit);
  /// Books what a surface takes: energy that arrives is absorbed, truncated (scattered after the last vertex allowed)
  /// or kept.
  void book(Path& path, const LidarHit& hit, bool last);
  void escape(const Path& path);
  struct Drawn {
    glm::dvec3 direction{0};
    bool scattered = false;      ///< else straight on
    bool ends = false;           ///< mirrored into its own surface
    std::vector<double> factor;  ///< [line]
  };
  /// Sums over lines, by which one choice is made for all: each line's factor makes up for it.
  struct Chances {
    double up = 0, down = 0, on = 0, mirrored = 0;
  };
  Chances chances(const LidarHit& hit, bool diffuse, bool straight) const;
  /// Books what is left of a path that ends.
  void truncate(const Path& path);
  /// One lobe of a vertex by the draws of a step (kernels/sampling/lidar_draws.h). Nothing: no light goes on.
  std::optional<Drawn> draw(const Path& path, const LidarHit& hit, unsigned step, bool diffuse, bool straight) const;
  /// Light that scattered at its first vertex, until it ends: every further vertex sends its share back.
  void scatter(Path path, LidarHit hit);
  /// The ray from the start on: through plates, straight.
  void follow(Path path, Hit* first_hit);
  /// Air and particles send light back from all along the first ray.
  void scatter_on_the_way(const Path& path, double from_m, double to_m);

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

}  // namespace raycube::reference::lidar_walk
