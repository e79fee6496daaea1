// The plan of one instrument's render: which nodes, sky components and rays carry the physics, and the
// spectra that go with them. Pure data: made once on the host in double, read by the kernels' driver and by the
// reference.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "atmos_tables/render_table.h"
#include "host/plan/plan_report.h"
#include "host/plan/sky_basis.h"
#include "kernels/shared/structs.h"
#include "scene_compiler/matter.h"
#include "scene_compiler/simulation.h"

namespace raycube::plan {

class BakedRows;

/// Uniform nodes first, first + step, ...; a value between two nodes gets linear weights, outside the range it is
/// clamped.
struct NodeAxis {
  float first = 0, step = 1;
  int count = 1;
};

/// Quadrature of one band on the spectral grid: L_band = sum_i weight[i] L(wavelength[first + i]), weights sum to 1.
/// The grid holds the midpoint of every interval between nodes of the table and the curves, and the weights integrate
/// quadratics against the response: exact for a curve times a spectrum, both linear between those nodes. A weight may
/// be slightly negative where a narrow response sits inside one interval.
struct BandQuadrature {
  std::size_t first = 0;
  std::vector<double> weight;
};

/// How a pixel looks for what hides its sky: rays from its samples, each in a direction of its own, drawn by the law of
/// kernels/sampling/sky_rays.h. What an open sky sends is known in closed form; a surface takes a share of it for
/// granted and its rays bring the rest, so that open ground has no noise and a crown's floor does not pay for light
/// that it never had.
struct SkyRays {
  /// Shares, by the cosine, of directions that meet another surface, as a few pixels show them (planner/open_share.h).
  struct Met {
    bool known = false;
    double rms = 0.5;   ///< over pixels, of what they see: those brighter than the mean by how bright, worst band
    double mean = 0.5;  ///< over pixels
    double on = 0.5;    ///< of surfaces that are met: those count the more the more others they meet
  };
  int rays = 0;           ///< of a pixel, all samples together; where there are paths, paths_beside() of it; 0: neither
  int paths_per_two = 1;  ///< paths that go with two rays, by the file or the planner's choice
  double cosine_share = 1;  ///< by the cosine about the normal
  double sun_share = 0;     ///< of the rest, about the sun with this asymmetry; all else evenly
  double asymmetry = 0.5;
  double spread = 0;           ///< variance of one ray's light over its mean's square: mean over many tilts, open sky
  double sun_azimuth_rad = 0;  ///< from which the maps' azimuth counts, clockwise from north
  std::vector<float> open_share;  ///< [surface], 0 .. 1, taken for granted; empty: 1 everywhere
  Met met;
  /// What the rays of a render with this seed are hashed by; draw: other rays of one seed, for trials.
  static std::uint32_t hash_seed(std::uint64_t seed, std::uint32_t draw = 0) {
    return static_cast<std::uint32_t>(seed) + draw * 0x9e3779b9u;
  }
  float known(std::size_t surface) const { return surface < open_share.size() ? open_share[surface] : 1.0f; }
};

/// Unoccluded irradiance per sky component (up to 4) against the surface normal, octahedral map of size x size nodes
/// (node (0,0) at corner -1,-1, node (size-1,size-1) at 1,1; size odd; linear on half-cells between:
/// rc_octahedral_nodes). Per unit of the component's spectrum.
struct IrradianceMap {
  int size = 0;
  std::vector<shared::rc_float4> value;  ///< [v * size + u]
};

/// The ground around every place: nodes on a uniform grid, each with the shares of materials in its environment, by the
/// environment functions of molecules and of aerosol; bilinear between nodes, clamped outside. Row kEnvironmentKey |
/// node.
struct EnvironmentMap {
  int columns = 0, rows = 0;  ///< nodes, index = row * columns + column; 0: no light between ground and air
  double first_x_m = 0, first_y_m = 0, step_m = 1;  ///< of node 0, scene frame; row and column step
  struct Part {
    std::uint32_t material = 0;         ///< its index: Lambertian by its reflectance
    double molecules = 0, aerosol = 0;  ///< share of the environment; over a node's parts each sums to 1 (0: black)
    bool operator==(const Part&) const = default;
  };
  std::vector<Part> part;                          ///< of all nodes, by node, then material
  std::vector<std::size_t> first_part;             ///< [node], and the end
  std::vector<double> mean;                        ///< [material]: area share of the scene's mean
  std::array<double, 2> mean_lo_m{}, mean_hi_m{};  ///< where the mean was taken: x, y
  double height_m = 1, cos_view = 1;  ///< of the sensor over the ground, for which the environment functions were taken
  double sensor_z_m = 0,
         pressure_hPa = 0;  ///< sensor above, pressure at the scene's z = 0: for the molecules' part of T_dif
  bool local = true;        ///< false: the mean alone was asked for
  double raster_m = 0;      ///< spacing of the points that say what the ground is, near the view
  std::vector<std::vector<double>> reflectance;  ///< [material][grid] of those in `part`; empty for others
  bool empty() const { return columns == 0; }
  std::size_t nodes() const { return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows); }
};

/// A node and its bilinear weight; weights sum to 1.
struct EnvironmentWeight {
  std::uint32_t node = 0;
  double weight = 0;
};
std::array<EnvironmentWeight, 4> environment_at(const EnvironmentMap& map, double x_m, double y_m);

/// Keys of environment rows: this bit and the node. Above every product key.
inline constexpr std::uint64_t kEnvironmentKey = std::uint64_t{1} << 63;

/// Thermal light, where there is any to be seen (host/plan/thermal_use.h). The thermal sky has
/// `sky_components` maps of zenith angle alone; one more component stands for the surroundings: all of a
/// surface's hemisphere that is not open sky, filled with a black body at `surroundings_K`. Emission enters
/// at temperature nodes, linear in between: (1 - reflectance) B(node) T_view.
struct Thermal {
  bool on = false;
  int sky_components = 0;             ///< at most 2
  std::vector<double> temperature_K;  ///< nodes, ascending
  double surroundings_K = 0;
  /// Where each material of a surface lies among the nodes: index + fraction, [surface][0..3].
  std::vector<shared::rc_float4> surface_node;
  SkyBasis basis;  ///< the thermal sky's maps
  /// Unoccluded irradiance against the vertical component of the normal, RC_TILT_NODES from -1 to 1: the sky's
  /// components, then the surroundings' (pi (1 - nz) / 2, what lies below the horizon). Per unit of the component's
  /// spectrum.
  std::vector<shared::rc_float4> tilt_irradiance;
  /// Of lobes that are not Lambert's, what they send back of an even light (kernels/light/lobe_albedo.h): by records of
  /// the scene's lobes the number of its table, from 1 (0: Lambert's), and the tables. Empty where all are.
  std::vector<std::uint32_t> albedo_at;
  std::vector<float> albedo;
  std::vector<std::string> notices;  ///< of matter that sends back more than comes
  int components() const { return on ? sky_components + 1 : 0; }
  int nodes() const { return on ? static_cast<int>(temperature_K.size()) : 0; }
};

/// Factors that bring a table's sky to its flux, at some heights; linear between, 1 at wavelengths that no band sees
/// and where there are none.
struct SkyFlux {
  std::vector<double> height_m;            ///< ascending
  std::size_t first = 0;                   ///< wavelength of the table's axis that scale begins with
  std::vector<std::vector<double>> scale;  ///< [height][wavelength]

  void add(double at_m, std::size_t first_line, std::vector<double> factors) {
    height_m.push_back(at_m), first = first_line;
    scale.push_back(std::move(factors));
  }
  double at(double z_m, std::size_t line) const {
    if (scale.empty() || line < first || line - first >= scale[0].size()) return 1;
    std::size_t above = 0;
    while (above < height_m.size() && height_m[above] <= z_m) ++above;
    const std::size_t hi = above < height_m.size() ? above : above - 1, lo = above > 0 ? above - 1 : 0;
    const double f = hi > lo ? (z_m - height_m[lo]) / (height_m[hi] - height_m[lo]) : 0;
    return (1 - f) * scale[lo][line - first] + f * scale[hi][line - first];
  }
};

/// Lamps, and the sources that they are: one for each spectrum.
struct Lamps {
  std::vector<shared::Lamp> lamp;    ///< by source
  std::vector<std::uint32_t> first;  ///< of each source, and the end
  std::vector<float> distribution;   ///< of those that have one: vertical angles, horizontal angles, values, deg
  std::vector<std::vector<double>> spectrum;  ///< [source][grid]: spectral flux over flux, 1/um
  int sources() const { return static_cast<int>(spectrum.size()); }
};

/// Light that goes on from surface to surface (docs/light.md). Paths carry what a viewer would see at some wavelengths
/// of the grid, the skeleton; what lies between them is `basis` times that, whatever the geometry.
struct Bounces {
  int levels = 0;  ///< surfaces after the first; 0: light is scattered once, and so it is without a skeleton
  std::vector<std::size_t> skeleton;       ///< indices into the grid
  std::vector<std::vector<double>> basis;  ///< [skeleton][grid]
  double share = 0;                        ///< that this was to be
  /// Of products of curves that the fit has not seen, over what each of them shows by itself, worst band: of what is
  /// seen, where surfaces see nothing but others as bright as they are.
  double error = 0;
  std::map<std::string, double> material_error;  ///< the same of each material that is not black, by its name
  double strength = 0;   ///< of those products, rms: what there is then of light between surfaces
  double amplified = 1;  ///< largest root of a sum of squares over the skeleton, of any wavelength
  /// [curve - 1][skeleton, padded to whole words]: kernels/light/bounce.h; with thermal light then [material]:
  /// PathHeat::excess.
  std::vector<float> curve;
  /// Light of all sources but lamps together, [h * view.count + v][grid]: the sun's by the cosine of its zenith angle
  /// (0.05 at least) and the first component's of each sky, what level ground gets of them, and hottest_light. A path's
  /// gain is told per unit of it.
  std::vector<std::vector<double>> together;
  std::vector<float> source_share;  ///< [sun, components, the surroundings' too][skeleton, padded]: of that
  /// Level ground around the scene, of its mean reflectance, as paths meet it that leave the scene downwards: pi times
  /// its radiance per unit of the light together, [skeleton, padded]. 0 where the plan has no light between ground and
  /// air, because none is asked for or it is too faint beside thermal light: then nothing is known of that ground.
  std::vector<float> ground;
  std::vector<shared::rc_float4> scattering;  ///< [surface]: x chance of the near side, y largest R + T, z of gloss
  bool logged = false;  ///< a probe hands over every step of every path; not of scenes with plates

  bool any() const { return !skeleton.empty(); }
  /// Largest reflectance and transmittance together, 1 at most.
  double brightest() const;
};

/// Paths between surfaces that go with so many rays into the sky: `per_two` for every second, rounded up. By itself one
/// does; where paths bring most of the noise the planner takes more (PixelTrial::choose_paths).
using scene::paths_beside;

/// Keys of the skeleton's rows: this and the number of a row, source of lamps * wavelengths + wavelength, all else
/// before the lamps. Of no product, and of no environment.
inline constexpr std::uint64_t kSkeletonKey = std::uint64_t{3} << 62;

/// Channels. Material rows (curve id >= 1): channel = (source * height.count + h) * view.count + v. Sources, in order:
/// the direct sun (scalar: max(0, n.s) times visibility) unless it is left out as too dark; the sky components (scalar:
/// irradiance of the component as the pixel's rays found it); thermal components likewise; lamps by spectrum (scalar:
/// irradiance, W m-2, all wavelengths); temperature nodes (scalar: node weight of the material's temperature). Sources
/// up to there carry the reflectance, emission carries 1 - reflectance. Row 0 (no curve): channel =
/// (h * path_y.count + y) * path_x.count + x, path radiance.
/// Environment rows: channel = h * view.count + v, light of the ground around that the air scatters into the path; a
/// pixel adds it for every sample, hit or not, as it does path radiance.
/// At most RC_MAX_CHANNELS of reflected sources, of emission, of the path and of the environment.
struct Plan {
  double tolerance = 0.01;            ///< the simulation's
  std::vector<double> wavelength_um;  ///< spectral grid: table axis, curve nodes and midpoints near bands, ascending
  std::vector<BandQuadrature> bands;
  std::array<float, 3> sun_direction{0, 0, 1};  ///< unit, towards the sun
  bool sun_up = true;
  int sun_sources = 1;     ///< 0: too dark beside the thermal light to be a source
  int sky_components = 0;  ///< 0..4, of sunlight
  scene::CameraMatter matter;
  std::vector<std::uint32_t>
      seen_curves;  ///< scene::seen_curves, which looks through all of the scene; then add_leaning_keys
  Thermal thermal;
  Lamps lamps;
  NodeAxis height;          ///< target height, m above scene z = 0
  NodeAxis view;            ///< sec(view zenith)
  NodeAxis path_x, path_y;  ///< horizontal components of the unit vector target -> sensor
  std::vector<std::vector<double>>
      source_spectrum;  ///< [channel][grid]: radiance at the sensor per unit reflectance and scalar (1/pi inside)
  std::vector<std::vector<double>> path_spectrum;  ///< [channel][grid]
  std::vector<std::vector<double>>
      transmission_spectrum;  ///< [h * view.count + v][grid], target to sensor (truth layer)
  EnvironmentMap environment;
  std::vector<std::vector<double>>
      /// [(0 molecules, 1 aerosol) * environment_channels() + channel][grid], per unit reflectance
      environment_spectrum;
  SkyFlux sky_flux;    ///< what the full tables' sky is multiplied by to carry its flux, as the components do
  SkyBasis sky_basis;  ///< the components' angular maps: of the rays' light and of the map
  SkyRays sky;         ///< none without components
  IrradianceMap irradiance;
  Bounces bounces;
  std::vector<scene::BandTruth> truth;  ///< cubes that a render makes beside the radiance: of a plan to render by alone
  /// [source * height.count + h][band]: what of a source's scalar 1 falls onto a surface, W m-2 um-1, of those that
  /// light it; empty unless the instrument asks for irradiance.
  std::vector<std::vector<double>> incident;
  std::string
      refusal;  ///< why the tolerance is not held, by worst-case estimates of its nodes and components; empty: it is
  std::vector<std::string> notices;  ///< what the user should know though it is no error
  std::shared_ptr<BakedRows>
      baked;          ///< set where a plan whose spectra stay is rendered again and again; by copies shared
  PlanReport report;  ///< what was weighed, each block's estimated error

  int components() const { return sky_components + thermal.components(); }  ///< that rays are traced for
  int met_sources() const { return components() + lamps.sources(); }        ///< planes of met sky (tile_layout.h)
  int first_component() const { return sun_sources; }                       ///< its source number
  int first_lamp() const { return sun_sources + components(); }             ///< source number of the lamps' first
  int first_emission() const { return first_lamp() + lamps.sources(); }     ///< source number of temperature node 0
  int sources() const { return first_emission() + thermal.nodes(); }
  int source_channels() const { return sources() * height.count * view.count; }
  int environment_channels() const { return environment.empty() ? 0 : height.count * view.count; }
  /// Whether pixels send rays that are drawn: into the sky, or along paths.
  bool sends_rays() const { return components() > 0 || bounces.any(); }
  /// Of the band table: the skeleton's wavelengths for all sources but lamps, and for each source of those.
  std::size_t skeleton_rows() const { return bounces.skeleton.size() * static_cast<std::size_t>(1 + lamps.sources()); }
  int paths() const { return bounces.any() ? paths_beside(sky.rays, sky.paths_per_two) : 0; }
  int path_channels() const { return height.count * path_y.count * path_x.count; }
  /// Values of a pixel: its bands, then those of each cube of truth.
  std::size_t columns() const { return bands.size() * (1 + truth.size()); }
  /// Channel of a material's row that its coverage of the pixel goes by, where there is truth per band.
  int coverage_channel() const { return source_channels(); }
};

/// The extremes a plan must cover, over the centres and corners of all pixels of the instrument.
struct ViewBounds {
  double sec_min = 1, sec_max = 1;                    ///< sec of view zenith
  double x_min = 0, x_max = 0, y_min = 0, y_max = 0;  ///< horizontal part of the unit vector target -> sensor
  double sensor_height_m = 0;                         ///< above scene z = 0
  double sensor_x_min = 0, sensor_x_max = 0, sensor_y_min = 0, sensor_y_max = 0;  ///< m, scene frame
};

/// Makes the plan: spectral grid and band quadrature, the cheapest node counts (host/plan/node_choice.h) whose
/// error is inside its share of `simulation.tolerance`, sky components by weighted SVD (component 0 carries the
/// irradiance exactly), the law of the sky's rays. Throws Error(input) when a band leaves the table or a
/// material's curve, or the table lacks a row. A plan that may not hold the tolerance says so in `refusal`: the
/// caller measures it, or stops there. The same on any number of threads (0: as many as the machine has).
Plan make_plan(const scene::Simulation& simulation, const scene::Instrument& instrument,
               const atmos::RenderTable& table, const ViewBounds& view, int threads = 0);

/// Bakes one term row in double: E[channel][band] for a product key (kernels/shared/product_key.h; 0 = path) or
/// kEnvironmentKey | node or kSkeletonKey | wavelength (one channel for each node of height and view), stored as
/// float, columns() padded with zeros to a multiple of 16: result[channel * padded + column]. Emission goes with
/// the key of one reflectance. Where there is truth per band (host/plan/band_truth.h) a material's row has one channel
/// more, its coverage. Error(input) when a curve does not cover the grid, which
/// cannot happen to the reflectance of a used material. Read from plan.baked where that has it.
std::vector<float> bake_row(const Plan& plan, const scene::CompiledScene& scene, std::uint64_t key);

}  // namespace raycube::plan
