// The time cube by GDAL and by our ENVI reader; tables by their text.
#include <doctest/doctest.h>

#include <cmath>

#include <gdal_priv.h>
#include <ogr_spatialref.h>

#include "host/base/error.h"
#include "host/products/csv_writer.h"
#include "host/products/envi_reader.h"
#include "host/products/map_grid.h"
#include "host/products/time_cube.h"
#include "tests/unit/test_folder.h"

using namespace raycube;
using namespace raycube::products;
using raycube::testing::TestFolder;

namespace {
constexpr int kBins = 333, kPixels = 3, kPulses = 41;
/// A value that no wrong order of axes reproduces.
float value_at(int line, int bin, int band) {
  return static_cast<float>(line * 1000 + bin) + 0.25f * static_cast<float>(band);
}
}  // namespace

TEST_CASE(
    "LIDAR 11.1: a time cube whose number of lines nobody knew before is read by GDAL and by our reader, time axis in "
    "the header") {
  TestFolder folder;
  {
    base::OutputSet set(folder.path.string());
    TimeCubeWriter writer(set.add("waveforms.img"), set.add("waveforms.hdr"), {3.9e-6, 0.5e-9, kBins, 1.0003, kPixels},
                          {{"on expected [photons]", 1.6455012345}, {"off expected [photons]", 1.6456}});
    std::vector<float> row(2 * kBins);
    for (int line = 0; line < kPulses * kPixels; ++line) {
      for (int band = 0; band < 2; ++band)
        for (int bin = 0; bin < kBins; ++bin)
          row[static_cast<std::size_t>(band * kBins + bin)] = value_at(line, bin, band);
      writer.add(row);
    }
    CHECK_THROWS_AS(writer.add({1.0f}), base::Error);
    writer.finish("waveforms", "raycube flash", "2026-06-21T10:00:00Z");
    set.publish();
  }
  GDALAllRegister();
  auto* const set = static_cast<GDALDataset*>(GDALOpen((folder / "waveforms.img").c_str(), GA_ReadOnly));
  REQUIRE(set);
  CHECK(set->GetRasterXSize() == kBins);
  CHECK(set->GetRasterYSize() == kPulses * kPixels);
  CHECK(set->GetRasterCount() == 2);
  std::vector<float> band_values(static_cast<std::size_t>(kBins) * kPulses * kPixels);
  for (int band = 0; band < 2; ++band) {
    REQUIRE(set->GetRasterBand(band + 1)->RasterIO(GF_Read, 0, 0, kBins, kPulses * kPixels, band_values.data(), kBins,
                                                   kPulses * kPixels, GDT_Float32, 0, 0) == CE_None);
    std::size_t wrong = 0;
    for (int line = 0; line < kPulses * kPixels; ++line)
      for (int bin = 0; bin < kBins; ++bin)
        wrong += band_values[static_cast<std::size_t>(line * kBins + bin)] != value_at(line, bin, band);
    CHECK(wrong == 0);
  }
  const char* const start = set->GetMetadataItem("raycube_bin_start_ns", "ENVI");
  REQUIRE(start);
  CHECK(std::string(start) == "3900");
  CHECK(std::string(set->GetMetadataItem("raycube_bin_width_ns", "ENVI")) == "0.5");
  GDALClose(set);

  const EnviReader reader(folder / "waveforms.img");
  CHECK(reader.header().wavelength_um() == std::vector<double>{1.6455012345, 1.6456});
  CHECK(reader.header().other.at("raycube group index") == "1.0003");
  CHECK(reader.header().other.at("raycube pixels") == "3");
  CHECK(reader.read_pixel(7, 300) == std::vector<double>{value_at(7, 300, 0), value_at(7, 300, 1)});
}

TEST_CASE("LIDAR 11.1: tables keep every digit, quote what must be quoted, and leave not-a-number empty") {
  TestFolder folder;
  {
    base::OutputFile file(folder / "a.csv");
    CsvWriter csv(file, {"name", "value_m", "count"});
    csv.add("plain").add(0.1).add(std::int64_t{-9007199254740993}).end_row();
    csv.add("with \"quotes\", comma").add(std::nan("")).add(0.1f).end_row();
    csv.add("only one");
    CHECK_THROWS_AS(csv.end_row(), base::Error);
  }
  {
    base::OutputFile file(folder / "b.csv");
    CsvWriter csv(file, {"name", "value_m", "count"});
    csv.add("plain").add(0.1).add(std::int64_t{-9007199254740993}).end_row();
    csv.add("with \"quotes\", comma").add(std::nan("")).add(0.1f).end_row();
    CHECK(csv.rows() == 2);
    csv.finish();
    file.publish();
  }
  CHECK(folder.read("b.csv") ==
        "name,value_m,count\nplain,0.1,-9007199254740993\n\"with \"\"quotes\"\", comma\",,0.1\n");
}

TEST_CASE("L-28: LAS: the coordinate system of a LAS file is OGC WKT 1 that GDAL knows as the code it came from") {
  const std::string wkt = projected_wkt(32618);
  CHECK(wkt.rfind("PROJCS[\"WGS 84 / UTM zone 18N\"", 0) == 0);
  OGRSpatialReference system;
  REQUIRE(system.importFromWkt(wkt.c_str()) == OGRERR_NONE);
  CHECK(std::string(system.GetAuthorityCode(nullptr)) == "32618");
  CHECK_THROWS_AS(projected_wkt(4326), base::Error);  // geographic: no metres
  CHECK_THROWS_AS(projected_wkt(999999), base::Error);
}
