// What one pixel's radiance is the sum of: light by where it came from and by what scattered it last.
#pragma once

#include <string>
#include <vector>

#include "host/render/renderer.h"
#include "host/run/camera_job.h"
#include "scene_compiler/simulation.h"

namespace raycube::run {

/// One kind of light, W m-2 sr-1 um-1 at the sensor.
struct PixelPart {
  scene::BandTruth kind;  ///< a part of the radiance
  int number = 0;  ///< of a sky's component, from 1; between surfaces: of surfaces after the first that it has met
  std::string material{};          ///< what scattered or emitted it last; empty: none, or several
  bool through = false;            ///< it came through that material
  bool gloss = false;              ///< by its gloss
  bool and_more = false;           ///< of that number of surfaces and of more
  std::vector<double> radiance{};  ///< [band]
};

struct PixelBudget {
  std::vector<PixelPart> light;  ///< in the order of kind, material and number
  std::vector<double> sum;       ///< [band], of all light
  std::vector<float> rendered;   ///< [band], what render writes
  double worst_difference = 0;   ///< of sum and rendered, over the rendered band
};

/// The pixel as render makes it, means of replicates and samples for small objects included. A sky's components after
/// its first are differences from that one's colour, and may be negative, as may thermal light between surfaces, which
/// is what that differs from the surroundings'. Light between surfaces is told apart by rendering the same paths to one
/// surface, to two, and so on to eight; what came by more is one part. Sums are of doubles, those of render of floats:
/// they differ by some 1e-7, with light between surfaces by some 1e-6.
PixelBudget explain_pixel(render::Renderer& renderer, const scene::Simulation& simulation, const CameraJob& job,
                          int line, int sample);

}  // namespace raycube::run
