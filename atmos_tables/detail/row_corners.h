// Where a point lies among a table's nodes, and the row values at the nodes around it. Used by the interpolation only.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "atmos_tables/render_table.h"

namespace raycube::atmos::detail {

using Spectrum = std::vector<double>;

struct Coordinate {
  const char* axis;
  double value;
};

/// A node set around the point: per coordinate the node index, and the product of the linear weights.
struct Corner {
  double weight;
  std::vector<std::size_t> node;  ///< per coordinate
};

struct Bracket {
  std::size_t low = 0, high = 0;
  double weight = 0;  ///< of high
};

/// The two nodes around a value. A one-node axis answers its node; a value outside is Error(input) naming axis and
/// range.
Bracket bracket(const Axis& axis, double value);

/// The nodes around a point, at most 2 per coordinate, those of weight 0 left out.
std::vector<Corner> corners_of(const RenderTable& table, const std::vector<Coordinate>& point);

/// Where a corner's values lie in a row: value(wavelength, k) = values[base + wavelength * wavelength_stride + k *
/// k_stride].
class RowView {
 public:
  RowView(const RenderTable& table, const Row& row);
  bool has_k() const { return k_stride_ != 0; }
  std::size_t offset(const std::vector<Coordinate>& point, const Corner& corner) const;
  std::vector<std::size_t> offsets(const std::vector<Coordinate>& point, const std::vector<Corner>& corners) const;
  double at(std::size_t offset, std::size_t wavelength, std::size_t k = 0) const {
    return row_.values[offset + wavelength * wavelength_stride_ + k * k_stride_];
  }

 private:
  std::size_t stride(std::string_view axis) const;

  const Row& row_;
  std::size_t wavelength_stride_ = 0, k_stride_ = 0;
  std::vector<std::pair<std::string, std::size_t>> strides_;
};

/// Plain linear interpolation of a row without k.
Spectrum linear(const RenderTable& table, const Row& row, const std::vector<Coordinate>& point);

/// Error(input) unless 0 <= zenith_deg < limit, or equal to it when inclusive.
void require_zenith(double zenith_deg, double limit, bool inclusive, const char* what);

}  // namespace raycube::atmos::detail
