#include "host/cli/info_statistics.h"

#include <fmt/format.h>

namespace raycube::cli {

nlohmann::ordered_json statistics_json(const products::BandStatistics& s) {
  return {{"count", s.count},
          {"min", s.min},
          {"max", s.max},
          {"mean", s.mean},
          {"standard_deviation", s.standard_deviation()},
          {"ignored", s.ignored},
          {"not_finite", s.not_finite}};
}

std::string statistics_title() {
  return fmt::format("  {:<24} {:>12} {:>12} {:>12} {:>12}\n", "statistics", "min", "max", "mean", "std");
}

std::string statistics_line(const std::string& name, const products::BandStatistics& s) {
  std::string text = fmt::format("  {:<24} {:>12.6g} {:>12.6g} {:>12.6g} {:>12.6g}", name, s.min, s.max, s.mean,
                                 s.standard_deviation());
  if (s.ignored) text += fmt::format("  {} ignored", s.ignored);
  if (s.not_finite) text += fmt::format("  {} not finite", s.not_finite);
  return text + "\n";
}

}  // namespace raycube::cli
