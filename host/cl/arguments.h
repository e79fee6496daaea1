// A kernel's arguments as a struct made from its list (kernels/shared/arguments.h): every one is given by name, in the
// list's order, with exactly the type that the kernel declares. What is left out, out of order or of another type does
// not compile.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "host/cl/buffer.h"
#include "kernels/shared/structs.h"

namespace raycube::cl {

/// A number or vector of exactly type T: a float for a count, or a wider integer, is refused.
template <typename T>
struct Value {
  template <std::same_as<T> U>
  Value(U v) : value(v) {}
  T value;
};

/// A buffer of T that the kernel reads.
template <typename T>
struct Read {
  Read(const Buffer<T>& b) : buffer(&b) {}
  const RawBuffer* buffer;
};

/// A buffer of T that the kernel writes; a constant one is refused.
template <typename T>
struct Write {
  Write(Buffer<T>& b) : buffer(&b) {}
  const RawBuffer* buffer;
};

/// An array of the scene, as kernels/geometry/scene_arrays.h has it: one buffer, or pages of 2^shift elements.
template <typename T>
struct PagedBuffer {
  std::vector<Buffer<T>> pages;  ///< in order, at least one
  bool paged = false;            ///< kernels are built for RC_MOST_PAGES pages and the shift
  std::uint32_t shift = 0;

  std::size_t size() const { return pages.size(); }
  const Buffer<T>& operator[](std::size_t page) const { return pages[page]; }
  /// How many arguments it is.
  std::size_t places() const { return paged ? RC_MOST_PAGES + 1 : 1; }
};

/// An array of the scene in a list of arguments.
template <typename T>
struct Pages {
  Pages(const PagedBuffer<T>& a) : array(&a) {}
  const PagedBuffer<T>* array;
};

}  // namespace raycube::cl

#define RC_VALUE_MEMBER(type, name) ::raycube::cl::Value<::raycube::shared::type> name;
#define RC_READ_MEMBER(type, name) ::raycube::cl::Read<::raycube::shared::type> name;
#define RC_WRITE_MEMBER(type, name) ::raycube::cl::Write<::raycube::shared::type> name;
#define RC_SCENE_MEMBER(type, name, array) ::raycube::cl::Pages<::raycube::shared::type> name;
#define RC_VISIT_MEMBER(type, name) action(name);
#define RC_VISIT_SCENE(type, name, array) action(name);
#define RC_NOTHING()

/// Struct `Name` of the arguments of kernel `kernel_name`, in the order of LIST.
#define RC_ARGUMENT_STRUCT(Name, kernel_name, LIST)                                       \
  struct Name {                                                                           \
    static constexpr const char* kKernel = kernel_name;                                   \
    LIST(RC_VALUE_MEMBER, RC_READ_MEMBER, RC_WRITE_MEMBER, RC_SCENE_MEMBER, RC_NOTHING)   \
    template <typename Action>                                                            \
    void for_each(Action&& action) const {                                                \
      LIST(RC_VISIT_MEMBER, RC_VISIT_MEMBER, RC_VISIT_MEMBER, RC_VISIT_SCENE, RC_NOTHING) \
    }                                                                                     \
  };
