#include "atmos_tables/lines/tabulated_absorber.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "atmos_tables/import/text_lines.h"
#include "host/base/error.h"

namespace raycube::atmos {

namespace {
constexpr double kSamePressure = 0.01;

/// Place of a value among ascending nodes: the two neighbours and the upper one's weight, held beyond the ends.
struct Place {
  std::size_t low, high;
  double weight;
};
template <class Nodes, class Value>
Place place_of(const Nodes& nodes, double at, Value&& value) {
  std::size_t high = 0;
  while (high < nodes.size() && value(nodes[high]) < at) ++high;
  if (high == 0) return {0, 0, 0};
  if (high == nodes.size()) return {high - 1, high - 1, 0};
  const double a = value(nodes[high - 1]), b = value(nodes[high]);
  return {high - 1, high, (at - a) / (b - a)};
}

}  // namespace

double TabulatedAbsorber::Spectrum::at(double wavenumber) const {
  const auto& v = wavenumber_per_cm;
  if (!(wavenumber >= v.front() && wavenumber <= v.back())) return 0;
  const std::size_t high = std::clamp<std::size_t>(
      static_cast<std::size_t>(std::upper_bound(v.begin(), v.end(), wavenumber) - v.begin()), 1, v.size() - 1);
  const double part = (wavenumber - v[high - 1]) / (v[high] - v[high - 1]);
  return (1 - part) * sigma_cm2[high - 1] + part * sigma_cm2[high];
}

double TabulatedAbsorber::first_per_cm() const {
  double first = 0;
  for (const Group& group : groups_)
    for (const Spectrum& s : group.by_temperature) first = std::max(first, s.wavenumber_per_cm.front());
  return first;
}

double TabulatedAbsorber::last_per_cm() const {
  double last = std::numeric_limits<double>::infinity();
  for (const Group& group : groups_)
    for (const Spectrum& s : group.by_temperature) last = std::min(last, s.wavenumber_per_cm.back());
  return last;
}

std::vector<double> TabulatedAbsorber::cross_section_cm2(const std::vector<double>& wavenumber_per_cm,
                                                         const GasState& state) const {
  std::vector<double> out(wavenumber_per_cm.size(), 0.0);
  const auto add = [&](const Group& group, double share) {
    if (!(share > 0)) return;
    const Place t =
        place_of(group.by_temperature, state.temperature_K, [](const Spectrum& s) { return s.temperature_K; });
    const Spectrum &cold = group.by_temperature[t.low], &warm = group.by_temperature[t.high];
    for (std::size_t i = 0; i < out.size(); ++i)
      out[i] += share * ((1 - t.weight) * cold.at(wavenumber_per_cm[i]) + t.weight * warm.at(wavenumber_per_cm[i]));
  };
  const Place p =
      place_of(groups_, std::log(state.pressure_hPa), [](const Group& g) { return std::log(g.pressure_hPa); });
  add(groups_[p.low], 1 - p.weight);
  add(groups_[p.high], p.weight);
  return out;
}

TabulatedAbsorber TabulatedAbsorber::read_csv(const std::string& file) {
  using namespace imported;
  base::Problems problems;
  std::vector<Spectrum> spectra;
  const CsvTable columns{"cross-sections",
                         {"wavenumber_per_cm", "pressure_hPa", "temperature_K", "cross_section_cm2"},
                         "give that header line and those units"};
  read_rows(file, columns, problems, [&](const auto& cells, const base::Where& where, const std::string& line) {
    const Number v = need_number(cells[0], where, "wavenumber_per_cm", problems),
                 p = need_number(cells[1], where, "pressure_hPa", problems);
    const Number t = need_number(cells[2], where, "temperature_K", problems);
    // Noise of a measurement may be negative; it is kept, so that means stay right.
    const Number sigma = need_number(cells[3], where, "cross_section_cm2", problems, true);
    if (!v.good() || !p.good() || !t.good() || !sigma.good()) return;
    if (!(v.value > 0 && p.value > 0 && p.value < 1e5 && t.value >= 50 && t.value <= 2000)) {
      problems.add(where, "needs wavenumber > 0, pressure within 0..1e5 hPa, temperature within 50..2000 K", line,
                   "correct the row");
      return;
    }
    if (!(std::abs(sigma.value) < 1e-12)) {
      problems.add(where, "a cross-section of a molecule is below 1e-12 cm2", std::string(cells[3]),
                   "is the unit cm2 per molecule?");
      return;
    }
    if (spectra.empty() || spectra.back().pressure_hPa != p.value || spectra.back().temperature_K != t.value) {
      for (const Spectrum& s : spectra)
        if (s.pressure_hPa == p.value && s.temperature_K == t.value)
          problems.add(where, "rows of one pressure and temperature must follow each other", line, "sort the rows");
      spectra.push_back({p.value, t.value, {}, {}});
    }
    Spectrum& spectrum = spectra.back();
    if (!spectrum.wavenumber_per_cm.empty() && !(v.value > spectrum.wavenumber_per_cm.back()))
      problems.add(where, "wavenumbers must ascend strictly", std::string(cells[0]),
                   "sort the rows and remove doubles");
    spectrum.wavenumber_per_cm.push_back(v.value);
    spectrum.sigma_cm2.push_back(sigma.value);
  });
  for (const Spectrum& s : spectra)
    if (problems.empty() && s.sigma_cm2.size() < 2)
      problems.add({file, 0, 0, ""}, "a spectrum needs at least 2 wavenumbers", "1", "add rows");
  if (problems.empty() && spectra.empty())
    problems.add({file, 0, 0, ""}, "holds no cross-sections", "no rows", "add rows");
  problems.throw_if_any();
  std::sort(spectra.begin(), spectra.end(),
            [](const Spectrum& a, const Spectrum& b) { return a.pressure_hPa < b.pressure_hPa; });
  TabulatedAbsorber out;
  for (Spectrum& s : spectra) {
    if (out.groups_.empty() || s.pressure_hPa > out.groups_.back().pressure_hPa * (1 + kSamePressure))
      out.groups_.push_back({s.pressure_hPa, {}});
    out.groups_.back().by_temperature.push_back(std::move(s));
  }
  for (Group& group : out.groups_) {
    auto& list = group.by_temperature;
    std::sort(list.begin(), list.end(),
              [](const Spectrum& a, const Spectrum& b) { return a.temperature_K < b.temperature_K; });
    for (std::size_t i = 1; i < list.size(); ++i)
      if (!(list[i].temperature_K > list[i - 1].temperature_K))
        throw base::Error(base::Fault::input, file + ": two spectra of " + std::to_string(list[i].temperature_K) +
                                                  " K at nearly one pressure; keep one of them");
  }
  return out;
}

}  // namespace raycube::atmos
