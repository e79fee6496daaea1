#include "host/plan/bounces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include <Eigen/Dense>
#include <fmt/format.h>

#include "host/plan/curve.h"
#include "host/plan/irradiance_map.h"
#include "kernels/sampling/sampler.h"
#include "kernels/shared/tile_layout.h"
#include "scene_compiler/matter.h"
#include "scene_compiler/shape_energy.h"
#include "scene_compiler/shape_list.h"
#include "scene_compiler/spectral_shape.h"

namespace raycube::plan {

namespace {

using Curves = std::vector<std::vector<double>>;  ///< [curve][grid]

constexpr int kMostFactors = 8;            ///< of a product that the skeleton is fitted to
constexpr std::size_t kRowsOfACurve = 24;  ///< that judge
constexpr std::size_t kMostRows = 600;     ///< that judge or train
constexpr std::size_t kMostWavelengths = 128, kStep = 16;
constexpr double kNothingLeft = 1e-12;  ///< of the largest column: rounding of what has been taken out
constexpr double kMostSeen = 4;         ///< light at a place over that of the bands there, so far counted
constexpr std::uint32_t kTraining = 61, kJudging = 62;

/// Of matter that is a sum of lobes, what light may be multiplied by: of shapes that change with wavelength each lobe's
/// curve; of those that go by the curve's value, and of a gloss by Fresnel's law, whose lobes' curves change their
/// signs, what leaves in all of light from some angles.
Curves lobe_factors(const Plan& plan, const scene::Material& material) {
  Curves out;
  const auto add = [&](const std::vector<scene::ShapeAndCurve>& parts, auto&& factor_of) {
    auto& sum = out.emplace_back(plan.wavelength_um.size(), 0.0);
    for (const auto& part : parts) {
      const std::vector<double> curve = sample_curve(material, part.curve, plan.wavelength_um);
      const double factor = factor_of(part.shape);
      for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += factor * curve[i];
    }
    for (double& value : sum) value = std::max(0.0, value);
  };
  const auto front = scene::front_parts(material), gloss = scene::gloss_parts(material);
  const bool by_values = scene::shape_entry(material.front.number).curve_parameter >= 0;
  if (by_values)
    for (const double zenith_rad : {0.2, 0.9, 1.3})
      add(front, [&](const scene::Shape& shape) { return scene::black_sky_albedo(shape, zenith_rad); });
  if (!material.index_n.value.empty())
    for (const double cosine : {1.0, 0.5, 0.25, 0.1})
      add(gloss,
          [&](const scene::Shape& shape) { return rc_shape_mirrored(shape.number, shape.parameters(), cosine); });
  const auto one = [](const scene::Shape&) { return 1.0; };
  if (!material.front_nodes.empty() && !by_values)
    for (const auto& part : front) add({part}, one);
  if (!material.gloss_nodes.empty())
    for (const auto& part : gloss) add({part}, one);
  return out;
}

/// Every curve that light may be multiplied by, on the grid: reflectances, transmittances of leaves and plates, sums of
/// both, and 1, a gloss's; none of what is black.
Curves factors_of(const Plan& plan, const scene::CompiledScene& scene) {
  Curves out, shares;  // the latter of shapes that change with wavelength
  for (const auto number : scene::used_materials(scene)) {
    const scene::Material& material = scene.materials[number];
    out.push_back(sample_reflectance(material, plan.wavelength_um));
    for (auto& share : lobe_factors(plan, material)) shares.push_back(std::move(share));
    if (!scene::lets_light_through(material) && !scene::is_plate(material)) continue;
    const std::size_t reflectance = out.size() - 1;
    out.push_back(sample_curve(material, material.transmittance, plan.wavelength_um));
    out.push_back(out[reflectance]);
    for (std::size_t i = 0; i < plan.wavelength_um.size(); ++i) out.back()[i] += out[reflectance + 1][i];
  }
  // Of what a gloss mirrors there is a curve less.
  if (plan.matter.glossy) out.emplace_back(plan.wavelength_um.size(), 1.0);
  std::move(shares.begin(), shares.end(), std::back_inserter(out));
  std::erase_if(out, [](const auto& curve) { return !(*std::max_element(curve.begin(), curve.end()) > 0); });
  return out;
}

/// Weight of a source in what light_together adds up.
double together_weight(const Plan& plan, int source) {
  if (source < plan.sun_sources) return std::max(0.05, static_cast<double>(plan.sun_direction[2]));
  return source == plan.sun_sources ? 1 : 0;
}

/// What all sources send together, [h * view.count + v][grid].
Curves light_together(const Plan& plan) {
  const auto nodes = static_cast<std::size_t>(plan.height.count * plan.view.count);
  Curves out(nodes, std::vector<double>(plan.wavelength_um.size(), 0.0));
  for (int source = 0; source < plan.sun_sources + plan.sky_components; ++source)
    for (std::size_t n = 0; n < nodes; ++n) {
      const std::vector<double>& light = plan.source_spectrum[static_cast<std::size_t>(source) * nodes + n];
      for (std::size_t i = 0; i < light.size(); ++i) out[n][i] += together_weight(plan, source) * light[i];
    }
  return out;
}

std::size_t middle_node(const Plan& plan) { return static_cast<std::size_t>(plan.height.count / 2 * plan.view.count); }

double largest_of(const std::vector<double>& values) {
  return values.empty() ? 0 : *std::max_element(values.begin(), values.end());
}

/// Of sun and sky: each source's light over that of all together, on the grid; 0 where there is none.
Curves shares_of(const Plan& plan, const std::vector<double>& together) {
  const auto nodes = static_cast<std::size_t>(plan.height.count * plan.view.count);
  const std::size_t middle = middle_node(plan);
  const double least = 1e-9 * largest_of(together);
  Curves out;
  for (int source = 0; source < plan.sun_sources + plan.sky_components; ++source) {
    const std::vector<double>& light = plan.source_spectrum[static_cast<std::size_t>(source) * nodes + middle];
    auto& share = out.emplace_back(light.size(), 0.0);
    for (std::size_t i = 0; i < light.size(); ++i)
      if (together[i] > least) share[i] = light[i] / together[i];
  }
  return out;
}

/// What products are made of: the first `curves` are of matter, the others are sources' shares.
struct Parts {
  Curves all;
  std::size_t curves = 0;
  /// Of the plan, weighted by the light that falls there, that of sun and sky, then that of each source of lamps; each
  /// sums to 1, or to 0.
  std::vector<BandQuadrature> bands;
  /// Light at a place of the grid over that of the bands there, where that is most of all lights; 0: none sees it.
  std::vector<double> seen;
  std::size_t shares() const { return all.size() - curves; }
};

/// How much of the bands' light is at each place of the grid: between the lines of a band is what it sees.
void add_seen(Parts& parts, const Plan& plan, const std::vector<double>& spectrum) {
  if (!(largest_of(spectrum) > 0)) return;
  std::vector<double> weight(spectrum.size(), 0.0), light(spectrum.size(), 0.0);
  for (BandQuadrature band : plan.bands) {
    double sum = 0, lit = 0;
    for (std::size_t i = 0; i < band.weight.size(); ++i)
      sum += band.weight[i], lit += band.weight[i] * spectrum[band.first + i];
    for (std::size_t i = 0; i < band.weight.size(); ++i) {
      const double here = std::abs(band.weight[i]);  // some are negative
      weight[band.first + i] += here, light[band.first + i] += here * lit / sum;
      band.weight[i] *= lit > 0 ? spectrum[band.first + i] / lit : 0;
    }
    parts.bands.push_back(std::move(band));
  }
  parts.seen.resize(spectrum.size(), 0.0);
  for (std::size_t i = 0; i < spectrum.size(); ++i)
    if (light[i] > 0) parts.seen[i] = std::max(parts.seen[i], std::min(kMostSeen, spectrum[i] * weight[i] / light[i]));
}

/// Curves of matter with what they are lit by.
Parts parts_of(const Plan& plan, Curves curves, const std::vector<double>& together, const Curves& shares) {
  Parts parts{.all = std::move(curves), .curves = 0, .bands = {}, .seen = {}};
  parts.curves = parts.all.size();
  add_seen(parts, plan, together);
  for (const auto& share : shares)
    if (largest_of(share) > 0 || plan.lamps.sources() == 0) parts.all.push_back(share);
  if (plan.lamps.sources() > 0) parts.all.emplace_back(together.size(), 1.0);  // a lamp's share of its own light
  for (const auto& spectrum : plan.lamps.spectrum) add_seen(parts, plan, spectrum);
  if (parts.seen.empty()) parts.seen.assign(together.size(), 0.0), parts.bands = plan.bands;
  return parts;
}

using Factors = std::vector<std::size_t>;  ///< of a product, as numbers of parts; the last is a share

/// Every product of 2 to `most` curves in any order and of a share; none where they are more than kMostRows.
std::vector<Factors> every_product(const Parts& parts, int most) {
  std::vector<Factors> out, of_one_length = {{}};
  for (int length = 1; length <= most; ++length) {
    std::vector<Factors> longer;
    for (const Factors& product : of_one_length)
      for (std::size_t c = product.empty() ? 0 : product.back(); c < parts.curves; ++c) {
        longer.push_back(product);
        longer.back().push_back(c);
      }
    if (out.size() + longer.size() * parts.shares() > kMostRows) return {};
    for (const Factors& product : longer)
      for (std::size_t share = 0; length > 1 && share < parts.shares(); ++share) {
        out.push_back(product);
        out.back().push_back(parts.curves + share);
      }
    of_one_length = std::move(longer);
  }
  return out;
}

/// Products of 2 to `most` curves and a share, drawn by `draw`; of training every other one is a curve's own power.
std::vector<Factors> drawn_products(const Parts& parts, int most, std::uint32_t draw) {
  const std::size_t count = parts.curves;
  std::vector<Factors> out(draw == kTraining ? kMostRows : std::clamp(kRowsOfACurve * count, kRowsOfACurve, kMostRows));
  for (std::size_t r = 0; r < out.size(); ++r) {
    const auto random = [&](std::uint32_t what) { return rc_hash(static_cast<std::uint32_t>(r), what, 0, draw); };
    const std::uint32_t length = 2 + random(0) % static_cast<std::uint32_t>(most - 1);
    const bool power = draw == kTraining && r % 2 == 0;
    for (std::uint32_t f = 0; f < length; ++f) out[r].push_back(power ? r / 2 % count : random(1 + f) % count);
    out[r].push_back(count + random(1 + length) % parts.shares());
  }
  return out;
}

/// A row of each product on the grid, over the largest value of its darkest factor: what the light is to whoever looks
/// at that matter; times how much of it is seen.
Eigen::MatrixXd rows_of(const std::vector<Factors>& products, const Parts& parts) {
  const Curves& factors = parts.all;
  const std::size_t grid = factors.front().size();
  std::vector<double> largest;
  for (const auto& curve : factors) largest.push_back(std::max(1e-300, *std::max_element(curve.begin(), curve.end())));
  Eigen::MatrixXd out(static_cast<Eigen::Index>(products.size()), static_cast<Eigen::Index>(grid));
  for (std::size_t r = 0; r < products.size(); ++r) {
    double darkest = 1;
    for (const std::size_t f : products[r])
      if (f < parts.curves) darkest = std::min(darkest, largest[f]);
    std::vector<double> product = parts.seen;
    for (double& value : product) value /= darkest;
    for (const std::size_t f : products[r])
      for (std::size_t i = 0; i < grid; ++i) product[i] *= factors[f][i];
    for (std::size_t i = 0; i < grid; ++i) out(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(i)) = product[i];
  }
  return out;
}

/// Picks columns of a matrix, one after the other where what the picks before leave of the rows is largest.
class ColumnPicks {
 public:
  explicit ColumnPicks(Eigen::MatrixXd rows) : rest_(std::move(rows)) {}

  /// Until there are `count` of them, or nothing is left.
  void go_on_to(std::size_t count) {
    count = std::min({count, static_cast<std::size_t>(rest_.cols()), static_cast<std::size_t>(rest_.rows())});
    factor_.conservativeResize(static_cast<Eigen::Index>(std::max(count, column_.size())), rest_.cols());
    while (column_.size() < count) {
      const Eigen::VectorXd left = rest_.colwise().squaredNorm();
      Eigen::Index at = 0;
      const double here = left.maxCoeff(&at);
      if (column_.empty()) largest_ = here;
      if (!(here > kNothingLeft * largest_)) break;
      const auto k = static_cast<Eigen::Index>(column_.size());
      const Eigen::VectorXd q = rest_.col(at) / std::sqrt(here);
      factor_.row(k) = q.transpose() * rest_;
      rest_.noalias() -= q * factor_.row(k);
      column_.push_back(at);
    }
  }

  const std::vector<Eigen::Index>& column() const { return column_; }
  /// [pick][column of the matrix]: triangular where the picks are.
  auto factor() const { return factor_.topRows(static_cast<Eigen::Index>(column_.size())); }

 private:
  Eigen::MatrixXd rest_, factor_;
  std::vector<Eigen::Index> column_;
  double largest_ = 0;
};

/// basis [pick][grid], for values without what is seen of them.
Eigen::MatrixXd basis_of(const ColumnPicks& picks, const std::vector<double>& seen) {
  const std::vector<Eigen::Index>& column = picks.column();
  const Eigen::MatrixXd factor = picks.factor();
  Eigen::MatrixXd triangle(factor.rows(), factor.rows());
  for (Eigen::Index k = 0; k < factor.rows(); ++k) triangle.col(k) = factor.col(column[static_cast<std::size_t>(k)]);
  Eigen::MatrixXd basis = triangle.triangularView<Eigen::Upper>().solve(factor);
  for (Eigen::Index k = 0; k < basis.rows(); ++k)
    basis.row(k) *= seen[static_cast<std::size_t>(column[static_cast<std::size_t>(k)])];
  for (Eigen::Index l = 0; l < basis.cols(); ++l) {
    const double here = seen[static_cast<std::size_t>(l)];
    basis.col(l) *= here > 0 ? 1 / here : 0;
  }
  return basis;
}

double band_mean(const BandQuadrature& band, const double* values) {
  double sum = 0;
  for (std::size_t i = 0; i < band.weight.size(); ++i) sum += band.weight[i] * values[band.first + i];
  return sum;
}

/// Means of each curve over the bands, no smaller than a hundredth of its largest: what its matter shows of itself.
Curves own_light(const Parts& parts) {
  Curves out;
  for (std::size_t f = 0; f < parts.curves; ++f) {
    auto& own = out.emplace_back();
    for (const auto& band : parts.bands) own.push_back(band_mean(band, parts.all[f].data()));
    const double least = std::max(1e-100, 0.01 * *std::max_element(own.begin(), own.end()));  // its square is a number
    for (double& value : own) value = std::max(value, least);
  }
  return out;
}

/// Products that no fit has seen, over what each of their curves shows of itself: band means, rms over the products
/// that a curve is in.
class Judge {
 public:
  Judge(const std::vector<Factors>& products, const Parts& parts)
      : parts_(parts),
        own_(own_light(parts)),
        value_(static_cast<Eigen::Index>(parts.all.front().size()), static_cast<Eigen::Index>(products.size())),
        seen_in_(parts.curves, 0.0) {
    value_.setOnes();
    for (std::size_t r = 0; r < products.size(); ++r) {
      auto value = value_.col(static_cast<Eigen::Index>(r));
      for (const std::size_t f : products[r])
        value = value.cwiseProduct(Eigen::Map<const Eigen::VectorXd>(parts.all[f].data(), value_.rows()));
      Factors curves(products[r].begin(), products[r].end() - 1);
      std::sort(curves.begin(), curves.end());
      curves.erase(std::unique(curves.begin(), curves.end()), curves.end());
      for (const std::size_t f : curves) seen_in_[f] += 1;
      curves_.push_back(std::move(curves));
    }
  }

  /// What a basis is off by, of the worst curve and band.
  double error(const ColumnPicks& picks, const Eigen::MatrixXd& basis) const {
    Eigen::MatrixXd at(basis.rows(), value_.cols());
    for (Eigen::Index k = 0; k < basis.rows(); ++k) at.row(k) = value_.row(picks.column()[static_cast<std::size_t>(k)]);
    double worst = 0;
    for (const auto& curve : mean_squares(value_ - basis.transpose() * at))
      for (const double square : curve) worst = std::max(worst, square);
    return std::sqrt(worst);
  }

  /// Of the products themselves, rms over curves and bands.
  double strength() const {
    double sum = 0;
    for (const auto& curve : mean_squares(value_))
      for (const double square : curve) sum += square / static_cast<double>(parts_.curves * parts_.bands.size());
    return std::sqrt(sum);
  }

 private:
  /// [curve][band] of [grid][product].
  Curves mean_squares(const Eigen::MatrixXd& values) const {
    Curves out(parts_.curves, std::vector<double>(parts_.bands.size()));
    for (std::size_t r = 0; r < curves_.size(); ++r)
      for (std::size_t b = 0; b < parts_.bands.size(); ++b) {
        const double mean = band_mean(parts_.bands[b], values.col(static_cast<Eigen::Index>(r)).data());
        for (const std::size_t f : curves_[r]) out[f][b] += mean * mean / (own_[f][b] * own_[f][b] * seen_in_[f]);
      }
    return out;
  }

  const Parts& parts_;
  Curves own_;
  Eigen::MatrixXd value_;  ///< [grid][product]
  std::vector<Factors> curves_;
  std::vector<double> seen_in_;  ///< so many products
};

void fit_skeleton(Bounces& out, const Plan& plan, const Parts& parts, double share) {
  // What plates let through comes beside what the levels count, to the viewer and from the sun.
  const int most = plan.matter.plates ? kMostFactors : std::clamp(out.levels + 1, 2, kMostFactors);
  std::vector<Factors> training = every_product(parts, most);
  if (training.empty()) training = drawn_products(parts, most, kTraining);
  ColumnPicks picks(rows_of(training, parts));
  const Judge judge(drawn_products(parts, most, kJudging), parts);
  out.strength = judge.strength();
  Eigen::MatrixXd basis;
  for (std::size_t count = kStep; count <= kMostWavelengths; count += kStep) {
    picks.go_on_to(count);
    basis = basis_of(picks, parts.seen);
    out.error = judge.error(picks, basis);
    if (out.error <= share || picks.column().size() < count) break;
  }
  double amplified = 0;  // where half of the usual light is, and more
  for (Eigen::Index l = 0; l < basis.cols(); ++l)
    if (parts.seen[static_cast<std::size_t>(l)] > 0.5) amplified = std::max(amplified, basis.col(l).squaredNorm());
  out.amplified = std::sqrt(amplified);
  for (Eigen::Index k = 0; k < basis.rows(); ++k) {
    out.skeleton.push_back(static_cast<std::size_t>(picks.column()[static_cast<std::size_t>(k)]));
    auto& row = out.basis.emplace_back(plan.wavelength_um.size());
    for (std::size_t i = 0; i < row.size(); ++i) row[i] = basis(k, static_cast<Eigen::Index>(i));
  }
}

/// Shares of the sources at the skeleton's wavelengths, [source][padded].
void sample_shares(Bounces& out, const Curves& shares) {
  const std::size_t padded = RC_PADDED(out.skeleton.size());
  out.source_share.assign(shares.size() * padded, 0.0f);
  for (std::size_t s = 0; s < shares.size(); ++s)
    for (std::size_t m = 0; m < out.skeleton.size(); ++m)
      out.source_share[s * padded + m] = static_cast<float>(shares[s][out.skeleton[m]]);
}

/// The ground around, under sun and sky as if it were open.
void find_ground(Bounces& out, const Plan& plan, const Curves& shares) {
  out.ground.assign(RC_PADDED(out.skeleton.size()), 0.0f);
  if (plan.environment.empty()) return;
  const std::array<double, 4> sky =
      plan.sky_components > 0 ? read_map(plan.irradiance, 0, 0, 1) : std::array<double, 4>{};
  const auto sun_sources = static_cast<std::size_t>(plan.sun_sources);
  for (std::size_t m = 0; m < out.skeleton.size(); ++m) {
    const std::size_t i = out.skeleton[m];
    double reflectance = 0, light = 0;
    for (std::size_t material = 0; material < plan.environment.mean.size(); ++material)
      if (plan.environment.mean[material] > 0)
        reflectance += plan.environment.mean[material] * plan.environment.reflectance[material][i];
    for (std::size_t s = 0; s < shares.size(); ++s) {
      const double sun = plan.sun_up ? std::max(0.0, static_cast<double>(plan.sun_direction[2])) : 0;
      light += (s < sun_sources ? sun : sky[s - sun_sources]) * shares[s][i];
    }
    out.ground[m] = static_cast<float>(reflectance * light);
  }
}

}  // namespace

double Bounces::brightest() const {
  double most = 0;
  for (const shared::rc_float4& law : scattering) most = std::max(most, static_cast<double>(law.y));
  return std::min(most, 1.0);
}

void plan_bounces(Plan& plan, const scene::CompiledScene& scene, int levels, int paths, double share) {
  plan.bounces = {};
  if (levels <= 0 || plan.sun_sources + plan.sky_components + plan.lamps.sources() == 0) return;
  Curves curves = factors_of(plan, scene);
  if (curves.empty()) return;
  plan.bounces.together = light_together(plan);
  const std::vector<double>& together = plan.bounces.together[middle_node(plan)];
  const Curves shares = shares_of(plan, together);
  const Parts parts = parts_of(plan, std::move(curves), together, shares);
  plan.bounces.levels = levels, plan.bounces.share = share;
  fit_skeleton(plan.bounces, plan, parts, share);
  if (plan.bounces.skeleton.empty()) {  // nothing reflects
    plan.bounces = {};
    return;
  }
  if (plan.bounces.error > share || plan.bounces.amplified > kMostAmplified)
    plan.notices.push_back(fmt::format(
        "{}{} wavelengths along paths tell those between them to {:.2g} % of what is seen (asked: "
        "{:.2g} %), and its noise grows by at most {:.2g}; fewer materials, or fewer bounces, would do better",
        kBetweenSurfaces, plan.bounces.skeleton.size(), 100 * plan.bounces.error, 100 * share, plan.bounces.amplified));
  if (plan.sky.rays == 0) plan.sky.rays = paths;
  sample_shares(plan.bounces, shares);
  find_ground(plan.bounces, plan, shares);
  std::vector<double> at_um;
  for (const std::size_t i : plan.bounces.skeleton) at_um.push_back(plan.wavelength_um[i]);
  plan.bounces.curve = sampled_curves(scene, at_um);
  plan.bounces.scattering = surface_scattering(scene, plan.bounces.curve, at_um.size());
}

void tell_of_plates(Plan& plan, const scene::Instrument& instrument) {
  const auto tell = [&](const char* why) {
    plan.notices.push_back(std::string("plates (transmission = \"plate\") ") + why);
  };
  if (!plan.matter.plates) return;
  if (!plan.bounces.any()) {
    tell(
        "are opaque here: light through them goes along paths, and none are followed; set bounces to \"auto\" or above "
        "0");
    return;
  }
  if (plan.lamps.sources() > 0) tell("are opaque to the light of lamps");
  if (instrument.adaptive())
    tell("hide what lies behind them from the first samples, so that every pixel has all its samples");
}

}  // namespace raycube::plan
