// A sparse render of a few hundred pixels at several settings, and what it says of their errors. Its rays are counted.
//
// A first look at a few thousand pixels, two renders with few samples, says where errors are; the trial's runs are
// drawn by it. Where a lawn has three trees, an even draw of a few hundred pixels does not see them, and all the error
// is there. A small image is tried whole.
#pragma once

#include <cstdint>

#include "host/planner/cost_model.h"
#include "host/planner/trial_pixels.h"
#include "host/render/renderer.h"

namespace raycube::planner {

class PixelTrial {
 public:
  /// `plan`: of the instrument, with any number of directions. Nothing is rendered yet. All must live as long as the
  /// trial.
  PixelTrial(render::Renderer& renderer, const scene::Simulation& simulation, const scene::Instrument& instrument,
             const plan::Plan& plan);

  /// Error of a sampler with u x v cells, against random points in the cells of two finer grids: unbiased and
  /// independent of each other. The sky's own noise, which is the sky trial's matter, is left out by rendering twice
  /// with other rays.
  TrialError sampling_error(scene::SamplerKind sampler, int samples_u, int samples_v);

  /// Error of so many sky directions a pixel: two renders of one grid of samples (u x v).
  TrialError sky_error(int directions, int samples_u, int samples_v);

  std::size_t pixels() const { return pixels_; }        ///< of the trial
  std::size_t looked_at() const { return looked_at_; }  ///< of the first look
  std::uint64_t rays() const { return rays_; }          ///< traced so far, sky rays towards a surface's back included
  double cost_s() const { return cost_s_; }             ///< by the cost model

 private:
  /// sky_draw: renders of one seed and other draws differ by the sky's rays alone.
  TrialImage render(const scene::Instrument& instrument, int directions, std::uint64_t seed, std::uint32_t sky_draw);
  scene::Instrument sampled(scene::SamplerKind sampler, int samples_u, int samples_v) const;
  void look();
  void make_references();

  render::Renderer& renderer_;
  const scene::Simulation& simulation_;
  scene::Instrument instrument_;
  plan::Plan plan_;  ///< with the directions of the last render
  std::vector<render::Tile> tiles_;
  std::vector<Draw> draws_;  ///< of the tiles; empty: the first look
  double pixels_per_run_ = 0, drawn_from_ = 0, left_out_ = 0;
  bool whole_ = false;  ///< every pixel is tried
  std::size_t pixels_ = 0, looked_at_ = 0;
  TrialImage one_, two_;
  std::vector<double> mean_;
  std::uint64_t rays_ = 0;
  double cost_s_ = 0;
};

}  // namespace raycube::planner
