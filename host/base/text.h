// Text as formats compare and write it.
#pragma once

#include <cctype>
#include <cmath>
#include <cstddef>
#include <cstdio>
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

/// The same of a noun, or of words that go with it, whose plural is its own: "1 post stands", "2 posts stand".
inline std::string counted(std::size_t number, const std::string& one, const std::string& many) {
  return std::to_string(number) + " " + (number == 1 ? one : many);
}

/// An estimated count, with two digits: 19000 of 19321.7; from 1e15 on as 2.0e+15.
inline std::string about_count(double number) {
  char text[32];
  if (!(number < 1e15)) {
    std::snprintf(text, sizeof text, "%.1e", number);
  } else {
    const double step = number < 10 ? 1 : std::pow(10.0, std::floor(std::log10(number)) - 1);
    std::snprintf(text, sizeof text, "%.0f", std::round(number / step) * step);
  }
  return text;
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
