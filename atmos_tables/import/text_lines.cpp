#include "atmos_tables/import/text_lines.h"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>

#include "host/base/input_file.h"
#include "host/base/text.h"

namespace raycube::atmos::imported {

namespace {

bool blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

}  // namespace

std::string read_bytes(const std::string& path) {
  base::refuse_other_than_plain(path);
  std::ifstream in(path, std::ios::binary);
  std::string bytes;
  if (in) bytes.assign(std::istreambuf_iterator<char>(in), {});
  if (!in || in.bad())
    throw base::Error(base::Fault::environment, path + ": cannot be read (" + std::strerror(errno) + ")");
  if (bytes.empty()) throw base::Error(base::Fault::input, path + ": the file is empty; was the run cut short?");
  return bytes;
}

std::vector<std::string> read_lines(const std::string& path) {
  const std::string bytes = read_bytes(path);
  std::vector<std::string> lines;
  const std::size_t mark = bytes.rfind("\xEF\xBB\xBF", 0) == 0 ? 3 : 0;  // of UTF-8, as editors put it
  for (std::size_t from = mark; from < bytes.size();) {
    const std::size_t end = std::min(bytes.find('\n', from), bytes.size());
    lines.emplace_back(bytes, from, end - from);
    if (!lines.back().empty() && lines.back().back() == '\r') lines.back().pop_back();
    if (lines.back().find('\0') != std::string::npos)
      throw base::Error(base::Fault::input,
                        path + ":" + std::to_string(lines.size()) + ": a zero byte; this is no text file");
    from = end + 1;
  }
  return lines;
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && blank(text.back())) text.remove_suffix(1);
  return text;
}

std::vector<std::string_view> split_blanks(std::string_view line) {
  std::vector<std::string_view> out;
  for (std::size_t i = 0; i < line.size();) {
    while (i < line.size() && blank(line[i])) ++i;
    const std::size_t from = i;
    while (i < line.size() && !blank(line[i])) ++i;
    if (i > from) out.push_back(line.substr(from, i - from));
  }
  return out;
}

std::vector<std::string_view> split_commas(std::string_view line) {
  std::vector<std::string_view> out;
  line = trimmed(line);
  while (!line.empty()) {
    const std::size_t end = std::min(line.find(','), line.size());
    out.push_back(trimmed(line.substr(0, end)));
    line.remove_prefix(std::min(end + 1, line.size()));
  }
  return out;
}

std::string_view card_field(std::string_view line, std::size_t first, std::size_t count) {
  return first >= line.size() ? std::string_view() : line.substr(first, count);
}

Number read_number(std::string_view field) {
  Number out;
  field = trimmed(field);
  if (field.empty()) return out;
  if (field.find('*') != std::string_view::npos) return out.state = Number::State::overflow, out;
  out.state = Number::State::malformed;
  std::size_t i = 0;
  std::string plain;
  if (field[i] == '+' || field[i] == '-') {
    if (field[i] == '-') plain += '-';
    ++i;
  }
  std::string word;
  for (std::size_t j = i; j < field.size(); ++j)
    word += static_cast<char>(std::tolower(static_cast<unsigned char>(field[j])));
  if (word.rfind("nan", 0) == 0 || word.rfind("inf", 0) == 0) return out.state = Number::State::not_finite, out;
  int digits = 0, decimals = 0;
  bool point = false;
  for (; i < field.size(); ++i) {
    if (std::isdigit(static_cast<unsigned char>(field[i])))
      ++digits, decimals += point;
    else if (field[i] == '.' && !point)
      point = true;
    else
      break;
    plain += field[i];
  }
  if (digits == 0) return out;
  int exponent = 0;
  const bool exponent_written = i < field.size();
  if (exponent_written) {
    const bool letter = std::strchr("eEdD", field[i]) != nullptr;
    if (letter) ++i;
    bool minus = false;
    if (i < field.size() && (field[i] == '+' || field[i] == '-'))
      minus = field[i++] == '-';
    else if (!letter)
      return out;
    const auto [end, error] = std::from_chars(field.data() + i, field.data() + field.size(), exponent);
    if (error != std::errc() || end != field.data() + field.size() || exponent < 0 || exponent > 400) return out;
    if (minus) exponent = -exponent;
  }
  plain += "e" + std::to_string(exponent);
  const char* end = plain.data() + plain.size();
  const auto [at, error] = std::from_chars(plain.data(), end, out.value);
  if (error == std::errc::result_out_of_range) {
    if (exponent > 0) return out.state = Number::State::not_finite, out;
    out.value = 0;  // below the smallest double
  } else if (error != std::errc() || at != end) {
    return out;
  }
  // "0.0000E+00" is a zero, not a number below 0.00005: with an exponent of its own anything larger would have been
  // printed.
  out.rounding = out.value == 0 && exponent_written ? 0 : 0.5 * std::pow(10.0, exponent - decimals);
  out.state = Number::State::good;
  return out;
}

std::optional<int> whole_number(double value, int lowest, int highest) {
  if (!(value >= lowest && value <= highest) || value != std::floor(value)) return std::nullopt;
  return static_cast<int>(value);
}

int need_whole(std::string_view field, const base::Where& where, const std::string& column, int lowest, int highest,
               base::Problems& problems) {
  const Number number = need_number(field, where, column, problems, true);
  if (!number.good()) return lowest;
  const auto whole = whole_number(number.value, lowest, highest);
  if (!whole)
    problems.add(where,
                 column + " is not a whole number from " + std::to_string(lowest) + " to " + std::to_string(highest),
                 std::string(trimmed(field)), "correct the row");
  return whole.value_or(lowest);
}

Number need_number(std::string_view field, const base::Where& where, const std::string& column,
                   base::Problems& problems, bool negative_allowed) {
  const Number number = read_number(field);
  const std::string found(trimmed(field));
  switch (number.state) {
    case Number::State::good:
      if (number.value < 0 && !negative_allowed)
        problems.add(where, column + " is negative", found, "it cannot be; run the code anew");
      break;
    case Number::State::blank:
      problems.add(where, column + " is blank", "", "the row is cut short or its fields have moved");
      break;
    case Number::State::overflow:
      problems.add(where, column + " did not fit its field", found,
                   "the code could not print it; run it anew with other units");
      break;
    case Number::State::not_finite:
      problems.add(where, column + " is not finite", found, "run the code anew");
      break;
    case Number::State::malformed:
      problems.add(where, column + " is no number", found, "is the file whole?");
      break;
  }
  return number;
}

void read_rows(const std::string& file, const CsvTable& table, base::Problems& problems,
               const std::function<void(const std::vector<std::string_view>& cells, const base::Where&,
                                        const std::string& line)>& take) {
  bool headed = false;
  int number = 0;
  for (const std::string& line : read_lines(file)) {
    ++number;
    if (trimmed(line).empty() || line[0] == '#') continue;
    const base::Where where{file, number, 0, ""};
    const std::vector<std::string_view> cells = split_commas(line);
    if (!headed) {
      headed = true;
      if (cells == table.columns) continue;
      std::string names;
      for (const std::string_view name : table.columns) names.append(names.empty() ? "" : ",").append(name);
      problems.add(where, "the columns of " + table.of + " are " + names, "'" + line + "'", table.header_advice);
      return;
    }
    if (problems.count() >= kEnoughProblems) return;
    if (cells.size() == table.columns.size())
      take(cells, where, line);
    else
      problems.add(where, "needs " + base::counted(table.columns.size(), "cell"), std::to_string(cells.size()),
                   "complete the row");
  }
}

}  // namespace raycube::atmos::imported
