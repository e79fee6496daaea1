// Text as formats compare and write it.
#pragma once

#include <cctype>
#include <cstddef>
#include <string>

namespace raycube::base {

/// Capital letters of ASCII become small ones.
inline std::string lower_case(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

/// "1 notice", "2 notices".
inline std::string counted(std::size_t number, const std::string& noun) {
  return std::to_string(number) + " " + noun + (number == 1 ? "" : "s");
}

/// Without the marks by which DOS ended texts (0x1A), and the blanks among them.
inline std::string without_dos_end(std::string text) {
  const std::size_t last = text.find_last_not_of("\x1a \t\r\n") + 1;  // 0 where there is nothing else
  if (text.find('\x1a', last) != std::string::npos) text.resize(last);
  return text;
}

/// As XML and HTML have it between tags and in quotes.
inline std::string escaped_markup(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '"')
      out += "&quot;";
    else
      out += c;
  }
  return out;
}

}  // namespace raycube::base
