#include "atmos_tables/gas/grey_gases.h"

#include <algorithm>
#include <cmath>

#include "atmos_tables/gas/trace_air.h"

namespace raycube::atmos {

namespace {

#include "atmos_tables/gas/data/grey_gases.inc"

/// Linear between figures, 0 beyond them.
template <std::size_t count>
double figure(const double (&values)[count], double first, double step, double wavenumber) {
  const double place = (wavenumber - first) / step;
  if (!(place >= 0 && place <= count - 1)) return 0;
  const std::size_t k = std::min(static_cast<std::size_t>(place), count - 2);
  return values[k] + (place - static_cast<double>(k)) * (values[k + 1] - values[k]);
}

}  // namespace

GreyGases::GreyGases(const std::vector<LayerNode>& nodes, std::size_t layers) : layer_(layers) {
  constexpr double density_296 = 273.15 / 296;
  for (const LayerNode& node : nodes) {
    const AirLevel& air = node.air;
    Amounts& sum = layer_[node.layer];
    const double t = air.temperature_K, cm = 1e5 * node.length_km, p = air.pressure_hPa / 1013.25;
    const double rho = p * 273.15 / t, rho_water = air.gas(Gas::h2o) / kLoschmidt_per_cm3;
    const double self = cm * air.gas(Gas::h2o) * rho_water / density_296;
    sum.water_self += self;
    sum.water_self_cold += self * (296 - t) / 36;
    sum.water_foreign += cm * air.gas(Gas::h2o) * std::max(rho - rho_water, 0.0) / density_296;
    sum.nitrogen_km += node.length_km * 0.781 * p * p * std::pow(273.15 / t, 1.5);
    sum.nitric_acid += cm * 1e-6 * trace_air(air.height_km).hno3_ppmv * air.air_per_cm3 / kLoschmidt_per_cm3;
    const double oxygen = cm * air.gas(Gas::o2) / kLoschmidt_per_cm3, warm = t - 220;
    sum.oxygen += oxygen * p, sum.oxygen_warm += oxygen * p * warm, sum.oxygen_warm2 += oxygen * p * warm * warm;
    sum.herzberg += oxygen * (1 + 0.83 * rho);
    const double ozone = cm * air.gas(Gas::o3) / kLoschmidt_per_cm3, celsius = t - 273.15;
    sum.ozone += ozone, sum.ozone_warm += ozone * celsius, sum.ozone_warm2 += ozone * celsius * celsius;
  }
}

double GreyGases::depth(double v, std::size_t layer) const {
  const Amounts& amount = layer_.at(layer);
  double sum = 0;
  const double warm = figure(kWaterSelf296, kWaterSelf296First, 10, v),
               cold = figure(kWaterSelf260, kWaterSelf260First, 10, v);
  // LOWTRAN7's straight line through 296 and 260 K meets 0 somewhere above 320 K.
  sum += std::max(1e-20 * (warm * amount.water_self + (cold - warm) * amount.water_self_cold), 0.0);
  sum += 1e-20 * figure(kWaterForeign, kWaterForeignFirst, 10, v) * amount.water_foreign;
  sum += figure(kNitrogen, kNitrogenFirst, 5, v) * amount.nitrogen_km;
  sum += figure(kNitricAcid, kNitricAcidFirst, 5, v) * amount.nitric_acid;
  if (v >= kOxygenFirst && v <= 2000)
    sum += std::max(figure(kOxygen, kOxygenFirst, 5, v) * amount.oxygen +
                        figure(kOxygenPerK, kOxygenPerKFirst, 5, v) * amount.oxygen_warm +
                        figure(kOxygenPerK2, kOxygenPerK2First, 5, v) * amount.oxygen_warm2,
                    0.0);
  sum += figure(kOzoneVisible, kOzoneVisibleFirst, 50, v) * amount.ozone;
  if (v >= kOzoneNearFirst && v < kOzoneFarFirst)
    sum += std::max(figure(kOzoneNear, kOzoneNearFirst, 20, v) * amount.ozone +
                        figure(kOzoneNearPerK, kOzoneNearPerKFirst, 20, v) * amount.ozone_warm +
                        figure(kOzoneNearPerK2, kOzoneNearPerK2First, 20, v) * amount.ozone_warm2,
                    0.0);
  if (v >= kOzoneFarFirst)
    sum += std::max(figure(kOzoneFar, kOzoneFarFirst, 100, v) * amount.ozone +
                        figure(kOzoneFarPerK, kOzoneFarPerKFirst, 100, v) * amount.ozone_warm +
                        figure(kOzoneFarPerK2, kOzoneFarPerK2First, 100, v) * amount.ozone_warm2,
                    0.0);
  return sum + figure(kHerzberg, kHerzbergFirst, 100, v) * amount.herzberg;
}

}  // namespace raycube::atmos
