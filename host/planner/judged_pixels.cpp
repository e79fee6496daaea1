#include "host/planner/judged_pixels.h"

#include <algorithm>
#include <cmath>

#include "host/plan/bounces.h"
#include "host/planner/trial_pixels.h"
#include "host/render/truth.h"

namespace raycube::planner {

namespace {

constexpr std::uint64_t kWeighing = 0x7f4a7c15u;         ///< added to the seed
constexpr int kWeighingSamples = 34, kWeighingSide = 6;  ///< of a lattice; cells along a pixel under a point spread
constexpr int kWidestWeighed = 512;                      ///< pixels traced at once

bool is_listed(const scene::Simulation& simulation, const std::string& name) {
  const auto& listed = simulation.tolerance_of.materials;
  return std::find(listed.begin(), listed.end(), name) != listed.end();
}

}  // namespace

std::vector<double> material_weights(const scene::Simulation& simulation) {
  if (simulation.tolerance_of.materials.empty()) return {};
  const auto& materials = simulation.scene.materials;
  std::vector<double> out;
  for (std::size_t m = 0; m < materials.size(); ++m)
    out.push_back(is_listed(simulation, materials[m - materials[m].in_family].name) ? 1 : 0);
  return out;
}

std::vector<float> pixel_weights(render::Renderer& renderer, const scene::Simulation& simulation,
                                 const scene::Instrument& instrument, const plan::Plan& plan,
                                 const std::vector<render::Tile>& tiles) {
  if (simulation.tolerance_of.materials.empty()) return {};
  scene::Instrument few = instrument;
  few.first_samples = 0, few.replicates = 1;
  few.small_objects = scene::SmallObjects::off, few.standard_error = scene::StandardError::off;
  few.sampler = few.box_pixels() ? scene::SamplerKind::lattice : scene::SamplerKind::jittered;
  few.samples_u = few.box_pixels() ? kWeighingSamples : kWeighingSide;
  few.samples_v = few.box_pixels() ? 1 : kWeighingSide;
  plan::Plan seen = plan::without_paths(plan);
  if (seen.sends_rays()) seen.sky.rays = 1;
  const std::size_t layers = render::truth_layer_names(simulation.scene).size();
  const auto& materials = simulation.scene.materials;
  std::vector<std::size_t> listed;  // among the abundances, which follow the materials that the user named
  for (std::size_t m = 0, named = 0; m < materials.size(); ++m) {
    if (materials[m].in_family != 0) continue;
    if (is_listed(simulation, materials[m].name)) listed.push_back(render::truth::abundance + named);
    ++named;
  }
  std::vector<float> out;
  renderer.probe_together(few, seen, simulation.sun, simulation.seed + kWeighing, joined(tiles, kWidestWeighed),
                          [&](const render::PixelProbe& probe) {
                            for (std::size_t p = 0; p < probe.truth.size() / layers; ++p) {
                              float share = 0;
                              for (const std::size_t layer : listed) share += probe.truth[p * layers + layer];
                              out.push_back(share);
                            }
                          });
  return out;
}

double together(scene::ErrorFigure figure, double one, double other) {
  return figure == scene::ErrorFigure::rms ? std::hypot(one, other) : one + other;
}

double left_beside(scene::ErrorFigure figure, double all, double one) {
  if (figure == scene::ErrorFigure::rms) return std::sqrt(std::max(0.0, all * all - one * one));
  return std::max(0.0, all - one);
}

}  // namespace raycube::planner
