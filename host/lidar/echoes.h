// Echoes in waveforms: which peaks are returns, and their time, area and width by one of three methods.
#pragma once

#include <vector>

#include "host/lidar/detection.h"
#include "host/lidar/detector.h"

namespace raycube::lidar {

/// Returns of a waveform in photo-electrons per bin (background included), in order of time, at most max_returns (the
/// strongest), numbered. A return is a maximum of the waveform smoothed over half the recorded pulse (not smoothed
/// where the noise is zero), with a bin above the threshold within the pulse's half width, parted from the next by a
/// dip of at least 3 standard deviations of the noise there (further apart than 4 of the pulse: 5, or below half of the
/// lower maximum).
///   peak               parabola through the logarithms of the three bins about the maximum
///   constant_fraction  first crossing of fraction x maximum, plus what a flat target's echo takes from there to its
///   centre gaussian           sum of Gaussians integrated over the bins, least squares with the noise's weights
///   (Levenberg-Marquardt); a component
///                      is added where the residuals ask for one (fall of chi^2 by more than 30), no narrower than the
///                      pulse and no wider than 3 of it. Width and area from the fit.
/// Probabilities are left 0.
std::vector<Echo> find_echoes(const scene::Lidar& lidar, const std::vector<float>& waveform_pe,
                              const DetectorNoise& noise);

/// Echoes of a Geiger detector's time tags: clusters no gap of which exceeds the recorded pulse's half width (at least
/// a bin), of at least threshold_pe events; time = mean, area = events, width = 2.355 x standard deviation (0 for one
/// event).
std::vector<Echo> cluster_tags(const scene::Lidar& lidar, const std::vector<Photon>& tags);

/// Keeps the strongest max_returns, numbers them in order of time and sets ranges.
void number_echoes(const scene::Lidar& lidar, std::vector<Echo>& echoes);

}  // namespace raycube::lidar
