// What a camera's detector makes of the light, as the simulation file says (host/sensors/detector.h does it).
#pragma once

#include <optional>
#include <vector>

namespace raycube::scene {

/// A row of a table of noise: the signal-to-noise ratio at a radiance, or noise as a function of it.
struct NoisePoint {
  double wavelength_um = 0;
  double radiance = 0, snr = 0;  ///< W m-2 sr-1 um-1
  /// Else noise is |a sqrt(b + L) + c|, L and noise in W m-2 sr-1 um-1; a = 0: the same whatever the light.
  bool function = false;
  double a = 0, b = 0, c = 0;
};

struct DetectorSpec {
  // Exactly one of these three says how large noise is.
  double snr = 0;  ///< 0: not so
  std::vector<NoisePoint> noise;
  double aperture_diameter_m = 0;

  double integration_time_s = 0;
  std::vector<double> at_um, transmission, quantum_efficiency;  ///< lists of one: the same at every wavelength
  double dark_e_s = 0, read_noise_e = 0;
  double prnu = 0, dsnu_e = 0, bad_share = 0;  ///< prnu and bad_share: parts of 1
  std::optional<double> full_well_e;
  int bits = 0;  ///< 0: no digital numbers
  double gain_e_dn = 0, offset_dn = 0;
};

}  // namespace raycube::scene
