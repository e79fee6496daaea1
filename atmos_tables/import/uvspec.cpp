#include "atmos_tables/import/uvspec.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "atmos_tables/import/conversions.h"
#include "atmos_tables/import/text_lines.h"
#include "atmos_tables/import/uvspec_input.h"
#include "host/base/planck.h"

namespace raycube::atmos::imported {

namespace {

struct Meaning {
  const char* name;
  bool radiance;  ///< per steradian
};

const Meaning* meaning_of(std::string_view source, bool up) {
  static constexpr std::pair<const char*, Meaning> kMeanings[] = {{"edir", {"irradiance_down_direct", false}},
                                                                  {"edn", {"irradiance_down_diffuse", false}},
                                                                  {"eglo", {"irradiance_down", false}},
                                                                  {"eup", {"irradiance_up", false}},
                                                                  {"uavg", {"mean_radiance", true}},
                                                                  {"uavgdir", {"mean_radiance_direct", true}},
                                                                  {"uavgdn", {"mean_radiance_down", true}},
                                                                  {"uavgup", {"mean_radiance_up", true}},
                                                                  {"uavgglo", {"mean_radiance_down_all", true}}};
  static constexpr Meaning kUu[2] = {{"radiance_downward", true}, {"radiance_upward", true}},
                           kU0u[2] = {{"radiance_downward_azimuth_mean", true}, {"radiance_upward_azimuth_mean", true}};
  if (source == "uu") return &kUu[up];
  if (source == "u0u") return &kU0u[up];
  for (const auto& [key, meaning] : kMeanings)
    if (source == key) return &meaning;
  return nullptr;
}

bool is_wavelength(std::string_view name) { return one_of(name, {"lambda", "wavelength", "wvl"}); }
bool is_wavenumber(std::string_view name) { return one_of(name, {"wavenumber", "wvn"}); }
bool is_level(std::string_view name) { return one_of(name, {"zout", "zout_sur", "zout_sea"}); }

/// Columns of output_user that say nothing of light as it is read here: actinic and net fluxes, heating, the air.
bool is_left_out(std::string_view name) {
  for (const char* gas : {"n_", "rho_", "vmr_", "mmr_"})
    if (name.rfind(gas, 0) == 0) return true;
  return one_of(name, {"enet",
                       "esum",
                       "fdir",
                       "fglo",
                       "fdn",
                       "fup",
                       "f",
                       "heat",
                       "emis",
                       "abs",
                       "albedo",
                       "p",
                       "T",
                       "T_d",
                       "T_sur",
                       "theta",
                       "theta_e",
                       "rh",
                       "rh_ice",
                       "c_p",
                       "CLWC",
                       "CLWD",
                       "CIWC",
                       "CIWD",
                       "TCC",
                       "z_sur",
                       "wavenumber_min",
                       "wavenumber_max",
                       "lambda_min",
                       "lambda_max"});
}

class UvspecReader {
 public:
  UvspecReader(const std::string& path, const UvspecInput& in) : path_(path), in_(in), lines_(read_lines(path)) {}

  Imported read() {
    declare();
    const std::size_t levels = in_.levels.size();
    std::size_t block = 0;
    while (more() && problems_.count() < kEnoughProblems) {
      next_column_ = block % levels * per_level_;
      if (!(in_.output_user.empty() ? own_block(block % levels) : user_line(block % levels))) break;
      ++block;
    }
    if (block % levels != 0 && problems_.empty())
      problems_.add(here(), "the last wavelength has not every level of the input file",
                    std::to_string(block % levels) + " of " + std::to_string(levels),
                    "the output is cut short, or the .inp is of another run");
    if (block == 0 && problems_.empty()) problems_.add(here(), "no data", "", "the run failed");
    if (problems_.empty()) {
      if (in_.axis_nm.empty())
        check_band();
      else
        check_axis();
      if (in_.sun_of_reptran && spectral()) check_reptran_sun();
      check_run(run_, {path_, 0, 0, ""}, problems_, 1e-5);
    }
    problems_.throw_if_any();
    return {path_, "libRadtran uvspec", "uvspec", {std::move(run_)}};
  }

 private:
  base::Where here() const { return {path_, static_cast<int>(std::min(at_ + 1, lines_.size())), 0, ""}; }
  bool more() {
    while (at_ < lines_.size() && trimmed(lines_[at_]).empty()) ++at_;
    return at_ < lines_.size();
  }

  void declare_column(std::string_view source, const Place& place, std::optional<double> umu,
                      std::optional<double> phi) {
    const bool up = umu && *umu > 0;
    const Meaning* meaning = meaning_of(source, up);
    Column column;
    column.source = std::string(source);
    column.place = place;
    if (umu) column.place.zenith_deg = zenith_deg_from_umu(*umu);
    if (umu && phi) column.place.relative_azimuth_deg = relative_azimuth_deg_from_uvspec(*umu, *phi, in_.phi0_deg);
    const std::string name = meaning->name, per_sr = meaning->radiance ? " sr-1" : "";
    switch (in_.quantity) {
      case UvspecQuantity::transmittance:
        column.name = name + "_per_sun", column.unit = meaning->radiance ? "sr-1" : "1";
        break;
      case UvspecQuantity::reflectivity:
        column.name = name + "_reflectivity", column.unit = "1";
        break;
      case UvspecQuantity::brightness:
        column.name = name + "_brightness_temperature", column.unit = "K";
        break;
      case UvspecQuantity::radiometric:
        column.name = name;
        column.unit = "W m-2" + per_sr + (spectral() ? " um-1" : "");
    }
    run_.columns.push_back(std::move(column));
  }

  void declare() {
    const bool emission = in_.thermal && in_.quantity == UvspecQuantity::radiometric;
    run_.mode = in_.unit.per == UvspecPer::all ? "integrated"
                : in_.unit.per == UvspecPer::band
                    ? "bands"
                    : std::string(emission ? "thermal " : "") + (in_.umu.empty() ? "fluxes" : "fluxes and radiances");
    run_.geometry.sun_zenith_deg = in_.sun_zenith_deg;
    run_.geometry.ground_albedo = in_.albedo, run_.geometry.ground_height_m = in_.ground_height_m;
    run_.geometry.day_of_year = in_.day_of_year;
    run_.notes = in_.notes;
    for (const Place& place : in_.levels) {
      const auto plain = [&](std::initializer_list<const char*> names) {
        for (const char* name : names) declare_column(name, place, {}, {});
      };
      if (!in_.output_user.empty()) {
        if (per_level_ == 0 &&
            std::none_of(in_.output_user.begin(), in_.output_user.end(),
                         [](const std::string& name) { return is_wavelength(name) || is_wavenumber(name); }))
          problems_.add({in_.file, 0, 0, ""}, "output_user without lambda", "", "run uvspec with it");
        for (const std::string& name : in_.output_user) declare_user(name, place);
      } else if (in_.two_stream) {
        plain({"edir", "edn", "eup", "uavg"});
      } else {
        plain({"edir", "edn", "eup", "uavgdir", "uavgdn", "uavgup"});
        for (const double umu : in_.umu) {
          declare_column("u0u", place, umu, {});
          for (const double phi : in_.phi_deg) declare_column("uu", place, umu, phi);
        }
      }
      if (per_level_ == 0) per_level_ = run_.columns.size();
    }
    problems_.throw_if_any();
  }

  /// Without phi uvspec computes azimuth means alone, and `uu` is those.
  std::string_view radiance_of(std::string_view name) const {
    return name == "uu" && in_.phi_deg.empty() ? "u0u" : name;
  }
  /// How many numbers a column of output_user is on each line.
  std::size_t width_of(std::string_view name) const {
    const std::string_view radiance = radiance_of(name);
    return radiance == "uu" ? in_.umu.size() * in_.phi_deg.size() : radiance == "u0u" ? in_.umu.size() : 1;
  }

  void declare_user(const std::string& name, const Place& place) {
    const std::string_view radiance = radiance_of(name);
    if (radiance == "uu" || radiance == "u0u") {
      for (const double umu : in_.umu) {
        if (radiance == "u0u")
          declare_column(radiance, place, umu, {});
        else
          for (const double phi : in_.phi_deg) declare_column(radiance, place, umu, phi);
      }
      if (in_.umu.empty()) problems_.add({in_.file, 0, 0, ""}, "output_user " + name + " without umu", "", "give umu");
    } else if (name == "spher_alb") {
      run_.columns.push_back({"spherical_albedo", "1", name, place, {}, {}});
    } else if (meaning_of(name, false)) {
      declare_column(name, place, {}, {});
    } else if (is_left_out(name)) {
      const std::string note = "column " + name + " is no light that is read here and was left out";
      if (std::find(run_.notes.begin(), run_.notes.end(), note) == run_.notes.end()) run_.notes.push_back(note);
    } else if (!is_wavelength(name) && !is_wavenumber(name) && !is_level(name) && name != "sza") {
      problems_.add({in_.file, 0, 0, ""}, "a column of output_user is not known", name,
                    "known: lambda wavenumber sza zout edir edn eglo eup uavg uavgdir uavgdn uavgup u0u uu spher_alb; "
                    "those of the air are left out");
    }
  }

  std::vector<Number> numbers(std::size_t expected, const char* what) {
    const auto words = split_blanks(lines_[at_]);
    std::vector<Number> out;
    if (words.size() != expected) {
      problems_.add(here(),
                    std::string("a line of ") + what + " has another number of fields than the input file asks for",
                    std::to_string(words.size()) + " of " + std::to_string(expected),
                    "the output is cut short, or the .inp is of another run");
      return out;
    }
    for (const auto& word : words) out.push_back(need_number(word, here(), what, problems_, true));
    return out;
  }

  /// Densities per wavelength or wavenumber; else sums over bands or over all.
  bool spectral() const { return in_.unit.per == UvspecPer::nm || in_.unit.per == UvspecPer::cm; }

  double converted(double value) const {
    const double um = run_.wavelength_um.back();
    if (in_.quantity != UvspecQuantity::radiometric) return value;
    if (in_.unit.power == UvspecPower::photons) return W_per_m2_um_from_photons_per_s_cm2_nm(value, um);
    const bool milli = in_.unit.power == UvspecPower::mW;
    switch (in_.unit.per) {
      case UvspecPer::nm:
        return milli ? W_per_m2_um_from_mW_per_m2_nm(value) : W_per_m2_um_from_W_per_m2_nm(value);
      case UvspecPer::cm:
        return W_per_m2_um_from_W_per_m2_per_cm(milli ? W_per_m2_from_mW_per_m2(value) : value, um);
      case UvspecPer::band:
      case UvspecPer::all:
        return milli ? W_per_m2_from_mW_per_m2(value) : value;
    }
    return value;
  }

  void put(const Number& number, double largest) {
    Column& column = run_.columns[next_column_++];
    double value = number.value;
    if (value < 0 && value >= -1e-9 * largest) value = 0;  // far below the seven digits printed of the largest
    if (value < 0)
      problems_.add(here(), column.source + " is negative", std::to_string(number.value),
                    "run uvspec with more streams");
    column.values.push_back(converted(value));
    column.rounding.push_back(converted(number.rounding));
  }

  bool wavelength(const Number& nm, std::size_t level) {
    if (!(nm.value > 0)) {
      problems_.add(here(), "a wavelength is not above 0", std::to_string(nm.value), "the output is damaged");
      return false;
    }
    const double um = base::um_from_nm(nm.value);
    auto& axis = run_.wavelength_um;
    if (level > 0 ? um != axis.back() : !axis.empty() && !(um > axis.back())) {
      problems_.add(here(),
                    level > 0 ? "the wavelength changes between the levels of one block" : "wavelengths do not ascend",
                    std::to_string(nm.value) + " after " + std::to_string(base::nm_from_um(axis.back())) + " nm",
                    "lines are missing, doubled or out of order");
      return false;
    }
    if (level == 0) axis.push_back(um);
    return true;
  }

  static double largest_of(const std::vector<Number>& line, std::size_t from) {
    double most = 0;
    for (std::size_t i = from; i < line.size(); ++i) most = std::max(most, std::abs(line[i].value));
    return most;
  }

  bool own_block(std::size_t level) {
    const auto line = numbers(in_.two_stream ? 5 : 7, "fluxes");
    if (line.empty() || !wavelength(line[0], level)) return false;
    const double largest = largest_of(line, 1);
    for (std::size_t i = 1; i < line.size(); ++i) put(line[i], largest);
    ++at_;
    if (in_.two_stream || in_.umu.empty()) return true;
    if (!in_.phi_deg.empty()) {
      if (!more()) return cut_short("phi values");
      const auto phis = numbers(in_.phi_deg.size(), "phi values");
      for (std::size_t i = 0; i < phis.size(); ++i)
        if (!(std::abs(phis[i].value - in_.phi_deg[i]) <= phis[i].rounding * 1.001))
          problems_.add(here(), "phi is not that of the input file",
                        std::to_string(phis[i].value) + " for " + std::to_string(in_.phi_deg[i]),
                        "the .inp is of another run");
      if (phis.empty()) return false;
      ++at_;
    }
    for (const double umu : in_.umu) {
      if (!more()) return cut_short("umu " + std::to_string(umu));
      const auto radiances = numbers(2 + in_.phi_deg.size(), "radiances");
      if (radiances.empty()) return false;
      if (!(std::abs(radiances[0].value - umu) <= radiances[0].rounding * 1.001)) {
        problems_.add(here(), "umu is not that of the input file",
                      std::to_string(radiances[0].value) + " for " + std::to_string(umu),
                      "lines are out of order, or the .inp is of another run");
        return false;
      }
      for (std::size_t i = 1; i < radiances.size(); ++i) put(radiances[i], largest);
      ++at_;
    }
    return true;
  }

  bool cut_short(const std::string& what) {
    problems_.add(here(), "the file ends before " + what, "", "the output is cut short");
    return false;
  }

  bool user_line(std::size_t level) {
    std::size_t columns = 0;
    for (const auto& name : in_.output_user) columns += width_of(name);
    const auto line = numbers(columns, "output_user");
    if (line.empty()) return false;
    double largest = 0;
    std::size_t field = 0;
    const auto check = [&](const char* what, double stands, double expected) {
      if (!(std::abs(stands - expected) <= line[field].rounding * 1.001))
        problems_.add(here(), std::string(what) + " is not that of the input file",
                      std::to_string(stands) + " for " + std::to_string(expected),
                      "lines are out of order, or the .inp is of another run");
    };
    // The axis first, wherever it stands: conversions need it.
    if (!user_axis(line, level)) return false;
    for (const auto& name : in_.output_user) {
      const std::size_t count = width_of(name);
      if (takes(name))
        for (std::size_t i = 0; i < count; ++i) largest = std::max(largest, std::abs(line[field + i].value));
      field += count;
    }
    field = 0;
    for (const auto& name : in_.output_user) {
      const std::size_t count = width_of(name);
      if (name == "sza" && in_.sun_zenith_deg)
        check("sza", line[field].value, *in_.sun_zenith_deg);
      else if (name == "sza" && !in_.thermal && !run_.geometry.sun_zenith_deg)
        run_.geometry.sun_zenith_deg = line[field].value;
      else if (name == "zout" && in_.levels[level].height_m)
        check("zout", line[field].value, *in_.levels[level].height_m / 1e3);
      else if (takes(name))
        for (std::size_t i = 0; i < count; ++i) put(line[field + i], largest);
      field += count;
    }
    ++at_;
    return true;
  }

  /// Whether a column of output_user becomes columns of the run.
  static bool takes(std::string_view name) { return name == "spher_alb" || meaning_of(name, false); }

  /// By lambda, or by wavenumber where that stands alone (one of them does); both must agree.
  bool user_axis(const std::vector<Number>& line, std::size_t level) {
    const Number *lambda = nullptr, *wavenumber = nullptr;
    std::size_t field = 0;
    for (const auto& name : in_.output_user) {
      if (is_wavelength(name)) lambda = &line[field];
      if (is_wavenumber(name)) wavenumber = &line[field];
      field += width_of(name);
    }
    if (wavenumber && !(wavenumber->value > 0)) {
      problems_.add(here(), "a wavenumber is not above 0", shown(wavenumber->value), "the output is damaged");
      return false;
    }
    const double nm = wavenumber ? base::nm_from_um(base::um_from_wavenumber_per_cm(wavenumber->value)) : lambda->value,
                 digits = wavenumber ? wavenumber->rounding * nm * nm * 1e-7 : 0;
    if (!wavelength(lambda ? *lambda : Number{Number::State::good, nm, digits}, level)) return false;
    // lambda is printed to 0.001 nm: it names the wavenumber to that.
    if (lambda && !(std::abs(nm - lambda->value) <= (lambda->rounding + digits) * 1.001))
      problems_.add(here(), "lambda and wavenumber disagree",
                    std::to_string(nm) + " and " + std::to_string(lambda->value) + " nm", "the columns have moved");
    return true;
  }

  /// The wavelengths are those of `spline`, to the digits that uvspec prints them with.
  void check_axis() {
    const auto& axis = run_.wavelength_um;
    bool same = axis.size() == in_.axis_nm.size();
    for (std::size_t i = 0; same && i < axis.size(); ++i)
      same = std::abs(base::nm_from_um(axis[i]) - in_.axis_nm[i]) <= 1e-3;
    if (!same)
      problems_.add(here(), "the wavelengths are not those that spline asks for",
                    std::to_string(axis.size()) + " of " + std::to_string(in_.axis_nm.size()),
                    "the output is cut short, or the .inp is of another run");
  }

  /// Without a solar file uvspec takes the sun of REPTRAN's tables, in mW m-2 nm-1 as its other files; its manual says
  /// W. The size decides: light from above beyond 1/500 of the sun's (a black body of 5772 K) cannot be in W, which
  /// would put it beyond the sun itself.
  void check_reptran_sun() {
    constexpr double kSun_K = 5772, kSunRadiusOverDistance2 = 2.1626e-5;
    double most = 0;
    for (const Column& column : run_.columns)
      for (std::size_t i = 0; i < column.values.size(); ++i) {
        const double sun = base::kPi * kSunRadiusOverDistance2 * base::planck_radiance(run_.wavelength_um[i], kSun_K);
        most = std::max(most, column.values[i] / sun);
      }
    if (!(most > 2e-3 && most < 2))
      problems_.add({path_, 0, 0, ""}, "source solar without a file: whether the numbers are in mW or W cannot be told",
                    "at most " + shown(most) + " of the sun, read as mW",
                    "name a solar file of libRadtran in `source solar`");
  }

  /// The wavelengths must lie in the band asked for; a run that stopped early ends short of it.
  void check_band() {
    const auto& axis = run_.wavelength_um;
    if (in_.last_nm <= 0) return;
    const double first = base::nm_from_um(axis.front()), last = base::nm_from_um(axis.back());
    // Steps of the solar file or of the band model: an end may miss the band's by one of them.
    const double step =
        axis.size() > 1 ? base::nm_from_um(axis[axis.size() - 1] - axis[axis.size() - 2]) : in_.last_nm - in_.first_nm;
    if (first < in_.first_nm - step || last > in_.last_nm + step || last < in_.last_nm - 1.001 * std::max(step, 1.0))
      problems_.add(here(),
                    "the wavelengths are not those of the input file, " + std::to_string(in_.first_nm) + " to " +
                        std::to_string(in_.last_nm) + " nm",
                    std::to_string(first) + " to " + std::to_string(last),
                    "the output is cut short, or the .inp is of another run");
  }

  const std::string& path_;
  const UvspecInput& in_;
  std::vector<std::string> lines_;
  std::size_t at_ = 0, per_level_ = 0, next_column_ = 0;
  Run run_;
  base::Problems problems_;
};

}  // namespace

std::string uvspec_input_beside(const std::string& path) {
  for (const char* end : {".inp", ".INP"}) {
    const std::filesystem::path input = std::filesystem::path(path).replace_extension(end);
    if (input != path && std::filesystem::exists(input)) return input.string();
  }
  return {};
}

Imported read_uvspec(const std::string& path, const std::string& input) {
  const std::string named = input.empty() ? uvspec_input_beside(path) : input;
  if (named.empty())
    throw base::Error(base::Fault::input,
                      path + ": uvspec output does not name its levels, angles and units; name its input file (" +
                          std::filesystem::path(path).replace_extension(".inp").string() + " is not there)");
  const UvspecInput in = read_uvspec_input(named);
  return UvspecReader(path, in).read();
}

}  // namespace raycube::atmos::imported
