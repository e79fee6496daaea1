// Regions of an image: which pixels an analysis takes, from a rectangle, a raster (a mask, classes, a layer of truth)
// or a file of outlines.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/analysis/cube.h"

namespace raycube::analysis {

/// Pixels of one line, from first to last, both from 0 and included.
struct Span {
  std::int64_t line = 0, first = 0, last = 0;
};

class Region {
 public:
  Region() = default;
  /// spans: by line, then by sample, none touching the next.
  Region(std::string name, std::vector<Span> spans) : name_(std::move(name)), spans_(std::move(spans)) {}

  const std::string& name() const { return name_; }
  const std::vector<Span>& spans() const { return spans_; }
  std::uint64_t count() const;
  bool holds(std::int64_t line, std::int64_t sample) const;

 private:
  std::string name_;
  std::vector<Span> spans_;
};

/// Reads a region written as NAME=WHAT of an image as large as the cube:
///   X0:X1,Y0:Y1           samples and lines, from 0, ends included
///   FILE                  a raster as large as the image, where it is not 0; or outlines (GeoJSON, shapefile, ... what
///                         GDAL reads as vectors), the pixels whose centres lie inside
///   FILE@VALUE            where the raster's first layer has that value
///   FILE@LAYER>=VALUE     where a layer, by its name or its number from 1, has such a value; also > <= < =
///   FILE@FIELD=TEXT       of outlines those whose attribute has that text
/// Outlines are in the coordinates of the cube's map info, or of their own system where they name one; without map info
/// they are samples and lines from the upper left corner, lines counted downwards. Throws Error(input) where the text
/// is not understood, a file is not there or of another size, or no pixel is left.
Region read_region(const std::string& text, const Cube& cube);

/// A raster layer's numbers, line by line; the file must be as large as the image. layer: its name or number, "": the
/// first.
std::vector<double> read_layer(const std::string& file, const std::string& layer, std::int64_t samples,
                               std::int64_t lines);

/// A region for each class of a raster: each value but 0 of its first layer, by the class names of its file where it
/// has some.
std::vector<Region> read_classes(const std::string& file, const Cube& cube);

/// Pixels where `is` holds.
template <class Is>
Region region_where(std::string name, std::int64_t samples, std::int64_t lines, const Is& is) {
  std::vector<Span> spans;
  for (std::int64_t line = 0; line < lines; ++line)
    for (std::int64_t sample = 0; sample < samples; ++sample) {
      if (!is(line, sample)) continue;
      if (!spans.empty() && spans.back().line == line && spans.back().last + 1 == sample)
        spans.back().last = sample;
      else
        spans.push_back({line, sample, sample});
    }
  return {std::move(name), std::move(spans)};
}

}  // namespace raycube::analysis
