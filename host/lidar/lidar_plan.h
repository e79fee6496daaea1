// All that device and reference need of a LIDAR besides the scene: spectral nodes, air, matter at the laser's lines,
// sub-rays.
//
// What a path brings (units: photons at the detector, quantum efficiency not included), for one line:
//   transmitter sampling, sub-ray k of N, scattering vertex P with distances: w f_r cos(theta_r) A_r cos(psi) eta(P) /
//   R^2 E_rx T
//     w     photons / N, times what each vertex before left (rho of a cosine-sampled diffuse surface, tau of a plate,
//     ...) psi   off the pupil's axis; eta: share of the pupil that sees P inside the field stop (overlap.h); R: P to
//     pupil
//   receiver sampling, sample k of N of a pixel's field Omega:    w f_r cos(theta_t) F(P) T,   w = A_r cos(psi) Omega /
//   N E_rx
//     F     photons / m2 of the beam at P across its axis (cos(theta_t): angle between normal and the way to the exit,
//     over the cosine of that
//           way with the axis, so that both samplings agree off the axis); Omega: pitch^2 cos^3(psi), pixels lying on a
//           plane of tangents
//   T = sum over the line's nodes of weight exp(-depth along the whole path), after the exponential, never before.
// Time: group_index (sum of all segments) / c. Path of the first vertex starts at the exit, the last ends at the pupil.
#pragma once

#include <cstdint>
#include <vector>

#include "host/lidar/shot.h"
#include "scene_compiler/compiled_scene.h"
#include "scene_compiler/lidar_spec.h"

namespace raycube::lidar {

/// One wavelength inside a line. Weights of a line sum to 1.
struct SpectralNode {
  int line = 0;
  double wavelength_um = 0, weight = 1;
};

/// Air over height, evenly spaced posts z0_m + i dz_m, scene frame; outside: the end's extinction goes on below,
/// nothing above.
struct AirColumn {
  double z0_m = 0, dz_m = 1;
  int posts = 0;              ///< 0: no air
  std::vector<double> depth;  ///< [node][post], extinction depth from post 0 up to a post, rising; linear between
  std::vector<double> backscatter_per_m_sr;  ///< [line][post], molecules and aerosol; linear between
};

/// Optical matter of a material at a line.
struct Matter {
  double reflectance = 0, transmittance = 0;
  double mirrored = 0;  ///< by its gloss, at normal incidence
  /// Where the material has further lobes: the first's part of what is reflected, the first's of what is mirrored, then
  /// each further one's; else empty, and both are 1 (pulse_lobes.h).
  std::vector<double> lobe{};
};

/// The pulse's shape as shares of bins: a hit at bin position p = j + f (j integer, 0 <= f < 1; position 0 = start of
/// bin 0) adds e * share[round-down phase, linear between phases][i] to bin j + first + i. Shares of a phase sum to 1.
/// phase q stands for f = q / phases.
struct PulseTaps {
  int phases = 0, taps = 0, first = 0;
  std::vector<float> share;  ///< [phases + 1][taps]
};

/// Sub-rays of a footprint, equal energy, about the axis, in units of the 1/e2 radius (gaussian) or of the edge
/// (uniform): a sub-ray's direction is axis + tan(half divergence) (a u + b v). Sorted so that runs of 16 are compact.
/// receiver sampling: a, b in -0.5 .. 0.5 of the pixel's sides.
struct Footprint {
  std::vector<float> a, b;
  std::vector<float> exit_a,
      exit_b;  ///< same length, where a sub-ray leaves, in units of the exit radius; empty: all from one point
};

struct LidarPlan {
  scene::Lidar lidar;
  std::uint64_t seed = 0;
  std::vector<SpectralNode> nodes;  ///< line by line
  std::vector<int> first_node;      ///< of each line, and the total at the end
  std::vector<double> photons;      ///< leaving the transmitter, of each line
  AirColumn air;
  std::vector<Matter> matter;             ///< [material][line], averaged over the line's nodes
  std::vector<double> cross_section_cm2;  ///< [volume][node]; 0 without gas
  PulseTaps taps;
  Footprint footprint;
  double sensor_low_m = 0, sensor_high_m = 0;  ///< heights of the exits
  /// Of expected waveforms by their sub-rays, a share of them (rms over bins; nearly every pulse's is less): what echo
  /// finders do not take for echoes. 0: not known.
  double waveform_error = 0;

  int lines() const { return static_cast<int>(photons.size()); }
  int pixels() const { return lidar.receiver.columns * lidar.receiver.rows; }
};

/// Number that random draws of a shot's pixel are keyed by: the low 32 bits of pulse * pixels + pixel (transmitter
/// sampling: pixel 0).
inline std::uint32_t draw_key(const LidarPlan& plan, std::int64_t pulse, int pixel) {
  return static_cast<std::uint32_t>(static_cast<std::uint64_t>(pulse) * static_cast<std::uint64_t>(plan.pixels()) +
                                    static_cast<std::uint64_t>(pixel));
}

/// Where the light of a shot went, as shares of the photons emitted by a line (each line has its own).
/// (receiver sampling: as shares of what is followed backwards from the pixels.) Light scattered at vertex max_bounces
/// counts as truncated. near: vertices nearer to the pupil than minimum_range.
/// Transport: emitted = absorbed + air + volumes + escaped + truncated. Of what scattered towards the pupil: bins +
/// early + late + near = collected.
struct Ledger {
  double absorbed = 0;                   ///< by surfaces
  double air = 0;                        ///< taken by air on the ways of rays (not of connections)
  double volumes = 0;                    ///< absorbed by volumes on the ways of rays
  double escaped = 0;                    ///< rays that left the scene, or scattered light after its last vertex
  double truncated = 0;                  ///< still scattering at max_bounces
  double collected = 0;                  ///< photons that reached the detector at any time, over the emitted
  double early = 0, late = 0, near = 0;  ///< of these: before the gate, after it, nearer than minimum_range
  double emitted_error() const { return absorbed + air + volumes + escaped + truncated - 1.0; }
};

/// What a sub-ray's first surface was, for truth and `check`.
struct FirstHit {
  std::uint32_t instance = 0xFFFFFFFFu, primitive = 0xFFFFFFFFu;
};

/// Expectations of one shot. Rows are [pixel][line][bin], photons at the detector.
struct ShotResult {
  Shot shot;
  std::vector<float> first;      ///< once scattered, surfaces and volumes
  std::vector<float> multiple;   ///< more than once; empty when max_bounces is 1
  std::vector<float> air;        ///< empty when air_return is off
  std::vector<float> particles;  ///< of `first`, what particles in volumes scattered; empty: there are no volumes
  std::vector<double>
      background_hz;           ///< [pixel][line], photons / s at the detector from the passive scene; empty: none
  std::vector<Ledger> ledger;  ///< [line]
  std::vector<FirstHit> hits;  ///< [sub-ray] (transmitter), [pixel][sample] (receiver); empty unless asked for
  /// A pulse fired so many pulses before this one (negative: after it) part of whose light is in this one's rows.
  struct Other {
    std::int64_t pulses_back = 0;
    Shot shot;
    std::vector<FirstHit> hits;
  };
  std::vector<Other> others;  ///< empty unless hits are asked for
  std::int64_t rays = 0;
};

}  // namespace raycube::lidar
