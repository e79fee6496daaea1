// One layer, one azimuth order: the discrete-ordinate equations solved exactly, without a growing exponential
// and without a singular point.
//
// Radiances at the nodes are carried as sqrt(w mu) I, which makes every operator symmetric (Nakajima & Tanaka
// 1986, JQSRT 35, 13). With s = up + down, d = up - down, u the scaled optical depth below the layer's top
// and q = sqrt(w/mu) times the source:
//   s' = E+ d - (q_up - q_down)
//   d' = E- s - (q_up + q_down)
//   E- = M^-1/2 (1 - omega W^1/2 De W^1/2) M^-1/2, and E+ the same with Do;
//   De, Do: the terms of even and of odd l - m in sum (2l+1) chi_l Lambda_l^m(mu) Lambda_l^m(mu').
// With E+ = L L^T, L^T E- L = Y k^2 Y^T, X = L Y, Z = X^-T, s = X sigma, d = Z delta:
//   sigma' = delta - Z^T (q_up - q_down)
//   delta' = k^2 sigma - X^T (q_up + q_down)
// The modes are decoupled pairs, regular at k = 0 (conservative scattering: sigma linear, delta constant).
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "atmos_tables/solver/beam_path.h"
#include "atmos_tables/solver/delta_m.h"
#include "atmos_tables/solver/quadrature.h"

namespace raycube::atmos::solver {

/// Modal amplitudes at one depth.
struct ModalField {
  Eigen::VectorXd sigma, delta;
};

/// Below k * depth of this the mode is linear in depth; its relative error, (k depth)^2 / 6, and that of the
/// exponential form, 1e-16 / (k depth), are then both near 1e-11.
inline constexpr double kLinearMode = 1e-5;

/// The layer's modes, its operators, and its particular solutions.
struct LayerMode {
  Eigen::MatrixXd x, z;               ///< N x N, see above
  Eigen::VectorXd k;                  ///< eigenvalues, >= 0
  double depth = 0;                   ///< scaled optical depth
  Eigen::MatrixXd reflect, transmit;  ///< N x N, of sqrt(w mu) I, same from both sides; reflect is symmetric
  double beam_slope = 1;              ///< slant per vertical depth
  /// Beam: sigma = -g D(u), delta = g (k D - e) + p e, with e = exp(-slope u), D = (exp(-k u) - e) / (slope -
  /// k).
  Eigen::VectorXd beam_source;              ///< g; empty = no beam
  Eigen::VectorXd beam_odd;                 ///< p
  Eigen::VectorXd thermal;                  ///< gamma: sigma = gamma B, delta = gamma B'; empty = none
  double planck_top = 0, planck_slope = 0;  ///< B = planck_top + planck_slope u
};

/// What the column says about a layer's sources in this order.
struct LayerSources {
  double beam_strength = 0;  ///< flux (2 - delta_m0) / (4 pi) times the transmittance to the layer's top
  double beam_slope = 1;
  double planck_top = 0, planck_bottom = 0;  ///< used in order 0 only
};

/// Associated Legendre functions of one order at the nodes and at the beam, degrees order ... streams - 1.
struct OrderBasis {
  int order = 0;
  Eigen::MatrixXd node;  ///< rows: degrees, columns: nodes
  Eigen::VectorXd beam;
};
OrderBasis order_basis(int order, int streams, const HalfRange& nodes, double beam_cosine);

LayerMode solve_layer(const ScaledLayer& layer, const LayerSources& sources, const OrderBasis& basis,
                      const HalfRange& nodes);

/// Particular solution at scaled depth u below the top, 0 <= u <= depth.
ModalField particular_field(const LayerMode& mode, double u);

/// sqrt(w mu) I that leaves the layer through its top and its bottom when nothing but its own sources lights
/// it.
struct LayerEmission {
  Eigen::VectorXd up, down;
};
LayerEmission layer_emission(const LayerMode& mode);

/// Amplitudes of the homogeneous solution: `even` is its sigma, `odd` its delta, each the mean of top and
/// bottom.
struct Amplitudes {
  Eigen::VectorXd even, odd;
};
/// From the radiances at the layer's two faces; particular: subtract the layer's own sources first.
Amplitudes homogeneous_amplitudes(const LayerMode& mode, const Eigen::VectorXd& up_top,
                                  const Eigen::VectorXd& down_top, const Eigen::VectorXd& up_bottom,
                                  const Eigen::VectorXd& down_bottom, bool particular);

/// Homogeneous solution at u.
ModalField homogeneous_field(const LayerMode& mode, const Amplitudes& amplitudes, double u);

}  // namespace raycube::atmos::solver
