// Differential absorption: gas columns from on-line and off-line returns (LIDAR specification, section 6). Columns one
// way, molecules / cm2; cross-sections cm2. Two-way transmission of a column C: exp(-2 sigma C).
#pragma once

#include <vector>

#include "host/lidar/detection.h"

namespace raycube::lidar {

/// A return's counts, background taken off, and their variance (without noise: 0).
struct NetCounts {
  double counts = 0, variance = 0;
  double photons = 1;  ///< fired, on any scale common to all lines
};

enum class DialState {
  good,
  /// nothing (or less than the noise) came back on the line: column_cm2 is what one standard deviation (at least one
  /// count) would mean, a lower bound
  saturated,
  no_signal  ///< nothing off the line either: no column
};

/// error_cm2: one standard deviation; 0 without noise. Never NaN.
struct DialColumn {
  double column_cm2 = 0, error_cm2 = 0;
  DialState state = DialState::no_signal;
};

/// C = ln[(N_off/E_off) / (N_on/E_on)] / (2 d_sigma), d_sigma = sigma_on - sigma_off > 0, line-effective. Relative
/// variances 1/N (from NetCounts) add up, with extra_variance: of the logarithm, such as 2/M for independent speckle.
DialColumn dial_column(const NetCounts& on, const NetCounts& off, double d_sigma_cm2, double extra_variance = 0);

/// A laser line by nodes: weights (sum 1) and cross-sections. Mean of exp(-2 sigma C), after the exponential.
struct LineSection {
  std::vector<double> weight, sigma_cm2;
  double transmission(double column_cm2) const;  ///< two-way
  double mean_sigma_cm2() const;                 ///< weighted: the effective one of thin columns
};
/// The column whose line-averaged transmissions on and off have the returns' ratio: no bias by the line's width. Up to
/// 1e24 / cm2.
DialColumn dial_column_of_line(const NetCounts& on, const NetCounts& off, const LineSection& on_line,
                               const LineSection& off_line, double extra_variance = 0);

/// Columns of several gases from returns at several wavelengths, by weighted least squares on ln(N/E) = a - 2 sum_g
/// sigma C_g (a: unknown common factor); sigma_cm2 is [wavelength][gas], at least gases + 1 wavelengths. Wavelengths
/// without counts are left out.
struct DialGases {
  std::vector<double> column_cm2, error_cm2;  ///< [gas]; empty when state is not good
  DialState state = DialState::no_signal;
};
DialGases dial_gases(const std::vector<NetCounts>& returns, const std::vector<std::vector<double>>& sigma_cm2);

/// Number density between bins R and R + dR, molecules / cm3: ln[N_off(R+dR) N_on(R) / (N_on(R+dR) N_off(R))] / (2
/// d_sigma dR), dR = bins_apart bins of bin_m. column_cm2 and error_cm2 of the entries are per cm3 here; as many
/// entries as bins - bins_apart.
std::vector<DialColumn> dial_profile(const std::vector<NetCounts>& on, const std::vector<NetCounts>& off,
                                     double d_sigma_cm2, double bin_m, int bins_apart);

/// A line's nodes with a volume's cross-sections, as the plan has them.
LineSection line_section(const LidarPlan& plan, int volume, int line);

/// The echo with the most photo-electrons; none: null.
const Echo* strongest_echo(const Detection& record);

/// Photo-electrons of a record's return about a time (the strongest echo's of the off-line record, as a rule): sum over
/// +- 3 recorded standard deviations less the background; variance with the detector's excess noise and readout.
NetCounts net_counts(const LidarPlan& plan, const Detection& record, double time_s);

}  // namespace raycube::lidar
