#include "atmos_tables/aerosol/substance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <mutex>
#include <utility>

#include "atmos_tables/aerosol/figures.h"
#include "host/base/error.h"

namespace raycube::atmos {

namespace {

namespace tables {
using figures::OpticsRow;
using figures::PhaseRow;
#include "atmos_tables/aerosol/data/lowtran7_optics.inc"
#include "atmos_tables/aerosol/data/lowtran7_phases.inc"
}  // namespace tables

static_assert(std::size(tables::kWave_um) == figures::kWaves &&
              std::size(tables::kPhaseWave_um) == figures::kPhaseWaves);
static_assert(std::size(tables::kLogPhase) == figures::kPhases &&
              std::size(tables::kPhaseAngle_deg) == figures::kPhaseAngles);

/// Neighbours of x among ascending nodes and the share of the upper one; held beyond the ends.
struct Bracket {
  std::size_t low, high;
  double share;
};
template <class Node>
Bracket bracket(std::size_t count, double x, Node&& node) {
  std::size_t high = 0;
  while (high < count && node(high) < x) ++high;
  if (high == 0) return {0, 0, 0};
  if (high == count) return {count - 1, count - 1, 0};
  return {high - 1, high, (x - node(high - 1)) / (node(high) - node(high - 1))};
}

/// Coordinate in which grades are interpolated: wind as it is, humidity as -ln(100 - RH).
double coordinate(const std::string& name, double grade) { return name == "desert" ? grade : -std::log(100 - grade); }

/// Geometric mean, and 0 where both ends are 0 (substances of one grade).
double geometric(double low, double high, double share) {
  return low == high ? low : std::pow(low, 1 - share) * std::pow(high, share);
}

}  // namespace

Substance::Substance(const std::string& name, double grade) : name_(name) {
  const auto first = std::find_if(std::begin(tables::kOptics), std::end(tables::kOptics),
                                  [&](const auto& row) { return name == row.name; });
  const auto last = std::find_if(first, std::end(tables::kOptics), [&](const auto& row) { return name != row.name; });
  if (first == last) throw base::Error(base::Fault::bug, "aerosol figures: no substance is called " + name);
  const std::size_t grades = static_cast<std::size_t>(last - first);
  const Bracket at = bracket(grades, coordinate(name, grades > 1 ? grade : 0),
                             [&](std::size_t i) { return coordinate(name, first[i].grade); });
  const tables::OpticsRow &low = first[at.low], &high = first[at.high];
  for (std::size_t i = 0; i < figures::kWaves; ++i)
    nodes_.push_back({geometric(low.extinction[i], high.extinction[i], at.share),
                      geometric(low.absorption[i], high.absorption[i], at.share),
                      geometric(low.asymmetry[i], high.asymmetry[i], at.share)});
  for (const auto& [row, weight] : {std::pair{&low, 1 - at.share}, std::pair{&high, at.share}})
    for (std::size_t i = 0; i < std::size(tables::kPhase) && weight > 0; ++i)
      if (name == tables::kPhase[i].name && row->grade == tables::kPhase[i].grade) phase_rows_.push_back({i, weight});
}

SubstanceOptics Substance::at(double wavelength_um, BetweenWaves rule) const {
  if (!(wavelength_um >= kMinAerosolWave_um && wavelength_um <= kMaxAerosolWave_um))
    throw base::Error(base::Fault::input,
                      "aerosol optics cover 0.2 to 200 um (found " + std::to_string(wavelength_um) + " um)");
  const Bracket at = bracket(figures::kWaves, wavelength_um, [](std::size_t i) { return tables::kWave_um[i]; });
  const SubstanceOptics &low = nodes_[at.low], &high = nodes_[at.high];
  if (rule == BetweenWaves::power_law) {
    const double from = tables::kWave_um[at.low], to = tables::kWave_um[at.high];
    const double share = at.low == at.high ? 0 : std::log(wavelength_um / from) / std::log(to / from);
    const double extinction = geometric(low.extinction, high.extinction, share);
    return {extinction,
            extinction * std::lerp(low.absorption / low.extinction, high.absorption / high.extinction, at.share),
            std::lerp(low.asymmetry, high.asymmetry, at.share)};
  }
  return {std::lerp(low.extinction, high.extinction, at.share), std::lerp(low.absorption, high.absorption, at.share),
          std::lerp(low.asymmetry, high.asymmetry, at.share)};
}

PhaseFunction Substance::phase(double wavelength_um) const {
  const Bracket at =
      bracket(figures::kPhaseWaves, wavelength_um, [](std::size_t i) { return tables::kPhaseWave_um[i]; });
  std::vector<PhaseFunction::Part> parts;
  const auto add = [&](std::size_t number, double weight) {
    if (weight <= 0) return;
    const std::shared_ptr<const PhaseShape> shape = tabulated_phase(number);
    for (PhaseFunction::Part& part : parts)
      if (part.shape == shape) return void(part.weight += weight);
    parts.push_back({weight, shape});
  };
  for (const PhaseRowPart& part : phase_rows_) {
    add(tables::kPhase[part.row].function[at.low], part.weight * (1 - at.share));
    add(tables::kPhase[part.row].function[at.high], part.weight * at.share);
  }
  return PhaseFunction(std::move(parts));
}

std::size_t tabulated_phases() { return figures::kPhases; }

std::shared_ptr<const PhaseShape> tabulated_phase(std::size_t number) {
  // Each is made when first asked for, once, and never changes: a column needs about ten of them.
  static std::array<std::once_flag, figures::kPhases> made;
  static std::array<std::shared_ptr<const PhaseShape>, figures::kPhases> shapes;
  std::call_once(made.at(number), [number] {
    const auto& row = tables::kLogPhase[number];
    shapes[number] = std::make_shared<const PhaseShape>(
        std::vector<double>(std::begin(tables::kPhaseAngle_deg), std::end(tables::kPhaseAngle_deg)),
        std::vector<double>(std::begin(row), std::end(row)));
  });
  return shapes.at(number);
}

}  // namespace raycube::atmos
