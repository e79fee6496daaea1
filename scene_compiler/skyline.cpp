#include "scene_compiler/skyline.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <limits>

#include "host/base/parallel.h"

namespace raycube::scene {
namespace {

constexpr float kNone = std::numeric_limits<float>::infinity();
constexpr double kTrianglesOfCell = 8;
constexpr double kMostCells = 4e6;
constexpr std::size_t kMostCellsOfTriangle = 16;  // on average; grounds of few large and many small triangles are left
constexpr std::uint32_t kBlocksLookedAt = 2048;
constexpr std::size_t kPasses = 3;
constexpr float kMargin = 1.02f;
constexpr float kFlat = 0.2f;  // rays less steep than this are few: no skyline is told lower

struct Point {
  float x, y, z;
  std::uint64_t hash() const {
    const auto xy = std::uint64_t{std::bit_cast<std::uint32_t>(x)} << 32 | std::bit_cast<std::uint32_t>(y);
    return mixed(mixed(xy) + std::bit_cast<std::uint32_t>(z));
  }
  static std::uint64_t mixed(std::uint64_t v) {  // Stafford's variant 13 of MurmurHash3's end
    v = (v ^ v >> 30) * 0xbf58476d1ce4e5b9u;
    v = (v ^ v >> 27) * 0x94d049bb133111ebu;
    return v ^ v >> 31;
  }
};

struct Triangle {
  Point corner[3];

  Triangle(const shared::TriBlock& b, std::size_t lane)
      : corner{{b.v0_x[lane], b.v0_y[lane], b.v0_z[lane]},
               {b.v1_x[lane], b.v1_y[lane], b.v1_z[lane]},
               {b.v2_x[lane], b.v2_y[lane], b.v2_z[lane]}} {}
  /// Twice its area on the map: positive where its corners go counter-clockwise there.
  double twice_area() const {
    const Point &a = corner[0], &b = corner[1], &c = corner[2];
    return (double{b.x} - a.x) * (double{c.y} - a.y) - (double{b.y} - a.y) * (double{c.x} - a.x);
  }
  /// Slope of its plane; INFINITY where that is vertical or none.
  float slope() const {
    const Point &a = corner[0], &b = corner[1], &c = corner[2];
    const double ux = double{b.x} - a.x, uy = double{b.y} - a.y, uz = double{b.z} - a.z;
    const double vx = double{c.x} - a.x, vy = double{c.y} - a.y, vz = double{c.z} - a.z;
    const double x = uy * vz - uz * vy, y = uz * vx - ux * vz, z = ux * vy - uy * vx;
    const double slope = std::sqrt(x * x + y * y) / std::abs(z);
    return std::isfinite(slope) ? static_cast<float>(slope) : kNone;
  }
};

/// Calls action(triangle) for every triangle of every `step`th block of a tree.
template <class Action>
void for_triangles(const CompiledScene& scene, const Tree& tree, const Action& action, std::uint32_t step = 1) {
  for (std::uint32_t b = tree.first_block; b < tree.first_block + tree.block_count; b += step)
    for (std::size_t lane = 0; lane < RC_BLOCK; ++lane)
      if (scene.blocks[b].surface[lane] != RC_NONE) action(Triangle(scene.blocks[b], lane));
}

double map_area(const Tree& tree) { return (double{tree.hi[0]} - tree.lo[0]) * (double{tree.hi[1]} - tree.lo[1]); }

/// Whether a matrix turns, moves and scales by one factor: then a point lifted off the ground along its normal, in the
/// scene, lies above the ground in the tree's frame too.
bool keeps_angles(const shared::Instance& instance) {
  const shared::rc_float4 *r = &instance.world_from_local_0, *end = r + 3;
  double xx = 0, yy = 0, zz = 0, xy = 0, yz = 0, zx = 0;
  for (; r < end; ++r) {
    const double x = r->x, y = r->y, z = r->z;
    xx += x * x, yy += y * y, zz += z * z, xy += x * y, yz += y * z, zx += z * x;
  }
  const double apart = std::max({std::abs(xx - yy), std::abs(yy - zz), std::abs(xy), std::abs(yz), std::abs(zx)});
  return apart <= 1e-5 * xx;
}

/// The placed tree to survey, or RC_NONE. Of large trees the area is told by some of their blocks.
std::uint32_t find_ground(const CompiledScene& scene) {
  std::vector<std::uint32_t> placed(scene.trees.size(), 0);
  for (const auto& instance : scene.instances) ++placed[instance.tree];
  std::uint32_t best = RC_NONE;
  double most = 0;
  for (std::uint32_t i = 0; i < scene.instances.size(); ++i) {
    const Tree& tree = scene.trees[scene.instances[i].tree];
    if (placed[scene.instances[i].tree] != 1 || map_area(tree) <= most || !keeps_angles(scene.instances[i])) continue;
    double gentle = 0;
    const std::uint32_t step = 1 + tree.block_count / kBlocksLookedAt;
    for_triangles(
        scene, tree,
        [&](const Triangle& t) {
          if (t.slope() <= kSteepSkyline) gentle += 0.5 * step * std::abs(t.twice_area());
        },
        step);
    if (gentle <= most || gentle < 0.5 * map_area(tree)) continue;
    best = i, most = gentle;
  }
  return best;
}

/// A rectangle of cells.
struct Cells {
  std::uint32_t x0, x1, y0, y1;  // the last ones belong to it
};

class Survey {
 public:
  Survey(const CompiledScene& scene, const Tree& tree, int threads, std::size_t edges_at_once)
      : scene_(scene), tree_(tree), threads_(threads), edges_at_once_(edges_at_once) {
    const double wanted = std::clamp(tree.triangle_count / kTrianglesOfCell, 1.0, kMostCells);
    cell_ = std::max(std::sqrt(map_area(tree) / wanted), 1e-30);
    per_cell_ = static_cast<float>(1 / cell_);
    const double across = (double{tree.hi[0]} - tree.lo[0]) / cell_ + 1,
                 along = (double{tree.hi[1]} - tree.lo[1]) / cell_ + 1;
    if (across * along > 2 * kMostCells) return;  // a thread's length of ground
    columns_ = static_cast<std::uint32_t>(across), rows_ = static_cast<std::uint32_t>(along);
  }

  Skyline skyline() {
    Skyline out;
    if (cells() == 0) return out;
    auto heights = base::beside(threads_, [this] { spread(); });
    sew();
    heights.get();
    if (touched_ > most_touched()) return out;
    for (std::size_t c = 0; c < cells(); ++c)
      if (layers_[c] != 1 || rim_[c]) near_[0][c] = kNone;
    rough_to_near();
    make_pyramid();
    out.x_m = tree_.lo[0], out.y_m = tree_.lo[1], out.per_cell = per_cell_;
    out.columns = columns_, out.rows = rows_;
    out.cells.resize(2 * cells());
    base::for_each_index(rows_, threads_, [&](std::size_t row) {
      for (std::uint32_t column = 0; column < columns_; ++column) {
        const std::size_t c = row * columns_ + column;
        const float slope = kMargin * steepest(column, static_cast<std::uint32_t>(row));
        out.cells[2 * c] = hi_[c], out.cells[2 * c + 1] = slope <= kSteepSkyline ? slope * slope : kNone;
      }
    });
    return out;
  }

 private:
  std::size_t cells() const { return std::size_t{columns_} * rows_; }
  std::uint32_t column_of(float x) const {
    return static_cast<std::uint32_t>(
        std::clamp((x - tree_.lo[0]) * per_cell_, 0.0f, static_cast<float>(columns_ - 1)));
  }
  std::uint32_t row_of(float y) const {
    return static_cast<std::uint32_t>(std::clamp((y - tree_.lo[1]) * per_cell_, 0.0f, static_cast<float>(rows_ - 1)));
  }
  /// Cells that a box on the map may touch, past what rounding moves.
  Cells cells_of(float lo_x, float hi_x, float lo_y, float hi_y) const {
    const auto slack = static_cast<float>(1e-3 * cell_);
    return {column_of(lo_x - slack), column_of(hi_x + slack), row_of(lo_y - slack), row_of(hi_y + slack)};
  }
  Cells cells_of(const Triangle& t) const {
    const Point &a = t.corner[0], &b = t.corner[1], &c = t.corner[2];
    return cells_of(std::min({a.x, b.x, c.x}), std::max({a.x, b.x, c.x}), std::min({a.y, b.y, c.y}),
                    std::max({a.y, b.y, c.y}));
  }

  /// Grounds whose triangles touch more cells, large and small ones in one place, are left alone: a bound on the work.
  std::size_t most_touched() const { return kMostCellsOfTriangle * (std::size_t{tree_.triangle_count} + cells()); }

  /// Heights, slopes and layers of each cell.
  void spread() {
    lo_.assign(cells(), kNone), hi_.assign(cells(), -kNone), near_[0].assign(cells(), 0.0f);
    layers_.assign(cells(), 0);
    for_triangles(scene_, tree_, [&](const Triangle& t) {
      const Point &a = t.corner[0], &b = t.corner[1], &c = t.corner[2];
      const float slope = t.slope(), lo = std::min({a.z, b.z, c.z}), hi = std::max({a.z, b.z, c.z});
      const Cells in = cells_of(t);
      touched_ += std::size_t{in.x1 - in.x0 + 1} * (in.y1 - in.y0 + 1);
      if (touched_ > most_touched()) return;
      for (std::uint32_t y = in.y0; y <= in.y1; ++y)
        for (std::uint32_t x = in.x0; x <= in.x1; ++x) {
          const std::size_t at = std::size_t{y} * columns_ + x;
          lo_[at] = std::min(lo_[at], lo), hi_[at] = std::max(hi_[at], hi);
          near_[0][at] = std::max(near_[0][at], slope);
          if (covers(t, x, y)) layers_[at] = static_cast<std::uint8_t>(std::min(layers_[at] + 1, 2));
        }
    });
  }

  /// Whether a triangle covers the middle of a cell, moved off the lines of round numbers. A middle on an edge counts
  /// for both sides: such a cell is not known.
  bool covers(const Triangle& t, std::uint32_t column, std::uint32_t row) const {
    const double x = tree_.lo[0] + (column + 0.5127) * cell_, y = tree_.lo[1] + (row + 0.4861) * cell_;
    bool left = true, right = true;
    for (int k = 0; k < 3; ++k) {
      const Point &a = t.corner[k], &b = t.corner[(k + 1) % 3];
      const double side = (double{b.x} - a.x) * (y - a.y) - (double{b.y} - a.y) * (x - a.x);
      left = left && side >= 0, right = right && side <= 0;
    }
    return left || right;
  }

  /// An edge by the hash of its ends; last bit: on which side of it, seen from the end of smaller hash, its triangle
  /// lies.
  struct Edge {
    std::uint64_t key;
    float lo_x, hi_x, lo_y, hi_y;
  };

  std::size_t cell_of_edge(const Point& a, const Point& b) const {
    return std::size_t{row_of(0.5f * (a.y + b.y))} * columns_ + column_of(0.5f * (a.x + b.x));
  }

  /// Edges in the order of the cells of their middles.
  void sew() {
    rim_.assign(cells(), 0);
    std::vector<std::uint32_t> first(cells() + 1, 0);
    for_triangles(scene_, tree_, [&](const Triangle& t) {
      for (int k = 0; k < 3; ++k) ++first[cell_of_edge(t.corner[k], t.corner[(k + 1) % 3]) + 1];
    });
    for (std::size_t c = 0; c < cells(); ++c) first[c + 1] += first[c];
    const std::size_t most = std::max(edges_at_once_, first.back() / kPasses);
    std::vector<Edge> edges;
    edges.reserve(std::min<std::size_t>(most, first.back()));
    for (std::size_t begin = 0, end = 0; begin < cells(); begin = end) {
      for (end = begin + 1; end < cells() && first[end + 1] - first[begin] <= most;) ++end;
      sew_cells(begin, end, first, edges);
    }
  }

  /// Those of cells begin .. end - 1.
  void sew_cells(std::size_t begin, std::size_t end, const std::vector<std::uint32_t>& first,
                 std::vector<Edge>& edges) {
    constexpr std::size_t kCellsOfPiece = 1024;
    const std::size_t before = first[begin];
    edges.resize(first[end] - before);
    std::vector<std::uint32_t> next(first.begin() + static_cast<std::ptrdiff_t>(begin),
                                    first.begin() + static_cast<std::ptrdiff_t>(end));
    for_triangles(scene_, tree_, [&](const Triangle& t) {
      const bool turned = t.twice_area() < 0;
      for (int k = 0; k < 3; ++k) {
        const Point &a = t.corner[k], &b = t.corner[(k + 1) % 3];
        const std::size_t cell = cell_of_edge(a, b);
        if (cell < begin || cell >= end) continue;
        const std::uint64_t hash_a = a.hash(), hash_b = b.hash(), side = (hash_a < hash_b) != turned ? 1 : 0;
        edges[next[cell - begin]++ - before] = {Point::mixed(hash_a + hash_b) << 1 | side, std::min(a.x, b.x),
                                                std::max(a.x, b.x), std::min(a.y, b.y), std::max(a.y, b.y)};
      }
    });
    base::for_each_index((end - begin + kCellsOfPiece - 1) / kCellsOfPiece, threads_, [&](std::size_t piece) {
      const std::size_t c0 = begin + piece * kCellsOfPiece, c1 = std::min(end, c0 + kCellsOfPiece);
      for (std::size_t c = c0; c < c1; ++c)
        sew_cell(edges.data() + (first[c] - before), edges.data() + (first[c + 1] - before));
    });
  }

  /// Edges that are not those of two triangles, one on either side, are the ground's own: cells that they touch are not
  /// known.
  void sew_cell(Edge* begin, Edge* end) {
    std::sort(begin, end, [](const Edge& a, const Edge& b) { return a.key < b.key; });
    for (Edge *at = begin, *past = begin; at < end; at = past) {
      while (past < end && past->key >> 1 == at->key >> 1) ++past;
      if (past - at == 2 && at[0].key != at[1].key) continue;
      const Cells in = cells_of(at->lo_x, at->hi_x, at->lo_y, at->hi_y);
      for (std::uint32_t y = in.y0; y <= in.y1; ++y)
        for (std::uint32_t x = in.x0; x <= in.x1; ++x)
          std::atomic_ref(rim_[std::size_t{y} * columns_ + x]).store(1, std::memory_order_relaxed);
    }
  }

  /// The greatest slope within 1, 2 and 4 cells of each, from that of each alone.
  void rough_to_near() {
    const auto widened = [&](const std::vector<float>& from, std::uint32_t by) {
      std::vector<float> across(cells()), out(cells());
      base::for_each_index(rows_, threads_, [&](std::size_t row) {
        const float* in = &from[row * columns_];
        for (std::uint32_t x = 0; x < columns_; ++x)
          across[row * columns_ + x] =
              *std::max_element(in + (x > by ? x - by : 0), in + std::min(columns_, x + by + 1));
      });
      base::for_each_index(rows_, threads_, [&](std::size_t row) {
        const auto y = static_cast<std::uint32_t>(row);
        for (std::uint32_t from_row = y > by ? y - by : 0; from_row < std::min(rows_, y + by + 1); ++from_row)
          for (std::uint32_t x = 0; x < columns_; ++x)
            out[row * columns_ + x] = std::max(out[row * columns_ + x], across[std::size_t{from_row} * columns_ + x]);
      });
      return out;
    };
    near_[1] = widened(near_[0], 1);
    near_[2] = widened(near_[1], 1);
    near_[3] = widened(near_[2], 2);
  }

  struct Level {
    std::uint32_t columns, rows;
    std::vector<float> hi;
  };

  /// Greatest heights of squares of 1, 2, 4 .. cells.
  void make_pyramid() {
    pyramid_.push_back({columns_, rows_, hi_});
    while (pyramid_.back().columns > 1 || pyramid_.back().rows > 1) {
      const Level& below = pyramid_.back();
      Level level{(below.columns + 1) / 2, (below.rows + 1) / 2, {}};
      level.hi.assign(std::size_t{level.columns} * level.rows, -kNone);
      for (std::uint32_t y = 0; y < below.rows; ++y)
        for (std::uint32_t x = 0; x < below.columns; ++x) {
          float& to = level.hi[std::size_t{y / 2} * level.columns + x / 2];
          to = std::max(to, below.hi[std::size_t{y} * below.columns + x]);
        }
      pyramid_.push_back(std::move(level));
    }
  }

  /// The steepest that any of the ground rises as seen from it within a cell.
  float steepest(std::uint32_t column, std::uint32_t row) const {
    const std::size_t c = std::size_t{row} * columns_ + column;
    constexpr std::uint32_t kReach[4] = {0, 1, 2, 4};
    for (std::size_t k = 3; k > 0; --k)
      if (near_[k][c] <= kSteepSkyline) return far(column, row, kReach[k], std::max(near_[k][c], kFlat));
    return kNone;
  }

  /// `slope`, or that of what lies more than `reach` cells off where it is more. From the pyramid's top.
  float far(std::uint32_t column, std::uint32_t row, std::uint32_t reach, float slope) const {
    struct Square {
      std::uint32_t level, x, y;
    };
    const float from = lo_[std::size_t{row} * columns_ + column];
    Square stack[4 * 32];
    std::size_t top = 0;
    stack[top++] = {static_cast<std::uint32_t>(pyramid_.size() - 1), 0, 0};
    while (top > 0 && slope <= kSteepSkyline) {
      const Square s = stack[--top];
      const Level& level = pyramid_[s.level];
      const float rise = level.hi[std::size_t{s.y} * level.columns + s.x] - from;
      if (rise <= 0) continue;
      const std::uint32_t size = 1u << s.level;
      const std::uint32_t dx = cells_between(column, s.x << s.level, size),
                          dy = cells_between(row, s.y << s.level, size);
      if (s.level == 0 && std::max(dx, dy) < reach) continue;  // that many cells lie between the two: `near` tells
      const auto x = static_cast<float>(dx), y = static_cast<float>(dy);
      const float gap = 0.999f / per_cell_ * std::sqrt(x * x + y * y);
      if (rise <= slope * gap) continue;
      if (s.level == 0) {
        slope = rise / gap;
        continue;
      }
      const Level& below = pyramid_[s.level - 1];
      for (std::uint32_t v = 2 * s.y; v < std::min(2 * s.y + 2, below.rows); ++v)
        for (std::uint32_t u = 2 * s.x; u < std::min(2 * s.x + 2, below.columns); ++u)
          stack[top++] = {s.level - 1, u, v};
    }
    return slope;
  }

  /// Whole cells between a cell and a row of `size` cells from `first` on.
  static std::uint32_t cells_between(std::uint32_t cell, std::uint32_t first, std::uint32_t size) {
    if (cell < first) return first - cell - 1;
    return cell >= first + size ? cell - (first + size) : 0;
  }

  const CompiledScene& scene_;
  const Tree& tree_;
  int threads_;
  std::size_t edges_at_once_;
  double cell_;  // side of a cell, m
  float per_cell_;
  std::uint32_t columns_ = 0, rows_ = 0;
  std::size_t touched_ = 0;
  std::vector<float> lo_, hi_;  // least and greatest heights of what touches each cell
  std::vector<std::uint8_t> layers_,
      rim_;  // triangles over each cell's middle, 2 for more; whether an edge of the ground touches it
  std::vector<float> near_[4];  // greatest slope within 0, 1, 2, 4 cells; INFINITY where the ground is not one function
  std::vector<Level> pyramid_;
};

}  // namespace

Skyline survey_skyline(const CompiledScene& scene, int threads, std::size_t edges_at_once) {
  const std::uint32_t instance = find_ground(scene);
  if (instance == RC_NONE) return {};
  Skyline skyline = Survey(scene, scene.trees[scene.instances[instance].tree], threads, edges_at_once).skyline();
  bool known = false;
  for (std::size_t c = 1; c < skyline.cells.size(); c += 2) known = known || skyline.cells[c] < kNone;
  if (!known) return {};
  skyline.instance = instance;
  return skyline;
}

}  // namespace raycube::scene
