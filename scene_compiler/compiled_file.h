// Compiled scenes on disk (.rcs) and their content hash.
#pragma once

#include <string>

#include "scene_compiler/compiled_scene.h"

namespace raycube::scene {

/// Layout version of .rcs files; a file of another version is refused.
inline constexpr std::uint32_t kCompiledFileVersion = 12;

/// SHA-256 (hex) of the origin, materials (names, curves; not the text of their source), surfaces, meshes, trees,
/// instances, nodes and blocks, and of volumes, ways of transmission and gloss where there are any, in the byte order
/// of the file. Equal hashes give equal results.
std::string content_hash(const CompiledScene& scene);

/// Writes atomically. Throws Error(environment) when the disk refuses.
void save_compiled(const CompiledScene& scene, const std::string& file, bool overwrite = false);

/// Throws Error(input) for a file that is missing, empty, not .rcs, of another version or byte order,
/// truncated, longer than it says, or whose content does not have the hash it carries.
CompiledScene load_compiled(const std::string& file);

}  // namespace raycube::scene
