#include "host/products/csv_writer.h"

#include <cmath>

#include <fmt/format.h>

#include "host/base/error.h"

namespace raycube::products {

CsvWriter::CsvWriter(base::OutputFile& file, std::vector<std::string> columns) : file_(file), columns_(columns.size()) {
  for (const auto& column : columns) add(column);
  end_row();
  rows_ = 0;
}

void CsvWriter::separate() {
  if (fields_++ > 0) buffer_ += ',';
}

CsvWriter& CsvWriter::add(double value) {
  separate();
  if (!std::isnan(value)) fmt::format_to(std::back_inserter(buffer_), "{}", value);
  return *this;
}

CsvWriter& CsvWriter::add(float value) {
  separate();
  if (!std::isnan(value)) fmt::format_to(std::back_inserter(buffer_), "{}", value);
  return *this;
}

CsvWriter& CsvWriter::add(std::int64_t value) {
  separate();
  fmt::format_to(std::back_inserter(buffer_), "{}", value);
  return *this;
}

CsvWriter& CsvWriter::add(std::string_view text) {
  separate();
  if (text.find_first_of(",\"\r\n") == std::string_view::npos) {
    buffer_ += text;
    return *this;
  }
  buffer_ += '"';
  for (const char c : text) buffer_.append(c == '"' ? 2 : 1, c);
  buffer_ += '"';
  return *this;
}

void CsvWriter::end_row() {
  if (fields_ != columns_)
    throw base::Error(base::Fault::bug,
                      fmt::format("{}: a row of {} fields under {} columns", file_.final_path(), fields_, columns_));
  buffer_ += '\n';
  fields_ = 0;
  ++rows_;
  if (buffer_.size() >= (std::size_t{1} << 20)) finish();
}

void CsvWriter::finish() {
  file_.append(buffer_);
  buffer_.clear();
}

}  // namespace raycube::products
