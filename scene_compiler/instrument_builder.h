// [[instrument]] entries: scale, poses, bands, sampling.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "scene_compiler/document.h"
#include "scene_compiler/scene_builder.h"
#include "scene_compiler/simulation.h"

namespace raycube::scene {

/// Every instrument, checked; heights above ground come from the terrains of `parts` (0 off them).
std::vector<Instrument> read_instruments(const Record& root, const SceneParts& parts, std::vector<std::string>& notices,
                                         base::Problems& problems);

/// Where an instrument's boresight goes, in place of pitch and roll.
struct Aim {
  bool at_point = false;
  std::array<double, 3> point_m{};  ///< that it meets
  std::optional<double> off_nadir_deg;
  double azimuth_deg = 0;  ///< way in which it looks, where off_nadir_deg is given; clockwise from north

  /// Whether the instrument's place follows too.
  bool places() const { return at_point && off_nadir_deg.has_value(); }
  /// Places it so high above the point.
  void place(double height_m, Pose& pose) const;
  /// Turns it: pitch and roll for its heading, or the heading as well. False: it would not look down.
  bool turn(bool heading_too, Pose& pose) const;
};

/// Poses of a straight flight at constant height along heading_deg, the middle of the image at `middle`.
/// Pushbroom: one per line, line_spacing_m apart, line 0 flown first. Whiskbroom: one per pixel; within a
/// line the platform moves on, one line spacing per line, evenly over the samples.
std::vector<Pose> straight_flight(InstrumentKind kind, int lines, int pixels, const Pose& middle,
                                  double line_spacing_m);

/// One pose per pixel from one per line, linear in time (angles the short way), extrapolated over the outer
/// half lines. A single line is held.
std::vector<Pose> poses_per_pixel(const std::vector<Pose>& per_line, int pixels);

}  // namespace raycube::scene
