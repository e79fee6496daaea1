#include "atmos_tables/gas/layer_gases.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "host/base/error.h"

namespace raycube::atmos {

/// Depths of lines along one path; sums over the path are kept between points.
class LayerGases::Path {
 public:
  Path(const LayerGases& gases, const std::vector<double>& path_factor)
      : model_(gases.model_), lowtran_(gases.lowtran_, path_factor.data()), sixs_(gases.sixs_, path_factor.data()) {}

  double depth(std::size_t point) {
    const auto [also_sixs, trace] = lowtran_.depths(point);
    const int wavenumber = LowtranLines::kFirst + LowtranLines::kStep * static_cast<int>(point);
    const double q = model_ == BandModel::blended ? blend_weight(wavenumber) : 0;
    return trace + (1 - q) * also_sixs + (q > 0 ? q * sixs_.depth_at(wavenumber) : 0);
  }

  double depth_at(double wavenumber) {
    if (!(wavenumber >= LowtranLines::kFirst && wavenumber <= LowtranLines::kLast)) return 0;
    const double place = (wavenumber - LowtranLines::kFirst) / LowtranLines::kStep;
    const std::size_t point = static_cast<std::size_t>(place);
    const double fraction = place - static_cast<double>(point);
    return fraction > 0 ? (1 - fraction) * depth(point) + fraction * depth(point + 1) : depth(point);
  }

 private:
  BandModel model_;
  LowtranLines::Path lowtran_;
  SixsLines::Path sixs_;
};

LayerGases::LayerGases(const AirProfile& profile, const std::vector<double>& level_km, BandModel model)
    : LayerGases(layer_nodes(profile, level_km), level_km.size() - 1, model) {}

LayerGases::LayerGases(const std::vector<LayerNode>& nodes, std::size_t layers, BandModel model)
    : layers_(layers), model_(model), lowtran_(nodes, layers), sixs_(nodes, layers), grey_(nodes, layers) {}

void LayerGases::check(double low, double high, const std::vector<double>& path_factor) const {
  if (!(low > 0 && low <= high && high < 1e6))
    throw base::Error(base::Fault::bug, "gases: wavenumbers " + std::to_string(low) + " to " + std::to_string(high) +
                                            " cm-1 are not a bin; give 0 < low <= high");
  if (path_factor.size() != layers_)
    throw base::Error(base::Fault::bug, "gases: " + std::to_string(path_factor.size()) + " path factors for " +
                                            std::to_string(layers_) + " layers; give one per layer");
  for (double factor : path_factor)
    if (!(factor >= 0))
      throw base::Error(base::Fault::bug,
                        "gases: path factor " + std::to_string(factor) + " is negative; give 0 or more");
}

double LayerGases::line_depth(double wavenumber_per_cm, const std::vector<double>& path_factor) const {
  check(wavenumber_per_cm, wavenumber_per_cm, path_factor);
  return Path(*this, path_factor).depth_at(wavenumber_per_cm);
}

double LayerGases::line_transmission(double low_per_cm, double high_per_cm,
                                     const std::vector<double>& path_factor) const {
  return std::exp(-mean_line_depth(low_per_cm, high_per_cm, path_factor));
}

double LayerGases::mean_line_depth(double low, double high, const std::vector<double>& path_factor) const {
  check(low, high, path_factor);
  Path path(*this, path_factor);
  constexpr double step = LowtranLines::kStep, first = LowtranLines::kFirst, last = LowtranLines::kLast;
  if (!(high > low) || high <= first || low >= last) return path.depth_at(0.5 * (low + high));
  std::vector<double> at, depth;
  const auto add = [&](double wavenumber) { at.push_back(wavenumber), depth.push_back(path.depth_at(wavenumber)); };
  add(std::max(low, first));
  for (double k = std::floor((at[0] - first) / step) + 1; first + k * step < std::min(high, last); ++k)
    add(first + k * step);
  add(std::min(high, last));
  // Outside the model's range nothing is absorbed. Sums of 1 - exp(..) keep the digits of weak bins.
  const double outside = (high - low) - (at.back() - at.front());
  const double least = outside > 0 ? 0 : *std::min_element(depth.begin(), depth.end());
  double lost = 0;
  for (std::size_t i = 0; i + 1 < at.size(); ++i)
    lost -= 0.5 * (at[i + 1] - at[i]) * (std::expm1(least - depth[i]) + std::expm1(least - depth[i + 1]));
  return least - std::log1p(-lost / (high - low));
}

}  // namespace raycube::atmos
