// Terrain: a height raster as triangles, and the heights of those very triangles.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/base/error.h"
#include "scene_compiler/bvh_builder.h"
#include "scene_compiler/raster.h"

namespace raycube::scene {

/// Posts at pixel centres, cells between four posts, in the local frame (double). Cell (row, column) lies
/// between posts (row, column) and (row + 1, column + 1); "north-west" is its first post, as in a north-up
/// raster.
class TerrainGrid {
 public:
  /// local_from_pixel: of pixel corners, as Raster::transform. z_m: posts, row by row.
  TerrainGrid(int columns, int rows, const std::array<double, 6>& local_from_pixel, std::vector<double> z_m);

  /// The same triangles' planes by `times` x `times` cells for each.
  TerrainGrid refined(int times) const;

  int cell_columns() const { return columns_ - 1; }
  int cell_rows() const { return rows_ - 1; }
  std::size_t cell_count() const {
    return static_cast<std::size_t>(cell_columns()) * static_cast<std::size_t>(cell_rows());
  }
  double cell_area_m2() const;

  /// Local x, y of raster coordinates (pixel corners are whole numbers, post (0, 0) is at (0.5, 0.5)).
  std::array<double, 2> local(double column, double row) const;
  /// Cell that holds a point, or nullopt off the terrain.
  std::optional<std::size_t> cell_at(double x_m, double y_m) const;
  /// Height of the triangle above or below the point (in the plane of its own cell: what a vertical ray
  /// hits).
  std::optional<double> height_m(double x_m, double y_m) const;
  std::array<double, 2> cell_center(std::size_t cell) const;
  /// The point itself on the terrain; off it a point of its edge, nearest in rows and columns.
  std::array<double, 2> nearest(double x_m, double y_m) const;
  /// Local bounds: lowest x, lowest y, highest x, highest y.
  std::array<double, 4> bounds() const;

  /// Two triangles per cell, split from first to last post, facing up; surface_of_cell gives each cell's
  /// surface and user_face is the cell number.
  TriangleMesh mesh(const std::vector<std::uint32_t>& surface_of_cell) const;

 private:
  /// Height at u, v (0 .. 1, right and down) of a cell.
  double height_in(int column, int row, double u, double v) const;
  /// Posts counted from the first, of any point: column, row.
  std::array<double, 2> post_at(double x_m, double y_m) const;
  bool locate(double x_m, double y_m, std::size_t& cell, double& u, double& v) const;

  int columns_, rows_;
  std::array<double, 6> local_from_pixel_;
  double determinant_;
  std::vector<double> z_m_;
};

/// Class or fraction pixel of every cell: the pixel that holds the cell's centre, on an edge the one before
/// (north, west). A map without georeferencing must have the terrain's pixels or cells, and lies on them.
/// local_from_map of a georeferenced map: its transform with the origin taken off. nullopt after reporting a
/// size that does not fit or cells outside the map.
std::optional<std::vector<std::size_t>> map_pixels(const TerrainGrid& grid, const Raster& map,
                                                   const std::array<double, 6>& local_from_map,
                                                   const base::Where& asked_by, base::Problems& problems);

}  // namespace raycube::scene
