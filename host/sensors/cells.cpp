#include "host/sensors/cells.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <glm/geometric.hpp>

#include "host/base/attitude.h"
#include "host/base/error.h"
#include "host/base/parallel.h"
#include "host/sensors/camera_frame.h"

namespace raycube::sensors {
namespace {

constexpr double kMostLines = 5, kUneven = 1.1;
constexpr double kAsGoodAsOne = 1e-6;  ///< rounding of a line spacing that is the pixel's length
constexpr double kMostCells = 1e8;     ///< a fifth of them where each has a pose of its own
constexpr double kAlmost = 0.3;        ///< cells that a line may be short of

using scene::FocalPlane;
using scene::Instrument;
using scene::InstrumentKind;

const FocalPlane& plane_of(const Instrument& instrument, std::size_t band) {
  return instrument.focal_planes[instrument.plane_of(instrument.bands[band].center_um)];
}

/// -1 at the line's first sample, 1 at its last.
double across(const Instrument& instrument, double sample) {
  return instrument.pixels < 2 ? 0 : 2 * sample / (instrument.pixels - 1) - 1;
}

/// Bilinear in the table; beyond its edges theirs.
double table_value(const scene::DistortionTable& table, const std::vector<std::vector<double>>& values, double um,
                   double sample) {
  const auto place = [](const std::vector<double>& at, double x, std::size_t& i, double& t) {
    const auto above = std::upper_bound(at.begin(), at.end(), x);
    i = above == at.begin() ? 0 : std::min(static_cast<std::size_t>(above - at.begin()) - 1, at.size() - 1);
    const std::size_t next = std::min(i + 1, at.size() - 1);
    t = next == i ? 0 : std::clamp((x - at[i]) / (at[next] - at[i]), 0.0, 1.0);
  };
  std::size_t w, s;
  double tw, ts;
  place(table.wavelength_um, um, w, tw), place(table.sample, sample, s, ts);
  const auto row = [&](std::size_t r) {
    return std::lerp(values[r][s], values[r][std::min(s + 1, table.sample.size() - 1)], ts);
  };
  return std::lerp(row(w), row(std::min(w + 1, table.wavelength_um.size() - 1)), tw);
}

/// Pose at a place between poses, extrapolated past the ends.
scene::Pose between(const scene::Pose& a, const scene::Pose& b, double t) {
  const base::Attitude turned =
      base::attitude_between({a.roll_deg, a.pitch_deg, a.heading_deg}, {b.roll_deg, b.pitch_deg, b.heading_deg}, t);
  return {a.x_m + t * (b.x_m - a.x_m),
          a.y_m + t * (b.y_m - a.y_m),
          a.z_m + t * (b.z_m - a.z_m),
          turned.roll_deg,
          turned.pitch_deg,
          turned.heading_deg};
}

/// The piece that a place lies in and its part of it, of so many poses.
std::pair<std::size_t, double> piece_of(double at, std::size_t poses) {
  const double last = static_cast<double>(poses) - 2;
  const double from = std::clamp(std::floor(at), 0.0, std::max(0.0, last));
  return {static_cast<std::size_t>(from), at - from};
}

/// Of a scanner, on the level ground below it: a pixel's length over the way to the next line. 1 of a framing camera.
double lines_of_pixel(const Instrument& seen) {
  if (seen.kind == InstrumentKind::framing) return 1;
  const std::size_t per_line = seen.kind == InstrumentKind::pushbroom ? 1 : static_cast<std::size_t>(seen.pixels);
  const auto middle = [&](int line) { return seen.poses[static_cast<std::size_t>(line) * per_line + per_line / 2]; };
  const double ground_m = seen.nominal_agl_m > 0 ? middle(seen.lines / 2).z_m - seen.nominal_agl_m : 0;
  const auto meets = [&](int line, double pixels) {
    const CameraFrame frame = frame_of(middle(line));
    const glm::dvec3 way = frame.boresight + pixels * seen.ifov_along_rad * frame.forward;
    return frame.origin_m + way * ((ground_m - frame.origin_m.z) / way.z);
  };
  std::vector<double> ratio;
  for (int line = 0; line + 1 < seen.lines; ++line) {
    const double step_m = glm::length(meets(line + 1, 0) - meets(line, 0));
    ratio.push_back(glm::length(meets(line, 0.5) - meets(line, -0.5)) / step_m);
  }
  std::sort(ratio.begin(), ratio.end());
  const double least = ratio.front(), most = ratio.back(), half = ratio[ratio.size() / 2];
  if (!(most <= kMostLines && least >= 1 / kMostLines && most <= kUneven * least))
    throw base::Error(
        base::Fault::input,
        fmt::format("instrument '{}': its lines lie {:.4g} to {:.4g} pixels apart on the ground; with "
                    "focal planes they must lie evenly, within a tenth, and 0.2 to 5 pixels apart: change "
                    "line_spacing_m or poses, or take psf in place of focal_plane",
                    seen.name, 1 / most, 1 / least));
  return std::abs(half - 1) < kAsGoodAsOne ? 1 : half;
}

/// Odd, and as many to a pixel as lie across it, or a little fewer.
int cells_of_line(int across, double lines_of_pixel_along) {
  const int least = static_cast<int>(std::ceil(across / lines_of_pixel_along - kAlmost));
  return std::max(1, least % 2 ? least : least + 1);
}

/// Poses of the cells: of each of their lines, or of each cell.
std::vector<scene::Pose> cell_poses(const Cells& cells) {
  const Instrument& seen = cells.seen;
  if (seen.kind == InstrumentKind::framing) return seen.poses;
  const auto lines = static_cast<std::size_t>(seen.lines), pixels = static_cast<std::size_t>(seen.pixels);
  const auto place = [&](std::size_t axis, int cell) {
    return (cell + 0.5) / cells.grid.cells[axis] - 0.5 - cells.margin_px[axis];
  };
  std::vector<scene::Pose> out;
  for (int line = 0; line < cells.rendered.lines; ++line) {
    const auto [l, t] = piece_of(place(1, line), lines);
    if (seen.kind == InstrumentKind::pushbroom) {
      out.push_back(between(seen.poses[l], seen.poses[l + 1], t));
      continue;
    }
    for (int sample = 0; sample < cells.rendered.pixels; ++sample) {
      const auto [s, u] = piece_of(place(0, sample), pixels);
      const std::size_t next = std::min(s + 1, pixels - 1);
      const auto of_line = [&](std::size_t row) {
        return between(seen.poses[row * pixels + s], seen.poses[row * pixels + next], u);
      };
      out.push_back(between(of_line(l), of_line(l + 1), t));
    }
  }
  return out;
}

/// Bands of the cells: each of the image's, or three shifts of it.
void make_bands(Cells& cells) {
  struct Shifted {
    scene::Band band;
    std::size_t of;
    double shift_um;
  };
  std::vector<Shifted> all;
  const Instrument& seen = cells.seen;
  for (std::size_t b = 0; b < seen.bands.size(); ++b) {
    double low = 0, high = 0;
    if (plane_of(seen, b).smiles()) {
      low = high = smile_um(seen, b, 0);
      for (int s = 1; s < seen.pixels; ++s) {
        const double here = smile_um(seen, b, s);
        low = std::min(low, here), high = std::max(high, here);
      }
    }
    const std::vector<double> shifts =
        low == high ? std::vector<double>{low} : std::vector<double>{low, (low + high) / 2, high};
    for (const double shift : shifts) {
      Shifted one{seen.bands[b], b, shift};
      one.band.center_um += shift;
      for (double& um : one.band.wavelength_um) um += shift;
      all.push_back(std::move(one));
    }
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const Shifted& a, const Shifted& b) { return a.band.center_um < b.band.center_um; });
  cells.bands.assign(seen.bands.size(), {});
  cells.rendered.bands.clear();
  for (Shifted& one : all) {
    cells.bands[one.of].from.push_back(cells.rendered.bands.size());
    cells.bands[one.of].shift_um.push_back(one.shift_um);
    cells.rendered.bands.push_back(std::move(one.band));
  }
}

std::string kernel_name(const Instrument& seen, std::size_t plane) {
  return seen.name + ", focal plane '" + seen.focal_planes[plane].name + "'";
}

/// Kernels, which know only how far they reach: one for all bands of a plane that sees them alike, else one each. Which
/// band each is of.
std::vector<std::size_t> lay_out_kernels(Cells& cells, const std::vector<OpticalTransfer>& optics) {
  const Instrument& seen = cells.seen;
  std::vector<std::size_t> of_plane(optics.size(), SIZE_MAX), made_for;
  for (std::size_t b = 0; b < seen.bands.size(); ++b) {
    const std::size_t plane = seen.plane_of(seen.bands[b].center_um);
    const bool grey = seen.focal_planes[plane].grey();
    if (!grey || of_plane[plane] == SIZE_MAX) of_plane[plane] = made_for.size(), made_for.push_back(b);
    cells.bands[b].kernel = of_plane[plane];
    const auto& offset = seen.focal_planes[plane].offset_px;
    cells.bands[b].offset_cells = {offset[0] * cells.grid.cells[0],
                                   offset[1] * cells.grid.lines_of_pixel * cells.grid.cells[1]};
  }
  cells.kernels.resize(made_for.size());
  for (std::size_t i = 0; i < made_for.size(); ++i) {
    const double um = seen.bands[made_for[i]].center_um;
    const std::size_t plane = seen.plane_of(um);
    cells.kernels[i].half = kernel_half(optics[plane], um, cells.grid, kernel_name(seen, plane));
  }
  return made_for;
}

void make_kernels(Cells& cells, const std::vector<OpticalTransfer>& optics, const std::vector<std::size_t>& made_for,
                  int threads) {
  base::for_each_index(made_for.size(), threads, [&](std::size_t i) {
    const double um = cells.seen.bands[made_for[i]].center_um;
    const std::size_t plane = cells.seen.plane_of(um);
    cells.kernels[i] = make_kernel(optics[plane], um, cells.grid, kernel_name(cells.seen, plane));
  });
}

void settle_margin(Cells& cells) {
  const Instrument& seen = cells.seen;
  for (std::size_t b = 0; b < seen.bands.size(); ++b)
    if (const FocalPlane& plane = plane_of(seen, b); plane.keystone_px != 0 || !plane.distortion.keystone_px.empty())
      for (int s = 0; s < seen.pixels; ++s)
        cells.most_keystone_px = std::max(cells.most_keystone_px, std::abs(keystone_px(seen, b, s)));
  for (std::size_t axis = 0; axis < 2; ++axis) {
    double far = 0;
    for (const BandOfCells& band : cells.bands)
      far = std::max(far, cells.kernels[band.kernel].half[axis] + std::abs(band.offset_cells[axis]));
    far += kShiftReach + 1 + (axis == 0 ? cells.most_keystone_px * cells.grid.cells[0] : 0);
    cells.margin_px[axis] = static_cast<int>(std::ceil(far / cells.grid.cells[axis]));
  }
}

/// Planes as their light spreads. Keeps references to cells.seen.
std::vector<OpticalTransfer> optics_of(const Cells& cells) {
  std::vector<OpticalTransfer> optics;
  const double highest = std::max(9, cells.seen.oversampling) * std::max(1.0, cells.grid.lines_of_pixel);
  for (const FocalPlane& plane : cells.seen.focal_planes) optics.emplace_back(plane, highest);
  return optics;
}

/// Everything but what the kernels weigh and the poses: grid, bands, margins, numbers of cells. Which band each kernel
/// is of.
std::vector<std::size_t> lay_out(Cells& cells, const std::vector<OpticalTransfer>& optics) {
  const Instrument& seen = cells.seen;
  int q = seen.oversampling;
  for (std::size_t b = 0; seen.oversampling == 0 && b < seen.bands.size(); ++b)
    q = std::max(q, enough_cells(optics[seen.plane_of(seen.bands[b].center_um)], seen.bands[b].center_um));
  cells.grid.cells = {q, cells_of_line(q, cells.grid.lines_of_pixel)};
  make_bands(cells);
  auto made_for = lay_out_kernels(cells, optics);
  settle_margin(cells);
  const auto& n = cells.grid.cells;
  const double across = (seen.pixels + 2.0 * cells.margin_px[0]) * n[0],
               along = (seen.lines + 2.0 * cells.margin_px[1]) * n[1],
               most = kMostCells / (seen.kind == InstrumentKind::whiskbroom ? 5 : 1);
  if (across * along > most)
    throw base::Error(
        base::Fault::input,
        fmt::format("instrument '{}': its focal planes make {:.0f} x {:.0f} cells of its pixels, more than "
                    "{:.0f}; split the image, or lower oversampling",
                    seen.name, across, along, most));
  cells.rendered.pixels = static_cast<int>(across), cells.rendered.lines = static_cast<int>(along);
  return made_for;
}

Cells begin_cells(const Instrument& instrument) {
  Cells cells;
  cells.seen = cells.rendered = instrument;
  cells.grid.lines_of_pixel = lines_of_pixel(instrument);
  return cells;
}

}  // namespace

std::vector<double> BandOfCells::shares(double um) const {
  std::vector<double> out(from.size(), 1.0);
  for (std::size_t i = 0; i < from.size(); ++i)
    for (std::size_t j = 0; j < from.size(); ++j)
      if (j != i) out[i] *= (um - shift_um[j]) / (shift_um[i] - shift_um[j]);
  return out;
}

double smile_um(const Instrument& instrument, std::size_t band, double sample) {
  const FocalPlane& plane = plane_of(instrument, band);
  if (!plane.distortion.smile_um.empty())
    return table_value(plane.distortion, plane.distortion.smile_um, instrument.bands[band].center_um, sample);
  const double x = across(instrument, sample);
  return plane.smile_um * x * x;
}

double keystone_px(const Instrument& instrument, std::size_t band, double sample) {
  const FocalPlane& plane = plane_of(instrument, band);
  const double um = instrument.bands[band].center_um;
  if (!plane.distortion.keystone_px.empty())
    return table_value(plane.distortion, plane.distortion.keystone_px, um, sample);
  if (plane.keystone_px == 0) return 0;
  double first = 1e300, last = 0;
  for (const scene::Band& other : instrument.bands)
    if (other.center_um >= plane.first_um && other.center_um <= plane.last_um)
      first = std::min(first, other.center_um), last = std::max(last, other.center_um);
  return last > first ? plane.keystone_px * across(instrument, sample) * (um - 0.5 * (first + last)) / (last - first)
                      : 0;
}

void check_cells(const Instrument& instrument) {
  if (instrument.focal_planes.empty()) return;
  Cells cells = begin_cells(instrument);
  lay_out(cells, optics_of(cells));
}

std::shared_ptr<const Cells> make_cells(const Instrument& instrument, int threads) {
  if (instrument.focal_planes.empty()) return nullptr;
  auto cells = std::make_shared<Cells>(begin_cells(instrument));
  const std::vector<OpticalTransfer> optics = optics_of(*cells);
  make_kernels(*cells, optics, lay_out(*cells, optics), threads);
  Instrument& r = cells->rendered;
  const auto& n = cells->grid.cells;
  r.ifov_across_rad /= n[0], r.ifov_along_rad /= n[1] * cells->grid.lines_of_pixel;
  r.motion = scene::PoseMotion::held;
  r.poses = cell_poses(*cells);
  r.focal_planes.clear(), r.detector.reset(), r.quicklook_bands.clear();
  r.cells_of_pixel = n;
  r.share_of_draws = 0;
  for (const SpreadKernel& kernel : cells->kernels)
    r.share_of_draws = std::max(r.share_of_draws, kernel.share_of_draws);
  return cells;
}

}  // namespace raycube::sensors
