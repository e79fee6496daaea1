// Every triangle against every ray with the kernels' own triangle test, no tree and no bundle: what both must give, bit
// by bit.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "tests/support/trace_chain.h"

namespace raycube::test {

/// First and one past the last block of each placed tree, in the order of scene.instances.
std::vector<std::uint32_t> block_ranges(const scene::CompiledScene& scene);

class BruteTrace {
 public:
  BruteTrace(const cl::Context& context, const scene::CompiledScene& scene, const TraceShape& shape);
  /// As TraceChain::primary over all samples.
  std::vector<std::uint32_t> primary(std::span<const shared::RayGroup> groups);
  /// As TraceChain::sun for points as surface() gives them.
  std::vector<std::uint16_t> sun(std::span<const float> points, const shared::rc_float4& direction);

 private:
  const cl::Context& context_;
  TraceShape shape_;
  std::uint32_t count_;
  std::shared_ptr<const cl::Program> program_;
  cl::Kernel primary_, sun_;
  cl::Buffer<shared::BvhNode> nodes_;
  cl::Buffer<shared::TriBlock> blocks_;
  cl::Buffer<shared::Instance> instances_;
  cl::Buffer<std::uint32_t> ranges_;
  cl::Buffer<shared::RayGroup> groups_;
  cl::Buffer<std::uint32_t> hits_;
  cl::Buffer<float> points_;
  cl::Buffer<std::uint16_t> sun_mask_;
};

}  // namespace raycube::test
