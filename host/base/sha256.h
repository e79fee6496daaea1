// SHA-256 (FIPS 180-4), fed in pieces. Uses the processor's SHA instructions where they exist; same result without.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace raycube::base {

class Sha256 {
 public:
  enum class Code { fastest, portable };
  explicit Sha256(Code code = Code::fastest);

  Sha256& add(const void* data, std::size_t bytes);
  Sha256& add(std::string_view text) { return add(text.data(), text.size()); }
  /// The digest of all bytes added so far. The object stays usable: later bytes continue the same message.
  std::array<std::uint8_t, 32> digest() const;
  /// The digest as 64 lower-case hexadecimal digits.
  std::string hex() const;

 private:
  using Compress = void (*)(std::uint32_t* state, const std::uint8_t* blocks, std::size_t count);
  Compress compress_;
  std::array<std::uint32_t, 8> state_;
  std::array<std::uint8_t, 64> pending_;
  std::size_t pending_bytes_ = 0;
  std::uint64_t total_bytes_ = 0;
};

/// Hexadecimal SHA-256 of a text.
std::string sha256_hex(std::string_view text);

}  // namespace raycube::base
