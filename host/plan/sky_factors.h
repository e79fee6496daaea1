// The sky as a few spectra times angular maps (DESIGN section 1): L_sky(l, w) = E_sky(l) sum_m c_m(l) A_m(w), from a
// weighted singular value decomposition of L_sky / E_sky. c_0 = 1, and only A_0 carries irradiance.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <vector>

#include "host/plan/sky_basis.h"
#include "host/plan/table_spectra.h"

namespace raycube::plan {

inline constexpr int kMaxSkyComponents = 4;

/// Component spectra at one height, W m-2 um-1: L_sky(l, w) ~ sum_m spectrum[m][l] A_m(w), spectrum[0] = E_sky.
using SkySpectra = std::array<Spectrum, kMaxSkyComponents>;

/// How a band mixes the components: S_m / S_0.
using Mixture = std::array<double, kMaxSkyComponents>;

struct SkyFactors {
  SkyBasis basis;
  int rank = 0;  ///< components, 0 (black) .. 4; fewer than asked for when the sky has no more
  /// Per table wavelength: half of integral |L - L_rank| cos dOmega over E_sky. As the difference carries no
  /// irradiance, this is the largest error that any obstacle over a horizontal surface can cause, in units of E_sky.
  Spectrum occluder_error;
  std::vector<bool> mean_shape;  ///< per table wavelength: the sky there matters so little that its shape is A_0
  SkySpectra spectra;            ///< at the height of the decomposition
  Sky sky = Sky::solar;
};

/// The sky of one height, sampled once, to be factored with any number of components.
class SkyFactorizer {
 public:
  /// threads: to sample it; 0: as many as the machine has.
  SkyFactorizer(const TableSpectra& table, double height_m, double sun_zenith_rad, Sky sky = Sky::solar,
                int threads = 0);
  ~SkyFactorizer();
  bool black() const;
  const Spectrum& irradiance()
      const;  ///< horizontal, W m-2 um-1: the table's flux where it knows that of its sky, else as sampled
  const Spectrum& sampled_irradiance() const;  ///< the same by the sampled sky alone

  /// Maps for `rank` components that keep the largest occluder_error times `importance` (per table wavelength) small:
  /// the decomposition is repeated with wavelengths reweighted by their errors (Lawson 1961). Where a band's sum would
  /// fall below zero (mostly at the horizon of saturated bands), maps 1.. are pulled towards zero at that node until it
  /// does not. mixtures: S_m / S_0 of every band.
  SkyFactors factor(int rank, const Spectrum& importance,
                    const std::function<std::vector<Mixture>(const SkySpectra&)>& mixtures) const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

/// Weighted least-squares spectra of the sky at another height on the maps already chosen. flux_scale: set to what
/// sky_flux_scale makes of the same samples, where the factors are of a solar sky that is not black.
SkySpectra sky_spectra(const SkyFactors& factors, const TableSpectra& table, double height_m,
                       Spectrum* flux_scale = nullptr, int threads = 0);

/// More than interpolation and quadrature leave between the sampled sky and the table's flux of it (0.3 % at 48 degrees
/// and 0.41 um, 1.5 % with the sun in the horizon): rows that contradict each other, or a sky on too coarse a grid,
/// which is told.
inline constexpr double kAnotherSky = 0.05;

/// What the sampled sky is multiplied by so that it carries the table's own flux: flux over sampled irradiance, at most
/// 2 and at least a half; 1 where either is 0.
double same_sky_scale(double sampled, double flux);

/// That factor per table wavelength at one height, the sky sampled as SkyFactorizer does; 1 where the table knows no
/// such flux.
Spectrum sky_flux_scale(const TableSpectra& table, double height_m, double sun_zenith_rad, int threads = 0);

/// Horizontal irradiance of the sky with the table's own nodes as quadrature: cheap, used to see how it changes with
/// height.
Spectrum coarse_sky_irradiance(const TableSpectra& table, double height_m, Sky sky = Sky::solar);

}  // namespace raycube::plan
