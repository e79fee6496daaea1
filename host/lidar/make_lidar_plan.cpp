#include "host/lidar/make_lidar_plan.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "host/base/error.h"
#include "host/base/units.h"
#include "host/lidar/air_column.h"
#include "host/lidar/footprint.h"
#include "host/lidar/gauss_hermite.h"
#include "host/lidar/pulse_lobes.h"
#include "host/lidar/pulse_taps.h"
#include "scene_compiler/matter.h"
#include "scene_compiler/spectral_shape.h"

namespace raycube::lidar {

namespace {

constexpr double kPlanck_J_s = 6.62607015e-34;

std::vector<Matter> matter_of(const LidarPlan& plan, const scene::CompiledScene& scene) {
  const auto lines = static_cast<std::size_t>(plan.lines());
  std::vector<Matter> out(scene.materials.size() * lines);
  base::Problems problems;
  for (const auto m : scene.blocks.empty() ? std::vector<std::uint32_t>{} : scene::used_materials(scene)) {
    try {
      for (std::size_t l = 0; l < lines; ++l) out[m * lines + l] = matter_at(plan, scene.materials[m], l);
    } catch (const base::Error& error) {
      problems.add({"", 0, 0, plan.lidar.name}, error.what(), "", "or use another wavelength");
    }
  }
  if (const auto [first, other] = scene::gloss_clash(scene); other && has_line_lobes(scene))
    problems.add(
        {"", 0, 0, plan.lidar.name}, "materials of different gloss, one of which changes with wavelength, mixed",
        "'" + first->name + "' and '" + other->name + "'", "give them one gloss, or set mixture = \"stochastic\"");
  problems.throw_if_any();
  return out;
}

double linear_at(const std::vector<double>& x, const std::vector<double>& y, double at) {
  const auto above = static_cast<std::size_t>(std::upper_bound(x.begin(), x.end(), at) - x.begin());
  if (above == x.size()) return y.back();
  const std::size_t below = above - 1;
  return y[below] + (y[above] - y[below]) * (at - x[below]) / (x[above] - x[below]);
}

std::vector<double> cross_sections(const LidarPlan& plan, const scene::CompiledScene& scene) {
  std::vector<double> out;
  base::Problems problems;
  for (const auto& volume : scene.volumes)
    for (const auto& node : plan.nodes) {
      double value = 0;
      const auto& x = volume.wavelength_um;
      if (!volume.gas.empty()) {
        if (x.empty() || node.wavelength_um < x.front() || node.wavelength_um > x.back())
          problems.add({"", 0, 0, "volume " + volume.name},
                       "its gas has no cross section at a wavelength of LIDAR " + plan.lidar.name,
                       std::to_string(1e3 * node.wavelength_um) + " nm",
                       "give cross sections that cover the laser's line");
        else
          value = linear_at(x, volume.cross_section_cm2, node.wavelength_um);
      }
      out.push_back(value);
    }
  problems.throw_if_any();
  return out;
}

/// Highest place that a beam reaches within the gate: of pulses that look up, where the gate ends. 256 pulses spread
/// over the survey speak for all.
double highest_view_m(const scene::Lidar& lidar, std::uint64_t seed) {
  const double reach = 0.5 * base::kLightSpeed_m_s * (lidar.gate.start_s + lidar.gate.bins * lidar.gate.bin_s) /
                       lidar.transport.group_index;
  double highest = -1e30;
  const std::int64_t step = std::max<std::int64_t>(1, lidar.pulses / 256);
  for (std::int64_t pulse = 0; pulse < lidar.pulses; pulse += step)
    for (const auto& shot : make_shots(lidar, pulse, 1, seed)) {
      const double up =
          std::min(1.0, shot.exit_axis[2] + 3 * lidar.pulse.half_divergence_rad + lidar.receiver.half_fov_rad);
      highest = std::max(highest, shot.exit_m[2] + std::max(0.0, up) * std::max(0.0, reach));
    }
  return highest;
}

}  // namespace

std::vector<SpectralNode> make_nodes(const scene::Lidar& lidar) {
  std::vector<SpectralNode> out;
  for (std::size_t l = 0; l < lidar.pulse.lines.size(); ++l) {
    const auto& line = lidar.pulse.lines[l];
    if (line.fwhm_um == 0 || lidar.transport.line_nodes == 1) {
      out.push_back({static_cast<int>(l), line.wavelength_um, 1});
      continue;
    }
    const HermiteRule rule = gauss_hermite(lidar.transport.line_nodes);
    for (std::size_t i = 0; i < rule.x.size(); ++i)
      out.push_back(
          {static_cast<int>(l), line.wavelength_um + base::kSigmaOfFwhm * line.fwhm_um * rule.x[i], rule.w[i]});
  }
  return out;
}

LidarPlan make_lidar_plan(const scene::Simulation& simulation, const scene::Lidar& lidar,
                          const atmos::RenderTable* table) {
  LidarPlan plan;
  plan.lidar = lidar;
  plan.seed = simulation.seed;
  plan.nodes = make_nodes(lidar);
  for (std::size_t n = 0; n < plan.nodes.size(); ++n)
    if (n == 0 || plan.nodes[n].line != plan.nodes[n - 1].line) plan.first_node.push_back(static_cast<int>(n));
  plan.first_node.push_back(static_cast<int>(plan.nodes.size()));
  for (const auto& line : lidar.pulse.lines)
    plan.photons.push_back(lidar.pulse.transmit_efficiency * line.energy_J * line.wavelength_um * 1e-6 /
                           (kPlanck_J_s * base::kLightSpeed_m_s));
  plan.sensor_low_m = 1e30, plan.sensor_high_m = -1e30;
  for (const auto& pose : lidar.trajectory) {
    plan.sensor_low_m = std::min(plan.sensor_low_m, pose.z_m);
    plan.sensor_high_m = std::max(plan.sensor_high_m, pose.z_m);
  }
  const bool empty = simulation.scene.instances.empty();
  const double low =
      empty ? std::min(0.0, plan.sensor_low_m) : std::min<double>(simulation.scene.lo[2], plan.sensor_low_m);
  const double high = empty ? plan.sensor_high_m : std::max<double>(simulation.scene.hi[2], plan.sensor_high_m);
  if (table != nullptr)
    plan.air =
        make_air(*table, plan.nodes, plan.lines(), low, std::max(high, highest_view_m(lidar, simulation.seed)) + 10);
  plan.matter = matter_of(plan, simulation.scene);
  plan.cross_section_cm2 = cross_sections(plan, simulation.scene);
  plan.taps = make_taps(lidar.pulse, lidar.gate.bin_s);
  plan.footprint = make_footprint(lidar, exit_matters(lidar));
  return plan;
}

}  // namespace raycube::lidar
