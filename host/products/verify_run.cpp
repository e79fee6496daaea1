#include "host/products/verify_run.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/base/block_hashes.h"
#include "host/base/input_file.h"
#include "host/base/error.h"
#include "host/base/interrupt.h"
#include "host/base/json_text.h"

namespace raycube::products {
namespace {

using base::Error;
using base::Fault;
using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

Error refusal(const std::string& path, const std::string& what) { return Error(Fault::input, path + ": " + what); }

/// More is held of no file at once. A run writes 4 MiB (base::kHashBlock_bytes).
constexpr std::uint64_t kMostBlock_bytes = 64u << 20;

/// Members of run.json that verification needs, and nothing that could lead out of its folder.
struct Recorded {
  std::uint64_t block_bytes = 0;
  std::vector<std::pair<std::string, base::FileHashes>> files;
};

Recorded recorded_in(const std::string& path) {
  base::refuse_other_than_plain(path);
  std::ifstream in(path);
  Recorded out;
  try {
    const Json record = Json::parse(base::shallow_json(in));
    if (!record.is_object() || record.value("format", "") != "raycube run")
      throw refusal(path, "is no run record of raycube; name a run's folder or its run.json");
    if (!record.contains("sha256"))
      throw refusal(path,
                    "has no member \"sha256\": it was written before raycube kept hashes of its files; render "
                    "again to have them");
    const Json& sha = record.at("sha256");
    out.block_bytes = sha.at("block_bytes");
    if (out.block_bytes == 0 || out.block_bytes > kMostBlock_bytes)
      throw refusal(path, fmt::format("is damaged: its block_bytes are not from 1 to {} (found {})", kMostBlock_bytes,
                                      out.block_bytes));
    for (const auto& [name, file] : sha.at("files").items()) {
      out.files.push_back({name, {file.at("bytes"), file.at("blocks"), file.at("list")}});
      const auto& hashes = out.files.back().second;
      if (name.empty() || name == ".." || name != fs::path(name).filename())
        throw refusal(path, fmt::format("names a file outside its folder: \"{}\"", name));
      const std::uint64_t blocks = hashes.bytes / out.block_bytes + (hashes.bytes % out.block_bytes != 0 ? 1 : 0);
      if (hashes.blocks.size() != blocks || base::hash_of_list(hashes.blocks) != hashes.list)
        throw refusal(
            path,
            fmt::format("its own list of blocks of {} is damaged: it does not have the hash that stands beside it",
                        name));
    }
  } catch (const Json::exception& failure) {
    throw refusal(path, fmt::format("cannot be read as a run record: {}; is the file whole?", failure.what()));
  }
  return out;
}

class Reader {
 public:
  explicit Reader(const std::string& path) : fd_(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)) {
    code_ = fd_ < 0 ? errno : 0;
  }
  ~Reader() {
    if (fd_ >= 0) ::close(fd_);
  }
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;

  /// Empty: it can be read. Else why not.
  std::string why_not() const {
    struct stat status {};
    if (fd_ < 0) return code_ == ENOENT ? "is missing" : std::string("cannot be opened: ") + std::strerror(code_);
    if (::fstat(fd_, &status) != 0 || !S_ISREG(status.st_mode)) return "is no plain file";
    return "";
  }
  std::uint64_t size() const {
    struct stat status {};
    return ::fstat(fd_, &status) == 0 ? static_cast<std::uint64_t>(status.st_size) : 0;
  }
  /// Bytes that could be read, at most as many as asked for.
  std::size_t read(std::uint64_t offset, unsigned char* data, std::size_t bytes) const {
    std::size_t all = 0;
    while (all < bytes) {
      const ssize_t got = ::pread(fd_, data + all, bytes - all, static_cast<off_t>(offset + all));
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) break;
      all += static_cast<std::size_t>(got);
    }
    return all;
  }

 private:
  int fd_, code_;
};

/// The first difference in words; empty: none.
std::string difference(const std::string& folder, const std::string& name, const base::FileHashes& wanted,
                       std::uint64_t block_bytes, const std::function<void(std::uint64_t)>& done) {
  const Reader file((fs::path(folder) / name).string());
  if (const std::string why = file.why_not(); !why.empty()) return fmt::format("{}: {}", name, why);
  // Of what is there, whatever the record says: what is missing cannot be read.
  std::vector<unsigned char> data(std::min(block_bytes, std::max<std::uint64_t>(1, file.size())));
  for (std::size_t i = 0; i < wanted.blocks.size(); ++i) {
    base::throw_if_interrupted();
    const std::uint64_t first = i * block_bytes, bytes = std::min(block_bytes, wanted.bytes - first);
    const std::string where =
        fmt::format("{}: block {} of {} (bytes {} to {})", name, i, wanted.blocks.size(), first, first + bytes - 1);
    const std::size_t got = file.read(first, data.data(), std::min<std::uint64_t>(bytes, data.size()));
    if (got < bytes)
      return fmt::format("{}: the file ends, or cannot be read, at byte {} of {}", where, first + got, wanted.bytes);
    if (base::Sha256().add(data.data(), bytes).hex() != wanted.blocks[i]) return where + ": not what was written";
    if (done) done(bytes);
  }
  if (file.size() != wanted.bytes)
    return fmt::format("{}: has {} bytes, {} were written", name, file.size(), wanted.bytes);
  return "";
}

}  // namespace

VerifiedRun verify_run(const std::string& record_path, const std::function<void(std::uint64_t)>& done) {
  const Recorded recorded = recorded_in(record_path);
  const std::string folder = fs::path(record_path).parent_path().string();
  VerifiedRun out;
  out.files = recorded.files.size();
  for (const auto& [name, hashes] : recorded.files) {
    const std::string found = difference(folder, name, hashes, recorded.block_bytes, done);
    if (found.empty())
      out.bytes += hashes.bytes;
    else
      out.differences.push_back(found);
  }
  return out;
}

}  // namespace raycube::products
