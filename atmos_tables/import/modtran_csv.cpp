#include "atmos_tables/import/modtran_csv.h"

#include <algorithm>

#include "host/base/text.h"
#include "atmos_tables/import/modtran_axis.h"
#include "atmos_tables/import/modtran_names.h"
#include "atmos_tables/import/text_lines.h"

namespace raycube::atmos::imported {

namespace {

using Cells = std::vector<std::string_view>;

bool starts_with_freq(const Cells& cells) { return !cells.empty() && label_key(cells[0]).rfind("FREQ", 0) == 0; }

bool is_data(const Cells& cells) { return !cells.empty() && read_number(cells[0]).state != Number::State::malformed; }

/// Rows of numbers under a header, checked for width and order.
struct Table {
  std::vector<std::vector<Number>> rows;
  std::vector<int> lines;

  void add(const Cells& cells, const std::vector<std::string>& labels, const base::Where& where,
           base::Problems& problems) {
    if (cells.size() != labels.size()) {
      problems.add(where, "the row has another number of fields than the header",
                   std::to_string(cells.size()) + " of " + std::to_string(labels.size()),
                   "the row is damaged or cut short");
      return;
    }
    std::vector<Number> row;
    for (std::size_t i = 0; i < cells.size(); ++i) row.push_back(need_number(cells[i], where, labels[i], problems));
    if (row[0].good() && row[0].value <= 0)
      problems.add(where, "a frequency is not above 0", std::string(cells[0]), "");
    const std::size_t n = rows.size();
    if (n > 0) {
      const double before = rows[n - 1][0].value,
                   first = n > 1 ? rows[1][0].value - rows[0][0].value : row[0].value - before;
      if (row[0].value == before || (row[0].value > before) != (first > 0))
        problems.add(where, labels[0] + " does not keep its order",
                     std::to_string(row[0].value) + " after " + std::to_string(before),
                     "rows are out of order or doubled");
    }
    rows.push_back(std::move(row));
    lines.push_back(where.line);
  }
};

/// Axis and unit of a table into the run; false when there is nothing to go on with.
bool set_axis(Run& run, AxisUnit& unit, const Table& table, const std::string& label, const base::Where& where,
              base::Problems& problems) {
  if (table.rows.empty()) {
    problems.add(where, "no data rows below the header", "", "the file is cut short");
    return false;
  }
  if (!problems.empty()) return false;
  const auto settled =
      settle_axis(label, table.rows.front()[0].value, table.rows.back()[0].value, std::nullopt, where, problems);
  if (!settled) return false;
  unit = *settled;
  for (const auto& row : table.rows) run.wavelength_um.push_back(wavelength_um_from_axis(row[0].value, unit));
  return true;
}

Imported read_spectra(const std::string& path, const std::vector<std::string>& lines) {
  Imported out{path, "MODTRAN 6", "csv", {}};
  base::Problems problems;
  std::vector<std::string> labels;
  std::string axis_label;
  Table table;
  base::Where header{path, 0, 0, ""};
  const auto finish = [&] {
    Run run;
    AxisUnit unit;
    if (!set_axis(run, unit, table, axis_label, header, problems)) return;
    for (std::size_t i = 1; i < labels.size(); ++i) {
      const auto quantity = modtran_quantity(labels[i]);
      if (!quantity) {
        run.notes.push_back("column " + labels[i] + " is not known and was left out");
        continue;
      }
      Column column = modtran_column(*quantity, labels[i]);
      for (std::size_t k = 0; k < table.rows.size(); ++k)
        append_modtran(column, quantity->kind, table.rows[k][i], unit, run.wavelength_um[k]);
      run.columns.push_back(std::move(column));
    }
    run.mode = run.find("radiance") ? "radiance" : "transmittance";
    if (run.find("radiance")) settle_radiance(run, header, table.lines, problems);
    sort_ascending(run);
    check_run(run, header, problems);
    out.runs.push_back(std::move(run));
  };
  for (std::size_t i = 0; i < lines.size() && problems.count() < kEnoughProblems; ++i) {
    const Cells cells = split_commas(lines[i]);
    const base::Where here{path, static_cast<int>(i) + 1, 0, ""};
    if (starts_with_freq(cells)) {
      if (!labels.empty()) finish();
      labels.assign(cells.begin(), cells.end());
      axis_label = labels[0], header = here, table = {};
    } else if (labels.empty() || cells.empty()) {
      continue;
    } else if (is_data(cells)) {
      table.add(cells, labels, here, problems);
    } else if (table.rows.empty() && i == static_cast<std::size_t>(header.line)) {
      axis_label += " " + std::string(cells[0]);
    } else if (!table.rows.empty()) {
      problems.add(here, "a row without numbers among the data", std::string(cells[0]), "is the file whole?");
    }
  }
  if (labels.empty())
    problems.add(header, "no row of labels that starts with Freq", "", "is it a CSV file of MODTRAN 6?");
  else if (problems.count() < kEnoughProblems)
    finish();
  problems.throw_if_any();
  return out;
}

/// "1 KM" or "0.5 KM" to metres.
std::optional<double> level_m(std::string_view cell) {
  const auto words = split_blanks(cell);
  const Number number = words.empty() ? Number{} : read_number(words[0]);
  if (words.size() != 2 || label_key(words[1]) != "KM" || !number.good()) return std::nullopt;
  return m_from_km(number.value);
}

class FluxReader {
 public:
  FluxReader(const std::string& path, const std::vector<std::string>& lines) : path_(path), lines_(lines) {}

  Imported read() {
    Imported out{path_, "MODTRAN 6", "flux csv", {}};
    for (at_ = 0; at_ < lines_.size(); ++at_)
      if (lines_[at_].rfind("case index", 0) == 0) {
        one_case(out);
        if (!problems_.empty()) break;
      }
    problems_.throw_if_any();
    return out;
  }

 private:
  base::Where here() const { return {path_, static_cast<int>(std::min(at_, lines_.size() - 1)) + 1, 0, ""}; }
  Cells next() {
    ++at_;
    while (at_ < lines_.size() && trimmed(lines_[at_]).empty()) ++at_;
    return at_ < lines_.size() ? split_commas(lines_[at_]) : Cells();
  }

  std::optional<std::size_t> count(const char* word) {
    const Cells cells = next();
    const Number number =
        cells.size() == 2 && label_key(cells[0]) == label_key(word) ? read_number(cells[1]) : Number{};
    if (number.good() && number.value >= 1 && number.value < 1e8) return static_cast<std::size_t>(number.value);
    problems_.add(here(), std::string("a line \"") + word + ", N\" belongs here",
                  at_ < lines_.size() ? lines_[at_].substr(0, 40) : "the end of the file", "is the file whole?");
    return std::nullopt;
  }

  void one_case(Imported& out) {
    const auto rows = count("num freq"), columns = rows ? count("num column") : std::nullopt;
    if (!columns) return;
    const Cells label_cells = next();
    const std::vector<std::string> labels(label_cells.begin(), label_cells.end());
    const base::Where header = here();
    const Cells units = next();
    if (!starts_with_freq(label_cells) || (labels.size() != *columns && labels.size() != *columns + 1) ||
        units.size() != labels.size()) {
      problems_.add(header, "labels and levels do not fit \"num column\"",
                    base::counted(labels.size(), "label") + ", " + base::counted(units.size(), "level") + ", " +
                        std::to_string(*columns) + " columns",
                    "is the file whole?");
      return;
    }
    Run run;
    run.mode = "fluxes";
    for (std::size_t i = 1; i < labels.size(); ++i) {
      const std::string key = label_key(labels[i]);
      const auto height = level_m(units[i]);
      const char* name = key == "UP"      ? "irradiance_up"
                         : key == "DOWN"  ? "irradiance_down_diffuse"
                         : key == "SOLAR" ? "irradiance_down_direct"
                                          : nullptr;
      if (!name || !height)
        problems_.add(header, "not UP, DOWN or SOLAR at a level in KM", labels[i] + ", " + std::string(units[i]), "");
      else
        run.columns.push_back(
            {name, "W m-2 um-1", labels[i] + " " + std::string(units[i]), {height, false, {}, {}, {}}, {}, {}});
    }
    const std::string axis_label = labels[0] + " " + std::string(units[0]);
    Table table;
    bool closed = false;
    for (Cells cells = next(); at_ < lines_.size() && problems_.count() < kEnoughProblems; cells = next()) {
      if (!cells.empty() && cells[0] == "}") {
        closed = true;
        break;
      }
      table.add(cells, labels, here(), problems_);
    }
    if (!closed || table.rows.size() != *rows)
      problems_.add(here(), "the case is not whole",
                    std::to_string(table.rows.size()) + " of " + std::to_string(*rows) + " frequencies" +
                        (closed ? "" : ", no closing }"),
                    "the file is cut short");
    AxisUnit unit;
    if (!problems_.empty() || !set_axis(run, unit, table, axis_label, header, problems_)) return;
    for (std::size_t i = 1; i < labels.size(); ++i)
      for (std::size_t k = 0; k < table.rows.size(); ++k)
        append_modtran(run.columns[i - 1], Kind::irradiance, table.rows[k][i], unit, run.wavelength_um[k]);
    sort_ascending(run);
    check_run(run, header, problems_);
    out.runs.push_back(std::move(run));
  }

  const std::string& path_;
  const std::vector<std::string>& lines_;
  std::size_t at_ = 0;
  base::Problems problems_;
};

}  // namespace

Imported read_modtran_csv(const std::string& path) {
  const auto lines = read_lines(path);
  const bool flux =
      std::any_of(lines.begin(), lines.end(), [](const std::string& line) { return line.rfind("case index", 0) == 0; });
  return flux ? FluxReader(path, lines).read() : read_spectra(path, lines);
}

}  // namespace raycube::atmos::imported
