// The plan of one instrument's render: which nodes, sky components and direction sets carry the physics, and the spectra
// that go with them. Pure data: made once on the host in double, read by the kernels' driver and by the reference.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "atmos_tables/render_table.h"
#include "host/plan/sky_basis.h"
#include "kernels/shared/structs.h"
#include "scene_compiler/simulation.h"

namespace raycube::plan {

/// Uniform nodes first, first + step, ...; a value between two nodes gets linear weights, outside the range it is clamped.
struct NodeAxis {
  float first = 0, step = 1;
  int count = 1;
};

/// Quadrature of one band on the spectral grid: L_band = sum_i weight[i] L(wavelength[first + i]), weights sum to 1.
/// The grid holds the midpoint of every interval between nodes of the table and the curves, and the weights integrate
/// quadratics against the response: exact for a curve times a spectrum, both linear between those nodes. A weight may be
/// slightly negative where a narrow response sits inside one interval.
struct BandQuadrature {
  std::size_t first = 0;
  std::vector<double> weight;
};

/// Sky directions: `sets` sets of `directions` unit vectors; a pixel takes set hash(seed, pixel) % sets. The weights carry
/// solid angle times component map: sum_k weight[m] max(0, n.d) estimates component m's irradiance on normal n.
struct SkySets {
  int sets = 0, directions = 0;
  std::vector<shared::rc_float4> direction;  ///< [set][k], towards the sky; w = 0
  std::vector<shared::rc_float4> weight;     ///< [set][k], components 0..3 (sr)
};

/// Unoccluded irradiance per sky component (up to 4) against the surface normal, octahedral map of size x size nodes
/// (node (0,0) at corner -1,-1, node (size-1,size-1) at 1,1; size odd; linear on half-cells between: rc_octahedral_nodes).
/// Per unit of the component's spectrum.
struct IrradianceMap {
  int size = 0;
  std::vector<shared::rc_float4> value;  ///< [v * size + u]
};

/// Channels. Material rows (curve id >= 1): channel = (source * height.count + h) * view.count + v with source 0 the direct
/// sun (scalar: max(0, n.s) times visibility) and 1 + m sky component m (scalar: irradiance of the component, unoccluded
/// map minus blocked directions). Row 0 (no curve): channel = (h * path_y.count + y) * path_x.count + x, path radiance.
/// At most RC_MAX_CHANNELS of either.
struct Plan {
  std::vector<double> wavelength_um;               ///< spectral grid: table axis, curve nodes and midpoints near bands, ascending
  std::vector<BandQuadrature> bands;
  std::array<float, 3> sun_direction{0, 0, 1};     ///< unit, towards the sun
  bool sun_up = true;
  int sky_components = 0;                          ///< 0..4
  NodeAxis height;                                 ///< target height, m above scene z = 0
  NodeAxis view;                                   ///< sec(view zenith)
  NodeAxis path_x, path_y;                         ///< horizontal components of the unit vector target -> sensor
  std::vector<std::vector<double>> source_spectrum;  ///< [channel][grid]: radiance at the sensor per unit reflectance and scalar (1/pi inside)
  std::vector<std::vector<double>> path_spectrum;    ///< [channel][grid]
  std::vector<std::vector<double>> transmission_spectrum;  ///< [h * view.count + v][grid], target to sensor (truth layer)
  SkyBasis sky_basis;                              ///< the components' angular maps, of which sets and map are made
  SkySets sky;                                     ///< empty without sky components
  IrradianceMap irradiance;
  std::string report_json;                         ///< what was chosen, each block's estimated error (DESIGN section 6's table)

  int source_channels() const { return (1 + sky_components) * height.count * view.count; }
  int path_channels() const { return height.count * path_y.count * path_x.count; }
};

/// The extremes a plan must cover, over the centres and corners of all pixels of the instrument.
struct ViewBounds {
  double sec_min = 1, sec_max = 1;         ///< sec of view zenith
  double x_min = 0, x_max = 0, y_min = 0, y_max = 0;  ///< horizontal part of the unit vector target -> sensor
  double sensor_height_m = 0;              ///< above scene z = 0
};

/// Makes the plan: spectral grid and band quadrature, node counts by bisection until the midpoint error is inside its share
/// of `simulation.tolerance`, sky components by weighted SVD (component 0 carries the irradiance exactly), direction sets
/// by hash of the seed. Throws Error(input) when a band leaves the table or a material's curve, or the table lacks a row.
Plan make_plan(const scene::Simulation& simulation, const scene::Instrument& instrument, const atmos::RenderTable& table,
               const ViewBounds& view);

/// Curve ids (1-based, ascending) that some triangle carries; every material's in a scene without triangles. Only these
/// must cover the bands.
std::vector<std::uint32_t> used_curves(const scene::CompiledScene& scene);

/// Bakes one term row in double: E[channel][band] for a curve id (0 = path), stored as float, bands padded with zeros to a
/// multiple of 16: result[channel * bands_padded + band]. Error(input) when the material's curve does not cover the grid,
/// which cannot happen to a used curve.
std::vector<float> bake_row(const Plan& plan, const scene::CompiledScene& scene, std::uint32_t curve);

}  // namespace raycube::plan
