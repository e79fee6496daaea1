// First hits on the terrain against Embree (robust) and double: the very comparison of `raycube check`, on the
// benchmark's rays and on as many jittered ones.
#include "bench/cases.h"
#include "bench/scenes/scenes.h"
#include "host/run/check_instrument.h"

namespace raycube::bench {

void run_check(const Settings& settings, Report& report) {
  const auto scene = compile({terrain_mesh()}, {{kIdentity}});
  render::RenderOptions options;
  options.threads = settings.threads;
  render::Renderer renderer(scene, options);
  reference::HitReport all;
  for (const scene::SamplerKind sampler : {scene::SamplerKind::grid, scene::SamplerKind::jittered}) {
    auto camera = terrain_camera();
    camera.sampler = sampler;
    const auto rays = static_cast<std::uint64_t>(camera.pixels * camera.lines * camera.samples_u * camera.samples_v);
    all.add(run::check_hits(renderer, scene, camera, 1, rays, settings.threads));
  }
  report.add("check_rays", static_cast<double>(all.rays), "rays", Goal::at_least(1e7));
  report.add("check_explained_share", all.explained_share(), "", Goal::at_most(5e-5));
  for (const auto cause : {reference::Cause::exact_tie, reference::Cause::edge_tie, reference::Cause::depth_tie,
                           reference::Cause::grazing}) {
    std::string key = std::string("check_") + reference::cause_name(cause);
    for (char& c : key) c = c == ' ' ? '_' : c;
    report.add(key, static_cast<double>(all.of(cause)), "rays");
  }
  report.add("check_device_right", static_cast<double>(all.device_right), "rays");
  report.add("check_embree_right", static_cast<double>(all.embree_right), "rays");
  report.add("check_unexplained", static_cast<double>(all.of(reference::Cause::unexplained)), "rays",
             Goal::at_most(0).as_guard());
  report.add("check_hit_miss", static_cast<double>(all.hit_miss), "rays", Goal::at_most(0).as_guard());
  report.add("check_hit_miss_double", static_cast<double>(all.hit_miss_double), "rays", Goal::at_most(0).as_guard());
}

}  // namespace raycube::bench
