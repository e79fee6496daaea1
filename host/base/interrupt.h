// Ctrl-C, SIGTERM and SIGHUP: the first one asks the program to stop at its next safe point, where
// destructors remove what was half written; the second one removes the registered temporaries and leaves at
// once. This is the only process-wide state of the program: a signal handler can reach nothing else.
#pragma once

#include <string>
#include <string_view>

#include "host/base/error.h"

namespace raycube::base {

/// Installs the handlers of SIGINT, SIGTERM and SIGHUP (not where the caller ignores SIGHUP, as nohup does),
/// gives std::terminate a message and exit status 70, and passes over SIGXFSZ and SIGPIPE, so that a
/// file-size limit and a reader that has gone are errors of write(): who reads the messages may leave and the
/// work goes on. A SIGCHLD that the caller ignored is heard again, else no child could be waited for.
void install_signal_handlers();

/// Removes the registered temporaries. Safe in a signal handler.
void remove_temporaries() noexcept;

/// Removes the registered temporaries, prints `message` and ends the process, running nothing else. Safe in a signal
/// handler.
[[noreturn]] void leave_at_once(std::string_view message, Fault fault) noexcept;

/// True once SIGINT, SIGTERM or SIGHUP has arrived.
bool interrupted() noexcept;

/// The same, after waiting a moment for one: Ctrl-C reaches a whole group of processes, and a driver's
/// compiler may have died of it, and its failure been seen here, before this process hears of it.
bool interrupted_by_now() noexcept;

/// What the error says once a signal has arrived.
std::string interrupt_text();

/// Throws Error(interrupted) once a signal has arrived. Call it between tiles, strips and nodes.
void throw_if_interrupted();

/// In a forked child that works for this process: signals end it as they end any program, the temporaries of
/// the parent are no concern of its, and leave_at_once() says nothing, since the parent says what became of
/// the child.
void become_helper() noexcept;

/// True in such a child.
bool is_helper() noexcept;

/// Forgets an interrupt (tests).
void clear_interrupt() noexcept;

/// While it lives, the second signal removes `path`: a file; a folder of ours alone with all that is in it; or a folder
/// if nothing is left in it. Up to 64 at a time; further ones are left to their owner's destructor.
class TemporaryPath {
 public:
  enum class Kind { file, folder, empty_folder };
  explicit TemporaryPath(const std::string& path, Kind kind = Kind::file) noexcept;
  ~TemporaryPath();
  TemporaryPath(const TemporaryPath&) = delete;
  TemporaryPath& operator=(const TemporaryPath&) = delete;

 private:
  int slot_ = -1;
};

}  // namespace raycube::base
