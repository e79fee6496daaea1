// The pixels of a trial: short runs of a line, picked by a hash of seed and a counter, more often where a first look
// found errors; and statistics over them.
#pragma once

#include <cstdint>
#include <vector>

#include "host/planner/band_errors.h"
#include "host/render/tile_shape.h"
#include "scene_compiler/simulation.h"

namespace raycube::planner {

inline constexpr int kTrialRuns = 64, kRunPixels = 8;
/// Runs of the first look (all of an image that has no more), and how many of them are drawn where references are dear
/// (some more than once).
inline constexpr int kLookRuns = 1024, kDraws = 128;
/// An image of no more runs, whose rays are soon traced, is judged whole.
inline constexpr int kWholeRuns = 512;

/// How a run came into a trial.
struct Draw {
  std::size_t run = 0;  ///< of those it was drawn from
  int times = 1;
  double share = 1;  ///< its chance over that of an even draw
};

/// At most `draws` draws, run i with a chance that grows with `error[i]` (>= 0: mean squares that a first look found):
/// half of the draws by it, a quarter by its root, a quarter even. Evenly spaced along the sum of chances from one
/// hashed place, in the order of the runs. All runs, evenly, where there are no more than `whole`.
std::vector<Draw> draw_runs(const std::vector<double>& error, std::uint64_t seed, int draws = kDraws,
                            int whole = kTrialRuns);

/// At most `runs` runs of kRunPixels pixels (fewer at a line's end), in the order of the image; every pixel of a small
/// image.
std::vector<render::Tile> trial_tiles(const scene::Instrument& instrument, std::uint64_t seed, int runs = kTrialRuns);

/// The same runs, those side by side on a line as one tile of at most `columns` pixels: fewer launches.
std::vector<render::Tile> joined(const std::vector<render::Tile>& runs, int columns);

/// Radiances of the trial's pixels.
struct TrialImage {
  std::size_t bands = 0;
  std::vector<std::size_t> run_end;                     ///< pixels up to and with each run
  std::vector<float> radiance;                          ///< [pixel][band]
  std::vector<Draw> draw;                               ///< of each run; empty: an even draw, each once
  double pixels_per_run = 0;                            ///< on average, of the runs drawn from; 0: of these
  double drawn_from = 0;                                ///< so many runs; 0: of all the image
  double left_out = 0;                                  ///< share of the image that those leave out
  bool whole = false;                                   ///< every pixel of the image, once
  scene::ErrorFigure figure = scene::ErrorFigure::rms;  ///< that errors are told by
  std::vector<float> weight = {};  ///< of each pixel in that figure and in the bands' means; empty: all count alike
  std::size_t pixels() const { return bands ? radiance.size() / bands : 0; }
};

/// An error by the image's figure, relative to the band's mean, of the worst band. The rms is as DESIGN 5a has it.
/// Another figure is told as the rms times what it is over the rms among the errors that are seen of single pixels:
/// what is known of their mean square without bias stays so, and as good as those of Gaussian draws are (of draws in
/// two that differ a pixel's error is seen as their difference over the root of two). The worst pixel of an image that
/// is not tried whole is extrapolated: excesses over a high error are exponential (Pickands, Ann. Stat. 3, 119, 1975).
struct TrialError {
  double estimate = 0;  ///< from the mean square found (0 where that is below 0)
  double bound =
      /// with one standard error of the mean square on top: over the runs; of a whole image that of its random points
      /// alone
      0;
  BandErrors bands = {};  ///< the same of each band; empty: not told
};

/// Of pixels, from what cells of theirs err (host/sensors/cells.h): their draws are their own, and of a pixel's weights
/// the root of the sum of the squares counts, the largest of all bands'.
TrialError of_pixels(TrialError error, const scene::Instrument& instrument);

/// Mean radiance of each band, held against 1e-4 of the largest.
std::vector<double> judged_means(const TrialImage& image);
/// The same from sums over so many pixels.
std::vector<double> judged_means(std::vector<double> sums, double pixels);

/// Mean square over pixels and bands of each run's difference between two images, over the bands' means.
std::vector<double> run_differences(const TrialImage& one, const TrialImage& two, const std::vector<double>& mean);

/// Error of an image against the truth that `one` and `two` scatter about: E[(a - r1)(a - r2)] = E[(a - truth)^2] for
/// references that are without bias and independent of each other, however coarse they are.
TrialError error_against(const TrialImage& image, const TrialImage& one, const TrialImage& two,
                         const std::vector<double>& mean);

/// The same without the noise of the sky: `again` has the image's samples and other sky rays, and
/// E[(a - r1)(b - r2)] is what a and b have in common.
TrialError common_error(const TrialImage& image, const TrialImage& again, const TrialImage& one, const TrialImage& two,
                        const std::vector<double>& mean);

/// Error of an image against another that is the truth.
TrialError error_from(const TrialImage& image, const TrialImage& truth, const std::vector<double>& mean);

/// Error of each of two images that differ by independent draws alone: half their mean squared difference.
TrialError error_between(const TrialImage& one, const TrialImage& two, const std::vector<double>& mean);

/// The same of two such pairs: `one` and `one_again`, `two` and `two_again`.
TrialError error_between_pairs(const TrialImage& one, const TrialImage& one_again, const TrialImage& two,
                               const TrialImage& two_again, const std::vector<double>& mean);

/// Error that `one` and `one_again` have in common, as `two` and `two_again` have another draw of it: without what
/// tells one from one_again. With a = e + m + n each, E[(one - two)(one_again - two_again)] / 2 = E[e^2].
TrialError common_spread(const TrialImage& one, const TrialImage& one_again, const TrialImage& two,
                         const TrialImage& two_again, const std::vector<double>& mean);

}  // namespace raycube::planner
