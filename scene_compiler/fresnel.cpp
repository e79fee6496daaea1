#include "scene_compiler/fresnel.h"

#include <cmath>
#include <complex>

namespace raycube::scene {

namespace {

constexpr int kAngles = 400;  ///< of the fit, even in the cosine

double third(double c) { return c * std::pow(1 - c, 8); }
double fourth(double c) { return c * std::pow(1 - c, 3); }

}  // namespace

double fresnel_mirrored(double n, double k, double cosine) {
  const std::complex<double> index(n, k);
  const std::complex<double> inside = std::sqrt(1.0 - (1 - cosine * cosine) / (index * index));
  const std::complex<double> across = (cosine - index * inside) / (cosine + index * inside),
                             along = (index * cosine - inside) / (index * cosine + inside);
  return 0.5 * (std::norm(across) + std::norm(along));
}

std::array<double, 4> fresnel_factors(double n, double k) {
  const double f0 = fresnel_mirrored(n, k, 1);
  double aa = 0, ab = 0, bb = 0, ar = 0, br = 0;
  for (int i = 0; i < kAngles; ++i) {
    const double c = (i + 0.5) / kAngles, s = std::pow(1 - c, 5);
    const double rest = fresnel_mirrored(n, k, c) - (f0 * (1 - s) + s), a = third(c), b = fourth(c);
    aa += a * a, ab += a * b, bb += b * b, ar += a * rest, br += b * rest;
  }
  const double over = 1 / (aa * bb - ab * ab);
  return {f0, 1, over * (bb * ar - ab * br), over * (aa * br - ab * ar)};
}

}  // namespace raycube::scene
