// Spectra of several detectors that follow each other in a file: what two of them measured counts once.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/base/error.h"
#include "scene_compiler/spectrum_file.h"

namespace raycube::scene {

/// Field spectrometers have a detector for each of two or three ranges that overlap, and their files hold one after the
/// other: wavelengths step back at each join. Sorted, the two would alternate point by point, which is a saw-tooth as
/// high as they differ. Each join is cut in the middle of its overlap, and a notice says where and by how much the two
/// differ there. Points may descend as a whole. nullopt: the steps back are not those of detectors, of which there are
/// at most six, each of `fewest` points at least and reaching further than the one before.
std::optional<std::vector<SpectrumPoint>> joined_detectors(std::vector<SpectrumPoint> points, std::size_t fewest,
                                                           const std::string& file, base::Problems& problems);

}  // namespace raycube::scene
