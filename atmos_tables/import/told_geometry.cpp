#include "atmos_tables/import/told_geometry.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <optional>

#include "atmos_tables/import/import_file.h"
#include "atmos_tables/import/text_lines.h"

namespace raycube::atmos::imported {

namespace {

namespace fs = std::filesystem;

constexpr double kSameAngle_deg = 0.05, kSameHeight_m = 0.5;

bool tells(const Imported& file) {
  return !file.runs.empty() && std::all_of(file.runs.begin(), file.runs.end(), only_tells);
}

/// Formats that name no geometry at all, and those that may lack some of it.
bool names_none(const Imported& file) { return one_of(file.format, {"chn", "acd", "acd-binary", "csv"}); }
bool may_lack(const Imported& file) {
  return !tells(file) && (names_none(file) || one_of(file.format, {"tape7", "7sc", "json"}));
}

std::string stem_of(const std::string& path) { return fs::path(path).replace_extension().lexically_normal().string(); }

/// Fills one geometry from another; problems where both say a thing and disagree.
class Filler {
 public:
  Filler(Run& run, const Imported& file, const Imported& teller, base::Problems& problems)
      : run_(run), file_(file), teller_(teller), problems_(problems) {}

  void fill(const Geometry& told) {
    Geometry& g = run_.geometry;
    take(g.sensor_height_m, told.sensor_height_m, kSameHeight_m, "the sensor's height", "m");
    take(g.path_end_height_m, told.path_end_height_m, kSameHeight_m, "the height of the path's end", "m");
    take(g.path_length_m, told.path_length_m, HUGE_VAL, "the path's length", "m");
    take(g.sight_zenith_deg, told.sight_zenith_deg, kSameAngle_deg, "the zenith of the line of sight", "deg");
    take(g.view_zenith_deg, told.view_zenith_deg, HUGE_VAL, "the view zenith", "deg");
    // Listings print it with refraction, which grows as the tangent: 0.015 deg at 45.
    const double low = std::min(told.sun_zenith_deg.value_or(0), 85.0) * std::numbers::pi / 180;
    take(g.sun_zenith_deg, told.sun_zenith_deg, std::max(kSameAngle_deg, 0.02 + 0.02 * std::tan(low)),
         "the sun's zenith", "deg");
    take(g.relative_azimuth_deg, told.relative_azimuth_deg, HUGE_VAL, "the relative azimuth", "deg");
    std::optional<double> azimuth = told.sun_azimuth_deg;  // 359.99 and 0.01 are one
    if (azimuth && g.sun_azimuth_deg)
      azimuth = *g.sun_azimuth_deg + std::remainder(*azimuth - *g.sun_azimuth_deg, 360.0);
    take(g.sun_azimuth_deg, azimuth, kSameAngle_deg, "the sun's azimuth", "deg");
    take(g.ground_height_m, told.ground_height_m, kSameHeight_m, "the ground's height", "m");
    take(g.earth_sun_factor, told.earth_sun_factor, 1e-4, "the earth-sun factor", "");
    if (g.day_of_year && told.day_of_year && *g.day_of_year != *told.day_of_year)
      disagree("the day of the year", std::to_string(*g.day_of_year), std::to_string(*told.day_of_year));
    if (!g.day_of_year) g.day_of_year = told.day_of_year;
    if (taken_) run_.notes.push_back(kToldBy + teller_.file);
  }

 private:
  void take(std::optional<double>& own, const std::optional<double>& told, double within, const char* what,
            const char* unit) {
    if (!told) return;
    if (own && std::abs(*own - *told) > within) disagree(what, shown(*own) + " " + unit, shown(*told) + " " + unit);
    if (!own) own = told, taken_ = true;
  }
  void disagree(const char* what, const std::string& own, const std::string& told) {
    problems_.add({file_.file, 0, 0, run_.mode}, std::string(what) + " is not that of " + teller_.file,
                  own + " against " + told, "give the listing or input of the same run");
  }

  Run& run_;
  const Imported &file_, &teller_;
  base::Problems& problems_;
  bool taken_ = false;
};

void tell(Imported& file, const Imported& teller, base::Problems& problems) {
  if (teller.runs.size() != 1 && teller.runs.size() != file.runs.size()) {
    problems.add({file.file, 0, 0, ""}, "not as many lines of sight as in " + teller.file,
                 std::to_string(file.runs.size()) + " against " + std::to_string(teller.runs.size()),
                 "give the listing or input of the same run");
    return;
  }
  for (std::size_t i = 0; i < file.runs.size(); ++i)
    Filler(file.runs[i], file, teller, problems).fill(teller.runs[teller.runs.size() == 1 ? 0 : i].geometry);
}

/// The listing or input of a file that nobody named, where its name says that it is of the same run. One that cannot be
/// read is none: it was not asked for.
std::optional<Imported> beside(const Imported& file, std::vector<std::string>& notes) {
  for (const char* end : {".tp6", ".json"}) {
    const std::string path = stem_of(file.file) + end;
    if (!fs::is_regular_file(path)) continue;
    try {
      Imported found = import_file(path);
      if (tells(found)) return found;
    } catch (const base::Error& error) {
      // A JSON of that name may be anything.
      if (std::string(end) == ".tp6") notes.push_back(std::string("beside it, and not read: ") + error.what());
    }
  }
  return std::nullopt;
}

}  // namespace

bool only_tells(const Run& run) { return run.mode == "listing" || run.mode == "input"; }

void tell_geometry(std::vector<Imported>& files) {
  std::vector<const Imported*> tellers;
  for (const Imported& file : files)
    if (tells(file)) tellers.push_back(&file);
  // A listing knows more than the input it repeats.
  std::stable_partition(tellers.begin(), tellers.end(), [](const Imported* t) { return t->format == "tape6"; });
  base::Problems problems;
  for (Imported& file : files) {
    if (!may_lack(file)) continue;
    bool told = false;
    for (const Imported* teller : tellers)
      if (tellers.size() == 1 || stem_of(teller->file) == stem_of(file.file))
        tell(file, *teller, problems), told = true;
    if (told || !tellers.empty() || !names_none(file)) continue;
    std::vector<std::string> notes;
    if (const auto found = beside(file, notes)) tell(file, *found, problems);
    for (Run& run : file.runs) run.notes.insert(run.notes.end(), notes.begin(), notes.end());
  }
  problems.throw_if_any();
}

}  // namespace raycube::atmos::imported
