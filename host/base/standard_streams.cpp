#include "host/base/standard_streams.h"

#include <cerrno>

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

namespace raycube::base {

void claim_standard_descriptors() noexcept {
  for (int number = STDIN_FILENO; number <= STDERR_FILENO; ++number) {
    if (::fcntl(number, F_GETFD) != -1 || errno != EBADF) continue;
    // The lowest free number is this one: those below are open by now. Opened the wrong way round, as libc
    // does for programs that run with rights of their own: a result that goes to a closed stdout is an error,
    // as before.
    const int mode = number == STDIN_FILENO ? O_WRONLY : O_RDONLY;
    int opened = ::open("/dev/null", mode);
    if (opened < 0) opened = ::open("/", O_RDONLY | O_DIRECTORY);  // a root without /dev
    if (opened >= 0 && opened != number) {
      ::dup2(opened, number);
      ::close(opened);
    }
  }
}

bool stdout_reader_is_gone() noexcept {
  pollfd out{STDOUT_FILENO, POLLOUT, 0};
  return ::poll(&out, 1, 0) == 1 && (out.revents & POLLERR) != 0;
}

}  // namespace raycube::base
