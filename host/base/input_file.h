// What a path is that a user gave for a file to read.
#pragma once

#include <string>

namespace raycube::base {

/// "" for a plain file, or a link to one, that may be read; else why not: "is not there", "is a folder", "is
/// a pipe", "is a device" ... Opens nothing, since opening a pipe waits for its writer and a device may never
/// end.
std::string why_no_plain_file(const std::string& path);

/// Throws Error(input), "PATH: is a pipe; ...", for what is there and no plain file. What is not there is
/// left to whoever opens it.
enum class OrFolder { no, yes };
void refuse_other_than_plain(const std::string& path, OrFolder folder = OrFolder::no);

}  // namespace raycube::base
