#include "host/lidar/image_blur.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>

#include "atmos_tables/optics/gauss_legendre.h"
#include "host/lidar/turbulence.h"

namespace raycube::lidar {

namespace {

constexpr int kMostReach = 15;

double sinc(double x) { return x == 0 ? 1 : std::sin(M_PI * x) / (M_PI * x); }

/// Modulation of a clear circular aperture at a share of its cut-off.
double aperture_mtf(double share) {
  return share >= 1 ? 0 : 2 / M_PI * (std::acos(share) - share * std::sqrt(1 - share * share));
}

/// Shares of the pixels 0 .. reach away along columns and rows: integral of modulation x sinc^2 x sinc^2 x cosines over
/// all frequencies (cycles / pixel).
Eigen::MatrixXd quadrant(const scene::Lidar& lidar, double fried_m, int reach) {
  const double wavelength_m = lidar.pulse.lines.front().wavelength_um * 1e-6,
               diameter_m = 2 * lidar.receiver.aperture_radius_m, pitch = lidar.receiver.pixel_pitch_rad;
  // sinc^2 of light and pixel leaves 1e-3 beyond 20 cycles: that part stays where it came from.
  const double highest = std::min(diameter_m / wavelength_m * pitch, 20.0);
  const auto count = static_cast<Eigen::Index>(std::ceil(24 + 6 * highest * (1 + 0.25 * reach)));
  const auto rule = atmos::gauss_legendre_rule(static_cast<std::size_t>(count));
  Eigen::VectorXd frequency(count);
  Eigen::MatrixXd cosine(count, reach + 1), modulation(count, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    frequency[i] = 0.5 * highest * (rule.node[static_cast<std::size_t>(i)] + 1);
    const double weight =
        highest * rule.weight[static_cast<std::size_t>(i)] * sinc(frequency[i]) * sinc(frequency[i]);  // both signs
    for (int k = 0; k <= reach; ++k) cosine(i, k) = weight * std::cos(2 * M_PI * k * frequency[i]);
  }
  for (Eigen::Index i = 0; i < count; ++i)
    for (Eigen::Index j = 0; j <= i; ++j) {
      const double nu = std::hypot(frequency[i], frequency[j]) / pitch;  // cycles / rad
      modulation(i, j) = modulation(j, i) =
          short_exposure_mtf(nu, wavelength_m, fried_m, diameter_m) * aperture_mtf(wavelength_m * nu / diameter_m);
    }
  return cosine.transpose() * modulation * cosine;
}

}  // namespace

PixelBlur::PixelBlur(const scene::Lidar& lidar, double fried_m) {
  const scene::LidarReceiver& receiver = lidar.receiver;
  if (!(fried_m > 0) || !lidar.turbulence.blur || receiver.columns * receiver.rows < 2 ||
      !(receiver.pixel_pitch_rad > 0) || !(receiver.aperture_radius_m > 0))
    return;
  const double wavelength_m = lidar.pulse.lines.front().wavelength_um * 1e-6;
  const double width =
      std::hypot(0.98 * wavelength_m / fried_m, 1.03 * wavelength_m / (2 * receiver.aperture_radius_m));
  // A spot of width w leaves about 2 w / (3 pitch) of an even pixel's light outside.
  if (width < 0.03 * receiver.pixel_pitch_rad) return;
  const int reach = std::clamp(static_cast<int>(std::ceil(3 * width / receiver.pixel_pitch_rad)), 1, kMostReach);
  const Eigen::MatrixXd shares = quadrant(lidar, fried_m, reach);
  double total = 0;
  for (int row = -reach; row <= reach; ++row)
    for (int column = -reach; column <= reach; ++column) {
      const int far = std::max(std::abs(column), std::abs(row)), near = std::min(std::abs(column), std::abs(row));
      share_.push_back(std::max(0.0, shares(far, near)));
      total += share_.back();
    }
  // What lies beyond the reach, or the frequencies left out, goes back in proportion: an even image stays as it is.
  for (double& share : share_) share /= total;
  reach_ = reach;
}

double PixelBlur::share(int columns, int rows) const {
  if (reach_ == 0) return columns == 0 && rows == 0 ? 1 : 0;
  if (std::abs(columns) > reach_ || std::abs(rows) > reach_) return 0;
  return share_[static_cast<std::size_t>((rows + reach_) * (2 * reach_ + 1) + columns + reach_)];
}

void PixelBlur::apply_to(std::vector<float>& rows, int columns, int lines_of_pixels, std::size_t per_pixel) const {
  if (rows.empty()) return;
  std::vector<double> sum(per_pixel);
  std::vector<float> out(rows.size());
  for (int y = 0; y < lines_of_pixels; ++y)
    for (int x = 0; x < columns; ++x) {
      std::fill(sum.begin(), sum.end(), 0.0);
      for (int v = std::max(0, y - reach_); v <= std::min(lines_of_pixels - 1, y + reach_); ++v)
        for (int u = std::max(0, x - reach_); u <= std::min(columns - 1, x + reach_); ++u) {
          const double weight = share(u - x, v - y);
          const float* from = rows.data() + static_cast<std::size_t>(v * columns + u) * per_pixel;
          for (std::size_t i = 0; i < per_pixel; ++i) sum[i] += weight * from[i];
        }
      std::transform(sum.begin(), sum.end(),
                     out.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(y * columns + x) * per_pixel),
                     [](double value) { return static_cast<float>(value); });
    }
  rows = std::move(out);
}

void PixelBlur::apply(const LidarPlan& plan, ShotResult& result) const {
  if (!any()) return;
  const int columns = plan.lidar.receiver.columns, rows = plan.lidar.receiver.rows;
  const auto per_pixel = static_cast<std::size_t>(plan.lines()) * static_cast<std::size_t>(plan.lidar.gate.bins);
  for (std::vector<float>* part : {&result.first, &result.multiple, &result.air, &result.particles})
    apply_to(*part, columns, rows, per_pixel);
}

}  // namespace raycube::lidar
