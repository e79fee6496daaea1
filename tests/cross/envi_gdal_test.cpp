// Our ENVI reader and writer against GDAL's, an independent implementation; and real files nobody here wrote.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdlib>

#include <gdal_priv.h>

#include "host/base/error.h"
#include "host/products/digest.h"
#include "host/products/envi_reader.h"
#include "host/products/envi_writer.h"
#include "tests/unit/test_folder.h"
#include "tests/support/skipped.h"

using namespace raycube;
using namespace raycube::products;
using raycube::testing::TestFolder;

namespace {

/// A value that no wrong order of axes reproduces.
float value_at(std::int64_t line, std::int64_t sample, std::int64_t band) {
  return static_cast<float>(line * 1000 + sample) + 0.01f * static_cast<float>(band);
}

struct GdalFile {
  GDALDataset* set;
  explicit GdalFile(const std::string& path) {
    GDALAllRegister();
    set = static_cast<GDALDataset*>(GDALOpen(path.c_str(), GA_ReadOnly));
  }
  ~GdalFile() {
    if (set) GDALClose(set);
  }
  std::vector<double> all(int parts) const {  // (line, sample, band)
    const int nx = set->GetRasterXSize(), ny = set->GetRasterYSize(), nb = set->GetRasterCount();
    std::vector<double> out(static_cast<std::size_t>(nx) * ny * nb * parts);
    const GSpacing item = 8 * parts;
    REQUIRE(set->RasterIO(GF_Read, 0, 0, nx, ny, out.data(), nx, ny, parts == 2 ? GDT_CFloat64 : GDT_Float64, nb,
                          nullptr, item * nb, item * nb * nx, item, nullptr) == CE_None);
    return out;
  }
};

EnviHeader small_header(Interleave interleave) {
  EnviHeader h;
  h.samples = 70, h.lines = 23, h.bands = 67;  // across the 64-blocks of the transpose
  h.interleave = interleave;
  h.wavelength_units = "Micrometers";
  for (int b = 0; b < 67; ++b) {
    h.wavelength.push_back(0.4 + 0.01 * b);
    h.fwhm.push_back(0.012);
    h.band_names.push_back("band " + std::to_string(b));
  }
  h.default_bands = {30, 20, 10};
  return h;
}

/// Writes value_at in strips of `lines_each`, pixels `stride` apart.
std::string write_cube(const TestFolder& folder, const EnviHeader& h, std::int64_t lines_each, std::size_t stride,
                       std::optional<double> scale = {}, std::string* digest = nullptr) {
  base::OutputSet set(folder.path.string(), base::IfExists::replace);
  EnviWriter writer(set, "cube.img", h, scale);
  Digest hash;
  for (std::int64_t line = 0; line < h.lines; line += lines_each) {
    const std::int64_t lines = std::min(lines_each, h.lines - line);
    std::vector<float> values(static_cast<std::size_t>(lines * h.samples) * stride, -777.0f);
    for (std::int64_t l = 0; l < lines; ++l)
      for (std::int64_t x = 0; x < h.samples; ++x)
        for (std::int64_t b = 0; b < h.bands; ++b)
          values[static_cast<std::size_t>(l * h.samples + x) * stride + static_cast<std::size_t>(b)] =
              value_at(line + l, x, b);
    const Strip strip{line, lines, values.data(), stride};
    writer.write(strip);
    hash.add_radiance(strip, h.samples, h.bands);
  }
  writer.finish();
  if (digest) {
    if (!scale) hash.add_truth(writer);
    *digest = hash.hex();
  }
  set.publish();
  return folder / "cube.img";
}

const char* shared_folder() {
  const char* folder = std::getenv("RAYCUBE_SHARED");
  if (folder && *folder) return folder;
  raycube::testing::skip_part("real ENVI files are not read");
  return nullptr;
}

}  // namespace

TEST_CASE("what we write in each interleave, GDAL reads: samples, wavelengths, names (DESIGN section 8)") {
  std::string digest, first_digest;
  for (const auto interleave : {Interleave::bip, Interleave::bil, Interleave::bsq})
    for (const std::int64_t lines_each : {1, 7, 23})
      for (const std::size_t stride : {std::size_t{67}, std::size_t{80}}) {
        CAPTURE(to_string(interleave));
        CAPTURE(lines_each);
        const TestFolder folder;
        const std::string path = write_cube(folder, small_header(interleave), lines_each, stride, {}, &digest);
        if (first_digest.empty()) first_digest = digest;
        CHECK(digest == first_digest);  // independent of interleave, strips and padding
        CHECK(folder.names() == std::set<std::string>{"cube.hdr", "cube.img"});
        const GdalFile gdal(path);
        REQUIRE(gdal.set != nullptr);
        REQUIRE(gdal.set->GetRasterCount() == 67);
        CHECK(gdal.set->GetRasterBand(1)->GetRasterDataType() == GDT_Float32);
        const auto values = gdal.all(1);
        std::size_t wrong = 0;
        for (int l = 0; l < 23; ++l)
          for (int x = 0; x < 70; ++x)
            for (int b = 0; b < 67; ++b)
              wrong += values[(static_cast<std::size_t>(l) * 70 + x) * 67 + b] != value_at(l, x, b);
        CHECK(wrong == 0);
        CHECK(std::string(gdal.set->GetRasterBand(31)->GetMetadataItem("wavelength")) == "0.7");
        CHECK(std::string(gdal.set->GetRasterBand(31)->GetMetadataItem("wavelength_units")) == "Micrometers");
        CHECK(EnviReader(path).read_lines(0, 23) == values);
      }
}

TEST_CASE("scaled uint16: GDAL sees the gain, values return within half a step, clipping is counted") {
  const TestFolder folder;
  const double scale = 2.5;
  const std::string path = write_cube(folder, small_header(Interleave::bsq), 5, 67, scale);
  const EnviReader reader(path);
  CHECK(reader.header().data_type == 12);
  const auto values = reader.read_lines_scaled(0, 23);
  double worst = 0;
  for (int l = 0; l < 23; ++l)
    for (int x = 0; x < 70; ++x)
      for (int b = 0; b < 67; ++b)
        worst = std::max(worst, std::abs(values[(static_cast<std::size_t>(l) * 70 + x) * 67 + b] - value_at(l, x, b)));
  CHECK(worst <= 0.5 / scale + 22070 * 6e-8);  // half a step, and one float rounding of the largest product
  const GdalFile gdal(path);
  REQUIRE(gdal.set != nullptr);
  CHECK(gdal.set->GetRasterBand(1)->GetRasterDataType() == GDT_UInt16);
  CHECK(gdal.set->GetRasterBand(5)->GetScale() == doctest::Approx(1 / scale));

  base::OutputSet set((folder.path / "clip").string());
  EnviHeader h;
  h.samples = 6, h.lines = h.bands = 1;
  EnviWriter writer(set, "c.img", h, 100.0);
  const float v[6] = {-0.004f, -0.006f, 655.35f, 655.36f, NAN, INFINITY};
  writer.write({0, 1, v, 0});
  writer.finish();
  CHECK(writer.clipped().low == 1);
  CHECK(writer.clipped().high == 2);
  CHECK(writer.clipped().nan == 1);
  set.publish();
  CHECK(EnviReader(folder / "clip/c.img").read_lines(0, 1) == std::vector<double>{0, 0, 65535, 65535, 0, 65535});
}

TEST_CASE("every ENVI data type and interleave that GDAL writes, we read alike") {
  GDALAllRegister();
  auto* driver = GetGDALDriverManager()->GetDriverByName("ENVI");
  for (const auto type :
       {GDT_Byte, GDT_Int16, GDT_Int32, GDT_Float32, GDT_Float64, GDT_CFloat32, GDT_CFloat64, GDT_UInt16, GDT_UInt32})
    for (const char* interleave : {"INTERLEAVE=BSQ", "INTERLEAVE=BIL", "INTERLEAVE=BIP"})
      for (const char* suffix : {"SUFFIX=ADD", static_cast<const char*>(nullptr)}) {  // g.img.hdr, g.hdr
        CAPTURE(GDALGetDataTypeName(type));
        CAPTURE(interleave);
        const TestFolder folder;
        const std::string path = folder / "g.img";
        const char* options[] = {interleave, suffix, nullptr};
        auto* set = driver->Create(path.c_str(), 5, 4, 3, type, const_cast<char**>(options));
        REQUIRE(set != nullptr);
        std::vector<std::complex<double>> values(60);
        for (std::size_t i = 0; i < values.size(); ++i)
          values[i] = {static_cast<double>(i * 4 + 1), static_cast<double>(i) * 0.5};
        REQUIRE(set->RasterIO(GF_Write, 0, 0, 5, 4, values.data(), 5, 4, GDT_CFloat64, 3, nullptr, 48, 240, 16,
                              nullptr) == CE_None);
        GDALClose(set);
        const EnviReader reader(path);
        const int parts = reader.header().type().components;
        const auto whole = reader.read_lines(0, 4);
        CHECK(whole == GdalFile(path).all(parts));
        const auto pixel = reader.read_pixel(2, 3);
        CHECK(std::equal(pixel.begin(), pixel.end(), whole.begin() + (2 * 5 + 3) * 3 * parts));
      }
}

TEST_CASE("big-endian files of every type give the numbers of their little-endian twins") {
  for (const int code : {1, 2, 3, 4, 5, 6, 9, 12, 13, 14, 15}) {
    CAPTURE(code);
    const TestFolder folder;
    const auto* type = find_envi_type(code);
    const std::size_t part = type->bytes / static_cast<std::size_t>(type->components);
    std::string little;
    for (std::size_t i = 0; i < 6 * type->bytes; ++i)
      little += static_cast<char>(i % part == part - 1 ? 0x40 + i % 5 : i * 29 + 7);
    std::string big = little;
    for (std::size_t at = 0; at < big.size(); at += part)
      std::reverse(big.begin() + static_cast<std::ptrdiff_t>(at), big.begin() + static_cast<std::ptrdiff_t>(at + part));
    const std::string header =
        "ENVI\nsamples = 3\nlines = 2\nbands = 1\nheader offset = 5\ndata type = " + std::to_string(code) +
        "\ninterleave = bip\nfile type = ENVI Standard\n";
    folder.write("l.img", "12345" + little);
    folder.write("l.img.hdr", header + "byte order = 0\n");
    folder.write("b.img", "12345" + big);
    folder.write("b.hdr", header + "byte order = 1\n");
    const auto values = EnviReader(folder / "l.img.hdr").read_lines(0, 2);
    CHECK(EnviReader(folder / "b.img").read_lines(0, 2) == values);
    if (code < 14)
      CHECK(GdalFile(folder / "b.img").all(type->components) == values);  // GDAL 3.6 has no 64-bit integers in ENVI
  }
}

TEST_CASE("64-bit integers, signed and unsigned, both byte orders") {
  const TestFolder folder;
  const std::string header = "ENVI\nsamples = 1\nlines = 2\nbands = 1\ninterleave = bsq\nbyte order = 1\ndata type = ";
  const std::string data("\xff\xff\xff\xff\xff\xff\xff\xfe\x00\x00\x00\x01\x00\x00\x00\x07", 16);
  folder.write("s", data);
  folder.write("s.hdr", header + "14\n");
  folder.write("u", data);
  folder.write("u.hdr", header + "15\n");
  CHECK(EnviReader(folder / "s").read_lines(0, 2) == std::vector<double>{-2, 4294967303.0});
  CHECK(EnviReader(folder / "u").read_lines(0, 2) == std::vector<double>{18446744073709551614.0, 4294967303.0});
}

TEST_CASE("refusals: truncated file, 0-byte file, a 10 GB dimension in a small header, missing halves of the pair") {
  const TestFolder folder;
  const auto refusal = [&](const std::string& name) -> std::string {
    try {
      EnviReader reader(folder / name);
    } catch (const base::Error& error) {
      CHECK(error.fault() == base::Fault::input);
      return error.what();
    }
    FAIL("accepted " << name);
    return "";
  };
  const std::string header = "ENVI\nsamples = 3\nlines = 2\nbands = 1\ndata type = 4\ninterleave = bip\n";
  folder.write("short.img", std::string(23, 'x'));
  folder.write("short.hdr", header);
  CHECK(refusal("short.img").find("need 24 bytes (found 23)") != std::string::npos);
  folder.write("empty.img", "");
  folder.write("empty.hdr", "");
  CHECK(refusal("empty.img").find("an empty file") != std::string::npos);
  folder.write("huge.img", std::string(24, 'x'));
  folder.write("huge.hdr", "ENVI\nsamples = 50000\nlines = 50000\nbands = 1\ndata type = 4\ninterleave = bip\n");
  CHECK(refusal("huge.img").find("need 10000000000 bytes (found 24)") != std::string::npos);
  folder.write("lone.img", "abc");
  CHECK(refusal("lone.img").find("header is missing") != std::string::npos);
  folder.write("half.hdr", header);
  CHECK(refusal("half.hdr").find("data file is missing") != std::string::npos);
  CHECK(refusal("nothing.img").find("no such file") != std::string::npos);
}

TEST_CASE("strips that come twice and unfinished images are our bugs, and nothing is published") {
  const TestFolder folder;
  base::OutputSet set(folder.path.string());
  EnviHeader h;
  h.samples = h.lines = 2, h.bands = 1;
  EnviWriter writer(set, "a.img", h);
  const float values[4] = {};
  writer.write({1, 1, values, 0});
  CHECK_THROWS_AS(writer.write({1, 1, values, 0}), base::Error);
  CHECK_THROWS_AS(writer.finish(), base::Error);
  CHECK_THROWS_AS(writer.write({1, 2, values, 0}), base::Error);
}

TEST_CASE("real ENVI files from seven instruments read as GDAL reads them") {
  const char* shared = shared_folder();
  if (!shared) return;
  const std::filesystem::path folder = std::filesystem::path(shared) / "data/envi";
  int read = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() != ".hdr") continue;
    CAPTURE(entry.path().string());
    const EnviReader reader(entry.path().string());
    const GdalFile gdal(reader.paths().data);
    if (!gdal.set) {
      MESSAGE("GDAL does not open " << reader.paths().data);
      continue;
    }
    const auto ours = reader.read_lines(0, reader.header().lines), theirs = gdal.all(reader.header().type().components);
    REQUIRE(ours.size() == theirs.size());
    std::size_t different = 0;
    for (std::size_t i = 0; i < ours.size(); ++i)
      different += !(ours[i] == theirs[i] || (std::isnan(ours[i]) && std::isnan(theirs[i])));
    CHECK(different == 0);
    ++read;
  }
  CHECK(read >= 12);
  for (const auto& entry : std::filesystem::directory_iterator(folder / "headers_only")) {
    CAPTURE(entry.path().string());
    const EnviHeader h = read_envi_header(entry.path().string());
    CHECK(h.bands >= 1);
    CHECK(parse_envi_header(envi_header_text(h), "again").wavelength == h.wavelength);
  }
}

TEST_CASE("the same EnMAP image in BIL and BSQ gives the same numbers") {
  const char* shared = shared_folder();
  if (!shared) return;
  const std::string stem = std::string(shared) + "/data/envi/enmap_potsdam_32x32x224_";
  const EnviReader bil(stem + "bil.hdr"), bsq(stem + "bsq.dat");
  CHECK(bil.header().band_names.size() == 224);
  CHECK(bil.read_lines(0, 32) == bsq.read_lines(0, 32));
}
