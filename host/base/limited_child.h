// Work that other people's code does on a user's file, in a child process that cannot hang, crash or use up
// the memory of this one.
#pragma once

#include <cstdint>
#include <cstring>
#include <functional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace raycube::base {

struct ChildLimits {
  double cpu_s = 60;                        ///< computing time
  double idle_s = 60;                       ///< without any computing at all: it waits for something that does not come
  std::uint64_t memory_bytes = 4ull << 30;  ///< of address space beyond what this process has now
};

/// In the child: what it hands back, in order.
class Parcel {
 public:
  /// most_bytes: more than that is std::bad_alloc.
  explicit Parcel(int fd, std::uint64_t most_bytes) : fd_(fd), most_bytes_(most_bytes) {}
  bool exceeded() const { return bytes_ > most_bytes_; }
  void bytes(const void* data, std::size_t count);
  template <class T>
  void value(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    bytes(&value, sizeof value);
  }
  template <class T>
  void list(const T* values, std::size_t count) {
    static_assert(std::is_trivially_copyable_v<T>);
    value(static_cast<std::uint64_t>(count));
    bytes(values, count * sizeof(T));
  }
  void text(std::string_view text) { list(text.data(), text.size()); }
  void flush();

 private:
  int fd_;
  std::uint64_t most_bytes_, bytes_ = 0;
  std::string waiting_;
};

enum class ChildEnd { done, out_of_time, out_of_memory, crashed };

/// In the parent: what came back, to be taken in the same order; nothing unless the child was done.
class Unpacked {
 public:
  Unpacked() = default;
  ~Unpacked();
  Unpacked(Unpacked&& other) noexcept;
  Unpacked& operator=(Unpacked&&) = delete;

  ChildEnd end = ChildEnd::done;
  std::string why;  ///< for people: "did not end in 60 s of computing", "was ended by signal 11"; empty when done

  template <class T>
  T value() {
    static_assert(std::is_trivially_copyable_v<T>);
    T out;
    std::memcpy(&out, take(sizeof out), sizeof out);
    return out;
  }
  template <class T>
  std::vector<T> list() {
    const auto count = value<std::uint64_t>();
    std::vector<T> out(count);
    if (count > 0) std::memcpy(out.data(), take(count * sizeof(T)), count * sizeof(T));
    return out;
  }
  std::string text() {
    const auto characters = list<char>();
    return {characters.begin(), characters.end()};
  }

 private:
  friend Unpacked in_limited_child(const ChildLimits&, const std::function<void(Parcel&)>&);
  const unsigned char* take(std::size_t bytes);

  const unsigned char* data_ = nullptr;
  std::size_t size_ = 0, next_ = 0;
};

/// Forks, runs `work` in the child and waits for its end; what `work` throws is bad_alloc (out_of_memory) or
/// a crash. Ctrl-C ends the child and throws. The child sees this process as it was and changes nothing of
/// it; it must not use OpenCL or other threads. What it hands back lies in memory beside what it uses: more than there
/// is (available_memory) is out_of_memory too. Throws Error(environment) when no child can be made.
Unpacked in_limited_child(const ChildLimits& limits, const std::function<void(Parcel&)>& work);

}  // namespace raycube::base
