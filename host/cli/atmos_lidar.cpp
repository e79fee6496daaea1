#include "host/cli/atmos_lidar.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <ostream>

#include <nlohmann/json.hpp>

#include "atmos_tables/compiler/lidar_profiles.h"
#include "atmos_tables/interpolate.h"
#include "atmos_tables/rct_file.h"
#include "host/base/error.h"
#include "host/base/output_file.h"
#include "host/cli/air_options.h"
#include "host/run/air_table.h"
#include "host/cli/services.h"
#include "scene_compiler/load_simulation.h"
#include "host/cli/typed.h"

namespace raycube::cli {

namespace {

struct AtmosLidarRequest {
  std::string file, lines, partition_sums;
  AirOptions air;
  std::vector<std::string> wavelengths, heights, cross_sections, ratios, depolarizations;
  bool cabannes = false;
  double ground = kUnset, ch4 = kUnset, water = kUnset;
};

std::pair<std::string, std::string> pair_of(const std::string& text, const std::string& option) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0 || equals + 1 == text.size())
    throw base::Error(base::Fault::input, option + ": '" + text + "' is not of the form NAME=VALUE");
  return {text.substr(0, equals), text.substr(equals + 1)};
}

std::string absolute(const std::string& path) { return std::filesystem::absolute(path).lexically_normal().string(); }

scene::AtmosphereSpec spec_of(const AtmosLidarRequest& o) {
  scene::AtmosphereSpec spec;
  if (!o.file.empty()) {
    scene::LoadOptions load;
    load.compile = false;
    spec = scene::load_simulation(o.file, load).atmosphere;
    if (!spec.layered || !spec.table_file.empty())
      throw base::Error(base::Fault::input,
                        o.file + ": its [atmosphere] is not of model = \"layered\"; LIDAR profiles need that model");
  } else {
    spec.layered.emplace();
  }
  scene::AirSpec& air = *spec.layered;
  const auto replace = [](double& standing, double typed) {
    if (!std::isnan(typed)) standing = typed;
  };
  replace(spec.ground_height_m, o.ground);
  apply(o.air, air);
  replace(air.ch4_ppmv, o.ch4), replace(air.water_g_cm2, o.water);
  if (!o.lines.empty()) air.lines = absolute(o.lines);
  if (!o.partition_sums.empty()) air.partition_sums = absolute(o.partition_sums);
  for (const std::string& text : o.cross_sections) {
    const auto [gas, rest] = pair_of(text, "--cross-section");
    const std::size_t comma = rest.rfind(',');
    scene::CrossSectionSpec& one = air.cross_sections.emplace_back();
    one.gas = gas;
    one.file = absolute(rest.substr(0, comma));
    if (comma != std::string::npos) one.ppmv = number_of(rest.substr(comma + 1), "--cross-section");
  }
  return spec;
}

atmos::LidarOptions lidar_options(const AtmosLidarRequest& o) {
  atmos::LidarOptions out;
  out.cabannes_only = o.cabannes;
  const auto component = [&](const std::string& name) -> atmos::LidarOptions::Particles& {
    for (auto& one : out.particles)
      if (one.component == name) return one;
    return out.particles.emplace_back(atmos::LidarOptions::Particles{name, -1, 0});
  };
  for (const std::string& text : o.ratios) {
    const auto [name, value] = pair_of(text, "--lidar-ratio");
    component(name).lidar_ratio_sr = number_of(value, "--lidar-ratio");
    if (component(name).lidar_ratio_sr < 0)
      throw base::Error(base::Fault::input, "--lidar-ratio: '" + text + "' must lie in 1 to 1000 sr");
  }
  for (const std::string& text : o.depolarizations) {
    const auto [name, value] = pair_of(text, "--depolarization");
    component(name).depolarization = number_of(value, "--depolarization");
  }
  return out;
}

/// The lowest node at every wavelength.
std::string ground_text(const atmos::RenderTable& table) {
  const atmos::LidarAir air = atmos::lidar_air(table, table.axis("range_height").nodes.front());
  std::string out =
      "  wavelength nm   extinction 1/km: molecules    aerosol        gas   backscatter 1/(km sr): molecules    "
      "aerosol\n";
  for (std::size_t i = 0; i < atmos::wavelengths(table).size(); ++i) {
    char line[200], gas[32] = "absent";
    if (table.has("lidar_extinction_gas")) std::snprintf(gas, sizeof gas, "%.4e", 1000 * air.extinction_gas_per_m[i]);
    std::snprintf(line, sizeof line, "  %13.4f   %26.4e %10.4e %10s   %33.4e %10.4e\n",
                  1000 * atmos::wavelengths(table)[i], 1000 * air.extinction_molecular_per_m[i],
                  1000 * air.extinction_aerosol_per_m[i], gas, 1000 * air.backscatter_molecular_per_m_sr[i],
                  1000 * air.backscatter_aerosol_per_m_sr[i]);
    out += line;
  }
  return out;
}

int run(const AtmosLidarRequest& o, Invocation& invocation) {
  if (o.wavelengths.empty())
    throw base::Error(base::Fault::input, "which wavelengths? give --wavelengths in nm (vacuum), such as 532,1064");
  const scene::AtmosphereSpec spec = spec_of(o);
  std::vector<double> wavelength_um = numbers_of(o.wavelengths, "--wavelengths");
  for (double& value : wavelength_um) value /= 1000;
  const std::vector<double> heights =
      o.heights.empty() ? atmos::lidar_heights(spec) : numbers_of(o.heights, "--heights");
  const atmos::RenderTable table = atmos::build_lidar(spec, wavelength_um, heights, lidar_options(o));
  const nlohmann::json provenance = nlohmann::json::parse(table.provenance_json);
  run::Services services = services_of(invocation);
  run::say_air(table, services);
  for (const auto& limit : provenance["limits"]) invocation.log.warning(limit.get<std::string>());
  const std::string output = invocation.common.output.empty() ? "lidar.rct" : invocation.common.output;
  const std::string hash =
      atmos::write_rct(table, output, invocation.common.overwrite ? base::IfExists::replace : base::IfExists::refuse);
  if (invocation.common.json)
    invocation.out << nlohmann::json{{"table", output}, {"content_hash", hash}, {"atmosphere", provenance}}.dump()
                   << "\n";
  else
    invocation.out << "table: " << output << "\n" << run::aerosol_text(table) << ground_text(table);
  return 0;
}

}  // namespace

std::string lidar_figures_json(const atmos::RenderTable& table, const std::string& title) {
  nlohmann::json out = {
      {"title", title}, {"wavelength_um", atmos::wavelengths(table)}, {"height_m", table.axis("range_height").nodes}};
  const std::size_t heights = table.axis("range_height").nodes.size();
  const std::string prefix = "lidar_";
  out["rows"] = nlohmann::json::object();
  for (const auto& [name, row] : table.rows) {
    if (name.rfind(prefix, 0) != 0) continue;
    nlohmann::json& spectra = out["rows"][name.substr(prefix.size())] = nlohmann::json::array();
    for (std::size_t i = 0; i < row.values.size(); i += heights)
      spectra.push_back(std::vector<float>(row.values.begin() + static_cast<std::ptrdiff_t>(i),
                                           row.values.begin() + static_cast<std::ptrdiff_t>(i + heights)));
  }
  return out.dump();
}

Verb verb_atmos_lidar() {
  auto o = std::make_shared<AtmosLidarRequest>();
  Verb verb("lidar", "Profiles of extinction and backscatter at laser wavelengths");
  verb.description =
      "Molecules, aerosols and, where lines or cross-sections are given, gases of the layered model, at heights from "
      "the ground to the "
      "top of the air, as a table of its own. The air is that of a scene FILE with model = \"layered\", or of the "
      "options, which "
      "replace what the file says. docs/atmosphere.md says how good it is.";
  verb.examples = {
      "raycube atmos lidar --wavelengths 532,1064 --visibility 23 -o lidar.rct",
      "raycube atmos lidar --wavelengths 3270.41,3269.68 --lines methane.par -o dial.rct",
      "raycube atmos lidar scene.toml --wavelengths 532 --lidar-ratio rural=55 --depolarization rural=0.05"};
  verb.common = kOutput;
  verb.add_options = [o](base::OptionTable& table) {
    const auto number = [&](const char* names, const char* unit, double low, double high, const char* help,
                            double& value, const char* standing) {
      table.number(names, unit, low, high, help, value).default_text = standing;
    };
    table.optional_argument("FILE", "A scene file", o->file);
    table.texts("--wavelengths", "NM", "Laser wavelengths, vacuum, nm, separated by commas", o->wavelengths);
    table.texts("--heights", "M", "Heights above z = 0, m, separated by commas", o->heights).default_text =
        "about 80 from 0 to 100 km";
    table.texts("--lidar-ratio", "NAME=SR",
                "Extinction over backscatter of a component (rural, troposphere, stratus ...)", o->ratios);
    table.texts("--depolarization", "NAME=D", "Linear depolarisation of a component's backscatter", o->depolarizations);
    table.flag("--cabannes", "The receiver rejects rotational Raman light", o->cabannes);
    table.text("--lines", "FILE", "HITRAN line list (.par)", o->lines);
    table.text("--partition-sums", "FILE", "CSV of partition sums instead of the formula", o->partition_sums);
    table.texts("--cross-section", "GAS=FILE[,PPMV]", "CSV of cross-sections of a gas", o->cross_sections);
    add_air_options(table, o->air, "FILE's, or by --visibility");
    number("--water", "g/cm2", 0, 10, "Precipitable water", o->water, "FILE's, or the profile's");
    number("--ch4", "ppmv", 0, 1000, "Methane at the ground", o->ch4, "FILE's, or the profile's");
    number("--ground-height", "m", -500, 9000, "Height of z = 0 above the sea", o->ground, "FILE's, or 0");
  };
  verb.run = [o](Invocation& invocation) { return run(*o, invocation); };
  return verb;
}

}  // namespace raycube::cli
