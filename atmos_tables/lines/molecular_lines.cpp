#include "atmos_tables/lines/molecular_lines.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "atmos_tables/lines/voigt.h"
#include "host/base/error.h"

namespace raycube::atmos {

namespace {

/// Pressure moves no centre further than this, cm-1, in an atmosphere.
constexpr double kFarthestShift_per_cm = 1;
/// Widths of a block, cm-1 and Doppler half widths. Lines nearer to its centre than twice its width are summed point by
/// point: the others' poles lie outside the ellipse of Bernstein with rho = 7.9, and of their Gaussian core exp(-24^2
/// ln 2) is left.
constexpr double kBlock_per_cm = 0.2, kBlockDopplers = 16;
constexpr std::size_t kNodes = 14;

/// Chebyshev points of the second kind on [-1, 1] and their barycentric weights (Berrut & Trefethen 2004, SIAM Rev. 46,
/// 501).
struct Chebyshev {
  std::array<double, kNodes> node, weight;
  Chebyshev() : node{}, weight{} {
    for (std::size_t k = 0; k < kNodes; ++k) {
      node[k] = -std::cos(std::numbers::pi * static_cast<double>(k) / (kNodes - 1));
      weight[k] = (k % 2 ? -1.0 : 1.0) * (k == 0 || k + 1 == kNodes ? 0.5 : 1.0);
    }
  }
  double value(const std::array<double, kNodes>& at_nodes, double x) const {
    double above = 0, below = 0;
    for (std::size_t k = 0; k < kNodes; ++k) {
      const double distance = x - node[k];
      if (distance == 0) return at_nodes[k];
      above += weight[k] / distance * at_nodes[k], below += weight[k] / distance;
    }
    return above / below;
  }
};

/// S(T); partition_ratio: Q(296) / Q(T).
double intensity_at(const SpectralLine& line, double temperature_K, double partition_ratio) {
  const double v = line.wavenumber_per_cm, energy = std::max(0.0, line.lower_energy_per_cm), t0 = kLineReference_K;
  return line.intensity * partition_ratio * std::exp(-kC2_cm_K * energy * (1 / temperature_K - 1 / t0)) *
         std::expm1(-kC2_cm_K * v / temperature_K) / std::expm1(-kC2_cm_K * v / t0);
}

}  // namespace

double line_intensity(const SpectralLine& line, double temperature_K, const PartitionSums& partition_sums) {
  return intensity_at(line, temperature_K, partition_sums.ratio(line.molecule, line.isotopologue, temperature_K));
}

/// A line in air of one state.
struct MolecularLines::Shape {
  double centre, intensity, pedestal;
  VoigtProfile profile;
  double at(double wavenumber) const { return intensity * profile(wavenumber - centre) - pedestal; }
};

MolecularLines::MolecularLines(std::vector<SpectralLine> lines, LineOptions options,
                               std::shared_ptr<const PartitionSums> partition_sums)
    : lines_(std::move(lines)), options_(options), partition_sums_(std::move(partition_sums)) {
  if (!(options_.wing_per_cm > 0) || !(options_.weakest >= 0) || !partition_sums_)
    throw base::Error(base::Fault::bug,
                      "lines: the wing must be above 0, the weakest line not negative, partition sums given");
  std::erase_if(lines_, [&](const SpectralLine& line) { return line.intensity < options_.weakest; });
}

std::vector<MolecularLines::Shape> MolecularLines::shapes(double low, double high, const GasState& state) const {
  const double reach = options_.wing_per_cm + kFarthestShift_per_cm;
  const auto first = std::lower_bound(lines_.begin(), lines_.end(), low - reach,
                                      [](const SpectralLine& line, double v) { return line.wavenumber_per_cm < v; });
  const double own_atm = state.own_pressure_hPa / kAtmosphere_hPa, atm = state.pressure_hPa / kAtmosphere_hPa;
  const double warmth = kLineReference_K / state.temperature_K;
  struct PerIsotopologue {
    double ratio, mass_g;
  };
  std::map<int, PerIsotopologue> known;
  std::vector<Shape> out;
  for (auto line = first; line != lines_.end() && line->wavenumber_per_cm <= high + reach; ++line) {
    auto found = known.find(line->isotopologue);
    if (found == known.end())
      found =
          known
              .emplace(line->isotopologue,
                       PerIsotopologue{partition_sums_->ratio(line->molecule, line->isotopologue, state.temperature_K),
                                       isotopologue_mass_g(line->molecule, line->isotopologue)})
              .first;
    const double v = line->wavenumber_per_cm, intensity = intensity_at(*line, state.temperature_K, found->second.ratio);
    const double gamma =
        std::pow(warmth, line->n_air) * (line->gamma_air * (atm - own_atm) + line->gamma_self * own_atm);
    const VoigtProfile profile(doppler_half_width_per_cm(v, state.temperature_K, found->second.mass_g), gamma);
    const double pedestal = options_.without_pedestal ? intensity * profile(options_.wing_per_cm) : 0;
    out.push_back({v + line->delta_air * atm, intensity, pedestal, profile});
  }
  std::sort(out.begin(), out.end(), [](const Shape& a, const Shape& b) { return a.centre < b.centre; });
  return out;
}

std::vector<double> MolecularLines::every_line_cm2(const std::vector<double>& wavenumber_per_cm,
                                                   const GasState& state) const {
  std::vector<double> out(wavenumber_per_cm.size(), 0.0);
  if (out.empty()) return out;
  for (const Shape& shape : shapes(wavenumber_per_cm.front(), wavenumber_per_cm.back(), state))
    for (std::size_t i = 0; i < out.size(); ++i)
      if (std::abs(wavenumber_per_cm[i] - shape.centre) <= options_.wing_per_cm)
        out[i] += shape.at(wavenumber_per_cm[i]);
  return out;
}

std::vector<double> MolecularLines::cross_section_cm2(const std::vector<double>& wavenumber_per_cm,
                                                      const GasState& state) const {
  static const Chebyshev chebyshev;
  const std::vector<double>& v = wavenumber_per_cm;
  std::vector<double> out(v.size(), 0.0);
  if (v.empty() || lines_.empty()) return out;
  const std::vector<Shape> all = shapes(v.front(), v.back(), state);
  const double heaviest_doppler = doppler_half_width_per_cm(v.back(), state.temperature_K, 1.0);
  const double mass = isotopologue_mass_g(lines_.front().molecule, 1);
  const double width = std::max(kBlock_per_cm, kBlockDopplers * heaviest_doppler / std::sqrt(mass)),
               wing = options_.wing_per_cm;
  for (std::size_t begin = 0, end; begin < v.size(); begin = end) {
    end = static_cast<std::size_t>(
        std::upper_bound(v.begin() + static_cast<std::ptrdiff_t>(begin), v.end(), v[begin] + width) - v.begin());
    const double half = 0.5 * (v[end - 1] - v[begin]), centre = v[begin] + half;
    const auto first = std::lower_bound(all.begin(), all.end(), v[begin] - wing,
                                        [](const Shape& shape, double at) { return shape.centre < at; });
    const auto last = std::upper_bound(first, all.end(), v[end - 1] + wing,
                                       [](double at, const Shape& shape) { return at < shape.centre; });
    const bool few = end - begin <= kNodes;
    std::array<double, kNodes> far{};
    for (auto shape = first; shape != last; ++shape) {
      const double distance = std::abs(shape->centre - centre);
      if (few || distance < 2 * width || distance > wing - half) {
        for (std::size_t i = begin; i < end; ++i)
          if (std::abs(v[i] - shape->centre) <= wing) out[i] += shape->at(v[i]);
      } else {
        for (std::size_t k = 0; k < kNodes; ++k) far[k] += shape->at(centre + half * chebyshev.node[k]);
      }
    }
    if (few) continue;
    for (std::size_t i = begin; i < end; ++i) out[i] += chebyshev.value(far, (v[i] - centre) / half);
  }
  return out;
}

}  // namespace raycube::atmos
