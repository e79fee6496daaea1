// What `chart` finds: settings with their time and error, of one instrument or LIDAR.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "host/run/services.h"
#include "host/knobs/knob.h"
#include "host/render/types.h"
#include "scene_compiler/simulation.h"

namespace raycube::run {

struct ChartOptions {
  std::uint64_t pixels = 512, pulses = 0;  ///< validated; pulses 0: by the LIDAR
  std::uint64_t timed_pixels = 4096;       ///< fewer where a pixel has many rays
  int repeats = 3, reference_grid = 31;
  std::vector<std::string> knobs;  ///< empty: all that apply
};

struct ChartPoint {
  std::string device, knob, label;  ///< knob "own": the file's own setting
  double level = 0;
  std::map<std::string, std::string> settings;  ///< of every knob that applies, as labels
  std::string refused;                          ///< why it has no plan; then nothing below is set
  double error = 0, error_low = 0, error_high = 0, rms = 0, p95 = 0;
  int worst_band = 0;  ///< from 1; 0: pulses
  double time_s = 0, time_low_s = 0, time_high_s = 0;
  double rays = 0, terms = 0;  ///< per pixel, or per pulse
  std::map<std::string, double> stage_s;
  bool front = false;
};

struct Chart {
  std::string name, kind;  ///< kind: cube, pulses
  std::string reference;   ///< one line: what the errors are against
  std::string what_time;   ///< one line: what the times are of
  double own_error = 0;    ///< of the reference
  double tolerance = 0;
  scene::ToleranceMeasure measure;    ///< what tolerance and errors are of
  std::uint64_t validated = 0;        ///< pixels or pulses
  std::vector<std::string> machines;  ///< devices and processor
  std::vector<ChartPoint> points;
};

/// Knobs of the subject that are asked for. Throws Error(input) when one does not exist, or when none that is named
/// applies.
std::vector<const knobs::Knob*> chosen_knobs(const knobs::Subject& subject, const std::vector<std::string>& names);

/// A camera whose knobs are turned; light between surfaces is asked for where the file has it or the knob is named.
knobs::Subject chart_subject(scene::Simulation& simulation, std::size_t instrument,
                             const std::vector<std::string>& knobs);

/// Calls visit with every setting: the own one, each knob's other levels one at a time, and samples with sky_directions
/// together where both are among the knobs (every second level of each). The subject is set while visit runs and as it
/// was afterwards.
void for_each_setting(const knobs::Subject& subject, const std::vector<const knobs::Knob*>& knobs,
                      const std::function<void(ChartPoint)>& visit);

/// On each of the devices; `given` says all else of where it runs.
Chart chart_cube(scene::Simulation& simulation, std::size_t instrument, const ChartOptions& options,
                 const std::vector<std::string>& devices, const render::RenderOptions& given, Services& services);
Chart chart_pulses(scene::Simulation& simulation, std::size_t lidar, const ChartOptions& options,
                   const std::vector<std::string>& devices, const render::RenderOptions& given, Services& services);

/// Marks the points of each device that no other of that device beats in time and error.
void mark_front(Chart& chart);

nlohmann::ordered_json chart_json(const Chart& chart);

}  // namespace raycube::run
