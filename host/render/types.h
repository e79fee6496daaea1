// What goes into a render and what comes out of it: options, strips of the image, statistics, probes. Plain data, for
// those who take results without driving a device.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "host/render/device_tuning.h"
#include "host/render/tile_shape.h"

namespace raycube::render {

struct RenderOptions {
  std::string device;                     ///< part of the device's name, or its number; empty: the first
  int threads = 0;                        ///< CPU devices: worker threads; 0 = all
  std::size_t memory_bytes = 2ull << 30;  ///< for tiles, band table and strips, on device and host together
  int tile_lines = 0;                     ///< forces the tile height (tests); 0 = from memory
  std::size_t page_bytes = 0;  ///< largest page of the scene's arrays (tests); 0 = half the device's largest buffer
  int row_capacity = 16;       ///< keys a row holds before the overflow path (tests: 1, 2, 16, 256)
  bool tuned = false;          ///< launches of the sizes that `raycube tune` kept for the device, where it did
  std::optional<DeviceTuning> tuning = {};  ///< forces sizes of launches (tests)
};

/// A part of a pixel's radiance: weight times what plan::bake_row has of the key in the channel.
struct Term {
  std::uint64_t key = 0;
  std::uint32_t channel = 0;
  double weight = 0;
};
using PixelTerms = std::vector<Term>;

/// Lines of the finished image, whole or a part of each.
struct Strip {
  int first_line = 0, lines = 0;
  const float* radiance = nullptr;  ///< [line][sample][column]: bands, W m-2 sr-1 um-1, then those of truth per band
  const float* truth = nullptr;     ///< [line][sample][layer], see truth_layer_names(scene, instrument)
  const float* band_error =
      nullptr;  ///< [line][sample][column], standard error of each; null unless the instrument asks for bands
  int first_sample = 0, samples = 0;  ///< of each line; 0: all
  std::size_t columns = 0;            ///< plan::Plan::columns(); 0: the instrument's bands
};
using StripSink = std::function<void(const Strip&)>;
using ProgressSink = std::function<void(std::uint64_t done_pixels, std::uint64_t all_pixels)>;

/// What a mean over replicates errs, as sums over pixels for each band: tiles and images add.
struct ReplicateSpread {
  double pixels = 0;
  std::vector<double> radiance;  ///< of the mean
  std::vector<double> square;    ///< of the mean's error: sum over replicates of (x - mean)^2 / (R (R - 1))
  std::vector<double> noise;     ///< variance of `square` by Gaussian draws, for which square^2 2 / (R + 1) stands
  void add(const ReplicateSpread& other);
};

/// What a render did and took.
struct RenderStatistics {
  std::map<std::string, double> stage_s;  ///< wall seconds by stage, of a device's from launch to end
  std::uint64_t primary_rays = 0, sun_rays = 0, sky_rays = 0;
  std::uint64_t paths = 0;  ///< of light between surfaces; how far each goes is chance, and known to the device alone
  std::uint64_t band_samples = 0;
  std::uint64_t overflow_pixels = 0;    ///< pixels that left the first row capacity
  std::uint64_t per_sample_pixels = 0;  ///< pixels past the largest row
  std::uint32_t terms_p50 = 0, terms_p95 = 0;
  std::string program_hash;                  ///< SHA-256 of source and options of the programs launched
  std::string trace_program_hash;            ///< of the tracing programs alone
  std::vector<std::string> kernel_variants;  ///< build options of what traced, by program
  int tile_lines = 0, tile_columns = 0;
  ReplicateSpread spread;                                 ///< of an image that is a mean of replicates
  std::map<int, std::uint64_t> small_object_pixels;       ///< by samples: rendered anew for small objects
  std::uint64_t adaptive_pixels = 0, refined_pixels = 0;  ///< given a first look; of these, rendered with all samples
};

/// Adds times and counts of another part of the same render; what is of the whole stays.
void add_counts(RenderStatistics& sum, const RenderStatistics& part);

/// First hits of a tile's rays.
struct HitProbe {
  Tile tile;
  int samples = 0;  ///< per pixel
  std::vector<shared::RayGroup> groups;
  std::vector<std::uint32_t> hit_instance, hit_primitive;  ///< [pixel][sample], RC_NONE = miss; samples unpadded
};

/// A few pixels with everything the stages said about them, for `check` and the tests.
struct PixelProbe : HitProbe {
  int sides = 1;                          ///< slots of a sample (scene::CameraMatter), the near side first
  std::vector<std::uint8_t> sun_visible;  ///< [pixel][side][sample]
  std::vector<float> sky_met;   ///< [pixel][side][sample][plane], irradiance that its rays add, then that of lamps
  std::vector<float> radiance;  ///< [pixel][band]
  std::vector<float> truth;     ///< [pixel][layer]
  /// Where the plan asks for them (Bounces::logged): [pixel][numbered path][levels + 1], and what the paths bring at
  /// the skeleton's wavelengths, of all sources but lamps, [pixel][wavelength].
  std::vector<shared::PathStep> steps;
  std::vector<double> glow;
};

/// What a pixel's samples and sky rays are drawn by: of one seed and other sky draws only the sky's rays differ.
struct PixelDraw {
  std::uint64_t seed = 0;
  std::uint32_t sky_draw = 0;
};

using ProbeSink = std::function<void(const PixelProbe&)>;
using HitSink = std::function<void(const HitProbe&)>;

}  // namespace raycube::render
