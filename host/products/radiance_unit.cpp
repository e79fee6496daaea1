#include "host/products/radiance_unit.h"

#include <cctype>
#include <cmath>
#include <cstdlib>
#include <map>
#include <vector>

namespace raycube::products {
namespace {

enum Dimension { power, length, angle, wavelength, dimensions };

struct Unit {
  Dimension of;
  double size;  ///< in W, m, sr, um
};

const Unit* unit_named(const std::string& name) {
  static const std::map<std::string, Unit> known = {{"w", {power, 1}},
                                                    {"watt", {power, 1}},
                                                    {"watts", {power, 1}},
                                                    {"mw", {power, 1e-3}},
                                                    {"milliwatt", {power, 1e-3}},
                                                    {"milliwatts", {power, 1e-3}},
                                                    {"uw", {power, 1e-6}},
                                                    {"microwatt", {power, 1e-6}},
                                                    {"microwatts", {power, 1e-6}},
                                                    {"nw", {power, 1e-9}},
                                                    {"nanowatt", {power, 1e-9}},
                                                    {"nanowatts", {power, 1e-9}},
                                                    {"m", {length, 1}},
                                                    {"meter", {length, 1}},
                                                    {"meters", {length, 1}},
                                                    {"metre", {length, 1}},
                                                    {"metres", {length, 1}},
                                                    {"cm", {length, 1e-2}},
                                                    {"centimeter", {length, 1e-2}},
                                                    {"centimeters", {length, 1e-2}},
                                                    {"centimetre", {length, 1e-2}},
                                                    {"sr", {angle, 1}},
                                                    {"str", {angle, 1}},
                                                    {"steradian", {angle, 1}},
                                                    {"steradians", {angle, 1}},
                                                    {"um", {wavelength, 1}},
                                                    {"micron", {wavelength, 1}},
                                                    {"microns", {wavelength, 1}},
                                                    {"micrometer", {wavelength, 1}},
                                                    {"micrometers", {wavelength, 1}},
                                                    {"micrometre", {wavelength, 1}},
                                                    {"nm", {wavelength, 1e-3}},
                                                    {"nanometer", {wavelength, 1e-3}},
                                                    {"nanometers", {wavelength, 1e-3}},
                                                    {"nanometre", {wavelength, 1e-3}}};
  const auto found = known.find(name);
  return found == known.end() ? nullptr : &found->second;
}

/// Lower-case ASCII; the Greek and the micro sign (UTF-8, Latin-1) as u, superscripts as the signs that they raise.
std::string plain(const std::string& text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto c = static_cast<unsigned char>(text[i]);
    const auto next = i + 1 < text.size() ? static_cast<unsigned char>(text[i + 1]) : 0u;
    if ((c == 0xc2 && next == 0xb5) || (c == 0xce && next == 0xbc)) {
      out += 'u', ++i;
    } else if (c == 0xc2 && (next == 0xb2 || next == 0xb9)) {  // superscript two and one
      out += next == 0xb2 ? '2' : '1', ++i;
    } else if (text.compare(i, 3, "\xe2\x81\xbb") == 0) {  // superscript minus
      out += '-', i += 2;
    } else if (c == 0xc2 && next == 0xb7) {  // middle dot
      out += '.', ++i;
    } else if (c == 0xb5) {
      out += 'u';
    } else {
      out += static_cast<char>(std::tolower(c));
    }
  }
  return out;
}

}  // namespace

std::optional<double> radiance_of(const std::string& unit) {
  const std::string text = plain(unit);
  double factor = 1, powers[dimensions] = {};
  int sign = 1, times = 1;  // of the next unit: below a line or not; "square"
  const Unit* last = nullptr;
  int last_exponent = 0;     // of the last unit, which "squared" doubles
  std::vector<int> outside;  // signs before parentheses
  for (std::size_t at = 0; at < text.size();) {
    const char c = text[at];
    if (std::isalpha(static_cast<unsigned char>(c))) {
      std::size_t end = at;
      while (end < text.size() && std::isalpha(static_cast<unsigned char>(text[end]))) ++end;
      const std::string word = text.substr(at, end - at);
      at = end;
      if (word == "radiance" || word == "spectral") continue;  // what it is, before or behind the unit
      if (word == "per" || word == "square" || word == "squared") {
        if (word == "per") sign = -1;
        if (word == "square") times = 2;
        if (word == "squared" && last) powers[last->of] += last_exponent, factor *= std::pow(last->size, last_exponent);
        continue;
      }
      const Unit* const known = unit_named(word);
      if (!known) return std::nullopt;
      int exponent = 1;
      if (end < text.size() && (text[end] == '^' || text[end] == '*'))
        at += text.compare(end, 2, "**") == 0 ? 2 : text[end] == '^';
      const bool number = at < text.size() && (std::isdigit(static_cast<unsigned char>(text[at])) ||
                                               ((text[at] == '-' || text[at] == '+') && at + 1 < text.size() &&
                                                std::isdigit(static_cast<unsigned char>(text[at + 1]))));
      if (number) {
        char* after = nullptr;
        exponent = static_cast<int>(std::strtol(text.c_str() + at, &after, 10));
        at = static_cast<std::size_t>(after - text.c_str());
      }
      exponent *= sign * times;
      powers[known->of] += exponent;
      factor *= std::pow(known->size, exponent);
      last = known, last_exponent = exponent;
      times = 1;
      if (outside.empty()) sign = sign < 0 && text.find("per") != std::string::npos ? sign : 1;
    } else if (c == '/') {
      sign = -1, ++at;
    } else if (c == '(' || c == '[') {
      outside.push_back(sign), ++at;
    } else if (c == ')' || c == ']') {
      if (outside.empty()) return std::nullopt;
      outside.pop_back(), sign = 1, ++at;
    } else if (std::isspace(static_cast<unsigned char>(c)) || c == '*' || c == '.' || c == ',' || c == ':') {
      ++at;
    } else {
      return std::nullopt;
    }
  }
  const bool radiance = powers[power] == 1 && powers[length] == -2 && powers[angle] == -1 && powers[wavelength] == -1;
  return radiance ? std::optional(factor) : std::nullopt;
}

}  // namespace raycube::products
