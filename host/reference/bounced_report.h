// Light between surfaces of some pixels: the device's paths against the reference's, which are other ones, so that only
// sums may be compared.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace raycube::reference {

struct BouncedReport {
  /// Standard errors that a band's sums may lie apart: of 360 bands that are one draw each, once in five thousand runs.
  static constexpr double kApart = 5;

  std::uint64_t pixels = 0, paths = 0;  ///< paths: of the reference, all pixels together
  double skeleton_error = 0;            ///< relative, as the plan knows it: what the bands between may err by besides
  struct Band {
    double device = 0, reference = 0;  ///< means over the pixels, W m-2 sr-1 um-1
    double size = 0;                   ///< of the reference's paths, without regard to their sign
    double error = 0;                  ///< standard error of their difference
  };
  std::vector<Band> bands;  ///< empty: the plan has no light between surfaces

  /// How many standard errors a band lies apart, less what the skeleton may err by.
  double apart(const Band& band) const;
  std::size_t worst() const;  ///< band that lies apart most
  std::vector<std::string> failures() const;
  std::string text() const;  ///< one line; empty without bands
};

}  // namespace raycube::reference
