#include "host/lidar/scintillation.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "host/lidar/detector.h"
#include "host/lidar/incomplete_gamma.h"
#include "host/lidar/quadrature.h"

namespace raycube::lidar {

namespace {

constexpr std::size_t kRows = 37;
/// A at d = 10^(-2 + row / 8), plane and spherical wave: int int kappa^(-8/3) (1 - cos(phase)) [2 J1(x)/x]^2 over the
/// same without the filter, by Gauss-Legendre to 1e-6; the eleven values of the LIDAR specification's table 8.4 come
/// out to its last digit.
constexpr std::array<std::array<double, 2>, kRows> kAveraging{
    {{0.9684379, 0.9719814},    {0.960949, 0.9654419},     {0.951785, 0.9574809},      {0.9406092, 0.9478279},
     {0.9270328, 0.9361763},    {0.9106126, 0.9221837},    {0.8908527, 0.905477},      {0.8672115, 0.8856609},
     {0.8391166, 0.8623328},    {0.8059909, 0.8351055},    {0.7672945, 0.8036378},     {0.7225866, 0.7676753},
     {0.6716123, 0.7270987},    {0.6144169, 0.6819774},    {0.5514849, 0.6326211},     {0.4838929, 0.5796212},
     {0.413443, 0.5238667},     {0.342718, 0.4665248},     {0.2749623, 0.4089758},     {0.2136674, 0.3527018},
     {0.1617887, 0.299145},     {0.1207379, 0.2495584},    {0.08975265, 0.2048826},    {0.06654389, 0.1656758},
     {0.04904815, 0.1321071},   {0.03602319, 0.1040077},   {0.02637043, 0.08095789},   {0.01925231, 0.06238448},
     {0.01402234, 0.04764856},  {0.0101921, 0.03611278},   {0.007394842, 0.0271855},   {0.005356862, 0.02034479},
     {0.003875158, 0.01514721}, {0.002799852, 0.01122679}, {0.002020728, 0.008288268}, {0.001457, 0.006097686},
     {0.001049629, 0.004472385}}};
constexpr double kFirstD = 0.01, kRowsPerDecade = 8;

double averaging(std::size_t column, double asymptote, double d) {
  const auto log_row = [&](std::size_t i) { return std::log(kAveraging[i][column]); };
  // 1 - A is nearly a power of d where apertures are small.
  if (d < kFirstD) {
    const double power = std::log((1 - kAveraging[1][column]) / (1 - kAveraging[0][column])) * kRowsPerDecade / M_LN10;
    return 1 - (1 - kAveraging[0][column]) * std::pow(std::max(0.0, d) / kFirstD, power);
  }
  const double position = std::log10(d / kFirstD) * kRowsPerDecade;
  if (position >= kRows - 1) {
    // What is missing to the asymptote at the table's end fades as it does in the table's last decade, d^-0.3.
    const double last_d = kFirstD * std::pow(10, (kRows - 1) / kRowsPerDecade);
    const double missing = 1 - kAveraging[kRows - 1][column] / (asymptote * std::pow(last_d, -7.0 / 6));
    return asymptote * std::pow(d, -7.0 / 6) * (1 - missing * std::pow(last_d / d, 0.3));
  }
  // Cubic in the logarithms, slopes from the rows beside.
  const auto i = static_cast<std::size_t>(position);
  const double f = position - static_cast<double>(i), rise = log_row(i + 1) - log_row(i);
  const double p = i == 0 ? rise : 0.5 * (log_row(i + 1) - log_row(i - 1)),
               q = i + 2 == kRows ? rise : 0.5 * (log_row(i + 2) - log_row(i));
  return std::exp(log_row(i) + f * (p + f * ((3 * rise - 2 * p - q) + f * (p + q - 2 * rise))));
}

GammaGamma gamma_gamma(double s, double large) {
  const double s12 = std::pow(s, 1.2);
  return {1 / std::expm1(0.49 * s / std::pow(1 + large * s12, 7.0 / 6)),
          1 / std::expm1(0.51 * s / std::pow(1 + 0.69 * s12, 5.0 / 6))};
}

}  // namespace

GammaGamma gamma_gamma_plane(double rytov_variance) { return gamma_gamma(rytov_variance, 1.11); }

GammaGamma gamma_gamma_spherical(double rytov_variance) { return gamma_gamma(rytov_variance, 0.56); }

GammaGamma with_index(const GammaGamma& shape, double scintillation_index) {
  // Index x (1/alpha + 1/beta) + x^2 / (alpha beta) for parameters divided by x.
  const double sum = 1 / shape.alpha + 1 / shape.beta, product = 1 / (shape.alpha * shape.beta);
  const double x = 2 * scintillation_index / (sum + std::sqrt(sum * sum + 4 * product * scintillation_index));
  return {shape.alpha / x, shape.beta / x};
}

double log_normal_below(double level, double scintillation_index) {
  const double s2 = std::log1p(scintillation_index);
  return normal_tail(-(std::log(level) + 0.5 * s2) / std::sqrt(s2));
}

double gamma_gamma_below(double level, const GammaGamma& g) {
  // Mean over the large-scale variate x of P(small-scale variate < level / x), in t = log x about the density's peak (t
  // = 0).
  const double wide = 10 / std::sqrt(g.alpha) + (g.alpha < 2 ? 40 : 0), high = std::min(wide, 8.0);
  return integrate(
      [&](double t) {
        const double x = std::exp(t),
                     density = std::exp(g.alpha * std::log(g.alpha * x) - g.alpha * x - log_gamma(g.alpha));
        return density * gamma_p(g.beta, g.beta * level / x);
      },
      -wide, high, 24);
}

double aperture_averaging_plane(double d) { return averaging(0, 0.933, d); }

double aperture_averaging_spherical(double d) { return averaging(1, 4.675, d); }

double draw_irradiance(Stream& stream, double scintillation_index, const GammaGamma* gamma_gamma) {
  if (!(scintillation_index > 0)) return 1;
  if (gamma_gamma) {
    const double large = stream.gamma(gamma_gamma->alpha) / gamma_gamma->alpha;
    return large * stream.gamma(gamma_gamma->beta) / gamma_gamma->beta;
  }
  const double s2 = std::log1p(scintillation_index);
  return std::exp(std::sqrt(s2) * stream.normal() - 0.5 * s2);
}

}  // namespace raycube::lidar
