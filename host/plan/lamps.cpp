#include "host/plan/lamps.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/format.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "host/base/units.h"
#include "host/plan/quadrature.h"

namespace raycube::plan {

namespace {

/// How near before a lamp nothing hides it, m, and in roundings of a coordinate: so that it may lie on a surface.
constexpr double kClear_m = 1e-3, kClearUlp = 64;
constexpr double kBeyond_um =
    1e-6;  ///< past a spectrum's end, where it is 0: what a band reads between them is nothing
constexpr double kUlp = 0x1p-24;
constexpr double kNarrowestCone = 1e-6;  ///< between the cosines of a spot's cones

shared::rc_float4 quad(const glm::dvec3& v, double w) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z), static_cast<float>(w)};
}
glm::dvec3 lamp_vector(const std::array<double, 3>& v) { return {v[0], v[1], v[2]}; }

bool flat(const scene::Lamp& lamp) {
  return lamp.shape == scene::LampShape::rectangle || lamp.shape == scene::LampShape::disc;
}

std::uint32_t number_of(scene::LampShape shape) {
  switch (shape) {
    case scene::LampShape::spot:
      return RC_LAMP_SPOT;
    case scene::LampShape::rectangle:
      return RC_LAMP_RECTANGLE;
    case scene::LampShape::disc:
      return RC_LAMP_DISC;
    case scene::LampShape::point:
      break;
  }
  return RC_LAMP_POINT;
}

/// Cosines of a spot's cones, kept apart.
std::array<double, 2> cones_of(const scene::Lamp& lamp) {
  const double outer = std::cos(base::rad_from_deg(lamp.cone_deg[1]));
  return {std::max(std::cos(base::rad_from_deg(lamp.cone_deg[0])), outer + kNarrowestCone), outer};
}

/// Largest intensity over flux, sr-1; of a surface radiance times area, 1 / pi.
double intensity_of_flux(const scene::Lamp& lamp) {
  if (flat(lamp)) return 1 / std::numbers::pi;
  if (!lamp.distribution.empty()) return 1 / lamp.distribution.solid_angle_sr();
  if (lamp.shape == scene::LampShape::point) return 0.25 / std::numbers::pi;
  const auto [inner, outer] = cones_of(lamp);  // the square of t = (c - outer) / (inner - outer), by c: a third
  return 1 / (2 * std::numbers::pi * (1 - inner + (inner - outer) / 3));
}

/// The spectra of lamps, each once, in their order.
std::vector<const scene::LampSpectrum*> lamp_spectra(const std::vector<scene::Lamp>& lamps) {
  std::vector<const scene::LampSpectrum*> out;
  for (const scene::Lamp& lamp : lamps)
    if (std::none_of(out.begin(), out.end(), [&](const auto* known) { return *known == lamp.spectrum; }))
      out.push_back(&lamp.spectrum);
  return out;
}

std::uint32_t source_of(const std::vector<const scene::LampSpectrum*>& spectra, const scene::Lamp& lamp) {
  const auto found = std::find_if(spectra.begin(), spectra.end(), [&](const auto* s) { return *s == lamp.spectrum; });
  return static_cast<std::uint32_t>(found - spectra.begin());
}

std::vector<double> values_on(const scene::LampSpectrum& spectrum, const std::vector<double>& wavelength_um) {
  std::vector<double> out;
  for (const double um : wavelength_um) out.push_back(spectrum.at(um));
  return out;
}

/// Means of a spectrum about the nodes of a grid, each by its hat function: a line between two nodes is not lost.
std::vector<double> node_means(const scene::LampSpectrum& spectrum, const std::vector<double>& wavelength_um) {
  std::vector<double> at = wavelength_um, sum(wavelength_um.size(), 0.0), weight = sum;
  for (const double node : spectrum.wavelength_um)
    if (node > wavelength_um.front() && node < wavelength_um.back()) at.push_back(node);
  std::sort(at.begin(), at.end());
  std::size_t cell = 0;
  for (std::size_t k = 1; k < at.size(); ++k) {
    const double low = at[k - 1], high = at[k], middle = (low + high) / 2;
    while (cell + 2 < wavelength_um.size() && wavelength_um[cell + 1] <= middle) ++cell;
    const double from = wavelength_um[cell], width = wavelength_um[cell + 1] - from;
    for (const auto& [um, share] : {std::pair{low, 1.0}, {middle, 4.0}, {high, 1.0}}) {  // Simpson's rule
      const double f = (um - from) / width, part = share / 6 * (high - low), value = spectrum.at(um);
      sum[cell] += part * (1 - f) * value, weight[cell] += part * (1 - f);
      sum[cell + 1] += part * f * value, weight[cell + 1] += part * f;
    }
  }
  for (std::size_t i = 0; i < sum.size(); ++i)
    sum[i] = weight[i] > 0 ? sum[i] / weight[i] : spectrum.at(wavelength_um[i]);
  return sum;
}

/// Flux of a source's lamps over the scene's extent on the map, W m-2.
std::vector<double> mean_irradiance(const std::vector<scene::Lamp>& lamps,
                                    const std::vector<const scene::LampSpectrum*>& spectra,
                                    const scene::CompiledScene& scene) {
  const double x = static_cast<double>(scene.hi[0]) - static_cast<double>(scene.lo[0]),
               y = static_cast<double>(scene.hi[1]) - static_cast<double>(scene.lo[1]);
  std::vector<double> out(spectra.size(), 0.0);
  for (const scene::Lamp& lamp : lamps)
    out[source_of(spectra, lamp)] +=
        static_cast<double>(lamp.position_m.size()) * lamp.flux_W / std::max(1.0, std::max(0.0, x) * std::max(0.0, y));
  return out;
}

/// All of a lamp but its place; the distribution goes to the list's end.
shared::Lamp record_of(const scene::Lamp& lamp, std::uint32_t source, std::vector<float>& distribution) {
  const glm::dvec3 axis = lamp_vector(lamp.axis), across = lamp_vector(lamp.across), along = glm::cross(across, axis);
  const double power = lamp.flux_W * intensity_of_flux(lamp);
  shared::Lamp out{};
  out.shape = number_of(lamp.shape), out.source = source;
  out.position = quad(glm::dvec3(0), power);
  const glm::dvec3 half(lamp.size_m[0] / 2, lamp.size_m[1] / 2, 0);
  const double radius = lamp.shape == scene::LampShape::disc ? half.x : flat(lamp) ? glm::length(half) : 0;
  const auto [inner, outer] = lamp.shape == scene::LampShape::spot ? cones_of(lamp) : std::array{0.0, 0.0};
  out.axis = quad(axis, radius);
  out.across = quad(across * (flat(lamp) ? half.x : 1.0), inner);
  out.along = quad(along * (flat(lamp) ? half.y : 1.0), outer);
  if (lamp.distribution.empty()) return out;
  out.distribution = static_cast<std::uint32_t>(distribution.size());
  out.verticals = static_cast<std::uint32_t>(lamp.distribution.vertical_deg.size());
  out.horizontals = static_cast<std::uint32_t>(lamp.distribution.horizontal_deg.size());
  for (const auto* list :
       {&lamp.distribution.vertical_deg, &lamp.distribution.horizontal_deg, &lamp.distribution.value})
    for (const double value : *list) distribution.push_back(static_cast<float>(value));
  return out;
}

/// At each of its places.
void add_lamp(const scene::Lamp& lamp, std::uint32_t source, Lamps& out) {
  shared::Lamp record = record_of(lamp, source, out.distribution);
  for (const auto& place : lamp.position_m) {
    const glm::dvec3 middle = lamp_vector(place), size = glm::abs(middle);
    record.position = quad(middle, static_cast<double>(record.position.w));
    record.clear = static_cast<float>(kClear_m + kClearUlp * kUlp * std::max({size.x, size.y, size.z}));
    out.lamp.push_back(record);
  }
}

std::string unseen_text(const scene::Lamp& lamp, const std::string& instrument) {
  return fmt::format("instrument '{}': no band sees the light of lamp '{}'{}", instrument, lamp.name,
                     lamp.spectrum.wavelength_um.empty()
                         ? std::string()
                         : fmt::format(", whose spectrum lies at {:g} to {:g} um", lamp.spectrum.wavelength_um.front(),
                                       lamp.spectrum.wavelength_um.back()));
}

}  // namespace

std::vector<double> lamp_nodes_um(const std::vector<scene::Lamp>& lamps) {
  std::vector<double> out;
  for (const auto* spectrum : lamp_spectra(lamps)) {
    const std::vector<double>& nodes = spectrum->wavelength_um;
    if (nodes.empty()) continue;
    out.push_back(nodes.front() - kBeyond_um);
    out.insert(out.end(), nodes.begin(), nodes.end());
    out.push_back(nodes.back() + kBeyond_um);
  }
  return out;
}

Lamps make_lamps(const std::vector<scene::Lamp>& lamps, const SpectralPlan& spectral, const std::string& instrument,
                 std::vector<std::string>& notices) {
  Lamps out;
  for (const auto* spectrum : lamp_spectra(lamps)) {
    std::vector<double> on_grid = values_on(*spectrum, spectral.wavelength_um);
    const std::vector<double> seen = in_bands(spectral.bands, on_grid);
    const auto with = std::find_if(lamps.begin(), lamps.end(), [&](const auto& l) { return l.spectrum == *spectrum; });
    if (std::none_of(seen.begin(), seen.end(), [](double value) { return value > 0; })) {
      notices.push_back(unseen_text(*with, instrument));
      continue;
    }
    const auto source = static_cast<std::uint32_t>(out.spectrum.size());
    out.first.push_back(static_cast<std::uint32_t>(out.lamp.size()));
    out.spectrum.push_back(std::move(on_grid));
    for (const scene::Lamp& lamp : lamps)
      if (lamp.spectrum == *spectrum) add_lamp(lamp, source, out);
  }
  out.first.push_back(static_cast<std::uint32_t>(out.lamp.size()));
  return out;
}

Spectrum typical_lamplight(const std::vector<scene::Lamp>& lamps, const scene::CompiledScene& scene,
                           const std::vector<double>& wavelength_um) {
  Spectrum out;
  const auto spectra = lamp_spectra(lamps);
  const auto irradiance = mean_irradiance(lamps, spectra, scene);
  if (!spectra.empty()) out.assign(wavelength_um.size(), 0.0);
  for (std::size_t s = 0; s < spectra.size(); ++s) {
    const std::vector<double> means = node_means(*spectra[s], wavelength_um);
    for (std::size_t i = 0; i < out.size(); ++i) out[i] += irradiance[s] * means[i];
  }
  return out;
}

}  // namespace raycube::plan
