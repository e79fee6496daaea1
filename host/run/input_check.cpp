#include "host/run/input_check.h"

#include <map>
#include <set>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "atmos_tables/clear_sky_inputs.h"
#include "host/base/doing.h"
#include "host/base/error.h"
#include "host/base/units.h"
#include "host/run/air_table.h"
#include "host/run/lidar_background.h"
#include "host/run/camera_job.h"
#include "host/run/lidar_job.h"
#include "host/run/light_budget.h"
#include "host/run/measure.h"
#include "host/lidar/air_column.h"
#include "host/lidar/make_lidar_plan.h"
#include "host/plan/adjacency.h"
#include "host/plan/channel_bands.h"
#include "host/plan/curve.h"
#include "host/plan/given_levels.h"
#include "host/plan/one_direction.h"
#include "host/plan/spectral_plan.h"
#include "host/plan/table_spectra.h"
#include "host/plan/thermal_plan.h"
#include "host/plan/thermal_use.h"
#include "host/planner/planner.h"
#include "host/sensors/cells.h"
#include "host/sensors/detector.h"
#include "host/sensors/psf.h"
#include "host/sensors/view_bounds.h"
#include "scene_compiler/matter.h"

namespace raycube::run {
namespace {

/// Every line once, in the order found: instruments share materials and air.
class Found {
 public:
  void add(const std::string& line) {
    if (seen_.insert(line).second) lines_.push_back(line);
  }
  void add(const base::Problems& problems) {
    for (const auto& line : problems.lines()) add(line);
  }
  /// Runs a part of the check; what it refuses of the input is added. False when it did.
  template <class Part>
  bool part(const Part& run) {
    try {
      run();
      return true;
    } catch (const base::Error& error) {
      if (error.fault() != base::Fault::input) throw;
      add(error.what());
      return false;
    }
  }
  void notice(const scene::Instrument& instrument, const std::vector<std::string>& texts) {
    for (const auto& text : texts) notices_.push_back(instrument.name + ": " + text);
  }
  void notice(const std::string& text) { notices_.push_back(text); }
  void throw_if_any() const {
    if (lines_.empty()) return;
    std::string text;
    for (const auto& line : lines_) text += (text.empty() ? "" : "\n") + line;
    throw base::Error(base::Fault::input, text);
  }
  const std::vector<std::string>& lines() const { return lines_; }
  const std::vector<std::string>& notices() const { return notices_; }

 private:
  std::set<std::string> seen_;
  std::vector<std::string> lines_;
  std::vector<std::string> notices_;
};

/// The table's own limits, where there is a table without computing one.
void check_known_table(const scene::Simulation& simulation, const scene::Instrument& instrument,
                       const plan::ViewBounds& view, const atmos::RenderTable& table, double bands_to_um,
                       Found& found) {
  const auto& table_um = table.axis("wavelength").nodes;
  base::Problems problems;
  scene::Instrument convolved = instrument;
  auto channels = plan::channel_bands(instrument, table);
  convolved.bands = std::move(channels.bands);
  plan::check_table(convolved, table_um, plan::table_name(simulation), problems);
  found.add(problems);
  found.part([&] { static_cast<void>(plan::choose_adjacency(simulation, table)); });
  const plan::TableSpectra air(table, simulation.atmosphere.none, simulation.sun.zenith_deg < 90, 0, table_um.size());
  found.part([&] { plan::check_view(instrument, view, air.last_view_zenith_rad()); });
  const auto heights = seen_heights(simulation.scene, view);
  found.part([&] { found.notice(instrument, plan::one_direction_notices(table, instrument.name, view, heights)); });
  found.notice(instrument, channels.notices);
  base::Problems cold;
  plan::check_thermal_matter(
      simulation.scene, simulation.file,
      plan::temperature_demand(simulation.atmosphere.none, bands_to_um, air.thermal(), table_um.back()), cold);
  found.add(cold);
}

/// What a built-in model's table will hold, where it has yet to be computed: the rows of light between ground and air,
/// which the layered model alone has, and views down to the last of its zenith angles.
void check_model(const scene::Simulation& simulation, const scene::Instrument& instrument, const plan::ViewBounds& view,
                 double bands_to_um, Found& found) {
  const scene::AtmosphereSpec& spec = simulation.atmosphere;
  found.part([&] { static_cast<void>(plan::choose_adjacency(simulation, spec.layered.has_value())); });
  found.part([&] { plan::check_view(instrument, view, base::rad_from_deg(atmos::last_view_zenith_deg(spec))); });
  base::Problems cold;
  plan::check_thermal_matter(simulation.scene, simulation.file,
                             plan::temperature_demand(false, bands_to_um, spec.layered.has_value(), bands_to_um), cold);
  found.add(cold);
}

/// Files of the materials' curves, as the simulation file names them.
std::map<std::string, std::string> curve_files(const scene::Simulation& simulation) {
  std::map<std::string, std::string> files;
  const auto resolved = nlohmann::json::parse(simulation.resolved_json);
  if (!resolved.contains("material")) return files;
  for (const auto& material : resolved["material"])
    for (const char* key : {"file", "family"})
      if (material.contains("name") && material.contains(key))
        files[material["name"].get<std::string>()] = material[key].get<std::string>();
  return files;
}

void check_instrument(const scene::Simulation& simulation, const scene::Instrument& instrument,
                      const std::map<std::string, std::string>& files, Found& found) {
  base::Problems problems;
  plan::check_bands(instrument, problems);
  const bool bands = problems.empty();
  if (bands) plan::check_curves(simulation.scene, instrument, problems, files);
  found.add(problems);
  found.part([&] { static_cast<void>(sensors::SampleWeights(instrument)); });
  if (bands) found.part([&] { sensors::check_cells(instrument); });
  // The detector's tables, which measure the radiance once it is there. Elements are left out: a framing camera's are
  // made as they are read.
  if (instrument.detector && bands)
    found.part([&] {
      scene::Instrument framing = instrument;
      framing.kind = scene::InstrumentKind::framing;
      static_cast<void>(sensors::Detector(framing, 0, std::vector<double>(instrument.bands.size(), 1.0)));
    });
  plan::ViewBounds view;
  if (!found.part([&] { view = sensors::view_bounds(instrument); }) || !bands) return;
  const AirRequest request = air_request(simulation, instrument, view.sensor_height_m);
  found.part([&] {
    if (const auto notice = coarse_sun_notice(simulation.atmosphere, instrument.bands))
      found.notice(instrument, {*notice});
    if (const auto table = known_table(request))
      check_known_table(simulation, instrument, view, *table, request.last_um, found);
    else
      check_model(simulation, instrument, view, request.last_um, found);
  });
}

/// Of the background light what the passive renderer refuses, in some shots of the survey.
void check_background(const scene::Simulation& simulation, const lidar::LidarPlan& plan,
                      const std::map<std::string, std::string>& files, Found& found) {
  const scene::Lidar& lidar = plan.lidar;
  constexpr std::int64_t kShots = 64;
  std::vector<lidar::Shot> shots;
  const std::int64_t step = std::max<std::int64_t>(1, (lidar.pulses - 1) / kShots);
  for (std::int64_t pulse = 0; pulse < lidar.pulses; pulse += step)
    for (lidar::Shot& shot : lidar::make_shots(lidar, pulse, 1, simulation.seed)) shots.push_back(std::move(shot));
  if (shots.empty()) return;
  Found light;
  check_instrument(simulation, background_camera(plan, shots), files, light);
  for (const auto& line : light.lines())
    found.add("LIDAR '" + lidar.name + "': the light of the scene in its field of view: " + line +
              "; or set solar_background = false in [lidar.detector]");
}

void check_lidar(const scene::Simulation& simulation, const scene::Lidar& lidar,
                 const std::map<std::string, std::string>& files, bool background, Found& found) {
  std::unique_ptr<atmos::RenderTable> air;
  bool sound = found.part([&] { air = lidar_air(simulation, lidar); });
  const auto wavelengths = lidar::table_wavelengths(lidar::make_nodes(lidar));
  for (const auto index : scene::used_families(simulation.scene)) {
    scene::Material material = simulation.scene.materials[index];
    if (const auto file = files.find(material.name); file != files.end()) material.source = file->second;
    const auto covers = [&](const scene::Curve& curve) {
      sound &= found.part([&] {
        try {
          plan::sample_curve(material, curve, wavelengths);
        } catch (const base::Error& error) {
          throw base::Error(error.fault(),
                            "LIDAR '" + lidar.name + "': " + error.what() + "; or use another wavelength");
        }
      });
    };
    covers(material.reflectance);
    if (material.transmittance.wavelength_um.empty()) continue;
    material.source += material.source.empty() ? "transmittance" : ", transmittance";
    covers(material.transmittance);
  }
  lidar::LidarPlan plan;
  sound = sound && found.part([&] { plan = lidar::make_lidar_plan(simulation, lidar, air.get()); });
  if (sound && background && has_background(simulation, lidar)) check_background(simulation, plan, files, found);
}

/// The light of these bands of an instrument needs the materials' curves, whoever looks.
void check_lit_curves(const scene::Simulation& simulation, const std::string& instrument,
                      const std::vector<scene::Band>& bands, const std::map<std::string, std::string>& files,
                      Found& found) {
  scene::Instrument lit;
  lit.name = instrument, lit.bands = bands;
  base::Problems problems;
  plan::check_bands(lit, problems);
  if (problems.empty()) plan::check_curves(simulation.scene, lit, problems, files);
  found.add(problems);
}

void check_reflectance_factors(const scene::Simulation& simulation, const scene::Measure& measure,
                               const std::map<std::string, std::string>& files, Found& found) {
  if (found.part([&] { check_measure(simulation, measure); }))
    check_lit_curves(simulation, measure.bands_of, bands_of(simulation, measure.bands_of), files, found);
}

void check_light_budget(const scene::Simulation& simulation, const scene::LightBudget& budget,
                        const std::map<std::string, std::string>& files, Found& found) {
  if (found.part([&] { check_budget(simulation, budget); }))
    check_lit_curves(simulation, budget.bands_of, budget_bands(simulation, budget), files, found);
}

/// Where the built-in air says less and less: plane-parallel, and without twilight.
void check_low_sun(const scene::Simulation& simulation, Found& found) {
  constexpr double kLow_deg = 86, kHorizon_deg = 90, kTwilight_deg = 96;
  const auto& air = simulation.atmosphere;
  const double zenith_deg = simulation.sun.zenith_deg;
  if (air.none || !air.table_file.empty() || zenith_deg < kLow_deg || zenith_deg >= kTwilight_deg) return;
  if (zenith_deg >= kHorizon_deg)
    found.notice(
        fmt::format("the sun stands {:.3g} deg below the horizon: the built-in air has no twilight, and no light "
                    "of the sun",
                    zenith_deg - kHorizon_deg));
  else if (!air.layered)
    found.notice(
        fmt::format("the sun stands {:.3g} deg above the horizon: the sky of clear_sky is too dark below 4 deg (17 "
                    "times at 0.1 deg, where 'layered' has 1.9 W m-2 sr-1 um-1); use model = \"layered\"",
                    kHorizon_deg - zenith_deg));
}

}  // namespace

std::vector<std::string> check_inputs(const scene::Simulation& simulation, const Asked& asked) {
  const base::Doing doing("checking inputs");
  Found found;
  const auto files = curve_files(simulation);
  if (!asked.instruments.empty()) found.part([&] { plan::check_given_levels(simulation); });
  for (const auto* instrument : asked.instruments) check_instrument(simulation, *instrument, files, found);
  for (const auto* lidar : asked.lidars) check_lidar(simulation, *lidar, files, asked.background, found);
  for (const auto* measure : asked.measures) check_reflectance_factors(simulation, *measure, files, found);
  for (const auto* budget : asked.budgets) check_light_budget(simulation, *budget, files, found);
  if (!asked.instruments.empty()) check_low_sun(simulation, found);
  found.throw_if_any();
  return found.notices();
}

namespace {

/// Tolerances below this are where channels may not suffice in ordinary scenes: 2e-4 and 7e-4 are the skies' own errors
/// over level ground.
constexpr double kTight = 1e-3;

/// What planning refuses: nodes that no plan can have, a tolerance that their channels do not hold. Where the table is
/// known this needs no ray and no solver of the air; a render plans in any case, and asks later.
void check_plan(const scene::Simulation& simulation, const scene::Instrument& given, Found& found) {
  found.part([&] {
    const auto cells = sensors::make_cells(given, 0);
    const scene::Instrument& instrument = cells ? cells->rendered : given;
    const plan::ViewBounds view = sensors::view_bounds(instrument);
    const auto table = quick_table(air_request(simulation, instrument, view.sensor_height_m));
    if (!table) {
      if (simulation.tolerance < kTight)
        found.notice(instrument, {fmt::format("whether {} channels hold the tolerance of {:g} is known once its air is "
                                              "computed: `raycube plan` does, and refuses it where they do not",
                                              RC_MAX_CHANNELS, simulation.tolerance)});
      return;
    }
    const plan::Plan plan = plan::make_plan(simulation, instrument, *table, view, 0);
    planner::Decision decision = planner::as_given(simulation, instrument, plan);
    planner::hold_tolerance(decision, simulation, instrument, plan, *table, 0);
  });
}

}  // namespace

std::vector<std::string> check_inputs(const scene::Simulation& simulation) {
  Asked all;
  all.background = true;
  for (const auto& instrument : simulation.instruments) all.instruments.push_back(&instrument);
  for (const auto& lidar : simulation.lidars) all.lidars.push_back(&lidar);
  for (const auto& measure : simulation.measures) all.measures.push_back(&measure);
  for (const auto& budget : simulation.budgets) all.budgets.push_back(&budget);
  std::vector<std::string> notices = check_inputs(simulation, all);
  Found found;
  for (const auto* instrument : all.instruments) check_plan(simulation, *instrument, found);
  found.throw_if_any();
  notices.insert(notices.end(), found.notices().begin(), found.notices().end());
  return notices;
}

}  // namespace raycube::run
