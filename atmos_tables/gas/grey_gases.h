// Absorption without line structure, after LOWTRAN7: depths add up over layers and paths.
#pragma once

#include <cstddef>
#include <vector>

#include "atmos_tables/gas/layer_nodes.h"

namespace raycube::atmos {

/// Water continuum (330..17860 cm-1), nitrogen (2080..2740), nitric acid (850..1735), oxygen near 6.4 um (1400..1755),
/// ozone in the visible and ultraviolet (13000..24250 and 27360..50000), oxygen's Herzberg continuum (36000..50000).
/// Linear between figures,
/// 0 beyond them.
class GreyGases {
 public:
  GreyGases(const std::vector<LayerNode>& nodes, std::size_t layers);
  /// Vertical depth of a layer, >= 0.
  double depth(double wavenumber_per_cm, std::size_t layer) const;

 private:
  /// Path amounts of one layer; rho is density over Loschmidt's, P pressure in atmospheres.
  struct Amounts {
    double water_self = 0, water_self_cold = 0,
           water_foreign = 0;  ///< molecules cm-2: int rho_w^2 / rho_0, times (296 K - T) / 36 K,
                               ///< int rho_w (rho - rho_w) / rho_0; rho_0 = 273.15 / 296
    double nitrogen_km = 0;    ///< int 0.781 P^2 (273.15 / T)^1.5
    double nitric_acid = 0;    ///< atm-cm
    double oxygen = 0, oxygen_warm = 0, oxygen_warm2 = 0;  ///< int P w, times (T - 220 K), times its square; atm-cm
    double ozone = 0, ozone_warm = 0, ozone_warm2 = 0;     ///< atm-cm, times (T - 273.15 K), times its square
    double herzberg = 0;                                   ///< int (1 + 0.83 P 273.15 / T) w, atm-cm
  };
  std::vector<Amounts> layer_;
};

}  // namespace raycube::atmos
