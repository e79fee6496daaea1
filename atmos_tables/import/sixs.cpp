#include "atmos_tables/import/sixs.h"

#include <cmath>
#include <numbers>

#include "atmos_tables/import/conversions.h"
#include "atmos_tables/import/text_lines.h"

namespace raycube::atmos::imported {

namespace {

/// A line without its box and with single blanks. Only the outermost star on either side is the box's.
std::string plain(const std::string& line) {
  std::string_view text = trimmed(line);
  if (!text.empty() && text.front() == '*') text.remove_prefix(1);
  if (!text.empty() && text.back() == '*') text.remove_suffix(1);
  std::string out;
  for (const auto& word : split_blanks(text)) out += (out.empty() ? "" : " ") + std::string(word);
  return out;
}

struct Item {
  const char* label;               ///< what the plain line starts with, or holds
  std::vector<const char*> names;  ///< one per number; "" = not kept
  const char* unit;
  bool below = false;  ///< the numbers stand on the next line
};

const std::vector<Item>& items() {
  static const std::vector<Item> kItems = {
      {"apparent reflectance", {"reflectance_apparent"}, "1"},
      {"appar. rad.(w/m2/sr/mic)", {"radiance"}, "W m-2 sr-1 um-1"},
      {"total gaseous transmittance", {""}, "1"},
      {"direct solar irr. atm. diffuse irr. environment irr",
       {"irradiance_down_direct", "irradiance_down_diffuse", "irradiance_down_environment"},
       "W m-2 um-1",
       true},
      {"atm. intrin. rad. background rad. pixel radiance",
       {"path_radiance_solar", "ground_reflected_environment", "ground_reflected_pixel"},
       "W m-2 sr-1 um-1",
       true},
      {"int. funct filter (in mic) int. sol. spect (in w/m2)", {"filter_width", "solar_irradiance_in_band"}, "", true},
      {"sol. spect (in w/m2/mic)", {"solar_irradiance"}, "W m-2 um-1", true},
      {"global gas. trans. :",
       {"sun_ground_transmittance_gas", "ground_sensor_transmittance_gas", "sun_ground_sensor_transmittance_gas"},
       "1"},
      {"total sca. \" :",
       {"sun_ground_transmittance_scattering", "ground_sensor_transmittance_scattering",
        "sun_ground_sensor_transmittance_scattering"},
       "1"},
      {"spherical albedo :", {"", "", "spherical_albedo"}, "1"},
      {"optical depth total:", {"optical_depth_rayleigh", "optical_depth_aerosol", "optical_depth"}, "1"},
      {"optical depth plane:",
       {"optical_depth_rayleigh_below_plane", "optical_depth_aerosol_below_plane", "optical_depth_below_plane"},
       "1"},
      {"reflectance I :", {"", "", "reflectance_path"}, "1"},
      {"reflectance :", {"", "", "reflectance_path"}, "1"},
  };
  return kItems;
}

/// Heading and columns of the table by wavelength that 6S writes in steps of 2.5 nm (iwave = -2); "" = not
/// kept. swl holds the earth-sun factor.
constexpr const char* kTableHeading = "wave total total total total atm. swl step sbor dsol toar";
struct TableColumn {
  const char *name, *unit, *source;
};
constexpr TableColumn kTable[] = {{"", "um", "wave"},
                                  {"sun_ground_sensor_transmittance_gas", "1", "total gas trans"},
                                  {"sun_ground_transmittance_scattering", "1", "total scat down"},
                                  {"ground_sensor_transmittance_scattering", "1", "total scat up"},
                                  {"spherical_albedo", "1", "total spheri albedo"},
                                  {"reflectance_path", "1", "atm. intr refl"},
                                  {"solar_irradiance", "W m-2 um-1", "swl"},
                                  {"", "um", "step"},
                                  {"", "1", "sbor"},
                                  {"", "1", "dsol"},
                                  {"reflectance_apparent", "1", "toar"}};

class SixsReader {
 public:
  explicit SixsReader(const std::string& path) : path_(path), lines_(read_lines(path)) {}

  Imported read() {
    Imported out{path_, "6S", "6s", {}};
    for (at_ = 0; at_ < lines_.size() && problems_.count() < kEnoughProblems; ++at_) {
      const std::string text = plain(lines_[at_]);
      if (is_title(text)) {
        if (started_) finish(out);
        started_ = true, title_line_ = static_cast<int>(at_) + 1;
      } else if (started_) {
        line(text);
      }
    }
    if (!started_)
      problems_.add({path_, 0, 0, ""}, "no title \"6S version\"", "", "is it the text output of 6S?");
    else
      finish(out);
    problems_.throw_if_any();
    return out;
  }

 private:
  base::Where here() const { return {path_, static_cast<int>(at_) + 1, 0, ""}; }

  static bool is_title(const std::string& text) {
    std::string low;
    for (const char c : text)
      if (c != '*') low += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return low.find("6s version") != std::string::npos || low.find("6sv version") != std::string::npos;
  }

  /// The number that follows `label` in the line.
  std::optional<Number> after(const std::string& text, const std::string& label) {
    const std::size_t found = text.find(label);
    if (found == std::string::npos) return std::nullopt;
    const auto words = split_blanks(std::string_view(text).substr(found + label.size()));
    return need_number(words.empty() ? std::string_view() : words[0], here(), label, problems_);
  }

  void line(const std::string& text) {
    if (text.rfind(kTableHeading, 0) == 0) {
      table_ = true;
      for (const TableColumn& column : kTable) rows_.push_back({column.name, column.unit, column.source, {}, {}, {}});
      return;
    }
    if (table_ && table_row(text)) return;
    if (const auto zenith = after(text, "solar zenith angle:")) run_.geometry.sun_zenith_deg = zenith->value;
    if (const auto zenith = after(text, "view zenith angle:")) run_.geometry.view_zenith_deg = zenith->value;
    if (const auto azimuth = after(text, "azimuthal angle difference:"))
      run_.geometry.relative_azimuth_deg = folded_azimuth_deg(azimuth->value);
    site(text);
    const auto first = after(text, "wl inf="), last = after(text, "wl sup=");
    if (first && last) {
      if (!(first->value > 0 && last->value >= first->value))
        problems_.add(here(), "the band's ends are not above 0 and in order", text, "");
      run_.wavelength_um = {0.5 * (first->value + last->value)};
      keep("band_first", "um", "wl inf", *first), keep("band_last", "um", "wl sup", *last);
    } else if (text.find("monochromatic") != std::string::npos) {
      monochromatic_ = true;
    }
    if (monochromatic_ && run_.wavelength_um.empty())
      if (const auto words = split_blanks(text); words.size() > 1)
        for (std::size_t i = 1; i < words.size(); ++i)
          if (words[i].rfind("mic", 0) == 0)
            run_.wavelength_um = {need_number(words[i - 1], here(), "wavelength", problems_).value};
    for (const Item& item : items()) {
      const std::size_t found = text.find(item.label);
      if (found == std::string::npos || (found != 0 && std::string_view(item.label).rfind("appar. rad", 0) != 0))
        continue;
      if (std::string_view(item.label) == "apparent reflectance" && text.find("appar. rad") == std::string::npos)
        continue;
      std::string numbers = text.substr(found + std::char_traits<char>::length(item.label));
      if (item.below) numbers = ++at_ < lines_.size() ? plain(lines_[at_]) : "";
      const auto words = split_blanks(numbers);
      for (std::size_t i = 0; i < item.names.size(); ++i) {
        const Number number =
            need_number(i < words.size() ? words[i] : std::string_view(), here(), item.label, problems_);
        if (*item.names[i]) keep(item.names[i], item.unit, item.label, number);
      }
    }
  }

  /// Where the sun stands from north, the ground, and the aircraft where 6S was told of one.
  void site(const std::string& text) {
    if (const auto azimuth = after(text, "solar azimuthal angle:"))
      run_.geometry.sun_azimuth_deg = azimuth_deg_0_to_360(azimuth->value);
    if (const auto ground = after(text, "ground altitude [km]"))
      run_.geometry.ground_height_m = m_from_km(ground->value);
    if (const auto plane = after(text, "plane altitude absolute [km]"))
      run_.geometry.sensor_height_m = m_from_km(plane->value);
  }

  /// A line of as many numbers as the table has columns; others (its heading's lower lines, what follows) are
  /// none of it.
  bool table_row(const std::string& text) {
    const auto words = split_blanks(text);
    if (words.size() != std::size(kTable) || words[0].find_first_not_of("0123456789.") != std::string_view::npos)
      return false;
    for (std::size_t i = 0; i < words.size(); ++i) {
      const Number number = need_number(words[i], here(), kTable[i].source, problems_);
      rows_[i].values.push_back(number.value), rows_[i].rounding.push_back(number.rounding);
    }
    return true;
  }

  /// The table in place of the integrals over its whole range, which say nothing of any one wavelength.
  void finish_table(const base::Where& title) {
    run_.mode = "spectrum";
    run_.wavelength_um = rows_[0].values;
    if (run_.wavelength_um.size() < 2)
      problems_.add(title, "a table by wavelength with fewer than 2 rows", std::to_string(run_.wavelength_um.size()),
                    "the output is cut short");
    for (std::size_t i = 1; i < run_.wavelength_um.size(); ++i)
      if (!(run_.wavelength_um[i] > run_.wavelength_um[i - 1])) {
        problems_.add(title, "wavelengths of the table do not ascend", std::to_string(run_.wavelength_um[i]) + " um",
                      "rows are missing or out of order");
        break;
      }
    run_.columns.clear();
    for (Column& column : rows_)
      if (!column.name.empty()) run_.columns.push_back(std::move(column));
    run_.notes.push_back(
        "a table by wavelength: means over its whole range (optical depths, irradiances, radiances) are left "
        "out");
  }

  void keep(const char* name, const char* unit, const char* source, const Number& number) {
    run_.columns.push_back({name, unit, source, {}, {number.value}, {number.rounding}});
  }

  void finish(Imported& out) {
    run_.mode = monochromatic_ ? "one wavelength" : "one band";
    const base::Where title{path_, title_line_, 0, ""};
    if (table_)
      finish_table(title);
    else
      need_band(title);
    if (problems_.empty()) {
      if (!table_) solar();
      check_run(run_, title, problems_);
      out.runs.push_back(std::move(run_));
    }
    run_ = {};
    rows_.clear();
    monochromatic_ = table_ = false;
  }

  void need_band(const base::Where& title) {
    if (run_.wavelength_um.size() != 1)
      problems_.add(title, "the run names no band (wl inf, wl sup)", "", "the output is cut short");
    for (const char* name : {"reflectance_apparent", "radiance", "sun_ground_transmittance_gas", "spherical_albedo"})
      if (!run_.find(name)) problems_.add(title, std::string("the run has no ") + name, "", "the output is cut short");
  }

  /// E0 = solar spectrum in the band / width of the filter, or as a monochromatic run prints it; with it reflectance =
  /// pi L / (E0 cos sun), to the printed digits.
  void solar() {
    Column width, in_band;
    std::erase_if(run_.columns, [&](const Column& c) {
      if (c.name == "filter_width") width = c;
      if (c.name == "solar_irradiance_in_band") in_band = c;
      return c.unit.empty();
    });
    if (!width.values.empty() && !in_band.values.empty() && width.values[0] > 0 && in_band.values[0] > 0) {
      const double mean = in_band.values[0] / width.values[0],
                   part = in_band.rounding[0] / in_band.values[0] + width.rounding[0] / width.values[0];
      run_.columns.push_back({"channel_width", "um", "int. funct filter", {}, width.values, width.rounding});
      run_.columns.push_back(
          {"solar_irradiance", "W m-2 um-1", "int. sol. spect / int. funct filter", {}, {mean}, {mean * part}});
    }
    const Column* sun = run_.find("solar_irradiance");
    if (!sun || !(sun->values[0] > 0) || !run_.geometry.sun_zenith_deg) return;
    const Column reflectance = run_.at("reflectance_apparent"), radiance = run_.at("radiance");
    const double per_radiance =
        std::numbers::pi / (sun->values[0] * std::cos(base::rad_from_deg(*run_.geometry.sun_zenith_deg)));
    const double expected = per_radiance * radiance.values[0];
    // The sun's zenith is printed to 0.01 deg: tan(zenith) times half of that, in the cosine.
    const double angle_part = std::tan(base::rad_from_deg(*run_.geometry.sun_zenith_deg)) * base::rad_from_deg(0.005);
    const double allowed = reflectance.rounding[0] + per_radiance * radiance.rounding[0] +
                           expected * (sun->rounding[0] / sun->values[0] + angle_part + 1e-6);
    if (!(std::abs(expected - reflectance.values[0]) <= allowed))
      problems_.add({path_, title_line_, 0, ""}, "apparent reflectance and radiance disagree: pi L / (E0 cos sun)",
                    std::to_string(expected) + " against " + std::to_string(reflectance.values[0]),
                    "lines are damaged or of two runs");
  }

  const std::string& path_;
  std::vector<std::string> lines_;
  base::Problems problems_;
  std::size_t at_ = 0;
  int title_line_ = 0;
  bool started_ = false, monochromatic_ = false, table_ = false;
  std::vector<Column> rows_;  ///< of the table by wavelength
  Run run_;
};

}  // namespace

Imported read_sixs(const std::string& path) { return SixsReader(path).read(); }

}  // namespace raycube::atmos::imported
