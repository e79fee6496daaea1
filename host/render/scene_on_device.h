// What the renderers of cameras and LIDARs hold alike: a scene in a device's memory, and how that device is used.
#pragma once

#include <algorithm>
#include <cstddef>

#include "host/cl/context.h"
#include "host/render/device_tuning.h"
#include "host/render/scene_buffers.h"
#include "host/render/tile_shape.h"
#include "host/render/types.h"
#include "host/sensors/scene_objects.h"

namespace raycube::render {

struct SceneOnDevice {
  SceneOnDevice(const scene::CompiledScene& scene_, const RenderOptions& options_)
      : scene(scene_),
        options(options_),
        context(pick_device(options_)),
        tuning(tuning_for(options_, context.device().info())),
        buffers(context, scene_, options_.page_bytes),
        objects(scene_) {
    context.set_launch_sizes(tuning.sizes);
  }

  /// What may be used of the device's memory.
  std::size_t memory() const {
    return std::min<std::size_t>(options.memory_bytes, context.device().info().global_memory_bytes);
  }
  /// Its share for the tiles, or the batch of shots, that are there at once.
  std::size_t tile_budget() const { return memory() / kBudgetShares; }
  DeviceTuning used_tuning() const { return {context.launch_sizes(), tuning.tile_samples, tuning.tuned}; }

  const scene::CompiledScene& scene;
  RenderOptions options;
  cl::Context context;
  DeviceTuning tuning;
  SceneBuffers buffers;
  mutable sensors::KnownObjects objects;
};

}  // namespace raycube::render
