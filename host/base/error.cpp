#include "host/base/error.h"

#include <cstdio>

namespace raycube::base {

namespace {

/// Bytes of the UTF-8 character that begins at `at`; 0: none does, or it is no printing one.
std::size_t printing_bytes(const std::string& text, std::size_t at) {
  const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u; };
  const unsigned first = byte(at);
  if (first < 0x80) return first >= 0x20 && first != 0x7f ? 1 : 0;
  const std::size_t bytes = first >= 0xc2 && first < 0xe0   ? 2
                            : first >= 0xe0 && first < 0xf0 ? 3
                            : first >= 0xf0 && first < 0xf5 ? 4
                                                            : 0;
  for (std::size_t i = 1; i < bytes; ++i)
    if ((byte(at + i) & 0xc0) != 0x80) return 0;
  return bytes;
}

/// Text of a file that need not be text: what does not print as \xNN, so that no byte ends a message or garbles it.
std::string printing(const std::string& text) {
  std::string out;
  for (std::size_t i = 0; i < text.size();) {
    if (const std::size_t bytes = printing_bytes(text, i); bytes > 0) {
      out.append(text, i, bytes);
      i += bytes;
      continue;
    }
    char hex[8];
    std::snprintf(hex, sizeof hex, "\\x%02x", static_cast<unsigned>(static_cast<unsigned char>(text[i++])));
    out += hex;
  }
  return out;
}

constexpr std::size_t kMostOfAKind = 20;

/// A rule without the names and numbers that it is told with.
std::string kind_of(const std::string& what) {
  std::string out;
  bool quoted = false;
  for (const char c : what) {
    if (c == '\'') quoted = !quoted;
    if (!quoted && !(c >= '0' && c <= '9')) out += c;
  }
  return out;
}

}  // namespace

std::string Where::text() const {
  std::string out = file;
  if (line > 0) out += ":" + std::to_string(line);
  if (line > 0 && column > 0) out += ":" + std::to_string(column);
  if (!element.empty()) out += (out.empty() ? "" : ": ") + element;
  return out;
}

void Problems::add(const Where& where, const std::string& what, const std::string& found, const std::string& way_out) {
  ++count_;
  Kind& kind = kinds_[where.file + '\n' + kind_of(what)];
  if (kind.count++ == 0) kind.file = where.file, kind.what = what;
  if (kind.count > kMostOfAKind) return;
  std::string line = where.text();
  line += (line.empty() ? "" : ": ") + what;
  if (!found.empty()) line += " (found " + printing(found) + ")";
  if (!way_out.empty()) line += "; " + way_out;
  lines_.push_back(std::move(line));
}

void Problems::tell(const Where& where, const std::string& what) {
  const std::string place = where.text();
  notices_.push_back(place + (place.empty() ? "" : ": ") + what);
}

std::vector<std::string> Problems::lines() const {
  std::vector<std::string> out = lines_;
  for (const auto& [key, kind] : kinds_)
    if (kind.count > kMostOfAKind)
      out.push_back(kind.file + (kind.file.empty() ? "" : ": ") + "and " + std::to_string(kind.count - kMostOfAKind) +
                    " more like \"" + kind.what + "\"");
  return out;
}

void Problems::throw_if_any() const {
  if (count_ == 0) return;
  std::string text;
  for (const auto& line : lines()) text += (text.empty() ? "" : "\n") + line;
  throw Error(Fault::input, text);
}

}  // namespace raycube::base
