// Files that appear under their final name only when they are whole. A run that ends early, by error or by
// signal, leaves nothing there; one that is killed leaves at most hidden temporaries, which the next run that
// writes into the folder removes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "host/base/block_hashes.h"

namespace raycube::base {

enum class IfExists { refuse, replace };

/// Has a folder's renames reach the disk, where its file system can.
void sync_folder(const std::string& folder);

class TemporaryPath;

/// A folder for output, with its parents. Those that were not there go again, by a signal too, when nothing is in them.
class MadeFolders {
 public:
  explicit MadeFolders(const std::string& folder);
  ~MadeFolders();
  MadeFolders(const MadeFolders&) = delete;
  MadeFolders& operator=(const MadeFolders&) = delete;

 private:
  std::vector<std::string> paths_;  ///< outer ones first
  std::vector<std::unique_ptr<TemporaryPath>> guards_;
};

/// One file under its temporary name `.NAME.raycube-XXXXXX` in the final folder, which is made when missing. Not
/// copyable; the destructor removes the temporary unless publish() has been called. Every failure is Error(environment)
/// that names the final path and the system's reason, except a file that is there already: Error(input).
class OutputFile {
 public:
  /// Refuses at once when the final name exists (IfExists::refuse) or the folder cannot be written.
  explicit OutputFile(const std::string& final_path, IfExists if_exists = IfExists::refuse);
  ~OutputFile();
  OutputFile(OutputFile&&) noexcept;
  OutputFile& operator=(OutputFile&&) = delete;

  /// Claims `bytes` of disk now, so that a full disk is known before the work begins. Never shrinks the file.
  void reserve(std::uint64_t bytes);
  /// Writes at the end of what append() wrote before.
  void append(const void* data, std::size_t bytes);
  void append(std::string_view text) { append(text.data(), text.size()); }
  /// From here on keeps the hashes of all blocks written; to be called before the first byte.
  void hash_blocks();
  /// Its bytes are written again before it is whole: hashes are made of them in the end.
  void expect_rewriting();
  /// Of the whole file, as hash_blocks() wants; call it after the last byte.
  FileHashes hashes();
  /// Writes at a byte offset. Thread-safe for disjoint ranges; one after the other where blocks are hashed.
  void write_at(std::uint64_t offset, const void* data, std::size_t bytes);
  /// Reads back exactly `bytes` written before.
  void read_at(std::uint64_t offset, void* data, std::size_t bytes) const;
  /// Bytes from the start of the file to the furthest byte written.
  std::uint64_t size() const;

  /// Flushes to the device (fsync). Called by publish() when not called before.
  void sync();
  /// Gives the file its final name. When two runs raced, the second one gets an error (refuse) or wins (replace).
  void publish();
  /// The temporary, flushed, belongs to somebody else from now on, who names or removes it.
  void hand_over();

  const std::string& final_path() const;
  const std::string& temporary_path() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// The files of one product in one folder. None has its final name before all are whole; they then appear as
/// one (publication.h), the last one added last, so add the run record last. While it lives, a second run
/// into the folder is refused.
class OutputSet {
 public:
  explicit OutputSet(const std::string& folder, IfExists if_exists = IfExists::refuse);
  ~OutputSet();
  OutputSet(const OutputSet&) = delete;
  OutputSet& operator=(const OutputSet&) = delete;

  /// Begins a file; name has no folder. The reference stays valid until publish().
  OutputFile& add(const std::string& name);
  const std::string& folder() const { return folder_; }
  /// Files that are added from here on keep the hashes of their blocks.
  void hash_blocks() { hashed_ = true; }
  /// Name and hashes of each of these, in the order they were added.
  std::vector<std::pair<std::string, FileHashes>> hashes();
  /// Names (no folders) of the product that this one replaces: publish() removes those that are not among its own
  /// before it names the last file, so that nothing of another run stays beside it. Not done with IfExists::refuse.
  void replaces(std::vector<std::string> names) { earlier_ = std::move(names); }
  /// Syncs every file, then names them all: whenever the program is killed, all of them or none. When one
  /// cannot be named because a file has taken its name, none is.
  void publish();

 private:
  std::string folder_;
  MadeFolders made_;
  IfExists if_exists_;
  int lock_ = -1;
  bool hashed_ = false;
  std::vector<std::unique_ptr<OutputFile>> files_;
  std::vector<std::string> earlier_;
};

/// Writes a whole small file that way.
void write_output_file(const std::string& final_path, std::string_view content, IfExists if_exists);

}  // namespace raycube::base
