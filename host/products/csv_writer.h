// Tables as CSV (RFC 4180 with line feeds), row by row.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "host/base/output_file.h"

namespace raycube::products {

/// Numbers have the fewest digits that read back to the same value; not a number is an empty field.
class CsvWriter {
 public:
  /// columns: names with their unit, as in "range_m".
  CsvWriter(base::OutputFile& file, std::vector<std::string> columns);

  CsvWriter& add(double value);
  CsvWriter& add(float value);
  CsvWriter& add(std::int64_t value);
  CsvWriter& add(int value) { return add(static_cast<std::int64_t>(value)); }
  CsvWriter& add(std::string_view text);
  /// Throws Error(bug) when the row has not as many fields as there are columns.
  void end_row();
  void finish();
  std::uint64_t rows() const { return rows_; }

 private:
  void separate();

  base::OutputFile& file_;
  std::size_t columns_ = 0, fields_ = 0;
  std::uint64_t rows_ = 0;
  std::string buffer_;
};

}  // namespace raycube::products
