// A sparse render of a few hundred pixels at several settings, and what it says of their errors. Its rays are counted.
//
// Settings are judged by replicates: renders of one setting with shifts and sky rays of their own, whose spread is
// their error. A first look at a few thousand pixels, with few samples, says where errors are; the pixels of the trial
// are drawn by it. Where a lawn has three trees, an even draw of a few hundred pixels does not see them, and all the
// error is there. A small image is tried whole. How many pixels are tried is known beforehand: four renders of them
// take a part of the image's own time (CostModel), whatever a clock would say.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "host/planner/cost_model.h"
#include "host/planner/trial_pixels.h"
#include "host/render/renderer.h"

namespace raycube::planner {

/// Sky directions of the first look; fewer where the file gives fewer. Its samples: SamplePattern::look.
inline constexpr int kLookDirections = 16;
/// Paths between surfaces that go with two rays into the sky, at most.
using scene::kMostPathsPerTwo;

/// Errors of samples and of sky directions, each by itself.
struct SettingErrors {
  TrialError samples, sky;
};

/// Begins the report of a part of a trial, of so many tiles; what it returns is told how many more are done.
using TrialProgress = std::function<std::function<void(std::uint64_t more)>(const std::string& what,
                                                                            std::uint64_t total, const std::string&)>;

class PixelTrial {
 public:
  /// `plan`: of the instrument, with any number of directions; `look_directions`: of the first look, which is rendered
  /// here. All must live as long as the trial.
  PixelTrial(render::Renderer& renderer, const scene::Simulation& simulation, const scene::Instrument& instrument,
             const plan::Plan& plan, int look_directions = kLookDirections, TrialProgress progress = {});

  /// How many paths between surfaces go with two rays into the sky, 1, 2, 4 or 8, where both together err least for
  /// their time: by another look, with the first one's samples and rays and more paths. 1 where light goes no further
  /// than one surface, or where no more would gain a tenth. What is rendered from then on has as many, and the first
  /// look's error of the sky is measured anew with them. To be called first.
  int choose_paths();

  /// What the first look found of its own setting.
  const SettingErrors& look() const { return look_; }

  /// Errors of a sampler that the seed moves (lattice, jittered) with so many samples and directions, by four
  /// replicates: two shifts of the samples, each under two draws of sky rays.
  SettingErrors replicates(scene::SamplerKind sampler, int samples_u, int samples_v, int directions);
  /// The same of so many samples of the instrument's pattern, which under a point spread are held against finer cells.
  SettingErrors replicates(int samples, int directions);

  /// Error of any sampler, a regular grid too, against random points in the cells of two finer grids: unbiased and
  /// independent of each other. The sky's own noise is left out by rendering twice with other rays.
  TrialError sampling_error(scene::SamplerKind sampler, int samples_u, int samples_v);

  /// Error of so many sky directions a pixel under a regular grid: two renders that differ in their rays alone.
  TrialError sky_error(int directions, int samples_u, int samples_v);

  /// The same under so many samples of the instrument's pattern, on the pixels that replicates have.
  TrialError sky_error(int samples, int directions);

  /// Error of the very draw that the image will have, of samples and sky together: against two means of renders with
  /// shifts and rays of their own, on all pixels of an image that is tried whole, else on those that replicates have.
  /// Where a few pixels hold all the error, one draw may be twice as far off as the next.
  TrialError own_draw(int samples, int directions);

  /// Whether any pixel of the look has of the materials that the tolerance is of; else all pixels count.
  bool meets_listed() const { return meets_listed_; }
  bool whole() const { return left_out_ <= 0; }         ///< the look saw every pixel, and so does a trial
  std::size_t pixels() const { return pixels_; }        ///< of the last trial
  std::size_t looked_at() const { return looked_at_; }  ///< of the first look
  std::uint64_t rays() const { return rays_; }          ///< traced so far, sky rays towards a surface's back included
  double cost_s() const { return cost_s_; }             ///< by the cost model

 private:
  /// An image for each draw.
  std::vector<TrialImage> render(const scene::Instrument& instrument, int directions,
                                 const std::vector<render::PixelDraw>& draws);
  SettingErrors replicates_on_pixels(const scene::Instrument& sampled, int directions);
  SettingErrors replicates(const scene::Instrument& tried, int directions);
  void draw_for_replicates(const scene::Instrument& tried, int directions);
  SettingErrors with_cells(int samples, SettingErrors found);
  scene::Instrument sampled(scene::SamplerKind sampler, int samples_u, int samples_v) const;
  scene::Instrument sampled(int samples) const;
  double pixel_cost_s(const scene::Instrument& sampled, int directions);
  void make_look(int directions);
  void weigh_look();
  std::vector<float> weights_of_tiles() const;
  void draw_pixels(int draws, int whole);
  void make_references();

  render::Renderer& renderer_;
  const scene::Simulation& simulation_;
  scene::Instrument instrument_;
  plan::Plan plan_;  ///< with the directions of the last render
  int look_directions_ = 0;
  std::vector<render::Tile> looked_;
  std::vector<float> look_weight_;  ///< of each pixel of the look in the figure that is judged; empty: all alike
  bool meets_listed_ = true;
  std::vector<double> look_error_;  ///< mean square that each of its runs was seen to err by
  std::vector<render::Tile> tiles_;
  std::vector<Draw> draws_;  ///< of the tiles; empty: the first look
  double pixels_per_run_ = 0, drawn_from_ = 0, left_out_ = 0;
  bool whole_ = false;  ///< every pixel is tried
  std::size_t pixels_ = 0, looked_at_ = 0;
  SettingErrors look_;
  TrialError look_pair_;  ///< of the look's sky, by its first two draws alone
  TrialImage one_, two_;
  std::vector<double> mean_;
  std::uint64_t rays_ = 0;
  double cost_s_ = 0;
  TrialProgress progress_;
};

}  // namespace raycube::planner
