#include "atmos_tables/import/modtran_tape6.h"

#include <array>
#include <cmath>
#include <initializer_list>

#include "atmos_tables/import/conversions.h"
#include "atmos_tables/import/text_lines.h"

namespace raycube::atmos::imported {

namespace {

using Words = std::vector<std::string_view>;

/// A point of the table of the sun along a path: height above sea, angles.
struct SunPoint {
  double height_km, sun_zenith_deg, path_zenith_deg, relative_azimuth_deg;
};

struct Sight {
  int line = 0;
  Geometry geometry;
  std::vector<SunPoint> sun;
  std::optional<double> true_azimuth_deg;
};

class ListingReader {
 public:
  explicit ListingReader(const std::string& path) : path_(path), lines_(read_lines(path)) {}

  Imported read() {
    Imported out{path_, "MODTRAN", "tape6", {}};
    bool any = false;
    for (at_ = 0; at_ < lines_.size() && problems_.count() < kEnoughProblems; ++at_) {
      any = any || holds("MODTRAN") || holds("CARD 1 ");
      if (holds("CARD 1  **"))
        close(out), case_ = {};
      else
        line(out);
    }
    close(out);
    if (out.runs.empty() && problems_.empty())
      problems_.add({path_, 0, 0, ""}, "no SUMMARY OF LINE-OF-SIGHT GEOMETRY", any ? "" : "nothing of MODTRAN",
                    "the listing is cut short, or its run failed; give the .tp6 of the run");
    problems_.throw_if_any();
    return out;
  }

 private:
  /// What holds for all lines of sight of one case.
  struct Case {
    std::optional<double> ground_height_m, earth_sun_factor, asked_sensor_height_m;
    std::optional<int> day_of_year;
    bool sun = false;
    std::vector<Sight> sights;
  };

  base::Where here() const { return {path_, static_cast<int>(at_) + 1, 0, ""}; }
  bool holds(std::string_view text) const { return lines_[at_].find(text) != std::string::npos; }

  /// The first word behind `label` and what closes it ("=", ":"); nothing where the line has no such label.
  std::optional<Number> after(std::string_view label, std::string_view close) {
    const std::string& text = lines_[at_];
    std::size_t found = text.find(label);
    if (found == std::string::npos) return std::nullopt;
    found = text.find(close, found + label.size());
    if (found == std::string::npos) return std::nullopt;
    const Words words = split_blanks(std::string_view(text).substr(found + close.size()));
    return need_number(words.empty() ? std::string_view() : words[0], here(), std::string(label), problems_, true);
  }

  void line(Imported& out) {
    if (const auto ground = after("GNDALT", "=")) case_.ground_height_m = m_from_km(ground->value);
    if (const auto day = after("DAY OF THE YEAR", "=")) take_day(*day);
    if (const auto factor = after("SOLAR IRRADIANCE FACTOR FOR DAY", ":")) take_factor(*factor);
    if (holds("SOURCE IS THE SUN")) case_.sun = true;
    if (holds("OBSERVER ALTITUDE (KM)")) lowered();
    if (holds("LINE-OF-SIGHT") && holds("GEOMETRY CALCULATION")) {
      summary();
    } else if (holds("SOLAR PATH GEOMETRY TABLE") && holds("LINE-OF-SIGHT")) {
      sun_table();
    } else if (holds("Line-of-Sight No.")) {
      located_ = sight_named("Line-of-Sight No.");
    } else if (holds("True Azimuth at") && located_ < case_.sights.size()) {
      const Words words = split_blanks(lines_[at_]);
      case_.sights[located_].true_azimuth_deg = need_number(words[0], here(), "True Azimuth", problems_, true).value;
    } else if (holds("CARD 3  **")) {
      case_.asked_sensor_height_m.reset();
    } else if (holds("CARD 5 **")) {
      close(out);  // what follows may repeat the path alone: ground and day stay
    }
  }

  /// Index of the line of sight whose number stands behind `label`; of the last one where none does.
  std::size_t sight_named(std::string_view label) {
    const std::size_t last = case_.sights.empty() ? 0 : case_.sights.size() - 1, found = lines_[at_].find(label);
    if (found == std::string::npos) return last;
    const Words words = split_blanks(std::string_view(lines_[at_]).substr(found + label.size()));
    const Number number = read_number(words.empty() ? std::string_view() : words[0]);
    const auto whole = number.good() ? whole_number(number.value, 1, kMostNumbered) : std::nullopt;
    return whole ? static_cast<std::size_t>(*whole) - 1 : last;
  }

  void take_day(const Number& day) {
    case_.day_of_year = whole_number(day.value, 1, 366);
    if (day.good() && !case_.day_of_year && day.value != 0)
      problems_.add(here(), "the day of the year is none", shown(day.value), "the listing is damaged");
  }

  void take_factor(const Number& factor) {
    // The earth's orbit: 0.967 in July to 1.034 in January.
    if (factor.good() && !(factor.value > 0.95 && factor.value < 1.05))
      problems_.add(here(), "the earth-sun factor is none of an orbit of the earth", shown(factor.value),
                    "the listing is damaged");
    case_.earth_sun_factor = factor.value;
  }

  /// `H1ALT   OBSERVER ALTITUDE (KM)   20.09900   19.00000`: asked for, and what the profile reaches.
  void lowered() {
    const Words words = split_blanks(lines_[at_]);
    if (words.size() < 2) return;
    const Number asked = need_number(words[words.size() - 2], here(), "OBSERVER ALTITUDE", problems_, true);
    if (asked.good()) case_.asked_sensor_height_m = m_from_km(asked.value);
  }

  /// The lines `LABEL = value UNIT` below the heading, up to the next empty line after the first of them.
  void summary() {
    Sight sight;
    sight.line = static_cast<int>(at_) + 1;
    Geometry& g = sight.geometry;
    std::optional<double> back_zenith;
    bool begun = false;
    for (++at_; at_ < lines_.size(); ++at_) {
      const Words words = split_blanks(lines_[at_]);
      if (words.empty() && begun) break;
      if (words.size() < 3 || words[1] != "=") continue;
      begun = true;
      const auto is = [&](std::initializer_list<const char*> names) {
        for (const char* name : names)
          if (words[0] == name) return true;
        return false;
      };
      if (!is({"H1ALT", "H1", "H2ALT", "H2", "OBSZEN", "ANGLE", "HRANGE", "RANGE", "BCKZEN", "PHI"})) continue;
      const Number number = need_number(words[2], here(), std::string(words[0]), problems_, true);
      if (is({"H1ALT", "H1"})) g.sensor_height_m = m_from_km(number.value);
      if (is({"H2ALT", "H2"})) g.path_end_height_m = m_from_km(number.value);
      if (is({"HRANGE", "RANGE"})) g.path_length_m = m_from_km(number.value);
      if (is({"OBSZEN", "ANGLE"})) g.sight_zenith_deg = number.value;
      if (is({"BCKZEN", "PHI"})) back_zenith = number.value;
    }
    if (!g.sensor_height_m || !g.sight_zenith_deg || !g.path_end_height_m)
      problems_.add({path_, sight.line, 0, ""}, "the line of sight lacks heights or zenith (H1ALT, H2ALT, OBSZEN)", "",
                    "the listing is cut short");
    else if (*g.sight_zenith_deg > 90)
      g.view_zenith_deg = back_zenith;  // towards the observer, seen from the path's end: refraction and all
    case_.sights.push_back(std::move(sight));
    if (at_ < lines_.size()) --at_;
  }

  /// Rows of a number, height, angle subtended, sun's zenith, path's zenith, relative azimuth, scattering angle.
  void sun_table() {
    const std::size_t index = sight_named("PATH No.");
    if (index >= case_.sights.size()) return;
    constexpr std::size_t kSunFields = 7;
    Sight& sight = case_.sights[index];
    bool begun = false;
    for (++at_; at_ < lines_.size(); ++at_) {
      const Words words = split_blanks(lines_[at_]);
      const bool row = words.size() >= kSunFields && read_number(words[0]).good() && read_number(words[1]).good();
      if (!row && begun) break;
      if (!row) continue;
      begun = true;
      std::array<double, kSunFields> number{};
      for (std::size_t i = 0; i < kSunFields; ++i)
        number[i] = need_number(words[i], here(), "the sun along the path", problems_, true).value;
      if (number[0] != static_cast<double>(sight.sun.size() + 1)) {
        problems_.add(here(), "points along the path do not follow each other",
                      shown(number[0]) + " after " + std::to_string(sight.sun.size()), "the listing is damaged");
        break;
      }
      if (!(number[3] >= 0 && number[3] <= 180 && number[4] >= 0 && number[4] <= 180 && std::abs(number[5]) <= 360))
        problems_.add(here(), "an angle along the path is none",
                      shown(number[3]) + ", " + shown(number[4]) + ", " + shown(number[5]), "the listing is damaged");
      sight.sun.push_back({number[1], number[3], number[4], number[5]});
    }
    if (at_ < lines_.size()) --at_;
  }

  void close(Imported& out) {
    for (Sight& sight : case_.sights) {
      Run run;
      run.mode = "listing";
      Geometry& g = run.geometry = std::move(sight.geometry);
      g.ground_height_m = case_.ground_height_m, g.day_of_year = case_.day_of_year;
      g.earth_sun_factor = case_.earth_sun_factor;
      if (case_.sun && sight.sun.empty())
        problems_.add({path_, sight.line, 0, ""}, "the line of sight has no table of the sun along it", "",
                      "the listing is cut short");
      if (!sight.sun.empty()) take_sun(sight, g);
      if (case_.asked_sensor_height_m && g.sensor_height_m && *case_.asked_sensor_height_m > *g.sensor_height_m) {
        run.notes.push_back("the profile ends at " + shown(*g.sensor_height_m) + " m; the sensor was asked for at " +
                            shown(*case_.asked_sensor_height_m) + " m, above all air");
        g.sensor_height_m = case_.asked_sensor_height_m;
      }
      run.notes.push_back("a listing, no spectrum: it tells what the .chn, .acd or .csv of the run lacks");
      if (case_.sights.size() > 1)
        run.notes.push_back("line of sight " + std::to_string(&sight - case_.sights.data() + 1));
      out.runs.push_back(std::move(run));
    }
    case_.sights.clear();
  }

  static void take_sun(const Sight& sight, Geometry& g) {
    const bool down = g.sight_zenith_deg && *g.sight_zenith_deg > 90;
    const SunPoint &observer = sight.sun.front(), &seen = down ? sight.sun.back() : observer;
    g.sun_zenith_deg = seen.sun_zenith_deg;
    g.relative_azimuth_deg = down ? relative_azimuth_deg_from_modtran(seen.relative_azimuth_deg)
                                  : sky_relative_azimuth_deg_from_modtran(seen.relative_azimuth_deg);
    if (sight.true_azimuth_deg)
      g.sun_azimuth_deg = azimuth_deg_0_to_360(*sight.true_azimuth_deg + observer.relative_azimuth_deg);
  }

  const std::string& path_;
  std::vector<std::string> lines_;
  base::Problems problems_;
  std::size_t at_ = 0, located_ = 0;  ///< located_: the line of sight whose place is being told
  Case case_;
};

}  // namespace

Imported read_tape6(const std::string& path) { return ListingReader(path).read(); }

}  // namespace raycube::atmos::imported
