// Writes LAS files of known contents into a folder for readers in Python, with what was handed to the writer as
// expected.json. Geometry: sensor 600 m above ground that steps along x, beams 10 degrees off nadir turning in azimuth,
// first sample at the gate.
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "host/products/las_writer.h"

using namespace raycube;
using namespace raycube::products;
using Json = nlohmann::json;

namespace {

constexpr double kLight_m_s = 299792458.0, kGate_s = 3.9e-6, kSpacing_s = 500e-12;
constexpr int kPulses = 200, kSamples = 256;
constexpr std::array<double, 3> kOrigin = {500000.0, 5400000.0, 250.0};

/// LAS keeps scan angles in these units.
constexpr double kScanAngleUnit_deg = 0.006;

/// What a file is: with packets of waveforms or without, beside the points or inside, of so many bits.
struct Kind {
  bool waveforms, internal_packets;
  int bits;
};

/// A pulse as the sensor sends it, and how far away it is returned.
struct Pulse {
  int number;
  std::array<double, 3> sensor_m, beam;
  std::vector<double> ranges_m;
  int returns() const { return static_cast<int>(ranges_m.size()); }
};

/// From -180 to 178 degrees in the course of the pulses.
int scan_angle_units(const Pulse& pulse) { return pulse.number * 300 - 30000; }

LasOptions options_of(const Kind& kind) {
  LasOptions options;
  options.offset_m = kOrigin;
  options.wkt =
      R"(PROJCS["WGS 84 / UTM zone 32N",GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563]],)"
      R"(PRIMEM["Greenwich",0],)"
      R"(UNIT["degree",0.0174532925199433]],PROJECTION["Transverse_Mercator"],PARAMETER["latitude_of_origin",0],)"
      R"(PARAMETER["central_meridian",9],)"
      R"(PARAMETER["scale_factor",0.9996],)"
      R"(PARAMETER["false_easting",500000],PARAMETER["false_northing",0],UNIT["metre",1],)"
      R"(AUTHORITY["EPSG","32632"]])";
  options.internal_packets = kind.internal_packets;
  options.creation_day = 200;
  options.creation_year = 2026;
  if (kind.waveforms) options.descriptors = {{kind.bits, kSamples, 500, kind.bits == 8 ? 0.5 : 0.01, -1.25}};
  if (kind.waveforms) options.descriptor_room = 3;
  return options;
}

/// Every fifth pulse has no return; the others have up to four, on samples and between them, and one has all 15.
Pulse pulse_of(int number) {
  const double azimuth = 0.1 * number, tilt = 10 * M_PI / 180;
  Pulse pulse{number,
              {kOrigin[0] + 0.7 * number, kOrigin[1] - 0.3 * number, kOrigin[2] + 600.0},
              {std::sin(tilt) * std::cos(azimuth), std::sin(tilt) * std::sin(azimuth), -std::cos(tilt)},
              {}};
  const int returns = number == 7 ? 15 : number % 5;
  for (int r = 0; r < returns; ++r)
    pulse.ranges_m.push_back(kLight_m_s / 2 * (kGate_s + kSpacing_s * (20 + 15 * r + 0.25 * (number % 4))));
  return pulse;
}

/// An echo of two samples' standard deviation at each range, over a floor that differs from pulse to pulse.
std::vector<std::uint16_t> samples_of(const Pulse& pulse, int bits) {
  std::vector<std::uint16_t> samples(kSamples);
  for (int i = 0; i < kSamples; ++i) {
    double value = 3 + (i * 7 + pulse.number) % 5;
    for (const double range : pulse.ranges_m) {
      const double off = (2 * range / kLight_m_s - kGate_s) / kSpacing_s - i;
      value += 200 * std::exp(-off * off / 8);
    }
    samples[static_cast<std::size_t>(i)] = static_cast<std::uint16_t>(std::lround(bits == 8 ? value : 100 * value));
  }
  return samples;
}

/// The extra bytes of return r from 0; the last pulse's stand for no object.
LasTruth truth_of(const Pulse& pulse, int r) {
  const double range = pulse.ranges_m[static_cast<std::size_t>(r)];
  LasTruth truth = {static_cast<std::uint64_t>(pulse.number) + (std::uint64_t{1} << 40),
                    range,
                    range + 0.001,
                    10.5f + static_cast<float>(r),
                    1.5f,
                    0.75f,
                    static_cast<std::uint8_t>(r + 1),
                    static_cast<std::uint32_t>(100000 + pulse.number),
                    static_cast<std::uint16_t>(r),
                    10.0f,
                    0.5f,
                    0.25f,
                    0.125f,
                    static_cast<std::uint32_t>(70000 + r),
                    3.5f * static_cast<float>(r + 1),
                    static_cast<std::int16_t>(r - 1)};
  if (pulse.number == kPulses - 1)
    truth.object_id = LasTruth::kNoObject, truth.material_id = LasTruth::kNoMaterial, truth.range_true_m = NAN;
  return truth;
}

/// Return r from 0; flags and numbers take every value they have room for as the pulses go by.
LasPoint point_of(const Pulse& pulse, int r, const LasPacket& packet) {
  const double range = pulse.ranges_m[static_cast<std::size_t>(r)];
  const auto &sensor = pulse.sensor_m, &beam = pulse.beam;
  const int n = pulse.number;
  LasPoint p;
  p.x_m = sensor[0] + range * beam[0], p.y_m = sensor[1] + range * beam[1], p.z_m = sensor[2] + range * beam[2];
  p.intensity = static_cast<std::uint16_t>(1000 * r + n);
  p.return_number = r + 1, p.number_of_returns = pulse.returns();
  p.synthetic = n % 2, p.key_point = n % 3 == 0, p.withheld = n % 7 == 1, p.overlap = n % 11 == 2;
  p.scanner_channel = n % 4, p.scan_to_right = n % 2 == 0, p.edge_of_line = n % 50 == 0;
  p.classification = static_cast<std::uint8_t>(n), p.user_data = static_cast<std::uint8_t>(255 - n);
  p.scan_angle_deg = kScanAngleUnit_deg * scan_angle_units(pulse), p.source_id = 77;
  p.gps_time_s = 4.5e8 + 1e-4 * n;
  p.packet = packet;
  p.return_location_ps = static_cast<float>((2 * range / kLight_m_s - kGate_s) * 1e12);
  p.direction_m_per_ps = las_direction(beam);
  p.truth = truth_of(pulse, r);
  return p;
}

Json json_of(const LasTruth& t) {
  return {t.pulse_id,        t.range_m,      std::isnan(t.range_true_m) ? Json() : Json(t.range_true_m),
          t.expected_pe,     t.echo_fwhm_ns, t.detection_probability,
          t.bounce_order,    t.object_id,    t.material_id,
          t.incidence_deg,   t.gff,          t.transmission_2way,
          t.subray_fraction, t.pixel,        t.energy_pe,
          t.pulses_back};
}

/// What a reader must find for a point, by the names of laspy where it has one.
Json json_of(const Pulse& pulse, const LasPoint& p) {
  return {{"x", p.x_m},
          {"y", p.y_m},
          {"z", p.z_m},
          {"intensity", p.intensity},
          {"return_number", p.return_number},
          {"number_of_returns", p.number_of_returns},
          {"synthetic", p.synthetic},
          {"key_point", p.key_point},
          {"withheld", p.withheld},
          {"overlap", p.overlap},
          {"scanner_channel", p.scanner_channel},
          {"scan_direction_flag", p.scan_to_right},
          {"edge_of_flight_line", p.edge_of_line},
          {"classification", p.classification},
          {"user_data", p.user_data},
          {"scan_angle", scan_angle_units(pulse)},
          {"point_source_id", p.source_id},
          {"gps_time", p.gps_time_s},
          {"sensor", pulse.sensor_m},
          {"beam", pulse.beam},
          {"offset", p.packet.offset},
          {"range", p.truth.range_m},
          {"extra", json_of(p.truth)}};
}

/// Writes one file and returns what its readers must find in it.
Json write(const std::string& folder, const std::string& name, const Kind& kind) {
  base::OutputSet set(folder, base::IfExists::replace);
  base::OutputFile& points = set.add(name + ".las");
  std::unique_ptr<base::OutputFile> scratch;
  base::OutputFile* packets = nullptr;
  if (kind.internal_packets)
    packets = (scratch = std::make_unique<base::OutputFile>(folder + "/" + name + ".part")).get();
  else if (kind.waveforms)
    packets = &set.add(name + ".wdp");
  const LasOptions options = options_of(kind);
  LasWriter writer(points, packets, options);
  Json list = Json::array(), waves = Json::array();
  int without = 0;
  for (int number = 0; number < kPulses; ++number) {
    const Pulse pulse = pulse_of(number);
    if (pulse.returns() == 0) ++without;
    LasPacket packet;
    if (kind.waveforms) {
      const auto samples = samples_of(pulse, kind.bits);
      packet = writer.add_packet(0, samples);
      waves.push_back({{"pulse", number}, {"offset", packet.offset}, {"samples", samples}});
      // One packet of another kind among them, of which the options said nothing.
      if (number == 3) writer.add_packet(writer.descriptor({16, 8, 250, 2.0, 0.0}), {1, 2, 3, 4, 5, 6, 7, 65535});
    }
    for (int r = 0; r < pulse.returns(); ++r) {
      const LasPoint point = point_of(pulse, r, packet);
      writer.add_point(point);
      list.push_back(json_of(pulse, point));
    }
  }
  writer.finish(kPulses, static_cast<std::uint64_t>(without));
  set.publish();
  return {{"points", list},
          {"waves", waves},
          {"wkt", options.wkt},
          {"without_return", without},
          {"format", kind.waveforms ? 9 : 6},
          {"internal", kind.internal_packets},
          {"bits", kind.bits}};
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 2) {
    std::fprintf(stderr, "usage: las_samples FOLDER\n");
    return 2;
  }
  const std::string folder = arguments[1];
  Json out = {{"gate_s", kGate_s}, {"spacing_s", kSpacing_s}, {"pulses", kPulses}};
  out["files"]["six"] = write(folder, "six", {false, false, 16});
  out["files"]["nine"] = write(folder, "nine", {true, false, 16});
  out["files"]["inside"] = write(folder, "inside", {true, true, 16});
  out["files"]["bytes"] = write(folder, "bytes", {true, false, 8});
  base::write_output_file(folder + "/expected.json", out.dump(), base::IfExists::replace);
  return 0;
}
