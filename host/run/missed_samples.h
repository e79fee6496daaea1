// Samples of an image that met nothing: beyond the scene's edge there is no ground, and its light is missing
// from the pixel.
#pragma once

#include <cstdint>
#include <string>

#include "host/render/types.h"
#include "scene_compiler/simulation.h"

namespace raycube::run {

class MissedSamples {
 public:
  /// Counts a strip's pixels by their hit_fraction.
  MissedSamples(const scene::Simulation& simulation, const scene::Instrument& instrument);
  void add(const render::Strip& strip);

  bool any() const { return empty_ + partly_ > 0; }
  /// One line: how much met nothing, where the first such pixel is, and the way out.
  std::string text() const;
  std::string json() const;

 private:
  std::string name_;
  std::size_t pixels_per_line_, layers_, layer_ = 0;
  std::uint64_t pixels_ = 0, empty_ = 0, partly_ = 0;
  double missed_ = 0;            ///< sum over pixels of what missed
  int line_ = -1, sample_ = -1;  ///< of the first pixel that partly or wholly misses
};

}  // namespace raycube::run
