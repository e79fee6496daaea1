#include "host/cli/lidar_gff.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <ostream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/base/error.h"
#include "host/run/python_chart.h"
#include "host/lidar/overlap.h"
#include "host/lidar/shot.h"
#include "host/products/csv_writer.h"
#include "scene_compiler/load_simulation.h"
#include "host/cli/typed.h"

namespace raycube::cli {

namespace {

constexpr double kMilli = 1e-3;

struct GffRequest {
  std::string file, lidar, profile;
  double separation_m = kUnset, crossing_m = kUnset, aperture_m = kUnset, obscuration_m = kUnset, fov_mrad = kUnset,
         focus_m = kUnset;
  double exit_m = kUnset, divergence_mrad = kUnset, plume_m = kUnset, ground_m = kUnset, from_m = kUnset, to_m = kUnset;
  int points = 401;
};

/// Two straight lines in space, met as ranges along the receiver's axis.
struct Geometry {
  lidar::Stop stop{0.10, 0, 2e-4, 0};
  bool gaussian = true;
  double exit_m = 0.010, half_divergence_rad = 1e-4;
  lidar::Vec3 offset_m{1, 0, 0};    ///< exit minus pupil: x, y across the receiver's axis, z along it
  lidar::Vec3 slope{-0.002, 0, 1};  ///< of the beam, per metre along the receiver's axis
  double surface_low_m = kUnset, surface_high_m = kUnset;  ///< ranges between which surfaces lie
  std::vector<std::pair<std::string, double>> plumes;      ///< name, range

  double centre_m(double range_m, std::size_t axis) const {
    return offset_m[axis] + slope[axis] * (range_m - offset_m[2]);
  }
  double apart_m(double range_m) const { return std::hypot(centre_m(range_m, 0), centre_m(range_m, 1)); }
  double path_m(double range_m) const {
    return std::max(0.0, range_m - offset_m[2]) * std::hypot(slope[0], slope[1], 1.0);
  }
  double beam_m(double range_m, bool as_gaussian) const {
    const double grown = std::tan(half_divergence_rad) * path_m(range_m);
    return as_gaussian ? std::hypot(exit_m, grown) : exit_m + grown;
  }
};

double dot(const lidar::Vec3& a, const lidar::Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

const scene::Lidar& pick(const scene::Simulation& simulation, const std::string& name, const std::string& file) {
  if (simulation.lidars.empty())
    throw base::Error(base::Fault::input, file + ": has no [[lidar]]; give the geometry by options instead of a file");
  if (name.empty()) return simulation.lidars.front();
  const auto found = std::find_if(simulation.lidars.begin(), simulation.lidars.end(),
                                  [&](const scene::Lidar& l) { return l.name == name; });
  if (found == simulation.lidars.end())
    throw base::Error(base::Fault::input, file + ": has no [[lidar]] called \"" + name + "\"; its first is \"" +
                                              simulation.lidars.front().name + "\"");
  return *found;
}

/// First pulse of a file's LIDAR; what lies along its beam.
Geometry from_file(const scene::Simulation& simulation, const scene::Lidar& lidar) {
  const auto shots = lidar::make_shots(lidar, 0, lidar.pulses, simulation.seed);
  if (shots.empty()) throw base::Error(base::Fault::input, lidar.name + ": the scan fires no pulse");
  const lidar::Shot& shot = shots.front();
  Geometry g;
  const scene::LidarReceiver& receiver = lidar.receiver;
  g.stop = {receiver.aperture_radius_m, receiver.obscuration_radius_m, receiver.half_fov_rad, receiver.focus_m};
  // The whole array as the circle of its solid angle.
  if (receiver.half_fov_rad <= 0)
    g.stop.half_fov_rad = receiver.pixel_pitch_rad * std::sqrt(receiver.columns * receiver.rows / M_PI);
  g.gaussian = lidar.pulse.profile == scene::BeamProfile::gaussian;
  g.exit_m = lidar.pulse.exit_radius_m, g.half_divergence_rad = lidar.pulse.half_divergence_rad;
  const lidar::Vec3 v{shot.pupil_axis[1] * shot.pupil_u[2] - shot.pupil_axis[2] * shot.pupil_u[1],
                      shot.pupil_axis[2] * shot.pupil_u[0] - shot.pupil_axis[0] * shot.pupil_u[2],
                      shot.pupil_axis[0] * shot.pupil_u[1] - shot.pupil_axis[1] * shot.pupil_u[0]};
  lidar::Vec3 apart;
  for (std::size_t i = 0; i < 3; ++i) apart[i] = shot.exit_m[i] - shot.pupil_m[i];
  g.offset_m = {dot(apart, shot.pupil_u), dot(apart, v), dot(apart, shot.pupil_axis)};
  const double along = dot(shot.exit_axis, shot.pupil_axis);
  if (!(along > 1e-3))
    throw base::Error(base::Fault::input,
                      lidar.name + ": beam and receiver look more than 89.9 degrees apart; no range is common to them");
  g.slope = {dot(shot.exit_axis, shot.pupil_u) / along, dot(shot.exit_axis, v) / along, 1};
  if (shot.exit_axis[2] < 0 && simulation.scene.lo[2] <= simulation.scene.hi[2]) {
    const double per_height = along / -shot.exit_axis[2];
    g.surface_high_m = g.offset_m[2] + (shot.exit_m[2] - simulation.scene.hi[2]) * per_height;
    g.surface_low_m = g.offset_m[2] + (shot.exit_m[2] - simulation.scene.lo[2]) * per_height;
  }
  for (const scene::Volume& volume : simulation.scene.volumes) {
    if (volume.shape == scene::Volume::Shape::box) continue;  // fills the view as a rule
    lidar::Vec3 to;
    for (std::size_t i = 0; i < 3; ++i) to[i] = volume.position_m[i] - shot.pupil_m[i];
    to[2] += volume.shape == scene::Volume::Shape::plume ? volume.release_height_m : 0.5 * volume.size_m[2];
    if (dot(to, shot.pupil_axis) > 0)
      g.plumes.emplace_back(volume.name.empty() ? "plume" : volume.name, dot(to, shot.pupil_axis));
  }
  return g;
}

Geometry geometry_of(const GffRequest& o, std::string& title, Invocation& invocation) {
  Geometry g;
  title = "two telescopes side by side";
  if (!o.file.empty()) {
    scene::LoadOptions load;
    load.seed = invocation.common.seed;
    const scene::Simulation simulation = scene::load_simulation(o.file, load);
    const scene::Lidar& lidar = pick(simulation, o.lidar, o.file);
    title = lidar.name;
    g = from_file(simulation, lidar);
  } else {
    if (!o.lidar.empty())
      throw base::Error(base::Fault::input, "--lidar names one of a file's LIDARs; give the FILE too");
    g.plumes.emplace_back("plume", 500), g.surface_low_m = g.surface_high_m = 1000;
  }
  replace(g.stop.pupil_m, o.aperture_m, 0.5), replace(g.stop.obscuration_m, o.obscuration_m, 0.5);
  replace(g.stop.half_fov_rad, o.fov_mrad, 0.5 * kMilli), replace(g.stop.focus_m, o.focus_m);
  replace(g.exit_m, o.exit_m, 0.5), replace(g.half_divergence_rad, o.divergence_mrad, 0.5 * kMilli);
  if (!o.profile.empty()) g.gaussian = o.profile == "gaussian";
  if (!std::isnan(o.separation_m) || !std::isnan(o.crossing_m)) {
    double separation = g.apart_m(g.offset_m[2]), crossing = g.slope[0] != 0 ? -g.offset_m[0] / g.slope[0] : 0;
    replace(separation, o.separation_m), replace(crossing, o.crossing_m);
    g.offset_m = {separation, 0, 0}, g.slope = {crossing > 0 ? -separation / crossing : 0, 0, 1};
  }
  if (!std::isnan(o.plume_m)) g.plumes = {{"plume", o.plume_m}};
  replace(g.surface_low_m, o.ground_m), replace(g.surface_high_m, o.ground_m);
  if (g.stop.obscuration_m >= g.stop.pupil_m)
    throw base::Error(base::Fault::input, fmt::format("the obscuration ({} m) must be smaller than the aperture ({} m)",
                                                      2 * g.stop.obscuration_m, 2 * g.stop.pupil_m));
  return g;
}

struct Row {
  double range_m, apart_m, beam_m, field_m, uniform, gauss, exact;
};

Row row_at(const Geometry& g, double range_m) {
  const double apart = g.apart_m(range_m), field = g.stop.pupil_m + g.stop.half_fov_rad * range_m;
  return {range_m,
          apart,
          g.beam_m(range_m, g.gaussian),
          field,
          lidar::uniform_circle_overlap(g.beam_m(range_m, false), field, apart),
          lidar::gaussian_circle_overlap(g.beam_m(range_m, true), field, apart),
          lidar::beam_overlap(g.stop, g.gaussian, g.beam_m(range_m, g.gaussian), range_m, apart)};
}

int draw(const GffRequest& o, Invocation& invocation) {
  std::string title;
  const Geometry g = geometry_of(o, title, invocation);
  double furthest = std::isnan(g.surface_low_m) ? 0 : g.surface_low_m;
  for (const auto& plume : g.plumes) furthest = std::max(furthest, plume.second);
  double from = 0, to = furthest > 0 ? 1.2 * furthest : 1000;
  replace(from, o.from_m), replace(to, o.to_m);
  if (from >= to)
    throw base::Error(base::Fault::input, fmt::format("--from ({} m) must be below --to ({} m)", from, to));

  std::vector<Row> rows;
  for (int i = 0; i < o.points; ++i) rows.push_back(row_at(g, from + (to - from) * i / (o.points - 1)));
  const std::filesystem::path chart = invocation.common.output.empty() ? "gff.png" : invocation.common.output;
  const auto if_exists = invocation.common.overwrite ? base::IfExists::replace : base::IfExists::refuse;
  const std::string csv = std::filesystem::path(chart).replace_extension(".csv").string();
  if (csv == chart.string())
    throw base::Error(base::Fault::input, csv + ": a chart is a PNG; its table goes to the .csv beside it");
  base::OutputFile table(csv, if_exists);
  products::CsvWriter writer(table, {"range_m", "beam_to_axis_m", "beam_radius_m", "field_radius_m", "level1_uniform",
                                     "level1_gaussian", "level2", "level2_per_m2"});
  nlohmann::json figures = {{"title", title}, {"beam", g.gaussian ? "Gaussian beam, 1/e2 radius" : "uniform beam"}};
  const double low = g.surface_high_m, high = g.surface_low_m;
  if (!std::isnan(low)) figures["surface_m"] = {low, high};
  for (const auto& [name, range] : g.plumes)
    figures["plumes"].push_back({{"name", name}, {"range_m", range}, {"overlap", row_at(g, range).exact}});
  double best = -1, best_m = 0;
  for (const Row& r : rows) {
    const double per_m2 = r.range_m > 0 ? r.exact / (r.range_m * r.range_m) : 0;
    writer.add(r.range_m)
        .add(r.apart_m)
        .add(r.beam_m)
        .add(r.field_m)
        .add(r.uniform)
        .add(r.gauss)
        .add(r.exact)
        .add(per_m2)
        .end_row();
    figures["range_m"].push_back(r.range_m), figures["apart_m"].push_back(r.apart_m),
        figures["beam_m"].push_back(r.beam_m), figures["field_m"].push_back(r.field_m);
    figures["uniform"].push_back(r.uniform), figures["gauss"].push_back(r.gauss), figures["exact"].push_back(r.exact),
        figures["per_m2"].push_back(per_m2);
    if (per_m2 > best) best = per_m2, best_m = r.range_m;
  }
  figures["peak_m"] = best_m;
  writer.finish();
  table.sync();
  const std::string numbers = run::draw_chart("lidar_gff.py", figures.dump(), chart.string(), if_exists);
  table.publish();

  nlohmann::json result = {
      {"chart", chart.string()}, {"table", csv}, {"figures", numbers}, {"brightest_range_m", best_m}};
  if (invocation.common.json) {
    if (!std::isnan(high)) result["overlap_at_surface"] = row_at(g, high).exact;
    for (const auto& [name, range] : g.plumes) result["overlap_at_plume"][name] = row_at(g, range).exact;
    invocation.out << result.dump() << "\n";
    return 0;
  }
  invocation.out << fmt::format("brightest at {:.6g} m (overlap over range squared)\n", best_m);
  for (const auto& [name, range] : g.plumes)
    invocation.out << fmt::format("{} at {:.6g} m: overlap {:.4g}\n", name, range, row_at(g, range).exact);
  if (!std::isnan(high))
    invocation.out << fmt::format("lowest surface at {:.6g} m: overlap {:.4g}\n", high, row_at(g, high).exact);
  invocation.out << fmt::format("chart: {}\ntable: {}\n", chart.string(), csv);
  return 0;
}

}  // namespace

Verb verb_lidar_gff() {
  auto o = std::make_shared<GffRequest>();
  Verb verb("gff", "Draw the receiver's overlap with the beam against range (geometric form factor)");
  verb.description =
      "Level 2 is what a run computes for every hit: the share of the pupil whose rays through a point pass the field "
      "stop, averaged over the beam. Level 1, a hard "
      "circle against the beam, is drawn beside it to show how far off it is. Geometry: the first pulse of a FILE's "
      "LIDAR, or two telescopes side by side (without "
      "FILE: 1 m apart, crossing at 500 m, so that a plume there is seen and the ground at 1000 m is not); options "
      "replace what FILE says. Ranges count along the "
      "receiver's axis. Writes a PNG, a table (.csv) and the figures (.json) beside it.";
  verb.examples = {"raycube lidar gff -o gff.png", "raycube lidar gff scenes/lidar/pipeline_dial.toml -o gff.png",
                   "raycube lidar gff --separation 0.2 --crossing 0 --fov 1 --divergence 0.5 --to 2000 -o biaxial.png"};
  verb.common = kOutput | kSeed;
  verb.output_default = "gff.png";
  verb.add_options = [o](base::OptionTable& table) {
    const auto number = [&](const char* names, const char* unit, double low, double high, const char* help,
                            double& value, const char* standing) {
      table.number(names, unit, low, high, help, value).default_text = standing;
    };
    table.optional_argument("FILE", "A scene file with a [[lidar]]", o->file);
    table.text("--lidar", "NAME", "Which of FILE's LIDARs", o->lidar).default_text = "the first";
    number("--separation", "m", 0, 1e6, "Distance of the two axes at the telescopes", o->separation_m, "FILE's, or 1");
    number("--crossing", "m", 0, 1e9, "Range where the axes cross; 0: parallel", o->crossing_m, "FILE's, or 500");
    number("--aperture", "m", 1e-6, 100, "Diameter of the receiver's pupil", o->aperture_m, "FILE's, or 0.2");
    number("--obscuration", "m", 0, 100, "Diameter of its central obscuration", o->obscuration_m, "FILE's, or 0");
    number("--fov", "mrad", 0, 1000, "Field of view, full angle", o->fov_mrad, "FILE's, or 0.4");
    number("--focus", "m", 0, 1e9, "Distance in focus; 0: infinity", o->focus_m, "FILE's, or 0");
    number("--exit", "m", 0, 100, "Diameter of the beam at the exit, 1/e2 or edge", o->exit_m, "FILE's, or 0.02");
    number("--divergence", "mrad", 0, 1000, "Divergence, full angle at 1/e2 or of the edge", o->divergence_mrad,
           "FILE's, or 0.2");
    table.choice("--profile", {"gaussian", "uniform"}, "Profile of the beam", o->profile).default_text =
        "FILE's, or gaussian";
    number("--plume", "m", 0, 1e9, "Range of a plume, marked", o->plume_m, "FILE's plumes and grids, or 500");
    number("--ground", "m", 0, 1e9, "Range of the ground, marked", o->ground_m, "FILE's surfaces, or 1000");
    number("--from", "m", 0, 1e9, "First range", o->from_m, "0");
    number("--to", "m", 1e-3, 1e9, "Last range", o->to_m, "1.2 of the furthest mark");
    table.integer("--points", "", 2, 100000, "Ranges drawn", o->points);
  };
  verb.run = [o](Invocation& invocation) { return draw(*o, invocation); };
  return verb;
}

}  // namespace raycube::cli
