// Point clouds as LAS 1.4 (revision 16): point format 6, or 9 with the waveforms the points were found in. Points and
// packets go to disk as they come; memory does not depend on their number.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "host/base/output_file.h"

namespace raycube::products {

/// What a point format has no room for, most of it known to the simulation alone: extra bytes of every point.
struct LasTruth {
  static constexpr std::uint32_t kNoObject = 0xFFFFFFFFu;
  static constexpr std::uint16_t kNoMaterial = 0xFFFFu;
  std::uint64_t pulse_id = 0;       ///< GPS time resolves 60 ns only (double at 4.5e8 s): this tells pulses apart
  double range_m = 0;               ///< measured: c/2 times delay, over the group index
  double range_true_m = 0;          ///< of the surface, NaN when the return stands for none (false alarm)
  float expected_pe = 0;            ///< photo-electrons expected in the echo
  float echo_fwhm_ns = 0;           ///< measured width, NaN when the method gives none
  float detection_probability = 0;  ///< 0 to 1
  std::uint8_t bounce_order = 1;    ///< scatterings of most of the echo's light; 0: none (false alarm, air)
  std::uint32_t object_id = kNoObject;
  std::uint16_t material_id = kNoMaterial;
  float incidence_deg = 0;       ///< between beam and surface normal
  float gff = 1;                 ///< geometric form factor (overlap)
  float transmission_2way = 1;   ///< of the air, to the surface and back
  float subray_fraction = 1;     ///< share of the footprint that brought the echo
  std::uint32_t pixel = 0;       ///< of an array
  float energy_pe = 0;           ///< measured: photo-electrons in the echo
  std::int16_t pulses_back = 0;  ///< how many pulses before pulse_id its light was sent, where ranges fold
};

/// Where a waveform lies in the packet file.
struct LasPacket {
  int descriptor = -1;       ///< index in LasOptions::descriptors; -1: none
  std::uint64_t offset = 0;  ///< bytes from the start of the packet record's 60-byte header
  std::uint32_t bytes = 0;
};

/// One return.
struct LasPoint {
  double x_m = 0, y_m = 0, z_m = 0;              ///< in the file's coordinate system
  std::uint16_t intensity = 0;                   ///< see LasOptions::intensity_from_energy
  int return_number = 1, number_of_returns = 1;  ///< 1 to 15
  bool synthetic = false, key_point = false, withheld = false, overlap = false;
  int scanner_channel = 0;  ///< 0 to 3
  bool scan_to_right = false, edge_of_line = false;
  std::uint8_t classification = 0, user_data = 0;
  double scan_angle_deg = 0;  ///< off nadir across the flight, right of it positive; -180 to 180, kept to 0.006
  std::uint16_t source_id = 1;
  double gps_time_s =
      0;  ///< adjusted standard GPS time (GPS time - 1e9 s) of the pulse's emission, the same for all its returns
  LasPacket packet;
  float return_location_ps = 0;               ///< of this return after the packet's first sample
  std::array<float, 3> direction_m_per_ps{};  ///< las_direction()
  LasTruth truth;
};

/// How samples of a kind of packet were digitised: value = offset + gain * sample (of ours photo-electrons, where LAS
/// says volts).
struct LasDescriptor {
  int bits = 16;  ///< 8 or 16, what readers know
  std::uint32_t samples = 0, spacing_ps = 1000;
  double gain = 1, offset = 0;
};

struct LasOptions {
  std::array<double, 3> offset_m{};  ///< of the stored integers: the scene's origin
  double scale_m = 1e-4;             ///< of the stored integers: 0.1 mm reaches 214 km from the offset, 1 mm 2147 km
  std::string wkt;                   ///< coordinate system, OGC WKT 1; empty: local metres east, north, up
  std::vector<LasDescriptor> descriptors;  ///< known before the first point
  int descriptor_room = 0;                 ///< how many more may come during the run; at most 255 together
  bool internal_packets = false;           ///< packets at the end of the .las file instead of in a .wdp
  std::string system_id = "raycube LIDAR", software = "raycube";  ///< 32 bytes each at most
  int creation_day = 0, creation_year = 0;                        ///< day of year from 1, UTC
  std::uint16_t source_id = 0;
  /// Intensities are truth.energy_pe in units of the smallest power of two photo-electrons that keeps the strongest
  /// within 16 bits (LAS wants them normalised, and the unit is not known before the last point); the unit stands in
  /// the VLR "raycube"/1.
  bool intensity_from_energy = false;
};

/// Vector d of a packet: sample i lies at P + (L - i spacing) d for a return at P with return location L (spacing, L in
/// ps), so d points from the target back to the sensor, as LASlib and CloudCompare read it (LAS 1.4 R16 states both
/// signs). |d| = c / (2 group index) per ps. beam: unit vector away from the sensor.
std::array<float, 3> las_direction(const std::array<double, 3>& beam, double group_index = 1);

/// Every pulse counts, also those without return: their packets are written all the same (in pulse order, all of one
/// size, so that a reader finds them), no point refers to them, and a VLR "raycube"/1 says how many there are. A
/// withheld point in their stead would stand in the air of every viewer that does not look at the flag.
class LasWriter {
 public:
  /// points: the .las. packets: the .wdp; with internal_packets a scratch file that is not published; null for format
  /// 6. Throws Error(input) for descriptors or scales LAS cannot hold.
  LasWriter(base::OutputFile& points, base::OutputFile* packets, LasOptions options);

  /// Index of this kind of waveform, new or known. Throws Error(input) beyond the room for them.
  int descriptor(const LasDescriptor& descriptor);
  /// Next waveform; `samples` has as many values as its descriptor says, none above what its bits hold.
  LasPacket add_packet(int descriptor, const std::vector<std::uint16_t>& samples);
  /// Next return. Throws Error(input) when a coordinate does not fit 32 bits (LAS would wrap), Error(bug) for numbers
  /// LAS has no room for.
  void add_point(const LasPoint& point);
  /// Ends both files; pulses: fired, without_return: of these.
  void finish(std::uint64_t pulses, std::uint64_t without_return);

  int format() const { return packets_file_ ? 9 : 6; }
  std::uint64_t points() const { return count_; }
  std::uint64_t packets() const { return packet_count_; }
  double scale_m() const { return options_.scale_m; }
  /// Photo-electrons per unit of intensity, so far.
  double intensity_unit_pe() const;

 private:
  std::string vlrs(std::uint64_t pulses, std::uint64_t without_return) const;
  void flush_points();
  void set_intensities();
  void flush_packets();
  std::uint64_t copy_packets_inside(std::uint64_t at);

  base::OutputFile& points_file_;
  base::OutputFile* packets_file_;
  LasOptions options_;
  std::size_t descriptor_places_ = 0;
  float strongest_pe_ = 0;
  std::uint32_t point_start_ = 0;
  std::uint16_t record_bytes_ = 0;
  std::uint64_t count_ = 0, packet_count_ = 0, points_written_ = 0, packets_written_ = 0;
  std::array<std::uint64_t, 15> by_return_{};
  std::array<std::int32_t, 3> low_, high_;
  std::vector<unsigned char> point_buffer_, packet_buffer_;
};

}  // namespace raycube::products
