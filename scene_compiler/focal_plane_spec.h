// How a camera's optics and detectors blur and misplace what they see, as the simulation file says
// (host/sensors/optical_transfer.h and cells.h do it). Pixels are the instrument's: across the lines its
// ifov_across_rad, along the flight its ifov_along_rad.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <vector>

namespace raycube::scene {

/// A measured point spread, of the optics alone: rings about the middle, or a grid.
struct SpreadTable {
  /// Rings, at one wavelength or several, ascending: value[w][i] at radius_px[i].
  std::vector<double> radius_px, wavelength_um;
  std::vector<std::vector<double>> value;
  /// Else a grid: of each point its place and value.
  std::vector<double> x_px, y_px, grid_value;
  bool rings() const { return !radius_px.empty(); }
  bool empty() const { return radius_px.empty() && x_px.empty(); }
};

/// Measured smile and keystone on a grid of wavelengths and samples; bilinear, beyond it those of its edge.
struct DistortionTable {
  std::vector<double> wavelength_um, sample;               ///< ascending; samples from 0
  std::vector<std::vector<double>> smile_um, keystone_px;  ///< [wavelength][sample]
};

struct FocalPlane {
  std::string name;
  double first_um = 0, last_um = 1e300;  ///< bands whose centres lie from the one to below the other
  std::array<double, 2> sigma_px{0, 0};  ///< Gaussian of the optics: across, along
  double f_number = 0, pitch_um = 0;     ///< diffraction; 0: none
  double obscuration = 0;                ///< of the aperture's diameter
  SpreadTable spread;
  std::array<double, 2> detector_px{1, 1}, smear_px{0, 0};
  double jitter_px = 0;
  std::array<double, 2> offset_px{0, 0};  ///< of what is seen from where the pixel should look
  double smile_um = 0, keystone_px = 0;
  DistortionTable distortion;

  /// Whether all its bands see alike.
  bool grey() const { return f_number == 0 && spread.wavelength_um.size() < 2; }
  bool smiles() const {
    const auto any = [](const std::vector<double>& row) {
      return std::any_of(row.begin(), row.end(), [](double v) { return v != 0; });
    };
    return smile_um != 0 || std::any_of(distortion.smile_um.begin(), distortion.smile_um.end(), any);
  }
};

}  // namespace raycube::scene
