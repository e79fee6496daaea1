#include "host/cl/kernel_archive.h"

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <stdexcept>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "host/base/sha256.h"

namespace raycube::cl {
namespace {

constexpr std::string_view kMagic = "RCKERN1\n";
constexpr std::size_t kDigits = 64;
constexpr std::int64_t kMostBytes = std::int64_t{1} << 30;

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

std::string read_own_file(const std::filesystem::path& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (file < 0) throw std::runtime_error(std::string("it cannot be opened: ") + std::strerror(errno));
  struct Closed {
    int file;
    ~Closed() { ::close(file); }
  } closed{file};
  struct stat status {};
  if (::fstat(file, &status) != 0 || !S_ISREG(status.st_mode))
    throw std::runtime_error("it is no regular file");
  if (status.st_uid != ::geteuid())
    throw std::runtime_error("it belongs to user " + std::to_string(status.st_uid));
  if (status.st_mode & 022) throw std::runtime_error("others may write it");
  if (status.st_size > kMostBytes) throw std::runtime_error("it is too long");
  std::string content(static_cast<std::size_t>(status.st_size), '\0');
  for (std::size_t done = 0; done < content.size();) {
    const ssize_t got = ::read(file, content.data() + done, content.size() - done);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) throw std::runtime_error("it cannot be read");
    done += static_cast<std::size_t>(got);
  }
  return content;
}

}  // namespace raycube::cl
