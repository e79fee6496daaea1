#include "host/plan/bounces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include <Eigen/Dense>
#include <fmt/format.h>

#include "host/plan/baked_rows.h"
#include "host/plan/irradiance_map.h"
#include "host/plan/path_parts.h"
#include "kernels/sampling/sampler.h"
#include "kernels/shared/tile_layout.h"
#include "scene_compiler/matter.h"

namespace raycube::plan {

namespace {

constexpr int kMostFactors = 8;            ///< of a product that the skeleton is fitted to
constexpr std::size_t kRowsOfACurve = 24;  ///< that judge
constexpr std::size_t kMostRows = 600;     ///< that judge or train
constexpr std::size_t kMostWavelengths = 128, kStep = 16;
constexpr double kNothingLeft = 1e-12;  ///< of the largest column: rounding of what has been taken out
constexpr std::uint32_t kTraining = 61, kJudging = 62;

using Factors = std::vector<std::size_t>;  ///< of a product, as numbers of parts; the last is a share

/// Every product of 2 to `most` curves (of emitted light 1 to `most`) in any order and of a share; none where they are
/// more than kMostRows.
std::vector<Factors> every_product(const PathParts& parts, int most) {
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
      for (std::size_t share = 0; share < parts.shares(); ++share) {
        if (product.size() < parts.fewest(share)) continue;
        out.push_back(product);
        out.back().push_back(parts.curves + share);
      }
    of_one_length = std::move(longer);
  }
  return out;
}

/// Products of 2 to `most` curves and a share, drawn by `draw`; of training every other one is a curve's own power.
std::vector<Factors> drawn_products(const PathParts& parts, int most, std::uint32_t draw) {
  const std::size_t count = parts.curves;
  std::vector<Factors> out(draw == kTraining ? kMostRows : std::clamp(kRowsOfACurve * count, kRowsOfACurve, kMostRows));
  for (std::size_t r = 0; r < out.size(); ++r) {
    const auto random = [&](std::uint32_t what) { return rc_hash(static_cast<std::uint32_t>(r), what, 0, draw); };
    std::uint32_t length = 2 + random(0) % static_cast<std::uint32_t>(most - 1);
    const std::size_t share = random(1 + length) % parts.shares();
    if (parts.fewest(share) == 1) length -= 1;
    const bool power = draw == kTraining && r % 2 == 0;
    for (std::uint32_t f = 0; f < length; ++f) out[r].push_back(power ? r / 2 % count : random(1 + f) % count);
    out[r].push_back(count + share);
  }
  return out;
}

/// A row of each product on the grid, over the largest value of its darkest factor: what the light is to whoever looks
/// at that matter; times how much of it is seen.
Eigen::MatrixXd rows_of(const std::vector<Factors>& products, const PathParts& parts) {
  const Curves& factors = parts.all;
  const std::size_t grid = factors.front().size();
  std::vector<double> largest;
  for (std::size_t f = 0; f < parts.curves; ++f) largest.push_back(std::max(1e-300, largest_of(parts.shown(f))));
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

/// Products that no fit has seen, over what each of their curves shows of itself: band means, rms over the products
/// that a curve is in.
class Judge {
 public:
  Judge(const std::vector<Factors>& products, const PathParts& parts)
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

  /// What a basis is off by, of each curve and its worst band.
  std::vector<double> errors(const ColumnPicks& picks, const Eigen::MatrixXd& basis) const {
    Eigen::MatrixXd at(basis.rows(), value_.cols());
    for (Eigen::Index k = 0; k < basis.rows(); ++k) at.row(k) = value_.row(picks.column()[static_cast<std::size_t>(k)]);
    std::vector<double> out;
    for (const auto& curve : mean_squares(value_ - basis.transpose() * at)) out.push_back(std::sqrt(largest_of(curve)));
    return out;
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

  const PathParts& parts_;
  Curves own_;
  Eigen::MatrixXd value_;  ///< [grid][product]
  std::vector<Factors> curves_;
  std::vector<double> seen_in_;  ///< so many products
};

void fit_skeleton(Bounces& out, const Plan& plan, const scene::CompiledScene& scene, const PathParts& parts,
                  double share) {
  // What plates let through comes beside what the levels count, to the viewer and from the sun.
  const int most = plan.matter.plates ? kMostFactors : std::clamp(out.levels + 1, 2, kMostFactors);
  std::vector<Factors> training = every_product(parts, most);
  if (training.empty()) training = drawn_products(parts, most, kTraining);
  ColumnPicks picks(rows_of(training, parts));
  const Judge judge(drawn_products(parts, most, kJudging), parts);
  out.strength = judge.strength();
  Eigen::MatrixXd basis;
  std::vector<double> errors;
  for (std::size_t count = kStep; count <= kMostWavelengths; count += kStep) {
    picks.go_on_to(count);
    basis = basis_of(picks, parts.seen);
    errors = judge.errors(picks, basis);
    out.error = largest_of(errors);
    if (out.error <= share || picks.column().size() < count) break;
  }
  for (std::size_t f = 0; f < parts.curves; ++f) {
    if (parts.owner[f] == kNobody) continue;
    const std::uint32_t owner = parts.owner[f];
    double& error = out.material_error[scene.materials[owner - scene.materials[owner].in_family].name];
    error = std::max(error, errors[f]);
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

/// What materials send by themselves, behind their curves.
void add_heat(Bounces& out, const PathHeat& heat) {
  const std::size_t padded = RC_PADDED(out.skeleton.size());
  for (const auto& excess : heat.excess) {
    std::vector<float> row(padded, 0.0f);
    for (std::size_t m = 0; !excess.empty() && m < out.skeleton.size(); ++m)
      row[m] = static_cast<float>(excess[out.skeleton[m]]);
    out.curve.insert(out.curve.end(), row.begin(), row.end());
  }
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
    for (std::size_t s = 0; s < sun_sources + static_cast<std::size_t>(plan.sky_components); ++s) {
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
  if (levels <= 0 || plan.first_lamp() + plan.lamps.sources() == 0) return;
  PathFactors factors = factors_of(plan, scene);
  if (factors.curve.empty()) return;
  plan.bounces.together = light_together(plan, scene);
  const std::vector<double>& together = plan.bounces.together[middle_node(plan)];
  const Curves shares = shares_of(plan, together);
  const PathHeat heat = path_heat(plan, scene, together);
  const PathParts parts = parts_of(plan, scene, std::move(factors), together, shares, heat);
  plan.bounces.levels = levels, plan.bounces.share = share;
  fit_skeleton(plan.bounces, plan, scene, parts, share);
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
  if (heat.any()) add_heat(plan.bounces, heat);
}

Plan without_paths(const Plan& plan) {
  Plan out = plan;
  out.bounces = {};
  if (out.baked) out.baked = std::make_shared<BakedRows>();
  return out;
}

void tell_of_matter(Plan& plan, const scene::Instrument& instrument) {
  plan.notices.insert(plan.notices.end(), plan.thermal.notices.begin(), plan.thermal.notices.end());
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
