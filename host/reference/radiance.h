// Radiance at the sensor as the textbook writes it: per sample, per wavelength, in double (S15):
// L(l) = rho(l) [ direct sun + sky seen + what hides the sky ] + (1 - rho(l)) B(l, T) T_view + path, rho of a lobe in
// emission times its albedo towards the viewer.
#pragma once

#include <array>
#include <functional>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "atmos_tables/render_table.h"
#include "host/reference/ground_around.h"
#include "host/reference/sampled_pixel.h"
#include "scene_compiler/lobe_albedo.h"

namespace raycube::reference {

/// Band radiances of one pixel, W m-2 sr-1 um-1, by physics block.
struct BandRadiance {
  std::vector<double> sun, sky, path;          ///< [band]; sky and path with their thermal light
  std::vector<double> lamps;                   ///< [band]; empty without lamps
  std::vector<double> environment;             ///< [band]; empty without light between ground and air
  std::vector<double> emission, surroundings;  ///< the surface's own light; that of what hides the sky, reflected
  double total(std::size_t band) const {
    return sun[band] + sky[band] + path[band] + (environment.empty() ? 0 : environment[band]) + emission[band] +
           surroundings[band] + (lamps.empty() ? 0 : lamps[band]);
  }
};

/// Every curve of the scene's materials, [curve - 1], on a wavelength grid: linear between the curve's nodes, its end
/// values outside; zero where a material has none. The reflectances come first, in the materials' order.
std::vector<std::vector<double>> curves_on(const scene::CompiledScene& scene, const std::vector<double>& wavelength_um);

/// Quadrature of a spectrum on the plan's grid over every band.
std::vector<double> band_values(const plan::Plan& plan, const std::vector<double>& spectrum);

/// The plan's irradiance map at a unit normal, components 0..3. Own double form of the documented interpolant:
/// octahedron |x|+|y|+|z| = 1 unfolded on [-1,1]^2, each cell cut along the diagonal parallel to its quadrant's fold,
/// linear on the triangles.
std::array<double, 4> unoccluded_irradiance(const plan::IrradianceMap& map, const glm::dvec3& normal);

/// The plan's table of thermal sky and surroundings at a normal's vertical component, linear between its nodes.
std::array<double, 4> thermal_unoccluded(const plan::Thermal& thermal, double normal_z);

/// A ray of a pixel into the sky (rc_sky_sample, rc_sky_number): its number, and how many samples it stands for.
struct NumberedRay {
  std::uint32_t number = 0;
  double samples = 1;
};

/// The rays of every sample of a pixel, [sample]; empty lists where the plan has no sky.
std::vector<std::vector<NumberedRay>> numbered_rays(const plan::Plan& plan, const scene::Instrument& instrument,
                                                    std::uint64_t seed, std::uint32_t pixel);

/// What a ray into the sky from one side of a sample's surface said.
struct SentRay {
  glm::dvec3 direction{0};  ///< unit
  /// Irradiance that a radiance of 1 brings by it: samples it stands for * cosine / density, sr. 0 below the horizon of
  /// surface or scene: then nothing was asked.
  double weight = 0;
  double solid_angle_sr = 0;  ///< the same without the cosine, at most 20 a sample: of rounding in the normal
  bool open = true;
};
using SentRays = std::vector<SentRay>;

/// By Embree, in the order in which the device adds them up.
SentRays sent_rays(const ReferenceScene& scene, const plan::Plan& plan, std::uint64_t seed, std::uint32_t pixel,
                   const Sample& side, const std::vector<NumberedRay>& rays);

/// The plan's components from a direction, sr-1: solar, thermal sky, surroundings (-1). Zero below the horizon.
std::array<double, 8> sky_light(const plan::Plan& plan, const glm::dvec3& direction);

/// Density of a way that a gloss mirrors the viewer's to, sr-1: facets by Trowbridge and Reitz (J. Opt. Soc. Am. 65,
/// 531, 1975), mirrored.
double mirrored_density(const scene::CompiledScene& scene, const Sample& gloss, const glm::dvec3& direction);

/// Share of the open sky that a side of a surface takes for granted; by gloss none.
double known_share(const scene::CompiledScene& scene, const plan::Plan& plan, const Sample& side);

/// Arithmetic form: the plan's nodes, sky components and rays taken as spectra.
class ArithmeticModel {
 public:
  /// Unoccluded irradiance of the plan's components against a unit normal.
  using OpenSky = std::function<std::array<double, 8>(const glm::dvec3& normal)>;

  /// Keeps references. Without `open` the plan's own map and table.
  ArithmeticModel(const scene::CompiledScene& scene, const plan::Plan& plan, OpenSky open = {});

  /// sent[i]: of SampledPixel::side(i), see sent_rays. lamplight[i]: irradiance on that side by the plan's lamps,
  /// W m-2, [source], with shapes times pi f.
  BandRadiance radiance(const SampledPixel& pixel, const std::vector<SentRays>& sent,
                        const std::vector<std::vector<double>>& lamplight = {}) const;

 private:
  /// On the plan's grid, by physics block.
  struct Spectra {
    std::vector<double> sun, sky, path, emission, surroundings, lamps;
  };
  /// By which light that falls onto the side of the sample goes to the viewer; material from 1.
  const std::vector<double>& curve_of(const Sample& sample, std::uint32_t material) const;
  /// Sun, sky and emission of one side of a surface.
  void add_side(const SampledPixel& pixel, const Sample& side, const SentRays& sent, Spectra& out) const;
  /// Irradiance of the plan's components on one side of a surface.
  std::array<double, 8> irradiance(const Sample& side, const SentRays& sent) const;
  void add_path(const SampledPixel& pixel, const Sample& sample, std::vector<double>& path) const;
  void add_source(const SampledPixel& pixel, const Sample& sample, int source, double scalar,
                  std::vector<double>& spectrum) const;
  void add_emission(const SampledPixel& pixel, const Sample& sample, std::vector<double>& spectrum) const;

  const scene::CompiledScene& scene_;
  const plan::Plan& plan_;
  OpenSky open_;
  std::vector<std::vector<double>> curve_;   ///< [curve - 1][grid], curves_on
  std::vector<std::vector<double>> ground_;  ///< [material][grid], ground_albedos
};

/// How a pixel's samples share the sky directions of the model form: each looks into `per_sample` of them, evenly
/// spread, another lot for each sample, and what it sees counts for all. 0: every sample looks into all. `turn_rad`:
/// the whole set is turned about the zenith.
struct SkyShare {
  int per_sample = 0;
  double turn_rad = 0;
  /// Half a step of the spiral of directions: another set as even, of which nothing is the same.
  static constexpr double kHalfStep_rad = 1.1999816148643266;
};

/// Model form: the whole table at each pixel's exact view and heights, and a dense set of sky directions.
/// Thermal light, whether the plan has it or not: every material that has a temperature emits at it, and what
/// the table says of path and sky is added. Where the plan has thermal light, what hides the sky is looked
/// up: it sends (1 - rho) B at its own temperature, and rho B at the plan's surroundings' for the light that
/// falls on it. Beside BouncedLight, whose paths do that, it counts as the surroundings do.
class TableModel {
 public:
  /// Keeps references. `no_air`: transmissions 1, no sky, no path.
  TableModel(const ReferenceScene& scene, const plan::Plan& plan, const atmos::RenderTable& table, bool no_air,
             int directions = 1024, const SkyShare& share = {}, bool beside_paths = false);

  BandRadiance radiance(const SampledPixel& pixel) const;

  /// Towards the sky, unit vectors, and the solid angle of each that a sample looks into.
  const std::vector<glm::dvec3>& directions() const { return direction_; }
  double solid_angle_sr() const { return solid_angle_; }

 private:
  enum class Light { sun, sky, thermal_sky, direct };
  std::vector<double> source(double height_m, double zenith_deg, Light light) const;
  /// Radiance on the plan's grid of a surface seen from nearby.
  std::vector<double> surface_light(std::uint32_t surface) const;
  /// A curve's part of what matter emits at wavelength i of the grid, W m-2 sr-1 um-1; cover: of what is seen of it;
  /// even: that times what its lobe sends of an even light.
  double emitted(std::uint32_t curve, double cover, double even, std::size_t i) const;
  void add_albedos();
  /// What a side's lobe sends of an even light to its viewer, by a table finer than the plan's.
  double even_light(const Sample& side) const;
  std::vector<double> on_grid(const std::vector<double>& table_spectrum) const;

  struct SkyView;
  struct PixelSums;
  struct Spectra;
  /// m; of a ray that meets nothing, the plan's lowest node.
  double height_of(const Sample& sample) const;
  /// Into one lot of the directions, every stride_-th.
  SkyView look(const Sample& sample, std::size_t lot) const;
  /// share: the sample's weight at the pixel's lowest and highest point.
  void add_hit(const Sample& sample, const SkyView& view, const double share[2], PixelSums& sums) const;
  PixelSums gather(const SampledPixel& pixel) const;
  void add_path(const SampledPixel& pixel, double height_m, double weight, Spectra& out) const;
  /// Reflected light of what hides the sky: the surfaces met, or black surroundings beyond the scene.
  void add_surroundings(const std::map<std::uint32_t, double>& hidden, const std::vector<double>& rho,
                        const std::vector<double>& direct, std::vector<double>& surroundings) const;
  /// Radiance at the sensor per unit reflectance of the sky's light, weighed by direction: on the table's wavelengths.
  std::vector<double> sky_at_sensor(const std::vector<double>& weight, double height_m,
                                    const std::vector<double>& through,
                                    const std::vector<double>& thermal_through) const;
  /// Sun, emission, surroundings and sky of every material at one end of the pixel's heights.
  void add_materials(const PixelSums& sums, int end, double height_m, double zenith_deg, Spectra& out) const;

  const ReferenceScene& scene_;
  const plan::Plan& plan_;
  const atmos::RenderTable& table_;
  bool no_air_, beside_paths_;
  bool sun_ = true, skylight_ = true;            ///< the table has rows of the sun's light
  bool warm_path_ = false, warm_sky_ = false;    ///< and of the air's own
  std::vector<std::vector<double>> curve_;       ///< [curve - 1][grid], curves_on
  std::vector<std::vector<double>> black_body_;  ///< [material][grid] B at its temperature; empty without one
  std::vector<std::pair<scene::Shape, scene::LobeAlbedo>> albedo_;  ///< of the shapes of matter that has a temperature
  std::vector<glm::dvec3> direction_;
  std::size_t stride_ = 1;  ///< a sample looks into every so many
  double solid_angle_ = 0;  ///< sr, of each direction that a sample looks into
  double height_first_ = 0, height_step_ = 1;
  std::optional<EnvironmentModel> environment_;
  std::vector<std::vector<float>> sky_;          ///< [height node][direction * table wavelengths], W m-2 sr-1 um-1
  std::vector<std::vector<float>> thermal_sky_;  ///< the same; empty where the table has none
};

}  // namespace raycube::reference
