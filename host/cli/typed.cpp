#include "host/cli/typed.h"

#include <algorithm>
#include <cstdlib>

#include "host/base/error.h"

namespace raycube::cli {

double number_of(const std::string& text, const std::string& option) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (text.empty() || *end != 0 || !std::isfinite(value))
    throw base::Error(base::Fault::input, option + ": '" + text + "' is no number");
  return value;
}

std::vector<double> numbers_of(const std::vector<std::string>& texts, const std::string& option) {
  std::vector<double> out;
  for (const std::string& text : texts)
    for (std::size_t begin = 0; begin <= text.size();) {
      const std::size_t comma = std::min(text.find(',', begin), text.size());
      out.push_back(number_of(text.substr(begin, comma - begin), option));
      begin = comma + 1;
    }
  std::sort(out.begin(), out.end());
  return out;
}

}  // namespace raycube::cli
