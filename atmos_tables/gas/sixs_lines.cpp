#include "atmos_tables/gas/sixs_lines.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "atmos_tables/gas/band_models.h"

namespace raycube::atmos {

namespace {

struct SixsRun {
  LineGas gas;
  int first_per_cm, bins, place;
};
namespace data {
#include "atmos_tables/gas/data/sixs_lines.inc"
}

}  // namespace

SixsLines::SixsLines(const std::vector<LayerNode>& nodes, std::size_t layers) : layers_(layers), begin_(kBins + 1) {
  for (std::size_t bin = 0; bin < kBins; ++bin) {
    const int wavenumber = kFirst + kStep * static_cast<int>(bin);
    for (const SixsRun& run : data::kRuns) {
      const int k = (wavenumber - run.first_per_cm) / kStep;
      if (wavenumber < run.first_per_cm || k >= run.bins) continue;
      const int* figure = data::kBins + 6 * (run.place + k);
      const double a3 = 1e-6 * figure[2], a4 = 1e-8 * figure[3], a5 = 1e-6 * figure[4], a6 = 1e-8 * figure[5];
      entry_.push_back(
          {run.gas == LineGas::h2o, std::pow(10, 1e-4 * figure[0]), std::pow(10, 1e-4 * figure[1]), amount_.size()});
      amount_.resize(amount_.size() + 2 * layers);
      double* u = &amount_[entry_.back().amounts];
      const std::size_t gas = static_cast<std::size_t>(run.gas);
      for (const LayerNode& node : nodes) {
        const double t = std::clamp(node.air.temperature_K, 180.0, 320.0) - 250;
        const double g_cm2 = 1e5 * node.length_km * node.air.gas_per_cm3[gas] * kMolarMass_g[gas] / kAvogadro;
        u[node.layer] += g_cm2 * std::exp(t * (a3 + a4 * t));
        u[layers + node.layer] += g_cm2 * std::exp(t * (a5 + a6 * t)) * (node.air.pressure_hPa / 1013.25);
      }
    }
    begin_[bin + 1] = entry_.size();
  }
}

double SixsLines::depth(std::size_t bin, const double* path_factor) const {
  double sum = 0;
  for (std::size_t e = begin_[bin]; e < begin_[bin + 1]; ++e) {
    const Entry& entry = entry_[e];
    const double *of_layer = &amount_[entry.amounts], *with_pressure = of_layer + layers_;
    double u = 0, up = 0;
    for (std::size_t i = 0; i < layers_; ++i)
      u += of_layer[i] * path_factor[i], up += with_pressure[i] * path_factor[i];
    sum += entry.goody ? goody_depth(entry.a1, entry.a2, u, up) : malkmus_depth(entry.a1, entry.a2, u, up);
  }
  return sum;
}

double SixsLines::Path::kept_depth(int bin) {
  if (bin < 0 || bin >= static_cast<int>(kBins)) return 0;
  const int place = bin % 2;
  if (kept_bin_[place] != bin) {
    kept_bin_[place] = bin;
    kept_depth_[place] = lines_.depth(static_cast<std::size_t>(bin), path_factor_);
  }
  return kept_depth_[place];
}

double SixsLines::Path::depth_at(int wavenumber_per_cm) {
  if (wavenumber_per_cm < kFirst) return 0;
  const int bin = (wavenumber_per_cm - kFirst) / kStep;
  const double above = kept_depth(bin);
  if ((wavenumber_per_cm - kFirst) % kStep != 0) return above;
  const double below = kept_depth(bin - 1);
  return std::min(below, above) - std::log(0.5 * (1 + std::exp(-std::abs(below - above))));
}

}  // namespace raycube::atmos
