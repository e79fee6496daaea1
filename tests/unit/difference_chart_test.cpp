// The chart of `check`: every cell has its difference's colour, the scale and labels stand beside it, letters are the
// letters.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "host/run/difference_chart.h"

using namespace raycube;
using products::Colour;
using products::Raster;

namespace {

Colour at(const Raster& image, int x, int y) {
  const std::size_t i =
      3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width()) + static_cast<std::size_t>(x));
  return {image.rgb()[i], image.rgb()[i + 1], image.rgb()[i + 2]};
}

std::size_t count(const Raster& image, const Colour& colour, int x0, int x1) {
  std::size_t n = 0;
  for (int y = 0; y < image.height(); ++y)
    for (int x = x0; x < x1; ++x) n += at(image, x, y) == colour;
  return n;
}

}  // namespace

TEST_CASE("S61: letters of charts: shapes, scale, and nothing outside the image") {
  Raster image(24, 9, {255, 255, 255});
  image.text(1, 1, "1e-", 1, {0, 0, 0});
  std::string drawn;
  for (int y = 1; y < 8; ++y, drawn += '\n')
    for (int x = 1; x < 18; ++x) drawn += at(image, x, y) == Colour{0, 0, 0} ? '#' : '.';
  CHECK(drawn ==
        "..#..............\n"
        ".##..............\n"
        "..#....###.......\n"
        "..#...#...#.#####\n"
        "..#...#####......\n"
        "..#...#..........\n"
        ".###...###.......\n");
  Raster twice(48, 18, {255, 255, 255});
  twice.text(2, 2, "1e-", 2, {0, 0, 0});
  CHECK(count(twice, {0, 0, 0}, 0, 48) == 4 * count(image, {0, 0, 0}, 0, 24));
  image.text(-3, -3, "outside of it", 5, {0, 0, 0});
  CHECK(Raster::text_width("nm", 2) == 24);
}

TEST_CASE("S61: the difference picture as a chart: cells, colour scale, labels, room for three bands as for 360") {
  reference::Report report;
  scene::Instrument instrument;
  instrument.name = "camera";
  int bands = 3, rows = 4;
  SUBCASE("3 bands of 4 pixels") {}
  SUBCASE("360 bands of 1500 pixels") { bands = 360, rows = 1500; }
  for (int b = 0; b < bands; ++b) {
    scene::Band band;
    band.center_um = 0.4 + 0.005 * b;
    instrument.bands.push_back(band);
  }
  report.pixels = static_cast<std::uint64_t>(rows);
  report.bands.resize(static_cast<std::size_t>(bands));
  report.picture.assign(static_cast<std::size_t>(rows), std::vector<float>(static_cast<std::size_t>(bands), -12.0f));
  for (int row = 0; row < rows; ++row) report.picture_line.push_back(static_cast<std::uint32_t>(10 * row));
  report.picture[1][2] = -4;  // beyond the limit
  const Raster chart = run::difference_chart(report, instrument);
  const reference::Picture field = reference::difference_picture(report);
  CHECK(field.bunch == (rows > 1024 ? 2 : 1));
  const int sx = std::max(1, 720 / bands), sy = std::max(1, 500 / field.height);
  CHECK(chart.width() > bands * sx + 150);
  CHECK(chart.width() < 1200);
  CHECK(chart.height() > field.height * sy + 50);
  // One red cell left of the scale, and the scale's own red beside it; all other cells black.
  const int scale = 120 + bands * sx + 12;
  CHECK(count(chart, {220, 30, 30}, 0, scale) == static_cast<std::size_t>(sx * sy));
  CHECK(count(chart, {220, 30, 30}, scale, chart.width()) >= 20);
  CHECK(count(chart, {0, 0, 0}, 0, scale) ==
        static_cast<std::size_t>(sx * sy) * static_cast<std::size_t>(bands * field.height - 1));
  CHECK(count(chart, {30, 30, 30}, 0, 110) > 100);                     // lines at the left
  CHECK(count(chart, {30, 30, 30}, scale + 20, chart.width()) > 100);  // figures of the scale
}
