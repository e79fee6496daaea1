// The air against height: pressure, temperature and number densities at levels, the rule between levels, columns.
//
// Between levels temperature is linear in height, pressure and densities are exponential (LOWTRAN's rule), and columns
// are the exact integrals of that: (d1 - d2) dz / ln(d1 / d2). A density that is 0 at one end of a layer is linear
// there.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

namespace raycube::atmos {

enum class Gas : std::size_t { h2o, co2, o3, n2o, co, ch4, o2 };
inline constexpr std::size_t kGases = 7;
inline constexpr std::array<const char*, kGases> kGasNames = {"h2o", "co2", "o3", "n2o", "co", "ch4", "o2"};
/// g mol-1 (IUPAC 2013 atomic weights).
inline constexpr std::array<double, kGases> kMolarMass_g = {18.0153, 44.0095, 47.9982, 44.0128,
                                                            28.0101, 16.0425, 31.9988};

inline constexpr double kAvogadro = 6.02214076e23;            ///< mol-1 (SI 2019)
inline constexpr double kBoltzmann_J_per_K = 1.380649e-23;    ///< (SI 2019)
inline constexpr double kLoschmidt_per_cm3 = 2.686780111e19;  ///< at 273.15 K and 1013.25 hPa

struct AirLevel {
  double height_km = 0;  ///< above the sea
  double pressure_hPa = 0;
  double temperature_K = 0;
  double air_per_cm3 = 0;  ///< molecules, water included
  std::array<double, kGases> gas_per_cm3{};

  double gas(Gas which) const { return gas_per_cm3[static_cast<std::size_t>(which)]; }
  double& gas(Gas which) { return gas_per_cm3[static_cast<std::size_t>(which)]; }
  /// Parts per million of all molecules.
  double ppmv(Gas which) const { return 1e6 * gas(which) / air_per_cm3; }
};

class AirProfile {
 public:
  /// Levels from the ground up. Throws Error(input) that lists every fault: fewer than 2 levels, heights that do not
  /// ascend strictly or lie outside -1..150 km, pressures that do not fall strictly, temperatures outside 100..1000 K,
  /// densities that are not finite, negative (gases) or not positive (air), gases above the air. source: who says so,
  /// for reports.
  AirProfile(std::vector<AirLevel> levels, std::string source);

  const std::vector<AirLevel>& levels() const { return levels_; }
  const std::string& source() const { return source_; }
  double ground_km() const { return levels_.front().height_km; }
  double top_km() const { return levels_.back().height_km; }

  /// All quantities at a height inside the profile (its ends included; throws Error(input) outside).
  AirLevel at(double height_km) const;

  /// Molecules per cm2 between two heights inside the profile, low <= high.
  double air_column_per_cm2(double low_km, double high_km) const;
  double gas_column_per_cm2(Gas gas, double low_km, double high_km) const;
  /// Air above a height: the column to the profile's top and what the pressure there carries, p / (m g).
  double air_above_per_cm2(double height_km) const;

  /// Whole columns of the two gases that users state: precipitable water, g cm-2, and ozone, atm-cm (1000 Dobson
  /// units).
  double water_g_cm2() const;
  double ozone_atm_cm() const;

 private:
  template <class Density>
  double column_per_cm2(double low_km, double high_km, Density&& density) const;
  void check_inside(double height_km) const;

  std::vector<AirLevel> levels_;
  std::string source_;
};

/// Value at fraction 0..1 between two ends: exponential, linear when an end is 0. The rule of this file.
double between(double low, double high, double fraction);
/// Mean of `between` over fraction 0..1.
double mean_between(double low, double high);

/// Acceleration by gravity, m s-2, at 45 degrees latitude: 9.80665 (6356.766 / (6356.766 + z))^2 (US Standard
/// Atmosphere 1976).
double gravity_m_s2(double height_km);
/// Mean mass of a molecule of dry air, kg: (28.9595 + 15.0556 c) g mol-1, c the volume fraction of CO2 (Bodhaine et al.
/// 1999, eq. 17).
double dry_air_molecule_kg(double co2_ppmv);

}  // namespace raycube::atmos
