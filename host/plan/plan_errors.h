// What each level of the plan would cost in radiance: errors per band, relative to the band's scene-typical radiance.
#pragma once

#include "host/plan/band_space.h"
#include "host/plan/node_choice.h"
#include "host/plan/sky_factors.h"
#include "host/plan/sources.h"

namespace raycube::plan {

/// Thermal light of a typical surface, on the table's wavelengths; empty where thermal light is off.
struct TypicalThermal {
  Spectrum planck;          ///< of the surroundings' temperature
  Spectrum sky_irradiance;  ///< horizontal, at mid height
};

/// Typical radiance of each band: the mean of the used curves, horizontal, in full sun and sky at mid height and mid
/// view, its emission and reflected thermal sky, plus path radiance; bands below 1e-4 of the largest are judged against
/// that floor (DESIGN 5a).
std::vector<double> typical_radiance(const TableSpectra& air, const Domain& domain, const BandSpace& bands,
                                     const Spectrum& sky_irradiance, const TypicalThermal& thermal);

/// Largest share of a band's typical radiance that sun, sky and light of the ground around make by the reflectances of
/// `brightest`.
struct SolarShare {
  double sun = 0, sky = 0, environment = 0;
};
SolarShare solar_share(const TableSpectra& air, const Domain& domain, const BandSpace& brightest,
                       const Spectrum& sky_irradiance, const std::vector<double>& typical);

/// Part of the typical radiance that reflected skylight is, per table wavelength: the radiance of the band around it.
Spectrum sky_importance(const TableSpectra& air, const Domain& domain, const BandSpace& bands,
                        const Spectrum& sky_irradiance, const std::vector<double>& typical, Sky sky = Sky::solar);

/// The sky with one number of components.
struct SkyLevel {
  SkyFactors factors;
  double error = 0;              ///< worst band: largest change any obstacle can see, over typical radiance
  double relative_error = 0;     ///< the same over the band's sky irradiance
  bool negative = false;         ///< drives some band's sky below zero somewhere: refused
  std::vector<Mixture> mixture;  ///< per band; zeros where the band has no sky
};
/// S_m / S_0 of every band, seen through the air and the mean reflectance.
std::vector<Mixture> band_mixtures(const SkySpectra& sky, const Spectrum& up, const BandSpace& bands);
SkyLevel judge_sky(SkyFactors factors, const TableSpectra& air, const Domain& domain, const BandSpace& bands,
                   const std::vector<double>& typical);

/// Errors of node counts; `sky_rank` is left to the caller.
NodeErrors estimate_node_errors(const TableSpectra& air, const Domain& domain, const BandSpace& bands,
                                const Spectrum& sky_irradiance, const std::vector<double>& typical,
                                const TypicalThermal& thermal);

/// Worst |integral of the sampled sky / diffuse_irradiance row - 1| over the bands; -1 when the table has no such row.
double diffuse_row_difference(const TableSpectra& air, const Domain& domain, const BandSpace& bands,
                              const Spectrum& sky_irradiance);

}  // namespace raycube::plan
