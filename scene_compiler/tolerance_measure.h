// What the tolerance is of: which figure of the pixels' errors, and which materials count.
#pragma once

#include <string>
#include <vector>

namespace raycube::scene {

/// Of |L - L_ref| over a band's mean L, over the pixels; the worst band counts. p99: the least error that 99 % of the
/// pixels do not exceed.
enum class ErrorFigure { rms, p99, worst };

struct ToleranceMeasure {
  ErrorFigure figure = ErrorFigure::rms;
  /// Names; each pixel counts by the share of it that they cover, in the figure and in the band's mean. Empty: all
  /// pixels count alike.
  std::vector<std::string> materials;

  /// The rms over all pixels, as DESIGN 5a has it.
  bool plain() const { return figure == ErrorFigure::rms && materials.empty(); }
  bool operator==(const ToleranceMeasure&) const = default;
};

/// As the simulation's file names it: rms, p99, worst.
const char* figure_name(ErrorFigure figure);
/// Throws std::invalid_argument on any other name.
ErrorFigure figure_named(const std::string& name);

/// "rms over pixels", "99th percentile over pixels of grass, panel".
std::string measure_text(const ToleranceMeasure& measure);

}  // namespace raycube::scene
