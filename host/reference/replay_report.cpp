#include "host/reference/replay_report.h"

#include <algorithm>
#include <cmath>

#include "host/reference/report_text.h"

namespace raycube::reference {

void ReplayReport::add(const ReplayReport& other) {
  if (!(other.worst <= worst) || pixels == 0) worst_line = other.worst_line, worst_sample = other.worst_sample;
  worst = std::isnan(other.worst) ? other.worst : std::max(worst, other.worst),
  worst_way = std::max(worst_way, other.worst_way);
  pixels += other.pixels, paths += other.paths, steps += other.steps;
  for (std::size_t i = 0; i < hits.size(); ++i) hits[i] += other.hits[i];
  asked += other.asked, asked_explained += other.asked_explained, asked_unexplained += other.asked_unexplained;
  decisions += other.decisions, decisions_near += other.decisions_near, decisions_wrong += other.decisions_wrong;
  ways_wrong += other.ways_wrong, excluded_pixels += other.excluded_pixels;
}

std::vector<std::string> ReplayReport::failures() const {
  std::vector<std::string> out;
  const auto none = [&](std::uint64_t count, const std::string& what) {
    if (count > 0) out.push_back("paths between surfaces: " + std::to_string(count) + " " + what);
  };
  none(hits[static_cast<std::size_t>(Cause::unexplained)], "rays met what double arithmetic contradicts");
  none(asked_unexplained, "answers to whether something hides a light are contradicted in double");
  none(decisions_wrong, "decisions are others than their draws and chances make them");
  none(ways_wrong, "directions or weights are not their own formulas'");
  none(other_bits, "tiles are rendered otherwise by the program that hands over its steps");
  if (!(worst <= kMostOff))
    out.push_back("paths between surfaces, replayed, bring other light than the device's: " + three_digits(worst) +
                  " of it at line " + std::to_string(worst_line) + ", sample " + std::to_string(worst_sample) +
                  " (limit " + three_digits(kMostOff) + ")");
  return out;
}

std::string ReplayReport::text() const {
  if (pixels == 0) return "";
  const auto count = [](std::uint64_t value) { return std::to_string(value); };
  const std::uint64_t agree = hits[static_cast<std::size_t>(Cause::agree)],
                      unexplained = hits[static_cast<std::size_t>(Cause::unexplained)];
  return "\npaths replayed (" + count(pixels) + " pixels, " + count(paths) + " paths): rays to surfaces " +
         count(steps) + ", agree " + count(agree) + ", ties " + count(steps - agree - unexplained) + ", unexplained " +
         count(unexplained) + "; rays to lights " + count(asked) + ", explained " + count(asked_explained) +
         ", unexplained " + count(asked_unexplained) + "; decisions " + count(decisions) + ", at their chance " +
         count(decisions_near) + ", wrong " + count(decisions_wrong) + "; directions off by " +
         three_digits(worst_way) + " at most (limit " + three_digits(kMostWayOff) +
         "); sums at the wavelengths along paths off by " + three_digits(worst) + " at most (limit " +
         three_digits(kMostOff) + "); pixels left out " + count(excluded_pixels);
}

}  // namespace raycube::reference
