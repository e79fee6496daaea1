#include "host/render/photons.h"

#include "host/cl/kernel.h"
#include "host/render/scene_on_device.h"
#include "host/render/tile_shape.h"
#include "kernels/kernel_source.h"
#include "kernels/shared/photon_arguments.h"
#include "scene_compiler/matter.h"

namespace raycube::render {

namespace {

RC_ARGUMENT_STRUCT(TracePhotonsArguments, "trace_photons", RC_TRACE_PHOTONS_ARGUMENTS)

constexpr std::size_t kOfItem = 16;  ///< photons that a work-item takes

std::string program_options(const scene::CompiledScene& scene, const SceneBuffers& buffers) {
  return "-cl-std=CL1.2 -DRC_STACK=" + std::to_string(kernel_stack(scene.stack_bound())) +
         matter_options(scene::camera_matter(scene)) + buffers.options;
}

}  // namespace

struct PhotonTracer::State : SceneOnDevice {
  State(const scene::CompiledScene& scene_, const RenderOptions& options_,
        const std::vector<shared::rc_float4>& scattering_)
      : SceneOnDevice(scene_, options_),
        program(context.program("trace_photons", kernels::kernel_source("trace_photons"),
                                program_options(scene_, buffers))),
        kernel(*program, "trace_photons"),
        scattering(context, scattering_, cl::Access::read_only, "scattering of surfaces"),
        photons(context, kAtOnce, cl::Access::read_write, "photons") {}

  std::shared_ptr<const cl::Program> program;
  cl::Kernel kernel;
  cl::Buffer<shared::rc_float4> scattering;
  cl::Buffer<shared::Photon> photons;
};

PhotonTracer::PhotonTracer(const scene::CompiledScene& scene, const RenderOptions& options,
                           const std::vector<shared::rc_float4>& scattering)
    : state_(std::make_unique<State>(scene, options, scattering)) {}
PhotonTracer::~PhotonTracer() = default;

void PhotonTracer::step(std::vector<shared::Photon>& photons, std::uint32_t level, std::uint32_t seed) {
  if (photons.empty()) return;
  State& s = *state_;
  s.photons.write(photons);
  s.kernel.arguments(TracePhotonsArguments{.nodes = s.buffers.nodes,
                                           .blocks = s.buffers.blocks,
                                           .instances = s.buffers.instances,
                                           .lobes = s.buffers.lobes,
                                           .scattering = s.scattering,
                                           .count = static_cast<cl_uint>(photons.size()),
                                           .level = level,
                                           .seed = seed,
                                           .photons = s.photons});
  s.context.launch(s.kernel, (photons.size() + kOfItem - 1) / kOfItem);
  s.photons.read(photons);
}

}  // namespace raycube::render
