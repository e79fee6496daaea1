#include "scene_compiler/focal_plane_builder.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "host/base/text.h"
#include "scene_compiler/csv_file.h"
#include "scene_compiler/document_values.h"

namespace raycube::scene {
namespace {

using base::Problems;

constexpr double kMostSmile_nm = 100, kMostKeystone_px = 20;  ///< as the keys of the same names
constexpr double kMostReach_px = 250 / 3.0;  ///< of a measured spread: 250 cells, of which a pixel has three at least
constexpr double kEven = 1e-6;               ///< of a grid's step, by which its points may be off

/// The columns of a file by name; each row's numbers. Reports what is missing.
struct Columns {
  std::optional<CsvFile> csv;
  std::map<std::string, std::vector<double>> of;
};

Columns read_columns(const Record& record, const char* key, const std::vector<std::string>& needed,
                     const std::vector<std::string>& optional, Problems& problems) {
  Columns out;
  out.csv = read_csv(record.text(key), record.place(key), problems);
  if (!out.csv) return out;
  for (const auto* names : {&needed, &optional})
    for (const std::string& name : *names) {
      const auto column = out.csv->column(name);
      if (!column) continue;
      auto& values = out.of[name];
      for (std::size_t row = 0; row < out.csv->rows.size(); ++row)
        values.push_back(out.csv->number(row, *column, problems).value_or(0));
    }
  for (const std::string& name : needed)
    if (out.of.find(name) == out.of.end()) {
      problems.add({out.csv->file, out.csv->header_line, 0, ""}, "column " + name + " is missing",
                   out.csv->columns_text(), "name it");
      out.csv.reset();
      return out;
    }
  std::vector<std::string> known = needed;
  known.insert(known.end(), optional.begin(), optional.end());
  out.csv->refuse_other_columns(known, problems);
  return out;
}

std::vector<double> distinct(const std::vector<double>& values) {
  const std::set<double> all(values.begin(), values.end());
  return {all.begin(), all.end()};
}

/// Values on the grid of two columns, [first][second]; empty, and reported, where one is missing or there twice.
std::vector<std::vector<double>> on_grid(const std::vector<double>& first, const std::vector<double>& second,
                                         const std::vector<double>& value, const base::Where& where,
                                         Problems& problems) {
  const std::vector<double> rows = distinct(first), columns = distinct(second);
  if (rows.size() * columns.size() != value.size()) {
    problems.add(where, "the table is no grid",
                 base::counted(value.size(), "row") + " for " + std::to_string(rows.size()) + " x " +
                     std::to_string(columns.size()),
                 "give each pair once");
    return {};
  }
  std::vector<std::vector<double>> out(rows.size(), std::vector<double>(columns.size(), NAN));
  for (std::size_t i = 0; i < value.size(); ++i) {
    const auto r = std::lower_bound(rows.begin(), rows.end(), first[i]) - rows.begin();
    const auto c = std::lower_bound(columns.begin(), columns.end(), second[i]) - columns.begin();
    out[static_cast<std::size_t>(r)][static_cast<std::size_t>(c)] = value[i];
  }
  for (const auto& row : out)
    for (const double v : row)
      if (std::isnan(v)) {
        problems.add(where, "the table is no grid", "a pair is there twice", "give each pair once");
        return {};
      }
  return out;
}

bool even(const std::vector<double>& places) {
  for (std::size_t i = 2; i < places.size(); ++i) {
    const double step = places[1] - places[0];
    if (std::abs(places[i] - places[i - 1] - step) > kEven * step * static_cast<double>(places.size())) return false;
  }
  return places.size() > 1;
}

/// Whether a spread ends where one can; farther ones would keep whoever makes its transfer busy.
bool within_reach(const std::vector<double>& places_px, const base::Where& where, Problems& problems) {
  double most = 0;
  for (const double place : places_px) most = std::max(most, std::abs(place));
  if (most <= kMostReach_px) return true;
  problems.add(where, "a point spread reaches at most 83 pixels", number_text(most), "cut it where it has ended");
  return false;
}

SpreadTable read_spread(const Record& record, Problems& problems) {
  SpreadTable out;
  const auto head = read_csv(record.text("spread"), record.place("spread"), problems);
  if (!head) return out;
  const base::Where where = record.place("spread");
  const std::size_t before = problems.count();
  if (!head->column("radius_px")) {
    const Columns table = read_columns(record, "spread", {"x_px", "y_px", "psf"}, {}, problems);
    if (!table.csv || problems.count() != before) return {};
    out.x_px = table.of.at("x_px"), out.y_px = table.of.at("y_px"), out.grid_value = table.of.at("psf");
    if (!within_reach(out.x_px, where, problems) || !within_reach(out.y_px, where, problems)) return {};
    const std::vector<double> columns = distinct(out.x_px), rows = distinct(out.y_px);
    if (columns.size() < 2 || rows.size() < 2 || !even(columns) || !even(rows))
      problems.add(where, "x_px and y_px of a point spread must lie on a regular grid of two rows and columns or more",
                   std::to_string(columns.size()) + " x " + std::to_string(rows.size()) + " places",
                   "resample it, or give radius_px");
    on_grid(out.x_px, out.y_px, out.grid_value, where, problems);
    double sum = 0;
    for (const double v : out.grid_value) sum += v;
    if (!(sum > 0)) problems.add(where, "a point spread needs a positive sum", number_text(sum), "check psf");
    return out;
  }
  const Columns table = read_columns(record, "spread", {"radius_px", "psf"}, {"wavelength_nm"}, problems);
  if (!table.csv || problems.count() != before) return {};
  const auto& radius = table.of.at("radius_px");
  if (!within_reach(radius, where, problems)) return {};
  const auto nm = table.of.find("wavelength_nm");
  const std::vector<double> at_nm = nm == table.of.end() ? std::vector<double>(radius.size(), 0.0) : nm->second;
  out.value = on_grid(at_nm, radius, table.of.at("psf"), where, problems);
  out.radius_px = distinct(radius);
  for (const double one : distinct(at_nm)) out.wavelength_um.push_back(1e-3 * one);
  if (nm != table.of.end() && !(out.wavelength_um.front() > 0))
    problems.add(where, "a wavelength of a point spread must be above 0", number_text(1e3 * out.wavelength_um.front()),
                 "correct wavelength_nm");
  if (out.radius_px.front() < 0 || out.radius_px.size() < 2)
    problems.add(where, "radius_px needs two radii or more, none below 0", number_text(out.radius_px.front()),
                 "check the file");
  if (out.radius_px.front() > 0) {  // within the first ring it is as on it
    out.radius_px.insert(out.radius_px.begin(), 0.0);
    for (auto& rings : out.value)
      if (!rings.empty()) rings.insert(rings.begin(), rings.front());
  }
  for (const auto& rings : out.value) {
    double sum = 0;
    for (std::size_t i = 0; i < rings.size(); ++i) sum += rings[i] * out.radius_px[i];
    if (!(sum > 0)) problems.add(where, "a point spread needs a positive sum", number_text(sum), "check psf");
  }
  return out;
}

DistortionTable read_distortion(const Record& record, Problems& problems) {
  DistortionTable out;
  const std::size_t before = problems.count();
  const Columns table =
      read_columns(record, "distortion", {"wavelength_nm", "sample", "smile_nm", "keystone_px"}, {}, problems);
  if (!table.csv || problems.count() != before) return {};
  const auto &nm = table.of.at("wavelength_nm"), &sample = table.of.at("sample");
  out.smile_um = on_grid(nm, sample, table.of.at("smile_nm"), record.place("distortion"), problems);
  out.keystone_px = on_grid(nm, sample, table.of.at("keystone_px"), record.place("distortion"), problems);
  if (problems.count() != before) return {};
  const auto within = [&](const std::vector<std::vector<double>>& rows, double most, const char* column) {
    for (const auto& row : rows)
      for (const double v : row)
        if (std::abs(v) > most) {
          problems.add(record.place("distortion"), std::string(column) + " is too large", number_text(v),
                       "at most " + number_text(most) + " either way");
          return;
        }
  };
  within(out.smile_um, kMostSmile_nm, "smile_nm"), within(out.keystone_px, kMostKeystone_px, "keystone_px");
  for (auto& row : out.smile_um)
    for (double& v : row) v *= 1e-3;
  for (const double one : distinct(nm)) out.wavelength_um.push_back(1e-3 * one);
  out.sample = distinct(sample);
  return out;
}

/// Shifted centres must stay wavelengths.
void check_smile(const Record& instrument, const Instrument& out, Problems& problems) {
  for (const Band& band : out.bands) {
    const FocalPlane& plane = out.focal_planes[out.plane_of(band.center_um)];
    double least = std::min(0.0, plane.smile_um);
    for (const auto& row : plane.distortion.smile_um)
      least = std::min(least, *std::min_element(row.begin(), row.end()));
    if (least < 0 && band.center_um + least <= 2 * band.fwhm_um)
      problems.add(instrument.place("focal_plane"), "smile moves a band to within twice its width of 0",
                   number_text(1e3 * band.center_um) + " nm by " + number_text(1e3 * least) + " nm", "lower smile_nm");
  }
}

/// Rings by wavelength know nothing beyond their first and last.
void tell_of_ends(const Record& instrument, const Instrument& out, Problems& problems) {
  for (const FocalPlane& plane : out.focal_planes) {
    const auto& um = plane.spread.wavelength_um;
    if (!plane.spread.rings() || um.size() < 2) continue;
    std::size_t beyond = 0;
    for (const Band& band : out.bands)
      if (&out.focal_planes[out.plane_of(band.center_um)] == &plane)
        beyond += band.center_um < um.front() || band.center_um > um.back();
    if (beyond > 0)
      problems.tell(instrument.place("focal_plane"),
                    base::counted(beyond, "band lies", "bands lie") + " beyond the wavelengths of the spread of '" +
                        plane.name + "', " + number_text(1e3 * um.front()) + " to " + number_text(1e3 * um.back()) +
                        " nm, and take its first or last rings");
  }
}

std::array<double, 2> pair_of(const Record& record, const char* key) {
  const auto& values = record.numbers(key);
  return {values.front(), values.back()};
}

FocalPlane read_plane(const Record& record, double pitch_um, Problems& problems) {
  FocalPlane out;
  out.name = record.text("name");
  if (record.given("first_nm")) out.first_um = 1e-3 * record.number("first_nm");
  if (record.given("last_nm")) out.last_um = 1e-3 * record.number("last_nm");
  if (out.first_um >= out.last_um)
    problems.add(record.place("last_nm"), "last_nm must lie beyond first_nm", number_text(1e3 * out.last_um),
                 "exchange them");
  out.sigma_px = pair_of(record, "sigma_px"), out.detector_px = pair_of(record, "detector_px");
  out.smear_px = pair_of(record, "smear_px"), out.offset_px = pair_of(record, "offset_px");
  out.jitter_px = record.number("jitter_px");
  if (record.given("f_number")) {
    out.f_number = record.number("f_number"), out.obscuration = record.number("obscuration");
    out.pitch_um = record.given("pitch_um") ? record.number("pitch_um") : pitch_um;
    if (!(out.pitch_um > 0))
      problems.add(record.place("f_number"), "f_number needs the detector's pitch",
                   "neither here nor of the instrument", "add pitch_um");
  } else {
    for (const char* key : {"pitch_um", "obscuration"})
      if (record.given(key))
        problems.add(record.place(key), std::string("'") + key + "' goes with f_number", "", "remove it, or add that");
  }
  if (record.given("spread")) out.spread = read_spread(record, problems);
  if (record.given("distortion")) {
    out.distortion = read_distortion(record, problems);
    for (const char* key : {"smile_nm", "keystone_px"})
      if (record.given(key))
        problems.add(record.place(key), std::string("'") + key + "' and distortion exclude each other", "both",
                     "remove one");
  }
  out.smile_um = 1e-3 * record.number("smile_nm"), out.keystone_px = record.number("keystone_px");
  return out;
}

/// Reports bands that no plane sees, or two, and planes that see none.
void check_bands_seen(const Record& instrument, const Instrument& out, Problems& problems) {
  std::vector<int> seen(out.focal_planes.size(), 0);
  for (const Band& band : out.bands) {
    int count = 0;
    for (std::size_t i = 0; i < seen.size(); ++i)
      if (band.center_um >= out.focal_planes[i].first_um && band.center_um < out.focal_planes[i].last_um)
        ++count, ++seen[i];
    if (count == 1) continue;
    problems.add(instrument.place("focal_plane"), "every band must lie in one focal plane",
                 "the one at " + number_text(1e3 * band.center_um) + " nm lies in " + std::to_string(count),
                 "set first_nm and last_nm of each; a band at last_nm lies beyond it");
    return;
  }
  for (std::size_t i = 0; i < seen.size(); ++i)
    if (seen[i] == 0 && !out.bands.empty())
      problems.add(instrument.records("focal_plane")[i].where, "a focal plane sees no band",
                   "'" + out.focal_planes[i].name + "'", "correct first_nm and last_nm, or remove it");
}

}  // namespace

void read_focal_planes(const Record& instrument, Instrument& out, Problems& problems) {
  const auto& records = instrument.records("focal_plane");
  if (instrument.given("oversampling")) {
    out.oversampling = static_cast<int>(instrument.integer("oversampling"));
    if (out.oversampling % 2 == 0 || records.empty())
      problems.add(instrument.place("oversampling"),
                   records.empty() ? "oversampling goes with focal planes" : "oversampling must be odd",
                   std::to_string(out.oversampling),
                   records.empty() ? "remove it" : "give one more, so that a cell lies in the pixel's middle");
  }
  if (records.empty()) return;
  const double pitch_um = instrument.given("pitch_um") ? instrument.number("pitch_um") : 0;
  for (const Record& record : records) {
    out.focal_planes.push_back(read_plane(record, pitch_um, problems));
    if (out.focal_planes.back().name.empty()) out.focal_planes.back().name = std::to_string(out.focal_planes.size());
  }
  const std::size_t before = problems.count();
  check_bands_seen(instrument, out, problems);
  if (problems.count() == before) check_smile(instrument, out, problems), tell_of_ends(instrument, out, problems);
  const auto refuse = [&](bool given, const char* key, const char* why) {
    if (given) problems.add(instrument.place(key), std::string("'") + key + "' " + why, "", "remove it");
  };
  refuse(instrument.given("psf"), "psf", "and focal planes exclude each other");
  refuse(out.standard_error != StandardError::off, "standard_error", "is not known of pixels that share their samples");
  const bool smiles = std::any_of(out.focal_planes.begin(), out.focal_planes.end(),
                                  [](const FocalPlane& plane) { return plane.smiles(); });
  refuse(out.motion != PoseMotion::held, "motion",
         "means nothing with focal planes: their smear_px says how far it goes");
  refuse(smiles && !out.band_truth.empty(), "band_truth", "is not told of bands that smile");
  if (out.kind != InstrumentKind::framing && out.lines < 2)
    problems.add(instrument.place("lines"), "a scanner with focal planes needs two lines or more",
                 std::to_string(out.lines), "give more");
}

}  // namespace raycube::scene
