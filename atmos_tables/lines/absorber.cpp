#include "atmos_tables/lines/absorber.h"

#include "atmos_tables/gas/layer_nodes.h"

namespace raycube::atmos {

std::vector<double> absorption_per_km(const std::vector<AbsorbingGas>& gases, const AirLevel& air,
                                      const std::vector<double>& wavenumber_per_cm) {
  constexpr double cm_per_km = 1e5;
  std::vector<double> out(wavenumber_per_cm.size(), 0.0);
  for (const AbsorbingGas& gas : gases) {
    const double density = gas.per_cm3(air);
    if (!(density > 0)) continue;
    const GasState state{air.pressure_hPa, air.temperature_K, air.pressure_hPa * density / air.air_per_cm3};
    const std::vector<double> sigma = gas.absorber->cross_section_cm2(wavenumber_per_cm, state);
    for (std::size_t i = 0; i < out.size(); ++i) out[i] += cm_per_km * density * sigma[i];
  }
  return out;
}

ResolvedGases::ResolvedGases(const std::vector<AbsorbingGas>& gases, const AirProfile& profile,
                             const std::vector<double>& level_km, const std::vector<double>& wavenumber_per_cm)
    : layers_(level_km.size() - 1), depth_(wavenumber_per_cm.size() * layers_, 0.0) {
  for (const LayerNode& node : layer_nodes(profile, level_km, 2)) {
    const std::vector<double> absorption = absorption_per_km(gases, node.air, wavenumber_per_cm);
    for (std::size_t i = 0; i < absorption.size(); ++i)
      depth_[i * layers_ + node.layer] += node.length_km * absorption[i];
  }
}

}  // namespace raycube::atmos
