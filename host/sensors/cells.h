// A camera with focal planes, rendered as cells: an instrument of finer pixels, past its edges, in whose image each
// band is convolved with its own point spread.
#pragma once

#include <memory>
#include <vector>

#include "host/sensors/spread_kernel.h"

namespace raycube::sensors {

/// A band of the image as a mix of the cells' bands: where it smiles Lagrange's polynomial through three shifts of its
/// centre, else one.
struct BandOfCells {
  std::vector<std::size_t> from;  ///< bands of the cells
  std::vector<double> shift_um;   ///< of their centres, ascending
  std::size_t kernel = 0;
  std::array<double, 2> offset_cells{};  ///< across, along: the same in the whole image

  /// Share of each of `from` in a band whose centre is shifted by so much.
  std::vector<double> shares(double um) const;
};

struct Cells {
  scene::Instrument seen;      ///< as the file has it
  scene::Instrument rendered;  ///< whose pixels are cells
  KernelGrid grid;
  std::array<int, 2> margin_px{};  ///< beyond each edge, across and along (lines)
  std::vector<SpreadKernel> kernels;
  std::vector<BandOfCells> bands;  ///< of `seen`
  double most_keystone_px = 0;     ///< in any band and sample

  /// Cell of a pixel's middle along either axis.
  int middle(std::size_t axis, int pixel) const {
    return (margin_px[axis] + pixel) * grid.cells[axis] + grid.cells[axis] / 2;
  }
  /// Cells on either side of the middle that are the pixel's own: along, a pixel is as long as its lines say.
  std::array<int, 2> own() const {
    const double along = grid.cells[1] * grid.lines_of_pixel;
    return {grid.cells[0] / 2, std::max(0, static_cast<int>(0.5 * along - 0.5 + 1e-6))};
  }
  int own_count() const { return (2 * own()[0] + 1) * (2 * own()[1] + 1); }
};

/// Of a band's centre at a sample, um, and of where it looks there, pixels towards higher samples.
double smile_um(const scene::Instrument& instrument, std::size_t band, double sample);
double keystone_px(const scene::Instrument& instrument, std::size_t band, double sample);

/// Of an instrument with focal planes; null without. threads: 0: all. Throws Error(input) for a scanner whose lines lie
/// unevenly on the ground (by more than a tenth), or more than five times closer or farther apart than its pixels are
/// long, and for point spreads that reach too far.
std::shared_ptr<const Cells> make_cells(const scene::Instrument& instrument, int threads);
/// Refuses what make_cells does, without the kernels' weights.
void check_cells(const scene::Instrument& instrument);

}  // namespace raycube::sensors
