// Values of a raster's band in as few bytes as its file's numbers have: a picture of eight bits takes one byte a texel
// until something is made of it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <utility>
#include <vector>

namespace raycube::scene {

enum class NumberType : unsigned char { u8, i8, u16, i16, u32, i32, f32, f64 };
std::size_t type_bytes(NumberType type);

/// Numbers as the bytes of a type.
struct PackedNumbers {
  NumberType type = NumberType::f64;
  std::vector<unsigned char> bytes;
};
/// In the type that is wanted where that holds every one of them, bit for bit (of what is no number: that it is none),
/// else as double: virtual rasters hand on numbers that the type they declare does not hold.
PackedNumbers packed(const std::vector<double>& numbers, NumberType wanted);

class BandValues {
 public:
  BandValues() = default;
  /// Values as they stand.
  BandValues(const std::vector<double>& values);
  /// None yet, of values that are scale * number + offset.
  BandValues(double scale, double offset, NumberType type, std::size_t expected);

  /// Widens all to double where the type is another.
  void append(const PackedNumbers& more);

  std::size_t size() const { return bytes_.size() / width_; }
  NumberType type() const { return type_; }
  double operator[](std::size_t i) const { return value_of(number(i)); }
  std::pair<double, double> least_and_most() const;
  /// Value i is then what value from(i) was.
  template <class From>
  void reorder(From from) {
    std::vector<unsigned char> out(bytes_.size());
    for (std::size_t i = 0, count = size(); i < count; ++i)
      std::memcpy(out.data() + i * width_, bytes_.data() + from(i) * width_, width_);
    bytes_ = std::move(out);
  }
  /// Indices in the order of ascending values, of equal ones ascending; precondition: fewer than 2^32.
  std::vector<std::uint32_t> ascending() const;

 private:
  template <class Number>
  double as(std::size_t i) const {
    Number out;
    std::memcpy(&out, bytes_.data() + i * sizeof out, sizeof out);
    return static_cast<double>(out);
  }
  double number(std::size_t i) const;
  double value_of(double number) const { return plain_ ? number : scale_ * number + offset_; }
  std::vector<std::uint32_t> counted_ascending() const;

  NumberType type_ = NumberType::f64;
  std::size_t width_ = sizeof(double);
  bool plain_ = true;
  double scale_ = 1, offset_ = 0;
  std::vector<unsigned char> bytes_;
};

}  // namespace raycube::scene
