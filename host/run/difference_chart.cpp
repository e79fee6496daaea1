#include "host/base/text.h"
#include "host/run/difference_chart.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace raycube::run {

namespace {

constexpr products::Colour kPaper{255, 255, 255}, kInk{30, 30, 30};
constexpr int kScale = 2, kLine = (products::kLetterHeight + 4) * kScale;
constexpr int kLeft = 120, kTop = 2 * kLine + 16, kRight = 150, kBottom = 2 * kLine + 16, kTick = 6;
/// The field is stretched by whole factors to about this size.
constexpr int kFieldWidth = 720, kFieldHeight = 500;

std::string band_label(const scene::Instrument& instrument, std::size_t band) {
  if (instrument.bands.size() <= band) return std::to_string(band + 1);
  const scene::Band& b = instrument.bands[band];
  if (!(b.center_um > 0)) return b.name;
  char text[32];
  std::snprintf(text, sizeof text, "%.0f", 1000 * b.center_um);
  return text;
}

/// About `wanted` places of 0 .. count - 1, evenly spread, first and last among them.
std::vector<int> ticks(int count, int wanted) {
  std::vector<int> out;
  const int n = std::min(count, wanted);
  for (int i = 0; i < n; ++i)
    out.push_back(n == 1 ? 0 : static_cast<int>(std::lround(static_cast<double>(i) * (count - 1) / (n - 1))));
  return out;
}

}  // namespace

products::Raster difference_chart(const reference::Report& report, const scene::Instrument& instrument) {
  const reference::Picture field = reference::difference_picture(report);
  const int sx = std::max(1, kFieldWidth / std::max(1, field.width)),
            sy = std::max(1, kFieldHeight / std::max(1, field.height));
  const int width = field.width * sx, height = field.height * sy;
  // 20 pixels of paper at least between the scale's labels.
  const int tall = std::max(height, 8 * kLine);
  const std::string title = instrument.name + ": relative difference of device and reference";
  const std::string subtitle =
      base::counted(report.pixels, "pixel") + ", " + base::counted(report.bands.size(), "band") + ", worst " + [&] {
        char text[32];
        std::snprintf(text, sizeof text, "%.2g", report.worst);
        return std::string(text);
      }();
  const int wide = std::max({kLeft + width + kRight, 16 + products::Raster::text_width(title, kScale),
                             16 + products::Raster::text_width(subtitle, kScale)});
  products::Raster chart(wide, kTop + tall + kBottom, kPaper);
  const auto text = [&](int x, int y, const std::string& what) { chart.text(x, y, what, kScale, kInk); };
  text(8, 8, title);
  text(8, 8 + kLine, subtitle);

  chart.fill(kLeft - 1, kTop - 1, width + 2, height + 2, kInk);
  for (int row = 0; row < field.height; ++row)
    for (int band = 0; band < field.width; ++band) {
      const std::size_t at =
          3 * (static_cast<std::size_t>(row) * static_cast<std::size_t>(field.width) + static_cast<std::size_t>(band));
      chart.fill(kLeft + band * sx, kTop + row * sy, sx, sy, {field.rgb[at], field.rgb[at + 1], field.rgb[at + 2]});
    }

  const int below = kTop + height;
  for (const int band : ticks(field.width, 7)) {
    const std::string label = band_label(instrument, static_cast<std::size_t>(band));
    const int middle = kLeft + band * sx + sx / 2;
    chart.fill(middle, below, 2, kTick, kInk);
    text(middle - products::Raster::text_width(label, kScale) / 2, below + kTick + 4, label);
  }
  text(kLeft, below + kTick + 4 + kLine, "band centre (nm)");

  text(8, kTop - kLine / 2 + 2, "line");
  for (const int row : ticks(field.height, std::min(6, std::max(1, height / (2 * kLine))))) {
    const std::size_t pixel = static_cast<std::size_t>(row) * static_cast<std::size_t>(field.bunch);
    const int middle = kTop + row * sy + sy / 2;
    const std::string label = std::to_string(report.picture_line.at(pixel));
    chart.fill(kLeft - kTick - 1, middle, kTick, 2, kInk);
    text(kLeft - kTick - 6 - products::Raster::text_width(label, kScale),
         middle + (row == 0 ? kLine / 2 : -products::kLetterHeight), label);
  }

  // The scale runs from 1e-9 to 2e-5, evenly in the logarithm.
  const double low = -9, high = std::log10(2e-5);
  const int bar = kLeft + width + 24;
  for (int y = 0; y < tall; ++y)
    chart.fill(bar, kTop + y, 20, 1,
               reference::difference_colour(static_cast<float>(high + (low - high) * y / (tall - 1))));
  for (const auto& [at, label] :
       {std::pair{high, ">2e-5"}, {-6.0, "1e-6"}, {-7.0, "1e-7"}, {-8.0, "1e-8"}, {-9.0, "<1e-9"}}) {
    const int y = kTop + static_cast<int>(std::lround((high - at) / (high - low) * (tall - 1)));
    chart.fill(bar + 20, y, kTick, 2, kInk);
    text(bar + 20 + kTick + 4, y - products::kLetterHeight, label);
  }
  return chart;
}

}  // namespace raycube::run
