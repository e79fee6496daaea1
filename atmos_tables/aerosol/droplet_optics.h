// Optics of a user's own spheres, by Mie's series: a modified gamma distribution and a refractive index against
// wavelength.
#pragma once

#include <memory>
#include <vector>

#include "atmos_tables/aerosol/phase_function.h"
#include "atmos_tables/aerosol/substance.h"

namespace raycube::atmos {

/// n(r) ~ r^alpha exp(-b r^gamma), r in um (Deirmendjian 1969; cloud C.1: 6, 1.5, 1; haze L: 2, 15.1186, 0.5).
struct DropletModel {
  double alpha = 6, b = 1.5, gamma = 1;
  struct Index {
    double wavelength_um, n, k;  ///< n + i k, k >= 0 absorbs
  };
  std::vector<Index> index;  ///< wavelengths ascend and reach over 0.55 um; raycube ships no table of indices
};

/// Mie's series is summed at each wavelength of the index table; between them extinction follows a power law, albedo
/// and asymmetry are linear, and phase functions are mixed.
class DropletOptics {
 public:
  /// Takes about a second per wavelength for cloud C.1 in the visible. Throws Error(input) that lists every bad figure.
  explicit DropletOptics(const DropletModel& model);

  /// Extinction over that at 0.55 um. Throws Error(input) outside the index table.
  SubstanceOptics at(double wavelength_um) const;
  PhaseFunction phase(double wavelength_um) const;

 private:
  struct Node {
    double wavelength_um = 0;
    SubstanceOptics optics;
    std::shared_ptr<const PhaseShape> shape;
  };
  struct Place {
    const Node *low, *high;
    double linear, logarithmic;  ///< shares of the higher node
  };
  Place place(double wavelength_um) const;
  std::vector<Node> nodes_;
};

}  // namespace raycube::atmos
