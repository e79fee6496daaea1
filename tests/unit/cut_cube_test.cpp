// Cubes that another program cuts while they are read: an error that names the file, and no SIGBUS.
#include <doctest/doctest.h>

#include <atomic>
#include <filesystem>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "host/analysis/cube.h"
#include "host/analysis/k_means.h"
#include "host/base/error.h"
#include "tests/unit/test_folder.h"

using namespace raycube;

namespace {

constexpr int kLines = 64, kSamples = 64, kBands = 8;

/// A cube of floats, pixel by pixel, that no two pixels of are alike.
std::string write_cube(const testing::TestFolder& folder) {
  std::vector<float> values(kLines * kSamples * kBands);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<float>((i * 7919) % 10007);
  folder.write("cube.img", std::string(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float)));
  folder.write("cube.hdr", fmt::format("ENVI\nsamples = {}\nlines = {}\nbands = {}\nheader offset = 0\ndata type = 4\n"
                                       "interleave = bip\nbyte order = 0\n",
                                       kSamples, kLines, kBands));
  return folder / "cube.img";
}

/// What k-means says of a cube that has `left` bytes from the moment on when `lines` lines were seen.
std::string said_when_cut(std::uintmax_t left, std::int64_t lines) {
  const testing::TestFolder folder;
  const std::string path = write_cube(folder);
  const analysis::Cube cube(path);
  std::atomic<std::int64_t> seen{0};
  analysis::Pass pass;
  pass.threads = 2;
  pass.after_lines = [&](std::int64_t more) {
    if ((seen += more) >= lines) std::filesystem::resize_file(path, left);
  };
  try {
    analysis::k_means(cube, {}, pass);
  } catch (const base::Error& error) {
    CHECK(error.fault() == base::Fault::environment);
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("a cube that is cut during k-means is an error that names its bytes") {
  const std::uintmax_t whole = kLines * kSamples * kBands * sizeof(float);
  for (const std::uintmax_t left : {std::uintmax_t{0}, std::uintmax_t{4096}, std::uintmax_t{50001}, whole - 1})
    for (const std::int64_t lines : {std::int64_t{1}, std::int64_t{kLines}}) {
      CAPTURE(left);
      CAPTURE(lines);
      const std::string said = said_when_cut(left, lines);
      CAPTURE(said);
      CHECK(said.find("cube.img: was cut while it was read") != std::string::npos);
      CHECK(said.find(fmt::format("its header describes {} bytes (found {})", whole, left)) != std::string::npos);
    }
}
