#include "atmos_tables/import/uvspec_input.h"

#include <algorithm>
#include <cmath>

#include "atmos_tables/import/conversions.h"
#include "atmos_tables/import/text_lines.h"

namespace raycube::atmos::imported {

namespace {

using Words = std::vector<std::string_view>;

class InputReader {
 public:
  explicit InputReader(const std::string& path) { in_.file = path; }

  UvspecInput read() {
    const auto lines = read_lines(in_.file);
    for (std::size_t i = 0; i < lines.size(); ++i) {
      line_ = static_cast<int>(i) + 1;
      const std::string text = lines[i].substr(0, lines[i].find('#'));
      const Words words = split_blanks(text);
      if (!words.empty()) setting(words);
    }
    line_ = 0;
    settle();
    problems_.throw_if_any();
    return in_;
  }

 private:
  base::Where here() const { return {in_.file, line_, 0, ""}; }

  std::vector<double> numbers(const Words& words, bool negative_allowed) {
    std::vector<double> out;
    for (std::size_t i = 1; i < words.size(); ++i)
      out.push_back(need_number(words[i], here(), std::string(words[0]), problems_, negative_allowed).value);
    if (out.empty()) problems_.add(here(), std::string(words[0]) + " has no value", "", "");
    return out;
  }

  /// The first of them; 0 where there is none, which is reported.
  double number(const Words& words, bool negative_allowed) {
    const auto list = numbers(words, negative_allowed);
    return list.empty() ? 0 : list.front();
  }

  void setting(const Words& words) {
    const std::string_view key = words[0], value = words.size() > 1 ? words[1] : std::string_view();
    if (key == "umu" || key == "phi") {
      auto list = numbers(words, true);
      if (key == "umu" && std::any_of(list.begin(), list.end(), [](double u) { return !(std::abs(u) <= 1) || u == 0; }))
        problems_.add(here(), "umu lies outside -1 to 1, or is 0", "", "");
      (key == "umu" ? in_.umu : in_.phi_deg) = std::move(list);
    } else if (key == "phi0") {
      in_.phi0_deg = number(words, true);
    } else if (key == "sza") {
      in_.sun_zenith_deg = number(words, false);
    } else if (key == "albedo") {
      in_.albedo = number(words, false);
    } else if (key == "zout") {
      for (std::size_t i = 1; i < words.size(); ++i) level(words[i]);
    } else if (key == "wavelength") {
      const auto list = numbers(words, false);
      if (!list.empty()) in_.first_nm = list.front(), in_.last_nm = list.back();
    } else if (key == "rte_solver") {
      if (one_of(value, {"twostr", "twostream"}))
        in_.two_stream = true;
      else if (!one_of(value, {"disort", "disort1", "disort2", "fdisort1", "fdisort2", "cdisort", "sdisort"}))
        solver_ = value;
    } else if (key == "output_user") {
      for (std::size_t i = 1; i < words.size(); ++i) in_.output_user.emplace_back(words[i]);
    } else if (key == "output_quantity") {
      if (value == "transmittance")
        in_.quantity = UvspecQuantity::transmittance;
      else if (value == "reflectivity")
        in_.quantity = UvspecQuantity::reflectivity;
      else if (value == "brightness")
        in_.quantity = UvspecQuantity::brightness;
      else
        unknown(words);
    } else if (key == "output_process") {
      process_ = value;
      if (!one_of(value, {"per_nm", "per_cm-1", "integrate", "none"})) unknown(words);
    } else if (key == "source") {
      thermal_ = value == "thermal";
      if (!thermal_ && value != "solar") unknown(words);
      if (words.size() > 2) solar_file_ = words[2];
      if (words.size() > 3 && words[3] != "per_nm") unknown(words);
    } else if (one_of(key, {"include", "output_format", "output_file", "header", "heating_rate", "zout_sea",
                            "polradtran", "mc_polarisation", "mc_backward", "print_disort_info", "spline",
                            "filter_function_file", "slit_function_file", "output"})) {
      unknown(words);
    }
  }

  void unknown(const Words& words) {
    std::string text(words[0]);
    if (words.size() > 1) text += " " + std::string(words[1]);
    problems_.add(
        here(), "this setting gives the output a layout or unit that is not known here", text,
        "run uvspec without it, or with output_user and one of kurudz, kurucz and atlas_plus_modtran as solar file");
  }

  void level(std::string_view word) {
    Place place;
    if (word == "TOA" || word == "toa")
      place.top_of_air = true;
    else if (one_of(word, {"BOA", "boa", "SUR", "sur", "surface"}))
      place.height_m = 0;
    else
      place.height_m = m_from_km(need_number(word, here(), "zout", problems_).value);
    in_.levels.push_back(place);
  }

  void settle() {
    if (in_.levels.empty()) in_.levels.push_back({0.0, false, {}, {}, {}});
    if (!solver_.empty() && in_.output_user.empty())
      problems_.add(here(), "the layout of this rte_solver is not known", solver_, "run uvspec with output_user");
    if (!in_.phi_deg.empty() && in_.umu.empty()) problems_.add(here(), "phi without umu", "", "");
    if (in_.quantity != UvspecQuantity::radiometric) {
      if (process_ == "integrate")
        problems_.add(here(), "an integral of a ratio or temperature is no spectrum", "output_process integrate", "");
      return;
    }
    const bool known_sun = solar_file_.find("kurudz") != std::string::npos ||
                           solar_file_.find("kurucz") != std::string::npos ||
                           solar_file_.find("atlas_plus_modtran") != std::string::npos;
    if (!thermal_ && !known_sun) {
      problems_.add(here(), "the unit of the output is that of the solar file, which is not known",
                    solar_file_.empty() ? "no file" : solar_file_,
                    "name one of kurudz, kurucz and atlas_plus_modtran in `source solar`");
      return;
    }
    if (process_ == "integrate")
      in_.density = thermal_ ? UvspecDensity::integrated_W : UvspecDensity::integrated_mW;
    else if (process_ == "per_cm-1" && thermal_)
      in_.density = UvspecDensity::W_per_cm;
    else if (process_ == "per_nm" && thermal_)
      in_.density = UvspecDensity::W_per_nm;
    else if (thermal_ || process_ == "per_cm-1")
      problems_.add(here(), "the unit of the output cannot be told",
                    thermal_ ? "thermal, no output_process" : "solar, per_cm-1",
                    thermal_ ? "give output_process per_nm or per_cm-1" : "give output_process per_nm");
  }

  UvspecInput in_;
  base::Problems problems_;
  int line_ = 0;
  bool thermal_ = false;
  std::string solver_, process_, solar_file_;
};

}  // namespace

UvspecInput read_uvspec_input(const std::string& path) { return InputReader(path).read(); }

}  // namespace raycube::atmos::imported
