// Absorption by a molecule line by line: Voigt profiles, strengths and widths of the air's state.
//
// S(T) = S Q(296)/Q(T) exp(-c2 E (1/T - 1/296)) (1 - exp(-c2 v/T)) / (1 - exp(-c2 v/296)); gamma = (296/T)^n (gamma_air
// p_air + gamma_self p_own); centre v + delta p. No line mixing and no correction of far wings: Q branches of CO2 and
// of methane near 1 atm, and the wings of CO2 beyond 4.18 um, can be off by tens of per cent.
#pragma once

#include <memory>
#include <vector>

#include "atmos_tables/lines/absorber.h"
#include "atmos_tables/lines/molecules.h"
#include "atmos_tables/lines/spectral_line.h"

namespace raycube::atmos {

struct LineOptions {
  double wing_per_cm = 25;  ///< a line ends at this distance from its centre
  /// The profile's value at that distance is taken off inside it: the rest belongs to the continuum (Clough et al.
  /// 1989, Atmos. Res. 23, 229). For water when a continuum is added.
  bool without_pedestal = false;
  /// Only lines stronger than this at 296 K, cm-1/(molecule cm-2).
  double weakest = 0;
};

class MolecularLines : public Absorber {
 public:
  /// Lines of one molecule, ascending in wavenumber; isotopologues mixed as on earth. Error(bug) when the options are
  /// not positive.
  MolecularLines(std::vector<SpectralLine> lines, LineOptions options,
                 std::shared_ptr<const PartitionSums> partition_sums);

  /// Lines further than the wing allows contribute nothing. Inside blocks of wavenumbers the sum of distant lines is a
  /// Chebyshev polynomial through 14 points: within 1e-11 of the sum of all profiles.
  std::vector<double> cross_section_cm2(const std::vector<double>& wavenumber_per_cm,
                                        const GasState& state) const override;
  /// The same, every profile at every wavenumber: slow, for tests.
  std::vector<double> every_line_cm2(const std::vector<double>& wavenumber_per_cm, const GasState& state) const;

 private:
  struct Shape;
  std::vector<Shape> shapes(double low_per_cm, double high_per_cm, const GasState& state) const;

  std::vector<SpectralLine> lines_;
  LineOptions options_;
  std::shared_ptr<const PartitionSums> partition_sums_;
};

/// S(T) of a line, cm-1/(molecule cm-2).
double line_intensity(const SpectralLine& line, double temperature_K, const PartitionSums& partition_sums);

}  // namespace raycube::atmos
