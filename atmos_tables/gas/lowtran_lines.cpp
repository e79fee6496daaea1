#include "atmos_tables/gas/lowtran_lines.h"

#include <array>
#include <cmath>
#include <iterator>
#include <numeric>

#include "atmos_tables/gas/trace_air.h"

namespace raycube::atmos {

namespace {

struct LowtranRun {
  LineGas gas;
  int first_per_cm, points, place;
  double a, n, m;
};
#include "atmos_tables/gas/data/lowtran7_lines.inc"

/// The atm-cm of LOWTRAN7's figures: 3.7194e-21 per km, molecule per cm3 and ppmv, 0.07 % less than Loschmidt's number
/// gives.
constexpr double kAtmCmPerKm = 3.7194e-15;  ///< per molecule cm-3

/// Per km: g cm-2 of water, atm-cm of the others.
std::array<double, kLineGases> amounts_per_km(const AirLevel& air) {
  std::array<double, kLineGases> out{};
  for (std::size_t g = 0; g < kGases; ++g) out[g] = kAtmCmPerKm * air.gas_per_cm3[g];
  out[0] = 1e5 * air.gas(Gas::h2o) * kMolarMass_g[0] / kAvogadro;
  const TraceAir trace = trace_air(air.height_km);
  const double per_ppmv = 1e-6 * kAtmCmPerKm * air.air_per_cm3;
  out[static_cast<std::size_t>(LineGas::no)] = per_ppmv * trace.no_ppmv;
  out[static_cast<std::size_t>(LineGas::so2)] = per_ppmv * trace.so2_ppmv;
  out[static_cast<std::size_t>(LineGas::no2)] = per_ppmv * trace.no2_ppmv;
  out[static_cast<std::size_t>(LineGas::nh3)] = per_ppmv * trace.nh3_ppmv;
  return out;
}

}  // namespace

LowtranLines::LowtranLines(const std::vector<LayerNode>& nodes, std::size_t layers)
    : layers_(layers), amount_(std::size(kRuns) * layers), begin_(kPoints + 1) {
  for (const LayerNode& node : nodes) {
    const auto per_km = amounts_per_km(node.air);
    const double log_p = std::log(node.air.pressure_hPa / 1013.25), log_t = std::log(273.15 / node.air.temperature_K);
    for (std::size_t r = 0; r < std::size(kRuns); ++r)
      amount_[r * layers + node.layer] += node.length_km * per_km[static_cast<std::size_t>(kRuns[r].gas)] *
                                          std::exp(kRuns[r].n * log_p + kRuns[r].m * log_t);
  }
  for (std::size_t point = 0; point < kPoints; ++point) {
    const int wavenumber = kFirst + kStep * static_cast<int>(point);
    for (std::size_t r = 0; r < std::size(kRuns); ++r) {
      const int k = (wavenumber - kRuns[r].first_per_cm) / kStep;
      if (wavenumber < kRuns[r].first_per_cm || k >= kRuns[r].points) continue;
      entry_.push_back({r, 1e-5 * kLog10C_1e5[kRuns[r].place + k]});
    }
    begin_[point + 1] = entry_.size();
  }
}

LowtranLines::Path::Path(const LowtranLines& lines, const double* path_factor)
    : lines_(lines), path_factor_(path_factor), amount_(std::size(kRuns), -1.0) {}

LowtranLines::Path::Depths LowtranLines::Path::depths(std::size_t point) {
  Depths out;
  for (std::size_t e = lines_.begin_[point]; e < lines_.begin_[point + 1]; ++e) {
    const Entry& entry = lines_.entry_[e];
    double& amount = amount_[entry.run];
    if (amount < 0) {
      const double* of_layer = &lines_.amount_[entry.run * lines_.layers_];
      amount = std::inner_product(of_layer, of_layer + lines_.layers_, path_factor_, 0.0);
    }
    const double depth = power_law_depth(entry.log10_c, amount, kRuns[entry.run].a);
    (static_cast<std::size_t>(kRuns[entry.run].gas) < kGases ? out.also_sixs : out.trace) += depth;
  }
  return out;
}

}  // namespace raycube::atmos
