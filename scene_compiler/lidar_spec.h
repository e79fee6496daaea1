// A LIDAR as a simulation file describes it: validated, every default filled in, in SI units (m, s, J, rad) unless a
// name says otherwise. Wavelengths are vacuum micrometres. Nothing here depends on the scene.
//
// Platform frame of a mount: x right wing, y forward, z up. The boresight of a mount without angles is -z (the nadir of
// a level platform). A positive tilt_along_rad turns it forwards (towards +y), a positive tilt_across_rad to the right
// (towards +x).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace raycube::scene {

enum class BeamProfile { gaussian, uniform };
enum class PulseShape { gaussian, rectangular, tabulated };

/// One laser wavelength. Several lines are fired by the same pulse number, as DIAL does; `separation_s` tells when.
struct LidarLine {
  std::string name;  ///< "on", "off", ...
  double wavelength_um = 1.064;
  double fwhm_um = 0;   ///< Gaussian line, full width at half maximum; 0: monochromatic
  double energy_J = 0;  ///< leaving the laser, before transmit_efficiency
};

struct LidarPulse {
  std::vector<LidarLine> lines;  ///< at least one
  double separation_s =
      0;  ///< between the lines of one shot; below the turbulence's correlation time they share its draw
  BeamProfile profile = BeamProfile::gaussian;
  double exit_radius_m = 0;        ///< 1/e2 radius (gaussian) or edge (uniform) at the exit
  double half_divergence_rad = 0;  ///< half angle at 1/e2 (gaussian) or of the edge (uniform)
  PulseShape shape = PulseShape::gaussian;
  double fwhm_s = 0;  ///< gaussian: full width at half maximum; rectangular: length; 0: an impulse
  std::vector<double> shape_time_s,
      shape_power;  ///< tabulated: power at times, linear between, >= 0; area 1; t = 0 as declared
  double transmit_efficiency = 1;
};

enum class ScanPattern { fixed, line, oscillating, rotating, palmer, raster };

/// Where pulse i points, about the mount's boresight. phase = scan_rate_hz * time, cycles.
///   fixed        0
///   line         across angle runs linearly from -half to +half each cycle, then jumps back
///   oscillating  across angle = half * sin(2 pi phase)
///   rotating     across angle = 360 deg * phase, kept where |angle| <= half (pulses outside are not fired)
///   palmer       constant angle half from the boresight, turning around it once a cycle (nutating cone)
///   raster       columns x rows directions row by row, spaced step_rad
struct LidarScan {
  ScanPattern pattern = ScanPattern::fixed;
  double scan_rate_hz = 0;
  double half_angle_rad = 0;
  int columns = 1, rows = 1;
  double step_rad = 0;
};

/// Platform at a time. Angles as in Pose (roll right wing down, pitch nose up, heading clockwise from north).
struct LidarPose {
  double time_s = 0;
  double x_m = 0, y_m = 0, z_m = 0;
  double roll_deg = 0, pitch_deg = 0, heading_deg = 0;
};

struct LidarMount {
  double offset_m[3] = {0, 0, 0};  ///< in the platform frame
  double tilt_along_rad = 0, tilt_across_rad = 0;
};

struct LidarReceiver {
  double aperture_radius_m = 0.05, obscuration_radius_m = 0;
  double half_fov_rad = 0;     ///< field stop (one pixel); 0 with an array
  int columns = 1, rows = 1;   ///< pixels of an array, rectangular, side pitch / focal length
  double pixel_pitch_rad = 0;  ///< of an array
  double focal_length_m = 0;   ///< 0: not given (needed by tangent_aperture alone)
  double focus_m = 0;          ///< distance in focus; 0: infinity
  double efficiency = 1;       ///< optics between aperture and detector
  double quantum_efficiency = 1;
  double filter_fwhm_um = 0.001;  ///< passband for background light
  bool tangent_aperture =
      false;  ///< collect A_r/(R^2 (1 + 1/(4F^2)))-like as a thin camera: pi/(1 + 4F^2) instead of pi/(4F^2)
  bool scans_with_beam = true;  ///< the field follows the scan
};

struct LidarGate {
  double start_s = 0;  ///< of the first bin, after emission (centre of the pulse)
  double bin_s = 1e-9;
  int bins = 1000;
};

/// Where rays start. transmitter: equal-energy sub-rays of the beam. receiver: samples of a pixel's field, for flash
/// arrays.
enum class LidarSampling { transmitter, receiver };
/// off: 1; circle: hard circle against the beam, a debugging aid; exact: vignetting of every hit.
enum class LidarOverlap { off, exact };

struct LidarTransport {
  LidarSampling sampling = LidarSampling::transmitter;
  int subrays = 256;           ///< per pulse (transmitter) or per pixel (receiver)
  bool subrays_given = false;  ///< by the file; otherwise the planner chooses them (host/planner)
  int max_bounces = 1;         ///< surface or volume scatterings a path may have
  int line_nodes = 32;         ///< Gauss-Hermite nodes of a line with a width; 1 for a monochromatic one
  double group_index = 1;      ///< time = group_index * path / c
  LidarOverlap overlap = LidarOverlap::exact;
  bool air_return = true;        ///< elastic return of the air
  double minimum_range_m = 0.1;  ///< hits nearer are counted, not recorded
  double range_limit_m = 0;      ///< rays end here; 0: no limit
};

enum class TurbulenceProfile { none, constant, hufnagel_valley };
struct LidarTurbulence {
  TurbulenceProfile profile = TurbulenceProfile::none;
  double cn2 = 0;                              ///< m^-2/3, constant
  double wind_m_s = 21, ground_cn2 = 1.7e-14;  ///< Hufnagel-Valley v and A
  std::optional<double> ground_z_m;            ///< scene z that Hufnagel-Valley heights count from; none: the ground
                                               ///< below each place of the path
  bool spread = true, wander = true, scintillation = true, blur = true, broadening = true;
  double outer_scale_m = 1;     ///< temporal broadening alone
  bool andrews_wander = false;  ///< 2.42 Cn2 L^3 w^-1/3 (two axes) instead of the first-order Gaussian weight
};

struct LidarSpeckle {
  bool on = false;
  double polarization_modes = 2;  ///< 2 for targets that depolarise, 1 for those that do not
};

enum class DetectorMode { photons, linear, geiger };
struct LidarDetector {
  DetectorMode mode = DetectorMode::photons;  ///< photons: Poisson counts of photo-electrons
  double dark_rate_hz = 0;
  bool solar_background = true;
  double gain = 1, ionization_ratio = 0;  ///< linear: APD gain M and k of F = k M + (1 - k)(2 - 1/M)
  double readout_noise_e = 0;             ///< rms electrons per bin after gain
  double response_fwhm_s = 0;             ///< impulse response of the electronics, Gaussian
  int bits = 16;                          ///< of the digitiser
  double full_scale_e = 0;                ///< primary photo-electrons at full scale; 0: by the largest expected signal
  double dead_time_s = 0;                 ///< geiger; 0: one photon per gate
  double jitter_fwhm_s = 0;               ///< geiger
  double afterpulse_probability = 0, afterpulse_time_s = 1e-7;
  int cells = 1;  ///< parallel Geiger cells per pixel (hybrid photon counting)
};

enum class EchoMethod { peak, constant_fraction, gaussian };
struct LidarEchoes {
  EchoMethod method = EchoMethod::gaussian;
  double threshold_sigma = 4;      ///< above the noise, where false_returns is 0
  double false_returns = 0;        ///< of a record by chance, at most; > 0: thresholds come from it instead
  bool air_is_background = false;  ///< the expected return of air and particles is subtracted, its noise in the
                                   ///< threshold
  double noise_class_above = 0;    ///< returns that chance makes more often are LAS class 7; 0: none
  double threshold_pe = 1;         ///< and at least so many photo-electrons in the peak bin
  double fraction = 0.5;           ///< constant fraction
  int max_returns = 15;
};

/// none: expectations alone are written; products: draws are made from stored expectations or during the run, with the
/// same numbers.
struct LidarProducts {
  bool waveforms = true, cube = true, las = true, csv = true, png = true;
  bool laz = false;                 ///< the points of the LAS file, compressed
  bool internal_waveforms = false;  ///< LAS packets inside the .las file instead of a .wdp
  bool orders = false;              ///< keep single, multiple and air apart in the cube
};

struct Lidar {
  std::string name;
  std::vector<LidarPose> trajectory;  ///< ascending times; one pose: a platform at rest
  double prf_hz = 1000;
  std::int64_t pulses = 1;
  int strip = 1;                ///< number of the flight line
  double first_pulse_s = 0;     ///< time of pulse 0 on the trajectory's clock
  double gps_start_s = 0;       ///< added to pulse times in LAS: adjusted standard GPS time
  bool fold_ambiguous = false;  ///< returns of earlier pulses join the gate they arrive in
  LidarScan scan;
  LidarMount transmitter, receiver_mount;
  LidarPulse pulse;
  LidarReceiver receiver;
  LidarGate gate;
  LidarTransport transport;
  LidarTurbulence turbulence;
  LidarSpeckle speckle;
  LidarDetector detector;
  LidarEchoes echoes;
  LidarProducts products;
};

}  // namespace raycube::scene
