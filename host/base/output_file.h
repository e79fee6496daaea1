// Files that appear under their final name only when they are whole. A run that ends early, by error or by signal, leaves
// nothing there; one that is killed leaves at most a hidden temporary, which the next run of the same output removes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace raycube::base {

enum class IfExists { refuse, replace };

/// One file under its temporary name `.NAME.raycube-XXXXXX` in the final folder, which is made when missing. Not copyable; the
/// destructor removes the temporary unless publish() has been called. Every failure is Error(environment) that names the
/// final path and the system's reason, except a file that is there already: Error(input).
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
  /// Writes at a byte offset. Thread-safe for disjoint ranges.
  void write_at(std::uint64_t offset, const void* data, std::size_t bytes);
  /// Reads back exactly `bytes` written before.
  void read_at(std::uint64_t offset, void* data, std::size_t bytes) const;
  /// Bytes from the start of the file to the furthest byte written.
  std::uint64_t size() const;

  /// Flushes to the device (fsync). Called by publish() when not called before.
  void sync();
  /// Gives the file its final name. When two runs raced, the second one gets an error (refuse) or wins (replace).
  void publish();
  /// After publish(): takes a file that was new under its name away again.
  void withdraw();

  const std::string& final_path() const;
  const std::string& temporary_path() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// The files of one product in one folder. None has its final name before all are whole; they then appear in the order they
/// were added, so add headers and the run record last. While it lives, a second run into the folder is refused.
class OutputSet {
 public:
  explicit OutputSet(const std::string& folder, IfExists if_exists = IfExists::refuse);
  ~OutputSet();
  OutputSet(const OutputSet&) = delete;
  OutputSet& operator=(const OutputSet&) = delete;

  /// Begins a file; name has no folder. The reference stays valid until publish().
  OutputFile& add(const std::string& name);
  const std::string& folder() const { return folder_; }
  /// Names (no folders) of the product that this one replaces: publish() removes those that are not among its own before it names the last file, so that
  /// nothing of another run stays beside it. Not done with IfExists::refuse.
  void replaces(std::vector<std::string> names) { earlier_ = std::move(names); }
  /// Syncs every file, then names them all. When one cannot be named, the ones named before are withdrawn.
  void publish();

 private:
  void remove_earlier() const;

  std::string folder_;
  IfExists if_exists_;
  int lock_ = -1;
  std::vector<std::unique_ptr<OutputFile>> files_;
  std::vector<std::string> earlier_;
};

/// Writes a whole small file that way.
void write_output_file(const std::string& final_path, std::string_view content, IfExists if_exists);

}  // namespace raycube::base
