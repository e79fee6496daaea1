#include "host/base/cache_folder.h"

#include <cstdlib>
#include <fstream>
#include <vector>

#include "host/base/sha256.h"

namespace raycube::base {

std::filesystem::path cache_folder(const std::string& kind) {
  if (const char* cache = std::getenv("XDG_CACHE_HOME"); cache && *cache)
    return std::filesystem::path(cache) / "raycube" / kind;
  if (const char* home = std::getenv("HOME"); home && *home)
    return std::filesystem::path(home) / ".cache/raycube" / kind;
  return {};
}

std::string program_hash() {
  Sha256 hash;
  std::ifstream file("/proc/self/exe", std::ios::binary);
  std::vector<char> piece(1 << 20);
  while (file.read(piece.data(), static_cast<std::streamsize>(piece.size())) || file.gcount() > 0)
    hash.add(piece.data(), static_cast<std::size_t>(file.gcount()));
  return hash.hex();
}

}  // namespace raycube::base
