// What the readers of runs write samples into: one wavelength axis, one ground, one sun and sensor that all agree on.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "atmos_tables/import/run_samples.h"
#include "host/base/error.h"

namespace raycube::atmos::imported {

/// What a run can give to a table.
enum class Role {
  down,
  sky,
  sun,
  levels,
  solver,
  emission,
  channels,
  correction,
  bands,
  wavelength_table,
  columns,
  told,
  unused
};

struct Source {
  const Imported* file;
  const Run* run;
  Role role;
};

struct SampleBook {
  const TableRequest& request;
  Samples out;
  base::Problems problems;
  double ground_m = 0;  ///< of z = 0, in the heights of the runs
  /// Target height and -ln of the transmission from there straight up to the sensor, of runs that know the beam.
  std::vector<std::pair<double, Spectrum>> depths;

  /// Values in ascending order of wavelength: channels stand as in their filter file.
  static Spectrum sorted(const Run& run, const Spectrum& values);
  /// On the book's wavelengths, linear between those of the run; a run of one wavelength says the same at all.
  Spectrum on_grid(const Run& run, const Spectrum& values) const;
  Spectrum on_grid(const Run& run, const Column& column) const { return on_grid(run, column.values); }
  /// Empty where the run has no such column.
  Spectrum optional(const Run& run, const std::string& name) const;
  /// Nothing of an empty spectrum.
  void add(const std::string& row, const Sample& place, Spectrum values);

  /// Above z = 0; the ground where a run names no height.
  double ground(std::optional<double> height) const { return height.value_or(ground_m) - ground_m; }
  void agree(std::optional<double>& standing, std::optional<double> found, double tolerance, const char* what,
             const Source& source);
  /// Sun and sensor, which all runs of one table share.
  void sun_and_sensor(const Source& source);
};

/// A run of uvspec, levels by zout: of sunlight, or of emission, which comes after the runs that know transmissions.
void add_solver_samples(const Source& source, SampleBook& book);

}  // namespace raycube::atmos::imported
