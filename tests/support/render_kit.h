// Small scenes and cameras for tests of the whole chain, and one call that renders them.
#pragma once

#include <functional>
#include <vector>

#include "atmos_tables/render_table.h"
#include "atmos_tables/synthetic.h"
#include "host/plan/plan.h"
#include "host/render/renderer.h"
#include "scene_compiler/bvh_builder.h"
#include "scene_compiler/simulation.h"

namespace raycube::test {

/// A material of constant reflectance over 0.3 to 4 um; its pure surface follows (call before any mesh).
std::uint32_t add_material(scene::CompiledScene& scene, const std::string& name, double reflectance);

/// Rectangle of `surface` in the plane spanned by edge_a and edge_b (m) from a corner; normal = edge_a x edge_b.
scene::TriangleMesh rectangle(const std::array<double, 3>& corner, const std::array<double, 3>& edge_a,
                              const std::array<double, 3>& edge_b, std::uint32_t surface);
/// Closed box, outward normals.
scene::TriangleMesh box(const std::array<double, 3>& low, const std::array<double, 3>& high, std::uint32_t surface);
/// Joins triangle soups of one frame.
scene::TriangleMesh join(const std::vector<scene::TriangleMesh>& parts);
/// Adds a mesh once, unmoved.
void place(scene::CompiledScene& scene, const scene::TriangleMesh& mesh);

/// Framing camera looking straight down from (x, y, height), heading 0; pixels of `gsd_m` at z = 0.
scene::Instrument nadir_camera(int pixels, int lines, double height_m, double gsd_m, double x_m = 0, double y_m = 0);

/// A finished image in memory.
struct Image {
  int lines = 0, pixels = 0, bands = 0, layers = 0;
  std::vector<float> radiance, truth;
  std::vector<float> band_error;  ///< as the radiance; empty unless the instrument asks for bands
  plan::Plan plan;
  render::RenderStatistics statistics;
  float at(int line, int pixel, int band) const {
    return radiance[(std::size_t(line) * pixels + pixel) * bands + band];
  }
  float layer(int line, int pixel, int index) const {
    return truth[(std::size_t(line) * pixels + pixel) * layers + index];
  }
};

/// Plans and renders instrument 0 of the simulation. `adjust` may change the plan before it is used.
Image render_image(const scene::Simulation& simulation, const atmos::RenderTable& table,
                   const render::RenderOptions& options = {}, const std::function<void(plan::Plan&)>& adjust = {});

/// Renders instrument 0 by a plan that is made.
Image render_planned(const scene::Simulation& simulation, plan::Plan plan, const render::RenderOptions& options = {});

/// Largest |radiance / expected[band] - 1| of all pixels.
double worst_relative(const Image& image, const std::vector<double>& expected);

/// What air does to light, the same at every wavelength; units of atmos::UniformAir.
struct GreyAir {
  double solar_irradiance = 1500, sun_transmission = 1, view_transmission = 1, two_way_factor = 1;
  double sky_radiance = 0, path_radiance = 0;
};
atmos::UniformAir uniform_air(const GreyAir& air, const scene::Sun& sun);

/// Gaussian bands at the given centres, one width, um.
std::vector<scene::Band> gaussian_bands(const std::vector<double>& centers_um, double fwhm_um);

/// Fills the rows for light between ground and air of a table that has none: smooth, of the size of a hazy air, with S
/// the integral of t; they vary with wavelength, height and zenith.
void add_ground_coupling(atmos::RenderTable& table);

}  // namespace raycube::test
