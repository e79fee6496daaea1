#include "host/products/las_writer.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "host/base/error.h"
#include "host/products/las_layout.h"

namespace raycube::products {
namespace {

using base::Error;
using base::Fault;
using namespace las;

constexpr std::size_t kBuffer_bytes = std::size_t{4} << 20;
constexpr std::size_t kCounts_bytes =
    192;  ///< of the text of our VLR, padded: its place comes before the numbers are known
constexpr std::uint16_t kTruth_bytes = 69;
constexpr double kLightSpeed_m_s = 299792458.0;

struct ExtraField {
  int type;
  const char* name;
  const char* description;
  bool no_data;  ///< all bits set means none
};
constexpr ExtraField kExtraFields[] = {{7, "pulse_id", "number of the pulse", false},
                                       {10, "range", "measured range, m", false},
                                       {10, "range_true", "range of the surface, m", false},
                                       {9, "expected_pe", "expected photo-electrons", false},
                                       {9, "echo_fwhm_ns", "measured echo width, ns", false},
                                       {9, "pd", "probability of detection", false},
                                       {1, "bounce_order", "scatterings of the light", false},
                                       {5, "object_id", "object hit", true},
                                       {3, "material_id", "material hit", true},
                                       {9, "incidence_deg", "beam to normal, degrees", false},
                                       {9, "gff", "geometric form factor", false},
                                       {9, "trans_2way", "air transmission both ways", false},
                                       {9, "subray_fraction", "share of the footprint", false},
                                       {5, "pixel", "pixel of the array", false},
                                       {9, "energy_pe", "measured photo-electrons", false},
                                       {4, "pulses_back", "sent so many pulses earlier", false}};

std::string vlr(const char* user, std::uint16_t id, const std::string& description, const std::string& data) {
  unsigned char header[kVlrHeader] = {};
  put_text(header, 2, 16, user);
  put(header, 18, id);
  put(header, 20, static_cast<std::uint16_t>(data.size()));
  put_text(header, 22, 32, description);
  return std::string(reinterpret_cast<const char*>(header), sizeof header) + data;
}

std::string packets_header(std::uint64_t data_bytes) {
  unsigned char header[kEvlrHeader] = {};
  put_text(header, 2, 16, kSpecUser);
  put(header, 18, kPacketsId);
  put(header, 20, data_bytes);
  put_text(header, 28, 32, "waveform data packets");
  return std::string(reinterpret_cast<const char*>(header), sizeof header);
}

std::string descriptor_vlr(const LasDescriptor& descriptor, std::size_t index) {
  unsigned char data[kDescriptor] = {};
  put(data, 0, static_cast<std::uint8_t>(descriptor.bits));
  put(data, 2, descriptor.samples);
  put(data, 6, descriptor.spacing_ps);
  put(data, 10, descriptor.gain);
  put(data, 18, descriptor.offset);
  return vlr(kSpecUser, static_cast<std::uint16_t>(kFirstDescriptorId + index), "waveform descriptor",
             std::string(reinterpret_cast<const char*>(data), sizeof data));
}

std::string extra_bytes_vlr() {
  std::string data;
  for (const ExtraField& field : kExtraFields) {
    unsigned char record[kExtraBytes] = {};
    record[2] = static_cast<unsigned char>(field.type);
    if (field.no_data) {
      record[3] = 1;  // the field no_data is set; integers stand in it widened to 64 bits
      put(record, 40, field.type == 5 ? std::uint64_t{LasTruth::kNoObject} : std::uint64_t{LasTruth::kNoMaterial});
    }
    put_text(record, 4, 32, field.name);
    put_text(record, 160, 32, field.description);
    data.append(reinterpret_cast<const char*>(record), sizeof record);
  }
  return vlr(kSpecUser, kExtraBytesId, "truth of each return", data);
}

void put_truth(unsigned char* record, const LasTruth& truth) {
  std::size_t at = 0;
  const auto next = [&](auto value) {
    put(record, at, value);
    at += sizeof value;
  };
  next(truth.pulse_id);
  next(truth.range_m);
  next(truth.range_true_m);
  next(truth.expected_pe);
  next(truth.echo_fwhm_ns);
  next(truth.detection_probability);
  next(truth.bounce_order);
  next(truth.object_id);
  next(truth.material_id);
  next(truth.incidence_deg);
  next(truth.gff);
  next(truth.transmission_2way);
  next(truth.subray_fraction);
  next(truth.pixel);
  next(truth.energy_pe);
  next(truth.pulses_back);
}

void check_descriptor(const std::string& name, const LasDescriptor& d) {
  if ((d.bits != 8 && d.bits != 16) || d.samples == 0 || d.spacing_ps == 0 || !(d.gain != 0) ||
      !std::isfinite(d.gain) || !std::isfinite(d.offset))
    throw Error(Fault::input, fmt::format("{}: a LAS waveform has 8 or 16 bits, at least one sample, a spacing of "
                                          "whole picoseconds and a gain (found {} bits, "
                                          "{} samples, {} ps, gain {})",
                                          name, d.bits, d.samples, d.spacing_ps, d.gain));
}

}  // namespace

std::array<float, 3> las_direction(const std::array<double, 3>& beam, double group_index) {
  const double speed = kLightSpeed_m_s * 1e-12 / (2 * group_index);
  return {static_cast<float>(-beam[0] * speed), static_cast<float>(-beam[1] * speed),
          static_cast<float>(-beam[2] * speed)};
}

LasWriter::LasWriter(base::OutputFile& points, base::OutputFile* packets, LasOptions options)
    : points_file_(points), packets_file_(packets), options_(std::move(options)) {
  const std::string& name = points.final_path();
  if (!(options_.scale_m > 0) || !std::isfinite(options_.scale_m))
    throw Error(Fault::input,
                fmt::format("{}: the scale of LAS coordinates must be above 0 (found {} m)", name, options_.scale_m));
  descriptor_places_ = options_.descriptors.size() + static_cast<std::size_t>(std::max(options_.descriptor_room, 0));
  if (descriptor_places_ > kLastDescriptorId - kFirstDescriptorId + 1u)
    throw Error(Fault::input,
                fmt::format("{}: LAS holds at most 255 kinds of waveform (found {}); write fewer, or no waveforms",
                            name, descriptor_places_));
  for (const auto& d : options_.descriptors) check_descriptor(name, d);
  if ((descriptor_places_ == 0) == (packets != nullptr))
    throw Error(Fault::bug, name + ": packets and their descriptors go together");
  if (options_.wkt.empty())
    options_.wkt = R"(LOCAL_CS["scene, metres",UNIT["metre",1],AXIS["East",EAST],AXIS["North",NORTH]])";
  if (options_.wkt.size() > 65534)
    throw Error(Fault::input, fmt::format("{}: the text of the coordinate system has {} bytes, LAS holds 65534", name,
                                          options_.wkt.size()));
  if (options_.intensity_from_energy) points.expect_rewriting();
  record_bytes_ = static_cast<std::uint16_t>(kPointBytes[static_cast<std::size_t>(format())] + kTruth_bytes);
  point_start_ = static_cast<std::uint32_t>(kHeader + vlrs(0, 0).size());
  low_.fill(std::numeric_limits<std::int32_t>::max());
  high_.fill(std::numeric_limits<std::int32_t>::min());
}

std::string LasWriter::vlrs(std::uint64_t pulses, std::uint64_t without_return) const {
  std::string out = vlr(kProjectionUser, kWktId, "OGC coordinate system WKT", options_.wkt + '\0');
  for (std::size_t i = 0; i < options_.descriptors.size(); ++i) out += descriptor_vlr(options_.descriptors[i], i);
  out += extra_bytes_vlr();
  std::string counts = fmt::format("pulses = {}\npulses without return = {}\n", pulses, without_return);
  if (options_.intensity_from_energy)
    counts += fmt::format("photo-electrons per unit of intensity = {}\n", intensity_unit_pe());
  // This record also fills the places of descriptors that did not come.
  counts.resize(kCounts_bytes + (descriptor_places_ - options_.descriptors.size()) * (kVlrHeader + kDescriptor), '\0');
  return out + vlr(kOurUser, kOurCountsId, "pulses, with and without return", counts);
}

int LasWriter::descriptor(const LasDescriptor& wanted) {
  auto& known = options_.descriptors;
  for (std::size_t i = 0; i < known.size(); ++i)
    if (known[i].bits == wanted.bits && known[i].samples == wanted.samples &&
        known[i].spacing_ps == wanted.spacing_ps && known[i].gain == wanted.gain && known[i].offset == wanted.offset)
      return static_cast<int>(i);
  check_descriptor(points_file_.final_path(), wanted);
  if (known.size() == descriptor_places_)
    throw Error(Fault::input, fmt::format("{}: more than {} kinds of waveform (gains of the digitiser); give the "
                                          "detector a fixed full scale, or write no LAS waveforms",
                                          points_file_.final_path(), descriptor_places_));
  known.push_back(wanted);
  return static_cast<int>(known.size()) - 1;
}

LasPacket LasWriter::add_packet(int descriptor, const std::vector<std::uint16_t>& samples) {
  if (descriptor < 0 || static_cast<std::size_t>(descriptor) >= options_.descriptors.size())
    throw Error(Fault::bug, fmt::format("{}: no waveform descriptor {}", points_file_.final_path(), descriptor));
  const LasDescriptor& d = options_.descriptors[static_cast<std::size_t>(descriptor)];
  if (samples.size() != d.samples)
    throw Error(Fault::bug, fmt::format("{}: a waveform of {} samples came where {} were announced",
                                        points_file_.final_path(), samples.size(), d.samples));
  const std::size_t sample_bytes = d.bits == 8 ? 1 : 2, bytes = samples.size() * sample_bytes;
  if (bytes > std::numeric_limits<std::uint32_t>::max())
    throw Error(Fault::input, fmt::format("{}: a waveform of {} samples is longer than LAS holds; record fewer bins",
                                          points_file_.final_path(), samples.size()));
  const LasPacket packet{descriptor, kEvlrHeader + packets_written_ + packet_buffer_.size(),
                         static_cast<std::uint32_t>(bytes)};
  if (d.bits == 16) {
    const auto* const first = reinterpret_cast<const unsigned char*>(samples.data());
    packet_buffer_.insert(packet_buffer_.end(), first, first + bytes);
  } else {
    for (const std::uint16_t sample : samples) {
      if (sample > 255)
        throw Error(Fault::bug, fmt::format("{}: sample {} of 8 bits", points_file_.final_path(), sample));
      packet_buffer_.push_back(static_cast<unsigned char>(sample));
    }
  }
  ++packet_count_;
  if (packet_buffer_.size() >= kBuffer_bytes) flush_packets();
  return packet;
}

void LasWriter::add_point(const LasPoint& p) {
  const std::string& name = points_file_.final_path();
  if (p.number_of_returns < 1 || p.number_of_returns > 15 || p.return_number < 1 ||
      p.return_number > p.number_of_returns)
    throw Error(Fault::bug, fmt::format("{}: return {} of {}: LAS counts from 1 to 15", name, p.return_number,
                                        p.number_of_returns));
  if (!(std::abs(p.scan_angle_deg) <= 180))
    throw Error(Fault::bug, fmt::format("{}: scan angle {} deg", name, p.scan_angle_deg));
  if (p.scanner_channel < 0 || p.scanner_channel > 3)
    throw Error(Fault::bug, fmt::format("{}: scanner channel {}", name, p.scanner_channel));
  const std::size_t start = point_buffer_.size();
  point_buffer_.resize(start + record_bytes_);
  unsigned char* const record = point_buffer_.data() + start;
  const double position[3] = {p.x_m, p.y_m, p.z_m};
  for (std::size_t i = 0; i < 3; ++i) {
    const double stored = std::round((position[i] - options_.offset_m[i]) / options_.scale_m);
    if (!(std::abs(stored) <= 2147483647.0))
      throw Error(Fault::input, fmt::format("{}: {} = {} m lies further than {:.6g} m from the file's offset {}: 32 "
                                            "bits at {} m cannot hold it; use a coarser scale or "
                                            "a scene origin nearer to the points",
                                            name, "xyz"[i], position[i], 2147483647.0 * options_.scale_m,
                                            options_.offset_m[i], options_.scale_m));
    const auto integer = static_cast<std::int32_t>(stored);
    low_[i] = std::min(low_[i], integer);
    high_[i] = std::max(high_[i], integer);
    put(record, 4 * i, integer);
  }
  put(record, 12, p.intensity);
  record[14] = static_cast<unsigned char>(p.return_number | p.number_of_returns << 4);
  record[15] = static_cast<unsigned char>(p.synthetic | p.key_point << 1 | p.withheld << 2 | p.overlap << 3 |
                                          p.scanner_channel << 4 | p.scan_to_right << 6 | p.edge_of_line << 7);
  record[16] = p.classification;
  record[17] = p.user_data;
  put(record, 18, static_cast<std::int16_t>(std::lround(p.scan_angle_deg / 0.006)));
  put(record, 20, p.source_id);
  put(record, 22, p.gps_time_s);
  if (format() == 9 && p.packet.descriptor >= 0) {
    record[30] = static_cast<unsigned char>(p.packet.descriptor + 1);
    put(record, 31, p.packet.offset);
    put(record, 39, p.packet.bytes);
    put(record, 43, p.return_location_ps);
    for (std::size_t i = 0; i < 3; ++i) put(record, 47 + 4 * i, p.direction_m_per_ps[i]);
  }
  strongest_pe_ = std::max(strongest_pe_, p.truth.energy_pe);
  put_truth(record + kPointBytes[static_cast<std::size_t>(format())], p.truth);
  ++count_;
  ++by_return_[static_cast<std::size_t>(p.return_number - 1)];
  if (point_buffer_.size() >= kBuffer_bytes) flush_points();
}

void LasWriter::flush_points() {
  points_file_.write_at(point_start_ + points_written_, point_buffer_.data(), point_buffer_.size());
  points_written_ += point_buffer_.size();
  point_buffer_.clear();
}

double LasWriter::intensity_unit_pe() const {
  if (!(strongest_pe_ > 0) || !std::isfinite(strongest_pe_)) return 1;
  const double unit = std::exp2(std::ceil(std::log2(strongest_pe_ / 65535.0)));
  return strongest_pe_ / unit > 65535.0 ? 2 * unit : unit;
}

/// The points once more: their energies are in the file, the unit is known only now.
void LasWriter::set_intensities() {
  const double unit = intensity_unit_pe();
  const std::size_t energy_at =
                        std::size_t{record_bytes_} - sizeof(LasTruth::pulses_back) - sizeof(LasTruth::energy_pe),
                    piece_points = kBuffer_bytes / record_bytes_;
  for (std::uint64_t first = 0; first < count_; first += piece_points) {
    const std::size_t points = std::min<std::uint64_t>(piece_points, count_ - first);
    point_buffer_.resize(points * record_bytes_);
    points_file_.read_at(point_start_ + first * record_bytes_, point_buffer_.data(), point_buffer_.size());
    for (std::size_t i = 0; i < points; ++i) {
      unsigned char* const record = point_buffer_.data() + i * record_bytes_;
      const double stored = std::round(get<float>(record, energy_at) / unit);
      put(record, 12, static_cast<std::uint16_t>(stored > 0 ? std::min(stored, 65535.0) : 0));  // NaN: 0
    }
    points_file_.write_at(point_start_ + first * record_bytes_, point_buffer_.data(), point_buffer_.size());
  }
}

void LasWriter::flush_packets() {
  packets_file_->write_at(kEvlrHeader + packets_written_, packet_buffer_.data(), packet_buffer_.size());
  packets_written_ += packet_buffer_.size();
  packet_buffer_.clear();
}

std::uint64_t LasWriter::copy_packets_inside(std::uint64_t at) {
  const std::uint64_t bytes = kEvlrHeader + packets_written_;
  packet_buffer_.resize(std::min<std::uint64_t>(kBuffer_bytes, bytes));
  for (std::uint64_t done = 0; done < bytes;) {
    const std::size_t piece = std::min<std::uint64_t>(packet_buffer_.size(), bytes - done);
    packets_file_->read_at(done, packet_buffer_.data(), piece);
    points_file_.write_at(at + done, packet_buffer_.data(), piece);
    done += piece;
  }
  return at;
}

void LasWriter::finish(std::uint64_t pulses, std::uint64_t without_return) {
  flush_points();
  if (options_.intensity_from_energy) set_intensities();
  std::uint64_t packets_at = 0;
  if (packets_file_) {
    flush_packets();
    const std::string header = packets_header(packets_written_);
    packets_file_->write_at(0, header.data(), header.size());
    if (options_.internal_packets) packets_at = copy_packets_inside(point_start_ + points_written_);
  }
  unsigned char h[kHeader] = {};
  put_text(h, 0, 4, "LASF");
  put(h, 4, options_.source_id);
  put(h, 6,
      static_cast<std::uint16_t>(kAdjustedGpsTime | kWkt |
                                 (!packets_file_ ? 0
                                  : packets_at   ? kInternalPackets
                                                 : kExternalPackets)));
  h[24] = 1, h[25] = 4;
  put_text(h, 26, 32, options_.system_id);
  put_text(h, 58, 32, options_.software);
  put(h, 90, static_cast<std::uint16_t>(options_.creation_day));
  put(h, 92, static_cast<std::uint16_t>(options_.creation_year));
  put(h, 94, static_cast<std::uint16_t>(kHeader));
  put(h, 96, point_start_);
  put(h, 100, static_cast<std::uint32_t>(3 + options_.descriptors.size()));
  h[104] = static_cast<unsigned char>(format());
  put(h, 105, record_bytes_);
  // Counts and by-return counts of 32 bits at 107 and 111 stay 0: formats above 5 use those of 64 bits alone.
  for (std::size_t i = 0; i < 3; ++i) {
    put(h, 131 + 8 * i, options_.scale_m);
    put(h, 155 + 8 * i, options_.offset_m[i]);
    if (count_ == 0) continue;
    // Of the stored integers, so that readers who check the box against the points find it exact.
    put(h, 179 + 16 * i, high_[i] * options_.scale_m + options_.offset_m[i]);
    put(h, 187 + 16 * i, low_[i] * options_.scale_m + options_.offset_m[i]);
  }
  put(h, 227, packets_at);
  put(h, 235, packets_at);
  put(h, 243, static_cast<std::uint32_t>(packets_at ? 1 : 0));
  put(h, 247, count_);
  for (std::size_t i = 0; i < 15; ++i) put(h, 255 + 8 * i, by_return_[i]);
  points_file_.write_at(0, h, sizeof h);
  const std::string records = vlrs(pulses, without_return);
  points_file_.write_at(kHeader, records.data(), records.size());
}

}  // namespace raycube::products
