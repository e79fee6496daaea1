// A scene that the device cannot hold is refused before tracing, in one message.
#include <doctest/doctest.h>

#include <string>

#include "host/base/error.h"
#include "host/render/trace_stages.h"

namespace {

using namespace raycube;

std::string refusal(const scene::CompiledScene& scene, const cl::DeviceInfo& device) {
  try {
    render::check_fits(scene, device);
  } catch (const base::Error& error) {
    return error.what();
  }
  return {};
}

/// 5 MiB of triangles (640 bytes a block) and 1 MiB of nodes (256 bytes each).
scene::CompiledScene some_scene() {
  scene::CompiledScene scene;
  scene.blocks.resize(8192);
  scene.nodes.resize(4096);
  return scene;
}

cl::DeviceInfo some_device(std::size_t largest_mib, std::size_t memory_mib) {
  cl::DeviceInfo device;
  device.name = "a device";
  device.max_alloc_bytes = largest_mib << 20;
  device.global_memory_bytes = memory_mib << 20;
  return device;
}

TEST_CASE("S60 a scene that fits the device to the byte is taken") {
  CHECK(refusal(some_scene(), some_device(5, 6)).empty());
}

TEST_CASE("S60 an array larger than the device's largest buffer: one error with need, limit and ways out") {
  const std::string text = refusal(some_scene(), some_device(4, 16));
  CHECK(text.find("needs 6 MiB") != std::string::npos);
  CHECK(text.find("takes 4 MiB in one array") != std::string::npos);
  CHECK(text.find("triangles 5 MiB") != std::string::npos);
  CHECK(text.find("nodes 1 MiB") == std::string::npos);
  CHECK(text.find("--device") != std::string::npos);
}

TEST_CASE("S60 arrays that fit one by one but not together are refused too") {
  const std::string text = refusal(some_scene(), some_device(5, 5));
  CHECK(text.find("needs 6 MiB") != std::string::npos);
  CHECK(text.find("which has 5 MiB") != std::string::npos);
}

}  // namespace
