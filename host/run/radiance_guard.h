// The last look at a cube before it gets its name: numbers that are none are refused, light that cannot be is
// counted.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "scene_compiler/simulation.h"

namespace raycube::run {

class RadianceGuard {
 public:
  /// limit: W m-2 sr-1 um-1 of each band (plan::radiance_limit).
  RadianceGuard(const scene::Instrument& instrument, const std::vector<double>& limit);

  /// Whole lines, [line][pixel][band]. Throws Error(bug) that names instrument, pixel and band of the first
  /// infinite value or NaN.
  void add(std::int64_t first_line, std::int64_t lines, const float* radiance);

  /// What to say of pixels beyond the limit; nothing when there are none.
  std::optional<std::string> warning() const;
  /// For run.json: how many pixels have a band beyond its limit, and where the worst stands (all 0 without
  /// any).
  std::string json() const;

 private:
  [[noreturn]] void refuse(std::int64_t line, std::int64_t pixel, std::size_t band, float value) const;
  std::string band_text(std::size_t band) const;

  const scene::Instrument& instrument_;
  std::vector<float> limit_;
  std::uint64_t pixels_ = 0;
  double worst_ = 0;  ///< radiance over limit
  std::int64_t worst_line_ = 0, worst_pixel_ = 0;
  std::size_t worst_band_ = 0;
};

}  // namespace raycube::run
