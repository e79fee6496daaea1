#include "scene_compiler/detector_joins.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "scene_compiler/document_values.h"

namespace raycube::scene {
namespace {

constexpr std::size_t kMostDetectors = 6;

using Run = std::span<const SpectrumPoint>;

/// Stretches that do not step back.
std::vector<Run> runs_of(const std::vector<SpectrumPoint>& points) {
  std::vector<Run> out;
  for (std::size_t first = 0, i = 1; i <= points.size(); ++i)
    if (i == points.size() || points[i].wavelength_um < points[i - 1].wavelength_um)
      out.emplace_back(points.data() + first, i - first), first = i;
  return out;
}

/// Whether two runs that follow one another both have points where both see: one row out of place is no detector.
bool overlap(Run before, Run after) {
  constexpr std::ptrdiff_t kFewest = 2;
  const double low_um = after.front().wavelength_um, high_um = before.back().wavelength_um;
  const auto within = [&](const SpectrumPoint& p) { return p.wavelength_um >= low_um && p.wavelength_um <= high_um; };
  return std::count_if(before.begin(), before.end(), within) >= kFewest &&
         std::count_if(after.begin(), after.end(), within) >= kFewest;
}

bool are_detectors(const std::vector<Run>& runs, std::size_t fewest) {
  if (runs.size() > kMostDetectors) return false;
  for (std::size_t r = 0; r < runs.size(); ++r) {
    if (runs[r].size() < fewest) return false;
    if (r > 0 && !(runs[r].front().wavelength_um > runs[r - 1].front().wavelength_um &&
                   runs[r].back().wavelength_um > runs[r - 1].back().wavelength_um))
      return false;
    if (r > 0 && !overlap(runs[r - 1], runs[r])) return false;
  }
  return true;
}

/// Reflectance at a wavelength within the run.
double value_at(Run run, double um) {
  const auto above = std::lower_bound(run.begin(), run.end(), um, [](const SpectrumPoint& point, double wavelength_um) {
    return point.wavelength_um < wavelength_um;
  });
  const auto i = static_cast<std::size_t>(
      std::clamp<std::ptrdiff_t>(above - run.begin(), 1, static_cast<std::ptrdiff_t>(run.size()) - 1));
  const double width = run[i].wavelength_um - run[i - 1].wavelength_um;
  const double part = width > 0 ? (um - run[i - 1].wavelength_um) / width : 0;
  return (1 - part) * run[i - 1].reflectance + part * run[i].reflectance;
}

std::string nm_text(double um) { return number_text(std::round(1e5 * um) / 100); }

}  // namespace

std::optional<std::vector<SpectrumPoint>> joined_detectors(std::vector<SpectrumPoint> points, std::size_t fewest,
                                                           const std::string& file, base::Problems& problems) {
  std::size_t up = 0, down = 0;
  for (std::size_t i = 1; i < points.size(); ++i) {
    up += points[i].wavelength_um > points[i - 1].wavelength_um;
    down += points[i].wavelength_um < points[i - 1].wavelength_um;
  }
  if (down > up) std::reverse(points.begin(), points.end());
  const std::vector<Run> runs = runs_of(points);
  if (runs.size() < 2) return points;
  if (!are_detectors(runs, fewest)) return std::nullopt;
  std::vector<SpectrumPoint> out;
  double from_um = 0;
  for (std::size_t r = 0; r < runs.size(); ++r) {
    const bool last = r + 1 == runs.size();
    const double low_um = last ? 0 : runs[r + 1].front().wavelength_um, high_um = runs[r].back().wavelength_um;
    const double to_um = last ? high_um : 0.5 * (low_um + high_um);
    for (const SpectrumPoint& point : runs[r])
      if ((r == 0 || point.wavelength_um > from_um) && point.wavelength_um <= to_um) out.push_back(point);
    from_um = to_um;
    if (last) continue;
    const double apart = std::abs(value_at(runs[r], to_um) - value_at(runs[r + 1], to_um));
    problems.tell({file, 0, 0, ""}, "two detectors overlap from " + nm_text(low_um) + " to " + nm_text(high_um) +
                                        " nm; they are joined at " + nm_text(to_um) + " nm, where they differ by " +
                                        number_text(std::round(1e4 * apart) / 1e4) + " in reflectance");
  }
  return out;
}

}  // namespace raycube::scene
