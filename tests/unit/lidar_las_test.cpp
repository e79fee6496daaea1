// What the LAS writer refuses, and L-28. Contents of files are read back by tests/cli/lidar_las_test.py.
#include <doctest/doctest.h>

#include <cmath>
#include <cstring>
#include <functional>

#include <sys/resource.h>

#include "host/base/error.h"
#include "host/products/las_reader.h"
#include "host/products/las_writer.h"
#include "tests/unit/test_folder.h"

using namespace raycube;
using namespace raycube::products;
using raycube::testing::TestFolder;

namespace {

std::string message_of(base::Fault fault, const std::function<void()>& action) {
  try {
    action();
  } catch (const base::Error& error) {
    CHECK(error.fault() == fault);
    return error.what();
  }
  FAIL("no error");
  return "";
}

}  // namespace

TEST_CASE("L-28: the waveform direction of a beam 10 degrees off nadir points back to the sensor at c/2 per ps") {
  const double tilt = 10 * M_PI / 180;
  const auto d = las_direction({std::sin(tilt), 0, -std::cos(tilt)});
  CHECK(d[0] == doctest::Approx(-2.602921e-5).epsilon(2e-7));  // seven digits are published
  CHECK(d[1] == 0);
  CHECK(d[2] == doctest::Approx(1.476190e-4).epsilon(2e-7));
  const auto slower = las_direction({0, 0, -1}, 1.5);
  CHECK(slower[2] == doctest::Approx(1.49896229e-4 / 1.5).epsilon(1e-7));
}

TEST_CASE("L-28: LAS: coordinates beyond 32 bits are an error, never wrapped; the last that fit are kept") {
  TestFolder folder;
  base::OutputFile file(folder / "a.las");
  LasOptions options;
  options.scale_m = 1e-3;
  LasWriter writer(file, nullptr, options);
  LasPoint p;
  p.x_m = 2147483.647, p.y_m = -2147483.647;
  writer.add_point(p);
  p.x_m = 2147483.648;
  const std::string message = message_of(base::Fault::input, [&] { writer.add_point(p); });
  CHECK(message.find("x = 2147483.648 m") != std::string::npos);
  CHECK(message.find("coarser scale") != std::string::npos);
  p.x_m = std::nan("");
  message_of(base::Fault::input, [&] { writer.add_point(p); });
}

TEST_CASE("L-28: LAS: return numbers outside 1 to 15 and above the number of returns are refused") {
  TestFolder folder;
  base::OutputFile file(folder / "a.las");
  LasWriter writer(file, nullptr, {});
  for (const auto& [number, of] : {std::pair{0, 1}, {2, 1}, {16, 16}, {1, 16}, {1, 0}}) {
    LasPoint p;
    p.return_number = number, p.number_of_returns = of;
    message_of(base::Fault::bug, [&] { writer.add_point(p); });
  }
}

TEST_CASE("L-28: LAS: waveforms LAS cannot describe are refused before the run") {
  TestFolder folder;
  base::OutputFile file(folder / "a.las"), packets(folder / "a.wdp");
  for (const LasDescriptor& d :
       {LasDescriptor{12, 10, 1000, 1, 0}, {16, 0, 1000, 1, 0}, {16, 10, 0, 1, 0}, {16, 10, 1000, 0, 0}}) {
    LasOptions options;
    options.descriptors = {d};
    message_of(base::Fault::input, [&] { LasWriter(file, &packets, options); });
  }
  LasOptions many;
  many.descriptors.resize(256, {16, 10, 1000, 1, 0});
  CHECK(message_of(base::Fault::input, [&] { LasWriter(file, &packets, many); }).find("at most 255") !=
        std::string::npos);
}

TEST_CASE(
    "L-28: LAS: intensities are photo-electrons in the smallest power of two that fits the strongest; descriptors come "
    "as they are needed") {
  for (const auto& [strongest, unit] : {std::pair{65535.0f, 1.0},
                                        {65536.0f, 2.0},
                                        {131070.0f, 2.0},
                                        {131071.0f, 4.0},
                                        {1.0f, 1.0 / 32768},
                                        {0.0f, 1.0}}) {
    TestFolder folder;
    base::OutputFile file(folder / "a.las"), packets(folder / "a.wdp");
    LasOptions options;
    options.intensity_from_energy = true;
    options.descriptor_room = 2;
    LasWriter writer(file, &packets, options);
    CHECK(writer.descriptor({16, 1, 1000, 1, 0}) == 0);
    CHECK(writer.descriptor({16, 1, 1000, 2, 0}) == 1);
    CHECK(writer.descriptor({16, 1, 1000, 1, 0}) == 0);
    CHECK(message_of(base::Fault::input, [&, &w = writer] {
            w.descriptor({16, 1, 1000, 4, 0});
          }).find("full scale") != std::string::npos);
    LasPoint p;
    for (const float energy : {strongest, strongest / 3, std::nanf("")}) {
      p.truth.energy_pe = energy;
      writer.add_point(p);
    }
    writer.finish(3, 0);
    CHECK(writer.intensity_unit_pe() == unit);
    const LasInfo info = (file.publish(), packets.publish(), read_las_info(folder / "a.las"));
    CHECK(info.descriptors.size() == 2);
    const std::string bytes = folder.read("a.las");
    for (std::size_t i = 0; i < 3; ++i) {
      std::uint16_t intensity = 0;
      std::memcpy(&intensity, bytes.data() + bytes.size() - (3 - i) * static_cast<std::size_t>(info.record_bytes) + 12,
                  2);
      CHECK(intensity == (i == 2 ? 0 : static_cast<int>(std::lround((i == 0 ? strongest : strongest / 3) / unit))));
    }
  }
}

TEST_CASE("L-28: LAS: memory does not depend on the number of points and waveforms") {
  constexpr int kPoints = 400000;
  TestFolder folder;
  base::OutputFile file(folder / "a.las"), packets(folder / "a.part");
  LasOptions options;
  options.descriptors = {{16, 64, 1000, 1, 0}};
  options.internal_packets = options.intensity_from_energy = true;
  rusage before{}, after{};
  ::getrusage(RUSAGE_SELF, &before);
  LasWriter writer(file, &packets, options);
  const std::vector<std::uint16_t> samples(64, 7);
  LasPoint p;
  for (int i = 0; i < kPoints; ++i) {
    p.packet = writer.add_packet(0, samples);
    p.x_m = 0.01 * i;
    p.truth.energy_pe = static_cast<float>(i);
    writer.add_point(p);
  }
  writer.finish(kPoints, 0);
  ::getrusage(RUSAGE_SELF, &after);
  CHECK(file.size() > 400000u * (122 + 128));
  CHECK(after.ru_maxrss - before.ru_maxrss < 24 * 1024);  // kB: two buffers of 4 MB and their growth, of 100 MB written
  packets.sync();
  file.publish();
  const LasInfo info = read_las_info(folder / "a.las");
  CHECK(info.points == kPoints);
  CHECK(info.packet_bytes == std::uint64_t{kPoints} * 128);
  CHECK(info.high[0] == doctest::Approx(0.01 * (kPoints - 1)));
}

TEST_CASE("L-28: LAS: a survey without any return is a whole file with its counts") {
  TestFolder folder;
  {
    base::OutputFile file(folder / "none.las"), packets(folder / "none.wdp");
    LasOptions options;
    options.descriptors = {{16, 4, 1000, 1, 0}};
    LasWriter writer(file, &packets, options);
    CHECK(writer.add_packet(0, {1, 2, 3, 4}).offset == 60);
    writer.finish(1, 1);
    file.publish();
    packets.publish();
  }
  const LasInfo info = read_las_info(folder / "none.las");
  CHECK(info.points == 0);
  CHECK(info.pulses == 1u);
  CHECK(info.pulses_without_return == 1u);
  CHECK(info.packet_bytes == 8);
  CHECK(info.warnings.empty());
}
