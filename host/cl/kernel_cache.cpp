#include "host/cl/kernel_cache.h"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <optional>
#include <set>
#include <stdexcept>
#include <vector>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include "host/base/cache_folder.h"
#include "host/base/data_folder.h"
#include "host/base/error.h"
#include "host/base/interrupt.h"
#include "host/base/memory.h"
#include "host/base/output_file.h"
#include "host/base/own_file.h"
#include "host/base/sha256.h"
#include "host/cl/kernel_archive.h"

namespace raycube::cl {
namespace {

namespace fs = std::filesystem;
using base::Level;

constexpr std::uint64_t kRoom_bytes =
    16u << 20;  ///< a program with its kernels and the compiler's temporaries takes 1 to 4 MB
constexpr std::uint64_t kMost_bytes = 256u << 20;  ///< of all that is kept; the longest unused goes first
constexpr auto kMostAge = std::chrono::hours(24 * 90);
constexpr const char* kSuffix = ".kernels";
constexpr const char* kDriverCode = "program.bc";     ///< PoCL's intermediate code, in its folder of a program
constexpr const char* kKeptCode = "raycube-code.bc";  ///< what a program was built of, beside it
constexpr const char* kRunPrefix = "run-";
constexpr const char* kPrivatePrefix = "raycube-kernels-";

/// The cache of this process. It is never destroyed: threads of drivers outlive static objects.
struct Cache {
  std::once_flag prepared;
  fs::path store;                                ///< what is kept; empty: nothing
  fs::path installed;                            ///< what came with the program; empty: nothing
  fs::path driver;                               ///< POCL_CACHE_DIR
  std::optional<base::TemporaryPath> temporary;  ///< the same, where it is ours
  bool ours = false;
  pid_t process = 0;  ///< whose folder it is: a child that ends takes nothing away
  std::function<void(Level, const std::string&)> notices;
  std::mutex building;
  std::map<std::string, std::set<std::string>> folders;  ///< by key: the driver's, relative
  std::set<std::string> not_kept;                        ///< reasons that were said
  std::set<std::string> useless;  ///< keys of archives that are whole and could not be put for the driver
};
Cache& cache() {
  static auto& one = *new Cache;
  return one;
}

std::atomic<int> at_work{0};

void notice(Level level, const std::string& text) {
  if (cache().notices) return cache().notices(level, text);
  if (level <= Level::warning) std::cerr << "raycube: warning: " << text << std::endl;
}

std::string reason(int code) { return std::strerror(code); }

std::string way_out() {
  return std::string("free some space, or name another folder by ") +
         (cache().ours ? "XDG_CACHE_HOME" : "POCL_CACHE_DIR");
}

extern "C" void raycube_at_exit() {
  if (at_work.load() > 0)
    base::leave_at_once(
        "the OpenCL driver's compiler ended the program, most likely since the disk of its kernels is full "
        "or a file may not grow "
        "further; what it said stands above. Free some space, or name another folder: XDG_CACHE_HOME, or "
        "POCL_CACHE_DIR where it is set",
        base::Fault::environment);
  std::error_code ignored;
  if (cache().ours && cache().process == ::getpid()) fs::remove_all(cache().driver, ignored);
}

/// Why the folder for what is kept cannot be used; empty: it can. It is made, private, where it is missing.
std::string claim(const fs::path& store) {
  std::error_code code;
  fs::create_directories(store.parent_path(), code);
  if (::mkdir(store.c_str(), 0700) != 0 && errno != EEXIST)
    return store.string() + " cannot be made (" + reason(errno) + ")";
  const int folder = ::open(store.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
  if (folder < 0) return store.string() + " is no folder of its own (" + reason(errno) + ")";
  struct stat status {};
  std::string why;
  if (::fstat(folder, &status) != 0) {
    why = store.string() + " cannot be looked at (" + reason(errno) + ")";
  } else if (status.st_uid != ::geteuid()) {
    why = store.string() + " belongs to user " + std::to_string(status.st_uid) + ", not to this one";
  } else if ((status.st_mode & 077) != 0) {
    const bool written = (status.st_mode & 022) != 0;
    if (::fchmod(folder, 0700) != 0) why = store.string() + " cannot be closed to others (" + reason(errno) + ")";
    if (written && why.empty()) {
      for (const auto& entry : fs::directory_iterator(store, code)) fs::remove_all(entry.path(), code);
      notice(Level::warning, "kernels kept in " + store.string() +
                                 ": the folder was open for others to write; it was emptied and closed to them");
    }
  }
  ::close(folder);
  return why;
}

/// A new folder PARENT/PREFIXxxxxxx that only this user may enter, locked to the end of the process; empty
/// with errno where there is none.
fs::path own_folder(const fs::path& parent, const char* prefix) {
  std::string pattern = (parent / (std::string(prefix) + "XXXXXX")).string();
  if (!::mkdtemp(pattern.data())) return {};
  const int lock = ::open(pattern.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);  // stays open
  if (lock >= 0) ::flock(lock, LOCK_EX | LOCK_NB);
  return pattern;
}

/// Removes what runs that were killed left: folders of this user's that nobody holds a lock on. A new one is
/// not locked at once.
void sweep_runs(const fs::path& parent, const char* prefix) {
  std::error_code code;
  for (const auto& entry : fs::directory_iterator(parent, code)) {
    struct stat status {};
    if (entry.path().filename().string().rfind(prefix, 0) != 0 || ::lstat(entry.path().c_str(), &status) != 0) continue;
    if (!S_ISDIR(status.st_mode) || status.st_uid != ::geteuid()) continue;
    if (fs::file_time_type::clock::now() - entry.last_write_time(code) < std::chrono::seconds(10)) continue;
    const int lock = ::open(entry.path().c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
    if (lock < 0) continue;
    if (::flock(lock, LOCK_EX | LOCK_NB) == 0) fs::remove_all(entry.path(), code);
    ::close(lock);
  }
}

/// Removes what nobody used for long, and the longest unused where all is too much.
void sweep_store(const fs::path& store) {
  struct Kept {
    fs::file_time_type used;
    std::uint64_t bytes;
    fs::path path;
  };
  std::vector<Kept> all;
  std::error_code code;
  const auto now = fs::file_time_type::clock::now();
  for (const auto& entry : fs::directory_iterator(store, code))
    if (entry.path().extension() == kSuffix)
      all.push_back({entry.last_write_time(code), entry.file_size(code), entry.path()});
  std::sort(all.begin(), all.end(), [](const Kept& a, const Kept& b) { return a.used > b.used; });
  std::uint64_t bytes = 0;
  for (const Kept& kept : all) {
    bytes += kept.bytes;
    if (bytes > kMost_bytes || now - kept.used > kMostAge) fs::remove(kept.path, code);
  }
}

void prepare(Cache& c) {
  std::atexit(raycube_at_exit);
  if (const char* users = std::getenv("POCL_CACHE_DIR"); users && *users) {
    c.driver = users;
    return;
  }
  try {
    c.installed = base::data_folder() / "kernels";
  } catch (const base::Error&) {  // a program without data, as tests are; who needs others of them says so
  }
  c.store = base::cache_folder("kernels");
  std::string why = c.store.empty() ? "neither XDG_CACHE_HOME nor HOME is set" : claim(c.store);
  if (why.empty()) {
    sweep_runs(c.store, kRunPrefix);
    sweep_store(c.store);
    c.driver = own_folder(c.store, kRunPrefix);
    if (c.driver.empty()) why = c.store.string() + " cannot be written (" + reason(errno) + ")";
  }
  if (!why.empty()) {
    c.store.clear();
    std::error_code code;
    const fs::path temporary = fs::temp_directory_path(code);
    if (!temporary.empty()) sweep_runs(temporary, kPrivatePrefix);
    if (!temporary.empty()) c.driver = own_folder(temporary, kPrivatePrefix);
    if (c.driver.empty())
      throw base::Error(base::Fault::environment, "no place for compiled kernels: " + why +
                                                      ", and the temporary folder " + temporary.string() +
                                                      " cannot be written (" + (code ? code.message() : reason(errno)) +
                                                      "); XDG_CACHE_HOME or TMPDIR names another folder");
    notice(Level::warning,
           "compiled kernels are not kept for the next run: " + why + "; XDG_CACHE_HOME names another folder for them");
  }
  c.ours = true;
  c.process = ::getpid();
  c.temporary.emplace(c.driver.string(), base::TemporaryPath::Kind::folder);
  ::setenv("POCL_CACHE_DIR", c.driver.c_str(), 1);
}

/// The driver's folders of programs, relative: two letters, then the rest of its name for the program (PoCL).
std::set<std::string> driver_folders(const fs::path& driver) {
  std::set<std::string> out;
  std::error_code code;
  for (const auto& first : fs::directory_iterator(driver, code)) {
    if (!first.is_directory(code)) continue;
    for (const auto& second : fs::directory_iterator(first.path(), code))
      if (second.is_directory(code)) out.insert((first.path().filename() / second.path().filename()).string());
  }
  return out;
}

/// What lies in the folders; of PoCL's notes on use nothing.
KernelFiles read_folders(const fs::path& driver, const std::set<std::string>& folders) {
  KernelFiles files;
  for (const auto& folder : folders)
    for (const auto& entry : fs::recursive_directory_iterator(driver / folder)) {
      if (!entry.is_regular_file() || entry.path().filename() == "last_accessed") continue;
      std::ifstream in(entry.path(), std::ios::binary);
      std::string content{std::istreambuf_iterator<char>(in), {}};
      if (in) files[fs::relative(entry.path(), driver).string()] = std::move(content);
    }
  return files;
}

void write_files(const fs::path& driver, const KernelFiles& files) {
  for (const auto& [name, content] : files) {
    fs::create_directories((driver / name).parent_path());
    std::ofstream out(driver / name, std::ios::binary);
    out.write(content.data(), static_cast<std::streamsize>(content.size()));
    if (!out.flush()) throw std::runtime_error((driver / name).string() + " could not be written");
  }
}

std::string content_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// The driver's folder that a kept file belongs to.
std::string folder_of(const fs::path& name) { return (*name.begin() / *std::next(name.begin())).string(); }

/// Writes the files of the sound archive `file` where the driver looks. When that fails nothing of them stays
/// there, the archive stays, and a full disk is the error; for any other reason false, with a warning that says what is
/// done instead.
bool put_for_driver(const KernelFiles& files, const std::string& file, const std::string& instead) {
  const fs::path& driver = cache().driver;
  const auto before = driver_folders(driver);
  try {
    write_files(driver, files);
    return true;
  } catch (const std::exception& failed) {
    std::error_code code;
    for (const auto& [name, content] : files)
      if (!before.count(folder_of(name))) fs::remove_all(driver / folder_of(name), code);
    blame_full_disk();
    notice(Level::warning,
           "kernels kept in " + file + " cannot be used by this run: " + failed.what() + "; " + instead);
    return false;
  }
}

/// The archive of `key` in `folder`, or nothing where there is no such folder.
fs::path file_of(const fs::path& folder, const std::string& key) {
  return folder.empty() ? fs::path() : folder / (key + kSuffix);
}

bool lies_there(const fs::path& file) {
  std::error_code ignored;
  return !file.empty() && fs::exists(fs::symlink_status(file, ignored));
}

KernelFiles read_archive(const std::string& key, const fs::path& file, bool installed) {
  return unpack_kernels(key, installed ? base::read_installed_file(file) : base::read_own_file(file));
}

}  // namespace

void set_cache_notices(std::function<void(Level, const std::string&)> notices) { cache().notices = std::move(notices); }

void prepare_kernel_cache() {
  std::call_once(cache().prepared, [] { prepare(cache()); });
}

void require_room_for_kernels() {
  const fs::path& folder = cache().driver;
  struct statvfs disk {};
  if (::statvfs(folder.c_str(), &disk) != 0) return;
  const std::uint64_t free_bytes = std::uint64_t{disk.f_bavail} * disk.f_frsize;
  if (free_bytes >= kRoom_bytes) return;
  throw base::Error(base::Fault::environment,
                    folder.string() + ": no room for compiled kernels (free: " + base::format_bytes(free_bytes) +
                        ", wanted: " + base::format_bytes(kRoom_bytes) + "); " + way_out());
}

void blame_full_disk() {
  const fs::path& folder = cache().driver;
  std::string pattern = (folder / "probe_XXXXXX").string();
  const int file = ::mkostemp(pattern.data(), O_CLOEXEC);
  int code = file < 0 ? errno : 0;
  if (file >= 0) {
    const std::string piece(std::size_t{256} << 10, 'x');
    for (std::size_t done = 0; done < piece.size() && code == 0;) {
      const ssize_t written = ::write(file, piece.data() + done, piece.size() - done);
      if (written <= 0) code = written < 0 ? errno : ENOSPC;
      if (written > 0) done += static_cast<std::size_t>(written);
    }
    ::close(file);
    ::unlink(pattern.c_str());
  }
  if (code == 0) return;
  throw base::Error(base::Fault::environment,
                    folder.string() + ": compiled kernels cannot be written (" + reason(code) + "); " + way_out());
}

DriverWork::DriverWork() noexcept { ++at_work; }
DriverWork::~DriverWork() { --at_work; }

KeptKernels::KeptKernels(std::string_view key) : key_(base::sha256_hex(key)), building_(cache().building) {
  Cache& c = cache();
  if (!c.ours) return;
  found_ = c.folders.count(key_) > 0 || take(file_of(c.store, key_), false) || take(file_of(c.installed, key_), true);
  if (found_ && c.folders[key_].size() == 1) code_ = content_of(c.driver / *c.folders[key_].begin() / kKeptCode);
  before_ = driver_folders(c.driver);
}

bool KeptKernels::take(const std::string& file, bool installed) const {
  if (!lies_there(file)) return false;
  const std::string instead = !installed && lies_there(file_of(cache().installed, key_))
                                  ? "those that came with the program are taken"
                                  : "they are compiled anew";
  std::error_code code;
  KernelFiles files;
  try {
    files = read_archive(key_, file, installed);
  } catch (const std::exception& damaged) {
    if (!installed) fs::remove(file, code);
    notice(Level::warning, "kernels kept in " + file + " are damaged: " + damaged.what() + "; " + instead);
    return false;
  }
  if (!put_for_driver(files, file, instead)) {
    cache().useless.insert(key_);
    return false;
  }
  for (const auto& [name, content] : files) cache().folders[key_].insert(folder_of(name));
  if (!installed) fs::last_write_time(file, fs::file_time_type::clock::now(), code);
  notice(Level::detail, "kernels: compiled ones from " + file);
  return true;
}

std::set<std::string> KeptKernels::new_folders() const {
  auto folders = driver_folders(cache().driver);
  std::erase_if(folders, [&](const auto& folder) { return before_.count(folder) > 0; });
  return folders;
}

bool KeptKernels::can_take_code() const { return cache().ours; }

void KeptKernels::take_code() {
  const fs::path& driver = cache().driver;
  const auto folders = new_folders();
  if (folders.size() == 1) code_ = content_of(driver / *folders.begin() / kDriverCode);
  std::error_code ignored;
  for (const auto& folder : folders) fs::remove_all(driver / folder, ignored);
}

void KeptKernels::built(bool of_code) {
  Cache& c = cache();
  if (c.ours) {
    auto folders = new_folders();
    if (of_code && folders.size() == 1)
      std::ofstream(c.driver / *folders.begin() / kKeptCode, std::ios::binary) << code_;
    // New ones replace what was kept: the driver did not find its own there (another version, another
    // processor).
    if (!folders.empty()) c.folders[key_] = std::move(folders);
  }
  building_.unlock();
}

KeptKernels::~KeptKernels() {
  try {
    keep();
  } catch (const std::exception& failed) {  // keep() holds no lock any more
    const std::lock_guard lock(cache().building);
    if (cache().not_kept.insert(failed.what()).second)
      notice(Level::warning, std::string("compiled kernels could not be kept for the next run: ") + failed.what());
  }
}

void KeptKernels::keep() const {
  Cache& c = cache();
  if (!c.ours || c.store.empty() || building_.owns_lock()) return;
  const std::lock_guard lock(c.building);
  const auto folders = c.folders.find(key_);
  if (folders == c.folders.end()) return;
  KernelFiles files = read_folders(c.driver, folders->second);
  const fs::path file = file_of(c.store, key_), came = file_of(c.installed, key_);
  const bool own = lies_there(file);
  // What could not be used is not carried along: the next run would meet it again.
  if ((own || lies_there(came)) && !c.useless.count(key_)) try {
      const KernelFiles kept = read_archive(key_, own ? file : came, !own);
      // Of other work-group sizes, by another run; not of a driver that does not look there any more.
      for (const auto& entry : kept)
        if (folders->second.count(folder_of(entry.first))) files.insert(entry);
      // A run beside this one compiled the same program: its code names another file, so its folder has another name.
      if (files == kept || (!found_ && kept.size() >= files.size())) return;
    } catch (const std::exception&) {  // written anew
    }
  base::OutputFile out(file.string(), base::IfExists::replace);
  ::chmod(out.temporary_path().c_str(), 0600);
  out.append(pack_kernels(key_, files));
  out.publish();
}

}  // namespace raycube::cl
