// Writes LAS files of known contents into a folder for readers in Python, with what was handed to the writer as
// expected.json. Geometry: sensor 600 m above ground that steps along x, beams 10 degrees off nadir turning in azimuth,
// first sample at the gate.
#include <cmath>
#include <cstdio>
#include <memory>

#include <nlohmann/json.hpp>

#include "host/products/las_writer.h"

using namespace raycube;
using namespace raycube::products;
using Json = nlohmann::json;

namespace {

constexpr double kLight_m_s = 299792458.0, kGate_s = 3.9e-6, kSpacing_s = 500e-12;
constexpr int kPulses = 200, kSamples = 256;
constexpr std::array<double, 3> kOrigin = {500000.0, 5400000.0, 250.0};

Json write(const std::string& folder, const std::string& name, bool waveforms, bool internal_packets, int bits) {
  base::OutputSet set(folder, base::IfExists::replace);
  base::OutputFile& points = set.add(name + ".las");
  std::unique_ptr<base::OutputFile> scratch;
  base::OutputFile* packets = nullptr;
  if (internal_packets)
    packets = (scratch = std::make_unique<base::OutputFile>(folder + "/" + name + ".part")).get();
  else if (waveforms)
    packets = &set.add(name + ".wdp");
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
  options.internal_packets = internal_packets;
  options.creation_day = 200;
  options.creation_year = 2026;
  if (waveforms) options.descriptors = {{bits, kSamples, 500, bits == 8 ? 0.5 : 0.01, -1.25}};
  if (waveforms) options.descriptor_room = 3;
  LasWriter writer(points, packets, options);
  Json list = Json::array(), waves = Json::array();
  int without = 0;
  for (int pulse = 0; pulse < kPulses; ++pulse) {
    const double azimuth = 0.1 * pulse, tilt = 10 * M_PI / 180;
    const std::array<double, 3> beam = {std::sin(tilt) * std::cos(azimuth), std::sin(tilt) * std::sin(azimuth),
                                        -std::cos(tilt)};
    const double sensor[3] = {kOrigin[0] + 0.7 * pulse, kOrigin[1] - 0.3 * pulse, kOrigin[2] + 600.0};
    const int returns = pulse == 7 ? 15 : pulse % 5;  // none for every fifth
    if (returns == 0) ++without;
    std::vector<double> ranges;
    for (int r = 0; r < returns; ++r)
      ranges.push_back(kLight_m_s / 2 * (kGate_s + kSpacing_s * (20 + 15 * r + 0.25 * (pulse % 4))));
    std::vector<std::uint16_t> samples(kSamples);
    for (int i = 0; i < kSamples; ++i) {
      double value = 3 + (i * 7 + pulse) % 5;
      for (const double range : ranges) {
        const double off = (2 * range / kLight_m_s - kGate_s) / kSpacing_s - i;
        value += 200 * std::exp(-off * off / 8);
      }
      samples[static_cast<std::size_t>(i)] = static_cast<std::uint16_t>(std::lround(bits == 8 ? value : 100 * value));
    }
    LasPacket packet;
    if (waveforms) {
      packet = writer.add_packet(0, samples);
      waves.push_back({{"pulse", pulse}, {"offset", packet.offset}, {"samples", samples}});
      if (pulse == 3) writer.add_packet(writer.descriptor({16, 8, 250, 2.0, 0.0}), {1, 2, 3, 4, 5, 6, 7, 65535});
    }
    for (int r = 0; r < returns; ++r) {
      const double range = ranges[static_cast<std::size_t>(r)];
      LasPoint p;
      p.x_m = sensor[0] + range * beam[0], p.y_m = sensor[1] + range * beam[1], p.z_m = sensor[2] + range * beam[2];
      p.intensity = static_cast<std::uint16_t>(1000 * r + pulse);
      p.return_number = r + 1, p.number_of_returns = returns;
      p.synthetic = pulse % 2, p.key_point = pulse % 3 == 0, p.withheld = pulse % 7 == 1, p.overlap = pulse % 11 == 2;
      p.scanner_channel = pulse % 4, p.scan_to_right = pulse % 2 == 0, p.edge_of_line = pulse % 50 == 0;
      p.classification = static_cast<std::uint8_t>(pulse), p.user_data = static_cast<std::uint8_t>(255 - pulse);
      p.scan_angle_deg = 0.006 * (pulse * 300 - 30000), p.source_id = 77;
      p.gps_time_s = 4.5e8 + 1e-4 * pulse;
      p.packet = packet;
      p.return_location_ps = static_cast<float>((2 * range / kLight_m_s - kGate_s) * 1e12);
      p.direction_m_per_ps = las_direction(beam);
      p.truth = {static_cast<std::uint64_t>(pulse) + (std::uint64_t{1} << 40),
                 range,
                 range + 0.001,
                 10.5f + static_cast<float>(r),
                 1.5f,
                 0.75f,
                 static_cast<std::uint8_t>(r + 1),
                 static_cast<std::uint32_t>(100000 + pulse),
                 static_cast<std::uint16_t>(r),
                 10.0f,
                 0.5f,
                 0.25f,
                 0.125f,
                 3.5f * static_cast<float>(r + 1)};
      if (pulse == 199)
        p.truth.object_id = LasTruth::kNoObject, p.truth.material_id = LasTruth::kNoMaterial,
        p.truth.range_true_m = NAN;
      writer.add_point(p);
      const LasTruth& t = p.truth;
      list.push_back({{"x", p.x_m},
                      {"y", p.y_m},
                      {"z", p.z_m},
                      {"intensity", p.intensity},
                      {"return_number", r + 1},
                      {"number_of_returns", returns},
                      {"synthetic", p.synthetic},
                      {"key_point", p.key_point},
                      {"withheld", p.withheld},
                      {"overlap", p.overlap},
                      {"scanner_channel", p.scanner_channel},
                      {"scan_direction_flag", p.scan_to_right},
                      {"edge_of_flight_line", p.edge_of_line},
                      {"classification", p.classification},
                      {"user_data", p.user_data},
                      {"scan_angle", pulse * 300 - 30000},
                      {"point_source_id", 77},
                      {"gps_time", p.gps_time_s},
                      {"sensor", sensor},
                      {"beam", beam},
                      {"offset", packet.offset},
                      {"range", range},
                      {"extra",
                       {t.pulse_id, t.range_m, std::isnan(t.range_true_m) ? Json() : Json(t.range_true_m),
                        t.expected_pe, t.echo_fwhm_ns, t.detection_probability, t.bounce_order, t.object_id,
                        t.material_id, t.incidence_deg, t.gff, t.transmission_2way, t.subray_fraction, t.energy_pe}}});
    }
  }
  writer.finish(kPulses, static_cast<std::uint64_t>(without));
  set.publish();
  return {{"points", list},
          {"waves", waves},
          {"wkt", options.wkt},
          {"without_return", without},
          {"format", waveforms ? 9 : 6},
          {"internal", internal_packets},
          {"bits", bits}};
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 2) {
    std::fprintf(stderr, "usage: las_samples FOLDER\n");
    return 2;
  }
  const std::string folder = arguments[1];
  Json out = {{"gate_s", kGate_s}, {"spacing_s", kSpacing_s}, {"pulses", kPulses}};
  out["files"]["six"] = write(folder, "six", false, false, 16);
  out["files"]["nine"] = write(folder, "nine", true, false, 16);
  out["files"]["inside"] = write(folder, "inside", true, true, 16);
  out["files"]["bytes"] = write(folder, "bytes", true, false, 8);
  base::write_output_file(folder + "/expected.json", out.dump(), base::IfExists::replace);
  return 0;
}
