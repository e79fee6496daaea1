#include "host/base/own_file.h"

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <stdexcept>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace raycube::base {
namespace {

constexpr std::int64_t kMostBytes = std::int64_t{1} << 30;

std::string read_trusted(const std::string& path, std::initializer_list<uid_t> owners) {
  const int file = ::open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (file < 0) throw std::runtime_error(std::string("it cannot be opened: ") + std::strerror(errno));
  struct Closed {
    int file;
    ~Closed() { ::close(file); }
  } closed{file};
  struct stat status {};
  if (::fstat(file, &status) != 0 || !S_ISREG(status.st_mode)) throw std::runtime_error("it is no regular file");
  if (std::find(owners.begin(), owners.end(), status.st_uid) == owners.end())
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

}  // namespace

std::string read_own_file(const std::string& path) { return read_trusted(path, {::geteuid()}); }

std::string read_installed_file(const std::string& path) {
  struct stat program {};
  const uid_t installer = ::stat("/proc/self/exe", &program) == 0 ? program.st_uid : 0;
  return read_trusted(path, {::geteuid(), installer, 0});
}

}  // namespace raycube::base
