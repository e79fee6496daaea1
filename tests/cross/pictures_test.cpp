// OpenEXR, PNG, map grid and run record, each read back by an independent library: OpenEXR's reader, libpng's
// simplified reader, GDAL, a JSON parser.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdlib>

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputPart.h>
#include <ImfMultiPartInputFile.h>
#include <ImfStringAttribute.h>
#include <gdal_priv.h>
#include <nlohmann/json.hpp>
#include <png.h>

#include "host/base/error.h"
#include "host/products/exr_writer.h"
#include "host/products/map_grid.h"
#include "host/products/quicklook.h"
#include "host/products/run_record.h"
#include "tests/unit/test_folder.h"

using namespace raycube;
using namespace raycube::products;
using raycube::testing::TestFolder;

namespace {

constexpr int kWidth = 37, kHeight = 41;

std::vector<float> image(std::size_t stride) {
  std::vector<float> values(kWidth * kHeight * stride);
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = static_cast<float>(i / stride) + 0.125f * static_cast<float>(i % stride);
  return values;
}

Strip strip_of(const std::vector<float>& values, std::size_t stride, std::int64_t first, std::int64_t lines) {
  return {first, lines, values.data() + static_cast<std::size_t>(first) * kWidth * stride, stride};
}

std::vector<std::uint8_t> read_png(const std::string& path, png_uint_32 format, unsigned& width, unsigned& height) {
  png_image picture{};
  picture.version = PNG_IMAGE_VERSION;
  REQUIRE(png_image_begin_read_from_file(&picture, path.c_str()));
  picture.format = format;
  std::vector<std::uint8_t> pixels(PNG_IMAGE_SIZE(picture));
  REQUIRE(png_image_finish_read(&picture, nullptr, pixels.data(), 0, nullptr));
  width = picture.width, height = picture.height;
  return pixels;
}

}  // namespace

TEST_CASE("OpenEXR: two parts written in strips read back exactly, with channel names and attributes") {
  const TestFolder folder;
  const auto values = image(8);
  base::OutputSet set(folder.path.string());
  ExrWriter writer(set.add("a.exr"), kWidth, kHeight,
                   {{"truth", {"hit.X", "hit.Y", "sun_fraction"}}, {"radiance", {"650 nm"}}},
                   {{"dataUnits", "W m-2 sr-1 um-1"}});
  for (std::int64_t line = 0; line < kHeight; line += 10) {
    const auto lines = std::min<std::int64_t>(10, kHeight - line);
    writer.write({{strip_of(values, 8, line, lines), {0, 1, 5}}, {strip_of(values, 8, line, lines), {7}}});
  }
  writer.finish();
  set.publish();
  Imf::MultiPartInputFile file((folder / "a.exr").c_str());
  REQUIRE(file.parts() == 2);
  CHECK(file.header(0).name() == "truth");
  CHECK(file.header(1).typedAttribute<Imf::StringAttribute>("dataUnits").value() == "W m-2 sr-1 um-1");
  const auto channel = [&](int part, const char* name) {
    std::vector<float> out(kWidth * kHeight, -1);
    Imf::InputPart input(file, part);
    Imf::FrameBuffer buffer;
    buffer.insert(name, Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(out.data()), 4, 4 * kWidth));
    input.setFrameBuffer(buffer);
    input.readPixels(0, kHeight - 1);
    return out;
  };
  const auto x = channel(0, "hit.X"), sun = channel(0, "sun_fraction"), red = channel(1, "650 nm");
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < kWidth * kHeight; ++i)
    wrong += x[i] != values[i * 8] || sun[i] != values[i * 8 + 5] || red[i] != values[i * 8 + 7];
  CHECK(wrong == 0);
}

TEST_CASE("OpenEXR: the file's bytes do not depend on the strips") {
  const auto values = image(8);
  const auto bytes_of = [&](std::int64_t step) {
    const TestFolder folder;
    base::OutputSet set(folder.path.string());
    ExrWriter writer(set.add("a.exr"), kWidth, kHeight,
                     {{"truth", {"hit.X", "hit.Y", "sun_fraction"}}, {"radiance", {"650 nm"}}}, {});
    for (std::int64_t line = 0; line < kHeight; line += step) {
      const auto strip = strip_of(values, 8, line, std::min<std::int64_t>(step, kHeight - line));
      writer.write({{strip, {0, 1, 5}}, {strip, {7}}});
    }
    writer.finish();
    set.publish();
    return folder.read("a.exr");
  };
  const std::string whole = bytes_of(kHeight);
  CHECK(whole.size() > 1000);
  for (const int step : {1, 7, 10, 16, 17, 32}) CHECK(bytes_of(step) == whole);
}

TEST_CASE("OpenEXR: missing lines are our bug") {
  const TestFolder folder;
  const auto values = image(1);
  base::OutputSet set(folder.path.string());
  ExrWriter writer(set.add("a.exr"), kWidth, kHeight, {{"truth", {"X"}}}, {});
  writer.write({{strip_of(values, 1, 0, 5), {0}}});
  CHECK_THROWS_AS(writer.write({{strip_of(values, 1, 7, 5), {0}}}), base::Error);
  CHECK_THROWS_AS(writer.finish(), base::Error);
}

TEST_CASE("quicklook: percentiles of a known ramp, black and full outside them, NaN black") {
  const TestFolder folder;
  std::vector<float> values(101 * 3);
  for (int i = 0; i < 101; ++i) {
    values[i * 3] = static_cast<float>(i);  // 0..100: percentiles 2 and 98 are 2 and 98 by nearest rank
    values[i * 3 + 1] = static_cast<float>(1000 - i);
    values[i * 3 + 2] = 7.0f;  // uniform
  }
  values[50 * 3] = NAN;
  base::OutputFile file(folder / "q.png");
  Quicklook look(101, 1, {0, 1, 2});
  look.add({0, 1, values.data(), 3});
  const auto stretch = look.write(file, {"650 nm", "550 nm", "450 nm"});
  file.publish();
  CHECK(stretch[1].low == 902);
  CHECK(stretch[1].high == 998);
  CHECK(stretch[2].low == stretch[2].high);
  unsigned width = 0, height = 0;
  const auto pixels = read_png(folder / "q.png", PNG_FORMAT_RGB, width, height);
  // Small as it is each pixel is shown as a square of 5 x 5, of one colour.
  REQUIRE(width == 505);
  REQUIRE(height == 5);
  for (std::size_t y = 0; y < 5; ++y)
    for (std::size_t k = 0; k < 5; ++k) {
      const auto at = [&](std::size_t x, std::size_t channel) { return pixels[(y * 505 + 5 * x + k) * 3 + channel]; };
      CHECK(at(0, 0) == 0);
      CHECK(at(100, 0) == 255);
      CHECK(at(50, 0) == 0);
      CHECK(at(50, 1) == 128);  // (950 - 902) / 96 = 0.5
      CHECK(at(26, 1) == 191);  // (974 - 902) / 96 = 0.75
      CHECK(at(50, 2) == 128);
    }
  const std::string text = folder.read("q.png");
  CHECK(text.find("green: band 2 (550 nm), linear from 902 to 998") != std::string::npos);
  CHECK(text.find("2nd to 98th percentile); each pixel as 5 x 5") != std::string::npos);
}

TEST_CASE("quicklook of a large image is averaged: memory stays bounded") {
  const std::int64_t side = 2100;
  Quicklook look(side, side, {0});
  CHECK(look.averaged_over() == 3);
  std::vector<float> line(static_cast<std::size_t>(side));
  for (std::int64_t y = 0; y < side; ++y) {
    for (std::int64_t x = 0; x < side; ++x)
      line[static_cast<std::size_t>(x)] = static_cast<float>(x % 3 + x / 3);  // mean of a triple: 1 + x/3
    look.add({y, 1, line.data(), 1});
  }
  const TestFolder folder;
  base::OutputFile file(folder / "q.png");
  const auto stretch = look.write(file, {"x"});
  file.publish();
  unsigned width = 0, height = 0;
  read_png(folder / "q.png", PNG_FORMAT_GRAY, width, height);
  CHECK(width == 700);
  CHECK(height == 700);
  CHECK(stretch[0].low == doctest::Approx(1 + 0.02 * 699).epsilon(0.1));  // one column of 700 is 1/14 of this value
  CHECK(stretch[0].high == doctest::Approx(1 + 0.98 * 699).epsilon(0.002));
}

TEST_CASE("default quicklook bands: visible where there is one, spread otherwise") {
  std::vector<double> um;
  for (int i = 0; i < 360; ++i) um.push_back(0.4 + i * 2.05 / 359);
  const auto rgb = default_quicklook_bands(um);
  REQUIRE(rgb.size() == 3);
  CHECK(um[static_cast<std::size_t>(rgb[0])] == doctest::Approx(0.65).epsilon(0.005));
  CHECK(um[static_cast<std::size_t>(rgb[2])] == doctest::Approx(0.45).epsilon(0.008));
  CHECK(default_quicklook_bands({8, 9, 10, 11, 12}) == std::vector<int>{3, 2, 1});
  CHECK(default_quicklook_bands({10, 11}) == std::vector<int>{0});
}

TEST_CASE("map grid: GDAL finds the corner, the pixel size and the UTM zone") {
  GDALAllRegister();
  for (const auto& [epsg, code] : {std::pair<int, const char*>{32618, "32618"}, {32733, "32733"}, {2056, "2056"}}) {
    CAPTURE(epsg);
    const TestFolder folder;
    EnviHeader h;
    h.samples = 4, h.lines = 3, h.bands = 1;
    set_map_grid(h, epsg, 276000.5, 4753000.25, 1.0, 2.0);
    base::OutputSet set(folder.path.string());
    EnviWriter writer(set, "m.img", h);
    const std::vector<float> values(12);
    writer.write({0, 3, values.data(), 0});
    writer.finish();
    set.publish();
    auto* gdal = static_cast<GDALDataset*>(GDALOpen((folder / "m.img").c_str(), GA_ReadOnly));
    REQUIRE(gdal != nullptr);
    double transform[6];
    REQUIRE(gdal->GetGeoTransform(transform) == CE_None);
    CHECK(transform[0] == 276000.5);
    CHECK(transform[1] == 1);
    CHECK(transform[3] == 4753000.25);
    CHECK(transform[5] == -2);
    const auto* system = gdal->GetSpatialRef();
    REQUIRE(system != nullptr);
    OGRSpatialReference wanted;
    wanted.importFromEPSG(epsg);
    const char* const loosely[] = {"CRITERION=EQUIVALENT", "IGNORE_DATA_AXIS_TO_SRS_AXIS_MAPPING=YES", nullptr};
    if (epsg != 2056) CHECK(system->IsSame(&wanted, loosely));  // UTM: GDAL rebuilds it from map info alone
    CHECK(system->IsProjected());
    GDALClose(gdal);
  }
  EnviHeader h;
  CHECK_THROWS_AS(set_map_grid(h, 4326, 0, 0, 1, 1), base::Error);    // degrees
  CHECK_THROWS_AS(set_map_grid(h, 999999, 0, 0, 1, 1), base::Error);  // unknown
}

TEST_CASE("run record is JSON with every figure of S62") {
  RunRecord r;
  r.command = "raycube render \"park.toml\"";
  r.seed = 18446744073709551615ull;
  r.stage_s = {{"build", 0.25}, {"trace", 3.5}};
  r.configuration_json = R"({"tolerance": 0.01})";
  r.files = {{"radiance.img", "radiance"}};
  const auto json = nlohmann::json::parse(run_record_json(r));
  CHECK(json["seed"] == 18446744073709551615ull);
  CHECK(json["command"] == r.command);
  CHECK(json["stage_s"]["trace"] == 3.5);
  CHECK(json["configuration"]["tolerance"] == 0.01);
  CHECK(json["plan"].is_null());
  for (const char* key : {"program", "device", "digest", "rays_per_s", "band_samples_per_s", "memory", "total_s"})
    CHECK(json.contains(key));
  r.plan_json = "{broken";
  CHECK_THROWS_AS(run_record_json(r), base::Error);
}
