#include "scene_compiler/csv_file.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "host/base/input_file.h"

namespace raycube::scene {
namespace {

std::vector<std::string> split_cells(const std::string& line) {
  std::vector<std::string> cells(1);
  bool quoted = false;
  for (const char c : line) {
    if (c == '"')
      quoted = !quoted;
    else if (c == ',' && !quoted)
      cells.emplace_back();
    else
      cells.back() += c;
  }
  for (auto& cell : cells) cell = trimmed(cell);
  return cells;
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
  std::istringstream stream(*text);
  std::string line;
  bool sound = true;
  for (int number = 1; std::getline(stream, line); ++number) {
    if (number == 1 && line.starts_with("\xEF\xBB\xBF")) line.erase(0, 3);
    const std::string bare = trimmed(line);
    if (bare.empty()) continue;
    if (bare[0] == '#') {
      read_comment(bare, csv);
    } else if (csv.columns.empty()) {
      csv.header_line = number;
      for (auto& name : split_cells(bare)) csv.columns.push_back(lower_case(name));
    } else {
      auto cells = split_cells(bare);
      if (cells.size() != csv.columns.size()) {
        problems.add({file, number, 0, ""}, "row has " + std::to_string(cells.size()) + " cells", bare.substr(0, 60),
                     "the header on line " + std::to_string(csv.header_line) + " names " +
                         std::to_string(csv.columns.size()) + " columns");
        sound = false;
        continue;
      }
      csv.rows.push_back(std::move(cells));
      csv.row_lines.push_back(number);
    }
  }
  if (csv.rows.empty() && sound) {
    problems.add({file, 0, 0, ""}, "file has no rows", std::to_string(text->size()) + " bytes",
                 "give a header line and at least one row; " + asked_by.text() + " names it");
    return std::nullopt;
  }
  return sound ? std::optional(std::move(csv)) : std::nullopt;
}

}  // namespace raycube::scene
