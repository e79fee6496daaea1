// Optics of particles that the figures do not hold.
#pragma once

#include <utility>

#include "atmos_tables/aerosol/phase_function.h"
#include "atmos_tables/aerosol/substance.h"

namespace raycube::atmos {

class ParticleOptics {
 public:
  virtual ~ParticleOptics() = default;
  /// Extinction and absorption over the extinction at 0.55 um. Throws Error(input) outside covers_um().
  virtual SubstanceOptics at(double wavelength_um) const = 0;
  virtual PhaseFunction phase(double wavelength_um) const = 0;
  /// First and last wavelength, vacuum.
  virtual std::pair<double, double> covers_um() const = 0;
};

}  // namespace raycube::atmos
