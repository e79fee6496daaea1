// What `raycube info` says about a mesh file: its parts by the names that [[mesh]] materials may use.
#pragma once

#include <string>

#include "host/cli/verb.h"

namespace raycube::cli {

/// By the name's end; one that Assimp reads and nothing else of ours.
bool is_mesh_file(const std::string& path);
void print_mesh_info(Invocation& invocation, const std::string& path);

}  // namespace raycube::cli
