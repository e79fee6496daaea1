#include "scene_compiler/instrument_builder.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "host/base/text.h"
#include "scene_compiler/band_list.h"
#include "scene_compiler/csv_file.h"
#include "scene_compiler/detector_builder.h"
#include "scene_compiler/document_values.h"
#include "scene_compiler/focal_plane_builder.h"

namespace raycube::scene {
namespace {

using base::Problems;

constexpr double kMaxPoses = 1e8, kMostPixels = 68719476736.0;

int count_given(const Record& record, std::initializer_list<const char*> keys) {
  return static_cast<int>(std::count_if(keys.begin(), keys.end(), [&](const char* key) { return record.given(key); }));
}

std::vector<Pose> read_poses(const Record& record, Problems& problems) {
  const auto csv = read_csv(record.text("poses"), record.place("poses"), problems);
  if (!csv) return {};
  static constexpr std::array<const char*, 6> kNames{"x_m", "y_m", "z_m", "roll_deg", "pitch_deg", "heading_deg"};
  std::array<std::optional<std::size_t>, 6> columns;
  for (std::size_t i = 0; i < 6; ++i) columns[i] = csv->column(kNames[i]);
  bool sound = columns[0] && columns[1] && columns[2];
  if (!sound)
    problems.add({csv->file, csv->header_line, 0, ""}, "columns x_m, y_m and z_m are needed", csv->columns_text(),
                 "name them; roll_deg, pitch_deg and heading_deg are optional");
  for (const auto& name : csv->columns)
    if (std::find(kNames.begin(), kNames.end(), name) == kNames.end()) {
      problems.add({csv->file, csv->header_line, 0, ""}, "unknown column", "'" + name + "'",
                   "columns: x_m, y_m, z_m, roll_deg, pitch_deg, heading_deg");
      sound = false;
    }
  std::vector<Pose> poses;
  const std::size_t before = problems.count();
  for (std::size_t row = 0; sound && row < csv->rows.size() && problems.count() < before + 20; ++row) {
    std::array<double, 6> v{
        0, 0, 0, record.number("roll_deg"), record.number("pitch_deg"), record.number("heading_deg")};
    for (std::size_t i = 0; i < 6; ++i)
      if (columns[i]) v[i] = csv->number(row, *columns[i], problems).value_or(0);
    poses.push_back({v[0], v[1], v[2], v[3], v[4], v[5]});
  }
  return problems.count() == before ? poses : std::vector<Pose>{};
}

std::vector<Band> read_bands(const Record& record, Problems& problems) {
  const Record* table = record.table("bands");
  if (table == nullptr) return read_band_file(record.text("bands"), "", record.place("bands"), problems);
  const bool file = table->given("file");
  const int regular = count_given(*table, {"first_nm", "step_nm", "count", "fwhm_nm"});
  if (file ? regular != 0 : regular != 4) {
    problems.add(
        table->where, "bands need either file, or first_nm, step_nm, count and fwhm_nm",
        file ? "file and " + std::to_string(regular) + " of the four" : std::to_string(regular) + " of the four",
        "complete one of the two forms");
    return {};
  }
  if (file) return read_band_file(table->text("file"), table->text("medium"), table->place("file"), problems);
  return regular_bands(table->number("first_nm"), table->number("step_nm"), static_cast<int>(table->integer("count")),
                       table->number("fwhm_nm"), table->text("medium"));
}

void read_samples(const Record& record, Instrument& out, Problems& problems) {
  if (const Record* samples = record.table("samples")) {
    if (count_given(*samples, {"grid", "lattice", "jittered"}) != 1) {
      problems.add(samples->where, "samples needs exactly one of grid, lattice, jittered",
                   std::to_string(count_given(*samples, {"grid", "lattice", "jittered"})),
                   "write samples = { grid = [11, 11] }");
      return;
    }
    out.samples_given = true;
    if (samples->given("lattice")) {
      out.sampler = SamplerKind::lattice;
      out.samples_u = static_cast<int>(samples->integer("lattice"));
      out.samples_v = 1;
    } else {
      const bool grid = samples->given("grid");
      const auto& n = samples->integers(grid ? "grid" : "jittered");
      out.sampler = grid ? SamplerKind::grid : SamplerKind::jittered;
      out.samples_u = static_cast<int>(n[0]);
      out.samples_v = static_cast<int>(n[1]);
    }
    if (samples->given("first")) {
      out.first_samples = static_cast<int>(samples->integer("first"));
      const int all = out.samples_u * out.samples_v;
      if (out.first_samples >= all)
        problems.add(samples->place("first"), "a first pass has fewer samples than the pixel",
                     std::to_string(out.first_samples) + " of " + std::to_string(all), "give fewer, or remove first");
    }
  }
  if (const Record* psf = record.table("psf")) {
    out.psf_sigma_px = psf->number("sigma_px");
    out.psf_support_px = psf->given("support_px") ? psf->number("support_px") : 1.0 + 6.0 * out.psf_sigma_px;
    const bool plain = out.psf_sigma_px == 0 && out.psf_support_px == 1;
    if (!plain && out.first_samples > 0)
      problems.add(psf->where, "a point spread does not go with adaptive samples, whose first pass is a lattice",
                   "first = " + std::to_string(out.first_samples), "remove samples.first or psf");
    if (!plain && out.sampler == SamplerKind::lattice)
      problems.add(psf->where, "a point spread needs the grid or jittered sampler", "lattice",
                   "use samples = { jittered = [n, n] }");
    if (out.psf_support_px < 1.0 + 5.0 * out.psf_sigma_px)
      problems.add(psf->where, "support_px cuts the point spread",
                   number_text(out.psf_support_px) + " for sigma_px " + number_text(out.psf_sigma_px),
                   "give at least 1 + 5 sigma_px");
  }
}

std::vector<int> nearest_bands(const std::vector<Band>& bands, const std::vector<double>& wanted_nm) {
  std::vector<int> out;
  for (const double nm : wanted_nm) {
    const auto nearest = std::min_element(bands.begin(), bands.end(), [nm](const Band& a, const Band& b) {
      return std::abs(a.center_um * 1e3 - nm) < std::abs(b.center_um * 1e3 - nm);
    });
    out.push_back(static_cast<int>(nearest - bands.begin()));
  }
  return out;
}

void choose_quicklook(const Record& record, Instrument& out, Problems& problems) {
  const auto count = static_cast<std::int64_t>(out.bands.size());
  if (count == 0) return;
  if (count_given(record, {"quicklook_bands", "quicklook_nm"}) == 2) {
    problems.add(record.place("quicklook_nm"), "quicklook_bands and quicklook_nm exclude each other", "both",
                 "remove one");
  } else if (record.given("quicklook_bands")) {
    for (const auto number : record.integers("quicklook_bands")) {
      if (number > count)
        problems.add(record.place("quicklook_bands"), "no such band",
                     std::to_string(number) + " of " + std::to_string(count),
                     "bands count from 1, in ascending order of wavelength");
      out.quicklook_bands.push_back(static_cast<int>(number) - 1);
    }
  } else if (record.given("quicklook_nm")) {
    out.quicklook_bands = nearest_bands(out.bands, record.numbers("quicklook_nm"));
  } else if (out.bands.front().center_um <= 0.475 && out.bands.back().center_um >= 0.625) {
    out.quicklook_bands = nearest_bands(out.bands, {650, 550, 450});
  } else {
    const auto last = static_cast<int>(count) - 1;
    out.quicklook_bands = count < 3 ? std::vector<int>{0} : std::vector<int>{last, last / 2, 0};
  }
}

/// Pixel pitch over focal length. agl_m <= 0: height above ground is not known.
double read_ifov_rad(const Record& record, double agl_m, Problems& problems) {
  // A pitch beside another scale is for the focal planes' diffraction.
  const bool planes = !record.records("focal_plane").empty();
  const bool optics = record.given("focal_length_mm") ||
                      (record.given("pitch_um") && !(planes && count_given(record, {"gsd_m", "ifov_mrad"}) == 1));
  const int ways = count_given(record, {"gsd_m", "ifov_mrad"}) + int(optics);
  if (ways != 1) {
    problems.add(record.where, "instrument needs exactly one of gsd_m, ifov_mrad, focal_length_mm with pitch_um",
                 std::to_string(ways), "remove or add one");
    return 0;
  }
  if (record.given("ifov_mrad")) return record.number("ifov_mrad") * 1e-3;
  if (optics) {
    if (count_given(record, {"focal_length_mm", "pitch_um"}) == 2)
      return record.number("pitch_um") * 1e-3 / record.number("focal_length_mm");
    problems.add(record.where, "focal_length_mm and pitch_um go together",
                 record.given("pitch_um") ? "pitch_um alone" : "focal_length_mm alone", "give both");
    return 0;
  }
  if (agl_m > 0) return record.number("gsd_m") / agl_m;
  problems.add(record.place("gsd_m"), "gsd_m needs the instrument above the ground", number_text(agl_m) + " m above it",
               "raise it, or give ifov_mrad");
  return 0;
}

/// Height above the terrain, or above z = 0 off it.
double agl_of(const Pose& pose, const SceneParts& parts) {
  return pose.z_m - parts.terrain_height_m(pose.x_m, pose.y_m).value_or(0.0);
}

/// Where the boresight goes, in place of pitch and roll.
std::optional<Aim> read_aim(const Record& record, Problems& problems) {
  const bool at = record.given("look_at_m"), off = record.given("off_nadir_deg");
  if (!off && record.given("off_nadir_azimuth_deg"))
    problems.add(record.place("off_nadir_azimuth_deg"), "'off_nadir_azimuth_deg' goes with off_nadir_deg", "",
                 "remove it, or add off_nadir_deg");
  if (!at && !off) return std::nullopt;
  const std::string with = at ? "look_at_m" : "off_nadir_deg";
  for (const char* key : {"pitch_deg", "roll_deg", "poses"})
    if (record.given(key))
      problems.add(record.place(key), std::string("'") + key + "' and '" + with + "' both turn the instrument", "",
                   "remove one");
  for (const char* key : {"position_m", "center_m"})
    if (at && off && record.given(key))
      problems.add(record.place(key), std::string("'") + key + "' does not go with look_at_m and off_nadir_deg", "",
                   "give altitude_agl_m: the place follows");
  if (at && record.numbers("look_at_m").size() != 3) return std::nullopt;
  Aim aim;
  if (at) aim.at_point = true, std::copy_n(record.numbers("look_at_m").begin(), 3, aim.point_m.begin());
  if (off) {
    aim.off_nadir_deg = record.number("off_nadir_deg");
    aim.azimuth_deg = record.number(record.given("off_nadir_azimuth_deg") ? "off_nadir_azimuth_deg" : "heading_deg");
  }
  return aim;
}

void read_geometry(const Record& record, const SceneParts& parts, Instrument& out, Problems& problems) {
  if (double(out.lines) * out.pixels > kMostPixels) {
    problems.add(record.place("lines"), "an image has at most 2^36 pixels, a band of which takes 256 GiB",
                 base::counted(out.pixels, "pixel") + " x " + base::counted(out.lines, "line"),
                 "split the image, or correct pixels and lines");
    return;
  }
  const int ways = count_given(record, {"altitude_agl_m", "position_m", "poses"});
  if (ways != 1) {
    problems.add(record.where, "instrument needs exactly one of altitude_agl_m, position_m, poses",
                 std::to_string(ways), "remove or add one");
    return;
  }
  if (double(out.lines) * (out.kind == InstrumentKind::whiskbroom ? out.pixels : 1) > kMaxPoses) {
    problems.add(record.place("lines"), "instrument needs more than 1e8 poses", base::counted(out.lines, "line"),
                 "split the image");
    return;
  }
  Pose middle{0, 0, 0, record.number("roll_deg"), record.number("pitch_deg"), record.number("heading_deg")};
  std::vector<Pose> given;
  const std::size_t before = problems.count();
  const std::optional<Aim> aim = read_aim(record, problems);
  if (problems.count() > before) return;
  if (aim && aim->places()) {
    out.nominal_agl_m = record.number("altitude_agl_m");
    aim->place(out.nominal_agl_m, middle);
  } else if (record.given("altitude_agl_m")) {
    const auto& c = record.numbers("center_m");
    out.nominal_agl_m = record.number("altitude_agl_m");
    middle.x_m = c[0], middle.y_m = c[1];
    middle.z_m = parts.terrain_height_m(c[0], c[1]).value_or(0.0) + out.nominal_agl_m;
  } else if (record.given("position_m")) {
    const auto& p = record.numbers("position_m");
    middle.x_m = p[0], middle.y_m = p[1], middle.z_m = p[2];
  } else {
    given = read_poses(record, problems);
    if (given.empty()) return;
    middle = given[given.size() / 2];
  }
  if (aim && !aim->turn(out.kind == InstrumentKind::framing && !record.given("heading_deg"), middle)) {
    problems.add(record.place("look_at_m"), "'look_at_m' does not lie below the instrument",
                 number_text(aim->point_m[2]) + " m against " + number_text(middle.z_m) + " m",
                 "raise the instrument, or look at a lower point");
    return;
  }
  if (record.given("center_m") && !record.given("altitude_agl_m"))
    problems.add(record.place("center_m"), "'center_m' goes with altitude_agl_m", "", "remove it");
  const double agl_m = agl_of(middle, parts);
  out.ifov_across_rad = out.ifov_along_rad = read_ifov_rad(record, agl_m, problems);
  if (record.given("line_spacing_m") && (!given.empty() || out.kind == InstrumentKind::framing))
    problems.add(record.place("line_spacing_m"), "'line_spacing_m' is for scanners on a straight flight", "",
                 "remove it");
  if (given.empty()) {
    const double spacing =
        record.given("line_spacing_m") ? record.number("line_spacing_m") : out.ifov_along_rad * agl_m;
    if (out.kind != InstrumentKind::framing && !(spacing > 0) && out.ifov_along_rad > 0)
      problems.add(record.where, "line spacing needs the instrument above the ground",
                   number_text(agl_m) + " m above it", "raise it, or give line_spacing_m");
    out.poses = straight_flight(out.kind, out.lines, out.pixels, middle, spacing);
    return;
  }
  const auto lines = static_cast<std::size_t>(out.lines), pixels = static_cast<std::size_t>(out.pixels);
  const bool per_line = given.size() == lines && out.kind != InstrumentKind::framing,
             one = given.size() == 1 && out.kind == InstrumentKind::framing;
  const bool per_pixel = given.size() == lines * pixels && out.kind == InstrumentKind::whiskbroom;
  if (!per_line && !one && !per_pixel)
    problems.add(record.place("poses"), "number of poses does not fit the image",
                 base::counted(given.size(), "pose") + ", " + base::counted(lines, "line") + " of " +
                     std::to_string(pixels) + " pixels",
                 "framing: 1; pushbroom: one per line; whiskbroom: one per line or per pixel");
  out.poses = per_line && !per_pixel && out.kind == InstrumentKind::whiskbroom ? poses_per_pixel(given, out.pixels)
                                                                               : std::move(given);
}

void read_band_truth(const Record& record, Instrument& out) {
  const auto& asked = record.value("band_truth").texts;
  const auto named = [&](std::string_view name) { return std::find(asked.begin(), asked.end(), name) != asked.end(); };
  out.all_parts = named("parts");
  for (std::size_t i = 0; i < std::size(kBandTruth); ++i)
    if (named(kBandTruth[i].name)) out.band_truth.push_back(static_cast<BandTruth>(i));
}

Instrument read_instrument(const Record& record, const SceneParts& parts, std::vector<std::string>& notices,
                           Problems& problems) {
  Instrument out;
  out.name = record.text("name");
  const std::string& kind = record.text("kind");
  out.kind = kind == "framing"      ? InstrumentKind::framing
             : kind == "whiskbroom" ? InstrumentKind::whiskbroom
                                    : InstrumentKind::pushbroom;
  out.pixels = static_cast<int>(record.integer("pixels"));
  out.lines = static_cast<int>(record.integer("lines"));
  const std::string& motion = record.text("motion");
  out.motion = motion == "held" ? PoseMotion::held : motion == "moving" ? PoseMotion::moving : PoseMotion::automatic;
  if (out.motion != PoseMotion::held && out.kind != InstrumentKind::pushbroom)
    problems.add(record.place("motion"), "only a pushbroom moves while it looks at a line", motion,
                 "remove motion, or set kind = \"pushbroom\"");
  read_geometry(record, parts, out, problems);
  read_samples(record, out, problems);
  out.bands = read_bands(record, problems);
  if (sort_bands(out.bands))
    notices.push_back(record.place("bands").text() + ": bands of '" + out.name +
                      "' were not ascending and have been sorted");
  choose_quicklook(record, out, problems);
  out.interleave = record.text("interleave");
  const std::string& small = record.text("small_objects");
  out.small_objects = small == "on" ? SmallObjects::on : small == "off" ? SmallObjects::off : SmallObjects::automatic;
  const std::string& error = record.text("standard_error");
  out.standard_error = error == "off"     ? StandardError::off
                       : error == "worst" ? StandardError::worst
                                          : StandardError::bands;
  if (out.standard_error != StandardError::off && out.samples_given && out.samples_u * out.samples_v < 4)
    problems.add(record.place("standard_error"), "a standard error needs at least 4 samples in a pixel",
                 std::to_string(out.samples_u * out.samples_v), "give more samples, or standard_error = \"off\"");
  out.write_exr = record.boolean("exr");
  out.write_png = record.boolean("png");
  read_band_truth(record, out);
  out.first_opaque = record.boolean("first_opaque");
  if (record.given("integer_scale")) out.integer_scale = record.number("integer_scale");
  read_focal_planes(record, out, problems);
  if (const Record* detector = record.table("detector")) {
    out.detector = read_detector(*detector, problems);
    if (out.integer_scale)
      problems.add(detector->where, "a detector measures radiance.img, which must be float32", "integer_scale",
                   "remove integer_scale; measured.img has digital numbers by detector.bits");
  }
  return out;
}

}  // namespace

std::vector<Instrument> read_instruments(const Record& root, const SceneParts& parts, std::vector<std::string>& notices,
                                         Problems& problems) {
  std::vector<Instrument> out;
  std::map<std::string, base::Where> places;
  for (const auto& record : root.records("instrument")) {
    const std::string& name = record.text("name");
    check_folder_name(record, "an instrument", problems);
    if (const auto [place, fresh] = places.emplace(name, record.where); !fresh && !name.empty())
      problems.add(record.where, "instrument '" + name + "' is defined twice", "first in " + place->second.text(),
                   "rename one");
    if (record.sound) out.push_back(read_instrument(record, parts, notices, problems));
  }
  return out;
}

}  // namespace raycube::scene
