// Sizes of memory as users write them, and how much of it this process has used.
#pragma once

#include <cstdint>
#include <string>

namespace raycube::base {

/// Bytes in "256M", "8G", "512MiB", "1.5G", "4096" (bytes). Suffixes K, M, G, T are powers of 1024, optionally followed
/// by B or iB, in either case. Throws Error(input) for anything else, for zero and for more than 2^60 bytes.
std::uint64_t parse_memory_size(const std::string& text);

/// "256 MiB", "1.5 GiB", "12 bytes": three significant digits, for people.
std::string format_bytes(std::uint64_t bytes);

/// Address space that this process may take, bytes (`ulimit -v`); 0: no limit. Safe in a signal handler.
std::uint64_t address_space_limit_bytes() noexcept;

/// "; this process may take 1 GiB of address space (ulimit -v)", to follow what went wrong; empty without a limit.
std::string address_space_text();

/// Largest resident set of this process so far, bytes (VmHWM of /proc/self/status; 0 where that file does not exist).
std::uint64_t peak_resident_bytes();

}  // namespace raycube::base
