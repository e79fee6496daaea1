#include "atmos_tables/import/uvspec_input.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

#include "atmos_tables/import/conversions.h"
#include "atmos_tables/import/text_lines.h"
#include "atmos_tables/import/uvspec_unit.h"
#include "host/base/text.h"

namespace raycube::atmos::imported {

namespace {

using Words = std::vector<std::string_view>;

/// Settings that give the output another layout or meaning, and the way round each.
struct Refused {
  const char *key, *what, *way_out;
};
constexpr Refused kRefused[] = {
    {"pressure_out", "levels by pressure have no height", "give zout in km"},
    {"print_disort_info", "DISORT's own prints stand between the lines of the output", "run uvspec without it"},
    {"header", "a header stands above the output", "run uvspec without it"},
    {"sza_file", "the sun's zenith changes with wavelength", "run uvspec with one sza"},
    {"polradtran", "the output holds Stokes vectors", "run uvspec with rte_solver disort"},
    {"mc_polarisation", "the output holds Stokes vectors", "run uvspec without it"},
    {"mc_backward", "the output holds pixels", "run uvspec with rte_solver disort"},
    {"mc_lidar", "the output holds a lidar's signal", "run uvspec with source solar or thermal"},
    {"mc_radar", "the output holds a radar's signal", "run uvspec with source solar or thermal"},
    {"output", "a setting of libRadtran 1.x", "write output_process or output_quantity, as 2.x calls it"},
    {"solar_file", "a setting of libRadtran 1.x", "write source solar FILE, as 2.x calls it"},
    {"correlated_k", "a setting of libRadtran 1.x", "write mol_abs_param, as 2.x calls it"},
    {"transmittance", "a setting of libRadtran 1.x", "write output_quantity transmittance, as 2.x calls it"},
};

class InputReader {
 public:
  explicit InputReader(const std::string& path) { in_.file = path; }

  UvspecInput read() {
    read_file(in_.file, 0);
    here_ = {in_.file, 0, 0, ""};
    settle();
    problems_.throw_if_any();
    return in_;
  }

 private:
  void read_file(const std::string& path, int depth) {
    const auto lines = read_lines(path);
    for (std::size_t i = 0; i < lines.size() && problems_.count() < kEnoughProblems; ++i) {
      here_ = {path, static_cast<int>(i) + 1, 0, ""};
      const std::string text = lines[i].substr(0, lines[i].find('#'));
      const Words words = split_blanks(text);
      if (words.empty()) continue;
      if (words[0] == "include")
        include(words, depth);
      else
        setting(words);
    }
  }

  void include(const Words& words, int depth) {
    constexpr int kDeepest = 20;
    const base::Where at = here_;
    const auto file = named_file(words, "the included file is not there",
                                 "put it beside this file, or write its lines in place of this one");
    if (file && depth >= kDeepest && !ring_)
      problems_.add(at, "files include each other", *file, "take out the line that closes the ring"), ring_ = true;
    else if (file && !ring_)
      read_file(*file, depth + 1);
  }

  /// Where the second word names a file: as it stands, from the folder of the file that names it, and beside that file
  /// (uvspec counts from the folder it runs in, which no file tells).
  std::optional<std::string> named_file(const Words& words, const char* missing, const char* way_out) {
    namespace fs = std::filesystem;
    if (words.size() < 2) {
      problems_.add(here_, std::string(words[0]) + " names no file", "", way_out);
      return std::nullopt;
    }
    const fs::path name = std::string(words[1]), folder = fs::path(here_.file).parent_path();
    for (const fs::path& path : {folder / name, folder / name.filename()}) {
      std::error_code ignored;
      if (fs::is_regular_file(path, ignored)) return path.string();
    }
    if (missing) problems_.add(here_, missing, name.string(), way_out);
    return std::nullopt;
  }

  std::vector<double> numbers(const Words& words, bool negative_allowed) {
    std::vector<double> out;
    for (std::size_t i = 1; i < words.size(); ++i)
      out.push_back(need_number(words[i], here_, std::string(words[0]), problems_, negative_allowed).value);
    if (out.empty()) problems_.add(here_, std::string(words[0]) + " has no value", "", "");
    return out;
  }

  /// The first of them; 0 where there is none, which is reported.
  double number(const Words& words, bool negative_allowed) {
    const auto list = numbers(words, negative_allowed);
    return list.empty() ? 0 : list.front();
  }

  void setting(const Words& words) {
    const std::string_view key = words[0], value = words.size() > 1 ? words[1] : std::string_view();
    for (const Refused& refused : kRefused)
      if (key == refused.key) {
        problems_.add(here_, std::string("this setting is not read: ") + refused.what, std::string(key),
                      refused.way_out);
        return;
      }
    if (geometry(key, words) || spectrum(key, words)) return;
    if (key == "rte_solver") {
      in_.two_stream = one_of(value, {"twostr", "twostream", "ftwostr"});
      solver_ = in_.two_stream || one_of(value, {"disort", "disort1", "disort2", "fdisort1", "fdisort2", "cdisort",
                                                 "sdisort", "spsdisort", "qdisort"})
                    ? ""
                    : value;
    } else if (key == "output_user") {
      in_.output_user.assign(words.begin() + 1, words.end());
    } else if (key == "output_quantity") {
      output_quantity(words);
    } else if (key == "output_process") {
      asked_.process = value;
      if (!one_of(value, {"per_nm", "per_cm-1", "per_band", "integrate", "sum", "none"}))
        unknown(words, "only per_nm, per_cm-1, per_band, integrate, sum and none are read");
    } else if (key == "output_format") {
      if (value != "ascii") unknown(words, "run uvspec with output_format ascii");
    } else if (key == "heating_rate") {
      heating_ = value != "none";
    }
  }

  void unknown(const Words& words, const char* way_out) {
    std::string text(words[0]);
    if (words.size() > 1) text += " " + std::string(words[1]);
    problems_.add(here_, "this setting gives the output a layout or unit that is not known here", text, way_out);
  }

  void output_quantity(const Words& words) {
    static const std::map<std::string_view, UvspecQuantity> kQuantities = {
        {"transmittance", UvspecQuantity::transmittance},
        {"reflectivity", UvspecQuantity::reflectivity},
        {"brightness", UvspecQuantity::brightness}};
    const auto found = kQuantities.find(words.size() > 1 ? words[1] : std::string_view());
    if (found == kQuantities.end())
      unknown(words, "transmittance, reflectivity and brightness are read");
    else
      in_.quantity = found->second;
  }

  /// Directions, levels, sun, ground; false where the key is none of them.
  bool geometry(std::string_view key, const Words& words) {
    if (key == "umu" || key == "phi") {
      auto list = numbers(words, true);
      if (key == "umu" && std::any_of(list.begin(), list.end(), [](double u) { return !(std::abs(u) <= 1) || u == 0; }))
        problems_.add(here_, "umu lies outside -1 to 1, or is 0", "", "");
      (key == "umu" ? in_.umu : in_.phi_deg) = std::move(list);
    } else if (key == "phi0") {
      in_.phi0_deg = number(words, true);
    } else if (key == "sza") {
      sza_ = number(words, false);
    } else if (one_of(key, {"latitude", "longitude", "time"})) {
      by_place_and_time_ = true;
    } else if (key == "day_of_year") {
      in_.day_of_year = whole_number(number(words, false), 1, 366);
      if (!in_.day_of_year && words.size() > 1)  // number() reports that there is none
        problems_.add(here_, "a day of the year is 1 to 366", std::string(words[1]), "");
    } else if (key == "albedo") {
      in_.albedo = number(words, false);
    } else if (key == "altitude") {
      ground_height_m_ =
          m_from_km(number({words.begin(), words.begin() + std::min<std::ptrdiff_t>(2, std::ssize(words))}, true));
    } else if (key == "zout" || key == "zout_sea") {
      in_.levels.clear(), at_surface_.clear(), above_sea_ = key == "zout_sea";
      for (std::size_t i = 1; i < words.size(); ++i) level(words[i]);
      if (words.size() < 2) problems_.add(here_, std::string(key) + " has no value", "", "");
    } else {
      return false;
    }
    return true;
  }

  void level(std::string_view word) {
    Place place;
    const std::string name = base::lower_case(std::string(word));
    if (name == "toa")
      place.top_of_air = true;
    else if (one_of(name, {"boa", "sur", "surface"}))
      place.height_m = 0, at_surface_.push_back(in_.levels.size());
    else if (name == "cpt")
      problems_.add(here_, "the height of the cold point is not said", "cpt", "give zout in km");
    else
      place.height_m = m_from_km(need_number(word, here_, "zout", problems_).value);
    in_.levels.push_back(place);
  }

  /// Source, wavelengths, gases and what is done with the spectrum; false where the key is none of them.
  bool spectrum(std::string_view key, const Words& words) {
    const std::string_view value = words.size() > 1 ? words[1] : std::string_view();
    if (key == "wavelength") {
      const auto list = numbers(words, false);
      if (!list.empty()) in_.first_nm = list.front(), in_.last_nm = list.back();
    } else if (key == "source") {
      asked_.thermal = value == "thermal";
      if (!asked_.thermal && value != "solar") unknown(words, "solar and thermal are read");
      asked_.solar_file = words.size() > 2 ? words[2] : std::string_view();
      asked_.file_unit = words.size() > 3 ? words[3] : std::string_view();
    } else if (key == "mol_abs_param") {
      asked_.gases = base::lower_case(std::string(value));
    } else if (key == "thermal_bandwidth") {
      asked_.thermal_bands =
          number({words.begin(), words.begin() + std::min<std::ptrdiff_t>(2, std::ssize(words))}, false) != 1;
    } else if (key == "thermal_bands_file") {
      asked_.thermal_bands = true;
    } else if (key == "slit_function_file") {
      slit(words);
    } else if (key == "filter_function_file") {
      asked_.filter = std::string(value), asked_.filter_normalized = words.size() > 2 && words[2] == "normalize";
    } else if (key == "spline") {
      spline(words);
    } else if (key == "spline_file") {
      spline_file(words);
    } else {
      return false;
    }
    return true;
  }

  /// The numbers are means over the slit; how wide it is, where its file is at hand.
  void slit(const Words& words) {
    slit_ = "convolved with the slit function " + std::string(words.size() > 1 ? words[1] : std::string_view());
    const auto file = named_file(words, nullptr, "name the file");
    if (!file) return;
    const auto table = two_columns(*file);
    if (const auto width = full_width(table)) slit_ += ", " + shown(*width) + " nm wide at half its height";
  }

  void spline(const Words& words) {
    const auto list = numbers(words, false);
    constexpr double kMost = 1e6;
    if (list.size() != 3 || !(list[2] > 0) || !(list[1] >= list[0]) || !((list[1] - list[0]) / list[2] < kMost)) {
      problems_.add(here_, "spline needs first and last wavelength and a step, in nm", "", "spline 300 340 1");
      return;
    }
    in_.axis_nm.clear();
    const int steps = static_cast<int>(std::floor((list[1] - list[0]) / list[2] + 1e-6));
    for (int i = 0; i <= steps; ++i) in_.axis_nm.push_back(list[0] + i * list[2]);
  }

  /// Its wavelengths, where it is at hand; the output has them anyway.
  void spline_file(const Words& words) {
    in_.axis_nm.clear();
    const auto file = named_file(words, nullptr, "name the file");
    if (!file) return;
    for (const auto& row : two_columns(*file)) in_.axis_nm.push_back(row.first);
  }

  /// Rows of numbers; the second is 0 where there is one alone.
  static std::vector<std::pair<double, double>> two_columns(const std::string& file) {
    std::vector<std::pair<double, double>> out;
    for (const std::string& line : read_lines(file)) {
      const Words words = split_blanks(std::string_view(line).substr(0, line.find('#')));
      const Number first = words.empty() ? Number{} : read_number(words[0]),
                   second = words.size() > 1 ? read_number(words[1]) : Number{};
      if (first.good()) out.emplace_back(first.value, second.good() ? second.value : 0);
    }
    return out;
  }
  /// Between the outermost crossings of half the largest value, straight between the rows.
  static std::optional<double> full_width(const std::vector<std::pair<double, double>>& table) {
    double half = 0;
    for (const auto& [x, y] : table) half = std::max(half, 0.5 * y);
    std::optional<double> first, last;
    for (std::size_t i = 1; i < table.size(); ++i) {
      const auto [x0, y0] = table[i - 1];
      const auto [x1, y1] = table[i];
      if ((y0 < half) == (y1 < half)) continue;
      last = x0 + (half - y0) / (y1 - y0) * (x1 - x0);
      if (!first) first = last;
    }
    return first && *last > *first ? std::optional<double>(*last - *first) : std::nullopt;
  }

  void settle() {
    if (in_.levels.empty()) in_.levels.push_back({0.0, false, {}, {}, {}});
    if (above_sea_) in_.ground_height_m = ground_height_m_;
    if (above_sea_)
      for (const std::size_t level : at_surface_) in_.levels[level].height_m = ground_height_m_.value_or(0);
    in_.thermal = asked_.thermal;
    if (!in_.thermal && (sza_ || !by_place_and_time_)) in_.sun_zenith_deg = sza_.value_or(0);
    if (in_.thermal) in_.day_of_year.reset();
    const bool own_layout = in_.output_user.empty();
    if (!solver_.empty() && own_layout)
      problems_.add(here_, "the layout of this rte_solver is not known", solver_,
                    "run uvspec with output_user, or with rte_solver disort");
    if (heating_ && own_layout)
      problems_.add(here_, "heating_rate prints a matrix of heating rates and no radiation", "",
                    "run uvspec without it, or with output_user");
    if (!in_.phi_deg.empty() && in_.umu.empty()) problems_.add(here_, "phi without umu", "", "");
    if (!slit_.empty()) in_.notes.push_back(slit_);
    asked_.quantity = in_.quantity;
    const UvspecTold told = uvspec_unit(asked_);
    if (!told.problem.empty()) problems_.add(here_, told.problem, told.found, told.way_out);
    in_.unit = told.unit, in_.sun_of_reptran = told.sun_of_reptran;
    if (!told.note.empty()) in_.notes.push_back(told.note);
  }

  UvspecInput in_;
  base::Problems problems_;
  bool ring_ = false;  ///< told once
  base::Where here_;
  UvspecAsked asked_;
  std::optional<double> sza_, ground_height_m_;
  std::vector<std::size_t> at_surface_;  ///< levels that a word names
  bool by_place_and_time_ = false, above_sea_ = false, heating_ = false;
  std::string solver_, slit_;
};

}  // namespace

UvspecInput read_uvspec_input(const std::string& path) { return InputReader(path).read(); }

}  // namespace raycube::atmos::imported
