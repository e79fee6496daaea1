// Reflectance from radiance by panels whose reflectance is known: the empirical line (Smith & Milton, Int. J. Remote
// Sens. 20, 1999).
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "host/analysis/spectra.h"

namespace raycube::analysis {

/// A panel: what the cube has of it, and its reflectance, on the cube's bands.
struct Panel {
  std::string name;
  Eigen::VectorXd radiance, reflectance;
};

struct EmpiricalLine {
  Eigen::VectorXd gain, offset;   ///< reflectance = gain L + offset, band by band; NaN where the band tells nothing
  Eigen::VectorXd rms;            ///< of the panels' reflectances from the line; 0 for two panels
  std::vector<std::size_t> dark;  ///< bands that tell nothing: the panels' radiances are the same to 1e-9
};

/// Of two panels the line through both: rho = rho_dark + (L - L_dark) (rho_bright - rho_dark) / (L_bright - L_dark); of
/// more the line of least squares in reflectance. Throws Error(input): fewer than two panels, or no band that tells
/// anything.
EmpiricalLine empirical_line(const std::vector<Panel>& panels);

}  // namespace raycube::analysis
