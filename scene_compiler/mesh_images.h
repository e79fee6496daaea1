// Textures and masks of meshes.
#pragma once

#include <string>
#include <vector>

#include "scene_compiler/document.h"
#include "scene_compiler/material_table.h"
#include "scene_compiler/memory_sum.h"
#include "scene_compiler/mesh_file.h"

namespace raycube::scene {

/// A mesh's triangles as the images of their materials have them: cut by texel_cut.h along the texels of what lies by
/// texture coordinates, without the pieces that a mask leaves out; by metres each takes the texel at its middle. The
/// mesh keeps its order, and a piece its face's number. record: its [[mesh]]. Reported: faces without texture
/// coordinates, a mesh that nothing is left of, more pieces than a mesh may have or than there is memory for (`memory`,
/// which has the file's triangles already).
void lay_images(const Record& record, MaterialTable& materials, MeshFile& file, MemorySum& memory,
                std::vector<std::string>& notices, base::Problems& problems);

}  // namespace raycube::scene
