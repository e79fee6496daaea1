// Optics of a user's own spheres, by Mie's series: a size distribution and a refractive index against wavelength.
#pragma once

#include <deque>
#include <memory>
#include <mutex>
#include <vector>

#include "atmos_tables/aerosol/particle_optics.h"
#include "atmos_tables/optics/size_distribution.h"

namespace raycube::atmos {

struct DropletModel {
  /// n(r) ~ r^alpha exp(-b r^gamma), r in um (Deirmendjian 1969; cloud C.1: 6, 1.5, 1; haze L: 2, 15.1186, 0.5).
  double alpha = 6, b = 1.5, gamma = 1;
  struct Index {
    double wavelength_um, n, k;  ///< n + i k, k >= 0 absorbs
  };
  std::vector<Index> index;  ///< wavelengths ascend and reach over 0.55 um; raycube ships no table of indices
  std::vector<LogNormalMode> modes = {};  ///< where there are any, in place of alpha, b and gamma
};

/// Mie's series is summed at each wavelength of the index table; between them extinction follows a power law, albedo
/// and asymmetry are linear, and phase functions are mixed. A wavelength's sum is made when it is first asked for:
/// about a second for cloud C.1 in the visible.
class DropletOptics : public ParticleOptics {
 public:
  /// Throws Error(input) that lists every bad figure.
  explicit DropletOptics(const DropletModel& model);

  /// Extinction over that at 0.55 um. Throws Error(input) outside the index table, and where spheres are too large for
  /// the wavelength (sphere_cloud.h).
  SubstanceOptics at(double wavelength_um) const override;
  PhaseFunction phase(double wavelength_um) const override;
  std::pair<double, double> covers_um() const override;

 private:
  struct Node {
    DropletModel::Index index;
    mutable std::once_flag summed = {};
    mutable SubstanceOptics optics = {};
    mutable std::shared_ptr<const PhaseShape> shape = {};
  };
  struct Place {
    const Node *low, *high;
    double linear, logarithmic;  ///< shares of the higher node
  };
  Place place(double wavelength_um) const;
  const Node& summed(const Node& node) const;

  SizeDistribution sizes_;
  double unit_um2_ = 1;     ///< extinction at 0.55 um
  std::deque<Node> nodes_;  ///< never moved: a flag cannot be
};

}  // namespace raycube::atmos
