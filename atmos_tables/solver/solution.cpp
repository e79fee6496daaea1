#include "atmos_tables/solver/solution.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "atmos_tables/solver/beam_scatter.h"
#include "atmos_tables/solver/level_fields.h"
#include "host/base/error.h"

namespace raycube::atmos::solver {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {
constexpr double kPi = std::numbers::pi;
constexpr double kDegree = kPi / 180;
constexpr double kSmallestCosine = 1e-9;
}  // namespace

struct ColumnSolution::Data {
  Column column;
  Options options;
  HalfRange nodes;
  std::vector<ScaledLayer> scaled;
  std::vector<BeamLayer> beam, true_beam_path;  ///< along the scaled and along the true depth
  std::vector<double> level_depth;              ///< true
  std::vector<OrderSolution> orders;
  LevelFields first_order;  ///< levels of order 0

  Place place(double depth) const;
  std::array<double, 2> case_flux(const Place& place, bool up) const;
  Fluxes own_fluxes(const Place& place) const;  ///< over a black, cold ground
  GroundCoupling coupling() const;
  double ground_radiance(const Ground& ground) const;
  BeamColumn beam_column() const;
};

namespace {

using Data = ColumnSolution::Data;

LayerSources layer_sources(const Data& data, std::size_t layer, int order) {
  const Column& column = data.column;
  const double azimuth_factor = order == 0 ? 1 : 2;
  LayerSources sources{column.beam.flux * azimuth_factor / (4 * kPi) * data.beam[layer].top,
                       data.beam[layer].slope, 0, 0};
  if (!column.planck.empty()) {
    sources.planck_top = column.planck[layer];
    sources.planck_bottom = column.planck[layer + 1];
  }
  return sources;
}

/// Solves one azimuth order. Order 0 has the second case, the ground as the only lamp.
OrderSolution solve_order(const Data& data, int order, LevelFields& fields) {
  OrderSolution solution;
  solution.order = order;
  solution.cases = order == 0 ? 2 : 1;
  const OrderBasis basis = order_basis(order, data.options.streams, data.nodes, data.column.beam.cosine);
  for (std::size_t i = 0; i < data.scaled.size(); ++i)
    solution.layers.push_back(solve_layer(data.scaled[i], layer_sources(data, i, order), basis, data.nodes));
  const auto count = static_cast<Eigen::Index>(data.nodes.cosine.size());
  MatrixXd top = MatrixXd::Zero(count, solution.cases), bottom = top;
  if (order == 0)
    for (Eigen::Index j = 0; j < count; ++j) {
      const auto at = static_cast<std::size_t>(j);
      const double flux_root = std::sqrt(data.nodes.weight[at] * data.nodes.cosine[at]);
      top(j, 0) = flux_root * data.column.top_radiance;
      bottom(j, 1) = flux_root;
    }
  fields = solve_levels(solution.layers, top, bottom);
  for (int c = 0; c < solution.cases; ++c) {
    std::vector<Amplitudes> amplitudes;
    for (std::size_t i = 0; i < data.scaled.size(); ++i)
      amplitudes.push_back(homogeneous_amplitudes(solution.layers[i], fields.up[i].col(c),
                                                  fields.down[i].col(c), fields.up[i + 1].col(c),
                                                  fields.down[i + 1].col(c), c == 0));
    solution.amplitudes.push_back(std::move(amplitudes));
  }
  return solution;
}

/// Largest radiance of case 0 at a node and level.
double largest_radiance(const Data& data, const LevelFields& fields) {
  double largest = 0;
  for (const auto* side : {&fields.up, &fields.down})
    for (const MatrixXd& level : *side)
      for (Eigen::Index j = 0; j < level.rows(); ++j) {
        const auto at = static_cast<std::size_t>(j);
        largest = std::max(largest,
                           std::abs(level(j, 0)) / std::sqrt(data.nodes.weight[at] * data.nodes.cosine[at]));
      }
  return largest;
}

/// Does any layer scatter in this azimuth order?
bool order_is_lit(const Data& data, int order) {
  if (data.column.beam.flux <= 0 || data.column.beam.cosine >= 1) return false;
  for (const ScaledLayer& layer : data.scaled)
    for (std::size_t l = static_cast<std::size_t>(order); l < layer.moment.size(); ++l)
      if (layer.albedo > 0 && layer.moment[l] != 0) return true;
  return false;
}

void solve_orders(Data& data) {
  data.orders.push_back(solve_order(data, 0, data.first_order));
  const double limit = data.options.fourier_tolerance * largest_radiance(data, data.first_order);
  int small = 0;
  for (int order = 1; order < data.options.streams && order_is_lit(data, order) && small < 2; ++order) {
    LevelFields fields;
    data.orders.push_back(solve_order(data, order, fields));
    small = largest_radiance(data, fields) <= limit ? small + 1 : 0;
  }
}

}  // namespace

Place ColumnSolution::Data::place(double depth) const {
  const double total = level_depth.back();
  if (!(depth >= -1e-9 * total && depth <= total * (1 + 1e-9)))
    throw base::Error(base::Fault::input, "optical depth " + std::to_string(depth) +
                                              " is outside the column: it has 0 to " + std::to_string(total) +
                                              "; ask for a depth inside it");
  if (scaled.empty()) return {};
  // First level at or below the depth; the layer is the one above it, so a boundary is the bottom of a layer.
  const auto below = std::lower_bound(level_depth.begin() + 1, level_depth.end() - 1, depth);
  const auto layer = static_cast<std::size_t>(below - level_depth.begin()) - 1;
  const double true_depth = scaled[layer].true_depth, part = depth - level_depth[layer];
  if (depth >= level_depth[layer + 1]) return {layer, scaled[layer].depth};
  if (part <= 0 || true_depth <= 0) return {layer, 0};
  return {layer, std::min(1.0, part / true_depth) * scaled[layer].depth};
}

/// Diffuse flux of both cases (of the scaled problem); exact level values at the layers' faces.
std::array<double, 2> ColumnSolution::Data::case_flux(const Place& at, bool up) const {
  const auto count = static_cast<Eigen::Index>(nodes.cosine.size());
  const Eigen::Map<const VectorXd> mu(nodes.cosine.data(), count), weight(nodes.weight.data(), count);
  const VectorXd flux_root = (weight.array() * mu.array()).sqrt();
  std::array<double, 2> flux{};
  const bool at_bottom = !scaled.empty() && at.u >= scaled[at.layer].depth;
  for (std::size_t c = 0; c < 2; ++c) {
    if (scaled.empty() || at_bottom || at.u <= 0) {
      const std::vector<MatrixXd>& side = up ? first_order.up : first_order.down;
      flux[c] =
          2 * kPi * flux_root.dot(side[at.layer + (at_bottom ? 1 : 0)].col(static_cast<Eigen::Index>(c)));
      continue;
    }
    const LayerMode& mode = orders[0].layers[at.layer];
    ModalField field = homogeneous_field(mode, orders[0].amplitudes[c][at.layer], at.u);
    if (c == 0) {
      const ModalField own = particular_field(mode, at.u);
      field.sigma += own.sigma;
      field.delta += own.delta;
    }
    const double sum = flux_root.dot(mode.x * field.sigma), difference = flux_root.dot(mode.z * field.delta);
    flux[c] = kPi * (up ? sum + difference : sum - difference);
  }
  return flux;
}

Fluxes ColumnSolution::Data::own_fluxes(const Place& at) const {
  const double beam_flux = column.beam.flux * column.beam.cosine;
  double true_beam = beam_flux, scaled_beam = beam_flux;
  if (!scaled.empty()) {
    const ScaledLayer& layer = scaled[at.layer];
    const double true_u = layer.depth > 0 ? at.u / layer.depth * layer.true_depth : 0;
    true_beam *= true_beam_path[at.layer].top * std::exp(-true_beam_path[at.layer].slope * true_u);
    scaled_beam *= beam[at.layer].top * std::exp(-beam[at.layer].slope * at.u);
  }
  // What delta-M counts as beam although it was scattered forward is diffuse light (S4.6).
  return {true_beam, case_flux(at, false)[0] + (scaled_beam - true_beam), case_flux(at, true)[0]};
}

GroundCoupling ColumnSolution::Data::coupling() const {
  const Place at = place(level_depth.back());
  const Fluxes own = own_fluxes(at);
  return {own.direct_down, own.diffuse_down, case_flux(at, false)[1] / kPi};
}

double ColumnSolution::Data::ground_radiance(const Ground& ground) const {
  const GroundCoupling air = coupling();
  return (ground.albedo * (air.direct_irradiance + air.diffuse_irradiance) / kPi +
          (1 - ground.albedo) * ground.planck) /
         (1 - ground.albedo * air.spherical_albedo);
}

BeamColumn ColumnSolution::Data::beam_column() const {
  return {&column,
          &scaled,
          &beam,
          column.beam.flux,
          column.beam.cosine,
          options.streams,
          options.intensity_correction};
}

double ColumnSolution::total_depth() const { return data_->level_depth.back(); }

double ColumnSolution::level_depth(std::size_t level) const {
  if (level >= data_->level_depth.size())
    throw base::Error(base::Fault::input, "level " + std::to_string(level) +
                                              " does not exist: the column has levels 0 to " +
                                              std::to_string(data_->level_depth.size() - 1));
  return data_->level_depth[level];
}

Fluxes ColumnSolution::fluxes(double depth, const Ground& ground) const {
  check_ground(ground);
  const Place at = data_->place(depth);
  Fluxes fluxes = data_->own_fluxes(at);
  const double from_ground = data_->ground_radiance(ground);
  fluxes.diffuse_down += from_ground * data_->case_flux(at, false)[1];
  fluxes.up += from_ground * data_->case_flux(at, true)[1];
  return fluxes;
}

std::vector<double> ColumnSolution::radiances(double depth, double cosine,
                                              const std::vector<double>& azimuth_deg,
                                              const Ground& ground) const {
  check_ground(ground);
  if (!(std::abs(cosine) <= 1))
    throw base::Error(base::Fault::input,
                      "cosine " + std::to_string(cosine) + " of a direction is not in [-1, 1]");
  const Place at = data_->place(depth);
  const bool up = cosine >= 0;
  const double mu = std::max(std::abs(cosine), kSmallestCosine);
  const Column& column = data_->column;
  std::vector<double> radiance(azimuth_deg.size(), 0.0);
  double isotropic = 0;
  for (const OrderSolution& order : data_->orders) {
    const std::array<double, 2> term = order_radiance(
        order, data_->scaled, data_->nodes, data_->options.streams, mu, up, at, column.top_radiance);
    if (order.order == 0) isotropic = data_->ground_radiance(ground) * term[1];
    for (std::size_t i = 0; i < radiance.size(); ++i)
      radiance[i] += term[0] * std::cos(order.order * kDegree * (azimuth_deg[i] - column.beam.azimuth_deg));
  }
  const BeamColumn beam = data_->beam_column();
  const double sines =
      std::sqrt(std::max(0.0, (1 - mu) * (1 + mu) * (1 - column.beam.cosine) * (1 + column.beam.cosine)));
  for (std::size_t i = 0; i < radiance.size(); ++i) {
    const double turn = std::cos(kDegree * (azimuth_deg[i] - column.beam.azimuth_deg));
    const double cos_angle = std::clamp((up ? -mu : mu) * column.beam.cosine + sines * turn, -1.0, 1.0);
    radiance[i] += isotropic + once_scattered(beam, mu, up, cos_angle, at);
    if (data_->options.intensity_correction && !up) radiance[i] -= aureole_excess(beam, mu, cos_angle, at);
  }
  return radiance;
}

double ColumnSolution::radiance(double depth, double cosine, double azimuth_deg, const Ground& ground) const {
  return radiances(depth, cosine, {azimuth_deg}, ground).front();
}

double ColumnSolution::path_radiance(double depth, double cosine, double azimuth_deg) const {
  return radiance(depth, cosine, azimuth_deg, Ground{});
}

GroundCoupling ColumnSolution::ground_coupling() const { return data_->coupling(); }

GroundTransmission ColumnSolution::ground_transmission(double depth, double cosine) const {
  if (!(std::abs(cosine) <= 1))
    throw base::Error(base::Fault::input,
                      "cosine " + std::to_string(cosine) + " of a direction is not in [-1, 1]");
  const Place at = data_->place(depth);
  const bool up = cosine >= 0;
  const double mu = std::max(std::abs(cosine), kSmallestCosine);
  const double total = order_radiance(data_->orders[0], data_->scaled, data_->nodes, data_->options.streams,
                                      mu, up, at, 0.0)[1];
  const double direct = up ? std::exp(-(total_depth() - depth) / mu) : 0.0;
  return {direct, total - direct};
}

int ColumnSolution::azimuth_terms() const { return static_cast<int>(data_->orders.size()); }

ColumnSolution solve_column(const Column& column, const Options& options) {
  check_column(column, options);
  auto data = std::make_shared<ColumnSolution::Data>();
  data->column = column;
  data->options = options;
  data->nodes = gauss_half_range(options.streams / 2);
  data->level_depth.push_back(0);
  std::vector<double> scaled_depth, true_depth;
  for (const Layer& layer : column.layers) {
    data->scaled.push_back(scale_layer(layer, options.streams, options.delta_m));
    scaled_depth.push_back(data->scaled.back().depth);
    true_depth.push_back(layer.optical_depth);
    data->level_depth.push_back(data->level_depth.back() + layer.optical_depth);
  }
  data->beam = beam_through_layers(column, scaled_depth);
  data->true_beam_path = beam_through_layers(column, true_depth);
  solve_orders(*data);
  return ColumnSolution(data);
}

}  // namespace raycube::atmos::solver
