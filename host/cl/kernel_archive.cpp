#include "host/cl/kernel_archive.h"

#include <cstdint>
#include <filesystem>
#include <stdexcept>

#include "host/base/sha256.h"

namespace raycube::cl {
namespace {

constexpr std::string_view kMagic = "RCKERN1\n";
constexpr std::size_t kDigits = 64;

void add_number(std::string& to, std::uint64_t value) {
  for (int i = 0; i < 8; ++i) to += static_cast<char>(value >> (8 * i) & 255);
}

/// Takes pieces from the front of what is left.
struct Reader {
  std::string_view rest;
  std::string_view take(std::uint64_t count) {
    if (count > rest.size()) throw std::runtime_error("it ends too early");
    const std::string_view piece = rest.substr(0, count);
    rest.remove_prefix(count);
    return piece;
  }
  std::uint64_t number() {
    std::uint64_t value = 0;
    const std::string_view bytes = take(8);
    for (int i = 0; i < 8; ++i) value |= std::uint64_t{static_cast<unsigned char>(bytes[i])} << (8 * i);
    return value;
  }
};

bool stays_inside(std::string_view name) {
  const std::filesystem::path path(name);
  if (name.empty() || path.is_absolute() || name.find('\0') != std::string_view::npos) return false;
  for (const auto& part : path)
    if (part == ".." || part == "." || part.empty()) return false;
  return true;
}

}  // namespace

std::string pack_kernels(std::string_view key, const KernelFiles& files) {
  std::string out(kMagic);
  out += key;
  add_number(out, files.size());
  for (const auto& [path, content] : files) {
    add_number(out, path.size());
    add_number(out, content.size());
    out += path;
    out += content;
  }
  return out + base::sha256_hex(out);
}

KernelFiles unpack_kernels(std::string_view key, std::string_view archive) {
  if (archive.size() < kMagic.size() + 2 * kDigits) throw std::runtime_error("it is cut short");
  const std::string_view body = archive.substr(0, archive.size() - kDigits);
  if (base::sha256_hex(body) != archive.substr(body.size()))
    throw std::runtime_error("its content is not that of its checksum");
  Reader reader{body};
  if (reader.take(kMagic.size()) != kMagic) throw std::runtime_error("it is of another format");
  if (reader.take(kDigits) != key) throw std::runtime_error("it holds another program");
  KernelFiles files;
  for (std::uint64_t count = reader.number(); count > 0; --count) {
    const std::uint64_t path_bytes = reader.number(), content_bytes = reader.number();
    const std::string path(reader.take(path_bytes));
    if (!stays_inside(path)) throw std::runtime_error("it names a file outside its folder");
    files[path] = reader.take(content_bytes);
  }
  return files;
}

}  // namespace raycube::cl
