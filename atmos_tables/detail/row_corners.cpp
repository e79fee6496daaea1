#include "atmos_tables/detail/row_corners.h"

#include <algorithm>

#include "host/base/error.h"

namespace raycube::atmos::detail {

namespace {
std::string shortest(double value) {
  std::string text = std::to_string(value);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text;
}
}  // namespace

Bracket bracket(const Axis& axis, double value) {
  const auto& nodes = axis.nodes;
  if (nodes.size() == 1) return {};
  const double slack = 1e-9 * (nodes.back() - nodes.front());
  if (!(value >= nodes.front() - slack && value <= nodes.back() + slack))
    throw base::Error(base::Fault::input, "atmosphere table: " + axis.name + " " + shortest(value) + " " + axis.unit +
                                              " lies outside the table's " + shortest(nodes.front()) + " to " +
                                              shortest(nodes.back()) + " " + axis.unit +
                                              "; build a table that covers it");
  const auto upper = std::upper_bound(nodes.begin(), nodes.end(), value);
  std::size_t high = static_cast<std::size_t>(upper - nodes.begin());
  high = std::clamp<std::size_t>(high, 1, nodes.size() - 1);
  const double w = (value - nodes[high - 1]) / (nodes[high] - nodes[high - 1]);
  return {high - 1, high, std::clamp(w, 0.0, 1.0)};
}

std::vector<Corner> corners_of(const RenderTable& table, const std::vector<Coordinate>& point) {
  std::vector<Corner> corners = {{1.0, {}}};
  for (const Coordinate& coordinate : point) {
    const Bracket b = bracket(table.axis(coordinate.axis), coordinate.value);
    std::vector<Corner> next;
    for (const Corner& corner : corners) {
      if (b.weight < 1)
        next.push_back({corner.weight * (1 - b.weight), corner.node}), next.back().node.push_back(b.low);
      if (b.weight > 0) next.push_back({corner.weight * b.weight, corner.node}), next.back().node.push_back(b.high);
    }
    corners = std::move(next);
  }
  return corners;
}

RowView::RowView(const RenderTable& table, const Row& row) : row_(row) {
  std::size_t stride = 1;
  for (auto name = row.axes.rbegin(); name != row.axes.rend(); ++name) {
    strides_.push_back({*name, stride});
    stride *= table.axis(*name).nodes.size();
  }
  wavelength_stride_ = this->stride("wavelength");
  k_stride_ = this->stride("k");
}

std::size_t RowView::stride(std::string_view axis) const {
  for (const auto& [name, stride] : strides_)
    if (name == axis) return stride;
  return 0;
}

std::size_t RowView::offset(const std::vector<Coordinate>& point, const Corner& corner) const {
  std::size_t at = 0;
  for (std::size_t i = 0; i < point.size(); ++i) at += corner.node[i] * stride(point[i].axis);
  return at;
}

std::vector<std::size_t> RowView::offsets(const std::vector<Coordinate>& point,
                                          const std::vector<Corner>& corners) const {
  std::vector<std::size_t> out;
  for (const Corner& corner : corners) out.push_back(offset(point, corner));
  return out;
}

Spectrum linear(const RenderTable& table, const Row& row, const std::vector<Coordinate>& point) {
  const std::size_t count = table.axis("wavelength").nodes.size();
  const RowView view(table, row);
  Spectrum out(count, 0.0);
  for (const Corner& corner : corners_of(table, point)) {
    const std::size_t base = view.offset(point, corner);
    for (std::size_t i = 0; i < count; ++i) out[i] += corner.weight * view.at(base, i);
  }
  return out;
}

void require_zenith(double zenith_deg, double limit, bool inclusive, const char* what) {
  if (zenith_deg >= 0 && (zenith_deg < limit || (inclusive && zenith_deg == limit))) return;
  throw base::Error(base::Fault::input, std::string("atmosphere table: ") + what + " zenith " + shortest(zenith_deg) +
                                            " deg is outside 0 to " + shortest(limit) + " deg; " +
                                            "the direction must point above the horizon");
}

}  // namespace raycube::atmos::detail
