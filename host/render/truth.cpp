#include "host/render/truth.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "host/base/units.h"
#include "kernels/shared/tile_layout.h"
#include "scene_compiler/matter.h"

namespace raycube::render {

std::vector<LayerName> truth_layer_names(const scene::CompiledScene& scene) {
  std::vector<LayerName> layers = {
#define RC_TRUTH_LAYER(name, unit, text) {#name, unit, text},
#include "kernels/shared/truth_layers.def"
#undef RC_TRUTH_LAYER
  };
  for (const auto& material : scene.materials)
    if (material.in_family == 0)
      layers.push_back({"abundance_" + material.name, "1", "share of the pixel covered by " + material.name});
  return layers;
}

namespace {

/// Number from 1 of the largest share among the materials that count, ties to the lower; 0: there is none.
template <class Counts>
float largest_share(const float* shares, std::size_t materials, Counts&& counts) {
  float best = 0, id = 0;
  for (std::size_t m = 0; m < materials; ++m)
    if (shares[m] > best && counts(m)) best = shares[m], id = static_cast<float>(m + 1);
  return id;
}

bool knows_temperatures(const scene::CompiledScene& scene) {
  return std::any_of(scene.materials.begin(), scene.materials.end(),
                     [](const scene::Material& material) { return material.temperature_K > 0; });
}

}  // namespace

std::size_t share_layers(const scene::CompiledScene& scene, const scene::Instrument& instrument) {
  return scene::named_count(scene) * (instrument.first_opaque ? 2 : 1);
}

std::vector<LayerName> truth_layer_names(const scene::CompiledScene& scene, const scene::Instrument& instrument) {
  std::vector<LayerName> layers = truth_layer_names(scene);
  if (instrument.first_opaque)
    for (const auto& material : scene.materials)
      if (material.in_family == 0)
        layers.push_back({"opaque_abundance_" + material.name, "1",
                          "share of the pixel whose rays meet " + material.name +
                              " first of what lets no light through, past all leaves"});
  if (instrument.standard_error != scene::StandardError::off) {
    layers.push_back(
        {"standard_error", "1",
         "of the samples: the worst band's, over that band's mean over the scene; not a number: not known"});
    layers.push_back({"not_converged", "1", "1: the standard error is above the tolerance or not known"});
  }
  const bool warm = knows_temperatures(scene);
  if (warm)
    layers.push_back(
        {"temperature_K", "K", "mean of the materials that are seen, by their areas; not a number where one has none"});
  if (!instrument.first_opaque) return layers;
  for (const std::string kind : {"opaque", "transparent"}) {
    const std::string what = kind == "opaque" ? "first lets no light through" : "is seen and lets light through";
    layers.push_back({kind + "_material_id", "index", "material with the largest share of what " + what + "; 0: none"});
    if (warm) layers.push_back({kind + "_temperature_K", "K", "mean temperature of what " + what});
  }
  return layers;
}

DerivedLayers::DerivedLayers(const scene::CompiledScene& scene, const scene::Instrument& instrument)
    : stride_(truth_layer_names(scene, instrument).size()),
      first_(truth::abundance + share_layers(scene, instrument) +
             (instrument.standard_error != scene::StandardError::off ? 2 : 0)),
      materials_(scene::named_count(scene)),
      knows_temperatures_(knows_temperatures(scene)),
      first_opaque_(instrument.first_opaque) {
  for (const auto& material : scene.materials) {
    if (material.in_family != 0) continue;
    temperature_K_.push_back(material.temperature_K > 0 ? material.temperature_K
                                                        : std::numeric_limits<double>::quiet_NaN());
    through_.push_back(scene::lets_light_through(material) || scene::is_plate(material));
  }
}

void DerivedLayers::fill(std::size_t pixels, float* layers) const {
  const auto mean_K = [&](const float* shares, auto&& counts) {
    double covered = 0, sum = 0;
    for (std::size_t m = 0; m < materials_; ++m)
      if (const double share = double{shares[m]}; share > 0 && counts(m))
        covered += share, sum += share * temperature_K_[m];
    return covered > 0 ? static_cast<float>(sum / covered) : std::numeric_limits<float>::quiet_NaN();
  };
  const auto all = [](std::size_t) { return true; };
  const auto through = [&](std::size_t m) { return through_[m] != 0; };
  for (std::size_t p = 0; p < pixels; ++p, layers += stride_) {
    const float *seen = layers + truth::abundance, *opaque = seen + materials_;
    float* to = layers + first_;
    if (knows_temperatures_) *to++ = mean_K(seen, all);
    if (!first_opaque_) continue;
    *to++ = largest_share(opaque, materials_, all);
    if (knows_temperatures_) *to++ = mean_K(opaque, all);
    *to++ = largest_share(seen, materials_, through);
    if (knows_temperatures_) *to++ = mean_K(seen, through);
  }
}

namespace {

/// Angles whose cosines are means over hits.
constexpr truth::Layer kAngles[] = {truth::sun_incidence_deg, truth::view_incidence_deg};
/// Means over hits, of which hits without any are none.
constexpr truth::Layer kOverHits[] = {truth::sun_fraction, truth::x_m, truth::y_m, truth::z_m, truth::range_m};
/// The same in every image: of the pixel's centre and of the sun.
constexpr truth::Layer kInCommon[] = {truth::view_zenith_deg, truth::view_azimuth_deg, truth::sun_zenith_deg,
                                      truth::sun_azimuth_deg};

float angle_deg(double cosine) {
  return static_cast<float>(base::deg_from_rad(std::acos(std::clamp(cosine, -1.0, 1.0))));
}

/// The material with the largest abundance, from 1; 0: none.
float main_material(const float* layers, std::size_t materials) {
  return largest_share(layers + truth::abundance, materials, [](std::size_t) { return true; });
}

}  // namespace

void add_truth(const float* layers, std::size_t shares, double* sums) {
  const double hit = layers[truth::hit_fraction];
  sums[truth::hit_fraction] += hit;
  for (const auto layer : kInCommon) sums[layer] = layers[layer];
  for (std::size_t m = 0; m < shares; ++m) sums[truth::abundance + m] += layers[truth::abundance + m];
  if (hit == 0) return;
  for (const auto layer : kOverHits) sums[layer] += hit * layers[layer];
  for (const auto layer : kAngles) sums[layer] += hit * std::cos(base::rad_from_deg(layers[layer]));
}

void copy_angles_of_view(const float* from, float* to) {
  for (const auto layer : kInCommon) to[layer] = from[layer];
}

void mean_truth(const double* sums, int count, std::size_t materials, std::size_t shares, float* layers) {
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  const double hit = sums[truth::hit_fraction];
  layers[truth::hit_fraction] = static_cast<float>(hit / count);
  for (const auto layer : kInCommon) layers[layer] = static_cast<float>(sums[layer]);
  for (const auto layer : kOverHits) layers[layer] = hit > 0 ? static_cast<float>(sums[layer] / hit) : kNone;
  if (hit == 0) layers[truth::sun_fraction] = 0;
  for (const auto layer : kAngles) layers[layer] = hit > 0 ? angle_deg(sums[layer] / hit) : kNone;
  for (std::size_t m = 0; m < shares; ++m)
    layers[truth::abundance + m] = static_cast<float>(sums[truth::abundance + m] / count);
  layers[truth::material_id] = main_material(layers, materials);
}

void fill_truth(const PixelTruth& pixel, std::size_t materials, const scene::Sun& sun, float* layers) {
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  const float hit = pixel.sums[RC_TRUTH_HIT];
  const auto mean = [&](int sum) { return hit > 0 ? pixel.sums[sum] / hit : kNone; };

  for (std::size_t m = 0; m < materials; ++m) layers[truth::abundance + m] = pixel.abundance[m];
  layers[truth::material_id] = main_material(layers, materials);
  layers[truth::hit_fraction] = hit;
  layers[truth::sun_fraction] = hit > 0 ? pixel.sums[RC_TRUTH_SUN] / hit : 0.0f;
  layers[truth::x_m] = mean(RC_TRUTH_X);
  layers[truth::y_m] = mean(RC_TRUTH_Y);
  layers[truth::z_m] = mean(RC_TRUTH_Z);
  layers[truth::range_m] = mean(RC_TRUTH_RANGE);
  const auto& d = pixel.to_target;
  const double length = std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
  const double azimuth_deg = base::deg_from_rad(std::atan2(-d[0], -d[1]));
  layers[truth::view_zenith_deg] =
      static_cast<float>(base::deg_from_rad(std::acos(std::clamp(-d[2] / length, -1.0, 1.0))));
  layers[truth::view_azimuth_deg] = static_cast<float>(azimuth_deg < 0 ? azimuth_deg + 360.0 : azimuth_deg);
  layers[truth::sun_zenith_deg] = static_cast<float>(sun.zenith_deg);
  layers[truth::sun_azimuth_deg] = static_cast<float>(sun.azimuth_deg);
  layers[truth::sun_incidence_deg] = hit > 0 ? angle_deg(double{mean(RC_TRUTH_INCIDENCE)}) : kNone;
  layers[truth::view_incidence_deg] = hit > 0 ? angle_deg(double{mean(RC_TRUTH_VIEW)}) : kNone;
}

}  // namespace raycube::render
