#include "tests/support/any_hits.h"

#include "tests/support/brute_trace.h"
#include "tests/support/probes.h"

namespace raycube::test {
std::vector<AnyAnswers> any_hits(const cl::Context& context, const scene::CompiledScene& scene, const AnyRays& rays) {
  const std::size_t sixteens = rays.x.size() / 16;
  std::vector<float> all;
  for (const std::vector<float>* part : {&rays.x, &rays.y, &rays.z, &rays.dx, &rays.dy, &rays.dz})
    all.insert(all.end(), part->begin(), part->end());
  const render::SceneBuffers buffers(context, scene);
  const auto program = probes(context, buffers.options);
  cl::Kernel kernel(*program, "any_hits");
  const cl::Buffer<std::uint32_t> ranges(context, block_ranges(scene), cl::Access::read_only, "blocks of instances");
  const cl::Buffer<float> sent(context, all, cl::Access::read_only, "rays");
  const cl::Buffer<std::uint32_t> answers(context, 4 * sixteens, cl::Access::write_only, "answers");
  kernel.arguments(buffers.nodes, buffers.blocks, buffers.instances, ranges,
                   static_cast<std::uint32_t>(scene.instances.size()), sent, static_cast<std::uint32_t>(rays.x.size()),
                   answers);
  context.launch(kernel, sixteens);
  context.finish();
  const std::vector<std::uint32_t> words = answers.read_all();
  std::vector<AnyAnswers> found;
  for (std::size_t i = 0; i < words.size(); i += 4)
    found.push_back({words[i], words[i + 1], words[i + 2], words[i + 3]});
  return found;
}

}  // namespace raycube::test
