#include "scene_compiler/scene_info.h"
#include "scene_compiler/shape_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

namespace raycube::scene {

SceneInfo scene_info(const CompiledScene& scene) {
  SceneInfo out;
  out.content_hash = scene.content_hash;
  out.origin = scene.origin;
  out.lo = scene.lo;
  out.hi = scene.hi;
  out.surfaces = scene.surfaces.size();
  out.nodes = scene.nodes.size();
  out.blocks = scene.blocks.size();
  out.stack_bound = scene.stack_bound();
  std::uint32_t top_nodes = static_cast<std::uint32_t>(scene.nodes.size());
  for (const auto& tree : scene.trees) {
    out.trees.push_back({tree.triangle_count, tree.meshes.size(), 0, tree.block_count, tree.depth});
    top_nodes = std::min(top_nodes, tree.root);
  }
  for (const auto& mesh : scene.meshes) {
    out.meshes.push_back({mesh.name, mesh.triangle_count(), 0, mesh.tree});
    out.triangles += mesh.triangle_count();
  }
  for (const auto& instance : scene.instances) ++out.trees[instance.tree].instances;
  for (auto& mesh : out.meshes) {
    mesh.instances = out.trees[mesh.tree].instances;
    out.instances += mesh.instances;
    out.placed_triangles += mesh.instances * mesh.triangles;
  }
  for (const auto& material : scene.materials) {
    if (material.in_family > 0) {
      ++out.materials.back().spectra;
      continue;
    }
    const auto& w = material.reflectance.wavelength_um;
    out.materials.push_back({material.name, material.source, w.empty() ? 0 : w.front(), w.empty() ? 0 : w.back(),
                             w.size(), !material.transmittance.value.empty(), material.behind.number == RC_SHAPE_plate,
                             material.gloss.number != RC_SHAPE_none,
                             std::string(shape_entry(material.front.number).name), 1});
  }
  for (const auto& volume : scene.volumes) {
    const auto& w = volume.wavelength_um;
    const char* shape = volume.shape == Volume::Shape::box    ? "box"
                        : volume.shape == Volume::Shape::grid ? "grid"
                                                              : "plume";
    out.volumes.push_back({volume.name, shape, volume.gas, w.empty() ? 0 : w.front(), w.empty() ? 0 : w.back(),
                           volume.extinction_per_m > 0});
  }
  // The top tree comes first; finish_top_tree moves every other tree behind it.
  const std::uint64_t top_bytes = std::uint64_t{top_nodes} * sizeof(shared::BvhNode);
  const std::uint64_t tree_bytes =
      (out.nodes - top_nodes) * sizeof(shared::BvhNode) + out.blocks * sizeof(shared::TriBlock);
  const std::uint64_t instance_bytes = scene.instances.size() * sizeof(shared::Instance);
  out.bytes = top_bytes + tree_bytes + instance_bytes + out.surfaces * sizeof(shared::Surface);
  if (out.triangles > 0) out.bytes_per_triangle = static_cast<double>(tree_bytes) / static_cast<double>(out.triangles);
  if (out.instances > 0)
    out.bytes_per_instance = static_cast<double>(top_bytes + instance_bytes) / static_cast<double>(out.instances);
  if (out.blocks > 0)
    out.block_fill = static_cast<double>(out.triangles) / (static_cast<double>(out.blocks) * RC_BLOCK);
  return out;
}

std::string scene_info_text(const SceneInfo& info) {
  std::string out = fmt::format("content        {}\n", info.content_hash);
  out += info.origin.epsg ? fmt::format("origin         EPSG:{} {} {} {} m\n", info.origin.epsg, info.origin.easting_m,
                                        info.origin.northing_m, info.origin.height_m)
                          : "origin         local\n";
  if (info.instances > 0)
    out += fmt::format("bounds         x {:.3f} .. {:.3f}, y {:.3f} .. {:.3f}, z {:.3f} .. {:.3f} m\n", info.lo[0],
                       info.hi[0], info.lo[1], info.hi[1], info.lo[2], info.hi[2]);
  out += fmt::format("triangles      {} stored, {} placed by {} instances\n", info.triangles, info.placed_triangles,
                     info.instances);
  out += fmt::format(
      "memory         {:.1f} MiB: {:.1f} bytes per triangle, {:.1f} bytes per instance, blocks {:.0f} % "
      "full\n",
      static_cast<double>(info.bytes) / (1 << 20), info.bytes_per_triangle, info.bytes_per_instance,
      100 * info.block_fill);
  out += fmt::format("trees          {} of {} meshes, {} nodes, traversal stack of {}\n", info.trees.size(),
                     info.meshes.size(), info.nodes, info.stack_bound);
  out += fmt::format("surfaces       {}\n\nmeshes\n", info.surfaces);
  for (const auto& mesh : info.meshes)
    out += fmt::format("  {:<32} {:>9} triangles x {}\n", mesh.name, mesh.triangles, mesh.instances);
  out += "\nmaterials\n";
  for (const auto& m : info.materials)
    out += fmt::format("  {:<32} {:.3f} .. {:.3f} um, {} points{}{}{}{}{}\n", m.name, m.first_um, m.last_um, m.points,
                       m.spectra > 1 ? fmt::format(", family of {}", m.spectra) : "",
                       m.shape == "lambert" ? "" : ", " + m.shape,
                       m.plate       ? ", plate"
                       : m.transmits ? ", transmits"
                                     : "",
                       m.gloss ? ", gloss" : "", m.source.empty() ? "" : "; " + m.source);
  if (!info.volumes.empty()) out += "\nvolumes\n";
  for (const auto& v : info.volumes)
    out += fmt::format("  {:<32} {}{}{}\n", v.name, v.shape,
                       v.gas.empty() ? "" : fmt::format(", {} {:.4f} .. {:.4f} um", v.gas, v.first_um, v.last_um),
                       v.particles ? ", particles" : "");
  return out;
}

std::string scene_info_json(const SceneInfo& info) {
  nlohmann::ordered_json meshes = nlohmann::ordered_json::array(), trees = meshes, materials = meshes, volumes = meshes;
  for (const auto& m : info.meshes)
    meshes.push_back({{"name", m.name}, {"triangles", m.triangles}, {"instances", m.instances}, {"tree", m.tree}});
  for (const auto& t : info.trees)
    trees.push_back({{"triangles", t.triangles},
                     {"meshes", t.meshes},
                     {"instances", t.instances},
                     {"blocks", t.blocks},
                     {"depth", t.depth}});
  for (const auto& m : info.materials)
    materials.push_back({{"name", m.name},
                         {"source", m.source},
                         {"first_um", m.first_um},
                         {"last_um", m.last_um},
                         {"points", m.points},
                         {"transmits", m.transmits},
                         {"plate", m.plate},
                         {"gloss", m.gloss},
                         {"shape", m.shape},
                         {"spectra", m.spectra}});
  for (const auto& v : info.volumes)
    volumes.push_back({{"name", v.name},
                       {"shape", v.shape},
                       {"gas", v.gas},
                       {"first_um", v.first_um},
                       {"last_um", v.last_um},
                       {"particles", v.particles}});
  const nlohmann::ordered_json out = {{"content_hash", info.content_hash},
                                      {"origin",
                                       {{"epsg", info.origin.epsg},
                                        {"easting_m", info.origin.easting_m},
                                        {"northing_m", info.origin.northing_m},
                                        {"height_m", info.origin.height_m}}},
                                      {"lo_m", info.lo},
                                      {"hi_m", info.hi},
                                      {"triangles", info.triangles},
                                      {"placed_triangles", info.placed_triangles},
                                      {"instances", info.instances},
                                      {"surfaces", info.surfaces},
                                      {"nodes", info.nodes},
                                      {"blocks", info.blocks},
                                      {"stack_bound", info.stack_bound},
                                      {"bytes", info.bytes},
                                      {"bytes_per_triangle", info.bytes_per_triangle},
                                      {"bytes_per_instance", info.bytes_per_instance},
                                      {"block_fill", info.block_fill},
                                      {"meshes", meshes},
                                      {"trees", trees},
                                      {"materials", materials},
                                      {"volumes", volumes}};
  return out.dump(2, ' ', false, decltype(out)::error_handler_t::replace) + "\n";
}

}  // namespace raycube::scene
