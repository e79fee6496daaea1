// Files of one program in one checked file: "RCKERN1\n", key (64 hexadecimal digits), count, then for each
// file the lengths of its relative path and content (little-endian 64 bits) and both; at the end the SHA-256
// of all that stands before it (64 digits).
#pragma once

#include <map>
#include <string>
#include <string_view>

namespace raycube::cl {

/// Content by relative path.
using KernelFiles = std::map<std::string, std::string>;

std::string pack_kernels(std::string_view key, const KernelFiles& files);

/// The files of `archive`. Throws std::runtime_error that says what is wrong with it: cut short, not its
/// checksum, of another key, a path that leads elsewhere.
KernelFiles unpack_kernels(std::string_view key, std::string_view archive);

}  // namespace raycube::cl
