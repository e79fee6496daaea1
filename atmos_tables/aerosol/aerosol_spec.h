// What a user says about aerosols, fog and clouds.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "atmos_tables/aerosol/droplet_optics.h"
#include "scene_compiler/simulation.h"

namespace raycube::atmos {

/// Aerosol of the lowest 2 km. none: no aerosol at any height. tropospheric: rural without large particles.
enum class AerosolModel : std::size_t {
  none,
  rural,
  urban,
  maritime,
  desert,
  tropospheric,
  fog_advective,
  fog_radiative
};
inline constexpr std::array<const char*, 8> kAerosolNames = {
    "none", "rural", "urban", "maritime", "desert", "tropospheric", "fog_advective", "fog_radiative"};

/// 10 to 30 km: background, or after volcanic eruptions (moderate: aged ash; high and extreme: fresh ash).
enum class StratosphereModel : std::size_t { background, moderate_volcanic, high_volcanic, extreme_volcanic };
inline constexpr std::array<const char*, 4> kStratosphereNames = {"background", "moderate_volcanic", "high_volcanic",
                                                                  "extreme_volcanic"};

/// The figures' water clouds and ice clouds (modal radius in the name), and fogs as layers.
enum class CloudKind : std::size_t {
  cumulus,
  altostratus,
  stratus,
  stratocumulus,
  nimbostratus,
  cirrus_64um,
  cirrus_4um,
  fog_advective,
  fog_radiative
};
inline constexpr std::array<const char*, 9> kCloudNames = {"cumulus",       "altostratus",   "stratus",
                                                           "stratocumulus", "nimbostratus",  "cirrus_64um",
                                                           "cirrus_4um",    "fog_advective", "fog_radiative"};

struct CloudLayer {
  double base_km = 0, top_km = 0;  ///< above the sea, base < top, inside the profile
  double optical_depth_550 = 0;    ///< vertical extinction depth at 0.55 um, 0..700; evenly spread
  CloudKind kind = CloudKind::stratus;
  std::optional<DropletModel> droplets = std::nullopt;  ///< own spheres instead of the figures of `kind`
};

struct AerosolSpec {
  AerosolModel boundary = AerosolModel::rural;  ///< 0..2 km above ground
  /// Meteorological range, km: 3.912 / extinction at 0.55 um at the ground, Rayleigh included. 0.02..323.58 (more is
  /// held there).
  double visibility_km = 23;
  /// >= 0: vertical depth of all aerosols at 0.55 um, in place of visibility_km. The visibility that has this depth is
  /// found (MODTRAN's practice: boundary layer and lower troposphere change); below the least depth all is scaled, with
  /// a notice.
  double aod_550 = -1;
  /// Relative humidity of the boundary layer, %, < 0: that of the profile's lowest level. Above 99 the figures of 99
  /// hold.
  double humidity_percent = -1;
  bool spring_summer = true;  ///< season of the tropospheric and stratospheric profiles
  StratosphereModel stratosphere = StratosphereModel::background;
  double wind_m_s = 10;  ///< desert only, 0..30
  std::vector<CloudLayer> clouds;
  std::vector<scene::OwnAerosolSpec> own;  ///< the user's, beside those above
  /// LOWTRAN7's rules, for comparisons with it: optics linear between tabulated wavelengths (BetweenWaves in
  /// substance.h), and for humidity_percent < 0 the mean over the boundary layer, weighted with its extinction, instead
  /// of the lowest level's.
  bool lowtran_rules = false;
  /// Henyey-Greenstein with the table's asymmetry for every component: for comparisons with codes that use it.
  bool henyey_greenstein = false;
};

/// Names as in the arrays above; throws Error(input) that lists them.
AerosolModel parse_aerosol(const std::string& name);
StratosphereModel parse_stratosphere(const std::string& name);
CloudKind parse_cloud(const std::string& name);
inline const char* to_string(AerosolModel model) { return kAerosolNames[static_cast<std::size_t>(model)]; }
inline const char* to_string(StratosphereModel model) { return kStratosphereNames[static_cast<std::size_t>(model)]; }
inline const char* to_string(CloudKind kind) { return kCloudNames[static_cast<std::size_t>(kind)]; }

}  // namespace raycube::atmos
