// Lines of 7 gases after 6S: random bands in bins of 10 cm-1, 2500 to 17260 cm-1. Water after Goody, the others after
// Malkmus.
#pragma once

#include <cstddef>
#include <vector>

#include "atmos_tables/gas/layer_nodes.h"

namespace raycube::atmos {

class SixsLines {
 public:
  static constexpr int kFirst = 2500, kStep = 10;  ///< lower edge of the first bin, cm-1
  static constexpr std::size_t kBins = 1476;       ///< up to 17260 cm-1

  SixsLines(const std::vector<LayerNode>& nodes, std::size_t layers);

  /// -ln T of all gases in a bin for one path. Temperatures outside 180 to 320 K count as these in the dependence on
  /// temperature, which is a fit around 250 K.
  double depth(std::size_t bin, const double* path_factor) const;

  /// Depths at wavenumbers of the 5 cm-1 grid for one path, the last bins kept: inside a bin its own, at a joint the
  /// mean transmittance of both.
  class Path {
   public:
    Path(const SixsLines& lines, const double* path_factor) : lines_(lines), path_factor_(path_factor) {}
    double depth_at(int wavenumber_per_cm);

   private:
    double kept_depth(int bin);
    const SixsLines& lines_;
    const double* path_factor_;
    int kept_bin_[2] = {-1, -1};
    double kept_depth_[2] = {0, 0};
  };

 private:
  struct Entry {
    bool goody;
    double a1, a2;
    std::size_t amounts;  ///< place in amount_ of `layers` amounts u, then `layers` amounts times pressure up, g cm-2
  };
  std::size_t layers_;
  std::vector<double> amount_;
  std::vector<Entry> entry_;        ///< of all bins, bin after bin
  std::vector<std::size_t> begin_;  ///< [kBins + 1]
};

}  // namespace raycube::atmos
