#include "scene_compiler/band_values.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>

namespace raycube::scene {
namespace {

template <class Number>
bool holds(double number) {
  if (std::isnan(number)) return !std::numeric_limits<Number>::is_integer;
  if (std::numeric_limits<Number>::is_integer) {
    if (!(number >= static_cast<double>(std::numeric_limits<Number>::lowest()) &&
          number <= static_cast<double>(std::numeric_limits<Number>::max())))
      return false;
  } else if (std::isfinite(number) && std::abs(number) > static_cast<double>(std::numeric_limits<Number>::max())) {
    return false;
  }
  return std::bit_cast<std::uint64_t>(static_cast<double>(static_cast<Number>(number))) ==
         std::bit_cast<std::uint64_t>(number);
}

template <class Number>
bool pack(const std::vector<double>& numbers, std::vector<unsigned char>& bytes) {
  if (!std::all_of(numbers.begin(), numbers.end(), holds<Number>)) return false;
  bytes.resize(numbers.size() * sizeof(Number));
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const auto number = static_cast<Number>(numbers[i]);
    std::memcpy(bytes.data() + i * sizeof number, &number, sizeof number);
  }
  return true;
}

bool pack_as(NumberType type, const std::vector<double>& numbers, std::vector<unsigned char>& bytes) {
  switch (type) {
    case NumberType::u8:
      return pack<std::uint8_t>(numbers, bytes);
    case NumberType::i8:
      return pack<std::int8_t>(numbers, bytes);
    case NumberType::u16:
      return pack<std::uint16_t>(numbers, bytes);
    case NumberType::i16:
      return pack<std::int16_t>(numbers, bytes);
    case NumberType::u32:
      return pack<std::uint32_t>(numbers, bytes);
    case NumberType::i32:
      return pack<std::int32_t>(numbers, bytes);
    case NumberType::f32:
      return pack<float>(numbers, bytes);
    case NumberType::f64:
      break;
  }
  return false;
}

}  // namespace

std::size_t type_bytes(NumberType type) {
  switch (type) {
    case NumberType::u8:
    case NumberType::i8:
      return 1;
    case NumberType::u16:
    case NumberType::i16:
      return 2;
    case NumberType::u32:
    case NumberType::i32:
    case NumberType::f32:
      return 4;
    case NumberType::f64:
      break;
  }
  return 8;
}

PackedNumbers packed(const std::vector<double>& numbers, NumberType wanted) {
  PackedNumbers out;
  if (pack_as(wanted, numbers, out.bytes)) {
    out.type = wanted;
    return out;
  }
  out.bytes.resize(numbers.size() * sizeof(double));
  if (!numbers.empty()) std::memcpy(out.bytes.data(), numbers.data(), out.bytes.size());
  return out;
}

BandValues::BandValues(const std::vector<double>& values) : bytes_(packed(values, NumberType::f64).bytes) {}

BandValues::BandValues(double scale, double offset, NumberType type, std::size_t expected)
    : type_(type), width_(type_bytes(type)), plain_(false), scale_(scale), offset_(offset) {
  bytes_.reserve(expected * width_);
}

void BandValues::append(const PackedNumbers& more) {
  if (more.type != type_ && type_ != NumberType::f64) {
    std::vector<double> wide(size());
    for (std::size_t i = 0; i < wide.size(); ++i) wide[i] = number(i);
    const std::size_t expected = bytes_.capacity() / width_;
    type_ = NumberType::f64, width_ = sizeof(double);
    bytes_.clear();
    bytes_.reserve(expected * width_);
    append(packed(wide, NumberType::f64));
  }
  if (more.type == type_) {
    bytes_.insert(bytes_.end(), more.bytes.begin(), more.bytes.end());
    return;
  }
  BandValues other(1, 0, more.type, 0);
  other.bytes_ = more.bytes;
  std::vector<double> wide(other.size());
  for (std::size_t i = 0; i < wide.size(); ++i) wide[i] = other.number(i);
  append(packed(wide, NumberType::f64));
}

double BandValues::number(std::size_t i) const {
  switch (type_) {
    case NumberType::u8:
      return as<std::uint8_t>(i);
    case NumberType::i8:
      return as<std::int8_t>(i);
    case NumberType::u16:
      return as<std::uint16_t>(i);
    case NumberType::i16:
      return as<std::int16_t>(i);
    case NumberType::u32:
      return as<std::uint32_t>(i);
    case NumberType::i32:
      return as<std::int32_t>(i);
    case NumberType::f32:
      return as<float>(i);
    case NumberType::f64:
      break;
  }
  return as<double>(i);
}

std::pair<double, double> BandValues::least_and_most() const {
  std::pair<double, double> out{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (std::size_t i = 0, count = size(); i < count; ++i) {
    const double value = (*this)[i];
    out.first = std::min(out.first, value), out.second = std::max(out.second, value);
  }
  return out;
}

std::vector<std::uint32_t> BandValues::counted_ascending() const {
  // A class for each value that numbers of one or two bytes can stand for.
  constexpr std::int32_t kLeast = -32768, kMost = 65535;
  constexpr std::size_t kNumbers = kMost - kLeast + 1;
  std::vector<std::size_t> count(kNumbers, 0), by_value(kNumbers), next(kNumbers);
  const auto bin = [&](std::size_t i) {
    return static_cast<std::size_t>(static_cast<std::int32_t>(number(i)) - kLeast);
  };
  const auto value = [&](std::size_t b) { return value_of(static_cast<double>(b) + kLeast); };
  for (std::size_t i = 0; i < size(); ++i) ++count[bin(i)];
  std::iota(by_value.begin(), by_value.end(), std::size_t{0});
  std::stable_sort(by_value.begin(), by_value.end(), [&](std::size_t a, std::size_t b) { return value(a) < value(b); });
  std::vector<std::size_t> class_of(kNumbers);
  for (std::size_t k = 0, first = 0; k < kNumbers;) {
    std::size_t end = k, in_class = 0;
    for (; end < kNumbers && value(by_value[end]) == value(by_value[k]); ++end)
      in_class += count[by_value[end]], class_of[by_value[end]] = by_value[k];
    next[by_value[k]] = first;
    first += in_class, k = end;
  }
  std::vector<std::uint32_t> out(size());
  for (std::size_t i = 0; i < out.size(); ++i) out[next[class_of[bin(i)]]++] = static_cast<std::uint32_t>(i);
  return out;
}

std::vector<std::uint32_t> BandValues::ascending() const {
  if (width_ <= 2) return counted_ascending();
  std::vector<std::uint32_t> out(size());
  std::iota(out.begin(), out.end(), 0u);
  std::sort(out.begin(), out.end(), [&](std::uint32_t a, std::uint32_t b) {
    const double value_a = (*this)[a], value_b = (*this)[b];
    return value_a != value_b ? value_a < value_b : a < b;
  });
  return out;
}

}  // namespace raycube::scene
