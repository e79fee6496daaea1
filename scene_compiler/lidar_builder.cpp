#include "scene_compiler/lidar_builder.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "scene_compiler/document_values.h"
#include "scene_compiler/lidar_parts.h"

namespace raycube::scene {

namespace detail {

int count_given(const Record& record, std::initializer_list<const char*> keys) {
  return static_cast<int>(std::count_if(keys.begin(), keys.end(), [&](const char* key) { return record.given(key); }));
}

void want_keys(const Record& record, std::initializer_list<const char*> keys, const std::string& because,
               const LidarReport& report) {
  for (const char* key : keys)
    if (!record.given(key))
      report.problems.add(record.where, std::string("'") + key + "' is missing for " + because, "",
                          std::string(find_key(record.path, key)->text));
}

void refuse_keys(const Record& record, std::initializer_list<const char*> keys, const std::string& because,
                 const LidarReport& report) {
  for (const char* key : keys)
    if (record.given(key))
      report.problems.add(record.place(key), std::string("'") + key + "' means nothing for " + because, "",
                          "remove it, or choose otherwise");
}

}  // namespace detail

namespace {

using base::Problems;
using detail::LidarReport;

/// Pixels of an array take points as sharp: right while the pupil's blur circle, r |1 / R - 1 / focus|, is small
/// against a pixel. It is largest at one of the gate's ends.
void note_blur_of_array(const Record& record, const Lidar& lidar, const LidarReport& report) {
  const auto& receiver = lidar.receiver;
  if (receiver.columns * receiver.rows == 1 || !(receiver.pixel_pitch_rad > 0)) return;
  const double half_way_m = 0.5 * base::kLightSpeed_m_s / lidar.transport.group_index,
               near_m = std::max(lidar.transport.minimum_range_m, half_way_m * lidar.gate.start_s);
  const double far_m = half_way_m * (lidar.gate.start_s + lidar.gate.bins * lidar.gate.bin_s),
               focus = receiver.focus_m > 0 ? 1 / receiver.focus_m : 0;
  const auto blur = [&](double range_m) { return receiver.aperture_radius_m * std::abs(1 / range_m - focus); };
  const bool at_near = !(far_m > near_m) || blur(near_m) >= blur(far_m);
  const double worst = at_near ? blur(near_m) : blur(far_m);
  if (worst > receiver.pixel_pitch_rad / 3)
    report.notice(record.table("receiver")->where,
                  "pixels of an array take points as sharp, but at the gate's " +
                      std::string(at_near ? "start" : "end") + " the pupil blurs them by a radius of " +
                      short_text(worst * 1e3) + " mrad, above a third of a pixel of " +
                      short_text(receiver.pixel_pitch_rad * 1e3) + " mrad: light of neighbours is not mixed there");
}

/// Checks over several tables; they hold only when each table was sound.
void check_together(const Record& record, const Lidar& lidar, const LidarReport& report) {
  const Record &gate = *record.table("gate"), &sampling = *record.table("sampling");
  const auto& t = lidar.transport;
  const double end_s = lidar.gate.start_s + lidar.gate.bins * lidar.gate.bin_s;
  const double near_s = 2 * t.group_index * t.minimum_range_m / base::kLightSpeed_m_s;
  if (end_s <= near_s)
    report.problems.add(gate.where, "the gate is empty: it ends before light from minimum_range_m is back",
                        number_text(end_s * 1e9) + " ns against " + number_text(near_s * 1e9) + " ns",
                        "start it later or give it more bins");
  if (lidar.fold_ambiguous && lidar.pulses == 1)
    report.problems.add(record.place("fold_ambiguous"), "'fold_ambiguous' needs more than one pulse", "1 pulse",
                        "remove it, or fire more");
  if (!lidar.fold_ambiguous && lidar.pulses > 1 && end_s > 1 / lidar.prf_hz)
    report.notice(gate.where,
                  "the gate ends " + number_text(end_s * 1e6) + " us after a pulse, the next follows after " +
                      number_text(1e6 / lidar.prf_hz) +
                      " us; returns are kept with their own pulse (fold_ambiguous = true puts them where they arrive)");
  if (lidar.pulse.separation_s > 0 && lidar.pulse.separation_s >= 1 / lidar.prf_hz)
    report.problems.add(record.table("pulse")->place("separation_s"),
                        "the lines of a shot must all leave before the next shot",
                        number_text(lidar.pulse.separation_s) + " s against " + number_text(1 / lidar.prf_hz) + " s",
                        "lower it, or prf_khz");
  note_blur_of_array(record, lidar, report);
  if (t.range_limit_m > 0 && t.range_limit_m <= t.minimum_range_m)
    report.problems.add(sampling.place("range_limit_m"), "'range_limit_m' is not above minimum_range_m",
                        number_text(t.range_limit_m), "raise it");
  if (t.sampling != LidarSampling::receiver) return;
  if (t.max_bounces > 1)
    report.problems.add(sampling.place("bounces"), "sampling from the receiver follows one scattering",
                        number_text(t.max_bounces) + " bounces", "set bounces = 1, or from = \"transmitter\"");
  if (lidar.pulse.half_divergence_rad == 0)
    report.problems.add(record.table("pulse")->place("divergence_mrad"),
                        "sampling from the receiver never meets a beam without divergence", "0",
                        "give the divergence, or from = \"transmitter\"");
  if (lidar.receiver.pixel_pitch_rad == 0)
    report.problems.add(sampling.place("from"), "sampling from the receiver samples the pixels of an array",
                        "a single round detector (fov_mrad)", "set from = \"transmitter\", or give an array");
}

Lidar read_lidar(const Record& record, const SceneParts& parts, const PlacedBox& box, bool has_sun,
                 const LidarReport& report) {
  Lidar out;
  out.name = record.text("name");
  const std::size_t before = report.problems.count();
  const auto sound = [&](const char* key) {
    const Record* table = record.table(key);
    return table != nullptr && table->sound ? table : nullptr;
  };
  out.fold_ambiguous = record.boolean("fold_ambiguous");
  if (const auto* table = sound("pulse")) detail::read_pulse(*table, out, report);
  if (const auto* table = sound("scan")) detail::read_scan(*table, out, report);
  if (const auto* table = sound("transmitter")) detail::read_mount(*table, out.transmitter, report);
  if (const auto* table = sound("receiver")) detail::read_receiver(*table, out, report);
  if (const auto* table = sound("sampling")) detail::read_sampling(*table, out, report);
  if (const auto* table = sound("gate")) detail::read_gate(*table, out, report);
  if (const auto* table = sound("turbulence")) detail::read_turbulence(*table, out, report);
  if (const auto* table = sound("detector")) detail::read_detector(*table, has_sun, out, report);
  if (const auto* table = sound("echoes")) detail::read_echoes(*table, out, report);
  detail::read_outputs(sound("speckle"), sound("products"), out, report);
  detail::read_platform(record, parts, out, report);
  if (record.sound && report.problems.count() == before) {
    check_together(record, out, report);
    detail::check_before_first_pulse(record, parts, box, out, report);
  }
  return out;
}

}  // namespace

std::vector<Lidar> read_lidars(const Record& root, const SceneParts& parts, const PlacedBox& box, bool has_sun,
                               std::vector<std::string>& notices, Problems& problems) {
  std::vector<Lidar> out;
  std::map<std::string, base::Where> places;
  for (const auto& instrument : root.records("instrument")) places.emplace(instrument.text("name"), instrument.where);
  for (const auto& record : root.records("lidar")) {
    const std::string& name = record.text("name");
    check_folder_name(record, "a LIDAR", problems);
    if (const auto [place, fresh] = places.emplace(name, record.where); !fresh && !name.empty())
      problems.add(record.where, "the name '" + name + "' is taken", "first in " + place->second.text(), "rename one");
    out.push_back(read_lidar(record, parts, box, has_sun, {name, notices, problems}));
    out.back().strip = static_cast<int>(record.given("strip") ? record.integer("strip")
                                                              : std::min<std::int64_t>(65535, std::ssize(out)));
  }
  return out;
}

}  // namespace raycube::scene
