// Where the program keeps what took long to compute, and what tells its builds apart.
#pragma once

#include <filesystem>
#include <string>

namespace raycube::base {

/// $XDG_CACHE_HOME/raycube/KIND, else ~/.cache/raycube/KIND; empty when the user has no home. It may not exist yet.
std::filesystem::path cache_folder(const std::string& kind);

/// SHA-256 of the running program's own bytes, so that no build reads what another made.
std::string program_hash();

}  // namespace raycube::base
