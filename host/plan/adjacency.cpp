#include "host/plan/adjacency.h"

#include <cmath>

#include <fmt/format.h>

#include "atmos_tables/environment_function.h"
#include "atmos_tables/interpolate.h"
#include "host/base/error.h"
#include "host/plan/environment_map.h"
#include "host/plan/node_choice.h"

namespace raycube::plan {

namespace {

Spectrum ground_of(const EnvironmentMap& map, const scene::Simulation& simulation, const atmos::RenderTable& table,
                   const std::vector<double>& covered_um, std::size_t first) {
  Spectrum ground = mean_reflectance(map, simulation.scene, covered_um);
  const auto& nodes = table.axis("target_height").nodes;
  for (const double z : nodes) {
    const Spectrum back = atmos::spherical_albedo(table, z);
    for (std::size_t i = 0; i < ground.size(); ++i)
      if (!(ground[i] * back[first + i] < 1 - 1e-6))
        throw base::Error(
            base::Fault::input,
            fmt::format(
                "atmosphere table: at {:.6g} um the ground's mean reflectance {:.6g} times the spherical albedo {:.6g} "
                "reaches 1: light would grow without end; check the row spherical_albedo",
                covered_um[i], ground[i], back[first + i]));
  }
  return ground;
}

/// Part of T_dif that has the molecules' environment function.
Spectrum molecular_share(const TableSpectra& air, const std::vector<double>& covered_um, double pressure_hPa, double z,
                         double sensor_z, double zenith_rad) {
  Spectrum share = air.diffuse_view_transmission(z, zenith_rad);
  const Spectrum factor = air.two_way_factor(z, zenith_rad);  // which that carries
  for (std::size_t i = 0; i < share.size(); ++i) {
    const double molecules = factor[i] * atmos::molecular_diffuse_transmission(covered_um[i], pressure_hPa, z, sensor_z,
                                                                               std::cos(zenith_rad));
    share[i] = share[i] > molecules ? molecules / share[i] : 1.0;
  }
  return share;
}

}  // namespace

scene::Adjacency choose_adjacency(const scene::Simulation& simulation, const atmos::RenderTable& table) {
  return choose_adjacency(simulation, atmos::has_ground_coupling(table));
}

scene::Adjacency choose_adjacency(const scene::Simulation& simulation, bool table_has_coupling) {
  const scene::AtmosphereSpec& spec = simulation.atmosphere;
  const bool possible = !spec.none && table_has_coupling;
  if (spec.adjacency == scene::Adjacency::automatic) return possible ? scene::Adjacency::local : scene::Adjacency::off;
  if (spec.adjacency != scene::Adjacency::off && !possible)
    throw base::Error(base::Fault::input,
                      simulation.file + ": atmosphere.adjacency asks for light between ground and air, " +
                          (spec.none ? "the model is 'none'"
                                     : "the atmosphere table lacks one of spherical_albedo, diffuse_view_transmission, "
                                       "diffuse_return, diffuse_irradiance") +
                          "; use a table that has them, or adjacency = \"off\"");
  return spec.adjacency;
}

Spectrum plan_environment(Plan& plan, const scene::Simulation& simulation, const atmos::RenderTable& table,
                          const Domain& domain, bool local, const std::vector<double>& covered_um, std::size_t first,
                          int threads) {
  plan.environment = make_environment(simulation.scene, domain.view, domain.z_lo, domain.z_hi, local, threads);
  plan.environment.pressure_hPa = simulation.atmosphere.pressure_hPa;
  return ground_of(plan.environment, simulation, table, covered_um, first);
}

void add_environment_spectra(Plan& plan, const scene::Simulation& simulation, const TableSpectra& air,
                             const BandSpace& bands, const std::vector<double>& covered_um,
                             const std::vector<double>& grid_um) {
  sample_environment(plan.environment, simulation.scene, grid_um);
  const auto channels = static_cast<std::size_t>(plan.environment_channels());
  plan.environment_spectrum.resize(2 * channels);
  for (int h = 0; h < plan.height.count; ++h)
    for (int v = 0; v < plan.view.count; ++v) {
      const double z = node_position(plan.height, h), sec = node_position(plan.view, v);
      const Spectrum light = environment_source(air, z, sec);
      Spectrum part = molecular_share(air, covered_um, plan.environment.pressure_hPa, z, plan.environment.sensor_z_m,
                                      zenith_of_sec(sec));
      const auto channel = static_cast<std::size_t>(h * plan.view.count + v);
      plan.environment_spectrum[channel] = bands.to_grid(product(light, part));
      for (double& p : part) p = 1 - p;
      plan.environment_spectrum[channels + channel] = bands.to_grid(product(light, part));
    }
}

std::vector<std::pair<std::string, double>> mean_ground(const EnvironmentMap& map, const scene::CompiledScene& scene) {
  std::vector<std::pair<std::string, double>> out;
  for (std::size_t c = 0; c < map.mean.size(); ++c)
    if (map.mean[c] > 0) {
      if (out.empty() || out.back().first != scene.materials[c].name) out.emplace_back(scene.materials[c].name, 0.0);
      out.back().second += map.mean[c];  // a family's members follow one another
    }
  return out;
}

}  // namespace raycube::plan
