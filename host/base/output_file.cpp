#include "host/base/output_file.h"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <mutex>
#include <optional>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include "host/base/error.h"
#include "host/base/interrupt.h"
#include "host/base/memory.h"
#include "host/base/publication.h"

namespace raycube::base {
namespace fs = std::filesystem;
namespace {

Error failed(const std::string& path, const std::string& what, int code) {
  std::string way_out;
  if (code == ENOSPC || code == EDQUOT) way_out = "; free some space or choose another place with -o";
  if (code == EACCES || code == EROFS || code == EPERM) way_out = "; choose a folder you may write to with -o";
  if (code == ENOTDIR || code == EEXIST) way_out = "; a file stands where a folder is wanted, choose another -o";
  if (code == EFBIG) way_out = "; the file-size limit (ulimit -f) or the file system is too small";
  return Error(Fault::environment, path + ": " + what + ": " + std::strerror(code) + way_out);
}

Error exists(const std::string& path) {
  return Error(Fault::input, path + ": is there already; give --overwrite to replace it, or another -o");
}

/// Written by one call. Where a call brings 4 MiB or more the kernel gathers huge pages for its cache, and 94 MB took
/// 0.23 to 0.33 s for 0.02 s (Linux 6, ext4).
constexpr std::size_t kWrite_bytes = 1u << 20;

constexpr std::string_view kMark = ".raycube-";

bool present(const std::string& path) {
  struct stat status {};
  return ::lstat(path.c_str(), &status) == 0;
}

/// Place of the six characters that mkostemp() put at the end of `.NAME.raycube-XXXXXX`; npos: no such name.
std::size_t mark_of(const std::string& name) {
  const std::size_t at = name.rfind(kMark);
  const auto drawn = [&](std::size_t i) { return std::isalnum(static_cast<unsigned char>(name[i])) != 0; };
  if (name.empty() || name[0] != '.' || at == std::string::npos || at < 2 || name.size() < at + kMark.size() + 6)
    return std::string::npos;
  for (std::size_t i = at + kMark.size(); i < at + kMark.size() + 6; ++i)
    if (!drawn(i)) return std::string::npos;
  const std::size_t end = at + kMark.size() + 6;
  return name.size() == end || name[end] == '.' ? at + kMark.size() : std::string::npos;
}

/// This user's temporaries, of whatever final name, whose writer is gone: nobody holds their lock. Another
/// user's may wait for their names. What was drawn beside a temporary (its name and an ending) lives as long
/// as that one.
void remove_stale(const fs::path& folder) {
  std::vector<fs::path> beside;
  std::error_code code;
  for (const auto& entry : fs::directory_iterator(folder, code)) {
    const std::string name = entry.path().filename().string();
    const std::size_t mark = mark_of(name);
    if (mark == std::string::npos) continue;
    if (name.size() > mark + 6) {
      beside.push_back(entry.path());
      continue;
    }
    const int fd = ::open(entry.path().c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
    if (fd < 0) continue;
    struct stat status {};
    const bool own = ::fstat(fd, &status) == 0 && status.st_uid == ::geteuid();
    if (own && ::flock(fd, LOCK_EX | LOCK_NB) == 0) ::unlink(entry.path().c_str());
    ::close(fd);
  }
  for (const fs::path& path : beside) {
    const std::string name = path.filename().string();
    if (!present((folder / name.substr(0, mark_of(name) + 6)).string())) ::unlink(path.c_str());
  }
}

}  // namespace

void sync_folder(const std::string& folder) {
  const int fd = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return;
  ::fsync(fd);  // some file systems refuse it for folders: the rename itself has succeeded
  ::close(fd);
}

MadeFolders::MadeFolders(const std::string& folder) {
  std::error_code code;
  for (fs::path at = fs::path(folder); !at.empty() && !fs::exists(at, code); at = at.parent_path())
    if (at.has_filename()) paths_.insert(paths_.begin(), at.string());
  fs::create_directories(folder, code);
  if (code) throw failed(folder, "the folder cannot be made", code.value());
  if (!fs::is_directory(folder, code)) throw failed(folder, "is not a folder", ENOTDIR);
  for (const std::string& path : paths_)
    guards_.push_back(std::make_unique<TemporaryPath>(path, TemporaryPath::Kind::empty_folder));
}

MadeFolders::~MadeFolders() {
  guards_.clear();
  for (auto path = paths_.rbegin(); path != paths_.rend(); ++path) ::rmdir(path->c_str());
}

struct OutputFile::State {
  std::string final_path, temporary_path;
  fs::path folder;
  std::optional<MadeFolders> made;
  IfExists if_exists = IfExists::refuse;
  int fd = -1;
  std::uint64_t appended = 0;
  std::atomic<std::uint64_t> end{0};
  std::uint64_t reserved = 0;
  bool synced = false, published = false;
  std::optional<TemporaryPath> guard;
  std::mutex hashing;
  std::optional<BlockHashes> hashes;

  void read_at(std::uint64_t offset, void* data, std::size_t bytes) const {
    auto* next = static_cast<char*>(data);
    while (bytes > 0) {
      const ssize_t got = ::pread(fd, next, std::min<std::size_t>(bytes, 1u << 30), static_cast<off_t>(offset));
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) throw failed(final_path, "reading back failed", got < 0 ? errno : ENODATA);
      next += got, offset += static_cast<std::uint64_t>(got), bytes -= static_cast<std::size_t>(got);
    }
  }

  ~State() {
    if (!published && !temporary_path.empty()) ::unlink(temporary_path.c_str());
    if (fd >= 0) ::close(fd);
  }
};

OutputFile::OutputFile(const std::string& final_path, IfExists if_exists) : state_(std::make_unique<State>()) {
  State& s = *state_;
  s.final_path = final_path;
  s.if_exists = if_exists;
  const fs::path path(final_path);
  const std::string name = path.filename().string();
  if (name.empty() || name == "." || name == "..") throw Error(Fault::input, final_path + ": is not a file name");
  s.folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  s.made.emplace(s.folder.string());
  finish_publication(s.folder.string(), FolderUse::write_file);
  if (present(final_path)) {
    std::error_code code;
    if (fs::is_directory(final_path, code)) throw Error(Fault::input, final_path + ": is a folder; name a file");
    if (if_exists == IfExists::refuse) throw exists(final_path);
  }
  const std::string prefix = "." + name + std::string(kMark);
  remove_stale(s.folder);
  struct stat status {};
  do {  // again when another run took the new file for a stale one before it was locked
    std::string pattern = (s.folder / (prefix + "XXXXXX")).string();
    if (s.fd >= 0) ::close(s.fd);
    s.fd = ::mkostemp(pattern.data(), O_CLOEXEC);
    if (s.fd < 0) throw failed(final_path, "cannot be written", errno);
    s.temporary_path = pattern;
    ::flock(s.fd, LOCK_EX);
    if (::fstat(s.fd, &status) != 0) throw failed(final_path, "cannot be written", errno);
  } while (status.st_nlink == 0);
  s.guard.emplace(s.temporary_path);
  const mode_t mask = ::umask(0);
  ::umask(mask);
  ::fchmod(s.fd, 0666 & ~mask);
}

OutputFile::~OutputFile() = default;
OutputFile::OutputFile(OutputFile&&) noexcept = default;

const std::string& OutputFile::final_path() const { return state_->final_path; }
const std::string& OutputFile::temporary_path() const { return state_->temporary_path; }
std::uint64_t OutputFile::size() const { return state_->end; }

void OutputFile::reserve(std::uint64_t bytes) {
  State& s = *state_;
  if (bytes == 0) return;
  // Asked first: a file system may hand out all it has before it finds that it is not enough, and whoever writes
  // meanwhile meets a full disk.
  struct statvfs disk {};
  const bool known = ::fstatvfs(s.fd, &disk) == 0;
  const std::uint64_t free_bytes = std::uint64_t{disk.f_bavail} * disk.f_frsize;
  const bool too_much = known && bytes > free_bytes;
  if (!too_much && ::fallocate(s.fd, FALLOC_FL_KEEP_SIZE, 0, static_cast<off_t>(bytes)) == 0) {
    s.reserved = bytes;
    return;
  }
  const int code = too_much ? ENOSPC : errno;
  if (code == EOPNOTSUPP || code == ENOSYS || code == EINTR) return;  // then a full disk is met while writing
  std::string what = "no room for " + format_bytes(bytes);
  if (known) what += " (free: " + format_bytes(free_bytes) + ")";
  throw failed(s.final_path, what, code);
}

void OutputFile::append(const void* data, std::size_t bytes) {
  write_at(state_->appended, data, bytes);
  state_->appended += bytes;
}

void OutputFile::hash_blocks() {
  if (size() > 0) throw Error(Fault::bug, final_path() + ": hashed from its middle");
  state_->hashes.emplace(final_path(), [s = state_.get()](std::uint64_t offset, void* data, std::size_t bytes) {
    s->read_at(offset, data, bytes);
  });
}

void OutputFile::expect_rewriting() {
  if (state_->hashes) state_->hashes->expect_rewriting();
}

FileHashes OutputFile::hashes() {
  if (!state_->hashes) throw Error(Fault::bug, final_path() + ": nobody asked for its hashes");
  return state_->hashes->finish(size());
}

void OutputFile::write_at(std::uint64_t offset, const void* data, std::size_t bytes) {
  State& s = *state_;
  if (s.published) throw Error(Fault::bug, s.final_path + ": written after it was published");
  std::unique_lock<std::mutex> one_at_a_time;
  if (s.hashes) {
    one_at_a_time = std::unique_lock(s.hashing);
    s.hashes->about_to_write(offset, data, bytes);
  }
  auto* next = static_cast<const char*>(data);
  const std::uint64_t stop = offset + bytes;
  while (bytes > 0) {
    const ssize_t written = ::pwrite(s.fd, next, std::min(bytes, kWrite_bytes), static_cast<off_t>(offset));
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) throw failed(s.final_path, "writing failed", written < 0 ? errno : ENOSPC);
    next += written, offset += static_cast<std::uint64_t>(written), bytes -= static_cast<std::size_t>(written);
  }
  s.synced = false;
  for (std::uint64_t end = s.end; end < stop && !s.end.compare_exchange_weak(end, stop);) {
  }
}

void OutputFile::read_at(std::uint64_t offset, void* data, std::size_t bytes) const {
  state_->read_at(offset, data, bytes);
}

void OutputFile::sync() {
  State& s = *state_;
  if (s.synced) return;
  if (s.reserved > s.end && ::ftruncate(s.fd, static_cast<off_t>(s.end.load())) != 0)
    throw failed(s.final_path, "giving back unused space failed", errno);
  if (::fsync(s.fd) != 0) throw failed(s.final_path, "flushing to the disk failed", errno);
  s.synced = true;
}

void OutputFile::publish() {
  State& s = *state_;
  if (s.published) return;
  sync();
  const char *from = s.temporary_path.c_str(), *to = s.final_path.c_str();
  if (s.if_exists == IfExists::replace) {
    if (::rename(from, to) != 0) throw failed(s.final_path, "cannot be named", errno);
  } else if (::renameat2(AT_FDCWD, from, AT_FDCWD, to, RENAME_NOREPLACE) != 0) {
    const int code = errno;
    if (code == EEXIST) throw exists(s.final_path);
    // File systems without RENAME_NOREPLACE: a hard link refuses an existing name just as well.
    if (code != EINVAL && code != ENOSYS) throw failed(s.final_path, "cannot be named", code);
    if (::link(from, to) != 0)
      throw errno == EEXIST ? exists(s.final_path) : failed(s.final_path, "cannot be named", errno);
    ::unlink(from);
  }
  s.published = true;
  s.guard.reset();
  sync_folder(s.folder);
}

void OutputFile::hand_over() {
  state_->published = true;
  state_->guard.reset();
}

OutputSet::OutputSet(const std::string& folder, IfExists if_exists)
    : folder_(folder), made_(folder), if_exists_(if_exists) {
  lock_ = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (lock_ < 0) throw failed(folder, "the folder cannot be opened", errno);
  // File systems without locks: the names themselves still refuse each other.
  if (::flock(lock_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    ::close(lock_);
    throw Error(Fault::environment,
                folder + ": another run is writing into this folder; wait for it, or choose another -o");
  }
  try {
    finish_publication(folder, FolderUse::write_set, /*locked=*/true);
  } catch (...) {
    ::close(lock_);
    throw;
  }
}

OutputSet::~OutputSet() {
  files_.clear();
  if (lock_ >= 0) ::close(lock_);
}

OutputFile& OutputSet::add(const std::string& name) {
  if (name != fs::path(name).filename()) throw Error(Fault::bug, "product name with a folder: " + name);
  files_.push_back(std::make_unique<OutputFile>((fs::path(folder_) / name).string(), if_exists_));
  if (hashed_) files_.back()->hash_blocks();
  return *files_.back();
}

std::vector<std::pair<std::string, FileHashes>> OutputSet::hashes() {
  std::vector<std::pair<std::string, FileHashes>> all;
  for (auto& file : files_) all.emplace_back(fs::path(file->final_path()).filename().string(), file->hashes());
  return all;
}

void OutputSet::publish() {
  throw_if_interrupted();
  if (files_.empty()) return;
  Publication::List list;
  list.replace = if_exists_ == IfExists::replace;
  list.remove = earlier_;
  for (auto& file : files_) {
    file->sync();
    list.files.emplace_back(fs::path(file->temporary_path()).filename().string(),
                            fs::path(file->final_path()).filename().string());
  }
  // First, so that a second Ctrl-C removes no file of a set that is published.
  for (auto& file : files_) file->hand_over();
  std::optional<Publication> publication;
  try {
    publication.emplace(folder_, std::move(list));
  } catch (...) {
    for (auto& file : files_) ::unlink(file->temporary_path().c_str());
    throw;
  }
  while (publication->step()) {
  }
  files_.clear();
}

void write_output_file(const std::string& final_path, std::string_view content, IfExists if_exists) {
  OutputFile file(final_path, if_exists);
  file.append(content);
  file.publish();
}

}  // namespace raycube::base
