// One azimuth order of a solved column, as numbers: what is needed to find its light at any depth and
// direction.
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
#include <array>
#include <vector>

#include "atmos_tables/solver/beam_path.h"
#include "atmos_tables/solver/column.h"
#include "atmos_tables/solver/delta_m.h"
#include "atmos_tables/solver/quadrature.h"

namespace raycube::atmos::solver {

/// Below k * depth of this the mode is linear in depth; its relative error, (k depth)^2 / 6, and that of the
/// exponential form, 1e-16 / (k depth), are then both near 1e-11.
inline constexpr double kLinearMode = 1e-5;

/// Planck radiance in a layer: top + slope * u.
struct LinearPlanck {
  double top = 0, slope = 0;
};

/// The column as every order sees it.
struct ScaledColumn {
  HalfRange nodes;
  int streams = 16;
  std::vector<ScaledLayer> layers;
  std::vector<BeamLayer> beam;  ///< along the scaled depth
  double beam_flux = 0, beam_cosine = 1;
  std::vector<LinearPlanck> emission;  ///< empty: none
  double top_radiance = 0;
};

/// Cases: 0 the column's own light over a black, cold ground; 1 (order 0 only) unit isotropic radiance from
/// the ground and no other source. Matrices have a row per mode or node and a column per layer (or level).
struct OrderSolution {
  int order = 0;
  int cases = 1;
  Eigen::MatrixXd k;      ///< eigenvalues, >= 0
  Eigen::MatrixXd decay;  ///< exp(-k depth)
  /// Beam: sigma = -g D(u), delta = g (k D - e) + p e, with e = exp(-slope u), D = (exp(-k u) - e) / (slope -
  /// k). g, p, and exp_difference(k depth, slope depth). Without columns where no beam falls.
  Eigen::MatrixXd beam_source, beam_odd, beam_pair;
  /// Emission: sigma = thermal B, delta = thermal B'. Without columns where nothing emits.
  Eigen::MatrixXd thermal;
  /// Amplitudes of the homogeneous solution: `even` is its sigma, `odd` its delta, each the mean of top and
  /// bottom. [case]
  std::array<Eigen::MatrixXd, 2> even, odd;
  /// Source function J(direction) = (row_even Lambda_even) . sigma +- (row_odd Lambda_odd) . delta, + upward:
  /// Lambda_even the Legendre functions of the direction's |cosine| with even l - m, ascending, padded to the
  /// number of nodes. Blocks of nodes x nodes, one per layer.
  Eigen::MatrixXd row_even, row_odd;
  std::vector<char> scatters;  ///< [layer] 0: no light is scattered in this order
  /// Order 0 only: X and Z, blocks as above, and sqrt(w mu) I at every level. [case]
  Eigen::MatrixXd x, z;
  std::array<Eigen::MatrixXd, 2> up, down;
  double largest_radiance = 0;  ///< of case 0, at a node and a level

  bool has_beam() const { return beam_source.cols() > 0; }
  bool emits() const { return thermal.cols() > 0; }
};

/// Legendre functions of one order at one direction, split by parity of l - m and padded with zeros.
struct ParityBasis {
  Eigen::VectorXd even, odd;
};
ParityBasis parity_basis(int order, int streams, double cosine);

/// Diffuse flux up and down inside a layer at scaled depth u below its top, of both cases of order 0.
struct InnerFlux {
  std::array<double, 2> up{}, down{};
};
InnerFlux inner_flux(const ScaledColumn& column, const OrderSolution& first, std::size_t layer, double u);

}  // namespace raycube::atmos::solver
