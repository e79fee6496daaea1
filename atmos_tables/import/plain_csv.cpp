#include "atmos_tables/import/plain_csv.h"

#include <cctype>
#include <optional>

#include "atmos_tables/import/conversions.h"
#include "atmos_tables/import/text_lines.h"

namespace raycube::atmos::imported {

namespace {

struct Unit {
  const char *theirs, *ours;
  double (*converted)(double value, double wavelength_um);
};

double per_cm(double value, double um) { return base::W_per_m2_sr_um_from_W_per_cm2_sr_per_cm(value, um); }

constexpr Unit kUnits[] = {
    {"1", "1", [](double value, double) { return value; }},
    {"K", "K", [](double value, double) { return value; }},
    {"um", "um", [](double value, double) { return value; }},
    {"W m-2 sr-1 um-1", "W m-2 sr-1 um-1", [](double value, double) { return value; }},
    {"W cm-2 sr-1 um-1", "W m-2 sr-1 um-1",
     [](double value, double) { return base::W_per_m2_sr_um_from_W_per_cm2_sr_um(value); }},
    {"uW cm-2 sr-1 nm-1", "W m-2 sr-1 um-1",
     [](double value, double) { return base::W_per_m2_sr_um_from_uW_per_cm2_sr_nm(value); }},
    {"W cm-2 sr-1 (cm-1)-1", "W m-2 sr-1 um-1", per_cm},
    {"W m-2 um-1", "W m-2 um-1", [](double value, double) { return value; }},
    {"W m-2 nm-1", "W m-2 um-1", [](double value, double) { return W_per_m2_um_from_W_per_m2_nm(value); }},
    {"mW m-2 nm-1", "W m-2 um-1", [](double value, double) { return W_per_m2_um_from_mW_per_m2_nm(value); }},
    {"W cm-2 (cm-1)-1", "W m-2 um-1", per_cm},
};

std::string known_units() {
  std::string out;
  for (const Unit& unit : kUnits) out += (out.empty() ? "" : ", ") + std::string(unit.theirs);
  return out;
}

struct Label {
  std::string name, unit;
};

std::optional<Label> label_of(std::string_view cell) {
  const std::size_t open = cell.find('[');
  if (open == std::string_view::npos || cell.back() != ']') return std::nullopt;
  Label label{std::string(trimmed(cell.substr(0, open))),
              std::string(trimmed(cell.substr(open + 1, cell.size() - open - 2)))};
  for (const char c : label.name)
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '_') return std::nullopt;
  if (label.name.empty()) return std::nullopt;
  return label;
}

std::optional<AxisUnit> axis_of(const Label& label) {
  if (label.name == "wavelength" && label.unit == "um") return AxisUnit::um;
  if (label.name == "wavelength" && label.unit == "nm") return AxisUnit::nm;
  if (label.name == "wavenumber" && label.unit == "cm-1") return AxisUnit::per_cm;
  return std::nullopt;
}

class PlainReader {
 public:
  explicit PlainReader(const std::string& path) : path_(path) {}

  Imported read() {
    const auto lines = read_lines(path_);
    for (std::size_t i = 0; i < lines.size() && problems_.count() < kEnoughProblems; ++i) {
      const std::string_view line = trimmed(lines[i]);
      if (line.empty() || line.front() == '#') continue;
      here_ = {path_, static_cast<int>(i) + 1, 0, ""};
      if (header_.line > 0)
        row(split_commas(line));
      else
        header(split_commas(line));
    }
    if (run_.wavelength_um.empty() && problems_.empty())
      problems_.add({path_, 0, 0, ""}, "no data rows", "", "the file is cut short");
    if (problems_.empty()) {
      sort_ascending(run_);
      check_run(run_, header_, problems_);
    }
    problems_.throw_if_any();
    return {path_, "plain CSV", "plain-csv", {std::move(run_)}};
  }

 private:
  void header(const std::vector<std::string_view>& cells) {
    header_ = here_;
    run_.mode = "columns";
    for (const auto& cell : cells) {
      const auto label = label_of(cell);
      const bool first = &cell == &cells.front();
      const Unit* unit = nullptr;
      for (const Unit& known : kUnits)
        if (label && label->unit == known.theirs) unit = &known;
      if (first && label && axis_of(*label)) {
        axis_ = *axis_of(*label);
      } else if (first) {
        problems_.add(here_, "the first column is no axis", std::string(cell),
                      "write wavelength [um], wavelength [nm] or wavenumber [cm-1]");
      } else if (!unit) {
        problems_.add(here_, "a column is not `name [unit]` with a known unit", std::string(cell),
                      "known: " + known_units());
      } else {
        units_.push_back(unit);
        run_.columns.push_back({label->name, unit->ours, std::string(cell), {}, {}, {}});
      }
    }
    if (cells.size() < 2) problems_.add(here_, "no columns beside the axis", "", "");
    problems_.throw_if_any();
  }

  void row(const std::vector<std::string_view>& cells) {
    if (cells.size() != units_.size() + 1) {
      problems_.add(here_, "the row has another number of fields than the header",
                    std::to_string(cells.size()) + " of " + std::to_string(units_.size() + 1),
                    "the row is damaged or cut short");
      return;
    }
    const Number axis = need_number(cells[0], here_, "the axis", problems_);
    if (!axis.good()) return;
    if (axis.value <= 0) {
      problems_.add(here_, "the axis is not above 0", std::string(cells[0]), "");
      return;
    }
    const double um = wavelength_um_from_axis(axis.value, axis_);
    auto& known = run_.wavelength_um;
    if (!known.empty() && (um == known.back() || (known.size() > 1 && (um > known.back()) != (known[1] > known[0]))))
      problems_.add(here_, "the axis does not keep its order", std::string(cells[0]),
                    "rows are out of order or doubled");
    known.push_back(um);
    for (std::size_t i = 0; i < units_.size(); ++i) {
      const Number number = need_number(cells[i + 1], here_, run_.columns[i].name, problems_);
      run_.columns[i].values.push_back(units_[i]->converted(number.value, um));
      run_.columns[i].rounding.push_back(units_[i]->converted(number.rounding, um));
    }
  }

  const std::string& path_;
  base::Problems problems_;
  base::Where here_, header_;
  AxisUnit axis_ = AxisUnit::um;
  std::vector<const Unit*> units_;
  Run run_;
};

}  // namespace

Imported read_plain_csv(const std::string& path) { return PlainReader(path).read(); }

}  // namespace raycube::atmos::imported
