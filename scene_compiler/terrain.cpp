#include "host/base/text.h"
#include "scene_compiler/terrain.h"

#include <algorithm>
#include <cmath>

namespace raycube::scene {

TerrainGrid::TerrainGrid(int columns, int rows, const std::array<double, 6>& local_from_pixel, std::vector<double> z_m)
    : columns_(columns),
      rows_(rows),
      local_from_pixel_(local_from_pixel),
      determinant_(local_from_pixel[1] * local_from_pixel[5] - local_from_pixel[2] * local_from_pixel[4]),
      z_m_(std::move(z_m)) {}

TerrainGrid TerrainGrid::refined(int times) const {
  const auto& t = local_from_pixel_;
  std::array<double, 6> finer = t;
  for (const std::size_t k : {1u, 2u, 4u, 5u}) finer[k] /= times;
  // The first post stays where it is, in the middle of a smaller pixel.
  finer[0] += 0.5 * (t[1] + t[2] - finer[1] - finer[2]), finer[3] += 0.5 * (t[4] + t[5] - finer[4] - finer[5]);
  const int columns = cell_columns() * times + 1, rows = cell_rows() * times + 1;
  std::vector<double> z;
  z.reserve(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < columns; ++c) {
      const int cell_c = std::min(c / times, columns_ - 2), cell_r = std::min(r / times, rows_ - 2);
      const double u = static_cast<double>(c - cell_c * times) / times,
                   v = static_cast<double>(r - cell_r * times) / times;
      z.push_back(height_in(cell_c, cell_r, u, v));
    }
  return TerrainGrid(columns, rows, finer, std::move(z));
}

double TerrainGrid::height_in(int column, int row, double u, double v) const {
  const double* post = z_m_.data() + static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) + column;
  const double nw = post[0], ne = post[1], sw = post[columns_], se = post[columns_ + 1];
  return v >= u ? nw + v * (sw - nw) + u * (se - sw) : nw + u * (ne - nw) + v * (se - ne);
}

double TerrainGrid::cell_area_m2() const { return std::abs(determinant_); }

std::array<double, 2> TerrainGrid::local(double column, double row) const {
  const auto& t = local_from_pixel_;
  return {t[0] + t[1] * column + t[2] * row, t[3] + t[4] * column + t[5] * row};
}

std::array<double, 2> TerrainGrid::post_at(double x_m, double y_m) const {
  const auto& t = local_from_pixel_;
  const double dx = x_m - t[0], dy = y_m - t[3];
  return {(dx * t[5] - dy * t[2]) / determinant_ - 0.5, (dy * t[1] - dx * t[4]) / determinant_ - 0.5};
}

std::array<double, 2> TerrainGrid::nearest(double x_m, double y_m) const {
  const auto [column, row] = post_at(x_m, y_m);
  return local(std::clamp(column, 0.0, columns_ - 1.0) + 0.5, std::clamp(row, 0.0, rows_ - 1.0) + 0.5);
}

bool TerrainGrid::locate(double x_m, double y_m, std::size_t& cell, double& u, double& v) const {
  auto [column, row] = post_at(x_m, y_m);
  // A millionth of a cell beyond the edge is the rounding of georeferenced doubles.
  const double slack = 1e-6;
  if (column > -slack && column < columns_ - 1 + slack) column = std::clamp(column, 0.0, columns_ - 1.0);
  if (row > -slack && row < rows_ - 1 + slack) row = std::clamp(row, 0.0, rows_ - 1.0);
  if (!(column >= 0 && column <= columns_ - 1 && row >= 0 && row <= rows_ - 1)) return false;
  const int c = std::min(static_cast<int>(column), columns_ - 2), r = std::min(static_cast<int>(row), rows_ - 2);
  cell = static_cast<std::size_t>(r) * static_cast<std::size_t>(cell_columns()) + static_cast<std::size_t>(c);
  u = column - c;
  v = row - r;
  return true;
}

std::optional<std::size_t> TerrainGrid::cell_at(double x_m, double y_m) const {
  std::size_t cell = 0;
  double u = 0, v = 0;
  if (!locate(x_m, y_m, cell, u, v)) return std::nullopt;
  return cell;
}

std::optional<double> TerrainGrid::height_m(double x_m, double y_m) const {
  std::size_t cell = 0;
  double u = 0, v = 0;
  if (!locate(x_m, y_m, cell, u, v)) return std::nullopt;
  const auto columns = static_cast<std::size_t>(cell_columns());
  return height_in(static_cast<int>(cell % columns), static_cast<int>(cell / columns), u, v);
}

std::array<double, 2> TerrainGrid::cell_center(std::size_t cell) const {
  const auto columns = static_cast<std::size_t>(cell_columns());
  return local(static_cast<double>(cell % columns) + 1.0, static_cast<double>(cell / columns) + 1.0);
}

std::array<double, 4> TerrainGrid::bounds() const {
  std::array<double, 4> out{1e300, 1e300, -1e300, -1e300};
  for (const double c : {0.5, columns_ - 0.5})
    for (const double r : {0.5, rows_ - 0.5}) {
      const auto [x, y] = local(c, r);
      out = {std::min(out[0], x), std::min(out[1], y), std::max(out[2], x), std::max(out[3], y)};
    }
  return out;
}

TriangleMesh TerrainGrid::mesh(const std::vector<std::uint32_t>& surface_of_cell) const {
  TriangleMesh out;
  out.vertices.reserve(z_m_.size());
  for (int r = 0; r < rows_; ++r)
    for (int c = 0; c < columns_; ++c) {
      const auto [x, y] = local(c + 0.5, r + 0.5);
      out.vertices.push_back(
          {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z_m_[out.vertices.size()])});
    }
  out.triangles.reserve(2 * cell_count());
  for (std::size_t cell = 0; cell < cell_count(); ++cell) {
    const auto columns = static_cast<std::size_t>(cell_columns());
    const auto nw = static_cast<std::uint32_t>(cell / columns * static_cast<std::size_t>(columns_) + cell % columns);
    const std::uint32_t ne = nw + 1, sw = nw + static_cast<std::uint32_t>(columns_), se = sw + 1;
    // A north-up raster has a negative determinant (rows run south); a flipped one needs the other sense to
    // face up.
    const bool north_up = determinant_ < 0;
    out.triangles.push_back(north_up ? std::array{nw, sw, se} : std::array{nw, se, sw});
    out.triangles.push_back(north_up ? std::array{nw, se, ne} : std::array{nw, ne, se});
    for (int k = 0; k < 2; ++k) {
      out.surface.push_back(surface_of_cell[cell]);
      out.user_face.push_back(static_cast<std::uint32_t>(cell));
    }
  }
  return out;
}

std::optional<std::vector<std::size_t>> map_pixels(const TerrainGrid& grid, const Raster& map,
                                                   const std::array<double, 6>& local_from_map,
                                                   const base::Where& asked_by, base::Problems& problems) {
  const std::string size = std::to_string(map.columns) + " x " + std::to_string(map.rows);
  std::vector<std::size_t> out(grid.cell_count());
  const auto columns = static_cast<std::size_t>(grid.cell_columns());
  if (!map.georeferenced) {
    const bool pixels = map.columns == grid.cell_columns() + 1 && map.rows == grid.cell_rows() + 1;
    const bool cells = map.columns == grid.cell_columns() && map.rows == grid.cell_rows();
    if (!pixels && !cells) {
      problems.add(asked_by, "map without georeferencing does not fit the terrain", size + " pixels in " + map.file,
                   "it needs the terrain's " + std::to_string(grid.cell_columns() + 1) + " x " +
                       std::to_string(grid.cell_rows() + 1) + " pixels or its " + std::to_string(grid.cell_columns()) +
                       " x " + std::to_string(grid.cell_rows()) + " cells, or georeferencing");
      return std::nullopt;
    }
    for (std::size_t cell = 0; cell < out.size(); ++cell)
      out[cell] = cell / columns * static_cast<std::size_t>(map.columns) + cell % columns;
    return out;
  }
  const auto& t = local_from_map;
  const double determinant = t[1] * t[5] - t[2] * t[4];
  std::size_t outside = 0;
  for (std::size_t cell = 0; cell < out.size(); ++cell) {
    const auto [x, y] = grid.cell_center(cell);
    const double dx = x - t[0], dy = y - t[3];
    // A centre on an edge belongs to the pixel before it; 1e-6 pixel absorbs the rounding of georeferenced
    // doubles.
    const double column = std::ceil((dx * t[5] - dy * t[2]) / determinant - 1e-6) - 1,
                 row = std::ceil((dy * t[1] - dx * t[4]) / determinant - 1e-6) - 1;
    if (column < 0 || row < 0 || column >= map.columns || row >= map.rows) {
      ++outside;
      continue;
    }
    out[cell] =
        static_cast<std::size_t>(row) * static_cast<std::size_t>(map.columns) + static_cast<std::size_t>(column);
  }
  if (outside > 0) {
    problems.add(asked_by, "map does not cover the terrain",
                 std::to_string(outside) + " of " + base::counted(out.size(), "cell") + " outside " + map.file,
                 "give a map that covers it");
    return std::nullopt;
  }
  return out;
}

}  // namespace raycube::scene
