// The stage graph on one device: a compiled scene uploaded once, then instruments rendered tile by tile.
//
//   ray groups -> trace_primary -> make_surface -> trace_sun -> trace_sky -> shade -> (host bakes missing rows)
//              -> resolve -> integrate_bands -> strip on the host
//
// Light of lamps (trace_lamps, after trace_sky) joins in shade. That between surfaces (trace_bounce, after both, where
// the plan has it) joins in resolve, as rows of the band table for the skeleton's wavelengths; so does light that the
// air scatters in from the ground around.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/cl/context.h"
#include "host/plan/plan.h"
#include "host/render/device_tuning.h"
#include "host/render/replicates.h"
#include "host/render/types.h"
#include "host/sensors/scene_objects.h"
#include "scene_compiler/simulation.h"

namespace raycube::render {

class Renderer {
 public:
  /// Uploads the scene. Throws Error(device | environment | input) when there is no device or the scene does not fit.
  Renderer(const scene::CompiledScene& scene, const RenderOptions& options);
  ~Renderer();
  Renderer(Renderer&&) noexcept;

  /// Renders one instrument; strips arrive in line order, on one thread of their own so that writing overlaps tracing.
  /// `rendered`: its replicates, where they have been; then only what small objects need is traced. Throws
  /// Error(interrupted) on Ctrl-C.
  RenderStatistics render(const scene::Instrument& instrument, const plan::Plan& plan, const scene::Sun& sun,
                          std::uint64_t seed, const StripSink& sink, const ProgressSink& progress = {},
                          const RenderedImage* rendered = nullptr);

  /// An image without a replicate, and `count` more of them: the very ones that render would average. Neither adaptive
  /// samples nor standard errors.
  RenderedImage no_replicates(const scene::Instrument& instrument) const;
  void add_replicates(const scene::Instrument& instrument, const plan::Plan& plan, const scene::Sun& sun,
                      std::uint64_t seed, int count, RenderedImage& image, const ProgressSink& progress = {});

  /// Renders tiles (first_column a multiple of 4; full width, or one line) and hands each to the sink with
  /// everything the stages said about it: of an instrument with adaptive samples only radiance and truth;
  /// where small objects are on, hits and visibilities are those of the ordinary samples in every pixel.
  /// Programs are built once for all of them. Without a sink nothing is collected: what is timed is what
  /// render does.
  RenderStatistics probe(const scene::Instrument& instrument, const plan::Plan& plan, const scene::Sun& sun,
                         std::uint64_t seed, const std::vector<Tile>& tiles, const ProbeSink& sink);

  /// What one pixel of the image is made of, as render makes it: its radiances and their terms.
  struct PixelParts {
    std::vector<float> radiance;  ///< [band], the bits that render writes
    PixelTerms terms;
  };
  PixelParts parts_of(const scene::Instrument& instrument, const plan::Plan& plan, const scene::Sun& sun,
                      std::uint64_t seed, int line, int sample);

  /// The same in few launches, for many small tiles: they are put together as long as they take little memory, and each
  /// is handed on by itself, bit for bit as probe does. Of adaptive samples, small objects and replicates it is probe.
  void probe_together(const scene::Instrument& instrument, const plan::Plan& plan, const scene::Sun& sun,
                      std::uint64_t seed, const std::vector<Tile>& tiles, const ProbeSink& sink);

  /// Radiances of the tiles' pixels under each of the draws, [draw][pixel][band], as quickly. Neither adaptive samples
  /// nor small objects nor replicates. progress: told of tiles that are done, of all.
  std::vector<std::vector<float>> draws_of(const scene::Instrument& instrument, const plan::Plan& plan,
                                           const scene::Sun& sun, const std::vector<PixelDraw>& draws,
                                           const std::vector<Tile>& tiles, const ProgressSink& progress = {});

  /// The same tiles' first hits and nothing else: trace_primary alone, by the very program that render launches.
  void probe_hits(const scene::Instrument& instrument, std::uint64_t seed, const std::vector<Tile>& tiles,
                  const HitSink& sink);

  /// Builds an instrument's programs, or takes them from the cache of kernels: the first launch then finds them.
  void load_programs(const scene::Instrument& instrument, const plan::Plan& plan);

  /// Largest tile of a render whose launches are of about `tile_samples` samples, as memory and image allow.
  TileSize tile_size(const scene::Instrument& instrument, const plan::Plan& plan, std::size_t tile_samples) const;

  /// What the options grant for tiles.
  std::size_t memory_bytes() const;
  /// Small objects of the scene, known to whoever looks at it first.
  sensors::KnownObjects& objects();
  std::string device_name() const;
  /// What launches use now.
  DeviceTuning tuning() const;
  /// Its sizes of launches may be set, and kernels timed, between renders.
  cl::Context& context();

 private:
  struct State;
  class TilesTogether;
  std::unique_ptr<State> state_;
};

}  // namespace raycube::render
