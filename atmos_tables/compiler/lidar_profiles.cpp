#include "atmos_tables/compiler/lidar_profiles.h"

#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include "atmos_tables/compiler/air_provenance.h"
#include "atmos_tables/compiler/air_stack.h"
#include "atmos_tables/compiler/line_air.h"
#include "atmos_tables/gas/grey_gases.h"
#include "atmos_tables/optics/rayleigh_air.h"
#include "atmos_tables/table_rows.h"
#include "host/base/error.h"
#include "host/base/units.h"

namespace raycube::atmos {

namespace {

constexpr double kPerKm_to_per_m = 1e-3;
/// Beside a height where extinction jumps (cloud edges) a node stands on either side.
constexpr double kEdge_km = 0.0005;

std::string text(double value) { return nlohmann::json(value).dump(); }

/// Backscatter per extinction of molecules, sr-1, and its linear depolarisation. With the ratio x = (anisotropy / mean
/// polarisability)^2 = 4.5 (F - 1) of the King factor F the parallel part goes as 45 + 4 x, the perpendicular one as 3
/// x; the Cabannes line holds a quarter of the anisotropic light (She 2001, Appl. Opt. 40, 4875).
struct MolecularBack {
  double per_sr, depolarization;
};
MolecularBack molecular_back(double wavelength_um, double co2_ppmv, bool cabannes_only) {
  const double x = 4.5 * (air_king_factor(wavelength_um, co2_ppmv) - 1);
  const double seen = cabannes_only ? 0.25 * x : x;
  // Sphere integral: extinction goes as 45 (1 + 2 x / 9) 8 pi / 3 in units in which 45 + 7 x is backscatter per sr.
  return {(45 + 7 * seen) / (45 + 10 * x) * 3 / (8 * base::kPi), 3 * seen / (45 + 4 * seen)};
}

struct Particles {
  double extinction_ratio, back_per_sr, depolarization;
};
std::vector<Particles> particles_at(const AerosolColumn& aerosols, double wavelength_um, const LidarOptions& options) {
  std::vector<Particles> out;
  for (std::size_t c = 0; c < aerosols.components(); ++c) {
    const auto optics = aerosols.optics(c, wavelength_um);
    Particles one{optics.extinction_ratio, aerosols.backscatter_per_sr(c, wavelength_um), 0};
    for (const LidarOptions::Particles& own : options.particles) {
      if (own.component != aerosols.name(c)) continue;
      if (own.lidar_ratio_sr > 0) one.back_per_sr = one.extinction_ratio / own.lidar_ratio_sr;
      one.depolarization = own.depolarization;
    }
    out.push_back(one);
  }
  return out;
}

void check(const std::vector<double>& wavelength_um, const std::vector<double>& height_m, base::Problems& problems) {
  const auto ascending = [&](const char* what, const std::vector<double>& list, double low, double high,
                             const char* unit) {
    if (list.empty()) problems.add({"", 0, 0, what}, "none given", "", "give at least one");
    for (std::size_t i = 0; i < list.size(); ++i) {
      if (!(list[i] >= low && list[i] <= high))
        problems.add({"", 0, 0, what}, "must lie in " + text(low) + " to " + text(high) + " " + unit, text(list[i]),
                     "change it");
      if (i > 0 && !(list[i] > list[i - 1]))
        problems.add({"", 0, 0, what}, "must ascend strictly", text(list[i - 1]) + " then " + text(list[i]),
                     "sort them and remove doubles");
    }
  };
  ascending("LIDAR wavelengths", wavelength_um, kLidarFirst_um, kLidarLast_um, "um");
  ascending("LIDAR heights", height_m, -1000, 1000 * kTopOfStack_km, "m");
}

void check(const LidarOptions& options, const AerosolColumn& aerosols, base::Problems& problems) {
  std::string known;
  for (std::size_t c = 0; c < aerosols.components(); ++c) known += (c ? ", " : "") + aerosols.name(c);
  for (const LidarOptions::Particles& own : options.particles) {
    const base::Where where{"", 0, 0, "lidar ratio of " + own.component};
    bool found = false;
    for (std::size_t c = 0; c < aerosols.components(); ++c) found = found || aerosols.name(c) == own.component;
    if (!found)
      problems.add(where, "the air has no such component", own.component,
                   known.empty() ? "there is none" : "it has " + known);
    if (!(own.lidar_ratio_sr < 0 || (own.lidar_ratio_sr >= 1 && own.lidar_ratio_sr <= 1000)))
      problems.add(where, "must lie in 1 to 1000 sr", text(own.lidar_ratio_sr), "correct it");
    if (!(own.depolarization >= 0 && own.depolarization <= 1))
      problems.add(where, "depolarisation must lie in 0 to 1", text(own.depolarization), "correct it");
  }
}

/// A phase function by asymmetry alone says little of the light at 180 degrees.
void tell_of_backscatter(const scene::AirSpec& air, const LidarOptions& options, std::vector<std::string>& notices) {
  for (const scene::OwnAerosolSpec& own : air.own_aerosols) {
    const bool has_ratio = std::any_of(
        options.particles.begin(), options.particles.end(),
        [&](const LidarOptions::Particles& one) { return one.component == own.name && one.lidar_ratio_sr > 0; });
    if (!own.asymmetry.empty() && !has_ratio)
      notices.push_back(
          "aerosol '" + own.name +
          "': its backscatter is that of Henyey-Greenstein, up to 2.6 times too low; state phase_moments, "
          "a refractive index, or its lidar ratio");
  }
}

/// Wavelengths whose lines are read together: a list is read once for each group, so that 532 nm and 1.65 um do not
/// read all between.
std::size_t end_of_group(const std::vector<double>& wavelength_um, std::size_t first, double wing_per_cm) {
  std::size_t end = first + 1;
  while (end < wavelength_um.size() && 1e4 / wavelength_um[end - 1] - 1e4 / wavelength_um[end] < 4 * wing_per_cm) ++end;
  return end;
}

/// Absorption by gases, km-1 [wavelength][height].
std::vector<std::vector<double>> gas_absorption(const LineAir& lines, const std::vector<AirLevel>& air,
                                                const std::vector<double>& wavelength_um) {
  std::vector<LayerNode> nodes;  // a kilometre of each height's air
  for (std::size_t h = 0; h < air.size(); ++h) nodes.push_back({h, 1.0, air[h]});
  const GreyGases grey(nodes, air.size());
  const std::size_t count = wavelength_um.size();
  std::vector<double> wavenumbers;  // wavelengths ascend
  for (std::size_t i = count; i-- > 0;) wavenumbers.push_back(1e4 / wavelength_um[i]);
  std::vector<std::vector<double>> out(count, std::vector<double>(air.size()));
  for (std::size_t h = 0; h < air.size(); ++h) {
    const std::vector<double> resolved = absorption_per_km(lines.gases, air[h], wavenumbers);
    for (std::size_t i = 0; i < count; ++i)
      out[i][h] = std::max(0.0, resolved[count - 1 - i]) + grey.depth(wavenumbers[count - 1 - i], h);
  }
  return out;
}

}  // namespace

std::vector<double> lidar_heights(const scene::AtmosphereSpec& spec) {
  if (!spec.layered) throw base::Error(base::Fault::bug, "lidar_heights was given no layered air");
  const double ground_km = spec.ground_height_m / 1000;
  std::vector<std::string> notices;
  const AirProfile profile = make_profile(*spec.layered, ground_km, notices);
  const AerosolColumn aerosols(make_aerosols(*spec.layered), profile);
  const double top_km = std::min(kTopOfStack_km, profile.top_km());
  std::vector<double> wanted = {ground_km, top_km};
  // Where extinction jumps: one node on either side.
  for (double knot : aerosols.level_km()) {
    double before = 0, after = 0;
    for (std::size_t c = 0; c < aerosols.components(); ++c) {
      before += aerosols.extinction_550_per_km(c, knot - kEdge_km),
          after += aerosols.extinction_550_per_km(c, knot + kEdge_km);
    }
    if (std::abs(after - before) > 0.05 * std::max(after, before)) {
      wanted.push_back(knot - kEdge_km);
      wanted.push_back(knot + kEdge_km);
    } else {
      wanted.push_back(knot);
    }
  }
  const std::vector<double> needed = wanted;
  const auto add = [&](double low, double high, double step) {
    for (int i = 1; low + i * step <= high + 1e-9; ++i) {
      const double height = ground_km + low + i * step;
      // A node beside one that must be there buys nothing.
      if (std::none_of(needed.begin(), needed.end(),
                       [&](double other) { return std::abs(other - height) < 0.5 * step; }))
        wanted.push_back(height);
    }
  };
  add(0, 2, 0.1), add(2, 6, 0.25), add(6, 12, 0.5), add(12, 30, 1), add(30, 50, 5), add(50, 100, 10);
  std::sort(wanted.begin(), wanted.end());
  std::vector<double> out;
  for (double height : wanted) {
    if (height < ground_km || height > top_km) continue;
    if (out.empty() || height - (out.back() / 1000 + ground_km) > 0.5 * kEdge_km)
      out.push_back(1000 * (height - ground_km));
  }
  return out;
}

RenderTable build_lidar(const scene::AtmosphereSpec& spec, const std::vector<double>& wavelength_um,
                        const std::vector<double>& height_m, const LidarOptions& options) {
  if (!spec.layered) throw base::Error(base::Fault::bug, "build_lidar was given no layered air");
  base::Problems problems;
  check(wavelength_um, height_m, problems);
  problems.throw_if_any();
  const double z0_km = spec.ground_height_m / 1000;
  std::vector<std::string> notices;
  const AirProfile profile = make_profile(*spec.layered, z0_km + height_m.front() / 1000, notices);
  const AerosolColumn aerosols(make_aerosols(*spec.layered), profile);
  check(options, aerosols, problems);
  problems.throw_if_any();
  notices.insert(notices.end(), aerosols.notices().begin(), aerosols.notices().end());
  tell_of_backscatter(*spec.layered, options, notices);

  RenderTable table;
  table.solar_source = "none";
  add_axis(table, "wavelength", wavelength_um);
  add_axis(table, "range_height", height_m);
  Row& mol_extinction = add_row(table, "lidar_extinction_molecular", "Bodhaine et al. 1999 times the profile's air");
  Row& aer_extinction = add_row(table, "lidar_extinction_aerosol", "components of the layered model");
  Row& mol_back = add_row(table, "lidar_backscatter_molecular",
                          options.cabannes_only ? "Cabannes line alone" : "Cabannes line and Raman wings");
  Row& aer_back =
      add_row(table, "lidar_backscatter_aerosol", "Mie functions at 180 degrees, or the lidar ratios given");
  Row& depolarization = add_row(table, "lidar_depolarization", "perpendicular over parallel, linearly polarised beam");
  std::vector<AirLevel> air;
  for (double height : height_m)
    air.push_back(profile.at(std::clamp(z0_km + height / 1000, profile.ground_km(), profile.top_km())));
  const double co2_ppmv = profile.levels().front().ppmv(Gas::co2);
  nlohmann::json ratios = nlohmann::json::object();
  for (std::size_t i = 0; i < wavelength_um.size(); ++i) {
    const double cross_section = rayleigh_cross_section_cm2(wavelength_um[i], co2_ppmv);
    const MolecularBack molecules = molecular_back(wavelength_um[i], co2_ppmv, options.cabannes_only);
    const std::vector<Particles> particles = particles_at(aerosols, wavelength_um[i], options);
    for (std::size_t c = 0; c < particles.size(); ++c)
      ratios[aerosols.name(c)].push_back(
          particles[c].back_per_sr > 0 ? particles[c].extinction_ratio / particles[c].back_per_sr : 0);
    for (std::size_t h = 0; h < height_m.size(); ++h) {
      const std::size_t n = i * height_m.size() + h;
      const double molecular = 100 * cross_section * air[h].air_per_cm3;  // cm-1 to m-1
      double extinction = 0, back = 0, crossed = 0;
      for (std::size_t c = 0; c < particles.size(); ++c) {
        const double at_550 = kPerKm_to_per_m * aerosols.extinction_550_per_km(c, air[h].height_km);
        const double back_here = at_550 * particles[c].back_per_sr;
        extinction += at_550 * particles[c].extinction_ratio;
        back += back_here;
        crossed += back_here * particles[c].depolarization / (1 + particles[c].depolarization);
      }
      const double molecular_back_here = molecular * molecules.per_sr;
      crossed += molecular_back_here * molecules.depolarization / (1 + molecules.depolarization);
      mol_extinction.values[n] = static_cast<float>(molecular);
      mol_back.values[n] = static_cast<float>(molecular_back_here);
      aer_extinction.values[n] = static_cast<float>(extinction);
      aer_back.values[n] = static_cast<float>(back);
      const double parallel = back + molecular_back_here - crossed;
      depolarization.values[n] = static_cast<float>(parallel > 0 ? std::min(1.0, crossed / parallel) : 0);
    }
  }
  std::vector<std::string> limits;
  if (has_line_air(*spec.layered)) {
    std::string names;
    Row& row = add_row(table, "lidar_extinction_gas", "");
    for (std::size_t first = 0, end; first < wavelength_um.size(); first = end) {
      end = end_of_group(wavelength_um, first, spec.layered->line_wing_per_cm);
      const std::vector<double> group(wavelength_um.begin() + static_cast<std::ptrdiff_t>(first),
                                      wavelength_um.begin() + static_cast<std::ptrdiff_t>(end));
      const LineAir lines = read_line_air(*spec.layered, 1e4 / group.back(), 1e4 / group.front());
      for (const std::string& notice : lines.notices)
        if (std::find(notices.begin(), notices.end(), notice) == notices.end()) notices.push_back(notice);
      names.clear();
      for (const AbsorbingGas& gas : lines.gases) names += (names.empty() ? "" : ", ") + gas.name;
      const auto absorption = gas_absorption(lines, air, group);
      for (std::size_t i = 0; i < group.size(); ++i)
        for (std::size_t h = 0; h < height_m.size(); ++h)
          row.values[(first + i) * height_m.size() + h] = static_cast<float>(kPerKm_to_per_m * absorption[i][h]);
    }
    row.text = "lines or cross-sections of " + names + "; continua and ozone of the layered model";
  } else {
    const GasesLeftOut gases = gases_left_out(*spec.layered, profile.ground_km(), wavelength_um);
    (gases.share >= kTellsGases ? notices : limits).push_back(gases.text);
  }
  nlohmann::json j;
  j["model"] = "raycube LIDAR profiles";
  j["sources"] = {"profile: " + profile.source(), "Rayleigh: Bodhaine et al. 1999; King factors Bates 1984",
                  aerosol_source(*spec.layered)};
  j["parameters"] = air_parameters(spec, aerosols);
  j["parameters"].update(
      {{"cabannes_only", options.cabannes_only}, {"lines", spec.layered->lines}, {"lidar_ratio_sr", ratios}});
  j["notices"] = notices;
  j["limits"] = limits;
  j["stated_errors"] = {
      "molecules 0.1 %; lidar ratios of the aerosol models 30 %: 70 Mie functions are shared between models"};
  table.provenance_json = j.dump();
  validate(table, "LIDAR profiles");
  return table;
}

}  // namespace raycube::atmos
