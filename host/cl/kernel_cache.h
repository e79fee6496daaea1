// Kernels that the driver compiled, kept from run to run: $XDG_CACHE_HOME/raycube/kernels
// (base::cache_folder), one checked file a program. PoCL keeps kernels by itself, but trusts what lies there:
// a file cut short ends the process by SIGBUS, and where there is no HOME it loads code from a folder of a
// known name under /tmp. So each process gives PoCL a folder of its own (POCL_CACHE_DIR, mode 0700, removed
// at the end), puts verified files there before a program is built, and keeps what PoCL added when the
// program goes. A POCL_CACHE_DIR that the user set is the user's: it is taken as it is, and nothing is kept
// here. Kernels that were compiled with the program (cmake/CompileKernels.cmake) lie in its data folder,
// kernels/, in the same form; they are taken where the user's folder has none, and never changed.
#pragma once

#include <functional>
#include <mutex>
#include <set>
#include <string>
#include <string_view>

#include "host/base/log.h"

namespace raycube::cl {

/// Where notices of the cache go (base::Level::warning, detail); before it is called warnings go to stderr.
void set_cache_notices(std::function<void(base::Level, const std::string&)> notices);

/// Before the first OpenCL call of the process: names the driver's folder and takes what runs that were
/// killed left there. Without a home, or where that may not be written or is not the user's own, the folder
/// is a private one under the temporary folder, with a warning, and nothing is kept. Throws
/// Error(environment) when there is no place at all.
void prepare_kernel_cache();

/// Throws Error(environment) when the driver's folder has no room for what a build writes.
void require_room_for_kernels();

/// When a build or launch failed: throws Error(environment) when the driver's folder cannot take a file of
/// 256 KiB, which is why then.
void blame_full_disk();

/// While one lives, the driver is at work, compiling perhaps. LLVM ends the process by exit(1) when its disk
/// is full: such an exit becomes one error with the status of the environment.
class DriverWork {
 public:
  DriverWork() noexcept;
  ~DriverWork();
  DriverWork(const DriverWork&) = delete;
  DriverWork& operator=(const DriverWork&) = delete;
};

/// One program's files in the cache, from before it is built until it goes.
class KeptKernels {
 public:
  /// Puts what was kept under `key` (all that the compiled code depends on) where the driver looks, if every
  /// byte of it is whole; removes it, with a warning, if not. Where nothing was kept, it does so with what came with
  /// the program. Other programs wait with their builds until built() or the end of this one. Throws
  /// Error(environment) where the disk is too full for it.
  explicit KeptKernels(std::string_view key);
  /// Whether what was kept has been put where the driver looks: nothing of it has to be compiled.
  bool found() const { return found_; }
  /// The SHA-256 of the key, hexadecimal.
  const std::string& hash() const { return key_; }
  /// The driver's intermediate code of the program that was kept with its kernels: a program built of it needs no
  /// front end. Empty where there is none.
  const std::string& code() const { return code_; }
  /// Whether the driver's folder is ours, so that what its front end writes there can be taken. In a POCL_CACHE_DIR of
  /// the user's it would stay, and a later build from source would take it for a whole program.
  bool can_take_code() const;
  /// After the driver's front end compiled the source: takes the intermediate code that it wrote, if it wrote any.
  void take_code();
  /// The driver has made its folders for the program, `of_code` by a build of the intermediate code.
  void built(bool of_code);
  /// Keeps the program's files if the driver has added to what was kept or came with the program. Call it when no
  /// kernel of it is compiled any more.
  ~KeptKernels();
  KeptKernels(const KeptKernels&) = delete;
  KeptKernels& operator=(const KeptKernels&) = delete;

 private:
  bool take(const std::string& file, bool installed) const;
  void keep() const;
  std::set<std::string> new_folders() const;
  std::string key_;  ///< SHA-256, hexadecimal
  std::string code_;
  bool found_ = false;
  std::unique_lock<std::mutex> building_;
  std::set<std::string> before_;  ///< the driver's folders before the build
};

}  // namespace raycube::cl
