// Optics of the layers in one spectral bin, and the columns the solver is given for it.
#pragma once

#include <cstddef>
#include <vector>

#include "atmos_tables/compiler/air_stack.h"
#include "atmos_tables/solver/solution.h"

namespace raycube::atmos {

/// A bin of the table: the stretch of wavenumbers whose mean a wavelength node stands for.
struct SpectralBin {
  double wavelength_um = 0;  ///< the node
  double low_per_cm = 0, high_per_cm = 0;
};
/// Bins around wavelength nodes, bounded half way to the neighbours but at most 5 % away; the outer ones are
/// symmetrical. One node alone stands for 5 cm-1.
std::vector<SpectralBin> spectral_bins(const std::vector<double>& wavelength_um);

/// Layers from the ground up, as in AirStack.
class SpectralAir {
 public:
  /// resolved: vertical depths of the layers by gases resolved to lines at the node's wavelength; empty: none.
  SpectralAir(const AirStack& stack, const SpectralBin& bin, std::size_t k_terms,
              const std::vector<double>& resolved = {});

  const SpectralBin& bin() const { return bin_; }
  std::size_t terms() const { return k_.weight.size(); }
  double weight(std::size_t term) const { return k_.weight[term]; }

  /// Depth of what is additive: scattering, aerosol absorption, continua, resolved lines.
  double grey_depth(const std::vector<double>& path_factor) const;
  /// Rayleigh and aerosol extinction alone.
  double scatterers_depth(const std::vector<double>& path_factor) const;
  /// -ln of the mean transmission of gas lines, band model: not additive over paths.
  double line_depth(const std::vector<double>& path_factor) const;
  /// Scattering depth (vertical) above a level and the mean phase function there, for the sky's shape.
  double scattering_depth_above(std::size_t level) const;
  double mean_phase_above(std::size_t level, double cos_angle) const;
  /// Vertical depths of a layer: all that is additive, and the part of it that scatters.
  double layer_extinction(std::size_t layer) const;
  double layer_scattering(std::size_t layer) const { return scattering(layer); }

  /// The solver's column of one k-term: layers from the top down. beam_flux 0: no sun. emits: Planck radiance at the
  /// levels. It refers to this object.
  solver::Column column(std::size_t term, double beam_flux, double sun_zenith_deg, bool emits) const;
  /// Vertical depth between two levels of one k-term.
  double depth_between(std::size_t term, std::size_t low, std::size_t high) const;

 private:
  struct Layer {
    double rayleigh = 0, absorbed = 0;  ///< absorbed: continua, resolved lines
    std::vector<double> aerosol;        ///< extinction depth per component
  };
  double scattering(std::size_t layer) const;
  /// Phase functions of molecules and of every aerosol component at an angle; their mean in a layer.
  std::vector<double> substance_phases(double cos_angle) const;
  double layer_phase(std::size_t layer, const std::vector<double>& substance_phase) const;

  const AirStack& stack_;
  SpectralBin bin_;
  std::vector<Layer> layers_;
  std::vector<double> rayleigh_moments_;
  double depolarization_ = 0;
  std::vector<AerosolColumn::Optics> aerosol_;
  std::vector<std::vector<double>> aerosol_moments_;
  LayerGases::KTerms k_;
};

}  // namespace raycube::atmos
