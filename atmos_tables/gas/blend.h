// How much each of the two band models counts.
#pragma once

namespace raycube::atmos {

/// Weight q of 6S in the depth of lines q tau_6S + (1 - q) tau_LOWTRAN7: 0 below 2500 and above 17250 cm-1; between,
/// one number per band, ramped over 50 cm-1 at the joints. The numbers were fitted to transmittances of MODTRAN 5.2.1
/// that the US Air Force Research Laboratory published (scanned at 0, 0.25, 0.5, 0.75 and 1).
double blend_weight(double wavenumber_per_cm);

}  // namespace raycube::atmos
