#include "atmos_tables/compiler/line_air.h"

#include <algorithm>
#include <cstdio>
#include <map>
#include <memory>
#include <utility>

#include "atmos_tables/lines/hitran_par.h"
#include "atmos_tables/lines/molecular_lines.h"
#include "atmos_tables/lines/tabulated_absorber.h"
#include "host/base/error.h"

namespace raycube::atmos {

namespace {

std::optional<Gas> profile_gas(const std::string& name) {
  for (std::size_t g = 0; g < kGases; ++g)
    if (name == kGasNames[g]) return static_cast<Gas>(g);
  return {};
}

std::string range_text(double low, double high) {
  char text[80];
  std::snprintf(text, sizeof text, "%.9g to %.9g cm-1", low, high);
  return text;
}

std::string joined(const std::vector<std::string>& names) {
  std::string out;
  for (const auto& name : names) out += (out.empty() ? "" : ", ") + name;
  return out;
}

void add_cross_sections(const scene::AirSpec& spec, double low, double high, LineAir& out) {
  for (const scene::CrossSectionSpec& table : spec.cross_sections) {
    AbsorbingGas gas;
    gas.name = table.gas;
    if (table.ppmv < 0) gas.in_profile = profile_gas(table.gas);
    gas.ppmv = table.ppmv;
    if (!gas.in_profile && table.ppmv < 0)
      throw base::Error(
          base::Fault::input,
          table.file + ": the profile carries no '" + table.gas +
              "'; give its mixing ratio in ppmv, or name one of its gases (h2o, co2, o3, n2o, co, ch4, o2)");
    auto absorber = std::make_shared<TabulatedAbsorber>(TabulatedAbsorber::read_csv(table.file));
    if (absorber->first_per_cm() > low || absorber->last_per_cm() < high)
      out.notices.push_back(table.file + ": cross-sections of " + table.gas + " cover " +
                            range_text(absorber->first_per_cm(), absorber->last_per_cm()) + " of " +
                            range_text(low, high) + "; outside it absorbs nothing");
    gas.absorber = std::move(absorber);
    out.gases.push_back(std::move(gas));
  }
}

void add_lines(const scene::AirSpec& spec, double low, double high, LineAir& out) {
  const auto sums = std::make_shared<PartitionSums>(
      spec.partition_sums.empty() ? PartitionSums() : PartitionSums::read_csv(spec.partition_sums));
  // A pressure shift moves no line by more than 1 cm-1.
  const double reach = spec.line_wing_per_cm + 1;
  LineList list = read_hitran_par(spec.lines, low - reach, high + reach);
  std::map<int, std::vector<SpectralLine>> by_molecule;
  for (const SpectralLine& line : list.lines) by_molecule[line.molecule].push_back(line);
  std::vector<std::string> left_out, bands;
  for (const auto& [molecule, extent] : list.molecules) {
    const std::string& name = molecule_name(molecule);
    const std::optional<Gas> gas = profile_gas(name);
    if (!gas) {
      if (by_molecule.count(molecule)) left_out.push_back(name);
      continue;
    }
    if (std::any_of(out.gases.begin(), out.gases.end(), [&](const AbsorbingGas& other) { return other.name == name; }))
      continue;
    if (extent.first_per_cm > low || extent.last_per_cm < high)
      out.notices.push_back(
          spec.lines + ": lines of " + name + " span " + range_text(extent.first_per_cm, extent.last_per_cm) +
          "; if the list was cut there, wings of lines outside are missing from " + range_text(low, high));
    LineOptions options;
    options.wing_per_cm = spec.line_wing_per_cm;
    options.without_pedestal = *gas == Gas::h2o;
    out.gases.push_back(
        {name, gas, 0, std::make_shared<MolecularLines>(std::move(by_molecule[molecule]), options, sums)});
  }
  for (std::size_t g = 0; g < kGases; ++g)
    if (!out.resolves(static_cast<Gas>(g))) bands.push_back(kGasNames[g]);
  if (!left_out.empty())
    out.notices.push_back(spec.lines + ": the profile carries no " + joined(left_out) + "; their lines are left out");
  if (!bands.empty())
    out.notices.push_back(
        spec.lines + ": holds no lines of " + joined(bands) +
        "; a table of sun and sky takes them from the band model at 10 to 20 cm-1, LIDAR profiles leave them out");
  if (list.unknown_energy > 0)
    out.notices.push_back(spec.lines + ": " + std::to_string(list.unknown_energy) +
                          " lines without a lower energy keep the strength of 296 K");
}

}  // namespace

bool LineAir::resolves(Gas gas) const {
  return std::any_of(gases.begin(), gases.end(), [&](const AbsorbingGas& one) { return one.in_profile == gas; });
}

bool has_line_air(const scene::AirSpec& spec) { return !spec.lines.empty() || !spec.cross_sections.empty(); }

LineAir read_line_air(const scene::AirSpec& spec, double low_per_cm, double high_per_cm) {
  LineAir out;
  add_cross_sections(spec, low_per_cm, high_per_cm, out);
  if (!spec.lines.empty()) add_lines(spec, low_per_cm, high_per_cm, out);
  return out;
}

AirProfile without_resolved(const AirProfile& profile, const LineAir& lines) {
  std::vector<AirLevel> levels = profile.levels();
  for (std::size_t g = 0; g < kGases; ++g)
    if (lines.resolves(static_cast<Gas>(g)))
      for (AirLevel& level : levels) level.gas_per_cm3[g] = 0;
  return AirProfile(std::move(levels), profile.source());
}

}  // namespace raycube::atmos
