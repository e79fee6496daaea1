// What a simulation file says, validated and with every default filled in; the scene itself is compiled apart.
// Angles in degrees and lengths in metres as typed; azimuth clockwise from north, of the direction towards the thing
// named.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "scene_compiler/band_truth.h"
#include "scene_compiler/compiled_scene.h"
#include "scene_compiler/detector_spec.h"
#include "scene_compiler/focal_plane_spec.h"
#include "scene_compiler/lamp.h"
#include "scene_compiler/lidar_spec.h"
#include "scene_compiler/tolerance_measure.h"

namespace raycube::scene {

enum class InstrumentKind { framing, whiskbroom, pushbroom };
enum class SamplerKind { grid, lattice, jittered };
enum class StandardError { off, worst, bands };  ///< a layer of the truth; bands: a cube beside the radiance too
/// Pixels that hold objects smaller than their samples see get the samples they need (host/sensors/small_objects.h);
/// automatic: where the planner chooses the samples. A renderer takes automatic for off.
enum class SmallObjects { off, on, automatic };
enum class PoseMotion { held, moving, automatic };

/// One pose of the platform. Position in the scene frame, metres; roll about the flight axis (right wing down
/// positive), pitch (nose up positive), yaw = heading clockwise from north. Rotation order yaw, pitch, roll (z-y-x,
/// intrinsic).
struct Pose {
  double x_m = 0, y_m = 0, z_m = 0;
  double roll_deg = 0, pitch_deg = 0, heading_deg = 0;
};

/// One band's relative spectral response. Either Gaussian (centre and FWHM) or tabulated.
struct Band {
  double center_um = 0;
  double fwhm_um = 0;                 ///< 0 when tabulated
  std::vector<double> wavelength_um;  ///< tabulated response, ascending, vacuum
  std::vector<double> response;       ///< >= 0
  /// A Gaussian counts no further than this: something that it needs is known no further (host/run/air_limits.h).
  double from_um = 0, to_um = 1e9;
  std::string name;
};

struct Instrument {
  std::string name;
  InstrumentKind kind = InstrumentKind::framing;
  int pixels = 0;  ///< samples of a line
  int lines = 0;
  double ifov_along_rad = 0;   ///< image-plane pixel pitch / focal length, across lines (v)
  double ifov_across_rad = 0;  ///< along a line (u)
  std::vector<Pose>
      poses;  ///< one (framing), one per line (pushbroom), or one per pixel in line-sample order (whiskbroom)
  /// Pushbroom with moving pose: platform velocity while a line is exposed, and the exposure, both zero when held.
  PoseMotion motion = PoseMotion::held;
  double nominal_agl_m = 0;  ///< what the file called altitude above ground; 0 when poses were given
  SamplerKind sampler = SamplerKind::grid;
  int samples_u = 11, samples_v = 11;  ///< grid and jittered: cells; lattice: total = samples_u * samples_v points
  bool samples_given = false;          ///< by the file; otherwise the planner chooses them (host/planner)
  /// Of the planner: the image is the mean of so many renders, each with shifts and sky rays of its own.
  int replicates = 1;
  int samples_of_replicate() const { return samples_u * samples_v; }
  int all_samples() const { return replicates * samples_of_replicate(); }
  int first_samples = 0;  ///< adaptive: lattice points of a first pass; pixels that it does not settle get all; 0: none
  /// Whether a pixel is the plain square that its samples cover.
  bool box_pixels() const { return psf_sigma_px == 0 && psf_support_px == 1; }
  bool adaptive() const { return first_samples > 0 && first_samples < samples_u * samples_v; }
  SmallObjects small_objects = SmallObjects::off;
  StandardError standard_error = StandardError::off;
  bool auto_bounces = true;   ///< the planner may let light go between surfaces; false: only a number in the file does
  double psf_sigma_px = 0;    ///< Gaussian PSF sigma in pixels; 0: box, no blur
  double psf_support_px = 1;  ///< width of the square the samples cover, pixels; 1 for the box
  std::vector<FocalPlane> focal_planes;  ///< empty: every band is the mean of the pixel's own samples
  /// Number of the focal plane that sees a band of this centre; as many as there are: none.
  std::size_t plane_of(double center_um) const {
    const auto sees = [=](const FocalPlane& p) { return center_um >= p.first_um && center_um < p.last_um; };
    return static_cast<std::size_t>(std::find_if(focal_planes.begin(), focal_planes.end(), sees) -
                                    focal_planes.begin());
  }
  int oversampling = 0;  ///< cells along a pixel of those; 0: as their point spreads ask for
  /// Of an instrument whose pixels are cells of another's (host/sensors/cells.h): what their draws err by, of that, is
  /// left in the pixels.
  double share_of_draws = 1;
  /// And how many of them are one of its pixels, across and along.
  std::array<int, 2> cells_of_pixel{1, 1};
  std::optional<DetectorSpec> detector;
  std::vector<Band> bands;
  std::vector<int> quicklook_bands;  ///< 0-based, red green blue (three) or grey (one)
  // products
  std::string interleave = "bip";  ///< bip, bil, bsq
  bool write_exr = true, write_png = true;
  std::optional<double> integer_scale;  ///< write uint16 of round(radiance * scale)
  bool first_opaque = false;            ///< truth of what lies behind leaves
  std::vector<BandTruth> band_truth;    ///< cubes of it, ascending
  bool all_parts = false;               ///< and all parts of the radiance that there are
  bool asks_for(BandTruth truth) const {
    return std::find(band_truth.begin(), band_truth.end(), truth) != band_truth.end();
  }
};

enum class MeasureViews { principal, orthogonal, hemisphere };

/// Reflectance factors of a level area (host/run/measure.h).
struct Measure {
  std::string name;
  std::string bands_of;  ///< instrument
  std::array<double, 2> center_m{}, size_m{};
  std::optional<double> height_m;  ///< of the level; none: the scene's highest point
  MeasureViews views = MeasureViews::principal;
  double first_deg = 0, last_deg = 0, step_deg = 0;  ///< zenith angles in a plane
  int directions = 0;                                ///< of a hemisphere
  int pixels = 0, samples = 0, paths = 0;            ///< along a side; of a pixel in a batch
};

/// Where the light goes that falls onto a level area (host/run/light_budget.h).
struct LightBudget {
  std::string name;
  std::string bands_of;  ///< instrument
  bool isotropic = false;
  std::array<double, 2> center_m{};
  std::optional<std::array<double, 2>> size_m;  ///< none: the cell that repeats
  std::optional<double> height_m;               ///< of the level; none: the scene's highest point
  std::vector<std::string> ground;              ///< materials
  bool par = false;                             ///< photosynthetically active light is a band more
  std::vector<double> levels_m;
  std::vector<std::string> facets;  ///< meshes
  std::uint64_t photons = 0;
};

/// Where the sun is. Towards the sun, seen from the scene origin.
/// The light in the sky: the sun, or the moon in its place.
struct Sun {
  double moon_phase_deg = -1;  ///< angle sun, moon, earth: 0 full, 180 new; below 0: it is the sun
  double zenith_deg = 0;
  double azimuth_deg = 0;
  int day_of_year = 0;  ///< 1..366; 0: earth-sun distance factor 1
  std::string utc;      ///< empty when angles were given
};

/// Light between ground and air; automatic: local where the table has the rows, else off.
enum class Adjacency { automatic, local, mean, off };

/// A cloud or fog that covers the whole sky; air_spec.def has the fields of this and the next three. Heights
/// above the sea.
struct CloudSpec {
#define RC_CLOUD(type, name, fallback, text) type name = fallback;
#include "scene_compiler/air_spec.def"
};

/// Absorption cross-sections of one gas from a user's file.
struct CrossSectionSpec {
#define RC_CROSS_SECTION(type, name, fallback, text) type name = fallback;
#define RC_CROSS_SECTION_FILE(name, text) std::string name;
#include "scene_compiler/air_spec.def"
};

/// An aerosol of the user's own, its files read.
struct OwnAerosolSpec {
#define RC_OWN_AEROSOL(type, name, fallback, text) type name = fallback;
#include "scene_compiler/air_spec.def"
};

/// The air of the layered model.
struct AirSpec {
#define RC_AIR(type, name, fallback, text) type name = fallback;
#define RC_AIR_FILE(name, text) std::string name;
#include "scene_compiler/air_spec.def"
};

/// The sun's spectrum above the air at 1 AU: a shipped one by its name (atmos_tables/solar_spectrum.h), or a file's.
struct SolarSpectrumSpec {
  std::string name = "tsis1";         ///< of a file: its path
  std::vector<double> wavelength_um;  ///< vacuum, ascending; empty: the shipped one
  std::vector<double> irradiance;     ///< W m-2 um-1, one for each
};

/// Parameters of the built-in clear-sky model, or the file of an imported table.
struct AtmosphereSpec {
  std::string table_file;         ///< absolute path; empty: build
  double ground_height_m = 0;     ///< above sea level, of the scene's z = 0 (origin height)
  double pressure_hPa = 1013.25;  ///< at the ground
  double water_g_cm2 = 1.5;
  double ozone_atm_cm = 0.32;
  double aod_550 = 0.1;  ///< aerosol optical depth at 0.55 um, vertical
  double angstrom = 1.2;
  double ssa = 0.945;  ///< aerosol single-scattering albedo at 0.4 um (Bird & Riordan's rural)
  double asymmetry = 0.65;
  double ground_albedo = 0.0;  ///< for the sky's ground-reflected part
  Adjacency adjacency = Adjacency::automatic;
  bool none = false;  ///< no air: T = 1, no sky, no path radiance (tests, laboratories)
  SolarSpectrumSpec solar;
  std::vector<double> view_zenith_deg;  ///< nodes of a built table, ascending; empty: the model's own
  std::optional<AirSpec>
      layered;  ///< the layered model; of the fields above it uses ground, sun and view zeniths alone
};

/// What the user fixes of a plan; 0: the plan's own choice, by the tolerance. docs/accuracy.md has what each costs.
struct PlanOverrides {
  int sky_rank = 0;  ///< components of the sunlit sky, 1..4; a sky of fewer shapes is exact with those
  int height_nodes = 0, view_nodes = 0,
      path_nodes = 0;  ///< of kNodeCounts (host/plan/node_choice.h); path: along each of its two axes
  bool any() const { return sky_rank || height_nodes || view_nodes || path_nodes; }
};

class Ground;

/// Of a pixel, where neither file nor planner says.
inline constexpr int kDefaultSkyDirections = 64;
/// Paths that may go with two directions into the sky; how many go with all of them, rounded up.
inline constexpr int kMostPathsPerTwo = 8;
constexpr int paths_beside(int sky_directions, int per_two = 1) { return (sky_directions * per_two + 1) / 2; }
/// Surfaces after the first, of which the planner chooses.
inline constexpr int kMostChosenBounces = 64;

/// A whole simulation as one file describes it.
struct Simulation {
  std::string file;  ///< absolute path
  double tolerance = 0.01;
  ToleranceMeasure tolerance_of;  ///< of cameras
  std::uint64_t seed = 1;
  int sky_directions = kDefaultSkyDirections;  ///< of a pixel, shared out among its samples
  int bounces = 0;                             ///< surfaces that light may come by after the first
  bool bounces_given = true;  ///< false: the planner chooses between that many and none (host/planner/bounce_choice.h)
  bool sky_directions_given = false;  ///< by the file; otherwise the planner chooses them (host/planner)
  int paths_per_two = 1;              ///< paths between surfaces for two such directions, where they are given
  PlanOverrides plan;
  bool thermal_below_3um = true;  ///< false: bands below 3 um go without thermal light whatever it makes
  AtmosphereSpec atmosphere;
  Sun sun;
  std::vector<Instrument> instruments;
  std::vector<Lidar> lidars;
  std::vector<Lamp> lamps;
  std::vector<Measure> measures;
  std::vector<LightBudget> budgets;
  std::optional<std::array<double, 2>> cell_m;  ///< of a scene that repeats: width and length
  int cell_copies = 0;                          ///< of it to each of its four sides
  CompiledScene scene;
  std::shared_ptr<const Ground> ground;  ///< kept where a LIDAR counts heights from it, else null
  std::string resolved_json;             ///< every option with its value after defaults
  std::vector<std::string> notices;  ///< what the user should know though it is no error: dropped faces, sorted bands
};

}  // namespace raycube::scene
