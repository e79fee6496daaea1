// Files that this program left for itself, read again from places where others may have put theirs.
#pragma once

#include <string>

namespace raycube::base {

/// All of a regular file, of at most 1 GiB, that belongs to this user and that nobody else may write; links
/// are not followed, and a pipe is not waited for. Throws std::runtime_error that says why not: "it belongs
/// to user 12345".
std::string read_own_file(const std::string& path);

/// The same of a file that was installed with the program: it may also belong to the user who owns the program's file,
/// or to root.
std::string read_installed_file(const std::string& path);

}  // namespace raycube::base
