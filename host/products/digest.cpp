#include "host/products/digest.h"

#include <algorithm>

namespace raycube::products {

void Digest::add_radiance(const Strip& strip, std::int64_t samples, std::int64_t bands) {
  const std::size_t pixels = static_cast<std::size_t>(strip.lines * samples),
                    pixel_bytes = static_cast<std::size_t>(bands) * sizeof(float);
  const std::size_t stride = strip.pixel_stride ? strip.pixel_stride : static_cast<std::size_t>(bands);
  if (stride == static_cast<std::size_t>(bands)) {
    hash_.add(strip.values, pixels * pixel_bytes);
    return;
  }
  for (std::size_t p = 0; p < pixels; ++p) hash_.add(strip.values + p * stride, pixel_bytes);
}

void Digest::add_truth(const EnviWriter& truth) {
  const EnviHeader& h = truth.header();
  const std::size_t line_values = static_cast<std::size_t>(h.samples * h.bands);
  const std::int64_t step =
      std::max<std::int64_t>(1, static_cast<std::int64_t>((4u << 20) / (line_values * sizeof(float))));
  std::vector<float> values;
  for (std::int64_t line = 0; line < h.lines; line += step) {
    const std::int64_t lines = std::min(step, h.lines - line);
    values.resize(static_cast<std::size_t>(lines) * line_values);
    truth.read_back(line, lines, values.data());
    hash_.add(values.data(), values.size() * sizeof(float));
  }
}

}  // namespace raycube::products
