// Maps that an analysis makes of a cube, on its pixels: ENVI, with the cube's map info, and the same as a GeoTIFF.
// Numbers are doubles, classes 16-bit.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "host/analysis/cube.h"
#include "host/base/output_file.h"

namespace raycube::analysis {

class MapFiles {
 public:
  /// Begins NAME.img, NAME.hdr and NAME.tif. layers: with their units, as band names.
  MapFiles(base::OutputSet& set, const std::string& name, const Cube& like, const std::vector<std::string>& layers,
           const std::string& description);
  ~MapFiles();
  MapFiles(MapFiles&&) noexcept;
  /// Begins a map of classes, whole numbers from 1 (0: none), by their names.
  static MapFiles of_classes(base::OutputSet& set, const std::string& name, const Cube& like,
                             const std::vector<std::string>& classes, const std::string& description);

  /// Values of a stretch's pixels, [pixel][layer]; threads may write at once.
  void write(const Pixels& where, const std::vector<double>& values);
  /// Once all is written.
  void finish();

 private:
  struct State;
  explicit MapFiles(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// Header of a cube on the pixels of another: its size, map info and what the header says of time and sun, without
/// bands.
products::EnviHeader header_like(const Cube& cube, const std::string& description);

}  // namespace raycube::analysis
