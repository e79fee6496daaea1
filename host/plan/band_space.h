// From spectra on the table's axis to band values: lets errors be judged per band, as the tolerance is.
#pragma once

#include <vector>

#include "host/plan/plan.h"
#include "host/plan/table_spectra.h"

namespace raycube::plan {

/// Linear interpolation of table spectra (wavelengths first .. first + count - 1 of the axis) onto the plan's grid, and
/// band averages of table spectra, with and without a reflectance on the way.
class BandSpace {
 public:
  /// table_um: the covered part of the table's axis; it must enclose the grid (1e-9 um).
  BandSpace(const std::vector<double>& table_um, const std::vector<double>& grid_um,
            const std::vector<BandQuadrature>& bands, const std::vector<double>& reflectance_on_grid);

  std::vector<double> to_grid(const Spectrum& on_table) const;
  std::vector<double> band_mean(const Spectrum& on_table) const;
  std::vector<double> reflected_band_mean(const Spectrum& on_table) const;  ///< of reflectance times the spectrum
  /// Per table wavelength the largest value of the bands whose quadrature reaches it; 0 where none does.
  Spectrum spread(const std::vector<double>& band_value) const;
  std::size_t bands() const { return plain_.size(); }

 private:
  struct Functional {
    std::size_t first = 0;
    std::vector<double> weight;
  };
  static std::vector<double> apply(const std::vector<Functional>& functionals, const Spectrum& spectrum);

  std::size_t table_size_;
  std::vector<Cell> cell_;  ///< of each grid point on the table's axis
  std::vector<Functional> plain_, reflected_;
};

}  // namespace raycube::plan
