#include "scene_compiler/csv_file.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "host/base/input_file.h"
#include "host/base/text.h"

namespace raycube::scene {
namespace {

constexpr std::size_t kMostColumns = 65536;

/// The cells of a line, at most `most` of them, and how many there are.
struct Cells {
  std::vector<std::string> text;
  std::size_t count = 0;
};
Cells split_cells(const std::string& line, char separator, std::size_t most) {
  Cells out{std::vector<std::string>(1), 1};
  bool quoted = false;
  for (const char c : line) {
    if (c == '"') {
      quoted = !quoted;
    } else if (c == separator && !quoted) {
      if (++out.count <= most) out.text.emplace_back();
    } else if (out.count <= most) {
      out.text.back() += c;
    }
  }
  for (auto& cell : out.text) cell = trimmed(cell);
  return out;
}

/// By what the columns of a header are apart.
char separator_of(const std::string& header) {
  for (const char c : {',', ';', '\t'})
    if (header.find(c) != std::string::npos) return c;
  return ',';
}

/// Makes "0.25" of a cell "0,25"; false: it is no such number.
bool take_decimal_comma(std::string& cell) {
  const auto comma = cell.find(',');
  if (comma == std::string::npos) return false;
  std::string other = cell;
  other[comma] = '.';
  if (!parse_number(other)) return false;
  cell = other;
  return true;
}

void read_comment(const std::string& line, CsvFile& csv) {
  const auto colon = line.find(':');
  if (colon == std::string::npos) return;
  const auto start = line.find_first_not_of("# \t");
  if (start == std::string::npos || start >= colon) return;
  const std::string key = lower_case(trimmed(line.substr(start, colon - start)));
  csv.comments.emplace(key, trimmed(line.substr(colon + 1)));
}

}  // namespace

std::string trimmed(const std::string& text) {
  const auto first = text.find_first_not_of(" \t\r\n");
  if (first == std::string::npos) return "";
  return text.substr(first, text.find_last_not_of(" \t\r\n") - first + 1);
}

std::string lower_case(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

std::optional<double> parse_number(std::string text) {
  text = trimmed(text);
  if (text.size() > 1 && text[0] == '+' && text[1] != '-' && text[1] != '+') text.erase(0, 1);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

bool says_percent(const std::string& text) {
  return text.find('%') != std::string::npos || lower_case(text).find("percent") != std::string::npos;
}

bool check_readable(const std::string& file, const base::Where& asked_by, base::Problems& problems) {
  std::error_code ignored;
  const std::string why = base::why_no_plain_file(file);
  if (!why.empty()) {
    problems.add(asked_by, "cannot read file", std::filesystem::exists(file, ignored) ? file + ", which " + why : file,
                 "check the path; it is relative to the file that names it");
    return false;
  }
  if (std::filesystem::file_size(file, ignored) == 0) {
    problems.add({file, 0, 0, ""}, "file is empty", "0 bytes", "restore it; " + asked_by.text() + " names it");
    return false;
  }
  return true;
}

std::optional<std::string> read_whole_file(const std::string& file, const base::Where& asked_by,
                                           base::Problems& problems) {
  if (!check_readable(file, asked_by, problems)) return std::nullopt;
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  return std::move(text).str();
}

std::optional<std::size_t> CsvFile::column(const std::string& name) const {
  const auto found = std::find(columns.begin(), columns.end(), lower_case(name));
  if (found == columns.end()) return std::nullopt;
  return static_cast<std::size_t>(found - columns.begin());
}

void CsvFile::refuse_other_columns(const std::vector<std::string>& known, base::Problems& problems) const {
  std::string names;
  for (const std::string& name : known) names += (names.empty() ? "" : ", ") + name;
  for (const std::string& name : columns)
    if (std::find(known.begin(), known.end(), name) == known.end())
      problems.add({file, header_line, 0, ""}, "unknown column", "'" + name + "'", "columns here: " + names);
}

std::string CsvFile::columns_text() const {
  std::string out;
  for (const auto& name : columns) out += (out.empty() ? "" : ",") + name;
  return out;
}

base::Where CsvFile::at(std::size_t row, std::size_t column_index) const {
  return {file, row_lines[row], 0, "column '" + columns[column_index] + "'"};
}

std::optional<double> CsvFile::number(std::size_t row, std::size_t column_index, base::Problems& problems) const {
  const std::string& cell = rows[row][column_index];
  const auto value = parse_number(cell);
  if (value && std::isfinite(*value)) return value;
  problems.add(at(row, column_index), "not a finite number", cell.empty() ? "nothing" : "'" + cell + "'",
               "give a number like 0.25, or remove the line");
  return std::nullopt;
}

std::optional<CsvFile> read_csv(const std::string& file, const base::Where& asked_by, base::Problems& problems) {
  const auto text = read_whole_file(file, asked_by, problems);
  if (!text) return std::nullopt;
  CsvFile csv;
  csv.file = file;
  std::istringstream stream(base::without_dos_end(*text));
  std::string line;
  struct Uneven {
    std::size_t count = 0;
    int line = 0;
    std::string text;
  };
  std::map<std::size_t, Uneven> uneven;  // by their number of cells
  std::size_t decimal_commas = 0;
  char separator = ',';
  for (int number = 1; std::getline(stream, line); ++number) {
    if (number == 1 && line.starts_with("\xEF\xBB\xBF")) line.erase(0, 3);
    const std::string bare = trimmed(line);
    if (bare.empty()) continue;
    if (bare[0] == '#') {
      read_comment(bare, csv);
    } else if (csv.columns.empty()) {
      csv.header_line = number;
      separator = separator_of(bare);
      const Cells names = split_cells(bare, separator, kMostColumns);
      if (names.count > kMostColumns) {
        problems.add({file, number, 0, ""}, "more than 65 536 columns", std::to_string(names.count),
                     "give a table of fewer; " + asked_by.text() + " names it");
        return std::nullopt;
      }
      for (const std::string& name : names.text) csv.columns.push_back(lower_case(name));
    } else {
      Cells cells = split_cells(bare, separator, csv.columns.size());
      if (cells.count != csv.columns.size()) {
        Uneven& rows = uneven[cells.count];
        if (rows.count++ == 0) rows.line = number, rows.text = bare.substr(0, 60);
        continue;
      }
      if (separator != ',')
        for (std::string& cell : cells.text) decimal_commas += take_decimal_comma(cell);
      csv.rows.push_back(std::move(cells.text));
      csv.row_lines.push_back(number);
    }
  }
  for (const auto& [count, rows] : uneven) {
    const bool commas = separator == ',' && count > csv.columns.size() && count <= 2 * csv.columns.size();
    problems.add({file, rows.line, 0, ""}, "row has " + base::counted(count, "cell"),
                 rows.text + (rows.count > 1 ? ", and " + base::counted(rows.count - 1, "more row") + " like it" : ""),
                 "the header on line " + std::to_string(csv.header_line) + " names " +
                     base::counted(csv.columns.size(), "column") +
                     (commas ? "; if these are decimal commas, write points, or separate columns by semicolons" : ""));
  }
  if (decimal_commas > 0)
    problems.tell({file, 0, 0, ""}, base::counted(decimal_commas, "number") + " with decimal commas read as such");
  std::map<std::string, std::size_t> number_of;
  for (std::size_t i = 0; i < csv.columns.size(); ++i) {
    const auto [first, alone] = number_of.emplace(csv.columns[i], i);
    if (alone || csv.columns[i].empty()) continue;
    problems.add(
        {file, csv.header_line, 0, ""}, "two columns have one name",
        "'" + csv.columns[i] + "' is column " + std::to_string(first->second + 1) + " and " + std::to_string(i + 1),
        "name each once");
    return std::nullopt;
  }
  if (csv.rows.empty() && uneven.empty()) {
    problems.add({file, 0, 0, ""}, "file has no rows", base::counted(text->size(), "byte"),
                 "give a header line and at least one row; " + asked_by.text() + " names it");
    return std::nullopt;
  }
  return uneven.empty() ? std::optional(std::move(csv)) : std::nullopt;
}

}  // namespace raycube::scene
