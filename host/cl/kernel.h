// A kernel with typed arguments.
#pragma once

#include <type_traits>
#include <vector>

#include "host/cl/arguments.h"
#include "host/cl/buffer.h"
#include "host/cl/program.h"
#include "kernels/shared/structs.h"

namespace raycube::cl {

class Kernel {
 public:
  Kernel(const Program& program, const std::string& name);
  const std::string& name() const { return name_; }
  cl_kernel operator()() const { return kernel_(); }
  /// Largest work-group the device takes of this kernel.
  std::size_t most_local() const { return most_local_; }

  /// Sets all arguments from the struct of the kernel's list (RC_ARGUMENT_STRUCT).
  template <typename List>
  requires requires { List::kKernel; }
  Kernel& arguments(const List& list) {
    check_name(List::kKernel);
    std::size_t count = 0;
    list.for_each([&](const auto& value) { count += places(value); });
    check_count(count);
    cl_uint index = 0;
    list.for_each([&](const auto& value) { set_next(index, value); });
    return *this;
  }
  /// Sets all arguments of a kernel without a list in order: buffers, 32-bit scalars, rc_float4, TileShape, and arrays
  /// in pages, which count as many arguments. The number is checked against the kernel's.
  template <typename... Arguments>
  Kernel& arguments(const Arguments&... values) {
    check_count((std::size_t{0} + ... + places(values)));
    cl_uint index = 0;
    (set_next(index, values), ...);
    return *this;
  }
  void set(cl_uint index, const RawBuffer& buffer);
  template <typename T>
  requires(std::is_same_v<T, cl_uint> || std::is_same_v<T, cl_int> || std::is_same_v<T, float> ||
           std::is_same_v<T, shared::rc_float4> ||
           std::is_same_v<T, shared::TileShape>) void set(cl_uint index, T value) {
    set_bytes(index, &value, sizeof value);
  }

 private:
  template <typename T>
  static std::size_t places(const T&) {
    return 1;
  }
  template <typename T>
  static std::size_t places(const PagedBuffer<T>& array) {
    return array.places();
  }
  template <typename T>
  static std::size_t places(const Pages<T>& array) {
    return array.array->places();
  }
  template <typename T>
  void set_next(cl_uint& index, const T& value) {
    set(index++, value);
  }
  template <typename T>
  void set_next(cl_uint& index, const Value<T>& value) {
    set(index++, value.value);
  }
  template <typename T>
  void set_next(cl_uint& index, const Read<T>& read) {
    set(index++, *read.buffer);
  }
  template <typename T>
  void set_next(cl_uint& index, const Write<T>& write) {
    set(index++, *write.buffer);
  }
  template <typename T>
  void set_next(cl_uint& index, const Pages<T>& array) {
    set_next(index, *array.array);
  }
  template <typename T>
  void set_next(cl_uint& index, const PagedBuffer<T>& array) {
    if (!array.paged) return set(index++, array[0]);
    for (std::size_t page = 0; page < RC_MOST_PAGES; ++page) set(index++, array[page < array.size() ? page : 0]);
    set(index++, cl_uint{array.shift});
  }
  void set_bytes(cl_uint index, const void* value, std::size_t bytes);
  void check_name(const std::string& of_list) const;
  void check_count(std::size_t given) const;
  std::string name_, device_name_;
  Handle<cl_kernel, clReleaseKernel> kernel_;
  std::size_t most_local_ = 1;
};

}  // namespace raycube::cl
