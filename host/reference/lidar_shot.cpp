#include "host/reference/lidar_shot.h"

#include "host/reference/lidar_walk.h"

namespace raycube::reference {

LidarReference reference_shot(const scene::CompiledScene& scene, const EmbreeScene& embree,
                              const lidar::LidarPlan& plan, const lidar::Shot& shot, const LidarShotOptions& options) {
  return lidar_walk::Walk(scene, embree, plan, shot, options).run();
}

}  // namespace raycube::reference
