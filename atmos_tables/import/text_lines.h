// Text of other codes: lines, fields and numbers as Fortran writes them.
#pragma once

#include <algorithm>
#include <functional>
#include <initializer_list>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "host/base/error.h"

namespace raycube::atmos::imported {

/// Lines of a file without their ends (LF or CR LF). Throws Error(environment) when it cannot be read, Error(input)
/// when empty.
std::vector<std::string> read_lines(const std::string& path);
/// The file's bytes.
std::string read_bytes(const std::string& path);

/// Whether `word` is one of `words`.
inline bool one_of(std::string_view word, std::initializer_list<std::string_view> words) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

std::string_view trimmed(std::string_view text);
std::vector<std::string_view> split_blanks(std::string_view line);
/// Fields between commas, blanks around them taken off. A comma at the end of the line closes the last field and opens
/// none.
std::vector<std::string_view> split_commas(std::string_view line);
/// Columns [first, first + count) of a card, shorter where the line ends.
std::string_view card_field(std::string_view line, std::size_t first, std::size_t count);

struct Number {
  enum class State { good, blank, overflow, not_finite, malformed } state = State::blank;
  double value = 0;
  double rounding = 0;  ///< half a unit of the last printed digit
  bool good() const { return state == State::good; }
};

/// One field. Reads exponents written without E ("1.234-105"), D exponents and leading or trailing points; `****` is
/// overflow.
Number read_number(std::string_view field);

/// As read_number; anything but a good number is added to `problems` with its place, naming `column`.
/// Negative numbers are added too unless `negative_allowed`.
Number need_number(std::string_view field, const base::Where& where, const std::string& column,
                   base::Problems& problems, bool negative_allowed = false);

/// The value as an int when it is a whole number from `lowest` to `highest`, else nothing.
std::optional<int> whole_number(double value, int lowest, int highest);

/// As need_number; what is not a whole number from `lowest` to `highest` is added to `problems` too and comes back as
/// `lowest`.
int need_whole(std::string_view field, const base::Where& where, const std::string& column, int lowest, int highest,
               base::Problems& problems);

/// Lines of sight and channels are numbered up to here at most.
constexpr int kMostNumbered = 1000000000;

/// More than this many problems in one file say no more; readers stop there.
constexpr std::size_t kEnoughProblems = 20;

/// A table between commas that this project defines: one line of column names, then rows of as many cells.
struct CsvTable {
  std::string of;  ///< "partition sums"
  std::vector<std::string_view> columns;
  std::string header_advice;  ///< where that line is another: "give that header line"
};

/// Hands every row of `table` in `file` to `take`; empty lines and those that begin with # are none. Another header
/// line ends the reading, rows of another length are left out, and so is what follows kEnoughProblems: all are added to
/// `problems`. Throws as read_lines.
void read_rows(const std::string& file, const CsvTable& table, base::Problems& problems,
               const std::function<void(const std::vector<std::string_view>& cells, const base::Where&,
                                        const std::string& line)>& take);

/// A number in a message: six digits.
inline std::string shown(double value) {
  std::ostringstream out;
  out << value;
  return out.str();
}

}  // namespace raycube::atmos::imported
