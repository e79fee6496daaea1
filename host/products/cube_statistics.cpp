#include "host/products/cube_statistics.h"

#include <algorithm>
#include <cmath>

namespace raycube::products {

double BandStatistics::standard_deviation() const {
  return count < 2 ? 0.0 : std::sqrt(sum_squares / static_cast<double>(count - 1));
}

void BandStatistics::add(double value) {
  min = count == 0 ? value : std::min(min, value);
  max = count == 0 ? value : std::max(max, value);
  ++count;
  const double before = value - mean;
  mean += before / static_cast<double>(count);
  sum_squares += before * (value - mean);
}

void BandStatistics::merge(const BandStatistics& other) {
  ignored += other.ignored;
  not_finite += other.not_finite;
  if (other.count == 0) return;
  if (count == 0) {
    min = other.min, max = other.max;
  } else {
    min = std::min(min, other.min), max = std::max(max, other.max);
  }
  const double n = static_cast<double>(count), m = static_cast<double>(other.count), shift = other.mean - mean;
  mean += shift * m / (n + m);
  sum_squares += other.sum_squares + shift * shift * n * m / (n + m);
  count += other.count;
}

std::vector<BandStatistics> band_statistics(const EnviReader& reader,
                                            const std::function<void(std::int64_t)>& after_lines) {
  const EnviHeader& h = reader.header();
  const std::size_t bands = static_cast<std::size_t>(h.bands), parts = static_cast<std::size_t>(h.type().components);
  std::vector<BandStatistics> out(bands);
  const auto line_bytes = static_cast<std::size_t>(h.samples) * bands * parts * sizeof(double);
  const std::int64_t step = std::max<std::int64_t>(1, static_cast<std::int64_t>((8u << 20) / line_bytes));
  for (std::int64_t line = 0; line < h.lines; line += step) {
    const std::int64_t lines = std::min(step, h.lines - line);
    const auto stored = reader.read_lines(line, lines);
    for (std::size_t i = 0; i < stored.size(); i += parts) {
      const std::size_t b = i / parts % bands;
      BandStatistics& band = out[b];
      double value = stored[i];
      if (h.ignores(value)) {
        ++band.ignored;
        continue;
      }
      if (parts == 2) value = std::hypot(value, stored[i + 1]);
      if (!std::isfinite(value)) {
        ++band.not_finite;
        continue;
      }
      if (parts == 1) value = h.scaled(value, i / (parts * bands) % static_cast<std::size_t>(h.samples), b);
      band.add(value);
    }
    if (after_lines) after_lines(lines);
  }
  return out;
}

BandStatistics merged(const std::vector<BandStatistics>& bands) {
  BandStatistics all;
  for (const auto& band : bands) all.merge(band);
  return all;
}

}  // namespace raycube::products
