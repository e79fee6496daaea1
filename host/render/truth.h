// Truth layers of a strip, from the shading stage's sums.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "host/plan/plan.h"
#include "scene_compiler/compiled_scene.h"
#include "scene_compiler/simulation.h"

namespace raycube::render {

/// Bands of the fixed layers, by the names of truth_layers.def; a material's abundance follows at abundance + its
/// number (scene::named_materials).
namespace truth {
enum Layer {
#define RC_TRUTH_LAYER(name, unit, text) name,
#include "kernels/shared/truth_layers.def"
#undef RC_TRUTH_LAYER
  abundance
};
}  // namespace truth

struct LayerName {
  std::string name, unit, text;
};

/// Every layer in band order: the fixed ones of truth_layers.def, then abundance_<material>.
std::vector<LayerName> truth_layer_names(const scene::CompiledScene& scene);

/// Layers that are shares of a pixel, which begin at `abundance`: abundances, and where the instrument asks for it
/// those of what is opaque.
std::size_t share_layers(const scene::CompiledScene& scene, const scene::Instrument& instrument);

/// The same with all its shares, then those of standard errors where the instrument has them, and what derives from all
/// these.
std::vector<LayerName> truth_layer_names(const scene::CompiledScene& scene, const scene::Instrument& instrument);

/// Layers that follow from a pixel's shares: temperatures, where the scene knows some, and where the instrument asks
/// for it what is opaque and what lets light through.
class DerivedLayers {
 public:
  DerivedLayers(const scene::CompiledScene& scene, const scene::Instrument& instrument);
  /// Of pixels whose other layers are filled.
  void fill(std::size_t pixels, float* layers) const;

 private:
  std::size_t stride_, first_, materials_;
  bool knows_temperatures_, first_opaque_;
  std::vector<double> temperature_K_;  ///< of the materials that the user named; not a number: none
  std::vector<char> through_;          ///< whether each lets light through
};

/// What the shading stage left of one pixel.
struct PixelTruth {
  const float* sums = nullptr;        ///< RC_TRUTH_SUMS floats
  const float* abundance = nullptr;   ///< one float per material that the user named
  std::array<double, 3> to_target{};  ///< pixel-centre ray direction, any length
};

/// Fills one pixel's layers (truth_layer_names().size() floats).
void fill_truth(const PixelTruth& pixel, std::size_t materials, const scene::Sun& sun, float* layers);

/// Adds one image's layers of a pixel to sums of as many, in which means over hits are weighted by the hits. shares:
/// layers from `abundance` on.
void add_truth(const float* layers, std::size_t shares, double* sums);

/// Angles of view and sun, which are those of a pixel's middle.
void copy_angles_of_view(const float* from, float* to);

/// Layers of the mean of `count` images, from their sums; of the shares the first are the materials' abundances.
void mean_truth(const double* sums, int count, std::size_t materials, std::size_t shares, float* layers);

}  // namespace raycube::render
