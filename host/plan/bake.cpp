#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "host/base/error.h"
#include "host/plan/baked_rows.h"
#include "host/plan/band_truth.h"
#include "host/plan/curve.h"
#include "host/plan/plan.h"
#include "scene_compiler/matter.h"
#include "kernels/shared/tile_layout.h"

namespace raycube::plan {

namespace {

constexpr std::size_t kMostBaked_bytes = std::size_t{16} << 20;

/// Sum of the parts' curves, by environment function, times the light that each brings to the sensor.
std::vector<std::vector<double>> environment_spectra(const Plan& plan, std::size_t node) {
  const EnvironmentMap& map = plan.environment;
  if (node >= map.nodes())
    throw base::Error(base::Fault::bug,
                      "bake_row: environment " + std::to_string(node) + " of " + std::to_string(map.nodes()));
  const std::size_t grid = plan.wavelength_um.size(), channels = static_cast<std::size_t>(plan.environment_channels());
  std::vector<std::vector<double>> out(channels, std::vector<double>(grid));
  constexpr std::size_t block = 256;  // sums of so many wavelengths stay in the nearest cache
  for (std::size_t begin = 0; begin < grid; begin += block) {
    const std::size_t count = std::min(block, grid - begin);
    double molecules[block] = {}, aerosol[block] = {};
    for (std::size_t p = map.first_part[node]; p < map.first_part[node + 1]; ++p) {
      const auto& part = map.part[p];
      const double* reflectance = &map.reflectance[part.material][begin];
      for (std::size_t i = 0; i < count; ++i)
        molecules[i] += part.molecules * reflectance[i], aerosol[i] += part.aerosol * reflectance[i];
    }
    for (std::size_t c = 0; c < channels; ++c) {
      const double *by_molecules = &plan.environment_spectrum[c][begin],
                   *by_aerosol = &plan.environment_spectrum[channels + c][begin];
      for (std::size_t i = 0; i < count; ++i)
        out[c][begin + i] = molecules[i] * by_molecules[i] + aerosol[i] * by_aerosol[i];
    }
  }
  return out;
}

/// Of a source of lamps, [h * view.count + v].
std::vector<std::vector<double>> lamp_spectra_of(const Plan& plan, std::size_t source) {
  const auto nodes = static_cast<std::size_t>(plan.height.count * plan.view.count);
  const auto first = plan.source_spectrum.begin() +
                     static_cast<std::ptrdiff_t>((static_cast<std::size_t>(plan.first_lamp()) + source) * nodes);
  return {first, first + static_cast<std::ptrdiff_t>(nodes)};
}

/// Whether a key is of what a front emits less by its angle (RC_CURVE_LEANING): no light is scattered under it.
bool is_leaning(const Plan& plan, const scene::CompiledScene& scene, std::uint64_t key) {
  const auto records = static_cast<rc_id>(plan.matter.further_records);
  return rc_curve_role(rc_key_curve(key, 0), scene::material_count(scene)) == RC_CURVE_LEANING(records);
}

/// Product of a key's curves on the plan's grid; 1 without any. By the transmittance of an opaque material, or the
/// gloss of a dull one, nothing goes.
std::vector<double> product_of_curves(const Plan& plan, const scene::CompiledScene& scene, std::uint64_t key) {
  std::vector<double> product(plan.wavelength_um.size(), 1.0);
  // Not scene::curve_count, which looks through all materials: rows are baked for each of many.
  const std::uint32_t curves =
      (RC_CURVE_ROLES + static_cast<rc_id>(plan.matter.further_records)) * scene::material_count(scene);
  for (std::uint32_t c = 0; c < rc_key_count(key); ++c) {
    const std::uint32_t curve = rc_key_curve(key, c);
    if (curve > curves)
      throw base::Error(base::Fault::bug, "bake_row: curve " + std::to_string(curve) + " of " + std::to_string(curves));
    const std::vector<double> values = curve_on(scene, curve, plan.wavelength_um);
    for (std::size_t i = 0; i < product.size(); ++i) product[i] *= values[i];
  }
  return product;
}

/// What matter emits, over what a black body does: 1 less all that it sends back and lets through, of which each key of
/// one curve says its part; those of more nothing.
std::vector<double> emission_of(const Plan& plan, const scene::CompiledScene& scene, std::uint64_t key) {
  if (rc_key_count(key) > 1) return std::vector<double>(plan.wavelength_um.size(), 0.0);
  const std::uint32_t own = rc_key_curve(key, 0), materials = scene::material_count(scene);
  const std::uint32_t curve =
      is_leaning(plan, scene, key) ? scene::reflectance_curve(scene, rc_curve_material(own, materials)) : own;
  std::vector<double> out = curve_on(scene, curve, plan.wavelength_um);
  const double black = rc_curve_role(own, materials) == RC_CURVE_REFLECTANCE ? 1 : 0;
  for (double& value : out) value = black - value;
  return out;
}

/// What a plate sends where paths go through it, by channels of emission: its own light, and for what it lets through
/// the surroundings', beside which paths carry what differs from them. Empty of all else.
std::vector<std::vector<double>> plate_emission(const Plan& plan, const scene::CompiledScene& scene,
                                                std::uint64_t key) {
  if (key == 0 || !plan.bounces.any() || !plan.matter.plates) return {};
  const std::uint32_t curve = rc_key_curve(key, 0), materials = scene::material_count(scene),
                      material = rc_curve_material(curve, materials);
  if (rc_curve_role(curve, materials) != RC_CURVE_REFLECTANCE || !scene::is_plate(scene.materials[material])) return {};
  const std::vector<double> back = curve_on(scene, curve, plan.wavelength_um),
                            on = curve_on(scene, scene::transmittance_curve(scene, material), plan.wavelength_um);
  const auto nodes = static_cast<std::size_t>(plan.height.count * plan.view.count),
             first = static_cast<std::size_t>(plan.first_emission()) * nodes,
             around = static_cast<std::size_t>(plan.first_lamp() - 1) * nodes;
  std::vector<std::vector<double>> out(plan.source_spectrum.begin() + static_cast<std::ptrdiff_t>(first),
                                       plan.source_spectrum.end());
  for (std::size_t c = 0; c < out.size(); ++c)
    for (std::size_t i = 0; i < back.size(); ++i)
      out[c][i] =
          (1 - back[i] - on[i]) * out[c][i] + on[i] * std::numbers::pi * plan.source_spectrum[around + c % nodes][i];
  return out;
}

/// take(c, sum of weight times spectrum c from `first` on) of channels from .. to - 1, four at once: four sums that do
/// not wait for each other.
template <class Take>
void add_channels(const std::vector<double>& weight, std::size_t first, const std::vector<std::vector<double>>& spectra,
                  std::size_t from, std::size_t to, const Take& take) {
  std::size_t c = from;
  for (; c + 4 <= to; c += 4) {
    const double *s0 = &spectra[c][first], *s1 = &spectra[c + 1][first], *s2 = &spectra[c + 2][first],
                 *s3 = &spectra[c + 3][first];
    double sum[4] = {};
    for (std::size_t i = 0; i < weight.size(); ++i)
      sum[0] += weight[i] * s0[i], sum[1] += weight[i] * s1[i], sum[2] += weight[i] * s2[i],
          sum[3] += weight[i] * s3[i];
    for (std::size_t k = 0; k < 4; ++k) take(c + k, sum[k]);
  }
  for (; c < to; ++c) {
    double sum = 0;
    for (std::size_t i = 0; i < weight.size(); ++i) sum += weight[i] * spectra[c][first + i];
    take(c, sum);
  }
}

}  // namespace

bool BakedRows::read(std::uint64_t key, std::vector<float>& row) const {
  const std::lock_guard lock(mutex_);
  const auto found = rows_.find(key);
  if (found != rows_.end()) row = found->second;
  return found != rows_.end();
}

void BakedRows::keep(std::uint64_t key, const std::vector<float>& row) {
  const std::lock_guard lock(mutex_);
  if (bytes_ + row.size() * sizeof(float) > kMostBaked_bytes) return;
  if (rows_.emplace(key, row).second) bytes_ += row.size() * sizeof(float);
}

std::vector<float> bake_row(const Plan& plan, const scene::CompiledScene& scene, std::uint64_t key) {
  std::vector<float> out;
  if (plan.baked && plan.baked->read(key, out)) return out;
  const std::size_t bands = plan.bands.size(), padded = RC_PADDED(plan.columns());
  const bool skeleton = (key & kSkeletonKey) == kSkeletonKey, around = !skeleton && (key & kEnvironmentKey) != 0;
  const std::uint32_t curves = around || skeleton ? 0 : rc_key_count(key);
  const auto environment = around ? environment_spectra(plan, static_cast<std::size_t>(key ^ kEnvironmentKey))
                                  : std::vector<std::vector<double>>{};
  const std::size_t row = skeleton ? key ^ kSkeletonKey : 0,
                    lines = std::max<std::size_t>(1, plan.bounces.skeleton.size());
  const auto lamplight = skeleton && row >= lines ? lamp_spectra_of(plan, row / lines - 1) : environment;
  const auto& spectra = around       ? environment
                        : skeleton   ? (row < lines ? plan.bounces.together : lamplight)
                        : curves > 0 ? plan.source_spectrum
                                     : plan.path_spectrum;
  const bool leaning = curves == 1 && is_leaning(plan, scene, key);
  const std::vector<double> scattered = skeleton  ? plan.bounces.basis[row % lines]
                                        : leaning ? std::vector<double>(plan.wavelength_um.size(), 0.0)
                                                  : product_of_curves(plan, scene, curves > 0 ? key : 0);
  std::vector<double> emitted;
  if (curves > 0 && plan.thermal.on) emitted = emission_of(plan, scene, key);
  const auto first_emission = static_cast<std::size_t>(plan.first_emission() * plan.height.count * plan.view.count);
  const auto glass = plate_emission(plan, scene, curves == 1 && plan.thermal.on ? key : 0);
  const bool covers = curves > 0 && !plan.truth.empty();
  out.assign((spectra.size() + (covers ? 1 : 0)) * padded, 0.0f);
  const std::size_t all = spectra.size(), lit = curves > 0 ? std::min(first_emission, all) : all;
  const std::vector<double> one(glass.empty() ? 0 : plan.wavelength_um.size(), 1.0);
  std::vector<double> weight;
  for (std::size_t b = 0; b < bands; ++b) {
    const auto& band = plan.bands[b];
    const auto into = [&](const std::vector<double>& factor, const std::vector<std::vector<double>>& light,
                          std::size_t from, std::size_t to, std::size_t first) {
      weight = band.weight;
      for (std::size_t i = 0; i < weight.size(); ++i) weight[i] *= factor[band.first + i];
      add_channels(weight, band.first, light, from, to,
                   [&](std::size_t c, double sum) { out[(first + c) * padded + b] = static_cast<float>(sum); });
    };
    into(scattered, spectra, 0, lit, 0);
    if (!glass.empty())
      into(one, glass, 0, glass.size(), lit);
    else if (lit < all)
      into(emitted, spectra, lit, all, 0);
  }
  if (!plan.truth.empty()) bake_truth(plan, scene, key, padded, out);
  if (plan.baked) plan.baked->keep(key, out);
  return out;
}

}  // namespace raycube::plan
