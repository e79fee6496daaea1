#include "host/analysis/impossible_places.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "host/base/error.h"

namespace raycube::analysis {
namespace {

using PlaceXY = std::array<double, 2>;
using PlaceLine = std::vector<PlaceXY>;

constexpr double kFarthest_m = 1e9;  ///< from zero: no map of the Earth reaches so far, in feet neither
constexpr double kTimes = 1000, kTimesAlone = 10;
constexpr double kLeftOut = 0.01;  ///< of the pixels, at each end
constexpr std::size_t kSomePlaces = 1 << 20;

double apart(const PlaceXY& a, const PlaceXY& b) { return std::hypot(a[0] - b[0], a[1] - b[1]); }

/// Where most pixels lie.
struct MostPlaces {
  PlaceXY middle{};
  double across_m = 0;  ///< the diagonal of the box that holds them
};

MostPlaces most_of(std::vector<PlaceXY>& some) {
  MostPlaces out;
  const std::size_t low = static_cast<std::size_t>(kLeftOut * static_cast<double>(some.size())),
                    high = some.size() - 1 - low, middle = some.size() / 2;
  PlaceXY size{};
  for (std::size_t axis = 0; axis < 2; ++axis) {
    std::sort(some.begin(), some.end(), [&](const PlaceXY& a, const PlaceXY& b) { return a[axis] < b[axis]; });
    out.middle[axis] = some[middle][axis], size[axis] = some[high][axis] - some[low][axis];
  }
  out.across_m = std::hypot(size[0], size[1]);
  return out;
}

/// To the nearest of a pixel's neighbours in its line and beside it; infinite: none has a place.
double from_neighbours(const std::array<PlaceLine, 3>& lines, std::size_t sample) {
  double nearest = std::numeric_limits<double>::infinity();
  const PlaceXY& place = lines[1][sample];
  const auto look = [&](const PlaceLine& line, std::size_t at) {
    if (at < line.size() && std::isfinite(line[at][0] + line[at][1]))
      nearest = std::min(nearest, apart(line[at], place));
  };
  look(lines[0], sample), look(lines[2], sample), look(lines[1], sample + 1);
  if (sample > 0) look(lines[1], sample - 1);
  return nearest;
}

[[noreturn]] void refuse(const std::string& file, std::int64_t line, std::size_t sample, const PlaceXY& place,
                         const std::string& why) {
  throw base::Error(base::Fault::input,
                    fmt::format("{}: line {}, sample {} (from 0) lies at ({:.10g}, {:.10g}), {}; the file is damaged, "
                                "or its header is another's: render again, or restore it",
                                file, line, sample, place[0], place[1], why));
}

}  // namespace

void refuse_places_off_earth(const std::string& file, std::int64_t lines, const PlacesOfLine& read) {
  PlaceLine line;
  for (std::int64_t l = 0; l < lines; ++l) {
    read(l, line);
    for (std::size_t s = 0; s < line.size(); ++s)
      if (std::max(std::abs(line[s][0]), std::abs(line[s][1])) > kFarthest_m)
        refuse(file, l, s, line[s], fmt::format("more than {:.3g} m from zero", kFarthest_m));
  }
}

void refuse_impossible_places(const std::string& file, std::int64_t lines, const PlacesOfLine& read) {
  refuse_places_off_earth(file, lines, read);
  std::vector<PlaceXY> some;
  PlaceLine line;
  for (std::int64_t l = 0; l < lines; ++l) {
    read(l, line);
    const std::size_t step = 1 + line.size() * static_cast<std::size_t>(lines) / kSomePlaces;
    for (std::size_t s = 0; s < line.size(); ++s) {
      const bool finite = std::isfinite(line[s][0]) && std::isfinite(line[s][1]);
      if (finite && (s + static_cast<std::size_t>(l)) % step == 0) some.push_back(line[s]);
    }
  }
  if (some.size() < 3) return;
  const MostPlaces most = most_of(some);
  if (!(most.across_m > 0)) return;
  std::array<PlaceLine, 3> at;  // the line before, the line, the line behind it
  if (lines > 0) read(0, at[2]);
  for (std::int64_t l = 0; l < lines; ++l) {
    std::rotate(at.begin(), at.begin() + 1, at.end());
    at[2].clear();
    if (l + 1 < lines) read(l + 1, at[2]);
    for (std::size_t s = 0; s < at[1].size(); ++s) {
      const double far = apart(at[1][s], most.middle);
      if (!(far > kTimesAlone * most.across_m)) continue;
      if (far > kTimes * most.across_m || from_neighbours(at, s) > kTimesAlone * most.across_m)
        refuse(file, l, s, at[1][s],
               fmt::format("{:.3g} m from the image's middle, whose pixels lie within {:.3g} m", far, most.across_m));
    }
  }
}

}  // namespace raycube::analysis
