#include "host/render/scene_buffers.h"

#include <algorithm>
#include <bit>
#include <span>

#include "host/base/error.h"
#include "scene_compiler/matter.h"

namespace raycube::render {

namespace {

std::string mib(std::uint64_t bytes) { return std::to_string((bytes + (1u << 20) - 1) >> 20) + " MiB"; }

/// Calls action(array, its name) for each of the scene's arrays.
template <class Action>
void for_each_array(const scene::CompiledScene& scene, Action action) {
  action(scene.nodes, "nodes");
  action(scene.blocks, "triangles");
  action(scene.instances, "instances");
  action(scene.surfaces, "surfaces");
}

/// The device wants at least one element of everything, even of an empty scene. paged: kernels take all arrays so.
template <class T>
cl::PagedBuffer<T> upload(const cl::Context& context, const std::vector<T>& from, const char* what, bool paged,
                          std::uint64_t page_bytes) {
  const Paging paging =
      cut_into_pages(from.size(), sizeof(T), context.device().info().max_alloc_bytes, page_bytes).value();
  const std::size_t step = paging.pages == 1 ? from.size() : std::size_t{1} << paging.shift;
  const std::string name = std::string("scene ") + what;
  // Of an array in one page every index is below 2^31 (kMostElements), so that the shift leads to it.
  cl::PagedBuffer<T> out{{}, paged, paging.pages == 1 ? 31 : paging.shift};
  if (from.empty()) out.pages.emplace_back(context, std::vector<T>(1), cl::Access::read_only, name);
  for (std::size_t first = 0; first < from.size(); first += step)
    out.pages.emplace_back(context, std::span(from).subspan(first, std::min(step, from.size() - first)),
                           cl::Access::read_only, name);
  return out;
}

std::string options_of(const cl::Context& context, const scene::CompiledScene& scene, std::uint64_t page_bytes) {
  const cl::DeviceInfo& device = context.device().info();
  check_fits(scene, device, page_bytes);
  bool paged = false;
  for_each_array(scene, [&](const auto& array, const char*) {
    paged |= cut_into_pages(array.size(), sizeof array[0], device.max_alloc_bytes, page_bytes).value().pages > 1;
  });
  return paged ? " -DRC_PAGED=1" : "";
}

}  // namespace

std::uint64_t most_elements(std::size_t element_bytes, std::uint64_t largest_bytes, std::uint64_t page_bytes) {
  const std::uint64_t page = (page_bytes ? std::min(page_bytes, largest_bytes) : largest_bytes) / element_bytes;
  return page ? std::min(kMostElements, kMostPages * std::bit_floor(page)) : 0;
}

std::optional<Paging> cut_into_pages(std::uint64_t count, std::size_t element_bytes, std::uint64_t largest_bytes,
                                     std::uint64_t page_bytes) {
  if (count > most_elements(element_bytes, largest_bytes, page_bytes)) return std::nullopt;
  const std::uint64_t fit = (page_bytes ? std::min(page_bytes, largest_bytes) : largest_bytes / 2) / element_bytes;
  if (count <= fit) return Paging{};
  auto shift = static_cast<std::uint32_t>(std::bit_width(std::max<std::uint64_t>(fit, 1)) - 1);
  const auto pages_of = [&] { return ((count - 1) >> shift) + 1; };
  if (pages_of() > kMostPages) ++shift;  // the next power fits a whole buffer, or most_elements had refused
  return Paging{static_cast<std::uint32_t>(pages_of()), shift};
}

void check_fits(const scene::CompiledScene& scene, const cl::DeviceInfo& device, std::uint64_t page_bytes) {
  std::string too_large;
  std::uint64_t all = 0;
  for_each_array(scene, [&](const auto& array, const char* what) {
    constexpr std::size_t each = sizeof array[0];
    const std::uint64_t most = most_elements(each, device.max_alloc_bytes, page_bytes);
    all += array.size() * each;
    if (array.size() > most)
      too_large += std::string(too_large.empty() ? "" : ", ") + what + " " + mib(array.size() * each) + " of at most " +
                   std::to_string((most * each) >> 20) + " MiB";
  });
  if (!too_large.empty() || all > device.global_memory_bytes)
    throw base::Error(
        base::Fault::device,
        "the scene needs " + mib(all) + " on device '" + device.name + "', which has " +
            mib(device.global_memory_bytes) + " and takes " + mib(device.max_alloc_bytes) + " in one buffer" +
            (too_large.empty() ? "" : "; too large even in " + std::to_string(kMostPages) + " buffers: " + too_large) +
            "; place repeated meshes as instances, use coarser meshes or terrain, cut the scene to what the "
            "instrument sees, or choose another device (--device)");
}

namespace {

scene::Skyline without_cells(const scene::Skyline& skyline) {
  return {skyline.instance, skyline.x_m, skyline.y_m, skyline.per_cell, skyline.columns, skyline.rows, {}};
}

}  // namespace

SceneBuffers::SceneBuffers(const cl::Context& context, const scene::CompiledScene& scene, std::uint64_t page_bytes)
    : options(options_of(context, scene, page_bytes)),
      nodes(upload(context, scene.nodes, "nodes", !options.empty(), page_bytes)),
      blocks(upload(context, scene.blocks, "triangles", !options.empty(), page_bytes)),
      instances(upload(context, scene.instances, "instances", !options.empty(), page_bytes)),
      surfaces(upload(context, scene.surfaces, "surfaces", !options.empty(), page_bytes)),
      skyline(without_cells(scene.skyline)),
      skyline_cells(context, scene.skyline.cells.empty() ? std::vector<float>(1) : scene.skyline.cells,
                    cl::Access::read_only, "skylines of the ground"),
      lobes(context, scene::camera_lobes(scene), cl::Access::read_only, "shapes of surfaces") {}

}  // namespace raycube::render
