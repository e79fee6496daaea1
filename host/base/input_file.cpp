#include "host/base/input_file.h"

#include <cerrno>
#include <cstring>

#include <sys/stat.h>
#include <unistd.h>

#include "host/base/error.h"

namespace raycube::base {

std::string why_no_plain_file(const std::string& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0)
    return errno == ENOENT ? "is not there" : std::string("cannot be looked at: ") + std::strerror(errno);
  if (S_ISDIR(status.st_mode)) return "is a folder";
  if (S_ISFIFO(status.st_mode)) return "is a pipe";
  if (S_ISSOCK(status.st_mode)) return "is a socket";
  if (!S_ISREG(status.st_mode)) return "is a device";
  if (::access(path.c_str(), R_OK) != 0) return std::string("cannot be read: ") + std::strerror(errno);
  return "";
}

void refuse_other_than_plain(const std::string& path, OrFolder folder) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0 || S_ISREG(status.st_mode)) return;
  if (folder == OrFolder::yes && S_ISDIR(status.st_mode)) return;
  throw Error(Fault::input, path + ": " + why_no_plain_file(path) + "; give the path of a plain file");
}

}  // namespace raycube::base
