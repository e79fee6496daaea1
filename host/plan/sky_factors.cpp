#include "host/plan/sky_factors.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include <Eigen/Dense>

#include "host/base/parallel.h"
#include "host/base/symmetric_modes.h"
#include "host/base/units.h"

namespace raycube::plan {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Wavelengths that take part in the decomposition; spectra are projected at all of them afterwards.
constexpr std::size_t kDecomposed = 64;
constexpr Index kTogether = 64;  ///< wavelengths whose sky is sampled at once
constexpr int kReweightings = 10, kLimitings = 24;
/// Part of a band's typical light below which its sky takes the mean shape.
constexpr double kUnimportant = 1e-3;
/// A sky fainter than this part of its brightest wavelength has no shape of its own.
constexpr double kFaintest = 1e-9;
/// A sun below 3 degrees of elevation: maps with intervals of 1.5 degrees make the skylight of thin air, which goes
/// with the airmass, 0.7 % too bright, beside which direct sun is nothing any more.
constexpr double kLowSun = base::rad_from_deg(87);
/// The decomposition weighs a direction by cos(zenith) + this: the horizon, which cos alone forgets, lights walls and
/// crowns.
constexpr double kHorizonShare = 0.1;
/// The sky is never brought to its flux by more than this factor: what two rows of a table may contradict each other by
/// before neither means anything. Far below it is told (kAnotherSky).
constexpr double kMostScaled = 2;

/// The axis with intervals no wider than `widest(middle)` (rad).
template <class Widest>
std::vector<double> refine(std::vector<double> axis, Widest widest) {
  std::sort(axis.begin(), axis.end());
  std::vector<double> out;
  for (const double at : axis) {
    if (!out.empty() && at - out.back() < 1e-6) continue;
    if (!out.empty()) {
      const double a = out.back();
      const int n = static_cast<int>(std::ceil((at - a) / widest(0.5 * (a + at)) - 1e-9));
      for (int k = 1; k < n; ++k) out.push_back(a + (at - a) * k / n);
    }
    out.push_back(at);
  }
  return out;
}

/// Radiance at every node of the maps: rows are nodes, columns wavelengths.
MatrixXd sample_sky(const SkyBasis& basis, const TableSpectra& table, double height_m, Sky sky, Index first,
                    Index count) {
  MatrixXd radiance(static_cast<Index>(basis.nodes()), count);
  table.sky_grid(height_m, basis.zenith_rad, basis.azimuth_rad, sky, static_cast<std::size_t>(first),
                 static_cast<std::size_t>(count),
                 std::span(radiance.data(), static_cast<std::size_t>(radiance.size())));
  return radiance;
}

/// work(first, count) for every lot of wavelengths.
template <class Work>
void each_lot(std::size_t wavelengths, int threads, const Work& work) {
  base::for_each_index((wavelengths + kTogether - 1) / kTogether, threads, [&](std::size_t lot) {
    const Index first = static_cast<Index>(lot) * kTogether;
    work(first, std::min(kTogether, static_cast<Index>(wavelengths) - first));
  });
}

MatrixXd sample_sky(const SkyBasis& basis, const TableSpectra& table, double height_m, Sky sky, int threads) {
  if (sky == Sky::thermal)  // which makes whole spectra
    return sample_sky(basis, table, height_m, sky, 0, static_cast<Index>(table.size()));
  MatrixXd radiance(static_cast<Index>(basis.nodes()), static_cast<Index>(table.size()));
  each_lot(table.size(), threads, [&](Index first, Index count) {
    table.sky_grid(height_m, basis.zenith_rad, basis.azimuth_rad, sky, static_cast<std::size_t>(first),
                   static_cast<std::size_t>(count),
                   std::span(radiance.col(first).data(), static_cast<std::size_t>(radiance.rows() * count)));
  });
  return radiance;
}

VectorXd vector_of(const std::vector<double>& v) {
  return Eigen::Map<const VectorXd>(v.data(), static_cast<Index>(v.size()));
}

/// Weights of the decomposition: (cos + horizon share) dOmega / A_0, so that a difference counts relative to the mean
/// sky there. Without the division the dark side of the sky, 10 times fainter than the aureole, is fitted so loosely
/// that truncations go negative.
VectorXd fit_weights(const SkyBasis& basis, const VectorXd& mean) {
  const VectorXd w = vector_of(cosine_weights(basis)) + kHorizonShare * vector_of(solid_angle_weights(basis));
  return w.array() / mean.array().max(1e-6 * mean.maxCoeff());
}

/// Divides each column by its irradiance sum_i q_i L_i; returns the irradiances. Columns too faint become zero.
VectorXd normalise(MatrixXd& radiance, const VectorXd& q) {
  VectorXd irradiance = radiance.transpose() * q;
  const double faintest = kFaintest * irradiance.maxCoeff();
  for (Index l = 0; l < radiance.cols(); ++l) {
    if (irradiance[l] > faintest)
      radiance.col(l) /= irradiance[l];
    else
      radiance.col(l).setZero();
  }
  return irradiance;
}

/// What a sky carries whose maps sum to `irradiance` as sampled: the table's own flux where the table knows that of its
/// sky.
VectorXd flux_of(VectorXd irradiance, const TableSpectra& table, double height_m, Sky sky) {
  if (sky != Sky::solar || !table.knows_flux_of_sky()) return irradiance;
  const Spectrum row = table.diffuse_irradiance(height_m);
  for (Index l = 0; l < irradiance.size(); ++l)
    irradiance[l] *= same_sky_scale(irradiance[l], row[static_cast<std::size_t>(l)]);
  return irradiance;
}

/// What brings a solar sky whose maps sum to `sampled` to the table's own flux, per wavelength.
Spectrum scale_to_flux(const VectorXd& sampled, const TableSpectra& table, double height_m) {
  Spectrum out(table.size(), 1.0);
  if (!table.knows_flux_of_sky()) return out;
  const Spectrum flux = table.diffuse_irradiance(height_m);
  for (std::size_t l = 0; l < out.size(); ++l) out[l] = same_sky_scale(sampled[static_cast<Index>(l)], flux[l]);
  return out;
}

/// Nodes of the maps.
SkyBasis basis_of(const TableSpectra& table, double sun_zenith_rad, Sky sky) {
  SkyBasis basis;
  auto zenith = table.sky_zenith_rad(), azimuth = table.sky_azimuth_rad(sky);
  std::erase_if(zenith, [](double t) { return t <= 0 || t >= base::kPi / 2 - 1e-9; });
  zenith.insert(zenith.end(), {0.0, base::kPi / 2});
  if (sun_zenith_rad < base::kPi / 2) zenith.push_back(sun_zenith_rad);
  std::erase_if(azimuth, [](double f) { return f <= 0 || f >= base::kPi - 1e-9; });
  azimuth.insert(azimuth.end(), {0.0, base::kPi});
  if (sky == Sky::
                 // few nodes, since azimuth says nothing; fine ones keep a limb that brightens as the airmass to 1e-4
      thermal) {
    basis.zenith_rad =
        refine(zenith, [](double t) { return base::rad_from_deg(t > base::rad_from_deg(80) ? 0.25 : 1.0); });
    basis.azimuth_rad = azimuth;
    return basis;
  }
  // finer around the sun, where the aureole bends most, and towards the horizon; finer still where skylight is all
  // there is
  const double finest = base::rad_from_deg(sun_zenith_rad > kLowSun ? 0.75 : 1.5);
  basis.zenith_rad = refine(zenith, [&](double t) {
    return std::abs(t - sun_zenith_rad) < base::rad_from_deg(10) || t > base::rad_from_deg(80) ? finest : 2 * finest;
  });
  basis.azimuth_rad = refine(azimuth, [](double f) {
    return base::rad_from_deg(f < base::rad_from_deg(6) ? 2.0 : f < base::rad_from_deg(30) ? 4.0 : 7.5);
  });
  return basis;
}

/// c_m of every column of the normalised sky (rows m), weighted least squares. Columns of zeros (too faint) get the
/// mean shape.
MatrixXd project(const MatrixXd& shape, const MatrixXd& maps, const VectorXd& weight, int threads = 1) {
  MatrixXd c = MatrixXd::Zero(maps.cols(), shape.cols());
  c.row(0).setOnes();
  if (maps.cols() == 1) return c;
  const auto free = maps.rightCols(maps.cols() - 1);
  const MatrixXd dual = weight.asDiagonal() * free;
  const Eigen::LDLT<MatrixXd> normal(dual.transpose() * free);
  const VectorXd of_mean = dual.transpose() * maps.col(0);
  MatrixXd right(dual.cols(), shape.cols());
  each_lot(static_cast<std::size_t>(shape.cols()), threads, [&](Index first, Index count) {
    for (Index l = first; l < first + count; ++l)  // one by one: a product of matrices packs a copy of all shapes first
      for (Index m = 0; m < dual.cols(); ++m) right(m, l) = dual.col(m).dot(shape.col(l)) - of_mean[m];
  });
  c.bottomRows(dual.cols()) = normal.solve(right);
  for (Index l = 0; l < shape.cols(); ++l)
    if (shape.col(l).isZero(0)) c.col(l).tail(maps.cols() - 1).setZero();
  return c;
}

/// Coefficients with those of the marked columns set to the mean shape.
MatrixXd with_mean_shapes(MatrixXd c, const std::vector<bool>& mean_shape) {
  for (Index l = 0; l < c.cols(); ++l)
    if (mean_shape[static_cast<std::size_t>(l)]) c.col(l).tail(c.rows() - 1).setZero();
  return c;
}

/// Pulls maps 1.. towards zero at the nodes where some mixture is negative, then takes the irradiance they got out
/// again. Returns whether there was anything to do.
bool limit(MatrixXd& maps, const VectorXd& q, const std::vector<Mixture>& mixtures) {
  bool any = false;
  for (Index i = 0; i < maps.rows(); ++i) {
    double lowest = 0;
    for (const auto& mixture : mixtures) {
      double sum = 0;
      for (Index m = 1; m < maps.cols(); ++m) sum += mixture[static_cast<std::size_t>(m)] * maps(i, m);
      lowest = std::min(lowest, sum);
    }
    if (maps(i, 0) + lowest >= 0) continue;
    any = true;
    maps.row(i).tail(maps.cols() - 1) *= 0.95 * maps(i, 0) / -lowest;
  }
  for (Index m = 1; m < maps.cols() && any; ++m) maps.col(m) -= q.dot(maps.col(m)) * maps.col(0);
  return any;
}

/// One decomposition with the columns weighted: A_0 their mean, A_1.. the leading singular vectors of the differences.
MatrixXd decompose(const SkyBasis& basis, const MatrixXd& sample, const VectorXd& column_weight, Index rank) {
  const VectorXd mean = sample * column_weight / column_weight.sum();
  if (rank == 1) return mean;
  const VectorXd root = fit_weights(basis, mean).cwiseSqrt();
  MatrixXd x = root.asDiagonal() * (sample.colwise() - mean);
  x = x * column_weight.cwiseSqrt().asDiagonal();
  // singular vectors from the small Gram matrix: its accuracy, 1e-8 of the largest, is that of the float table
  base::SymmetricModes gram;
  MatrixXd products = MatrixXd::Zero(x.cols(), x.cols());
  products.selfadjointView<Eigen::Lower>().rankUpdate(x.transpose());
  gram.compute(products);
  MatrixXd maps(sample.rows(), 1);
  maps.col(0) = mean;
  const Index n = x.cols();
  for (Index m = 1; m < rank && m <= n; ++m) {
    const double value = gram.eigenvalues()[n - m];
    if (!(value > 1e-13 * column_weight.sum())) break;  // rounding, no shape: the mean itself has norm ~ 1
    maps.conservativeResize(Eigen::NoChange, m + 1);
    maps.col(m) = (x * gram.eigenvectors().col(n - m) / std::sqrt(value)).cwiseQuotient(root);
  }
  return maps;
}

VectorXd occluder_error(const MatrixXd& shape, const MatrixXd& maps, const MatrixXd& c, const VectorXd& q) {
  VectorXd error(shape.cols()), left(shape.rows());
  for (Index l = 0; l < shape.cols(); ++l) {  // column by column: a matrix of differences is 16 MB of fresh pages
    left = shape.col(l);
    for (Index m = 0; m < maps.cols(); ++m) left -= c(m, l) * maps.col(m);
    error[l] = 0.5 * left.cwiseAbs().dot(q);
  }
  return error;
}

void store(SkyBasis& basis, const MatrixXd& maps) {
  basis.value.assign(basis.nodes(), {0, 0, 0, 0});
  for (Index i = 0; i < maps.rows(); ++i)
    for (Index m = 0; m < maps.cols(); ++m)
      basis.value[static_cast<std::size_t>(i)][static_cast<std::size_t>(m)] = maps(i, m);
}

MatrixXd load(const SkyBasis& basis, int rank) {
  MatrixXd maps(static_cast<Index>(basis.nodes()), static_cast<Index>(rank));
  for (Index i = 0; i < maps.rows(); ++i)
    for (Index m = 0; m < maps.cols(); ++m)
      maps(i, m) = basis.value[static_cast<std::size_t>(i)][static_cast<std::size_t>(m)];
  return maps;
}

SkySpectra spectra_of(const VectorXd& irradiance, const MatrixXd& c) {
  SkySpectra out;
  for (auto& spectrum : out) spectrum.assign(static_cast<std::size_t>(irradiance.size()), 0.0);
  for (Index m = 0; m < c.rows(); ++m)
    for (Index l = 0; l < c.cols(); ++l)
      out[static_cast<std::size_t>(m)][static_cast<std::size_t>(l)] = irradiance[l] * c(m, l);
  return out;
}

}  // namespace

struct SkyFactorizer::Data {
  SkyBasis basis;  ///< nodes only
  VectorXd q, irradiance;
  MatrixXd shape;  ///< L / E, [node][wavelength]
  Sky sky = Sky::solar;
  int threads = 0;
  Spectrum irradiance_list, sampled_list;
};

SkyFactorizer::~SkyFactorizer() = default;
bool SkyFactorizer::black() const { return data_->shape.size() == 0; }
const Spectrum& SkyFactorizer::irradiance() const { return data_->irradiance_list; }
const Spectrum& SkyFactorizer::sampled_irradiance() const { return data_->sampled_list; }

SkyFactorizer::SkyFactorizer(const TableSpectra& table, double height_m, double sun_zenith_rad, Sky sky, int threads)
    : data_(std::make_unique<Data>()) {
  data_->irradiance_list.assign(table.size(), 0.0);
  data_->sampled_list = data_->irradiance_list;
  data_->sky = sky, data_->threads = threads;
  if (!table.has_sky(sky)) return;
  data_->basis =
      basis_of(table, sky == Sky::thermal ? base::kPi : sun_zenith_rad, sky);  // the thermal one knows of no sun
  data_->q = vector_of(cosine_weights(data_->basis));
  data_->shape = sample_sky(data_->basis, table, height_m, sky, threads);
  const VectorXd sampled = normalise(data_->shape, data_->q);
  if (!(sampled.maxCoeff() >
        0)) {  // a table with light between ground and air has a sky by name, at night none by light
    data_->shape.resize(0, 0);
    return;
  }
  data_->sampled_list.assign(sampled.data(), sampled.data() + sampled.size());
  data_->irradiance = flux_of(sampled, table, height_m, sky);
  data_->irradiance_list.assign(data_->irradiance.data(), data_->irradiance.data() + data_->irradiance.size());
}

SkyFactors SkyFactorizer::factor(int rank, const Spectrum& importance,
                                 const std::function<std::vector<Mixture>(const SkySpectra&)>& mixtures) const {
  SkyFactors out;
  out.basis = data_->basis;
  out.sky = data_->sky;
  if (black()) return out;
  std::vector<Index> bright;
  for (Index l = 0; l < data_->irradiance.size(); ++l)
    if (data_->irradiance[l] > kFaintest * data_->irradiance.maxCoeff()) bright.push_back(l);
  const std::size_t used = std::min(bright.size(), kDecomposed);
  MatrixXd sample(data_->shape.rows(), static_cast<Index>(used));
  VectorXd matters(static_cast<Index>(used));
  for (std::size_t k = 0; k < used; ++k) {
    const Index l = bright[used > 1 ? k * (bright.size() - 1) / (used - 1) : bright.size() / 2];
    sample.col(static_cast<Index>(k)) = data_->shape.col(l);
    matters[static_cast<Index>(k)] = importance[static_cast<std::size_t>(l)];
  }

  VectorXd column_weight = VectorXd::Ones(matters.size());
  MatrixXd maps;
  double best = std::numeric_limits<double>::infinity();
  for (int round = 0; round < kReweightings; ++round) {
    const MatrixXd tried = decompose(data_->basis, sample, column_weight, rank);
    const MatrixXd c = project(sample, tried, fit_weights(data_->basis, tried.col(0)));
    const VectorXd error = occluder_error(sample, tried, c, data_->q).cwiseProduct(matters);
    if (error.maxCoeff() < best) {
      best = error.maxCoeff();
      maps = tried;
    }
    if (!(best > 1e-7)) break;
    column_weight = column_weight.cwiseProduct((error / error.maxCoeff()).cwiseMax(1e-3));
    column_weight *= static_cast<double>(used) / column_weight.sum();
  }
  const VectorXd weight = fit_weights(data_->basis, maps.col(0));
  // Where the sky is too small a part of the light to matter, its shape is the mean one: never negative, and no band
  // that nobody sees bends the maps of those that are seen. Its error counts like any other.
  for (double part : importance) out.mean_shape.push_back(part < kUnimportant);
  const auto fit = [&] {
    return with_mean_shapes(project(data_->shape, maps, weight, data_->threads), out.mean_shape);
  };
  MatrixXd c = fit();
  for (int round = 0;
       round < kLimitings && maps.cols() > 1 && limit(maps, data_->q, mixtures(spectra_of(data_->irradiance, c)));
       ++round)
    c = fit();
  for (Index m = 1; m < maps.cols(); ++m) {  // largest coefficient 1, which keeps float sums well conditioned
    const double largest = c.row(m).cwiseAbs().maxCoeff();
    if (!(largest > 0)) continue;
    maps.col(m) *= largest;
    c.row(m) /= largest;
  }
  out.rank = static_cast<int>(maps.cols());
  store(out.basis, maps);
  const VectorXd error = occluder_error(data_->shape, maps, c, data_->q);
  out.occluder_error.assign(error.data(), error.data() + error.size());
  for (Index l = 0; l < error.size(); ++l)
    if (data_->shape.col(l).isZero(0)) out.occluder_error[static_cast<std::size_t>(l)] = 0;
  out.spectra = spectra_of(data_->irradiance, c);
  return out;
}

SkySpectra sky_spectra(const SkyFactors& factors, const TableSpectra& table, double height_m, Spectrum* flux_scale,
                       int threads) {
  SkySpectra out;
  for (auto& spectrum : out) spectrum.assign(table.size(), 0.0);
  if (factors.rank == 0) return out;
  const MatrixXd maps = load(factors.basis, factors.rank);
  const VectorXd weight = fit_weights(factors.basis, maps.col(0)), q = vector_of(cosine_weights(factors.basis));
  const Index wavelengths = static_cast<Index>(table.size());
  MatrixXd c(maps.cols(), wavelengths);
  VectorXd sampled(wavelengths);
  each_lot(table.size(), threads, [&](Index first, Index count) {  // all of them are 30 MB of fresh pages
    MatrixXd shape = sample_sky(factors.basis, table, height_m, factors.sky, first, count);
    sampled.segment(first, count) = normalise(shape, q);
    c.middleCols(first, count) = project(shape, maps, weight);
  });
  const double faintest = kFaintest * sampled.maxCoeff();
  for (Index l = 0; l < wavelengths; ++l)
    if (!(sampled[l] > faintest)) c.col(l).tail(c.rows() - 1).setZero();
  if (flux_scale) *flux_scale = scale_to_flux(sampled, table, height_m);
  return spectra_of(flux_of(sampled, table, height_m, factors.sky), with_mean_shapes(std::move(c), factors.mean_shape));
}

double same_sky_scale(double sampled, double flux) {
  return sampled > 0 && flux > 0 ? std::clamp(flux / sampled, 1 / kMostScaled, kMostScaled) : 1;
}

Spectrum sky_flux_scale(const TableSpectra& table, double height_m, double sun_zenith_rad, int threads) {
  if (!table.has_sky()) return Spectrum(table.size(), 1.0);
  const SkyBasis basis = basis_of(table, sun_zenith_rad, Sky::solar);
  const VectorXd q = vector_of(cosine_weights(basis));
  VectorXd sampled(static_cast<Index>(table.size()));
  each_lot(table.size(), threads, [&](Index first, Index count) {
    sampled.segment(first, count) = sample_sky(basis, table, height_m, Sky::solar, first, count).transpose() * q;
  });
  return scale_to_flux(sampled, table, height_m);
}

Spectrum coarse_sky_irradiance(const TableSpectra& table, double height_m, Sky sky) {
  Spectrum out(table.size(), 0.0);
  if (!table.has_sky(sky)) return out;
  SkyBasis grid;
  const auto close = [](std::vector<double> axis, double last) {
    std::erase_if(axis, [last](double a) { return a <= 0 || a >= last; });
    axis.insert(axis.begin(), 0.0);
    axis.push_back(last);
    return axis;
  };
  grid.zenith_rad = close(table.sky_zenith_rad(), base::kPi / 2);
  grid.azimuth_rad = close(table.sky_azimuth_rad(sky), base::kPi);
  const auto q = cosine_weights(grid);
  std::vector<double> radiance(q.size() * out.size());
  table.sky_grid(height_m, grid.zenith_rad, grid.azimuth_rad, sky, radiance);
  for (std::size_t k = 0; k < out.size(); ++k)
    for (std::size_t i = 0; i < q.size(); ++i) out[k] += q[i] * radiance[k * q.size() + i];
  return out;
}

}  // namespace raycube::plan
