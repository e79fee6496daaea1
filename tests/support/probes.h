// The program of kernels that only tests launch (tests/support/probes.cl). There is one, so that tests compile few.
#pragma once

#include <memory>
#include <string>

#include "host/cl/context.h"
#include "host/cl/program.h"

namespace raycube::test {

/// The deepest traversal that its kernels have room for: CompiledScene::stack_bound() of what they are given.
inline constexpr int kProbeStack = 512;

/// options: of the scene's arrays (SceneBuffers::options) or of its matter (render::matter_options).
std::shared_ptr<const cl::Program> probes(const cl::Context& context, const std::string& options = "");

}  // namespace raycube::test
