#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <fmt/format.h>

#include "host/base/doing.h"
#include "host/base/error.h"
#include "host/base/parallel.h"
#include "host/base/units.h"
#include "host/plan/adjacency.h"
#include "host/plan/band_space.h"
#include "host/plan/band_truth.h"
#include "host/plan/bounces.h"
#include "host/plan/channel_bands.h"
#include "host/plan/given_levels.h"
#include "host/plan/irradiance_map.h"
#include "host/plan/lamps.h"
#include "host/plan/plan.h"
#include "host/plan/plan_errors.h"
#include "host/plan/sky_factors.h"
#include "host/plan/sky_rays.h"
#include "host/plan/sources.h"
#include "host/plan/spectral_plan.h"
#include "host/plan/thermal_plan.h"
#include "host/plan/thermal_use.h"
#include "scene_compiler/matter.h"

namespace raycube::plan {

namespace {

/// Part of the tolerance for each block (nodes of height, view and path; sky components), and for all of them together.
constexpr double kShare = 0.1, kBudget = 0.3;
/// Part of the horizontal irradiance that the irradiance map may be off between its nodes: a hundredth of the tolerance
/// (a tenth of what a block may be off by), and at most half of the 1e-4 within which it and the sampled maps are to
/// agree.
constexpr double kMapShareOfTolerance = 0.01, kMostMapShare = 5e-5;
/// Part of that which the grid may err that the map is read from.
constexpr double kGridPart = 0.5;
constexpr int kMaxThermalComponents = 2;

Domain make_domain(const scene::Simulation& simulation, const atmos::RenderTable& table, const ViewBounds& view) {
  Domain domain;
  const auto& scene = simulation.scene;
  if (!scene.blocks.empty() && scene.lo[2] <= scene.hi[2]) {
    domain.z_lo = static_cast<double>(scene.lo[2]);
    // Rays look down: what towers over the sensor blocks light but is never seen.
    domain.z_hi = std::max(domain.z_lo, std::min(static_cast<double>(scene.hi[2]), view.sensor_height_m));
  }
  domain.sun_zenith = base::rad_from_deg(simulation.sun.zenith_deg);
  domain.sun_azimuth = base::rad_from_deg(simulation.sun.azimuth_deg);
  domain.view = view;
  // A table without sunlight holds for any sun.
  if (!simulation.atmosphere.none && table.has("solar_irradiance") &&
      std::abs(table.sun_zenith_deg - simulation.sun.zenith_deg) > 0.05)
    throw base::Error(
        base::Fault::input,
        fmt::format("the atmosphere table is for a sun zenith of {:.4f} deg, the simulation has {:.4f} deg; build or "
                    "import a table for this sun, or set the sun to the table's",
                    table.sun_zenith_deg, simulation.sun.zenith_deg));
  return domain;
}

/// A normal and the exact irradiance there.
struct IrradianceCheck {
  double x, y, z;
  std::array<double, 4> want;
};

/// Over the whole sphere of normals.
std::vector<IrradianceCheck> irradiance_checks(const SkyIrradiance& exact, double sun_azimuth, int threads) {
  constexpr std::size_t tilts = 30, turns = 20;
  std::vector<IrradianceCheck> checks(tilts * turns);
  base::for_each_index(tilts, threads, [&](std::size_t i) {
    const double z = 1 - (2 * static_cast<double>(i) + 1) / tilts, r = std::sqrt(1 - z * z);
    std::array<double, turns> turn;
    std::array<std::array<double, 4>, turns> want;
    for (std::size_t k = 0; k < turns; ++k)
      turn[k] = 2 * std::numbers::pi * std::fmod(static_cast<double>(i * turns + k) * (std::numbers::phi - 1), 1.0);
    exact.at(std::acos(z), turn, want);
    for (std::size_t k = 0; k < turns; ++k)
      checks[i * turns + k] = {r * std::sin(turn[k] + sun_azimuth), r * std::cos(turn[k] + sun_azimuth), z, want[k]};
  });
  return checks;
}

/// Largest error of what `found(x, y, z)` says at the checks, of any mixture.
template <class Found>
double worst_irradiance(const std::vector<IrradianceCheck>& checks, const std::vector<Mixture>& mixtures,
                        const Found& found) {
  double worst = 0;
  for (const auto& [x, y, z, want] : checks) {
    const std::array<double, 4> here = found(x, y, z);
    for (const auto& mixture : mixtures) {
      double difference = 0;
      for (std::size_t m = 0; m < 4; ++m) difference += mixture[m] * (here[m] - want[m]);
      worst = std::max(worst, std::abs(difference));
    }
  }
  return worst;
}

/// The smallest map whose error between nodes, against the exact integral at fixed directions, is inside its share.
double fit_map(Plan& plan, double sun_azimuth, const std::vector<Mixture>& mixtures, int threads) {
  const SkyIrradiance exact(plan.sky_basis);
  const std::vector<IrradianceCheck> checks = irradiance_checks(exact, sun_azimuth, threads);
  const double share = std::min(kMapShareOfTolerance * plan.tolerance, kMostMapShare);
  const auto grid_of = [&](std::size_t tilts) { return IrradianceGrid(exact, sun_azimuth, tilts, threads); };
  const auto error_of = [&](const IrradianceGrid& grid) {
    return worst_irradiance(checks, mixtures, [&](double x, double y, double z) { return grid.at(x, y, z); });
  };
  IrradianceGrid grid = grid_of(kGridTilts.front());
  for (std::size_t finer = 1; finer < kGridTilts.size() && error_of(grid) > kGridPart * share; ++finer)
    grid = grid_of(kGridTilts[finer]);
  double worst = 0;
  for (const int size : kMapSizes) {
    worst = worst_irradiance(checks, mixtures,
                             [&](double x, double y, double z) { return read_between_nodes(grid, size, x, y, z); });
    if (worst > share && size != kMapSizes.back()) continue;
    plan.irradiance = make_irradiance_map(grid, size, threads);
    break;
  }
  return worst;
}

/// The sky with 1, 2, ... components, up to the first of at least `least` that meets its share.
std::vector<SkyLevel> sky_levels(const SkyFactorizer& sky, Sky kind, const TableSpectra& air, const Domain& domain,
                                 const BandSpace& bands, const std::vector<double>& typical, double share,
                                 int least = 1) {
  std::vector<SkyLevel> levels;
  if (sky.black()) return levels;
  const int most = kind == Sky::thermal ? kMaxThermalComponents : kMaxSkyComponents;
  const Spectrum up = sky_path(air, domain.z(0.5), domain.sec(0.5), kind);
  const auto mixtures = [&](const SkySpectra& spectra) { return band_mixtures(spectra, up, bands); };
  const Spectrum importance = sky_importance(air, domain, bands, sky.irradiance(), typical, kind);
  for (int rank = 1; rank <= most; ++rank) {
    levels.push_back(judge_sky(sky.factor(rank, importance, mixtures), air, domain, bands, typical));
    if (levels.back().factors.rank < rank) {  // the sky has no more shapes than the level before
      levels.pop_back();
      break;
    }
    if (rank >= least && !levels.back().negative && levels.back().error <= share) break;
  }
  return levels;
}

std::vector<SkyLevelReport> reported(const std::vector<SkyLevel>& levels) {
  std::vector<SkyLevelReport> out;
  for (const auto& level : levels)
    out.push_back({level.factors.rank, level.error, level.relative_error, level.negative});
  return out;
}

/// Error of each axis of nodes with each count of them.
AxisErrors reported(const NodeErrors& errors) {
  const auto list = [](const auto& values) { return std::vector<double>(values.begin(), values.end()); };
  return {{kNodeCounts.begin(), kNodeCounts.end()},
          list(errors.source_height),
          list(errors.source_view),
          list(errors.path_height),
          list(errors.path_x),
          list(errors.path_y)};
}

/// What all steps of one plan read: the air and the bands on the part of the table's axis that the bands reach.
struct Setting {
  const scene::Simulation& simulation;
  const Domain& domain;
  const TableSpectra& air;
  const BandSpace& bands;
  const SpectralPlan& spectral;
  const std::vector<double>& covered_um;
  std::size_t first;  ///< number of covered_um[0] on the table's axis
  double share;       ///< of typical radiance that one block may be off by
  int threads;
};

/// Sunlight's sky, the thermal one, and what emits.
struct Light {
  SkyFactorizer sky, thermal_sky;
  ThermalUse thermal;
  Emitters emitters;
  TypicalThermal emitted;  ///< by a typical surface; empty where thermal light is off
  std::vector<double> typical;

  Light(const Setting& at, ThermalUse use)
      : sky(at.air, at.domain.z(0.5), at.domain.sun_zenith, Sky::solar, at.threads),
        thermal_sky(at.air, at.domain.z(0.5), at.domain.sun_zenith, Sky::thermal, at.threads),
        thermal(std::move(use)) {
    if (thermal.on) {
      emitters = find_emitters(at.simulation.scene, at.simulation.file, thermal.demanded_by);
      emitted = {planck_spectrum(at.covered_um, emitters.surroundings_K), thermal_sky.irradiance()};
    }
    typical = typical_radiance(at.air, at.domain, at.bands, sky.irradiance(), emitted);
  }
};

/// Levels of each block with their errors.
struct Levels {
  NodeErrors errors;
  std::vector<SkyLevel> sky, thermal_sky;
  std::vector<TemperatureLevel> temperatures;
  SolarShare solar;  ///< beside thermal light
  bool skylight = true;
};

struct Chosen {
  NodeChoice nodes;
  double budget = 0;
};

/// The sky's components of the levels chosen; empty without.
struct ChosenSkies {
  SkyFactors solar, thermal;
};

/// A plan that knows its tolerance, its sun and its matter.
Plan begin_plan(const scene::Simulation& simulation, const Domain& domain) {
  Plan plan;
  plan.tolerance = simulation.tolerance;
  plan.sun_up = simulation.sun.zenith_deg < 90;
  plan.sun_direction = {static_cast<float>(std::sin(domain.sun_zenith) * std::sin(domain.sun_azimuth)),
                        static_cast<float>(std::sin(domain.sun_zenith) * std::cos(domain.sun_azimuth)),
                        static_cast<float>(std::cos(domain.sun_zenith))};
  plan.matter = scene::camera_matter(simulation.scene);
  plan.seen_curves = scene::seen_curves(simulation.scene);
  return plan;
}

/// Thermal light is on: its levels. Sun, sky and ground around that no band and no material can see beside it get no
/// channels.
void weigh_thermal(Plan& plan, const Setting& at, const Light& light, Levels& out) {
  NodeErrors& errors = out.errors;
  out.solar = solar_share(
      at.air, at.domain,
      BandSpace(at.covered_um, at.spectral.wavelength_um, at.spectral.bands, at.spectral.largest_reflectance),
      light.sky.irradiance(), light.typical);
  const double share = plan.matter.glossy && plan.sun_up ? -1 : at.share;  // a gloss mirrors more
  if (out.solar.sun <= share) errors.sun_sources = 0, errors.left_out += out.solar.sun;
  if (out.solar.sky <= share) out.skylight = false, errors.left_out += out.solar.sky;
  if (!plan.environment.empty() && out.solar.environment <= at.share)
    plan.environment = {}, errors.left_out += out.solar.environment;
  errors.surroundings = 1;
  add_leaning_keys(at.simulation.scene, plan.seen_curves);
  out.thermal_sky = sky_levels(light.thermal_sky, Sky::thermal, at.air, at.domain, at.bands, light.typical, at.share);
  out.temperatures = temperature_levels(light.emitters, at.air, at.domain, at.bands, at.covered_um, light.typical);
  for (const auto& level : out.temperatures)
    errors.temperature.emplace_back(static_cast<int>(level.node_K.size()), level.error);
}

/// What each level of each block would cost in radiance.
Levels weigh_levels(Plan& plan, const Setting& at, const Light& light) {
  Levels out;
  out.errors = estimate_node_errors(at.air, at.domain, at.bands, light.sky.irradiance(), light.typical, light.emitted);
  out.errors.lamps = plan.lamps.sources();
  if (light.thermal.on) weigh_thermal(plan, at, light, out);
  if (out.skylight)
    out.sky = sky_levels(light.sky, Sky::solar, at.air, at.domain, at.bands, light.typical, at.share,
                         at.simulation.plan.sky_rank);
  const auto error_of = [](const SkyLevel& level) {
    return level.negative ? std::numeric_limits<double>::infinity() : level.error;
  };
  for (const auto& level : out.sky) out.errors.sky_rank.push_back(error_of(level));
  for (const auto& level : out.thermal_sky) out.errors.thermal_rank.push_back(error_of(level));
  return out;
}

/// The cheapest nodes that hold the budget.
Chosen choose_within_budget(const NodeErrors& errors, const scene::Simulation& simulation) {
  const scene::PlanOverrides& given = simulation.plan;
  Chosen out;
  for (const double part :
       {kBudget, 0.5, 0.75, 1.0}) {  // where the channels do not hold the budget, the cheapest that holds more
    out.budget = part * simulation.tolerance;
    out.nodes = choose_nodes(errors, out.budget, given);
    if (out.nodes.within_budget) break;
  }
  if (!out.nodes.possible) throw impossible_levels(simulation);
  return out;
}

/// Why the nodes chosen do not hold the tolerance; empty: they do, or the file asked for them.
std::string refusal_of(const NodeChoice& choice, const scene::Simulation& simulation, const std::string& instrument) {
  const double total = choice.total();
  if (!(total > simulation.tolerance) || simulation.plan.any()) return {};
  return fmt::format(
      "instrument '{}': {} channels cannot hold the tolerance of {:g}: the nodes of height, view and path and the "
      "sky's components leave an estimated error of {:.3g} (source {:.3g}, path {:.3g}, sky {:.3g}, temperatures "
      "{:.3g})",
      instrument, RC_MAX_CHANNELS, simulation.tolerance, total, choice.source_error, choice.path_error,
      choice.sky_error, choice.emission_error);
}

/// The plan's axes, sources and components as they were chosen.
ChosenSkies take_choice(Plan& plan, const Setting& at, const Light& light, const Levels& levels,
                        const NodeChoice& choice) {
  const ViewBounds& view = at.domain.view;
  plan.height = make_axis(at.domain.z_lo, at.domain.z_hi, choice.height);
  plan.view = make_axis(view.sec_min, view.sec_max, choice.view);
  plan.path_x = make_axis(view.x_min, view.x_max, choice.path_x);
  plan.path_y = make_axis(view.y_min, view.y_max, choice.path_y);
  plan.sun_sources = levels.errors.sun_sources;
  plan.sky_components = choice.sky_rank;
  ChosenSkies skies;
  if (choice.sky_rank > 0) skies.solar = levels.sky[static_cast<std::size_t>(choice.sky_rank - 1)].factors;
  plan.sky_basis = skies.solar.basis;
  if (choice.thermal_rank > 0)
    skies.thermal = levels.thermal_sky[static_cast<std::size_t>(choice.thermal_rank - 1)].factors;
  if (light.thermal.on)
    plan.thermal =
        make_thermal(at.simulation.scene, light.emitters, levels.temperatures[choice.temperature], skies.thermal);
  return skies;
}

/// B of the surroundings, then of the temperature nodes, on the grid; empty without thermal light.
std::vector<std::vector<double>> planck_of(const Plan& plan, const std::vector<double>& grid_um) {
  std::vector<std::vector<double>> planck;
  if (plan.thermal.on) planck.push_back(planck_spectrum(grid_um, plan.thermal.surroundings_K));
  for (const double kelvin : plan.thermal.temperature_K) planck.push_back(planck_spectrum(grid_um, kelvin));
  return planck;
}

/// Spectra of all sources at every node of height and view, and of the path at every node of height and direction.
void fill_spectra(Plan& plan, const Setting& at, const ChosenSkies& skies) {
  const TableSpectra& air = at.air;
  const BandSpace& bands = at.bands;
  const auto planck = planck_of(plan, at.spectral.wavelength_um);
  plan.source_spectrum.resize(static_cast<std::size_t>(plan.source_channels()));
  for (int h = 0; h < plan.height.count; ++h) {
    const double z = node_position(plan.height, h);
    Spectrum flux_scale;
    const SkySpectra component = sky_spectra(skies.solar, air, z, &flux_scale, at.threads),
                     emitted_sky = sky_spectra(skies.thermal, air, z, nullptr, at.threads);
    if (air.has_sky() && air.knows_flux_of_sky())
      plan.sky_flux.add(
          z, at.first,
          flux_scale.empty() ? sky_flux_scale(air, z, at.domain.sun_zenith, at.threads) : std::move(flux_scale));
    for (int v = 0; v < plan.view.count; ++v) {
      const double sec = node_position(plan.view, v);
      const auto source = [&](int number) -> std::vector<double>& {
        return plan.source_spectrum[static_cast<std::size_t>((number * plan.height.count + h) * plan.view.count + v)];
      };
      if (plan.sun_sources > 0) source(0) = bands.to_grid(sun_source(air, z, sec));
      const Spectrum up = sky_path(air, z, sec);
      for (int m = 0; m < plan.sky_components; ++m)
        source(plan.first_component() + m) = bands.to_grid(product(component[static_cast<std::size_t>(m)], up));
      plan.transmission_spectrum.push_back(bands.to_grid(air.view_transmission(z, zenith_of_sec(sec))));
      const std::vector<double>& through = plan.transmission_spectrum.back();
      for (int m = 0; m < plan.lamps.sources(); ++m)
        source(plan.first_lamp() + m) =
            product(plan.lamps.spectrum[static_cast<std::size_t>(m)], through, 1 / std::numbers::pi);
      if (!plan.thermal.on) continue;
      const Spectrum thermal_up = sky_path(air, z, sec, Sky::thermal);
      const int warm_sky = plan.first_component() + plan.sky_components,
                surroundings = warm_sky + plan.thermal.sky_components;
      for (int m = 0; m < plan.thermal.sky_components; ++m)
        source(warm_sky + m) = bands.to_grid(product(emitted_sky[static_cast<std::size_t>(m)], thermal_up));
      source(surroundings) = product(planck[0], through, 1 / std::numbers::pi);
      for (int k = 0; k < plan.thermal.nodes(); ++k)
        source(plan.first_emission() + k) = product(planck[static_cast<std::size_t>(1 + k)], through);
    }
    for (int y = 0; y < plan.path_y.count; ++y)
      for (int x = 0; x < plan.path_x.count; ++x)
        plan.path_spectrum.push_back(bands.to_grid(
            path_source(air, at.domain, z, node_position(plan.path_x, x), node_position(plan.path_y, y))));
  }
}

void fill_report(Plan& plan, const Setting& at, const Light& light, const Levels& levels, const Chosen& chosen,
                 double map_error) {
  const NodeChoice& choice = chosen.nodes;
  const ThermalUse& thermal = light.thermal;
  const double total = choice.total();
  PlanReport& report = plan.report;
  report.budget = chosen.budget;
  report.table_nodes = at.covered_um.size();
  report.source_error = choice.source_error, report.path_error = choice.path_error;
  report.sky_error = choice.sky_error;
  report.total_error = total, report.within_tolerance = total <= at.simulation.tolerance;
  report.given = at.simulation.plan;
  report.sky_levels = reported(levels.sky);
  report.irradiance_map_error = map_error;
  report.mean_ground = mean_ground(plan.environment, at.simulation.scene);
  report.axes = reported(levels.errors);
  if (thermal.on)
    report.thermal = {reported(levels.thermal_sky),
                      light.emitters.distinct_K.size(),
                      levels.solar.sun,
                      levels.solar.sky,
                      !levels.skylight,
                      choice.emission_error,
                      choice.left_out};
  if (!thermal.on && thermal.share > 0) report.thermal_left_out = {thermal.share, thermal.band, thermal.from};
}

/// Tells of a sky whose radiances contradict the table's own flux.
void compare_with_flux_row(Plan& plan, const Setting& at, const SkyFactorizer& sky) {
  const double d = diffuse_row_difference(at.air, at.domain, at.bands, sky.sampled_irradiance());
  if (!(d >= 0 && plan.sky_components > 0)) return;
  plan.report.diffuse_irradiance_row_difference = d;
  if (d > kAnotherSky && at.air.knows_flux_of_sky())
    plan.notices.push_back(fmt::format(
        "the atmosphere table's sky_radiance_solar sums to another irradiance than its diffuse_irradiance, "
        "{:.3g} % off in the worst band: the sky takes its shape from the one and its brightness from the other; "
        "give the sky on a finer grid of directions, or mend the rows",
        100 * d));
}

}  // namespace

Plan make_plan(const scene::Simulation& simulation, const scene::Instrument& instrument,
               const atmos::RenderTable& table, const ViewBounds& view, int threads) {
  const base::Doing doing("planning instrument", instrument.name);
  check_given_levels(simulation);
  Domain domain = make_domain(simulation, table, view);
  const auto& table_um = table.axis("wavelength").nodes;
  scene::Instrument convolved = instrument;
  convolved.bands = channel_bands(instrument, table).bands;
  SpectralPlan spectral = make_spectral_plan(simulation.scene, convolved, table_um, table_name(simulation),
                                             lamp_nodes_um(simulation.lamps));
  Plan plan = begin_plan(simulation, domain);
  std::vector<std::string> unseen;
  plan.lamps = make_lamps(simulation.lamps, spectral, instrument.name, unseen);

  const std::size_t first = find_cell(table_um, spectral.wavelength_um.front()).index;
  const std::size_t last = std::min(find_cell(table_um, spectral.wavelength_um.back()).index + 1, table_um.size() - 1);
  const std::vector<double> covered(table_um.begin() + static_cast<std::ptrdiff_t>(first),
                                    table_um.begin() + static_cast<std::ptrdiff_t>(last) + 1);
  if (plan.lamps.sources() > 0) domain.lamplight = typical_lamplight(simulation.lamps, simulation.scene, covered);
  const scene::Adjacency adjacency = choose_adjacency(simulation, table);
  Spectrum ground;
  if (adjacency != scene::Adjacency::off)
    ground = plan_environment(plan, simulation, table, domain, adjacency == scene::Adjacency::local, covered, first,
                              threads);
  TableSpectra air(table, simulation.atmosphere.none, plan.sun_up, first, last - first + 1, ground);
  check_view(instrument, view, air.last_view_zenith_rad());
  const BandSpace bands(covered, spectral.wavelength_um, spectral.bands, spectral.mean_reflectance);
  const Setting setting{simulation, domain, air, bands, spectral, covered, first, kShare * simulation.tolerance,
                        threads};

  ThermalUse thermal = thermal_use(simulation, instrument, table, air, domain, bands, spectral, setting.share);
  if (!thermal.on) air.leave_out_emission();
  plan.notices = std::move(thermal.notices);
  plan.notices.insert(plan.notices.end(), unseen.begin(), unseen.end());
  const std::string without_paths = std::move(thermal.without_paths);
  const Light light(setting, std::move(thermal));
  const Levels levels = weigh_levels(plan, setting, light);
  const Chosen chosen = choose_within_budget(levels.errors, simulation);
  plan.refusal = refusal_of(chosen.nodes, simulation, instrument.name);

  const ChosenSkies skies = take_choice(plan, setting, light, levels, chosen.nodes);
  fill_spectra(plan, setting, skies);
  if (instrument.asks_for(scene::BandTruth::irradiance))
    fill_incident(plan, air, bands, {skies.solar, skies.thermal}, spectral, threads);
  if (!plan.environment.empty()) add_environment_spectra(plan, simulation, air, bands, covered, spectral.wavelength_um);
  double map_error = 0;
  if (plan.sky_components > 0)
    map_error = fit_map(plan, domain.sun_azimuth, levels.sky[static_cast<std::size_t>(plan.sky_components - 1)].mixture,
                        threads);
  plan.sky =
      make_sky_rays(plan.sky_basis, plan.thermal, domain.sun_azimuth, plan.sun_direction, simulation.sky_directions);
  plan.sky.paths_per_two = simulation.paths_per_two;

  fill_report(plan, setting, light, levels, chosen, map_error);
  compare_with_flux_row(plan, setting, light.sky);
  if (light.thermal.on)
    tell_of_missing_truth(plan, instrument, levels.errors.sun_sources > 0 ? 0 : levels.solar.sun,
                          levels.skylight ? 0 : levels.solar.sky);
  plan.wavelength_um = std::move(spectral.wavelength_um);
  plan.bands = std::move(spectral.bands);
  plan.report.bounces.open = !simulation.bounces_given && instrument.auto_bounces;
  const bool follows = simulation.bounces_given || instrument.auto_bounces || plan.matter.plates;
  plan_bounces(plan, simulation.scene, follows ? simulation.bounces : 0, simulation.sky_directions, setting.share);
  if (!plan.bounces.any() && !without_paths.empty()) plan.notices.push_back(without_paths);
  tell_of_matter(plan, instrument);
  return plan;
}

}  // namespace raycube::plan
