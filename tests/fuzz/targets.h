// What reads files that users bring, one function each: bytes in, base::Error or nothing out. Fed by libFuzzer
// (fuzz_main.cpp) and, from the corpora and their mutations, by the ordinary build (replay_main.cpp, mutate_main.cpp).
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
  /// Where the numbers that a text counts begin; null: it counts none.
  std::size_t (*body)(const std::string& text) = nullptr;
  bool by_others = false;  ///< GDAL or Assimp read it, in a process of their own: not for libFuzzer
};

std::span<const Target> targets();
/// Null when there is none such.
const Target* find_target(const std::string& name);

/// A folder of this process in memory, made at the first call and removed at exit.
const std::string& scratch_folder();

/// Removes this process's folder, of one that ends without exit handlers.
void remove_scratch();

/// Writes the bytes and reads them. Errors that the program would report (base::Error) are expected; anything else
/// leaves as it is. True: it was read.
bool feed(const Target& target, const std::uint8_t* data, std::size_t bytes);

}  // namespace raycube::fuzz
