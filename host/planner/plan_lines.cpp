#include "host/planner/plan_lines.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/base/text.h"
#include "host/planner/sample_pattern.h"

namespace raycube::planner {

namespace {

using Json = nlohmann::json;

/// A number, or null below 0: not estimated.
Json number(double value) { return value < 0 ? Json() : Json(value); }

/// Rays of a pixel, in the mean.
std::string rays_text(double rays) {
  const std::string number = fmt::format("{:.0f}", rays);
  return number + (number == "1" ? " ray a pixel" : " rays a pixel");
}

/// An axis of `count` nodes: its error, the sum of these lists, and that of the next fewer.
PlanLine axis_line(const plan::AxisErrors& axes, const std::string& block, int count, bool given,
                   const std::vector<const std::vector<double>*>& errors, const std::string& cost) {
  PlanLine line;
  line.block = block;
  line.level = base::counted(static_cast<std::size_t>(count), "node");
  line.cost = cost;
  line.why = "linear between nodes; midpoints inside their share of the tolerance";
  line.given = given;
  for (std::size_t i = 0; i < axes.counts.size(); ++i) {
    if (axes.counts[i] != count) continue;
    line.error = 0;
    for (const auto* list : errors) line.error += (*list)[i];
    if (i == 0) continue;
    line.next_error = 0;
    for (const auto* list : errors) line.next_error += (*list)[i - 1];
  }
  // An axis of no extent has one node whatever is asked for.
  if (count == 1 && line.error == 0) line.why = "no extent";
  return line;
}

PlanLine sky_line(const std::vector<plan::SkyLevelReport>& levels, const std::string& block, int components,
                  int channels) {
  PlanLine line{block,
                components == 0 ? "off" : base::counted(static_cast<std::size_t>(components), "component"),
                0,
                -1,
                base::counted(static_cast<std::size_t>(components), "source"),
                "",
                false};
  for (const auto& level : levels) {
    if (!std::isfinite(level.error)) continue;
    if (level.components == components) line.error = level.error;
    if (level.components == components - 1) line.next_error = level.error;
  }
  line.why = components == 0 ? "no light of the sky, or too dark to be seen"
                             : fmt::format("worst obstacle beside typical surfaces; {} in all",
                                           base::counted(static_cast<std::size_t>(channels), "channel"));
  return line;
}

/// What small objects get, or would need.
PlanLine small_objects_line(const sensors::SmallObjectSurvey& survey) {
  PlanLine line;
  line.block = "small objects";
  line.level = survey.on ? base::counted(survey.scarce, "object") : "off";
  line.cost = "none";
  if (survey.on && !survey.levels.empty())
    line.cost = fmt::format("{} rays in {}, {} at most in one", base::about_count(survey.more_samples),
                            base::counted(survey.pixels, "pixel"), survey.levels.rbegin()->first);
  line.why = survey.on ? "known from their boxes: an rms over pixels does not see them"
                       : fmt::format("{} of {} have too few samples on them", survey.missed.size(),
                                     base::counted(survey.objects, "object"));
  return line;
}

Json small_objects_json(const sensors::SmallObjectSurvey& survey) {
  constexpr std::size_t most_named = 100;
  Json out = {{"on", survey.on},
              {"objects", survey.objects},
              {"need_more_samples", survey.scarce},
              {"pixels", survey.pixels},
              {"samples", survey.more_samples}};
  for (const auto& [samples, pixels] : survey.levels)
    out["levels"].push_back({{"samples_per_pixel", samples}, {"pixels", pixels}});
  out["missed"] = survey.missed.size();
  for (std::size_t i = 0; i < std::min(most_named, survey.missed.size()); ++i) {
    const auto& o = survey.missed[i];
    out["missed_objects"].push_back({{"name", o.name},
                                     {"size_m", o.size_m},
                                     {"share_of_a_pixel", o.share},
                                     {"samples_on_it", o.points},
                                     {"pixels", o.pixels},
                                     {"line", o.line},
                                     {"sample", o.sample}});
  }
  if (!survey.textures.empty()) out["as_texture"] = survey.textures;
  return out;
}

}  // namespace

std::string missed_objects_text(const sensors::SmallObjectSurvey& survey, const scene::Instrument& instrument) {
  constexpr std::size_t named = 3;
  std::string list;
  for (std::size_t i = 0; i < std::min(named, survey.missed.size()); ++i) {
    const auto& o = survey.missed[i];
    list += fmt::format(
        "{}'{}' ({:.2g} x {:.2g} x {:.2g} m, {:.2g} of a pixel's area, {:.2g} samples on it; {} from line "
        "{}, sample {})",
        i ? ", " : "", o.name, o.size_m[0], o.size_m[1], o.size_m[2], o.share, o.points,
        base::counted(o.pixels, "pixel"), o.line, o.sample);
  }
  if (survey.missed.size() > named) list += ", ...";
  const std::string way_out =
      survey.on ? "they are smaller than the finest samples tell: use smaller pixels, or larger objects"
                : "small_objects = \"on\" gives their pixels the samples they need, and so does a file "
                  "without `samples`";
  return fmt::format(
      "{}: {} of {} smaller than {} pixels may be missed, or have an abundance wrong by more than 20 %, with "
      "fewer than {} of the samples on each: {}; {}",
      instrument.name, survey.missed.size(), base::counted(survey.objects, "object"), sensors::kWidest_px,
      sensors::kFewestPoints, list, way_out);
}

std::string percent_text(double error) {
  if (error < 0) return "-";
  return error == 0 ? "0 %" : fmt::format("{:.2g} %", 100 * error);
}

std::string sampling_text(const Sampling& s) {
  const std::string each = sampler_text(s.sampler, s.samples_u, s.samples_v);
  return s.replicates > 1 ? fmt::format("{} x {}", s.replicates, each) : each;
}

namespace {

/// Of samples and sky directions together.
double drawn_error(const Decision& d) {
  return d.total_error < 0 ? -1 : std::sqrt(std::max(0.0, d.total_error * d.total_error - d.plan_error * d.plan_error));
}

/// How the error of what was tried is known.
std::string tried_text(const Decision& d) {
  return d.sampling.replicates > 1
             ? fmt::format("spread of {} replicates of all pixels, sky included", d.sampling.replicates)
             : "trial of " + base::counted(static_cast<std::size_t>(d.trial_pixels), "pixel");
}

/// What the planner settles: samples of a pixel, directions of the sky.
void add_sampling_lines(std::vector<PlanLine>& lines, const Decision& d, const plan::Plan& plan) {
  PlanLine samples;
  samples.block = "samples";
  samples.level = sampling_text(d.sampling);
  samples.error = d.samples_error, samples.next_error = d.samples_less_error, samples.given = d.samples_given;
  if (d.sampling.replicates > 1) samples.error = drawn_error(d);
  samples.cost = rays_text(d.counts.samples);
  samples.why = d.samples_given
                    ? d.estimated ? "the file gives them" : "the file gives them; `raycube plan` estimates their error"
                : d.estimated ? tried_text(d)
                              : "the default: nothing could be tried";
  lines.push_back(samples);
  PlanLine adaptive;
  adaptive.block = "adaptive";
  adaptive.given = d.sampling.first_samples > 0;
  adaptive.level = adaptive.given ? fmt::format("first {}", d.sampling.first_samples) : "off";
  adaptive.cost =
      adaptive.given ? fmt::format("{} rays a pixel, then all where needed", d.sampling.first_samples) : "none";
  adaptive.why =
      adaptive.given ? "the file gives it; the samples' error above is without it" : "samples.first asks for it";
  lines.push_back(adaptive);
  if (d.small.objects > 0) lines.push_back(small_objects_line(d.small));
  PlanLine sky;
  sky.block = "sky directions";
  sky.level = !plan.sends_rays()          ? "none"
              : d.sampling.replicates > 1 ? fmt::format("{} x {}", d.sampling.replicates, d.sampling.directions)
                                          : std::to_string(d.sampling.directions);
  sky.error = d.sky_error, sky.next_error = d.sky_less_error, sky.given = d.directions_given;
  sky.cost = rays_text(d.counts.sky_rays);
  sky.why = !plan.sends_rays() ? "nothing comes from the sky"
            : d.directions_given
                ? d.estimated ? "the file gives them" : "the file gives them; `raycube plan` estimates their error"
            : d.estimated ? tried_text(d)
                          : "the default: nothing could be tried";
  lines.push_back(sky);
}

/// ", most of all in what 'nylon' gets": of the material whose light the wavelengths along paths tell worst; nothing
/// where that is what a gloss mirrors.
std::string worst_told(const plan::Bounces& b) {
  const auto less = [](const auto& one, const auto& other) { return one.second < other.second; };
  const auto worst = std::max_element(b.material_error.begin(), b.material_error.end(), less);
  return b.material_error.size() < 2 || worst->second < b.error
             ? ""
             : fmt::format(", most of all in what '{}' gets", worst->first);
}

PlanLine bounces_line(const plan::Plan& plan) {
  const plan::Bounces& b = plan.bounces;
  const auto& [open, chosen, missed, once_missed] = plan.report.bounces;
  std::string why = "the file asks for them; the error is the wavelengths', where surfaces see nothing but each other" +
                    worst_told(b);
  if (open) why = "whether there is enough of it a look on a device says";
  if (chosen)
    why = b.any() ? fmt::format(
                        "without it so much {}; paths end by chance; the wavelengths err by {} where surfaces see "
                        "nothing but each other{}",
                        plan.thermal.on ? "is missed, or may be" : "may be missed, from above", percent_text(b.error),
                        worst_told(b))
                  : "light scattered once is that near, after a look at what surfaces see of each other";
  return {"between surfaces",
          b.any() ? fmt::format("{}{} more", chosen ? "up to " : "",
                                base::counted(static_cast<std::size_t>(b.levels), "surface"))
                  : "none",
          chosen ? missed : b.error,
          chosen && b.any() ? once_missed : -1,
          b.any() ? fmt::format("{} paths a pixel, {}", plan.paths(), base::counted(b.skeleton.size(), "wavelength"))
                  : "none",
          why,
          !chosen && !open};
}

}  // namespace

std::string drawn_text(const Decision& d) {
  if (d.sampling.replicates > 1) return "samples and sky directions " + percent_text(drawn_error(d));
  return fmt::format("samples {}, sky directions {}", percent_text(d.samples_error), percent_text(d.sky_error));
}

std::vector<PlanLine> plan_lines(const Decision& d, const plan::Plan& plan) {
  const plan::PlanReport& report = plan.report;
  std::vector<PlanLine> lines;
  lines.push_back({"spectral grid", base::counted(plan.wavelength_um.size(), "wavelength"), 0, -1, "none after baking",
                   "nodes of air and materials and their midpoints: exact for both linear in between", false});
  if (report.thermal) {
    const double sun_share = report.thermal->sun_share;
    lines.push_back({"sun", plan.sun_sources > 0 ? "on" : "left out", plan.sun_sources > 0 ? 0 : sun_share,
                     plan.sun_sources > 0 ? sun_share : -1, rays_text(d.counts.sun_rays),
                     "its largest share of any band beside thermal light", false});
  } else {
    lines.push_back({"sun", plan.sun_up ? "on" : "below the horizon", 0, -1, rays_text(d.counts.sun_rays), "", false});
  }
  lines.push_back(sky_line(report.sky_levels, "sky", plan.sky_components, plan.source_channels()));
  lines.back().given = report.given.sky_rank > 0;
  if (report.thermal) {
    lines.push_back(
        sky_line(report.thermal->sky_levels, "thermal sky", plan.thermal.sky_components, plan.source_channels()));
    lines.push_back({"temperatures", base::counted(static_cast<std::size_t>(plan.thermal.nodes()), "node"),
                     report.thermal->temperature_nodes_error, -1,
                     base::counted(static_cast<std::size_t>(plan.thermal.nodes()), "source"),
                     fmt::format("{} distinct temperatures in the scene", report.thermal->temperatures), false});
  }
  if (plan.lamps.sources() > 0)
    lines.push_back({"lamps",
                     fmt::format("{}, {}", base::counted(plan.lamps.lamp.size(), "lamp"),
                                 base::counted(static_cast<std::size_t>(plan.lamps.sources()), "source")),
                     0, -1, rays_text(d.counts.lamp_rays), "a source for each spectrum", false});
  const plan::AxisErrors& axes = report.axes;
  const scene::PlanOverrides& given = report.given;
  const std::string sources =
                        base::counted(static_cast<std::size_t>(plan.source_channels()), "channel") + " of sources",
                    path = base::counted(static_cast<std::size_t>(plan.path_channels()), "channel") + " of path";
  lines.push_back(axis_line(axes, "target height", plan.height.count, given.height_nodes > 0,
                            {&axes.source_height, &axes.path_height}, sources));
  lines.push_back(axis_line(axes, "view zenith", plan.view.count, given.view_nodes > 0, {&axes.source_view}, sources));
  lines.push_back(axis_line(axes, "path, east", plan.path_x.count, given.path_nodes > 0, {&axes.path_x}, path));
  lines.push_back(axis_line(axes, "path, north", plan.path_y.count, given.path_nodes > 0, {&axes.path_y}, path));
  const std::string ground = plan::ground_mode(plan);
  lines.push_back({"ground around", ground, -1, -1,
                   plan.environment.empty() ? "none" : "4 rows of the band table a pixel",
                   ground == "off"    ? "no air between, or no rows for it in the table"
                   : ground == "mean" ? "the scene's mean ground, as the file asks"
                                      : "local environment of each pixel",
                   false});
  add_sampling_lines(lines, d, plan);
  if (plan.bounces.any() || report.bounces.chosen) lines.push_back(bounces_line(plan));
  return lines;
}

nlohmann::json lines_json(const std::vector<PlanLine>& lines) {
  Json list = Json::array();
  for (const auto& line : lines)
    list.push_back({{"block", line.block},
                    {"level", line.level},
                    {"error", number(line.error)},
                    {"error_without", number(line.next_error)},
                    {"cost", line.cost},
                    {"why", line.why},
                    {"given", line.given}});
  return list;
}

nlohmann::json decision_json(const Decision& d, const std::vector<PlanLine>& lines) {
  Json out = {{"tolerance", d.tolerance},
              {"tolerance_of", figure_name(d.measure.figure)},
              {"tolerance_materials", d.measure.materials},
              {"samples", {d.sampling.samples_u, d.sampling.samples_v}},
              {"sampler", static_cast<int>(d.sampling.sampler)},
              {"sky_directions", d.sampling.directions},
              {"replicates", d.sampling.replicates},
              {"error",
               {{"plan", d.plan_error},
                {"plan_estimate", d.plan_estimate},
                {"samples", number(d.samples_error)},
                {"sky_directions", number(d.sky_error)},
                {"total", number(d.total_error)}}},
              {"within_tolerance", d.estimated ? Json(d.within) : Json()},
              {"cost",
               {{"samples", d.counts.samples},
                {"sun_rays", d.counts.sun_rays},
                {"sky_rays", d.counts.sky_rays},
                {"lamp_rays", d.counts.lamp_rays},
                {"terms", d.counts.terms},
                {"nominal_s_per_megapixel", d.s_per_megapixel}}},
              {"dear", d.dear},
              {"notes", d.notes},
              {"lines", lines_json(lines)}};
  if (d.small.objects > 0 || !d.small.textures.empty()) out["small_objects"] = small_objects_json(d.small);
  if (d.model_pixels > 0) out["model_pixels"] = d.model_pixels;
  if (d.estimated)
    out["trial"] = {
        {"pixels", d.trial_pixels}, {"looked_at", d.looked_at}, {"rays", d.trial_rays}, {"measured", d.measured}};
  return out;
}

std::string lines_text(const std::vector<PlanLine>& lines) {
  std::size_t block = 5, level = 5, cost = 4;
  for (const auto& line : lines) {
    block = std::max(block, line.block.size());
    level = std::max(level, line.level.size() + (line.given ? 8 : 0));
    cost = std::max(cost, line.cost.size());
  }
  std::string out = fmt::format("  {:<{}}  {:<{}}  {:>9}  {:>9}  {:<{}}  {}\n", "block", block, "level", level, "error",
                                "without", "cost", cost, "why");
  for (const auto& line : lines) {
    std::string row = fmt::format("  {:<{}}  {:<{}}  {:>9}  {:>9}  {:<{}}  {}", line.block, block,
                                  line.level + (line.given ? " (given)" : ""), level, percent_text(line.error),
                                  percent_text(line.next_error), line.cost, cost, line.why);
    while (!row.empty() && row.back() == ' ') row.pop_back();
    out += row + "\n";
  }
  return out;
}

}  // namespace raycube::planner
