// From cells to pixels: a camera with focal planes, whose cells come in as they are rendered and whose lines go out
// when all that they see has come.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/render/truth.h"
#include "host/render/types.h"
#include "host/run/camera_job.h"

namespace raycube::run {

class SpreadImage {
 public:
  /// sink: of the image's lines, in order. Keeps references. threads: 0: all.
  SpreadImage(const scene::Simulation& simulation, const CameraJob& job, int threads, render::StripSink sink);

  /// Cells, in any order. What waits is lines of cells that came before their turn, and sums of lines of pixels that
  /// are not whole: memory does not grow with the image's lines. The same bits in any order and on any threads.
  void add(const render::Strip& cells);
  /// Throws Error(bug) where the image is not whole.
  void finish() const;
  /// Of an image that is whole: what around it met nothing.
  std::optional<std::string> warning() const;

 private:
  /// A line of cells that is not whole, or waits.
  struct CellLine {
    std::vector<float> radiance, truth;
    int filled = 0;
  };
  /// A line of pixels on its way.
  struct PixelLine {
    std::vector<float> sums;    ///< [pixel][column of the cells]
    std::vector<double> truth;  ///< [pixel][layer], sums of truth over its cells
    std::vector<float> middle;  ///< [pixel][layer], of the cell in its middle
  };
  /// Weights of the cells' columns along an axis, for vectors over columns: [term][tap][column].
  struct Weights {
    int half = 0;
    std::size_t columns = 0;
    std::vector<float> value;
    std::size_t place(int term, int tap) const {
      return (static_cast<std::size_t>(term) * static_cast<std::size_t>(2 * half + 1) +
              static_cast<std::size_t>(tap + half)) *
             columns;
    }
    const float* at(int term, int tap) const { return value.data() + place(term, tap); }
  };

  void size_weights();
  void fill(Weights& weights, const std::vector<sensors::Taps>& terms, const std::vector<std::size_t>& columns) const;
  Weights weights_of(int axis, int pixel) const;
  void take(int first_line, int lines);
  void take_pixel(int pixel, int first_line, int lines);
  void take_truth(int pixel, int line, const CellLine& cells);
  void count_missed(int line, const CellLine& cells);
  int last_cell_of(int pixel_line) const;
  void send(int pixel_line, const PixelLine& line);

  const sensors::Cells& cells_;
  render::StripSink sink_;
  int threads_;
  std::size_t columns_, layers_, materials_, shares_;
  std::vector<std::vector<std::size_t>>
      columns_of_;  ///< each band of the image; last: surfaces' means, which no optics
                    ///< blur
  render::DerivedLayers derived_;
  int terms_ = 1;
  std::array<int, 2> half_{};  ///< taps on either side, across and along
  std::vector<Weights>
      across_;  ///< of every pixel where keystone makes each its own, of all; none: made as they are used
  Weights along_;
  std::map<int, CellLine> waiting_;
  std::map<int, PixelLine> open_;
  int next_cell_ = 0, next_pixel_ = 0;
  double missed_ = 0;  ///< cells around the image, by what of them met nothing
  std::uint64_t around_ = 0;
};

}  // namespace raycube::run
