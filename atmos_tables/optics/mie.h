// Light scattered by one homogeneous sphere: Mie's series. Bohren & Huffman (1983), "Absorption and Scattering of Light
// by Small Particles", chapter 4 (their sign: fields go as exp(-i omega t), so a refractive index n + i k with k >= 0
// absorbs); recurrences after Wiscombe (1980), Appl. Opt. 19, 1505-1509.
#pragma once

#include <complex>
#include <cstddef>
#include <vector>

namespace raycube::atmos {

inline constexpr double kMinSizeParameter = 1e-6, kMaxSizeParameter = 2e5;

/// Per geometric cross-section pi r^2. extinction = scattering + absorption exactly: both parts are sums of squares, so
/// neither loses digits for weak absorption or small spheres. backscatter: 4 pi times the differential cross-section at
/// 180 degrees (radar's convention, Bohren & Huffman eq. 4.82). asymmetry: mean cosine of the scattering angle.
struct MieEfficiencies {
  double extinction = 0, scattering = 0, absorption = 0, backscatter = 0, asymmetry = 0;
};

/// The expansion coefficients of a sphere. a[i] and b[i] belong to order i + 1.
class MieSphere {
 public:
  /// size_parameter: 2 pi radius / wavelength in the medium, 1e-6..2e5. index: n + i k relative to the medium, n > 0, k
  /// >= 0, |index - 1| >= 1e-6 and |index| size_parameter <= 1e7. Throws Error(input) outside.
  MieSphere(double size_parameter, std::complex<double> index);

  double size_parameter() const { return size_parameter_; }
  std::size_t terms() const { return a_.size(); }
  const std::vector<std::complex<double>>& a() const { return a_; }
  const std::vector<std::complex<double>>& b() const { return b_; }
  const MieEfficiencies& efficiencies() const { return efficiencies_; }

 private:
  double size_parameter_;
  std::vector<std::complex<double>> a_, b_;
  MieEfficiencies efficiencies_;
};

/// Terms that are summed: x + 7 x^(1/3) + 3. Coefficients fall like exp(-(4/3) (2^(1/3) c)^(3/2)) at order x + c
/// x^(1/3): Wiscombe's c = 4 leaves 3e-7, which shows in the light at 180 degrees; c = 7 leaves 1e-15.
std::size_t mie_terms(double size_parameter);

}  // namespace raycube::atmos
