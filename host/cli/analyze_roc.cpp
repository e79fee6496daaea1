// raycube analyze roc: how a map of scores finds targets that are known.
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <ostream>

#include <fmt/format.h>

#include "host/analysis/roc.h"
#include "host/base/error.h"
#include "host/cli/analyze_kit.h"
#include "host/cli/analyze_verbs.h"
#include "host/cli/services.h"

namespace raycube::cli {
namespace {

struct RocRequest : AnalyzeRequest {
  std::string layer, truth, false_alarms = "exact", share_of = "pixel";
  std::vector<std::string> least_shares;
  analysis::RocOptions options;
  bool per_target = false;
};

/// FILE or FILE@LAYER.
std::vector<double> truth_of(const std::string& text, const analysis::Cube& cube) {
  const bool whole = std::filesystem::exists(text);
  const auto at = whole ? std::string::npos : text.rfind('@');
  return analysis::read_layer(text.substr(0, at), at == std::string::npos ? "" : text.substr(at + 1), cube.samples(),
                              cube.lines());
}

std::vector<double> least_shares_of(const RocRequest& request) {
  std::vector<double> out;
  for (const std::string& text : request.least_shares) {
    char* end = nullptr;
    out.push_back(std::strtod(text.c_str(), &end));
    if (text.empty() || *end != '\0' || !(out.back() >= 0 && out.back() <= 1))
      throw base::Error(base::Fault::input, fmt::format("--least-share {}: a share is from 0 to 1", text));
  }
  if (out.empty()) out.push_back(0);
  return out;
}

/// Points of a curve that a picture shows: where it turns.
nlohmann::ordered_json corners(const analysis::Roc& roc) {
  nlohmann::ordered_json out = nlohmann::json::array();
  const auto& p = roc.point;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const bool straight = i > 0 && i + 1 < p.size() && p[i - 1].detection_rate == p[i].detection_rate &&
                          p[i + 1].detection_rate == p[i].detection_rate;
    if (!straight) out.push_back({p[i].false_alarm_rate, p[i].detection_rate, p[i].threshold});
  }
  return out;
}

int roc(const RocRequest& request, Invocation& invocation) {
  if (request.truth.empty())
    throw base::Error(base::Fault::input,
                      "a curve needs the truth: --truth FILE@LAYER, as truth.img@abundance_green of a render");
  const analysis::Cube cube = open_cube(invocation, request.cube, request.bands);
  const std::vector<double> score = analysis::read_layer(cube.path(), request.layer, cube.samples(), cube.lines()),
                            share = truth_of(request.truth, cube);
  analysis::RocOptions options = request.options;
  options.false_alarms =
      request.false_alarms == "exact" ? analysis::FalseAlarms::exact : analysis::FalseAlarms::outside_area;
  options.share_of = request.share_of == "pixel" ? analysis::ShareOf::pixel : analysis::ShareOf::target;
  options.seed = invocation.common.seed.value_or(1), options.per_target = request.per_target;
  AnalysisFolder folder(invocation, request, "roc");
  products::CsvWriter table(folder.table("roc.csv"),
                            {"least_share", "threshold", "false_alarm_rate", "detection_rate"});
  std::string text;
  for (const double least : least_shares_of(request)) {
    options.least_share = least;
    const analysis::Roc found = analysis::roc(score, share, cube.samples(), cube.lines(), options);
    for (const analysis::RocPoint& p : found.point) {
      table.add(least).add(p.threshold).add(p.false_alarm_rate).add(p.detection_rate).end_row();
    }
    folder.numbers()["curves"].push_back({{"least_share", least},
                                          {"positives", found.positives},
                                          {"negatives", found.negatives},
                                          {"targets", found.targets},
                                          {"not_scored", found.not_scored},
                                          {"area", found.area},
                                          {"before_first_false_alarm", found.before_first_false_alarm},
                                          {"interval_95", {found.interval_low, found.interval_high}},
                                          {"points", corners(found)}});
    text += fmt::format(
        "share of {} at least {:g}: {} {} of {} targets, {} pixels for false alarms; found before the first false "
        "alarm: "
        "{:.1f} % (95 %: {:.1f} to {:.1f}); area under the curve {:.5f}\n",
        request.share_of, least, found.positives, options.per_target ? "targets" : "pixels", found.targets,
        found.negatives, 100 * found.before_first_false_alarm, 100 * found.interval_low, 100 * found.interval_high,
        found.area);
    if (found.not_scored > 0)
      text += fmt::format("  {} of them have no score, and count as not found\n", found.not_scored);
  }
  table.finish();
  folder.numbers()["false_alarms"] = request.false_alarms, folder.numbers()["buffer_px"] = options.buffer_px;
  folder.numbers()["share_of"] = request.share_of, folder.numbers()["per_target"] = options.per_target;
  return folder.finish(cube, text);
}

}  // namespace

Verb verb_analyze_roc() {
  auto o = std::make_shared<RocRequest>();
  Verb verb("roc", "Detections against false alarms of a map of scores whose targets are known");
  verb.description =
      "CUBE is a map of scores (raycube analyze detect), --truth a raster of the share of each pixel that is target, "
      "as "
      "the layers abundance_MATERIAL of a render's truth.img. Pixels with target that touch are one target.\n\n"
      "A pixel with target counts as to be found where its share is at least --least-share: of the pixel's area "
      "(--share-of pixel), or of the target's own (target): a target smaller than a pixel never fills one. Others with "
      "target are neither found nor false alarms. False alarms are counted outside each target's pixels and --buffer "
      "around them (exact), or outside the rectangle around all targets and --buffer (outside_area), as for real "
      "images "
      "whose targets are not known to the pixel. With --per-target a target is found when its best pixel is.\n\n"
      "The interval is of 95 %, by --bootstrap draws of the targets with their pixels; the negatives stay.";
  verb.examples = {
      "raycube analyze roc detect/detect.img --layer \"ace green\" --truth out/camera/truth.img@abundance_green",
      "raycube analyze roc detect/detect.img --truth truth.img@3 --least-share 0 --least-share 0.1 --per-target"};
  verb.common = kOutput | kSeed;
  verb.output_default = "roc";
  verb.add_options = [o](base::OptionTable& table) {
    add_cube_options(table, *o);
    table.text("--layer", "NAME", "Layer of scores, by name or number", o->layer).default_text = "the first";
    table.text("--truth", "FILE@LAYER", "Share of target in each pixel", o->truth);
    table.texts("--least-share", "SHARE", "Least share of pixels to be found; a curve for each", o->least_shares)
        .default_text = "0";
    table.choice("--share-of", {"pixel", "target"}, "What the share is of", o->share_of);
    table.choice("--false-alarms", {"exact", "outside_area"}, "Where false alarms are counted", o->false_alarms);
    table.integer("--buffer", "px", 0, 1000, "Pixels around targets that are no false alarms", o->options.buffer_px);
    table.flag("--per-target", "Count targets, not pixels", o->per_target);
    table.flag("--lower", "Lower scores are more like a target, as of sam", o->options.lower_is_target);
    table.integer("--bootstrap", "", 0, 1000000, "Draws for the interval", o->options.bootstrap);
  };
  verb.run = [o](Invocation& invocation) { return roc(*o, invocation); };
  return verb;
}

}  // namespace raycube::cli
