// Where a place on the ground lies in an image whose pixels' places are known: the registration of two images by their
// truth.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "host/analysis/cube.h"

namespace raycube::analysis {

/// Numbers in the file, from 0, of the layers that say where pixels look: x_m, y_m, z_m of truth.img, or easting,
/// northing, height of location.img. Error(input) where a cube has neither.
std::array<std::size_t, 3> place_layers(const products::EnviHeader& header, const std::string& path);

/// A place in an image, pixels from the middle of its first.
struct ImagePlace {
  double sample = 0, line = 0;
};

class GroundMatch {
 public:
  /// The image's places in memory: 28 bytes a pixel.
  explicit GroundMatch(const Cube& places, const Pass& pass);

  /// The nearest pixel's middle, and from there by the slope of the map about it. size: of what lies at the place, in
  /// the places' unit. Nothing where the nearest lies farther in space than 1.5 times the larger of that and its own
  /// size (beyond the image, or hidden there by something higher), or farther along the image than 0.75 pixels.
  std::optional<ImagePlace> find(const double* place, double size) const;

 private:
  const float* at(std::int64_t line, std::int64_t sample) const {
    return place_.data() + 3 * (line * samples_ + sample);
  }
  std::array<std::int64_t, 2> bin_of(double x, double y) const;
  std::array<double, 3> slope(std::int64_t line, std::int64_t sample, int across) const;

  std::int64_t samples_, lines_;
  std::array<double, 3> origin_{};  ///< of the floats
  std::vector<float> place_;        ///< [line][sample][3]
  std::array<double, 2> low_{}, step_{1, 1};
  std::array<std::int64_t, 2> bins_{1, 1};
  std::vector<std::uint32_t> first_, pixel_;  ///< pixels by bin: those of bin b from first_[b]
};

}  // namespace raycube::analysis
