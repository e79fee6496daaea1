#include "host/run/chart_point.h"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "host/base/error.h"
#include "host/study/pareto.h"

namespace raycube::run {

std::vector<const knobs::Knob*> chosen_knobs(const knobs::Subject& subject, const std::vector<std::string>& names) {
  std::vector<const knobs::Knob*> out;
  std::string possible;
  for (const std::string& name : names) knobs::find_knob(name);
  for (const knobs::Knob& knob : knobs::all_knobs()) {
    if (!knob.applies(subject)) continue;
    possible += (possible.empty() ? "" : ", ") + knob.name;
    if (names.empty() || std::find(names.begin(), names.end(), knob.name) != names.end()) out.push_back(&knob);
  }
  if (out.empty())
    throw base::Error(base::Fault::input, "none of the knobs that are named changes anything of '" +
                                              (subject.instrument ? subject.instrument->name : subject.lidar->name) +
                                              "'; there are: " + possible);
  return out;
}

knobs::Subject chart_subject(scene::Simulation& simulation, std::size_t instrument,
                             const std::vector<std::string>& knobs) {
  const bool named = std::find(knobs.begin(), knobs.end(), "bounces") != knobs.end();
  return {simulation, &simulation.instruments[instrument], nullptr, named || simulation.bounces > 0};
}

void for_each_setting(const knobs::Subject& subject, const std::vector<const knobs::Knob*>& chosen,
                      const std::function<void(ChartPoint)>& visit) {
  knobs::Settings keep(subject);
  const auto give = [&](const std::string& knob, const std::string& label, double level) {
    ChartPoint point;
    point.knob = knob, point.label = label, point.level = level;
    for (const knobs::Knob& one : knobs::all_knobs())
      if (one.applies(subject)) point.settings[one.name] = one.label(one.get(subject));
    visit(std::move(point));
    keep.restore();
  };
  give("own", "own", 0);
  const knobs::Knob *samples = nullptr, *sky = nullptr;
  for (const knobs::Knob* knob : chosen) {
    for (const double level : knob->levels(subject)) {
      knob->set(subject, level);
      give(knob->name, knob->label(level), level);
    }
    if (knob->name == "samples") samples = knob;
    if (knob->name == "sky_directions") sky = knob;
  }
  if (!samples || !sky) return;
  const std::vector<double> n = samples->levels(subject), d = sky->levels(subject);
  for (std::size_t i = 0; i < n.size(); i += 2)
    for (std::size_t k = 0; k < d.size(); k += 2) {
      samples->set(subject, n[i]);
      sky->set(subject, d[k]);
      give("samples and sky_directions", samples->label(n[i]) + ", " + sky->label(d[k]), n[i]);
    }
}

void mark_front(Chart& chart) {
  for (const std::string& device : chart.machines) {
    std::vector<std::size_t> index;
    std::vector<study::Cost> costs;
    for (std::size_t i = 0; i < chart.points.size(); ++i)
      if (chart.points[i].device == device && chart.points[i].refused.empty())
        index.push_back(i), costs.push_back({chart.points[i].time_s, chart.points[i].error});
    for (const std::size_t f : study::pareto_front(costs)) chart.points[index[f]].front = true;
  }
}

nlohmann::ordered_json chart_json(const Chart& chart) {
  using Json = nlohmann::ordered_json;
  Json points = Json::array();
  for (const ChartPoint& p : chart.points) {
    Json point = {
        {"device", p.device}, {"knob", p.knob}, {"label", p.label}, {"level", p.level}, {"settings", p.settings}};
    if (!p.refused.empty()) {
      point["refused"] = p.refused;
    } else {
      point.update({{"error", p.error},
                    {"error_low", p.error_low},
                    {"error_high", p.error_high},
                    {"rms", p.rms},
                    {"p95", p.p95},
                    {"worst_band", p.worst_band},
                    {"time_s", p.time_s},
                    {"time_low_s", p.time_low_s},
                    {"time_high_s", p.time_high_s},
                    {"rays", p.rays},
                    {"terms", p.terms},
                    {"stage_s", p.stage_s},
                    {"front", p.front}});
    }
    points.push_back(std::move(point));
  }
  return Json{{"name", chart.name},
              {"kind", chart.kind},
              {"tolerance", chart.tolerance},
              {"tolerance_of", figure_name(chart.measure.figure)},
              {"tolerance_materials", chart.measure.materials},
              {"reference", chart.reference},
              {"reference_error", chart.own_error},
              {"validated", chart.validated},
              {"time_of", chart.what_time},
              {"machines", chart.machines},
              {"points", points}};
}

}  // namespace raycube::run
