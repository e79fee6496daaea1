// Blur of a flash array's image by diffraction and, within one short pulse, by turbulence (LIDAR specification, 8.6).
#pragma once

#include <vector>

#include "host/lidar/lidar_plan.h"

namespace raycube::lidar {

/// Share of a pixel's light that reaches the pixels beside it: the short-exposure modulation of turbulence times that
/// of a clear circular aperture, light even over the pixel it comes from. What motion adds is the shot's tilt.
class PixelBlur {
 public:
  /// fried_m: of the image (TurbulenceTruth::fried_m); 0: no turbulence, the image stays as it is. Also where less than
  /// 2 % of the light would leave a pixel, where there is one pixel, or where the file asks for no blur.
  PixelBlur(const scene::Lidar& lidar, double fried_m);

  bool any() const { return reach_ > 0; }
  int reach() const { return reach_; }        ///< pixels to either side
  double share(int columns, int rows) const;  ///< of the pixel so many columns and rows away; 0 beyond the reach

  /// Every row of expectations, line by line and bin by bin; background light, which varies slowly over pixels, stays.
  /// Light blurred over the array's edge is lost; what would come in from outside is not there, so that a rim as wide
  /// as the blur is too dark.
  void apply(const LidarPlan& plan, ShotResult& result) const;

 private:
  void apply_to(std::vector<float>& rows, int columns, int lines_of_pixels, std::size_t per_pixel) const;
  int reach_ = 0;
  std::vector<double> share_;  ///< [row][column], 2 reach + 1 each
};

}  // namespace raycube::lidar
