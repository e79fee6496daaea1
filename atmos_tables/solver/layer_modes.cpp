#include "atmos_tables/solver/layer_modes.h"

#include <cmath>

#include "atmos_tables/solver/exp_differences.h"
#include "atmos_tables/solver/legendre.h"

namespace raycube::atmos::solver {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Thinner layers are taken isothermal: B' would reach B / 1e-5 and cost the digits it gains.
constexpr double kThinEmission = 1e-5;

/// (2l+1) chi_l for degrees of one parity of l - order, 0 for the other.
VectorXd moments_of_parity(const ScaledLayer& layer, const OrderBasis& basis, int parity) {
  VectorXd weight = VectorXd::Zero(basis.node.rows());
  for (Eigen::Index i = parity; i < weight.size(); i += 2) {
    const auto degree = static_cast<std::size_t>(basis.order + i);
    weight(i) = (2 * static_cast<double>(degree) + 1) * layer.moment[degree];
  }
  return weight;
}

/// L with E+ = L L^T. Rounding, or moments no positive phase function has, can leave E+ indefinite: then its
/// eigenvalues are floored so that the solution stays finite.
MatrixXd square_root(const MatrixXd& symmetric) {
  const Eigen::LLT<MatrixXd> factor(symmetric);
  if (factor.info() == Eigen::Success) return factor.matrixL();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(symmetric);
  const VectorXd value = eigen.eigenvalues();
  const double floor = 1e-12 * value.cwiseAbs().maxCoeff();
  return eigen.eigenvectors() * value.cwiseMax(floor).cwiseSqrt().asDiagonal();
}

/// Eigenvalues and modes of E+ E-.
void solve_modes(LayerMode& mode, const MatrixXd& even, const MatrixXd& odd, bool conservative) {
  const MatrixXd root = square_root(odd);
  const MatrixXd product = root.transpose() * even * root;
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(0.5 * (product + product.transpose()));
  VectorXd square = eigen.eigenvalues().cwiseMax(0.0);
  // Conservative scattering keeps energy: one eigenvalue is 0, and rounding (1e-16 of the largest, 1/mu_1^2)
  // must not say otherwise.
  if (conservative) square(0) = 0;
  mode.k = square.cwiseSqrt();
  mode.x = root * eigen.eigenvectors();
  // X^-T = L^-T Y
  mode.z = root.transpose().partialPivLu().solve(eigen.eigenvectors());
}

/// reflect + transmit = (1-G)(1+G)^-1 and reflect - transmit = (H-1)(H+1)^-1, G = Z k tanh(k d/2) Z^T, H = X
/// tanh(k d/2)/k X^T: the responses to equal and to opposite light on the two faces. Both are contractions,
/// at every depth.
void solve_operators(LayerMode& mode) {
  const Eigen::Index count = mode.k.size();
  VectorXd even(count), odd(count);
  for (Eigen::Index j = 0; j < count; ++j) {
    const double half = 0.5 * mode.k(j) * mode.depth, tanh_half = std::tanh(half);
    even(j) = mode.k(j) * tanh_half;
    odd(j) = half < 1e-8 ? 0.5 * mode.depth : tanh_half / mode.k(j);
  }
  const MatrixXd one = MatrixXd::Identity(count, count);
  const MatrixXd equal =
      Eigen::LLT<MatrixXd>(one + mode.z * even.asDiagonal() * mode.z.transpose()).solve(one);
  const MatrixXd opposite =
      Eigen::LLT<MatrixXd>(one + mode.x * odd.asDiagonal() * mode.x.transpose()).solve(one);
  mode.reflect = equal - opposite;
  mode.transmit = equal + opposite - one;
}

}  // namespace

OrderBasis order_basis(int order, int streams, const HalfRange& nodes, double beam_cosine) {
  const Eigen::Index degrees = streams - order;
  OrderBasis basis{order, MatrixXd(degrees, static_cast<Eigen::Index>(nodes.cosine.size())),
                   VectorXd(degrees)};
  const auto column = [&](double cosine) -> VectorXd {
    const std::vector<double> value = normalized_legendre(order, streams, cosine);
    return Eigen::Map<const VectorXd>(value.data(), degrees);
  };
  for (std::size_t i = 0; i < nodes.cosine.size(); ++i)
    basis.node.col(static_cast<Eigen::Index>(i)) = column(nodes.cosine[i]);
  basis.beam = column(beam_cosine);
  return basis;
}

LayerMode solve_layer(const ScaledLayer& layer, const LayerSources& sources, const OrderBasis& basis,
                      const HalfRange& nodes) {
  const auto count = static_cast<Eigen::Index>(nodes.cosine.size());
  const Eigen::Map<const VectorXd> mu(nodes.cosine.data(), count), weight(nodes.weight.data(), count);
  const VectorXd ratio = (weight.array() / mu.array()).sqrt(),
                 flux_root = (weight.array() * mu.array()).sqrt();
  const VectorXd even_moment = moments_of_parity(layer, basis, 0),
                 odd_moment = moments_of_parity(layer, basis, 1);
  const MatrixXd scaled_node = basis.node * ratio.asDiagonal();
  const MatrixXd inverse = mu.cwiseInverse().asDiagonal();

  LayerMode mode;
  mode.depth = layer.depth;
  const MatrixXd even =
      inverse - layer.albedo * scaled_node.transpose() * even_moment.asDiagonal() * scaled_node;
  const MatrixXd odd =
      inverse - layer.albedo * scaled_node.transpose() * odd_moment.asDiagonal() * scaled_node;
  solve_modes(mode, even, odd, basis.order == 0 && layer.albedo >= 1);
  solve_operators(mode);

  if (sources.beam_strength > 0) {
    mode.beam_slope = sources.beam_slope;
    const double strength = 2 * layer.albedo * sources.beam_strength;
    // The beam travels down: Lambda_l^m(-mu0) = (-1)^(l+m) Lambda_l^m(mu0), so the odd terms change sign.
    const VectorXd sum = strength * (scaled_node.transpose() * even_moment.cwiseProduct(basis.beam));
    const VectorXd difference = -strength * (scaled_node.transpose() * odd_moment.cwiseProduct(basis.beam));
    mode.beam_odd = mode.z.transpose() * difference;
    const VectorXd even_source = mode.x.transpose() * sum;
    mode.beam_source =
        ((mode.beam_slope * mode.beam_odd - even_source).array() / (mode.k.array() + mode.beam_slope))
            .matrix();
  }
  if (basis.order == 0 && (sources.planck_top > 0 || sources.planck_bottom > 0)) {
    // Radiance equal to B in every direction solves the equations for any albedo; a slope adds d = 2 B' E+^-1
    // sqrt(w mu).
    mode.thermal = 2 * (mode.z.transpose() * flux_root);
    const bool thin = layer.depth < kThinEmission;
    mode.planck_top = thin ? 0.5 * (sources.planck_top + sources.planck_bottom) : sources.planck_top;
    mode.planck_slope = thin ? 0 : (sources.planck_bottom - sources.planck_top) / layer.depth;
  }
  return mode;
}

ModalField particular_field(const LayerMode& mode, double u) {
  const Eigen::Index count = mode.k.size();
  ModalField field{VectorXd::Zero(count), VectorXd::Zero(count)};
  if (mode.beam_source.size() > 0) {
    const double fade = std::exp(-mode.beam_slope * u);
    for (Eigen::Index j = 0; j < count; ++j) {
      const double difference =
          u * exp_difference(mode.k(j) * u, mode.beam_slope * u);  // (e^-ku - e^-slope u)/(slope - k)
      field.sigma(j) = -mode.beam_source(j) * difference;
      field.delta(j) = mode.beam_source(j) * (mode.k(j) * difference - fade) + mode.beam_odd(j) * fade;
    }
  }
  if (mode.thermal.size() > 0) {
    field.sigma += mode.thermal * (mode.planck_top + mode.planck_slope * u);
    field.delta += mode.thermal * mode.planck_slope;
  }
  return field;
}

LayerEmission layer_emission(const LayerMode& mode) {
  const ModalField top = particular_field(mode, 0), bottom = particular_field(mode, mode.depth);
  const VectorXd s_top = mode.x * top.sigma, d_top = mode.z * top.delta;
  const VectorXd s_bottom = mode.x * bottom.sigma, d_bottom = mode.z * bottom.delta;
  // The homogeneous solution must take away the light that the particular one lets in.
  const VectorXd in_top = 0.5 * (s_top - d_top), in_bottom = 0.5 * (s_bottom + d_bottom);
  return {0.5 * (s_top + d_top) - mode.reflect * in_top - mode.transmit * in_bottom,
          0.5 * (s_bottom - d_bottom) - mode.transmit * in_top - mode.reflect * in_bottom};
}

Amplitudes homogeneous_amplitudes(const LayerMode& mode, const VectorXd& up_top, const VectorXd& down_top,
                                  const VectorXd& up_bottom, const VectorXd& down_bottom, bool particular) {
  Amplitudes amplitudes{0.5 * (mode.z.transpose() * (up_top + down_top + up_bottom + down_bottom)),
                        0.5 * (mode.x.transpose() * (up_top - down_top + up_bottom - down_bottom))};
  if (particular) {
    const ModalField top = particular_field(mode, 0), bottom = particular_field(mode, mode.depth);
    amplitudes.even -= 0.5 * (top.sigma + bottom.sigma);
    amplitudes.odd -= 0.5 * (top.delta + bottom.delta);
  }
  return amplitudes;
}

ModalField homogeneous_field(const LayerMode& mode, const Amplitudes& amplitudes, double u) {
  const Eigen::Index count = mode.k.size();
  ModalField field{VectorXd(count), VectorXd(count)};
  for (Eigen::Index j = 0; j < count; ++j) {
    const double k = mode.k(j);
    // cosh(k t)/cosh(k d/2) and sinh(k t)/(k cosh(k d/2)) with t = u - d/2, by falling exponentials only.
    double even = 1, odd = u - 0.5 * mode.depth;
    if (k * mode.depth >= kLinearMode) {
      const double from_top = std::exp(-k * u), from_bottom = std::exp(-k * (mode.depth - u));
      const double norm = 1 + std::exp(-k * mode.depth);
      even = (from_top + from_bottom) / norm;
      odd = (from_bottom - from_top) / (k * norm);
    }
    field.sigma(j) = amplitudes.even(j) * even + amplitudes.odd(j) * odd;
    field.delta(j) = amplitudes.even(j) * k * k * odd + amplitudes.odd(j) * even;
  }
  return field;
}

}  // namespace raycube::atmos::solver
