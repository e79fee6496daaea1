// Absorption by gases in the layers of a column: what the compiler of tables asks for.
//
// Lines: band models, LOWTRAN7 from 330 to 17860 cm-1 and, from 2500 to 17250 cm-1, blended with 6S (blend.h), in steps
// of 5 cm-1 at a resolution of 20 cm-1. Band models do not add up over paths: ask for the whole path. Everything else
// is grey (grey_gases.h).
#pragma once

#include <cstddef>
#include <vector>

#include "atmos_tables/gas/blend.h"
#include "atmos_tables/gas/grey_gases.h"
#include "atmos_tables/gas/lowtran_lines.h"
#include "atmos_tables/gas/sixs_lines.h"
#include "atmos_tables/optics/air_profile.h"

namespace raycube::atmos {

enum class BandModel { blended, lowtran };

/// Layers are given by levels from the ground up (km above the sea). Path factors are the path in a layer over its
/// thickness, >= 0; 0: not crossed; two-way paths add their factors. Safe to share between threads.
class LayerGases {
 public:
  /// Throws Error(input) as layer_nodes does.
  LayerGases(const AirProfile& profile, const std::vector<double>& level_km, BandModel model = BandModel::blended);

  std::size_t layers() const { return layers_; }

  /// -ln T of the lines of all gases along a path; linear between the model's points, 0 outside 330..17860 cm-1.
  double line_depth(double wavenumber_per_cm, const std::vector<double>& path_factor) const;

  /// Vertical depth of a layer by what is additive: continua, ozone in the visible and ultraviolet, N2, HNO3, O2.
  double grey_depth(double wavenumber_per_cm, std::size_t layer) const { return grey_.depth(wavenumber_per_cm, layer); }

  /// Mean over [low, high] cm-1 of exp(-line_depth), by the trapezoidal rule over the model's points inside and both
  /// ends.
  double line_transmission(double low_per_cm, double high_per_cm, const std::vector<double>& path_factor) const;
  /// -ln of it, which does not run out of numbers in deep bands.
  double mean_line_depth(double low_per_cm, double high_per_cm, const std::vector<double>& path_factor) const;

  /// T(path) ~ sum_j weight[j] exp(-sum_i layer_depth[j][i] path_factor[i]) in a bin, for multiple scattering.
  struct KTerms {
    std::vector<double> weight;                    ///< >= 0, sum 1; deepest term first
    std::vector<std::vector<double>> layer_depth;  ///< [term][layer], vertical
    double fit_rms = 0;                            ///< of T over the whole column times the factors of the fit
  };
  /// At most `terms` (1..5) terms; one where the vertical depth is below 1e-4. Fitted to the bin's mean transmittance
  /// of the whole column times 2.5^-6 .. 2.5^5, and times less where even that is deep; factors near 1 count most. A
  /// layer's share is the one that gives columns below and above each level the depth the band model has for them, so
  /// that pressure and temperature of every layer count. Reached over 0.58..14 um, midlatitude summer, with 3 / 4
  /// terms, rms of T: vertical 0.0023 / 0.0007, 60 degrees 0.0028 / 0.0010, ground to 3 km 0.005 / 0.004, 3 km to top
  /// 0.005 / 0.004, 10 km to top 0.014 / 0.007.
  KTerms k_terms(double low_per_cm, double high_per_cm, std::size_t terms) const;

 private:
  void check(double low_per_cm, double high_per_cm, const std::vector<double>& path_factor) const;
  /// Layers' parts of the column, sum 1. amount_of_depth: by how much the column is to be multiplied to have a depth.
  template <class Column>
  std::vector<double> layer_shares(double low_per_cm, double high_per_cm, Column&& amount_of_depth) const;

  std::size_t layers_;
  BandModel model_;
  LowtranLines lowtran_;
  SixsLines sixs_;
  GreyGases grey_;

  class Path;
  LayerGases(const std::vector<LayerNode>& nodes, std::size_t layers, BandModel model);
};

}  // namespace raycube::atmos
