// A camera's detector over a cube of radiance: measured.img, and what it is made of.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "host/base/output_file.h"
#include "host/products/envi_header.h"
#include "host/run/services.h"
#include "scene_compiler/simulation.h"

namespace raycube::run {

/// Reads lines of the radiance, [line][sample][band]; threads may read at once.
using ReadsRadiance = std::function<void(std::int64_t first_line, std::int64_t lines, float* values)>;

struct MeasuredCube {
  std::uint64_t saturated = 0, values = 0;                 ///< cut off at the upper end, of so many
  std::vector<std::pair<std::string, std::string>> files;  ///< that were added to the set: name, what it holds
  std::string warning() const;                             ///< of what was cut off
};

/// Adds measured.img (digital numbers of 16 bits with the calibration to radiance as the header's gains and offsets, or
/// radiance), detector.csv (each band's electrons, noise and calibration) and, where there are any, bad_elements.csv.
/// Radiance that is not finite stays so; Error(input) where there are digital numbers. header: of the radiance. The
/// same bits whatever the threads, and of a render or a stored cube alike.
MeasuredCube measure_cube(const scene::Instrument& instrument, std::uint64_t seed, const ReadsRadiance& read,
                          const products::EnviHeader& header, base::OutputSet& set, const Services& services);

}  // namespace raycube::run
