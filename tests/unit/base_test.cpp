// host/base: hashing against FIPS 180-4 vectors, sizes, units, log and progress text.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include <nlohmann/json.hpp>
#include <unistd.h>

#include "host/base/error.h"
#include "host/base/log.h"
#include "host/base/memory.h"
#include "host/base/progress.h"
#include "host/base/sha256.h"
#include "host/base/text.h"
#include "host/base/units.h"

using namespace raycube::base;

TEST_CASE("SHA-256 gives the vectors of FIPS 180-4 (NIST examples)") {
  for (const auto code : {Sha256::Code::fastest, Sha256::Code::portable}) {
    CHECK(Sha256(code).hex() == "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
    CHECK(Sha256(code).add("abc").hex() == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    CHECK(Sha256(code).add("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq").hex() ==
          "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
    CHECK(Sha256(code)
              .add("abcdefghbcdefghicdefghijdefghijkefghijklfghijklmghijklmnhijklmnoijklmnopjklmnopqklmnopqrlmnopqrsmno"
                   "pqrstnopqrstu")
              .hex() == "cf5b16a778af8380036ce59e7b0492370b249b11e8f07a51afac45037afee9d1");
    CHECK(Sha256(code).add(std::string(1000000, 'a')).hex() ==
          "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
  }
}

TEST_CASE("SHA-256 does not depend on how the bytes are cut, nor on the processor's instructions") {
  std::string text;
  for (int i = 0; i < 1000; ++i) text += static_cast<char>(i * 37 + i / 7);
  const std::string whole = Sha256(Sha256::Code::portable).add(text).hex();
  for (std::size_t piece = 1; piece < 200; ++piece) {
    Sha256 hash;
    for (std::size_t at = 0; at < text.size(); at += piece) hash.add(std::string_view(text).substr(at, piece));
    CHECK(hash.hex() == whole);
  }
  for (std::size_t length = 0; length < 130; ++length)  // every position of the padding
    CHECK(Sha256().add(text.data(), length).hex() == Sha256(Sha256::Code::portable).add(text.data(), length).hex());
}

TEST_CASE("memory sizes: binary suffixes, and refusals that name the value") {
  CHECK(parse_memory_size("4096") == 4096);
  CHECK(parse_memory_size("256M") == 268435456);
  CHECK(parse_memory_size("8G") == 8589934592);
  CHECK(parse_memory_size("512MiB") == 536870912);
  CHECK(parse_memory_size("1.5g") == 1610612736);
  CHECK(parse_memory_size("64kb") == 65536);
  for (const std::string bad :
       {"", "G", "-1G", "0", "12Q", "1 G", "nan", "inf", "1e3", "4X", "9999999T", "8GBB", "0x10"}) {
    CAPTURE(bad);
    try {
      parse_memory_size(bad);
      FAIL("accepted");
    } catch (const Error& error) {
      CHECK(error.fault() == Fault::input);
      CHECK(std::string(error.what()).find("\"" + bad + "\"") != std::string::npos);
    }
  }
  CHECK(format_bytes(1) == "1 byte");
  CHECK(format_bytes(2147483648) == "2 GiB");
  CHECK(format_bytes(1023 * 1024 + 1000) == "1 MiB");
}

TEST_CASE("peak memory grows by what is touched (S62)") {
  const auto before = peak_resident_bytes();
  REQUIRE(before > 0);
  std::vector<char> touched(64 << 20, 1);
  const auto after = peak_resident_bytes();
  CHECK(touched[12345] == 1);
  CHECK(after >= before + (48u << 20));  // the peak before may lie up to the freed heap above the present size
}

TEST_CASE("unit conversions: the factors of REQUIREMENTS section 2") {
  CHECK(W_per_m2_sr_um_from_uW_per_cm2_sr_nm(1) == 10);
  CHECK(W_per_cm2_sr_um_from_W_per_m2_sr_um(W_per_m2_sr_um_from_uW_per_cm2_sr_nm(1)) ==
        doctest::Approx(1e-3).epsilon(1e-15));
  CHECK(um_from_wavenumber_per_cm(1000) == 10);
  CHECK(um_from_nm(550) == doctest::Approx(0.55).epsilon(1e-15));
  // 10 cm-1 at 2 um: 1e4/(5000-5) - 1e4/(5000+5) = 4.000004e-3 um; first order is right to 1e-6 of itself
  CHECK(width_um_from_per_cm(10, 2) == doctest::Approx(1e4 / 4995 - 1e4 / 5005).epsilon(2e-6));
  // The same Planck radiance both ways: 2 h c^2 nu^3/(exp(hc nu/kT)-1) per cm-1 against 2 h c^2/l^5/(...) per um, 10
  // um, 300 K
  const double h = 6.62607015e-34, c = 299792458, k = 1.380649e-23, T = 300, l_m = 10e-6, nu_per_m = 1e5;
  const double per_wavelength = 2 * h * c * c / std::pow(l_m, 5) / std::expm1(h * c / (l_m * k * T)) * 1e-6;
  const double per_wavenumber =
      2 * h * c * c * std::pow(nu_per_m, 3) / std::expm1(h * c * nu_per_m / (k * T)) * 1e2 * 1e-4;
  CHECK(per_wavelength == doctest::Approx(9.92403).epsilon(1e-6));  // golden of REQUIREMENTS section 3
  CHECK(W_per_m2_sr_um_from_W_per_cm2_sr_per_cm(per_wavenumber, 10) == doctest::Approx(per_wavelength).epsilon(1e-12));
  CHECK(W_per_cm2_sr_per_cm_from_W_per_m2_sr_um(per_wavelength, 10) == doctest::Approx(per_wavenumber).epsilon(1e-12));
}

TEST_CASE("progress says share, rate and time left, and fits the terminal") {
  CHECK(progress_text("render", 0, 320, "lines", 0, 0) == "render   0 % 0/320 lines");
  CHECK(progress_text("render", 80, 320, "lines", 10, 0) == "render  25 % 80/320 lines, 8 lines/s, 0:30 left");
  CHECK(progress_text("render", 320, 320, "lines", 40, 0) == "render 100 % 320/320 lines, 8 lines/s, took 0:40");
  CHECK(progress_text("render", 319, 320, "lines", 40, 0).find(" 99 %") != std::string::npos);
  for (int columns = 40; columns < 200; columns += 7)
    CHECK(progress_text("render", 160, 320, "lines", 40, columns).size() <
          std::max<std::size_t>(columns, progress_text("render", 160, 320, "lines", 40, 0).size() + 1));
  CHECK(progress_text("render", 160, 320, "lines", 40, 120).find(" [====================>                   ] ") !=
        std::string::npos);
  CHECK(format_duration(59.6) == "1:00");
  CHECK(format_duration(3 * 3600 + 7 * 60 + 40) == "3:07:40");
}

TEST_CASE("the JSON log holds every message and progress event, one object a line") {
  const auto path = std::filesystem::temp_directory_path() / ("raycube_log_" + std::to_string(::getpid()) + ".jsonl");
  {
    Log log({-2, path.string()});
    log.info("a \"quoted\" text\nof two lines");
    log.warning("odd byte \xff");
    double now_s = 0;
    Progress progress(log, "trace", 10, "tiles", [&] { return now_s; });
    now_s = 6;
    progress.advance(3);
    now_s = 6.05;
    progress.advance(3);  // too soon after the last report
    progress.advance(4);
  }
  std::ifstream in(path);
  std::vector<nlohmann::json> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(nlohmann::json::parse(line));
  REQUIRE(lines.size() == 6);
  CHECK(lines[0]["level"] == "info");
  CHECK(lines[0]["message"] == "a \"quoted\" text\nof two lines");
  CHECK(lines[1]["level"] == "warning");
  CHECK(lines[3]["event"] == "progress");
  CHECK(lines[3]["done"] == 3);
  CHECK(lines[3]["elapsed_s"] == 6);
  CHECK(lines[5]["done"] == 10);
  std::filesystem::remove(path);
}

TEST_CASE("a log that cannot be opened is an environment error that names the file") {
  try {
    Log log({0, "/proc/no/such/file.jsonl"});
    FAIL("accepted");
  } catch (const Error& error) {
    CHECK(error.fault() == Fault::environment);
    CHECK(std::string(error.what()).find("/proc/no/such/file.jsonl") != std::string::npos);
  }
}

TEST_CASE("counts are read as English: one thing, several things, and estimates in two digits") {
  CHECK(counted(1, "post") == "1 post");
  CHECK(counted(0, "post") == "0 posts");
  CHECK(counted(1, "vertex", "vertices") == "1 vertex");
  CHECK(counted(3, "post stands", "posts stand") == "3 posts stand");
  CHECK(about_count(0) == "0");
  CHECK(about_count(1.2) == "1");
  CHECK(about_count(99.7) == "100");
  CHECK(about_count(19321.7) == "19000");
  CHECK(about_count(6.3e6) == "6300000");
  CHECK(about_count(5e16) == "5.0e+16");
}
