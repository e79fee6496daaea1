#include "host/plan/curve.h"

#include <fmt/format.h>

#include "host/base/error.h"
#include "host/plan/sky_basis.h"
#include "scene_compiler/matter.h"
#include "scene_compiler/spectral_shape.h"

namespace raycube::plan {

std::vector<double> sample_curve(const scene::Material& material, const scene::Curve& curve,
                                 const std::vector<double>& wavelength_um) {
  const auto& x = curve.wavelength_um;
  const auto& y = curve.value;
  if (x.empty()) throw base::Error(base::Fault::input, "material '" + material.name + "' has no reflectance curve");
  if (x.size() == 1) return std::vector<double>(wavelength_um.size(), y[0]);
  std::vector<double> out;
  out.reserve(wavelength_um.size());
  for (const double l : wavelength_um) {
    if (l < x.front() - 1e-9 || l > x.back() + 1e-9)
      throw base::Error(
          base::Fault::input,
          fmt::format("material '{}': its curve{} covers {:.6g} to {:.6g} nm and {}, {:.6g} nm is needed; give a curve "
                      "that covers what the instrument sees",
                      material.name, material.source.empty() ? "" : " (" + material.source + ")", 1000 * x.front(),
                      1000 * x.back(), l < x.front() ? "begins too late" : "ends too early", 1000 * l));
    const Cell cell = find_cell(x, l);
    out.push_back((1 - cell.fraction) * y[cell.index] + cell.fraction * y[cell.index + 1]);
  }
  return out;
}

std::vector<double> curve_on(const scene::CompiledScene& scene, std::uint32_t curve,
                             const std::vector<double>& wavelength_um) {
  if (!scene::carries_light(scene, curve)) return std::vector<double>(wavelength_um.size(), 0.0);
  return sample_curve(scene.materials[scene::material_of_curve(scene, curve)], scene::curve_of(scene, curve),
                      wavelength_um);
}

std::vector<double> sample_reflectance(const scene::Material& material, const std::vector<double>& wavelength_um) {
  std::vector<double> out(wavelength_um.size(), 0.0);
  for (const auto& part : scene::front_parts(material)) {
    const std::vector<double> values = sample_curve(material, part.curve, wavelength_um);
    for (std::size_t i = 0; i < out.size(); ++i) out[i] += values[i];
  }
  return out;
}

}  // namespace raycube::plan
