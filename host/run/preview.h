// A picture of what a camera sees, soon: three bands, a few samples, the quick air, no plan. What it shows is right in
// kind, not to a tolerance.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "host/products/quicklook.h"
#include "host/render/renderer.h"
#include "host/run/services.h"
#include "scene_compiler/simulation.h"

namespace raycube::run {

/// Samples and sky directions of a pixel in each pass: fewer leave crowns speckled, more keep a user waiting for the
/// first picture.
inline constexpr int kPreviewSamples = 4, kPreviewDirections = 2;

struct PreviewSettings {
  int samples = 64;                      ///< of a pixel when all passes are done; rounded up to whole passes
  std::int64_t most_pixels = 512 * 512;  ///< of the picture: a larger image is seen at every n-th line and column
};

/// What a picture is of.
struct PreviewState {
  int width = 0, height = 0, step = 1;  ///< pixels; of the image's lines and columns every step-th
  int samples = 0;                      ///< of a pixel so far
  bool last = false;
};

/// Told of each picture, which write() puts into a file: after 1, 2, 4, ... passes and after the last.
using PreviewSink = std::function<void(const PreviewState& state, const std::function<void(base::OutputFile&)>& write)>;

/// Pass by pass, each with its own draw of samples and rays, averaged: the same pictures every time. The simulation is
/// left with the quick air: the clear sky in place of the layered model where that knows the bands, no light between
/// ground and air. Throws what ends the run.
void preview(render::Renderer& renderer, scene::Simulation& simulation, const scene::Instrument& instrument,
             const PreviewSettings& settings, Services& services, const PreviewSink& sink);

}  // namespace raycube::run
