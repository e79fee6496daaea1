// Sizes of launches chosen by a clock (here one whose times are known), and the file that keeps them.
#include <doctest/doctest.h>

#include <cstdlib>
#include <fstream>

#include "host/base/error.h"
#include "host/render/device_tuning.h"
#include "host/render/tuner.h"
#include "tests/unit/test_folder.h"

namespace {

using namespace raycube;

cl::DeviceInfo device(const std::string& name, bool is_cpu) {
  cl::DeviceInfo info;
  info.name = name, info.driver = "1.0", info.is_cpu = is_cpu, info.compute_units = 2;
  return info;
}

}  // namespace

TEST_CASE("every kernel gets its own fastest size; the first round counts for nothing; noise changes nothing") {
  int runs = 0, slower = 0;
  const auto choices = render::choose_sizes({1, 4, 16}, 1, 5, [&](std::size_t size) -> std::map<std::string, double> {
    ++runs;
    const double compile = runs <= 3 ? 100.0 / static_cast<double>(size) : 0;  // of the warm-up: favours the large ones
    const double busy = runs > 9 ? 10 : 1;                        // the machine gets slower half way: all do
    const double lucky = size == 4 && ++slower == 3 ? 1.5 : 0.7;  // median well ahead, one round behind
    return {{"trace", busy * (size == 16 ? 0.5 : 1.0) + compile},
            {"shade", busy * (size == 4 ? 0.97 : 1.0) + compile},
            {"resolve", busy * (size == 4 ? lucky : 1.0) + compile},
            {"rows", busy * (1.0 + 0.1 * static_cast<double>(size)) + compile},
            {"brief", busy * (size == 16 ? 0.001 : 0.004) + compile}};
  });
  CHECK(runs == 3 * 6);
  CHECK(choices.at("trace").size == 16);
  CHECK(choices.at("trace").seconds == doctest::Approx(5));
  CHECK(choices.at("trace").preset_seconds == doctest::Approx(10));
  CHECK(choices.at("shade").size == 1);    // 3 % is noise
  CHECK(choices.at("resolve").size == 1);  // not in every round
  CHECK(choices.at("rows").size == 1);
  CHECK(choices.at("brief").size == 1);  // 40 ms
  CHECK(choices.at("rows").candidates.size() == 3);
}

TEST_CASE("a preset other than 1 stays unless beaten, and what it does not launch gets no choice") {
  const auto choices = render::choose_sizes({1, 64}, 64, 3, [](std::size_t size) -> std::map<std::string, double> {
    if (size == 1) return {{"trace", 0.1}, {"shade", 1.0}, {"other", 1.0}};
    return {{"trace", 1.0}, {"shade", 1.0}};
  });
  CHECK(choices.at("trace").size == 1);
  CHECK(choices.at("shade").size == 64);
  CHECK(!choices.contains("other"));
}

TEST_CASE("sizes are kept for one device, survive another kernel's tuning, and a damaged file counts as none") {
  const testing::TestFolder home;
  ::setenv("XDG_CACHE_HOME", home.path.c_str(), 1);
  const auto cpu = device("a CPU", true), gpu = device("a GPU", false);
  CHECK(!render::read_tuning(cpu));
  CHECK(render::default_tuning(cpu).sizes.of("shade") == 1);
  CHECK(render::default_tuning(gpu).sizes.of("shade") == 64);

  render::DeviceTuning found = render::default_tuning(cpu);
  found.sizes.local = {{"shade", 8}, {"resolve", 2}};
  found.tile_samples = 12345;
  const auto path = render::tuning_file(cpu);
  const auto keep = [&] {
    auto file = render::claim_tuning(cpu);
    render::keep_tuning(cpu, found, file);
  };
  keep();
  CHECK(!render::read_tuning(gpu));
  auto kept = render::read_tuning(cpu);
  REQUIRE(kept);
  CHECK(kept->tuned);
  CHECK(kept->sizes.of("shade") == 8);
  CHECK(kept->sizes.of("trace_sun") == 1);
  CHECK(kept->tile_samples == 12345);

  found.sizes.local = {{"shade", 16}, {"lidar_shots", 4}};
  keep();
  kept = render::read_tuning(cpu);
  CHECK(kept->sizes.of("shade") == 16);
  CHECK(kept->sizes.of("resolve") == 2);
  CHECK(kept->sizes.of("lidar_shots") == 4);

  for (const char* damaged :
       {"", "{", R"({"local": {"shade": 0}, "tile_samples": 1})", R"({"local": {"shade": 8}})",
        R"({"local": {"shade": 99999}, "tile_samples": 1})", R"({"local": {"shade": 8}, "tile_samples": 0})",
        R"({"local": {"shade": "8"}, "tile_samples": 1})"}) {
    INFO(damaged);
    std::ofstream(path) << damaged;
    CHECK(!render::read_tuning(cpu));
  }
  home.write("file", "");
  ::setenv("XDG_CACHE_HOME", (home / "file").c_str(), 1);
  CHECK(!render::read_tuning(cpu));
  CHECK_THROWS_WITH_AS(render::claim_tuning(cpu), doctest::Contains("XDG_CACHE_HOME"), base::Error);
  ::unsetenv("XDG_CACHE_HOME");
  ::unsetenv("HOME");
  CHECK(!render::read_tuning(cpu));
  CHECK_THROWS_WITH_AS(render::claim_tuning(cpu), doctest::Contains("XDG_CACHE_HOME"), base::Error);
}
