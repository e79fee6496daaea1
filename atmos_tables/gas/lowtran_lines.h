// Lines of 11 gases after LOWTRAN7: bands of 20 cm-1 at points 5 cm-1 apart, 330 to 17860 cm-1.
#pragma once

#include <cstddef>
#include <vector>

#include "atmos_tables/gas/band_models.h"
#include "atmos_tables/gas/layer_nodes.h"

namespace raycube::atmos {

class LowtranLines {
 public:
  static constexpr int kFirst = 330, kLast = 17860, kStep = 5;  ///< cm-1
  static constexpr std::size_t kPoints = (kLast - kFirst) / kStep + 1;

  LowtranLines(const std::vector<LayerNode>& nodes, std::size_t layers);

  /// Depths at points of the grid for one path; amounts are summed over the path when a band is first asked for.
  class Path {
   public:
    Path(const LowtranLines& lines, const double* path_factor);
    struct Depths {
      double also_sixs = 0;  ///< gases that 6S has as well: H2O, CO2, O3, N2O, CO, CH4, O2
      double trace = 0;      ///< NO, SO2, NO2, NH3
    };
    Depths depths(std::size_t point);

   private:
    const LowtranLines& lines_;
    const double* path_factor_;
    std::vector<double> amount_;  ///< per run; negative: not yet summed
  };

 private:
  std::size_t layers_;
  std::vector<double> amount_;  ///< [run][layer], scaled by pressure and temperature
  struct Entry {
    std::size_t run;
    double log10_c;
  };
  std::vector<Entry> entry_;        ///< of all points, point after point
  std::vector<std::size_t> begin_;  ///< [kPoints + 1]
};

}  // namespace raycube::atmos
