// ENVI headers: what REQUIREMENTS section 2 expects of reading, writing and refusing. Oracle: the format's
// documentation, restated in hand-written headers.
#include <doctest/doctest.h>

#include <string>

#include "host/base/error.h"
#include "host/products/envi_header.h"

using namespace raycube;
using namespace raycube::products;

namespace {

const std::string kMinimal = "ENVI\nsamples = 4\nlines = 3\nbands = 2\ndata type = 4\ninterleave = bil\n";

std::string refusal(const std::string& text) {
  try {
    parse_envi_header(text, "x.hdr");
  } catch (const base::Error& error) {
    CHECK(error.fault() == base::Fault::input);
    return error.what();
  }
  FAIL("accepted: " << text);
  return "";
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST_CASE("keys in any case, lists over lines, CR LF, comments, defaults") {
  const auto h = parse_envi_header(
      "ENVI\r\n; a comment\r\nDescription = {\r\n  two\r\n  lines}\r\nSAMPLES = 4\r\nLines   = 3\r\nbands = "
      "2\r\nheader  Offset = 16\r\n"
      "data type = 12\r\nInterleave = BSQ\r\nbyte order = 1\r\nwavelength units = nanometers\r\n"
      "Wavelength = {\r\n 400.5,\r\n 500}\r\nband names = { red clay , blue,\r\n}\r\nfwhm = {5, 6,}\r\ndata ignore "
      "value = -1.23000002e+034\r\n"
      "my own key = {a {nested} value}\r\n",
      "x.hdr");
  CHECK(h.samples == 4);
  CHECK(h.header_offset == 16);
  CHECK(h.data_type == 12);
  CHECK(h.interleave == Interleave::bsq);
  CHECK(h.byte_order == 1);
  CHECK(h.description == "two\n  lines");
  CHECK(h.band_names == std::vector<std::string>{"red clay", "blue"});
  CHECK(h.wavelength_um() == std::vector<double>{400.5 * 1e-3, 500 * 1e-3});
  CHECK(h.fwhm.size() == 2);
  CHECK(*h.data_ignore_value == -1.23000002e+34);
  CHECK(h.other.at("my own key") == "{a {nested} value}");
  const auto minimal = parse_envi_header(kMinimal, "x.hdr");
  CHECK(minimal.header_offset == 0);
  CHECK(minimal.byte_order == 0);
}

TEST_CASE("S11 wavelengths in every unit become micrometres") {
  const auto um = [](const std::string& unit, const std::string& values) {
    return parse_envi_header(kMinimal + "wavelength units = " + unit + "\nwavelength = {" + values + "}\n", "x.hdr")
        .wavelength_um();
  };
  for (const auto& [unit, values] : {std::pair<std::string, std::string>{"Micrometers", "0.5, 2"},
                                     {"um", "0.5, 2"},
                                     {"Nanometers", "500, 2000"},
                                     {"nm", "500, 2000"},
                                     {"mm", "0.0005, 0.002"},
                                     {"cm", "0.00005, 0.0002"},
                                     {"m", "5e-7, 2e-6"},
                                     {"Angstroms", "5000, 20000"},
                                     {"Wavenumber", "20000, 5000"},
                                     {"GHz", "599584.916, 149896.229"},
                                     {"MHz", "599584916, 149896229"}}) {
    CAPTURE(unit);
    const auto got = um(unit, values);
    REQUIRE(got.size() == 2);
    CHECK(got[0] == doctest::Approx(0.5).epsilon(1e-14));
    CHECK(got[1] == doctest::Approx(2).epsilon(1e-14));
  }
  CHECK(um("Index", "1, 2").empty());
  CHECK(um("Unknown", "1, 2").empty());
}

TEST_CASE("bad headers: all problems at once, each with its line, value and rule") {
  const std::string all =
      refusal("ENVI\nsamples = -4\nlines = 3x\ndata type = 7\ninterleave = bpi\nbyte order = 2\nfwhm = {1, two}\n");
  for (const char* part : {"x.hdr:2: \"samples\" must be a whole number", "found -4", "x.hdr:3: \"lines\"", "found 3x",
                           "\"bands\" is missing", "\"data type\" must be one of", "\"interleave\" must be bip",
                           "\"byte order\"", "value 2 of \"fwhm\""})
    CHECK(contains(all, part));
  CHECK(contains(refusal(""), "first line must be ENVI"));
  CHECK(contains(refusal("GIF89a\n"), "first line must be ENVI"));
  CHECK(contains(refusal(kMinimal + "wavelength = {1, 2\nfwhm = 3\n"),
                 "x.hdr:7: the brace of \"wavelength\" is never closed"));
  CHECK(contains(refusal(kMinimal + "samples = 5\n"), "stands twice, first in line 2"));
  CHECK(contains(refusal("ENVI\nsamples = 10000000000\nlines = 1\nbands = 1\ndata type = 4\ninterleave = bip\n"),
                 "from 1 to 2147483648"));
  CHECK(contains(
      refusal("ENVI\nsamples = 2000000000\nlines = 2000000000\nbands = 2000000000\ndata type = 9\ninterleave = bip\n"),
      "2^62 bytes"));
  CHECK(contains(refusal(kMinimal + "bbl = {1, 3e27, 1}\n"), "x.hdr:7: \"bbl\" must be whole numbers from 0 to 1"));
  CHECK(contains(refusal(kMinimal + "default bands = {1.5}\n"), "\"default bands\" must be whole numbers"));
}

TEST_CASE("lists of another length are left out with a warning, as real files have them") {
  const auto h = parse_envi_header(kMinimal + "wavelength = {1, 2, 3}\ndefault bands = {1, 9, 2}\n", "x.hdr");
  CHECK(h.wavelength.empty());
  CHECK(h.default_bands.empty());
  CHECK(h.warnings.size() == 2);
}

TEST_CASE("a spectral library says so, or has one band and a name for each line; all else is an image") {
  const auto parsed = [](const std::string& bands, const std::string& more) {
    return parse_envi_header("ENVI\nsamples = 3\nlines = 2\n" + bands +
                                 "data type = 4\ninterleave = bsq\nwavelength units = nm\ndata gain values = {1, 2, "
                                 "3}\nwavelength = {400, 500, 600}\n" +
                                 more,
                             "x.hdr");
  };
  const std::string type = "file type = envi  Spectral Library\n", two = "spectra names = {a, b}\n";
  for (const auto& [bands, more] : {std::pair<std::string, std::string>{"bands = 1\n", two},
                                    {"", two},
                                    {"", type},
                                    {"bands = 1\n", type},
                                    {"bands = 1\n", type + "spectra names = {a}\n"}}) {
    CAPTURE(bands + more);
    const auto h = parsed(bands, more);
    CHECK(h.spectral_library);
    CHECK(h.bands == 1);
    CHECK(h.wavelength_um().size() == 3);
    CHECK(h.scaled(10, 2, 0) == 30);
  }
  // Images: lists go by bands, whatever stands in the file besides; what does not fit is left out.
  for (const auto& [bands, more] : {std::pair<std::string, std::string>{"bands = 5\n", "spectra names = {a}\n"},
                                    {"bands = 5\n", two},
                                    {"bands = 1\n", "spectra names = {a, b, c}\n"},
                                    {"bands = 2\n", two},
                                    {"bands = 5\n", ""}}) {
    CAPTURE(bands + more);
    const auto h = parsed(bands, more);
    CHECK_FALSE(h.spectral_library);
    CHECK(h.wavelength.empty());
    CHECK(h.data_gain.empty());
    CHECK(h.spectra_names.empty());
    CHECK(h.scaled(10, 2, 4) == 10);
    CHECK(h.warnings.size() == (more.empty() ? 2 : 3));
  }
  const auto cube = parsed("bands = 3\n", "spectra names = {a, b}\ndata offset values = {1, 2, 3}\n");
  CHECK(cube.wavelength_um() == std::vector<double>{400 * 1e-3, 500 * 1e-3, 600 * 1e-3});
  CHECK(cube.scaled(10, 0, 2) == 33);
  CHECK(contains(cube.warnings.at(0), "\"spectra names\" is ignored: the file is an image"));
  // A library of several bands keeps lists by sample, which nobody reads by band; its readers refuse it.
  const auto odd = parsed("bands = 5\n", type);
  CHECK(odd.spectral_library);
  CHECK(odd.scaled(10, 2, 4) == 30);
  CHECK(
      contains(refusal("ENVI\nsamples = 3\nlines = 2\ndata type = 4\nspectra names = {a}\n"), "\"bands\" is missing"));
}

TEST_CASE("widths and wavelengths that are none are left out and told: of wavenumbers, twice the centre") {
  const auto parsed = [](const std::string& unit, const std::string& centres, const std::string& widths) {
    return parse_envi_header(
        kMinimal + "wavelength units = " + unit + "\nwavelength = {" + centres + "}\nfwhm = {" + widths + "}\n",
        "x.hdr");
  };
  for (const char* width : {"2000", "2100", "-5", "inf", "nan"}) {
    CAPTURE(width);
    for (const char* unit : {"Wavenumber", "GHz"}) {
      const auto h = parsed(unit, "2000, 1000", std::string("10, ") + width);
      CHECK(h.fwhm_um().empty());
      CHECK(h.wavelength_um().size() == 2);
      REQUIRE(h.warnings.size() == 1);
      CHECK(contains(h.warnings[0], "x.hdr: value 2 of \"fwhm\", " + std::string(width)));
    }
  }
  CHECK(parsed("nm", "500, 600", "10, -5").fwhm_um().empty());
  CHECK(parsed("Wavenumber", "1000, 0", "1, 1").wavelength_um().empty());
  CHECK(parsed("nm", "500, nan", "1, 1").wavelength_um().empty());
  const auto sound = parsed("Wavenumber", "1000, 2000", "1999, 0");
  CHECK(sound.warnings.empty());
  CHECK(sound.fwhm_um().at(0) == doctest::Approx(1e4 / 0.5 - 1e4 / 1999.5));
}

TEST_CASE("what is written is read back the same") {
  EnviHeader h;
  h.samples = 320, h.lines = 200, h.bands = 3;
  h.description = "a {braced}, two-line\ntext";
  h.interleave = Interleave::bip;
  h.sensor_type = "spectir";
  h.acquisition_time = "2012-09-20T15:30:00Z";
  h.sun_azimuth_deg = 160.25, h.sun_elevation_deg = 50;
  h.data_units = "W m-2 sr-1 um-1";
  h.wavelength_units = "Nanometers";
  h.wavelength = {399.4, 404.0, 408.6};
  h.fwhm = {5.1, 5.2, 5.3};
  h.band_names = {"one", "two, with comma", "three"};
  h.default_bands = {3, 2, 1};
  h.data_ignore_value = -9999;
  h.map_info = {"UTM", "1", "1", "276000", "4753000", "1", "1", "18", "North", "WGS-84", "units=Meters"};
  h.other["raycube seed"] = "7";
  const auto back = parse_envi_header(envi_header_text(h), "x.hdr");
  CHECK(back.description == "a (braced), two-line text");
  CHECK(back.samples == 320);
  CHECK(back.wavelength == h.wavelength);
  CHECK(back.fwhm == h.fwhm);
  CHECK(back.band_names == std::vector<std::string>{"one", "two; with comma", "three"});
  CHECK(back.default_bands == h.default_bands);
  CHECK(back.map_info == h.map_info);
  CHECK(back.sun_azimuth_deg == h.sun_azimuth_deg);
  CHECK(back.data_ignore_value == h.data_ignore_value);
  CHECK(back.other == h.other);
  CHECK(back.warnings.empty());
  CHECK(envi_header_text(h).find('\t') == std::string::npos);
}
