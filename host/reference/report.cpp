#include <algorithm>
#include <cmath>
#include <cstdio>

#include <nlohmann/json.hpp>

#include "host/base/text.h"
#include "host/reference/compare.h"
#include "host/reference/report_text.h"

namespace raycube::reference {

namespace {

std::string name_of(const Hit& hit) {
  return hit.miss() ? "a miss"
                    : "instance " + std::to_string(hit.instance) + " primitive " + std::to_string(hit.primitive);
}

nlohmann::ordered_json json_of(const HitReport& report) {
  nlohmann::ordered_json out = {{"rays", report.rays}};
  for (std::size_t c = 0; c < kCauses; ++c) out[key_of(static_cast<Cause>(c))] = report.hits[c];
  out["explained_share"] = report.explained_share();
  out["explained_device_right"] = report.device_right;
  out["explained_embree_right"] = report.embree_right;
  out["hit_against_miss"] = report.hit_miss;
  out["hit_against_miss_in_double"] = report.hit_miss_double;
  out["unexplained_rays"] = nlohmann::ordered_json::array();
  const auto hit = [](const Hit& h) {
    return h.miss() ? nlohmann::ordered_json()
                    : nlohmann::ordered_json{{"instance", h.instance}, {"primitive", h.primitive}};
  };
  for (const UnexplainedRay& r : report.unexplained)
    out["unexplained_rays"].push_back({{"line", r.line},
                                       {"sample", r.sample},
                                       {"ray", r.ray},
                                       {"device", hit(r.device)},
                                       {"embree", hit(r.embree)},
                                       {"double", hit(r.exact)}});
  return out;
}

nlohmann::ordered_json json_of(const BouncedReport& report) {
  nlohmann::ordered_json out = {{"pixels", report.pixels},
                                {"paths", report.paths},
                                {"skeleton_error", report.skeleton_error},
                                {"limit_standard_errors", BouncedReport::kApart},
                                {"worst_band", report.worst()}};
  for (const auto& band : report.bands) {
    out["device"].push_back(band.device);
    out["reference"].push_back(band.reference);
    out["standard_error"].push_back(band.error);
    out["apart"].push_back(report.apart(band));
    out["reference_size"].push_back(band.size);
  }
  return out;
}

nlohmann::ordered_json json_of(const ReplayReport& report) {
  nlohmann::ordered_json hits;
  for (std::size_t cause = 0; cause < kCauses; ++cause) hits[key_of(static_cast<Cause>(cause))] = report.hits[cause];
  return {{"pixels", report.pixels},
          {"pixels_left_out", report.excluded_pixels},
          {"paths", report.paths},
          {"rays_to_surfaces", report.steps},
          {"hits", hits},
          {"rays_to_lights", report.asked},
          {"rays_to_lights_explained", report.asked_explained},
          {"rays_to_lights_unexplained", report.asked_unexplained},
          {"decisions", report.decisions},
          {"decisions_at_their_chance", report.decisions_near},
          {"decisions_wrong", report.decisions_wrong},
          {"directions_wrong", report.ways_wrong},
          {"worst_direction", report.worst_way},
          {"limit_direction", ReplayReport::kMostWayOff},
          {"other_bits", report.other_bits},
          {"worst", report.worst},
          {"worst_line", report.worst_line},
          {"worst_sample", report.worst_sample},
          {"limit", ReplayReport::kMostOff}};
}

std::uint64_t unexplained(const Report& r) { return r.hits[static_cast<std::size_t>(Cause::unexplained)]; }

}  // namespace

/// Black, blue, green, yellow, red at -9, -8, -7, -6, log10(2e-5); linear between.
std::array<std::uint8_t, 3> difference_colour(float log10_difference) {
  static constexpr float at[] = {-9, -8, -7, -6, -4.69897f};
  static constexpr float rgb[][3] = {{0, 0, 0}, {40, 60, 160}, {40, 160, 90}, {250, 220, 60}, {220, 30, 30}};
  if (!(log10_difference < at[4])) return {220, 30, 30};
  int i = 0;
  while (i < 3 && log10_difference > at[i + 1]) ++i;
  const float f = std::clamp((log10_difference - at[i]) / (at[i + 1] - at[i]), 0.0f, 1.0f);
  std::array<std::uint8_t, 3> out{};
  for (std::size_t c = 0; c < 3; ++c)
    out[c] = static_cast<std::uint8_t>(std::lround(rgb[i][c] + f * (rgb[i + 1][c] - rgb[i][c])));
  return out;
}

std::vector<std::string> Report::failures() const {
  std::vector<std::string> out;
  if (pixels == 0) out.push_back("no pixel was compared");
  if (const std::uint64_t count = first_hits.of(Cause::unexplained); count > 0) {
    const UnexplainedRay& r = first_hits.unexplained.at(0);
    out.push_back(std::to_string(count) + " of " + std::to_string(first_hits.rays) +
                  " first hits differ without explanation, "
                  "the first at line " +
                  std::to_string(r.line) + ", sample " + std::to_string(r.sample) + ", ray " + std::to_string(r.ray) +
                  ": the device says " + name_of(r.device) + ", Embree " + name_of(r.embree) + ", double " +
                  name_of(r.exact));
  }
  if (unexplained(*this) > 0)
    out.push_back(base::counted(unexplained(*this), "first hit differs", "first hits differ") + " without explanation");
  if (sun_unexplained > 0)
    out.push_back(base::counted(sun_unexplained, "sun ray differs", "sun rays differ") + " without explanation");
  if (sky_unexplained > 0)
    out.push_back(base::counted(sky_unexplained, "sample sees", "samples see") + " another sky without explanation");
  if (lamp_unexplained > 0)
    out.push_back(base::counted(lamp_unexplained, "side of a sample gets", "sides of samples get") +
                  " other lamplight without explanation");
  if (!(worst_median < limits.median))
    out.push_back("a band's median difference is " + three_digits(worst_median) + ", limit " +
                  three_digits(limits.median));
  if (beyond_pixels > 0)
    out.push_back(base::counted(beyond_pixels, "pixel differs", "pixels differ") + " by more than " +
                  three_digits(limits.worst) + ", the worst by " + three_digits(worst) + " in band " +
                  std::to_string(worst_band + 1) + " at line " + std::to_string(worst_line) + ", sample " +
                  std::to_string(worst_sample));
  if (model_pixels > 0 && !(model_total.figure <= limits.model))
    out.push_back("the full tables differ by " + three_digits(model_total.figure) + " in band " +
                  std::to_string(model_total.band + 1) + ", tolerance " + three_digits(limits.model));
  for (const std::string& failure : bounced.failures()) out.push_back(failure);
  for (const std::string& failure : replayed.failures()) out.push_back(failure);
  return out;
}

std::string Report::text(const std::vector<std::string>& band_names) const {
  const auto band = [&](std::size_t b) { return b < band_names.size() ? band_names[b] : std::to_string(b); };
  std::string out;
  if (first_hits.rays > 0)
    out += "first hits of " + std::to_string(first_hits.rays) + " rays:" + counts_text(first_hits.hits) +
           "; share explained " + three_digits(first_hits.explained_share()) + " (double sides with the device in " +
           std::to_string(first_hits.device_right) + ", with Embree in " + std::to_string(first_hits.embree_right) +
           "); hit against miss: Embree " + std::to_string(first_hits.hit_miss) + ", double " +
           std::to_string(first_hits.hit_miss_double) + "\n";
  out += "pixels compared in full " + std::to_string(pixels) + ", their rays " + std::to_string(rays) +
         "\nfirst hits:" + counts_text(hits) + "; hit against miss " + std::to_string(hit_miss);
  out += "\nsun rays: " + std::to_string(sun_rays) + ", explained " + std::to_string(sun_explained) + ", unexplained " +
         std::to_string(sun_unexplained);
  out += "\nsky rays: " + std::to_string(sky_rays) + ", explained " + std::to_string(sky_explained) +
         ", samples unexplained " + std::to_string(sky_unexplained);
  if (lamps)
    out += "\nlamp rays: " + std::to_string(lamp_rays) + ", explained " + std::to_string(lamp_explained) +
           ", unexplained " + std::to_string(lamp_unexplained);
  out += "\narithmetic: worst band median " + three_digits(worst_median) + " (limit " + three_digits(limits.median) +
         "), worst " + three_digits(worst) + " (limit " + three_digits(limits.worst) + ") in band " + band(worst_band) +
         " at line " + std::to_string(worst_line) + ", sample " + std::to_string(worst_sample) + "; pixels left out " +
         std::to_string(excluded_pixels);
  if (model_pixels > 0)
    out += "\nmodel (" + base::counted(model_pixels, "pixel") + "): " + three_digits(model_total.figure) + " in band " +
           band(model_total.band) + " (tolerance " + three_digits(limits.model) + "); sun " +
           three_digits(model_sun.figure) + ", sky " + three_digits(model_sky.figure) + ", path " +
           three_digits(model_path.figure);
  if (model_pixels > 0 && lamps) out += ", lamps " + three_digits(model_lamps.figure);
  if (model_pixels > 0 && adjacency) out += ", ground around " + three_digits(model_environment.figure);
  if (model_pixels > 0 && thermal)
    out += ", emission " + three_digits(model_emission.figure) + ", surroundings at one temperature " +
           three_digits(model_surroundings.figure);
  out += bounced.text() + replayed.text();
  for (const std::string& failure : failures()) out += "\nBEYOND LIMITS: " + failure;
  return out + "\n";
}

std::string Report::json() const {
  nlohmann::ordered_json out;
  out["passed"] = failures().empty();
  out["failures"] = failures();
  if (first_hits.rays > 0) out["first_hits"] = json_of(first_hits);
  out["pixels"] = pixels;
  out["rays"] = rays;
  for (std::size_t c = 0; c < hits.size(); ++c) out["hits_" + key_of(static_cast<Cause>(c))] = hits[c];
  out["hits_hit_against_miss"] = hit_miss;
  out["sun_rays"] = sun_rays;
  out["sun_explained"] = sun_explained;
  out["sun_unexplained"] = sun_unexplained;
  if (lamps) {
    out["lamp_rays"] = lamp_rays;
    out["lamp_explained"] = lamp_explained;
    out["lamp_unexplained"] = lamp_unexplained;
  }
  out["sky_rays"] = sky_rays;
  out["sky_explained"] = sky_explained;
  out["sky_unexplained"] = sky_unexplained;
  out["excluded_pixels"] = excluded_pixels;
  out["beyond_pixels"] = beyond_pixels;
  out["median_worst_band"] = worst_median;
  out["median_limit"] = limits.median;
  out["worst"] = worst;
  out["worst_limit"] = limits.worst;
  out["worst_band"] = worst_band;
  out["worst_line"] = worst_line;
  out["worst_sample"] = worst_sample;
  if (model_pixels > 0) {
    const auto block = [](const ModelDifference& d) {
      return nlohmann::ordered_json{{"figure", d.figure}, {"band", d.band}};
    };
    out["model"] = {{"pixels", model_pixels},  {"tolerance", limits.model}, {"total", block(model_total)},
                    {"sun", block(model_sun)}, {"sky", block(model_sky)},   {"path", block(model_path)}};
    if (lamps) out["model"]["lamps"] = block(model_lamps);
    if (thermal) {
      out["model"]["emission"] = block(model_emission);
      out["model"]["surroundings"] = block(model_surroundings);
    }
  }
  if (model_pixels > 0 && adjacency)
    out["model"]["environment"] = {{"figure", model_environment.figure}, {"band", model_environment.band}};
  if (!bounced.bands.empty()) out["light_between_surfaces"] = json_of(bounced);
  if (replayed.pixels > 0) out["paths_replayed"] = json_of(replayed);
  for (const BandDifference& band : bands) {
    out["band_median"].push_back(band.median);
    out["band_rms"].push_back(band.rms);
    out["band_max"].push_back(band.max);
  }
  return out.dump(2);
}

Picture difference_picture(const Report& report, int rows) {
  Picture out;
  if (report.picture.empty() || report.picture[0].empty()) return out;
  const std::size_t pixels = report.picture.size(), bands = report.picture[0].size();
  const std::size_t bunch = (pixels + static_cast<std::size_t>(rows) - 1) / static_cast<std::size_t>(rows);
  out.width = static_cast<int>(bands);
  out.bunch = static_cast<int>(bunch);
  for (std::size_t first = 0; first < pixels; first += bunch, ++out.height)
    for (std::size_t b = 0; b < bands; ++b) {
      float worst = -12;
      for (std::size_t p = first; p < std::min(pixels, first + bunch); ++p)
        if (!(report.picture[p][b] <= worst)) worst = report.picture[p][b];
      for (std::uint8_t channel : difference_colour(worst)) out.rgb.push_back(channel);
    }
  return out;
}

}  // namespace raycube::reference
