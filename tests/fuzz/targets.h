// What reads files that users bring, one function each: bytes in, base::Error or nothing out. Fed by libFuzzer
// (fuzz_main.cpp) and, from the corpora, by the ordinary build (replay_main.cpp).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace raycube::fuzz {

struct Target {
  const char* name;                       ///< of its corpus folder too
  const char* file;                       ///< name the bytes get; readers look at its ending
  void (*read)(const std::string& path);  ///< reads the file as the program does
};

std::span<const Target> targets();
/// Null when there is none such.
const Target* find_target(const std::string& name);

/// A folder of this process in memory, made at the first call and removed at exit.
const std::string& scratch_folder();

/// Writes the bytes and reads them. Errors that the program would report (base::Error) are expected; anything else
/// leaves as it is.
void feed(const Target& target, const std::uint8_t* data, std::size_t bytes);

}  // namespace raycube::fuzz
