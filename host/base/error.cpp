#include "host/base/error.h"

namespace raycube::base {

std::string Where::text() const {
  std::string out = file;
  if (line > 0) out += ":" + std::to_string(line);
  if (line > 0 && column > 0) out += ":" + std::to_string(column);
  if (!element.empty()) out += (out.empty() ? "" : ": ") + element;
  return out;
}

void Problems::add(const Where& where, const std::string& what, const std::string& found, const std::string& way_out) {
  std::string line = where.text();
  line += (line.empty() ? "" : ": ") + what;
  if (!found.empty()) line += " (found " + found + ")";
  if (!way_out.empty()) line += "; " + way_out;
  lines_.push_back(std::move(line));
}

void Problems::throw_if_any() const {
  if (lines_.empty()) return;
  std::string text;
  for (const auto& line : lines_) text += (text.empty() ? "" : "\n") + line;
  throw Error(Fault::input, text);
}

}  // namespace raycube::base
