// Leaks at 1e8: camera rays over closed ground, and rays from inside a closed mesh aimed at the interiors of its edges.
#include <algorithm>
#include <cmath>

#include "bench/cases.h"
#include "bench/scenes/scenes.h"
#include "bench/trace_comparison.h"
#include "bench/trace_rig.h"
#include "host/sensors/ray_groups.h"
#include "kernels/sampling/sampler.h"

namespace raycube::bench {
namespace {

constexpr double kRays = 1e8;

std::uint64_t misses(const TraceRig& rig) {
  const auto hits = rig.hits();
  return static_cast<std::uint64_t>(
      std::count_if(hits.begin(), hits.end(), [](const RayResult& r) { return r.instance == RC_NONE; }));
}

void camera_rays(const Settings& settings, Report& report) {
  const auto scene = compile({terrain_mesh()}, {{kIdentity}});
  auto camera = terrain_camera();
  camera.sampler = scene::SamplerKind::jittered;  // other rays in every run
  const auto groups = sensors::make_ray_groups(camera, scene, 0, camera.lines);
  TraceRig rig(scene, camera, groups.size(), bench_sun(), settings.threads);
  rig.set_groups(groups);
  const double rays_per_run = static_cast<double>(groups.size()) * RC_GROUP_WIDTH * camera.samples_u * camera.samples_v;
  std::uint64_t lost = 0;
  double rays = 0;
  for (std::uint32_t run = 0; rays < kRays; ++run, rays += rays_per_run) {
    rig.run(run * static_cast<std::uint32_t>(camera.lines));
    lost += misses(rig);
  }
  report.add("leak_camera_rays", rays, "rays", Goal::at_least(kRays));
  report.add("leaks_camera", static_cast<double>(lost), "rays", Goal::at_most(0));
}

// One group whose 484 rays run along one edge, from 2 % to 98 % of its length. b stays 0 (one row of samples); dv only
// gives the pyramid a thickness.
shared::RayGroup along_edge(const std::array<float, 3>& a, const std::array<float, 3>& b,
                            const std::array<double, 3>& eye) {
  std::array<double, 3> edge, middle, side;
  for (std::size_t k = 0; k < 3; ++k) {
    edge[k] = static_cast<double>(b[k]) - a[k];
    middle[k] = 0.5 * (static_cast<double>(a[k]) + b[k]) - eye[k];
  }
  for (std::size_t k = 0; k < 3; ++k)
    side[k] = edge[(k + 1) % 3] * middle[(k + 2) % 3] - edge[(k + 2) % 3] * middle[(k + 1) % 3];
  const double length = std::hypot(edge[0], edge[1], edge[2]),
               thick = 0.24 * length / std::hypot(side[0], side[1], side[2]);
  const auto rounded = [](const std::array<double, 3>& v, double scale) {
    return shared::rc_float4{static_cast<float>(scale * v[0]), static_cast<float>(scale * v[1]),
                             static_cast<float>(scale * v[2]), 0};
  };
  return {rounded(eye, 1), rounded(middle, 1), rounded(edge, 0.24), rounded(side, thick), {}};
}

void edge_rays(const Settings& settings, Report& report) {
  const scene::TriangleMesh mesh = bumpy_sphere();
  const auto scene = compile({mesh}, {{kIdentity}});
  scene::Instrument along;
  along.name = "edges";
  along.samples_u = 121;
  along.samples_v = 1;
  constexpr std::size_t kGroups = 16384;
  TraceRig rig(scene, along, kGroups, bench_sun(), settings.threads);
  const double rays_per_run = static_cast<double>(kGroups) * RC_GROUP_WIDTH * 121;
  std::uint64_t lost = 0;
  double rays = 0;
  std::vector<shared::RayGroup> groups(kGroups);
  for (std::uint32_t run = 0; rays < kRays; ++run, rays += rays_per_run) {
    for (std::uint32_t g = 0; g < kGroups; ++g) {
      const auto draw = [&](std::uint32_t dimension) { return rc_hash(31u, run * kGroups + g, 0u, dimension); };
      const auto& t = mesh.triangles[draw(0) % mesh.triangles.size()];
      const std::uint32_t k = draw(1) % 3;
      const std::array<double, 3> eye{rc_unit_float(draw(2)) - 0.5, rc_unit_float(draw(3)) - 0.5,
                                      rc_unit_float(draw(4)) - 0.5};
      groups[g] = along_edge(mesh.vertices[t[k]], mesh.vertices[t[(k + 1) % 3]], eye);
    }
    rig.set_groups(groups);
    rig.run();
    lost += misses(rig);
  }
  report.add("leak_edge_rays", rays, "rays", Goal::at_least(kRays));
  report.add("leaks_edge", static_cast<double>(lost), "rays", Goal::at_most(0));
}

}  // namespace

void run_leaks(const Settings& settings, Report& report) {
  camera_rays(settings, report);
  edge_rays(settings, report);
}

}  // namespace raycube::bench
