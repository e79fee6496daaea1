#include "host/products/quicklook.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "host/base/error.h"
#include "host/products/png_writer.h"

namespace raycube::products {
namespace {

constexpr double kLargestPixels = 1 << 20;
constexpr std::int64_t kShownSide = 512;  ///< of a small image's longer side, at most
constexpr double kLowShare = 0.02, kHighShare = 0.98;

/// Value below which a share of the sorted values lies: nearest rank.
float quantile(std::vector<float>& values, double share) {
  const auto rank = static_cast<std::ptrdiff_t>(std::llround(share * static_cast<double>(values.size() - 1)));
  std::nth_element(values.begin(), values.begin() + rank, values.end());
  return values[static_cast<std::size_t>(rank)];
}

/// Rows of pixels with each as a square of so many.
std::vector<std::uint8_t> enlarged(const std::vector<std::uint8_t>& pixels, std::size_t width, std::size_t channels,
                                   std::size_t factor) {
  std::vector<std::uint8_t> out;
  out.reserve(pixels.size() * factor * factor);
  for (std::size_t row = 0; row < pixels.size(); row += width * channels)
    for (std::size_t again = 0; again < factor; ++again)
      for (std::size_t at = row; at < row + width * channels; at += channels)
        for (std::size_t k = 0; k < factor; ++k)
          out.insert(out.end(), pixels.begin() + static_cast<std::ptrdiff_t>(at),
                     pixels.begin() + static_cast<std::ptrdiff_t>(at + channels));
  return out;
}

}  // namespace

std::vector<int> default_quicklook_bands(const std::vector<double>& wavelength_um) {
  const auto count = static_cast<int>(wavelength_um.size());
  if (count < 3) return {0};
  const auto [low, high] = std::minmax_element(wavelength_um.begin(), wavelength_um.end());
  const auto nearest = [&](double um) {
    const auto found = std::min_element(wavelength_um.begin(), wavelength_um.end(),
                                        [&](double a, double b) { return std::abs(a - um) < std::abs(b - um); });
    return static_cast<int>(found - wavelength_um.begin());
  };
  if (*low <= 0.47 && *high >= 0.63) return {nearest(0.65), nearest(0.55), nearest(0.45)};
  const double width = *high - *low;
  return {nearest(*low + width * 5 / 6), nearest(*low + width / 2), nearest(*low + width / 6)};
}

Quicklook::Quicklook(std::int64_t samples, std::int64_t lines, std::vector<int> bands)
    : samples_(samples), lines_(lines), bands_(std::move(bands)) {
  if (bands_.size() != 1 && bands_.size() != 3)
    throw base::Error(base::Fault::bug, "a quicklook takes one band or three");
  while (std::ceil(static_cast<double>(samples) / step_) * std::ceil(static_cast<double>(lines) / step_) >
         kLargestPixels)
    ++step_;
  if (step_ > 255) throw base::Error(base::Fault::input, "the image is too large for a quicklook; switch the PNG off");
  width_ = (samples + step_ - 1) / step_;
  height_ = (lines + step_ - 1) / step_;
  sum_.assign(static_cast<std::size_t>(width_ * height_) * bands_.size(), 0.0f);
  count_.assign(sum_.size(), 0);
}

void Quicklook::add(const Strip& strip) {
  if (strip.first_line != next_line_ || strip.first_line + strip.lines > lines_ || strip.pixel_stride == 0)
    throw base::Error(base::Fault::bug,
                      fmt::format("quicklook: line {} came, {} is next", strip.first_line, next_line_));
  for (std::int64_t l = 0; l < strip.lines; ++l)
    for (std::int64_t x = 0; x < samples_; ++x) {
      const float* pixel = strip.values + static_cast<std::size_t>(l * samples_ + x) * strip.pixel_stride;
      const auto at = static_cast<std::size_t>(((strip.first_line + l) / step_) * width_ + x / step_) * bands_.size();
      for (std::size_t c = 0; c < bands_.size(); ++c) {
        const float value = pixel[bands_[c]];
        if (!std::isfinite(value)) continue;
        sum_[at + c] += value;
        ++count_[at + c];
      }
    }
  next_line_ += strip.lines;
}

int Quicklook::enlarged_by() const {
  return static_cast<int>(std::max<std::int64_t>(1, kShownSide / std::max(width_, height_)));
}

std::vector<Quicklook::Stretch> Quicklook::write(base::OutputFile& file,
                                                 const std::vector<std::string>& band_text) const {
  const std::size_t channels = bands_.size();
  if (next_line_ != lines_ || band_text.size() != channels)
    throw base::Error(base::Fault::bug, "quicklook of an unfinished image");
  std::vector<Stretch> stretches;
  std::vector<std::uint8_t> pixels(sum_.size());
  std::string text;
  for (std::size_t c = 0; c < channels; ++c) {
    std::vector<float> values;
    values.reserve(sum_.size() / channels);
    for (std::size_t i = c; i < sum_.size(); i += channels)
      if (count_[i]) values.push_back(sum_[i] / static_cast<float>(count_[i]));
    Stretch stretch{bands_[c], 0, 0};
    if (!values.empty()) stretch.low = quantile(values, kLowShare), stretch.high = quantile(values, kHighShare);
    const double width = stretch.high - stretch.low;
    for (std::size_t i = c; i < sum_.size(); i += channels) {
      if (!count_[i]) continue;  // no finite value: black
      const double value = sum_[i] / static_cast<float>(count_[i]);
      const double share = width > 0 ? (value - stretch.low) / width : 0.5;  // a uniform band is shown mid-grey
      pixels[i] = static_cast<std::uint8_t>(std::lround(255 * std::clamp(share, 0.0, 1.0)));
    }
    text += fmt::format("{}{}: band {} ({}), linear from {:.6g} to {:.6g}", text.empty() ? "" : "; ",
                        channels == 1 ? "grey"
                        : c == 0      ? "red"
                        : c == 1      ? "green"
                                      : "blue",
                        bands_[c] + 1, band_text[c], stretch.low, stretch.high);
    stretches.push_back(stretch);
  }
  text += " (2nd to 98th percentile)";
  if (step_ > 1) text += fmt::format("; means over {0} x {0} pixels", step_);
  const int factor = enlarged_by();
  if (factor > 1) {
    pixels = enlarged(pixels, static_cast<std::size_t>(width_), channels, static_cast<std::size_t>(factor));
    text += fmt::format("; each pixel as {0} x {0}", factor);
  }
  write_png(file, static_cast<std::uint32_t>(width_ * factor), static_cast<std::uint32_t>(height_ * factor),
            static_cast<int>(channels), pixels, {{"Description", text}, {"Software", "raycube"}});
  return stretches;
}

}  // namespace raycube::products
