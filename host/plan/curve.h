// A material's curve on another wavelength grid.
#pragma once

#include <cstdint>
#include <vector>

#include "scene_compiler/compiled_scene.h"

namespace raycube::plan {

/// A curve of `owner` at ascending wavelengths (um), linear between the curve's nodes. Error(input) names the material
/// when a wavelength lies more than 1e-9 um outside the curve; a curve of one node is constant.
std::vector<double> sample_curve(const scene::Material& owner, const scene::Curve& curve,
                                 const std::vector<double>& wavelength_um);

/// The same by a curve's number (scene_compiler/matter.h): zeros where no light goes by it, as by the transmittance of
/// opaque matter.
std::vector<double> curve_on(const scene::CompiledScene& scene, std::uint32_t curve,
                             const std::vector<double>& wavelength_um);

std::vector<double> sample_reflectance(const scene::Material& material, const std::vector<double>& wavelength_um);

}  // namespace raycube::plan
