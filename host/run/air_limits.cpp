#include "host/run/air_limits.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "atmos_tables/clear_sky.h"
#include "atmos_tables/compiler/layered_air.h"
#include "atmos_tables/rct_file.h"
#include "host/base/error.h"
#include "host/plan/quadrature.h"
#include "host/run/air_table.h"
#include "host/run/camera_job.h"
#include "scene_compiler/matter.h"

namespace raycube::run {

namespace {

/// Tables are read for bands from this width on: what narrower ones reach beyond a table is for its user to see.
constexpr double kWide_um = 0.05;

struct Limit {
  double from_um = 0, to_um = 0;
  std::string of;
};

/// Share of a Gaussian of unit area beyond `away` from its centre.
double weight_beyond(double away_um, double fwhm_um) {
  return 0.5 * std::erfc(2 * std::sqrt(std::numbers::ln2) * away_um / fwhm_um);
}

bool is_wide(const scene::Band& band) { return band.fwhm_um >= kWide_um; }

/// What the air covers; its table is read where a wide band asks.
Limit air_limit(const scene::Simulation& simulation, const scene::Instrument& instrument) {
  const scene::AtmosphereSpec& spec = simulation.atmosphere;
  if (spec.table_file.empty()) {
    const double last = spec.none      ? atmos::kVacuumLast_um
                        : spec.layered ? atmos::kLayeredLast_um
                                       : atmos::kClearSkyLast_um;
    return {atmos::kClearSkyFirst_um, last, "the atmosphere"};
  }
  if (std::none_of(instrument.bands.begin(), instrument.bands.end(), is_wide)) return {0, 1e9, ""};
  try {
    const auto table = known_table(air_request(simulation, instrument, instrument.poses.front().z_m));
    const auto& um = table->axis("wavelength").nodes;
    return {um.front(), um.back(), "the atmosphere's table"};
  } catch (const base::Error&) {  // whoever needs the table says what is wrong with it
    return {0, 1e9, ""};
  }
}

std::vector<Limit> limits_of(const scene::Simulation& simulation, const scene::Instrument& instrument) {
  std::vector<Limit> limits = {air_limit(simulation, instrument)};
  const scene::CompiledScene& scene = simulation.scene;
  for (const auto curve : scene::seen_curves(scene)) {
    const auto& um = scene::curve_of(scene, curve).wavelength_um;
    if (um.size() > 1 && scene::carries_light(scene, curve))
      limits.push_back(
          {um.front(), um.back(), "material '" + scene.materials[scene::material_of_curve(scene, curve)].name + "'"});
  }
  return limits;
}

/// What limits leave of a band.
struct Cut {
  double from_um = 0, to_um = 1e9, lost = 0;  ///< lost: share of the weight beyond
  std::string by;                             ///< what takes most
};

Cut cut_of(const scene::Band& band, const std::vector<Limit>& limits) {
  const auto [from, to] = plan::band_support(band);
  Cut cut{from, to, 0, ""};
  double below = 0, above = 0, most = 0;
  for (const Limit& limit : limits) {
    const double first = weight_beyond(band.center_um - limit.from_um, band.fwhm_um),
                 last = weight_beyond(limit.to_um - band.center_um, band.fwhm_um);
    if (limit.from_um > cut.from_um) cut.from_um = limit.from_um, below = first;
    if (limit.to_um < cut.to_um) cut.to_um = limit.to_um, above = last;
    const double worse = std::max(limit.from_um > from ? first : 0, limit.to_um < to ? last : 0);
    if (worse > most) most = worse, cut.by = limit.of;
  }
  cut.lost = below + above;
  return cut;
}

/// The band that loses most, and how many lose something.
struct Worst {
  std::size_t band = 0, count = 0;
  Cut cut;
  void add(std::size_t b, const Cut& one) {
    ++count;
    if (one.lost > cut.lost) band = b, cut = one;
  }
  std::string bands() const {
    return count == 1 ? "the Gaussian of a band" : fmt::format("Gaussians of {} bands", count);
  }
};

std::string range(double from_um, double to_um) {
  return fmt::format("{:.6g} to {:.6g} nm", 1000 * from_um, 1000 * to_um);
}

void cut_bands(scene::Simulation& simulation) {
  for (scene::Instrument& instrument : simulation.instruments) {
    const bool gaussian = std::any_of(instrument.bands.begin(), instrument.bands.end(),
                                      [](const scene::Band& band) { return band.fwhm_um > 0; });
    if (!gaussian || instrument.poses.empty()) continue;
    const auto limits = limits_of(simulation, instrument);
    Worst cut, left;
    for (std::size_t b = 0; b < instrument.bands.size(); ++b) {
      scene::Band& band = instrument.bands[b];
      if (!(band.fwhm_um > 0)) continue;
      const Cut one = cut_of(band, limits);
      if (!(one.lost > 0)) continue;
      if (one.lost <= kMostLostWeight)
        cut.add(b, one), band.from_um = one.from_um, band.to_um = one.to_um;
      else if (one.lost < 0.5)  // else its centre is outside, which needs no word about cuts
        left.add(b, one);
    }
    const std::string name = "instrument '" + instrument.name + "': ";
    if (cut.count > 0)
      simulation.notices.push_back(
          fmt::format("{}{} cut to what {} covers (band {}: {}, {:.1g} of its weight lies beyond)", name,
                      cut.bands() + (cut.count == 1 ? " is" : " are"), cut.cut.by, cut.band + 1,
                      range(cut.cut.from_um, cut.cut.to_um), cut.cut.lost));
    if (left.count > 0)
      simulation.notices.push_back(
          fmt::format("{}{} too much beyond what {} covers to be cut (band {}: {:.2g} of its weight, at most {:g} are "
                      "cut): give the "
                      "measured response, or a smaller FWHM",
                      name, left.bands() + (left.count == 1 ? " has" : " have"), left.cut.by, left.band + 1,
                      left.cut.lost, kMostLostWeight));
  }
}

/// Whether a table is one of the air that is held there: those of other codes have their own light below it.
bool is_held_table(const std::string& file) {
  try {
    return std::abs(atmos::read_rct(file).sun_zenith_deg - kHeldZenith_deg) < 1e-6;
  } catch (const base::Error&) {  // whoever needs the table says what is wrong with it
    return false;
  }
}

void hold_sun(scene::Simulation& simulation) {
  scene::Sun& sun = simulation.sun;
  const scene::AtmosphereSpec& spec = simulation.atmosphere;
  if (spec.none || sun.moon_phase_deg >= 0) return;
  // The light of the models falls to nothing between the held angle and 90 deg, and would jump up at the horizon.
  if (sun.zenith_deg <= kHeldZenith_deg || sun.zenith_deg > kSunsetZenith_deg) return;
  if (!spec.table_file.empty() && !is_held_table(spec.table_file)) return;
  simulation.notices.push_back(fmt::format(
      "the sun stands at a zenith angle of {:.7g} deg, where its disc is still seen but the light of the built-in air "
      "ends: the light of {:g} deg is taken",
      sun.zenith_deg, kHeldZenith_deg));
  sun.zenith_deg = kHeldZenith_deg;
}

}  // namespace

void keep_within_air(scene::Simulation& simulation) {
  cut_bands(simulation);
  hold_sun(simulation);
}

}  // namespace raycube::run
