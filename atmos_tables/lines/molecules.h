// Molecules by HITRAN's numbers: names, masses, and how many of them are in the lower state of a line.
#pragma once

#include <string>
#include <vector>

namespace raycube::atmos {

inline constexpr double kC2_cm_K = 1.438776877;  ///< hc/k (SI 2019)

/// 1 ... molecule_count().
int molecule_count();
/// Formula in lower case ("h2o"). Throws Error(bug) for an unknown number.
const std::string& molecule_name(int molecule);
/// 0 when unknown.
int molecule_number(const std::string& name);
/// g mol-1. Isotopologues of the first seven molecules by their own mass, of others (and beyond the list) by the
/// commonest isotopes, which is within 4 %: 2 % of a Doppler width.
double isotopologue_mass_g(int molecule, int isotopologue);

/// Partition sums Q(T) of molecules: by formula, or from a user's file.
class PartitionSums {
 public:
  /// Classical rotation (T for linear molecules, T^1.5 for others) times harmonic vibrations at the fundamental
  /// frequencies (Shimanouchi 1972, NSRDS-NBS 39; Huber & Herzberg 1979; the rule of the AFGL line compilation,
  /// McClatchey et al. 1973, AFCRL-TR-73-0096). Against levels summed one by one Q(296) / Q(T) is within 0.5 % between
  /// 180 and 330 K for linear molecules and CH4; the first quantum correction of H2O is 0.9 % at 180 K and 0.7 % at 200
  /// K, of O3 below 0.1 %; molecules whose frequencies are not held (molecules.cpp) are taken as stiff.
  PartitionSums() = default;

  /// CSV: molecule (name or number), isotopologue, temperature_K, q under a header line of those names; temperatures
  /// ascending for each. ln Q is linear in ln T between them. Isotopologues that the file leaves out keep the formula.
  /// Throws Error(environment) when it cannot be read, Error(input) with every fault by line.
  static PartitionSums read_csv(const std::string& file);

  /// Q(296 K) / Q(T). Throws Error(input) when a user's table does not reach T.
  double ratio(int molecule, int isotopologue, double temperature_K) const;

 private:
  struct Table {
    int molecule = 0, isotopologue = 0;
    std::vector<double> log_temperature, log_q;
  };
  double log_q(const Table& table, double temperature_K) const;
  std::vector<Table> tables_;
  std::string file_;
};

}  // namespace raycube::atmos
