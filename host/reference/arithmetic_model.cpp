#include <algorithm>
#include <cmath>
#include <numbers>

#include "host/base/error.h"
#include "host/reference/plan_nodes.h"
#include "host/reference/radiance.h"
#include "host/reference/spread.h"
#include "scene_compiler/matter.h"

namespace raycube::reference {

std::vector<std::vector<double>> curves_on(const scene::CompiledScene& scene,
                                           const std::vector<double>& wavelength_um) {
  std::vector<std::vector<double>> out;
  const std::uint32_t count = scene::curve_count(scene);
  for (std::uint32_t curve = 1; curve <= count; ++curve) {
    const std::vector<double>&x = scene::curve_of(scene, curve).wavelength_um, &y = scene::curve_of(scene, curve).value;
    std::vector<double>& values = out.emplace_back();
    const bool dark = x.empty() || !scene::carries_light(scene, curve);
    for (double wavelength : wavelength_um) {
      if (dark) {
        values.push_back(0);
        continue;
      }
      const auto above = static_cast<std::size_t>(std::upper_bound(x.begin(), x.end(), wavelength) - x.begin());
      if (above == 0)
        values.push_back(y.front());
      else if (above == x.size())
        values.push_back(y.back());
      else
        values.push_back(y[above - 1] +
                         (y[above] - y[above - 1]) * (wavelength - x[above - 1]) / (x[above] - x[above - 1]));
    }
  }
  return out;
}

std::vector<double> band_values(const plan::Plan& plan, const std::vector<double>& spectrum) {
  std::vector<double> out;
  for (const plan::BandQuadrature& band : plan.bands) {
    double sum = 0;
    for (std::size_t i = 0; i < band.weight.size(); ++i) sum += band.weight[i] * spectrum[band.first + i];
    out.push_back(sum);
  }
  return out;
}

std::array<double, 4> unoccluded_irradiance(const plan::IrradianceMap& map, const glm::dvec3& normal) {
  if (map.size < 3 || map.size % 2 == 0)
    throw base::Error(base::Fault::bug,
                      "irradiance map of " + std::to_string(map.size) + " nodes a side; an odd number >= 3 is due");
  const glm::dvec3 p = glm::abs(normal) / (std::abs(normal.x) + std::abs(normal.y) + std::abs(normal.z));
  const int half = (map.size - 1) / 2;
  // Distances from the map's centre lines, in nodes; the lower half is mirrored at the diamond's sides.
  const double u = (normal.z < 0 ? 1 - p.y : p.x) * half, v = (normal.z < 0 ? 1 - p.x : p.y) * half;
  const int i = std::min(static_cast<int>(u), half - 1), j = std::min(static_cast<int>(v), half - 1);
  const double a = u - i, b = v - j;
  const auto node = [&](int di, int dj) {
    const int column = half + (normal.x < 0 ? -(i + di) : i + di), row = half + (normal.y < 0 ? -(j + dj) : j + dj);
    return map
        .value[static_cast<std::size_t>(row) * static_cast<std::size_t>(map.size) + static_cast<std::size_t>(column)];
  };
  const shared::rc_float4 right = node(1, 0), up = node(0, 1), corner = a + b <= 1 ? node(0, 0) : node(1, 1);
  const double w_right = a + b <= 1 ? a : 1 - b, w_up = a + b <= 1 ? b : 1 - a, w_corner = std::abs(1 - a - b);
  const auto mix = [&](float c, float r, float t) {
    return w_corner * static_cast<double>(c) + w_right * static_cast<double>(r) + w_up * static_cast<double>(t);
  };
  return {mix(corner.x, right.x, up.x), mix(corner.y, right.y, up.y), mix(corner.z, right.z, up.z),
          mix(corner.w, right.w, up.w)};
}

std::array<double, 4> thermal_unoccluded(const plan::Thermal& thermal, double normal_z) {
  const auto last = static_cast<double>(thermal.tilt_irradiance.size() - 1);
  const double t = std::clamp(0.5 * (normal_z + 1), 0.0, 1.0) * last;
  const auto i = static_cast<std::size_t>(std::min(std::floor(t), last - 1));
  const shared::rc_float4 &a = thermal.tilt_irradiance[i], &b = thermal.tilt_irradiance[i + 1];
  const double f = t - static_cast<double>(i);
  return {(1 - f) * a.x + f * b.x, (1 - f) * a.y + f * b.y, (1 - f) * a.z + f * b.z, (1 - f) * a.w + f * b.w};
}

ArithmeticModel::ArithmeticModel(const scene::CompiledScene& scene, const plan::Plan& plan, OpenSky open)
    : scene_(scene), plan_(plan), open_(std::move(open)), curve_(curves_on(scene, plan.wavelength_um)) {
  if (!plan.environment.empty()) ground_ = ground_albedos(scene, plan.wavelength_um);
  if (open_) return;
  open_ = [&plan](const glm::dvec3& normal) {
    std::array<double, 8> irradiance{};
    if (plan.sky_components > 0) {
      const std::array<double, 4> solar = unoccluded_irradiance(plan.irradiance, normal);
      std::copy(solar.begin(), solar.end(), irradiance.begin());
    }
    if (plan.thermal.on) {
      const std::array<double, 4> emitted = thermal_unoccluded(plan.thermal, normal.z);
      std::copy(emitted.begin(), emitted.begin() + plan.thermal.components(), irradiance.begin() + plan.sky_components);
    }
    return irradiance;
  };
}

const std::vector<double>& ArithmeticModel::curve_of(const Sample& sample, std::uint32_t material) const {
  return curve_[rc_curve_id(rc_curve_of_side(sample.side), material - 1, scene::material_count(scene_)) - 1];
}

void ArithmeticModel::add_source(const SampledPixel& pixel, const Sample& sample, int source, double scalar,
                                 std::vector<double>& spectrum) const {
  if (scalar == 0) return;
  const NodeWeight h = locate(plan_.height, sample.point.z), v = locate(plan_.view, 1 / pixel.to_sensor.z);
  const shared::Surface& surface = scene::matter_of(scene_, sample.hit.primitive);
  for (int ih = 0; ih < plan_.height.count; ++ih)
    for (int iv = 0; iv < plan_.view.count; ++iv) {
      const double weight = sample.weight * scalar * h.of(ih) * v.of(iv);
      if (weight == 0) continue;
      const std::vector<double>& light =
          plan_.source_spectrum[static_cast<std::size_t>((source * plan_.height.count + ih) * plan_.view.count + iv)];
      for (int m = 0; m < 4; ++m) {
        if (surface.material[m] == 0) continue;
        const std::vector<double>& rho = curve_of(sample, surface.material[m]);
        const double w = weight * static_cast<double>(surface.fraction[m]);
        for (std::size_t i = 0; i < spectrum.size(); ++i) spectrum[i] += w * rho[i] * light[i];
      }
    }
}

void ArithmeticModel::add_emission(const SampledPixel& pixel, const Sample& sample,
                                   std::vector<double>& spectrum) const {
  const NodeWeight h = locate(plan_.height, sample.point.z), v = locate(plan_.view, 1 / pixel.to_sensor.z);
  const std::vector<double>& nodes = plan_.thermal.temperature_K;
  const double black = sample.side == RC_NEAR_SIDE ? 1 : 0;  // 1 - reflectance - transmittance, each side its part
  const double even = even_light(scene_, plan_.thermal, sample);
  const shared::Surface& surface = scene::matter_of(scene_, sample.hit.primitive);
  for (int m = 0; m < 4; ++m) {
    if (surface.material[m] == 0) continue;
    const std::vector<double>& rho = curve_of(sample, surface.material[m]);
    const double kelvin = scene_.materials[surface.material[m] - 1].temperature_K;
    NodeWeight at;
    if (nodes.size() > 1) {
      const auto above = std::upper_bound(nodes.begin() + 1, nodes.end() - 1, kelvin) - nodes.begin();
      at.low = static_cast<int>(above) - 1;
      const double low = nodes[static_cast<std::size_t>(above) - 1], high = nodes[static_cast<std::size_t>(above)];
      at.f = std::clamp((kelvin - low) / (high - low), 0.0, 1.0);
    }
    for (int k = 0; k < plan_.thermal.nodes(); ++k)
      for (int ih = 0; ih < plan_.height.count; ++ih)
        for (int iv = 0; iv < plan_.view.count; ++iv) {
          const double w = sample.weight * static_cast<double>(surface.fraction[m]) * at.of(k) * h.of(ih) * v.of(iv);
          if (w == 0) continue;
          const std::vector<double>& light = plan_.source_spectrum[static_cast<std::size_t>(
              ((plan_.first_emission() + k) * plan_.height.count + ih) * plan_.view.count + iv)];
          for (std::size_t i = 0; i < spectrum.size(); ++i) spectrum[i] += w * (black - even * rho[i]) * light[i];
        }
  }
}

std::array<double, 8> ArithmeticModel::irradiance(const Sample& side, const SentRays& sent) const {
  const double known = known_share(scene_, plan_, side);
  const auto all = static_cast<std::size_t>(plan_.components());
  std::array<double, 8> out = open_(side.normal);
  for (std::size_t m = 0; m < all; ++m) {
    // The surroundings, the last, fill what the open sky leaves of the hemisphere.
    const bool surroundings = plan_.thermal.on && m + 1 == all;
    out[m] += (known - 1) * (surroundings ? out[m] - std::numbers::pi : out[m]);
    if (surroundings) out[m] += std::numbers::pi * (even_light(scene_, plan_.thermal, side) - 1);
  }
  for (const SentRay& ray : sent) {
    if (ray.weight == 0) continue;
    const double seen = (ray.open ? spread(scene_, side, ray.direction) : 0) - known;
    if (seen == 0) continue;
    const std::array<double, 8> light = sky_light(plan_, ray.direction);
    for (std::size_t m = 0; m < all; ++m) out[m] += ray.weight * seen * light[m];
  }
  return out;
}

void ArithmeticModel::add_side(const SampledPixel& pixel, const Sample& side, const SentRays& sent,
                               Spectra& out) const {
  const glm::dvec3 sun_direction(plan_.sun_direction[0], plan_.sun_direction[1], plan_.sun_direction[2]);
  if (side.sun_visible && plan_.sun_sources > 0)
    add_source(pixel, side, 0, std::max(0.0, side.cos_sun) * spread(scene_, side, sun_direction), out.sun);
  if (plan_.components() > 0) {
    const auto all = static_cast<std::size_t>(plan_.components());
    const std::array<double, 8> light = irradiance(side, sent);
    for (std::size_t m = 0; m < all; ++m)
      add_source(pixel, side, plan_.first_component() + static_cast<int>(m), light[m],
                 plan_.thermal.on && m + 1 == all ? out.surroundings : out.sky);
  }
  if (plan_.thermal.on) add_emission(pixel, side, out.emission);
}

void ArithmeticModel::add_path(const SampledPixel& pixel, const Sample& sample, std::vector<double>& path) const {
  const NodeWeight x = locate(plan_.path_x, pixel.to_sensor.x), y = locate(plan_.path_y, pixel.to_sensor.y);
  // A ray that meets nothing ends over black ground at the lowest node.
  const NodeWeight h =
      locate(plan_.height, sample.hit.miss() ? static_cast<double>(plan_.height.first) : sample.point.z);
  for (int ih = 0; ih < plan_.height.count; ++ih)
    for (int iy = 0; iy < plan_.path_y.count; ++iy)
      for (int ix = 0; ix < plan_.path_x.count; ++ix) {
        const double weight = sample.weight * h.of(ih) * y.of(iy) * x.of(ix);
        if (weight == 0) continue;
        const std::vector<double>& light =
            plan_.path_spectrum[static_cast<std::size_t>((ih * plan_.path_y.count + iy) * plan_.path_x.count + ix)];
        for (std::size_t i = 0; i < path.size(); ++i) path[i] += weight * light[i];
      }
}

BandRadiance ArithmeticModel::radiance(const SampledPixel& pixel, const std::vector<SentRays>& sent,
                                       const std::vector<std::vector<double>>& lamplight) const {
  const std::vector<double> dark(plan_.wavelength_um.size(), 0.0);
  Spectra spectra{dark, dark, dark, dark, dark, dark};
  for (std::size_t i = 0; i < pixel.sides(); ++i)
    if (!pixel.side(i).hit.miss()) add_side(pixel, pixel.side(i), sent[i], spectra);
  for (std::size_t i = 0; i < lamplight.size(); ++i)
    for (std::size_t m = 0; m < lamplight[i].size(); ++m)
      add_source(pixel, pixel.side(i), plan_.first_lamp() + static_cast<int>(m), lamplight[i][m], spectra.lamps);
  for (const Sample& sample : pixel.samples) add_path(pixel, sample, spectra.path);
  BandRadiance out{.sun = band_values(plan_, spectra.sun),
                   .sky = band_values(plan_, spectra.sky),
                   .path = band_values(plan_, spectra.path),
                   .lamps = lamplight.empty() ? std::vector<double>() : band_values(plan_, spectra.lamps),
                   .environment = {},
                   .emission = band_values(plan_, spectra.emission),
                   .surroundings = band_values(plan_, spectra.surroundings)};
  if (!plan_.environment.empty()) out.environment = band_values(plan_, environment_light(pixel, plan_, ground_));
  return out;
}

}  // namespace raycube::reference
