#include "scene_compiler/air_wavelength.h"

namespace raycube::scene {

double ciddor_air_index(double wavelength_um) {
  if (wavelength_um < 0.2) return 1.0;
  const double sigma2 = 1.0 / (wavelength_um * wavelength_um);  // um^-2
  return 1.0 + 1e-8 * (5792105.0 / (238.0185 - sigma2) + 167917.0 / (57.362 - sigma2));
}

double vacuum_from_air_um(double air_wavelength_um) {
  double vacuum_um = air_wavelength_um;
  for (int i = 0; i < 4; ++i) vacuum_um = ciddor_air_index(vacuum_um) * air_wavelength_um;
  return vacuum_um;
}

}  // namespace raycube::scene
