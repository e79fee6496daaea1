#include "atmos_tables/solver/solution.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "atmos_tables/solver/beam_scatter.h"
#include "atmos_tables/solver/order_solver.h"
#include "atmos_tables/solver/user_radiance.h"
#include "host/base/error.h"
#include "host/base/units.h"

namespace raycube::atmos::solver {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {
constexpr double kSmallestCosine = 1e-9;
/// Thinner layers are taken isothermal: B' would reach B / 1e-5 and cost the digits it gains.
constexpr double kThinEmission = 1e-5;

LinearPlanck linear_emission(double top, double bottom, double depth) {
  if (depth < kThinEmission) return {0.5 * (top + bottom), 0};
  return {top, (bottom - top) / depth};
}
}  // namespace

struct ColumnSolution::Data {
  Column column;
  Options options;
  ScaledColumn scaled;
  std::vector<BeamLayer> true_beam_path;  ///< along the true depth
  std::vector<double> level_depth;        ///< true
  std::vector<OrderSolution> orders;

  Place place(double depth) const;
  std::vector<Place> places(const std::vector<double>& depths) const;
  std::array<double, 2> case_flux(const Place& place, bool up) const;
  Fluxes own_fluxes(const Place& place) const;  ///< over a black, cold ground
  GroundCoupling coupling() const;
  double ground_radiance(const Ground& ground) const;
};

namespace {

using Data = ColumnSolution::Data;

/// Does any layer scatter in this azimuth order?
bool order_is_lit(const Data& data, int order) {
  if (data.column.beam.flux <= 0 || data.column.beam.cosine >= 1) return false;
  for (const ScaledLayer& layer : data.scaled.layers)
    for (std::size_t l = static_cast<std::size_t>(order); l < layer.moment.size(); ++l)
      if (layer.albedo > 0 && layer.moment[l] != 0) return true;
  return false;
}

void solve_orders(Data& data) {
  data.orders.push_back(solve_order(data.scaled, 0));
  const double limit = data.options.fourier_tolerance * data.orders[0].largest_radiance;
  int small = 0;
  for (int order = 1; order < data.options.streams && order_is_lit(data, order) && small < 2; ++order) {
    data.orders.push_back(solve_order(data.scaled, order));
    small = data.orders.back().largest_radiance <= limit ? small + 1 : 0;
  }
}

/// Directions of a sweep that travel to one side, and where they stand in the caller's list.
struct Side {
  bool up = true;
  std::vector<double> cosine;
  std::vector<std::size_t> index;
};

std::array<Side, 2> split_sides(const std::vector<double>& cosines) {
  std::array<Side, 2> sides;
  sides[1].up = false;
  for (std::size_t i = 0; i < cosines.size(); ++i) {
    if (!(std::abs(cosines[i]) <= 1))
      throw base::Error(base::Fault::input,
                        "cosine " + std::to_string(cosines[i]) + " of a direction is not in [-1, 1]");
    Side& side = sides[cosines[i] >= 0 ? 0 : 1];
    side.cosine.push_back(std::max(std::abs(cosines[i]), kSmallestCosine));
    side.index.push_back(i);
  }
  return sides;
}

/// Diffuse radiance along the rays of one side, added to its place in `radiance` [place][cosine][azimuth].
void add_side(const Data& data, const Side& side, const std::vector<Place>& places, double ground_radiance,
              const std::vector<double>& turn_deg, std::size_t cosines, std::vector<double>& radiance) {
  const Column& column = data.column;
  const Rays rays = make_rays(data.scaled, side.up, side.cosine);
  const bool exact = data.options.intensity_correction;
  const auto at = [&](std::size_t p, std::size_t r) {
    return &radiance[(p * cosines + side.index[r]) * turn_deg.size()];
  };
  std::vector<double> turn(turn_deg.size());
  for (const OrderSolution& order : data.orders) {
    for (std::size_t a = 0; a < turn.size(); ++a) turn[a] = std::cos(base::rad_from_deg(order.order) * turn_deg[a]);
    const OrderRadiance term = order_radiance(data.scaled, order, rays, places);
    for (std::size_t p = 0; p < places.size(); ++p)
      for (std::size_t r = 0; r < side.index.size(); ++r) {
        const auto row = static_cast<Eigen::Index>(r), col = static_cast<Eigen::Index>(p);
        const double own = term.own(row, col);
        const double from_ground = order.order == 0 ? ground_radiance * term.from_ground(row, col) : 0;
        double* out = at(p, r);
        for (std::size_t a = 0; a < turn.size(); ++a) out[a] += own * turn[a] + from_ground;
      }
  }
  if (column.beam.flux <= 0) return;
  const std::vector<MatrixXd> weights = scatter_once(column, data.scaled, rays, places, exact);
  const OnceScattered once(column, data.scaled, exact, weights);
  std::vector<Aureole> aureoles;
  if (exact && !side.up)
    for (const Place& place : places) aureoles.emplace_back(column, data.scaled, place);
  VectorXd first(static_cast<Eigen::Index>(places.size()));
  for (std::size_t r = 0; r < side.index.size(); ++r) {
    const double mu = side.cosine[r];
    const double sines =
        std::sqrt(std::max(0.0, (1 - mu) * (1 + mu) * (1 - column.beam.cosine) * (1 + column.beam.cosine)));
    for (std::size_t a = 0; a < turn_deg.size(); ++a) {
      const double cos_angle = std::clamp(
          (side.up ? -mu : mu) * column.beam.cosine + sines * std::cos(base::rad_from_deg(turn_deg[a])), -1.0, 1.0);
      first.setZero();
      once.add(static_cast<Eigen::Index>(r), cos_angle, first);
      for (std::size_t p = 0; p < places.size(); ++p) {
        at(p, r)[a] += first(static_cast<Eigen::Index>(p));
        if (!aureoles.empty()) at(p, r)[a] -= aureoles[p].excess(mu, cos_angle);
      }
    }
  }
}

}  // namespace

Place ColumnSolution::Data::place(double depth) const {
  const double total = level_depth.back();
  if (!(depth >= -1e-9 * total && depth <= total * (1 + 1e-9)))
    throw base::Error(base::Fault::input, "optical depth " + std::to_string(depth) +
                                              " is outside the column: it has 0 to " + std::to_string(total) +
                                              "; ask for a depth inside it");
  const std::vector<ScaledLayer>& layers = scaled.layers;
  if (layers.empty()) return {};
  // First level at or below the depth; the layer is the one above it, so a boundary is the bottom of a layer.
  const auto below = std::lower_bound(level_depth.begin() + 1, level_depth.end() - 1, depth);
  const auto layer = static_cast<std::size_t>(below - level_depth.begin()) - 1;
  const double true_depth = layers[layer].true_depth, part = depth - level_depth[layer];
  if (depth >= level_depth[layer + 1]) return {layer, layers[layer].depth};
  if (part <= 0 || true_depth <= 0) return {layer, 0};
  return {layer, std::min(1.0, part / true_depth) * layers[layer].depth};
}

std::vector<Place> ColumnSolution::Data::places(const std::vector<double>& depths) const {
  std::vector<Place> out;
  for (double depth : depths) out.push_back(place(depth));
  return out;
}

/// Diffuse flux of both cases (of the scaled problem); exact level values at the layers' faces.
std::array<double, 2> ColumnSolution::Data::case_flux(const Place& at, bool up) const {
  const auto count = static_cast<Eigen::Index>(scaled.nodes.cosine.size());
  const Eigen::Map<const VectorXd> mu(scaled.nodes.cosine.data(), count), weight(scaled.nodes.weight.data(), count);
  const std::vector<ScaledLayer>& layers = scaled.layers;
  const bool at_bottom = !layers.empty() && at.u >= layers[at.layer].depth;
  if (!layers.empty() && !at_bottom && at.u > 0) {
    const InnerFlux inner = inner_flux(scaled, orders[0], at.layer, at.u);
    return up ? inner.up : inner.down;
  }
  const VectorXd flux_root = (weight.array() * mu.array()).sqrt();
  const std::array<MatrixXd, 2>& side = up ? orders[0].up : orders[0].down;
  const auto level = static_cast<Eigen::Index>(at.layer + (at_bottom ? 1 : 0));
  return {2 * base::kPi * flux_root.dot(side[0].col(level)), 2 * base::kPi * flux_root.dot(side[1].col(level))};
}

Fluxes ColumnSolution::Data::own_fluxes(const Place& at) const {
  const double beam_flux = column.beam.flux * column.beam.cosine;
  double true_beam = beam_flux, scaled_beam = beam_flux;
  if (!scaled.layers.empty()) {
    const ScaledLayer& layer = scaled.layers[at.layer];
    const BeamLayer &true_path = true_beam_path[at.layer], &path = scaled.beam[at.layer];
    const double true_u = layer.depth > 0 ? at.u / layer.depth * layer.true_depth : 0;
    true_beam *= true_path.top * std::exp(-true_path.slope * true_u);
    scaled_beam *= path.top * std::exp(-path.slope * at.u);
  }
  // What delta-M counts as beam although it was scattered forward is diffuse light (S4.6).
  return {true_beam, case_flux(at, false)[0] + (scaled_beam - true_beam), case_flux(at, true)[0]};
}

GroundCoupling ColumnSolution::Data::coupling() const {
  const Place at = place(level_depth.back());
  const Fluxes own = own_fluxes(at);
  return {own.direct_down, own.diffuse_down, case_flux(at, false)[1] / base::kPi};
}

double ColumnSolution::Data::ground_radiance(const Ground& ground) const {
  const GroundCoupling air = coupling();
  return (ground.albedo * (air.direct_irradiance + air.diffuse_irradiance) / base::kPi +
          (1 - ground.albedo) * ground.planck) /
         (1 - ground.albedo * air.spherical_albedo);
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

std::vector<double> ColumnSolution::radiances(const std::vector<double>& depths, const std::vector<double>& cosines,
                                              const std::vector<double>& azimuth_deg, const Ground& ground) const {
  check_ground(ground);
  const std::vector<Place> places = data_->places(depths);
  std::vector<double> radiance(depths.size() * cosines.size() * azimuth_deg.size(), 0.0), turn_deg;
  for (double azimuth : azimuth_deg) turn_deg.push_back(azimuth - data_->column.beam.azimuth_deg);
  const double from_ground = data_->ground_radiance(ground);
  for (const Side& side : split_sides(cosines))
    if (!side.index.empty()) add_side(*data_, side, places, from_ground, turn_deg, cosines.size(), radiance);
  return radiance;
}

std::vector<double> ColumnSolution::radiances(double depth, double cosine, const std::vector<double>& azimuth_deg,
                                              const Ground& ground) const {
  return radiances(std::vector<double>{depth}, {cosine}, azimuth_deg, ground);
}

double ColumnSolution::radiance(double depth, double cosine, double azimuth_deg, const Ground& ground) const {
  return radiances(depth, cosine, {azimuth_deg}, ground).front();
}

double ColumnSolution::path_radiance(double depth, double cosine, double azimuth_deg) const {
  return radiance(depth, cosine, azimuth_deg, Ground{});
}

GroundCoupling ColumnSolution::ground_coupling() const { return data_->coupling(); }

std::vector<GroundTransmission> ColumnSolution::ground_transmissions(const std::vector<double>& depths,
                                                                     const std::vector<double>& cosines) const {
  const std::vector<Place> places = data_->places(depths);
  std::vector<GroundTransmission> out(depths.size() * cosines.size());
  for (const Side& side : split_sides(cosines)) {
    if (side.index.empty()) continue;
    const Rays rays = make_rays(data_->scaled, side.up, side.cosine);
    const MatrixXd total = order_radiance(data_->scaled, data_->orders[0], rays, places).from_ground;
    for (std::size_t p = 0; p < places.size(); ++p)
      for (std::size_t r = 0; r < side.index.size(); ++r) {
        const double direct = side.up ? std::exp(-(total_depth() - depths[p]) / side.cosine[r]) : 0.0;
        out[p * cosines.size() + side.index[r]] = {
            direct, total(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(p)) - direct};
      }
  }
  return out;
}

GroundTransmission ColumnSolution::ground_transmission(double depth, double cosine) const {
  return ground_transmissions({depth}, {cosine}).front();
}

int ColumnSolution::azimuth_terms() const { return static_cast<int>(data_->orders.size()); }

ColumnSolution solve_column(const Column& column, const Options& options) {
  check_column(column, options);
  auto data = std::make_shared<ColumnSolution::Data>();
  data->column = column;
  data->options = options;
  data->level_depth.push_back(0);
  ScaledColumn& scaled = data->scaled;
  scaled.streams = options.streams;
  scaled.nodes = gauss_half_range(options.streams / 2);
  scaled.beam_flux = column.beam.flux;
  scaled.beam_cosine = column.beam.cosine;
  scaled.top_radiance = column.top_radiance;
  std::vector<double> scaled_depth, true_depth;
  for (const Layer& layer : column.layers) {
    scaled.layers.push_back(scale_layer(layer, options.streams, options.delta_m));
    scaled_depth.push_back(scaled.layers.back().depth);
    true_depth.push_back(layer.optical_depth);
    data->level_depth.push_back(data->level_depth.back() + layer.optical_depth);
  }
  scaled.beam = beam_through_layers(column, scaled_depth);
  data->true_beam_path = beam_through_layers(column, true_depth);
  if (std::any_of(column.planck.begin(), column.planck.end(), [](double planck) { return planck > 0; }))
    for (std::size_t i = 0; i < scaled_depth.size(); ++i)
      scaled.emission.push_back(linear_emission(column.planck[i], column.planck[i + 1], scaled_depth[i]));
  solve_orders(*data);
  return ColumnSolution(data);
}

}  // namespace raycube::atmos::solver
