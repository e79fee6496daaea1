// The sun's spectrum above the air at 1 AU: shipped ones by name, 0.3 to 31 um, or a file's. Beyond, Planck's law of
// 5000 K.
//   tsis1  TSIS-1 hybrid spectrum (Coddington et al. 2021) from 0.35 to 2.5 um, Gueymard (2004) outside, scaled to
//          TSIS-1 at the joints; restated at 2 nm to 500 nm (data/solar_tsis1_gueymard.inc). The default.
//   e490   ASTM E-490-00a (2000) zero-air-mass spectrum, 1366.1 W m-2 in all; restated alike (data/solar_e490.inc).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "scene_compiler/simulation.h"

namespace raycube::atmos {

class SolarSpectrum {
 public:
  /// Of a file the nodes as they stand; outside its range the default spectrum times the one factor that meets it: the
  /// ratio of the two means over the 50 nm (or all) of the file next to that end. Throws Error(input) for a name that
  /// none of the shipped has and for a file that ends before 0.35 um or begins beyond 31 um.
  explicit SolarSpectrum(const scene::SolarSpectrumSpec& spec = {});

  static bool is_shipped(const std::string& name) { return name == "tsis1" || name == "e490"; }

  /// W m-2 um-1, linear between nodes; the wavelength (vacuum) must not lie below the first node (0.3 um or the
  /// file's).
  double irradiance_1au(double wavelength_um) const;
  /// Its mean over [from, to] um, exact for straight lines between nodes; what of it lies outside the nodes counts as
  /// the nearest end.
  double mean_1au(double from_um, double to_um) const;
  /// Distance of the nodes around a wavelength: what it resolves.
  double step_um(double wavelength_um) const;
  /// Whether a file's nodes lie on one line there, with those beside them: a spectrum that is meant so, flat or not, is
  /// not one whose lines are lost.
  bool straight(double wavelength_um) const;
  /// Name of the source and what it resolves, for a table's header.
  const std::string& source() const { return source_; }
  /// Whether it is a file's; the shipped ones are averages already, at the nodes of any table.
  bool is_file() const { return is_file_; }
  /// What a user should know of a table over this range: where the file ends and something else goes on.
  std::optional<std::string> notice(double first_um, double last_um) const;

 private:
  struct Node {
    double wavelength_nm, irradiance;
  };
  void join_file(const scene::SolarSpectrumSpec& spec);

  std::vector<Node> nodes_;
  std::string source_;
  bool is_file_ = false;
  double file_first_um_ = 0, file_last_um_ = 0, factor_below_ = 1, factor_beyond_ = 1;
};

}  // namespace raycube::atmos
