// Cross sections of a volume's gas: from a CSV, or from Lorentz lines given in numbers.
#pragma once

#include <vector>

#include "scene_compiler/compiled_scene.h"
#include "scene_compiler/document.h"

namespace raycube::scene {

struct LorentzLine {
  double strength_cm = 0, half_width_per_cm = 0.06, center_per_cm = 1e4, wing_per_cm = 25;
};

/// Sum of the lines over wavelength, ascending, linear between nodes to 1e-7 of itself inside every line's wings (nodes
/// even in asinh of the distance over the half width); 0 outside all wings.
void tabulate_lines(const std::vector<LorentzLine>& lines, Volume& out);

/// The gas's cross sections from `cross_section` or [[volume.line]] of a record; reports what is wrong.
void read_cross_section(const Record& volume, Volume& out, base::Problems& problems);

}  // namespace raycube::scene
