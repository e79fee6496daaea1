#include "scene_compiler/spectrum_file.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>
#include <span>

#include "host/base/text.h"
#include "scene_compiler/air_wavelength.h"
#include "scene_compiler/csv_file.h"
#include "scene_compiler/detector_joins.h"
#include "scene_compiler/document_values.h"
#include "scene_compiler/envi_library.h"
#include "scene_compiler/spectrometer_file.h"

namespace raycube::scene {
namespace {

using base::Problems;
using base::Where;

constexpr double kShortestUm = 0.05, kLongestUm = 1000.0;
constexpr double kNoData = 1e30;  ///< USGS marks what it deleted by -1.23e34
constexpr double kNoise = 0.05;   ///< spectrometers' values lie so far below 0 by noise
constexpr std::size_t kFewestOfDetector = 3, kFewestOfTable = 10;  ///< points from one step back to the next

bool is_air(const std::string& asked, const std::string& file_says, const std::string& file, Problems& problems) {
  const std::string medium = lower_case(asked.empty() ? file_says : asked);
  if (medium == "air") return true;
  if (!medium.empty() && medium != "vacuum")
    problems.add({file, 0, 0, ""}, "unknown medium", medium, "write # medium: air or # medium: vacuum");
  return false;
}

Material material_of(const std::vector<SpectrumPoint>& points, bool has_transmittance, bool air) {
  Material out;
  for (const auto& point : points) {
    const double wavelength_um = air ? vacuum_from_air_um(point.wavelength_um) : point.wavelength_um;
    out.reflectance.wavelength_um.push_back(wavelength_um);
    out.reflectance.value.push_back(point.reflectance);
    if (!has_transmittance) continue;
    out.transmittance.wavelength_um.push_back(wavelength_um);
    out.transmittance.value.push_back(point.transmittance);
  }
  return out;
}

constexpr const char* kDiffer = ", where they differ by ";
constexpr const char* kLeftOut = " without data left out";  ///< in a material's source, behind their number

bool is_data(double value) { return std::isfinite(value) && std::abs(value) < kNoData; }

/// Points that hold data; said in `source`, how many do not.
std::vector<SpectrumPoint> with_data(std::vector<SpectrumPoint> points, std::string& note) {
  const std::size_t all = points.size();
  std::erase_if(points, [](const SpectrumPoint& p) { return !is_data(p.reflectance) || !is_data(p.transmittance); });
  if (points.size() < all) note += ", " + base::counted(all - points.size(), "sample") + kLeftOut;
  return points;
}

/// Where wavelengths step back as those of detectors do, one spectrum; else the points as they are.
std::vector<SpectrumPoint> without_overlaps(std::vector<SpectrumPoint> points, std::size_t fewest,
                                            const std::string& file, Problems& problems) {
  auto joined = joined_detectors(points, fewest, file, problems);
  return joined ? std::move(*joined) : std::move(points);
}

/// What is told of spectra of one family: each sentence once, the first of those that differ in a figure.
class FamilyNotices {
 public:
  /// A spectrum as `make` has it, which reports to what it is given; nullopt after reporting.
  template <class Make>
  std::optional<Material> member(Make make, Problems& problems) {
    Problems own;
    auto out = make(own);
    if (!out || !own.empty()) {
      make(problems);
      return std::nullopt;
    }
    for (const std::string& notice : own.notices()) {
      const std::string kind = notice.substr(0, notice.find(kDiffer));
      const auto [entry, fresh] = count_.try_emplace(kind, 0);
      if (entry->second++ == 0) first_.push_back({kind, notice});
    }
    return out;
  }
  void tell(Problems& problems) const {
    constexpr std::size_t kMost = 20;
    for (std::size_t i = 0; i < std::min(kMost, first_.size()); ++i) {
      const std::size_t spectra = count_.at(first_[i].first);
      problems.tell({}, first_[i].second + (spectra > 1 ? "; so for " + std::to_string(spectra) + " spectra" : ""));
    }
    if (first_.size() > kMost)
      problems.tell({}, base::counted(first_.size() - kMost, "more notice") + " of its spectra");
  }

 private:
  std::map<std::string, std::size_t> count_;
  std::vector<std::pair<std::string, std::string>> first_;  ///< kind and notice, in the order they came
};

/// The material's `scale` before what the file declares, which is told where the two are not the same.
double scale_of(const SpectrumRequest& request, std::optional<double> declared, Problems& problems) {
  if (request.scale && declared && std::abs(*request.scale - *declared) > 1e-9 * *declared)
    problems.tell(request.asked_by, "'scale' is taken, " + number_text(*request.scale) + ", and not that of " +
                                        request.file + ", " + number_text(*declared));
  return request.scale.value_or(declared.value_or(1.0));
}

/// Which column of a CSV is the wavelength, and its unit in um; nullopt after reporting.
std::optional<std::pair<std::size_t, double>> wavelength_column(const CsvFile& csv, Problems& problems) {
  for (std::size_t i = csv.columns.size(); i-- > 0;)
    if (const auto unit = wavelength_unit_um(csv.columns[i])) return std::pair(i, *unit);
  problems.add({csv.file, csv.header_line, 0, ""}, "no wavelength column", csv.columns_text(),
               "name one wavelength_nm or wavelength_um");
  return std::nullopt;
}

/// The spectrum of a column, and of one of transmittance where there is one.
std::optional<Material> column_spectrum(const CsvFile& csv, std::pair<std::size_t, double> wavelength,
                                        std::size_t reflectance, std::optional<std::size_t> transmittance,
                                        const SpectrumRequest& request, Problems& problems) {
  const auto factor = [&](std::size_t column) {
    return scale_of(request, says_percent(csv.columns[column]) ? std::optional(0.01) : std::nullopt, problems);
  };
  const double scale = factor(reflectance), through = transmittance ? factor(*transmittance) : scale;
  std::vector<SpectrumPoint> points;
  std::optional<std::pair<std::size_t, std::size_t>> unread;  // row and column of the first cell that is no number
  std::size_t more_unread = 0;
  const auto value = [&](std::size_t row, std::size_t column) -> std::optional<double> {
    const auto number = parse_number(csv.rows[row][column]);
    if (number && (column != wavelength.first || std::isfinite(*number))) return number;
    if (unread)
      ++more_unread;
    else
      unread = {row, column};
    return std::nullopt;
  };
  for (std::size_t row = 0; row < csv.rows.size(); ++row) {
    const auto w = value(row, wavelength.first), r = value(row, reflectance);
    const auto t = transmittance ? value(row, *transmittance) : std::optional(0.0);
    if (w && r && t)
      points.push_back({*w * wavelength.second,
                        is_data(*r) ? *r * scale : NAN,
                        is_data(*t) ? *t * through : NAN,
                        {csv.file, csv.row_lines[row], 0, ""}});
  }
  if (unread) {
    const std::string& cell = csv.rows[unread->first][unread->second];
    problems.add(csv.at(unread->first, unread->second), "not a number",
                 (cell.empty() ? "nothing" : "'" + cell + "'") +
                     (more_unread > 0 ? ", and in " + base::counted(more_unread, "more cell") : ""),
                 "give a number like 0.25, nan where there is none, or remove the line");
    return std::nullopt;
  }
  std::string note;
  points = with_data(std::move(points), note);
  if (!points.empty() && points.front().wavelength_um < points.back().wavelength_um)
    points = without_overlaps(std::move(points), kFewestOfTable, csv.file, problems);
  const bool sound = check_spectrum(points, csv.file, problems);
  const auto comment = [&](const char* key) {
    const auto found = csv.comments.find(key);
    return found == csv.comments.end() ? std::string() : found->second;
  };
  const bool air = is_air(request.medium, comment("medium"), csv.file, problems);
  if (!sound) return std::nullopt;
  Material out = material_of(points, transmittance.has_value(), air);
  out.source = (comment("source").empty() ? comment("source file") : comment("source")) + note;
  return out;
}

std::optional<Material> read_csv_spectrum(const SpectrumRequest& request, Problems& problems) {
  const auto csv = read_csv(request.file, request.asked_by, problems);
  if (!csv) return std::nullopt;
  const auto wavelength = wavelength_column(*csv, problems);
  const auto reflectance = csv->column(request.reflectance_column);
  if (!reflectance)
    problems.add({csv->file, csv->header_line, 0, ""}, "no column '" + request.reflectance_column + "'",
                 csv->columns_text(), "name it, or give reflectance_column");
  if (!wavelength || !reflectance) return std::nullopt;
  return column_spectrum(*csv, *wavelength, *reflectance, csv->column(request.transmittance_column), request, problems);
}

/// A line of a library.
std::optional<Material> library_spectrum(const EnviLibrary& library, std::size_t line, const SpectrumRequest& request,
                                         Problems& problems) {
  const double scale = scale_of(request, library.scale, problems);
  std::vector<SpectrumPoint> points;
  for (std::size_t i = 0; i < library.wavelength_um.size(); ++i)
    points.push_back({library.wavelength_um[i],
                      is_data(library.spectra[line][i]) ? library.spectra[line][i] * scale : NAN,
                      0,
                      {request.file, 0, 0, "spectrum '" + library.names[line] + "', sample " + std::to_string(i + 1)}});
  std::string note;
  points = without_overlaps(with_data(std::move(points), note), kFewestOfDetector, request.file, problems);
  if (!check_spectrum(points, request.file, problems)) return std::nullopt;
  Material out = material_of(points, false, is_air(request.medium, "", request.file, problems));
  if (!note.empty() && !library.left_out.empty()) note += " (" + library.left_out + ")";
  out.source =
      std::filesystem::path(request.file).filename().string() + ", spectrum '" + library.names[line] + "'" + note;
  return out;
}

std::optional<Material> read_library_spectrum(const SpectrumRequest& request, Problems& problems) {
  const auto library = read_envi_library(request.file, request.asked_by, problems);
  if (!library) return std::nullopt;
  std::size_t line = 0;
  if (!request.spectrum.empty() || library->names.size() != 1) {
    const auto found = std::find(library->names.begin(), library->names.end(), request.spectrum);
    line = static_cast<std::size_t>(found - library->names.begin());
    if (found == library->names.end()) {
      std::string names;
      for (std::size_t i = 0; i < library->names.size() && i < 8; ++i) names += (i ? ", " : "") + library->names[i];
      if (library->names.size() > 8) names += ", ... " + std::to_string(library->names.size()) + " in all";
      problems.add(request.asked_by, "spectral library has no spectrum of that name",
                   request.spectrum.empty() ? "no 'spectrum' key" : "'" + request.spectrum + "'", "it holds: " + names);
      return std::nullopt;
    }
    if (const auto again = std::find(found + 1, library->names.end(), request.spectrum);
        again != library->names.end()) {
      problems.add(request.asked_by, "two spectra of the library have one name",
                   "'" + request.spectrum + "' is line " + std::to_string(line + 1) + " and " +
                       std::to_string(again - library->names.begin() + 1) + " of " + request.file,
                   "name each once in its header");
      return std::nullopt;
    }
  }
  return library_spectrum(*library, line, request, problems);
}

/// Of a spectrometer's file: detectors joined, else sorted; values at one wavelength averaged, noise below 0 as 0.
std::optional<Material> spectrometer_spectrum(const SpectrometerFile& file, const SpectrumRequest& request,
                                              Problems& problems) {
  if (!file.unread.empty()) {
    problems.add({request.file, file.unread[0], 0, ""}, "not a row of numbers",
                 file.unread.size() > 1 ? "and " + std::to_string(file.unread.size() - 1) + " more" : "",
                 "correct or remove the line");
    return std::nullopt;
  }
  if (file.decimal_commas > 0)
    problems.tell({request.file, 0, 0, ""},
                  base::counted(file.decimal_commas, "row") + " with decimal commas read as such");
  const double scale = scale_of(request, file.scale != 1 ? std::optional(file.scale) : std::nullopt, problems);
  std::string note;
  std::vector<SpectrumPoint> points;
  for (std::size_t i = 0; i < file.value.size(); ++i)
    points.push_back({file.wavelength_um[i],
                      is_data(file.value[i]) ? file.value[i] * scale : NAN,
                      0,
                      {request.file, file.line[i], 0, ""}});
  points = with_data(std::move(points), note);
  if (auto joined = joined_detectors(points, kFewestOfDetector, request.file, problems)) {
    points = std::move(*joined);
  } else {
    std::stable_sort(points.begin(), points.end(),
                     [](const SpectrumPoint& a, const SpectrumPoint& b) { return a.wavelength_um < b.wavelength_um; });
    problems.tell({request.file, 0, 0, ""}, "wavelengths go up and down; sorted");
  }
  std::vector<SpectrumPoint> apart;
  std::size_t noisy = 0;
  for (std::size_t first = 0; first < points.size();) {
    SpectrumPoint mean = points[first];
    std::size_t next = first + 1;
    for (; next < points.size() && points[next].wavelength_um == mean.wavelength_um; ++next)
      mean.reflectance += points[next].reflectance;
    mean.reflectance /= static_cast<double>(next - first);
    if (mean.reflectance < 0 && mean.reflectance >= -kNoise) mean.reflectance = 0, ++noisy;
    apart.push_back(mean);
    first = next;
  }
  if (noisy > 0) note += ", " + base::counted(noisy, "value") + " below 0 taken as 0";
  if (!check_spectrum(apart, request.file, problems)) return std::nullopt;
  Material out = material_of(apart, false, is_air(request.medium, "", request.file, problems));
  out.source = file.kind + ", " + file.name + note;
  return out;
}

/// Tells that spectra lack samples, once for a file.
void tell_left_out(const std::string& file, std::span<const Material> spectra, Problems& problems) {
  const auto lacks = [](const Material& spectrum) { return spectrum.source.find(kLeftOut) != std::string::npos; };
  const auto lacking = std::count_if(spectra.begin(), spectra.end(), lacks);
  const auto why = [&] {  // behind the words in the first one's source
    const std::string& source = std::find_if(spectra.begin(), spectra.end(), lacks)->source;
    return source.substr(source.find(kLeftOut) + std::string(kLeftOut).size());
  };
  if (lacking > 0 && spectra.size() == 1)
    problems.tell({file, 0, 0, ""},
                  spectra[0].source.substr(spectra[0].source.rfind(", ", spectra[0].source.find(kLeftOut)) + 2));
  else if (lacking > 0)
    problems.tell({file, 0, 0, ""}, std::to_string(lacking) + " of " + std::to_string(spectra.size()) + " spectra " +
                                        (lacking == 1 ? "has" : "have") + " samples without data, which are left out" +
                                        why());
}

/// Whether the file is a library; a header in its place is reported.
enum class FileKind { csv, library, header };
FileKind kind_of(const SpectrumRequest& request, Problems& problems) {
  const std::string extension = lower_case(std::filesystem::path(request.file).extension().string());
  if (extension == ".sli") return FileKind::library;
  if (extension != ".hdr") return FileKind::csv;
  problems.add(request.asked_by, "a header is not the library", request.file,
               "name the .sli file; its .hdr is found beside it");
  return FileKind::header;
}

std::optional<Material> read_one(const SpectrumRequest& request, Problems& problems) {
  switch (kind_of(request, problems)) {
    case FileKind::library:
      return read_library_spectrum(request, problems);
    case FileKind::csv: {
      bool known = false;
      const auto file = read_spectrometer_file(request.file, request.wavelengths, request.asked_by, known, problems);
      if (file) return spectrometer_spectrum(*file, request, problems);
      return known ? std::nullopt : read_csv_spectrum(request, problems);
    }
    case FileKind::header:
      break;
  }
  return std::nullopt;
}

/// Whether a column's first word names what is no reflectance: another quantity, or how well one is known.
bool is_other_quantity(const std::string& column) {
  static const std::set<std::string> kOthers = {
      "transmittance", "transmission", "absorptance", "absorbance", "emissivity", "emittance", "radiance",
      "irradiance",    "std",          "stdev",       "stddev",     "sd",         "sigma",     "variance",
      "uncertainty",   "error",        "count",       "counts",     "dn",         "log",       "fwhm",
      "fwhm_nm",       "fwhm_um"};
  const std::string word = column.substr(0, column.find_first_of(" ([/,;:"));
  return kOthers.count(word) > 0 || wavelength_unit_um(column).has_value();
}

std::vector<Material> csv_family(const SpectrumRequest& request, Problems& problems) {
  std::vector<Material> out;
  const auto csv = read_csv(request.file, request.asked_by, problems);
  const auto wavelength = csv ? wavelength_column(*csv, problems) : std::nullopt;
  if (!wavelength) return out;
  FamilyNotices notices;
  for (std::size_t column = 0; column < csv->columns.size(); ++column) {
    if (column == wavelength->first) continue;
    if (const std::string& name = csv->columns[column]; is_other_quantity(name)) {
      problems.add({csv->file, csv->header_line, 0, ""}, "no reflectance", "column '" + name + "'",
                   "remove it: each column beside the wavelength is taken for a spectrum of reflectance");
      return {};
    }
    auto member = notices.member(
        [&](Problems& own) { return column_spectrum(*csv, *wavelength, column, std::nullopt, request, own); },
        problems);
    if (!member) return {};
    const std::size_t note = member->source.rfind(", ");  // of samples left out
    const bool noted = note != std::string::npos && member->source.ends_with(kLeftOut);
    member->source = std::filesystem::path(csv->file).filename().string() + ", column '" + csv->columns[column] + "'" +
                     (noted ? member->source.substr(note) : "");
    out.push_back(std::move(*member));
  }
  notices.tell(problems);
  return out;
}

std::vector<Material> library_family(const SpectrumRequest& request, Problems& problems) {
  std::vector<Material> out;
  const auto library = read_envi_library(request.file, request.asked_by, problems);
  FamilyNotices notices;
  for (std::size_t line = 0; library && line < library->names.size(); ++line) {
    auto member =
        notices.member([&](Problems& own) { return library_spectrum(*library, line, request, own); }, problems);
    if (!member) return {};
    out.push_back(std::move(*member));
  }
  notices.tell(problems);
  return out;
}

}  // namespace

std::optional<double> wavelength_unit_um(const std::string& column) {
  if (column == "wavelength_um") return 1.0;
  if (column == "wavelength_nm") return 1e-3;
  return std::nullopt;
}

bool check_spectrum(const std::vector<SpectrumPoint>& points, const std::string& file, Problems& problems) {
  struct Cause {
    Where where;
    std::string what, found, way_out;
    std::size_t points = 0;
  };
  std::vector<Cause> causes;  // each told once, by the first point that has it
  const auto report = [&](const SpectrumPoint& point, const std::string& what, const std::string& found,
                          const std::string& way_out) {
    for (Cause& cause : causes)
      if (cause.what == what) return void(++cause.points);
    causes.push_back({point.where, what, found, way_out, 1});
  };
  double largest = 0;
  for (const auto& p : points)
    if (is_data(p.reflectance) && is_data(p.transmittance))
      largest = std::max({largest, p.reflectance, p.transmittance});
  const std::string scaled = largest <= 1.5   ? "correct it, or give `scale` if the file is in percent"
                             : largest <= 150 ? "give scale = 0.01 if the file is in percent, else correct it"
                             : largest <= 15000
                                 ? "give scale = 1e-4 if its values are 10 000 times reflectance, else correct it"
                                 : "correct it, or give `scale`";
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto& p = points[i];
    if (!std::isfinite(p.wavelength_um) || p.wavelength_um < kShortestUm || p.wavelength_um > kLongestUm)
      report(p, "wavelength outside 0.05 .. 1000 um", number_text(p.wavelength_um) + " um",
             "check the unit in the column's name or header");
    else if (i > 0 && p.wavelength_um == points[i - 1].wavelength_um)
      report(p, "wavelength is given twice", number_text(p.wavelength_um) + " um", "keep one of the two values");
    else if (i > 0 && p.wavelength_um < points[i - 1].wavelength_um)
      report(p, "wavelengths are not ascending",
             number_text(p.wavelength_um) + " um after " + number_text(points[i - 1].wavelength_um) + " um",
             "sort the file by wavelength; where detectors overlap, leave one of them out");
    if (!(p.reflectance >= 0 && p.reflectance <= 1))
      report(p, "reflectance outside 0 .. 1", number_text(p.reflectance), scaled);
    if (!(p.transmittance >= 0 && p.transmittance <= 1))
      report(p, "transmittance outside 0 .. 1", number_text(p.transmittance), scaled);
    // Rounded columns may sum to a few 1e-7 above 1.
    else if (p.reflectance <= 1 && p.reflectance + p.transmittance > 1 + 1e-6)
      report(p, "reflectance + transmittance above 1",
             number_text(p.reflectance) + " + " + number_text(p.transmittance),
             "energy must not be gained: correct the file");
  }
  for (const Cause& cause : causes)
    problems.add(cause.where, cause.what,
                 cause.found + (cause.points > 1 ? ", and at " + base::counted(cause.points - 1, "more point") : ""),
                 cause.way_out);
  if (points.size() < 2) {
    problems.add({file, 0, 0, ""}, "a spectrum needs at least two points", std::to_string(points.size()),
                 "give more, or a constant `reflectance`");
    return false;
  }
  return causes.empty();
}

std::optional<Material> read_spectrum(const SpectrumRequest& request, Problems& problems) {
  std::optional<Material> out = read_one(request, problems);
  if (out) tell_left_out(request.file, {&*out, 1}, problems);
  return out;
}

std::vector<Material> read_family(const SpectrumRequest& request, Problems& problems) {
  constexpr std::size_t kLeast = 2, kMost = 4096;
  const FileKind kind = kind_of(request, problems);
  if (kind == FileKind::header) return {};
  const std::size_t before = problems.count();
  std::vector<Material> out =
      kind == FileKind::library ? library_family(request, problems) : csv_family(request, problems);
  if (problems.count() == before && (out.size() < kLeast || out.size() > kMost)) {
    problems.add(request.asked_by, "a family has 2 to 4096 spectra", std::to_string(out.size()) + " in " + request.file,
                 "give more, or fewer; one spectrum is `file`");
    return {};
  }
  tell_left_out(request.file, out, problems);
  return out;
}

std::vector<Material> read_spectra(const SpectrumRequest& request, Problems& problems) {
  const FileKind kind = kind_of(request, problems);
  if (kind == FileKind::header) return {};
  if (kind == FileKind::library) return library_family(request, problems);
  bool known = false;
  const auto file = read_spectrometer_file(request.file, request.wavelengths, request.asked_by, known, problems);
  if (known && !file) return {};
  if (!file) {
    const auto csv = read_csv(request.file, request.asked_by, problems);
    if (!csv) return {};
    if (std::find(csv->columns.begin(), csv->columns.end(), request.transmittance_column) == csv->columns.end())
      return csv_family(request, problems);
  }
  auto one = file ? spectrometer_spectrum(*file, request, problems) : read_csv_spectrum(request, problems);
  if (!one) return {};
  if (one->name.empty() && file) one->name = file->name;
  return {std::move(*one)};
}

}  // namespace raycube::scene
