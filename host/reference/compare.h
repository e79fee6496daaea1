// Device against reference, pixel by pixel, on the same fp32 rays: hits, sun, radiance of every band, and the full
// tables. Light between surfaces, of which paths differ, has a report of its own in it.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "atmos_tables/render_table.h"
#include "host/reference/bounced_report.h"
#include "host/reference/replay_report.h"
#include "host/reference/first_hits.h"
#include "host/reference/radiance.h"
#include "host/reference/tie_search.h"

namespace raycube::reference {

/// What the device said about one pixel.
struct DevicePixel {
  PixelAddress address;
  std::vector<Hit> hits;                  ///< [sample]
  std::vector<std::uint8_t> sun_visible;  ///< [side][sample]; read where the side of the surface faces the sun
  /// [side][sample][plane of met sky, kernels/shared/tile_layout.h]: irradiance that the sample's rays add; of lamps.
  std::vector<float> sky_met;
  std::vector<float> radiance;  ///< [band], W m-2 sr-1 um-1
};

/// Beyond these the check fails (DESIGN section 7).
struct Limits {
  double median = 1e-6;      ///< of each band's relative differences
  double worst = 2e-5;       ///< of any band of any pixel
  double band_floor = 1e-9;  ///< differences are relative to max(|L_b|, band_floor x the pixel's largest band)
  double model = 0.01;       ///< `tolerance`: rms over pixels / band mean, worst band
  double sky = 4e-6;  ///< of what a sample's rays bring, relative to all they could: fp32 cosines, densities and maps
};

struct CompareOptions {
  Limits limits;
  int threads = 0;                            ///< 0: all
  const atmos::RenderTable* table = nullptr;  ///< null: no comparison with the model
  bool no_air = false;
  std::size_t model_pixels = 64;  ///< the first so many pixels are compared with the model
  int model_directions = 1024;
  bool beside_paths = false;  ///< of the model: light between surfaces is compared apart (TableModel)
};

/// One band over the agreeing pixels.
struct BandDifference {
  double median = 0, rms = 0, max = 0;
};

/// A figure of section 5a: rms over pixels of the difference / the band's mean, worst band.
struct ModelDifference {
  double figure = 0;
  std::size_t band = 0;
};

struct Report {
  Limits limits;
  HitReport first_hits;  ///< of many more rays than those of the pixels below; may be empty
  std::uint64_t pixels = 0, rays = 0;
  std::array<std::uint64_t, kCauses> hits{};  ///< by Cause
  std::uint64_t hit_miss = 0;                 ///< of the disagreements: one hit, the other missed
  std::uint64_t sun_rays = 0, sun_explained = 0, sun_unexplained = 0;
  std::uint64_t sky_rays = 0, sky_explained = 0;  ///< rays
  std::uint64_t sky_unexplained = 0;              ///< samples whose met sky no ties account for
  std::uint64_t lamp_rays = 0, lamp_explained = 0, lamp_unexplained = 0;
  std::uint64_t excluded_pixels = 0;  ///< pixels with an unexplained hit, ray to sun or lamp, or sky
  std::vector<BandDifference> bands;  ///< over the other pixels
  double worst_median = 0, worst = 0;
  std::size_t worst_band = 0;
  std::uint32_t worst_line = 0, worst_sample = 0;
  std::uint64_t beyond_pixels = 0;  ///< pixels with a band beyond limits.worst that nothing explains
  std::size_t model_pixels = 0;
  ModelDifference model_total, model_sun, model_sky, model_path;
  bool lamps = false;  ///< the plan has lamps
  ModelDifference model_lamps;
  bool adjacency = false;  ///< the plan carries light between ground and air
  ModelDifference model_environment;
  bool thermal = false;
  ModelDifference model_emission, model_surroundings;
  BouncedReport bounced;  ///< of its own pixels, as the next; the figures above are of light scattered once
  ReplayReport replayed;
  /// log10 of each pixel's relative difference, [pixel in order of number][band]
  std::vector<std::vector<float>> picture;
  std::vector<std::uint32_t> picture_line;  ///< image line of each of its rows

  std::vector<std::string> failures() const;  ///< one line per limit that is not met; empty: the check holds
  std::string text(const std::vector<std::string>& band_names) const;
  std::string json() const;
};

/// Picture of all differences: one column per band, one row per pixel (at most `rows`, then the worst of each bunch);
/// black below 1e-9, blue, green, yellow at 1e-6, red from 2e-5. RGB, 8 bit.
struct Picture {
  int width = 0, height = 0;
  int bunch = 1;  ///< pixels that a row stands for
  std::vector<std::uint8_t> rgb;
};
/// Its colour of a relative difference, given as the logarithm.
std::array<std::uint8_t, 3> difference_colour(float log10_difference);
Picture difference_picture(const Report& report, int rows = 1024);

class Comparison {
 public:
  /// Keeps references to everything but the options.
  Comparison(const scene::CompiledScene& scene, const plan::Plan& plan, const scene::Instrument& instrument,
             std::uint64_t seed, const CompareOptions& options);
  ~Comparison();

  /// Compares these pixels, on several threads. Order of pixels decides nothing but which meet the model.
  void add(const std::vector<DevicePixel>& pixels);
  Report report() const;

 private:
  struct Result;
  Result compare(const DevicePixel& pixel, bool with_model) const;
  /// The sun's ray from a side of a sample's surface; where the two part by a tie, the side goes the device's way.
  void compare_sun(Sample& side, bool device_sees, Result& result) const;
  /// Light of lamps on a side, W m-2, [source]: the device's where the reference's draw agrees with it or is a tie.
  std::vector<double> compare_lamps(const Sample& side, std::uint32_t pixel, std::uint32_t sample, const float* device,
                                    Result& result) const;
  void compare_sky(const Sample& sample, const float* device, SentRays& sent, Result& result) const;

  const plan::Plan& plan_;
  const scene::Instrument& instrument_;
  std::uint64_t seed_;
  CompareOptions options_;
  ReferenceScene scene_;
  ArithmeticModel arithmetic_;
  Components brightest_{};  ///< of each of the sky's components, any direction
  std::unique_ptr<TableModel> model_;
  std::vector<Result> results_;
};

}  // namespace raycube::reference
