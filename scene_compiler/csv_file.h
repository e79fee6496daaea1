// Tables of numbers in text, apart by commas, with a header line and `# key: value` comments. A header without commas
// may be apart by semicolons or tabs; then numbers may have decimal commas, which is told.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "host/base/error.h"

namespace raycube::scene {

/// A CSV file's text cells. Empty lines and lines that begin with '#' are skipped; the first other line is
/// the header.
struct CsvFile {
  std::string file;
  std::map<std::string, std::string> comments;  ///< "# source: USGS ..." gives {"source", "USGS ..."}; lower-case keys
  int header_line = 0;
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;
  std::vector<int> row_lines;  ///< line number of each row

  std::optional<std::size_t> column(const std::string& name) const;
  std::string columns_text() const;
  /// Reports columns that are none of these, which would be passed over.
  void refuse_other_columns(const std::vector<std::string>& known, base::Problems& problems) const;
  base::Where at(std::size_t row, std::size_t column_index) const;
  /// The cell as a finite number; reports anything else ("nan", "******", "1,5", "") with line and value.
  std::optional<double> number(std::size_t row, std::size_t column_index, base::Problems& problems) const;
};

/// Reads the file; nullopt after reporting one that is missing, empty, without rows, of more than 65 536 columns, whose
/// columns share a name, or whose rows differ in length (the first of each length, and how many more). asked_by: the
/// key that names the file.
std::optional<CsvFile> read_csv(const std::string& file, const base::Where& asked_by, base::Problems& problems);

/// True when the file is there, readable and not empty; reports it otherwise.
bool check_readable(const std::string& file, const base::Where& asked_by, base::Problems& problems);

/// Opens a file for reading as a whole; nullopt after reporting a missing, unreadable or 0-byte file.
std::optional<std::string> read_whole_file(const std::string& file, const base::Where& asked_by,
                                           base::Problems& problems);

/// Number from text: the whole of it, finite or not; surrounding blanks and a leading '+' are allowed.
std::optional<double> parse_number(std::string text);
std::string trimmed(const std::string& text);
std::string lower_case(std::string text);
/// Whether a header or a unit says that values are in percent: "Reflectance (%)", "percent".
bool says_percent(const std::string& text);

}  // namespace raycube::scene
