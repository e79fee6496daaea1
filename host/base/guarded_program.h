// Programs that this one starts and waits for, which end when it does, however that ends.
#pragma once

#include <string>
#include <vector>

namespace raycube::base {

struct Started {
  std::vector<std::string> words;  ///< the program, a path or a name that PATH holds, and its arguments
  std::string folder;              ///< where it works; empty: here
  std::string out, err;            ///< files that its stdout and stderr are appended to; empty: ours
  bool reads_nothing = false;      ///< its stdin is empty, not ours
};

/// How it ended, as waitpid() says it; kNotStarted as exit status: there is no such program or folder.
inline constexpr int kNotStarted = 127;  ///< as shells say it

/// Runs a program to its end, in a process group of its own, under a guard: a process that waits for it and for us. A
/// signal to us is handed on to the whole group as SIGTERM; what is left of the group when the program has ended of it,
/// or when we are gone, by a second signal or by kill -9, is told to end and, after a few seconds, killed. Ctrl-Z halts
/// the group with us. A program that ends by itself may leave others behind, and one that left the group is nobody's.
/// Throws Error(environment) where no process could be made; does not throw after a signal, but returns when the
/// program, and what is left of its group, has ended.
int run_guarded(const Started& started);

}  // namespace raycube::base
