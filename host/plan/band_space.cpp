#include "host/plan/band_space.h"

#include <algorithm>

namespace raycube::plan {

BandSpace::BandSpace(const std::vector<double>& table_um, const std::vector<double>& grid_um,
                     const std::vector<BandQuadrature>& bands, const std::vector<double>& reflectance_on_grid)
    : table_size_(table_um.size()) {
  for (const double l : grid_um) cell_.push_back(find_cell(table_um, l));
  for (const auto& band : bands) {
    Functional plain, reflected;
    plain.first = reflected.first = cell_[band.first].index;
    const Cell& last = cell_[band.first + band.weight.size() - 1];
    plain.weight.assign(std::min(last.index + 2, table_um.size()) - plain.first, 0.0);
    reflected.weight = plain.weight;
    for (std::size_t i = 0; i < band.weight.size(); ++i) {
      const Cell& cell = cell_[band.first + i];
      const double w = band.weight[i], r = w * reflectance_on_grid[band.first + i];
      const std::size_t k = cell.index - plain.first;
      plain.weight[k] += w * (1 - cell.fraction);
      reflected.weight[k] += r * (1 - cell.fraction);
      if (cell.fraction > 0) {
        plain.weight[k + 1] += w * cell.fraction;
        reflected.weight[k + 1] += r * cell.fraction;
      }
    }
    plain_.push_back(std::move(plain));
    reflected_.push_back(std::move(reflected));
  }
}

std::vector<double> BandSpace::to_grid(const Spectrum& on_table) const {
  std::vector<double> out;
  out.reserve(cell_.size());
  for (const Cell& c : cell_)
    out.push_back(c.fraction > 0 ? (1 - c.fraction) * on_table[c.index] + c.fraction * on_table[c.index + 1]
                                 : on_table[c.index]);
  return out;
}

Spectrum BandSpace::spread(const std::vector<double>& band_value) const {
  Spectrum out(table_size_, 0.0);
  for (std::size_t b = 0; b < plain_.size(); ++b)
    for (std::size_t i = 0; i < plain_[b].weight.size(); ++i)
      out[plain_[b].first + i] = std::max(out[plain_[b].first + i], band_value[b]);
  return out;
}

std::vector<double> BandSpace::apply(const std::vector<Functional>& functionals, const Spectrum& spectrum) {
  std::vector<double> out;
  out.reserve(functionals.size());
  for (const auto& f : functionals) {
    double sum = 0;
    for (std::size_t i = 0; i < f.weight.size(); ++i) sum += f.weight[i] * spectrum[f.first + i];
    out.push_back(sum);
  }
  return out;
}

std::vector<double> BandSpace::band_mean(const Spectrum& on_table) const { return apply(plain_, on_table); }
std::vector<double> BandSpace::reflected_band_mean(const Spectrum& on_table) const {
  return apply(reflected_, on_table);
}

}  // namespace raycube::plan
