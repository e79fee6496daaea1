#include "host/run/radiance_guard.h"

#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/base/error.h"

namespace raycube::run {

namespace {
/// Rounding of the kernels' sums in single precision, ten times over.
constexpr double kSlack = 1e-5;
}  // namespace

RadianceGuard::RadianceGuard(const scene::Instrument& instrument, const std::vector<double>& limit)
    : instrument_(instrument) {
  for (const double value : limit) limit_.push_back(static_cast<float>(value * (1 + kSlack)));
}

std::string RadianceGuard::band_text(std::size_t band) const {
  const scene::Band& b = instrument_.bands[band];
  return fmt::format("band {}{} ({:.6g} um)", band + 1, b.name.empty() ? "" : " '" + b.name + "'", b.center_um);
}

void RadianceGuard::refuse(std::int64_t line, std::int64_t pixel, std::size_t band, float value) const {
  throw base::Error(base::Fault::bug, fmt::format("instrument '{}': the radiance of pixel {} of line {} "
                                                  "(counted from 0) in {} is {}, no number; nothing is "
                                                  "published. Look for values without measure in the "
                                                  "atmosphere's table (raycube atmos info), else report "
                                                  "this with the simulation file",
                                                  instrument_.name, pixel, line, band_text(band), value));
}

void RadianceGuard::add(std::int64_t first_line, std::int64_t lines, const float* radiance) {
  const std::size_t bands = limit_.size();
  for (std::int64_t line = first_line; line < first_line + lines; ++line)
    for (std::int64_t pixel = 0; pixel < instrument_.pixels; ++pixel, radiance += bands) {
      std::uint32_t beyond = 0;  // or no number: neither compares
      for (std::size_t b = 0; b < bands; ++b) beyond += !(radiance[b] <= limit_[b]) || radiance[b] == -INFINITY;
      if (beyond == 0) continue;
      ++pixels_;
      for (std::size_t b = 0; b < bands; ++b) {
        if (!std::isfinite(radiance[b])) refuse(line, pixel, b, radiance[b]);
        if (!(radiance[b] > limit_[b])) continue;
        const double ratio = limit_[b] > 0 ? double{radiance[b]} / double{limit_[b]} : INFINITY;
        if (ratio > worst_) worst_ = ratio, worst_line_ = line, worst_pixel_ = pixel, worst_band_ = b;
      }
    }
}

std::optional<std::string> RadianceGuard::warning() const {
  if (pixels_ == 0) return std::nullopt;
  return fmt::format(
      "{}: {} of {} pixels {} brighter than E0 / (pi (1 - S)) + B(T) + path radiance and all lamps at 1 cm, which no "
      "Lambertian surface can be: at worst {:.3g} "
      "times, pixel {} of line {} in {}; the atmosphere's table or a reflectance above 1 may be wrong, or a lamp lies "
      "on "
      "what it lights",
      instrument_.name, pixels_, std::int64_t{instrument_.pixels} * instrument_.lines, pixels_ == 1 ? "is" : "are",
      worst_, worst_pixel_, worst_line_, band_text(worst_band_));
}

std::string RadianceGuard::json() const {
  nlohmann::ordered_json out = {{"bound", "E0 / (pi (1 - S)) + B(T) + path radiance + all lamps at 1 cm"},
                                {"pixels_beyond", pixels_}};
  if (pixels_ > 0) {
    out["worst_ratio"] = std::isfinite(worst_) ? nlohmann::ordered_json(worst_) : nlohmann::ordered_json(nullptr);
    out["worst_line"] = worst_line_, out["worst_pixel"] = worst_pixel_, out["worst_band"] = worst_band_ + 1;
  }
  return out.dump();
}

}  // namespace raycube::run
