// SHA-256 of a file's fixed blocks of 4 MiB, made of the bytes that go to the file system, in whatever order
// they come.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "host/base/sha256.h"

namespace raycube::base {

inline constexpr std::uint64_t kHashBlock_bytes = 4u << 20;

struct FileHashes {
  std::uint64_t bytes = 0;          ///< of the file
  std::vector<std::string> blocks;  ///< SHA-256 of each block, hexadecimal; the last one may be shorter
  std::string list;                 ///< SHA-256 of the blocks' digests, 32 bytes each, one after the other
};

/// SHA-256 of a list of hexadecimal digests, taken as bytes.
std::string hash_of_list(const std::vector<std::string>& blocks);

/// A block that comes from its first byte to its last is hashed on the way. One that comes otherwise (an
/// image in bands, a header filled in at the end) is read back once at the end; a sum over all that was
/// written, sum of (8-byte word x a number made of its place) modulo 2^64, which no order changes, then has
/// to be that of what was read. So a stranger's bytes are told, not hashed.
class BlockHashes {
 public:
  /// Reads bytes of the file, all of which were written before.
  using ReadBack = std::function<void(std::uint64_t offset, void* data, std::size_t bytes)>;

  BlockHashes(std::string path, ReadBack read_back) : path_(std::move(path)), read_back_(std::move(read_back)) {}

  /// Blocks will be written again: none is hashed on the way, which would be for nothing.
  void expect_rewriting() { rewritten_ = true; }

  /// Before the bytes go to the file, which still holds what they replace.
  void about_to_write(std::uint64_t offset, const void* data, std::size_t bytes);
  /// Of the first `bytes` of the file, all that was written. Places never written are zeros. Throws
  /// Error(environment) when the file does not hold what was written.
  FileHashes finish(std::uint64_t bytes);

 private:
  using Span = std::pair<std::uint64_t, std::uint64_t>;  ///< first byte and the one after the last
  struct Block {
    Sha256 sha;  ///< of the first in_order bytes
    std::uint64_t in_order = 0;
    bool scattered = false;  ///< then sum and written count instead
    std::uint64_t sum = 0;
    std::vector<Span> written;  ///< in order, apart from each other
  };

  void write_in_block(std::uint64_t number, std::uint64_t offset, const unsigned char* data, std::size_t bytes);
  void scatter(Block& block, std::uint64_t start);
  void take_out_replaced(Block& block, const Span& span);
  std::vector<unsigned char> read(std::uint64_t offset, std::uint64_t bytes) const;
  [[noreturn]] void changed(std::uint64_t start) const;

  std::string path_;
  ReadBack read_back_;
  bool rewritten_ = false;
  std::vector<Block> blocks_;
};

}  // namespace raycube::base
