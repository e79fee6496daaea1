// Converged references on disk: a hit, a miss for every change that counts, a damaged file computed anew.
#include <doctest/doctest.h>

#include <filesystem>
#include <fstream>
#include <functional>

#include "host/study/kept.h"
#include "tests/unit/test_folder.h"

using namespace raycube;

namespace {

study::Converged some(double value) { return {2, {value, 2, 3, 4}, {0.5, 0, 0, -0.5}}; }

}  // namespace

TEST_CASE("S64 a kept reference is found again bit for bit; another key, or a damaged file, is computed anew") {
  const testing::TestFolder folder;
  int computed = 0;
  const auto get = [&](const std::string& key, study::Kept* kept = nullptr) {
    return study::kept_or(
        folder.path.string(), key, [&] { return ++computed, some(1.0 / 3); }, kept);
  };
  const std::string one(64, 'a'), two(64, 'b');
  study::Kept kept;
  get(one, &kept);
  CHECK(computed == 1);
  CHECK_FALSE(kept.found);
  CHECK(kept.warning.empty());
  const study::Converged again = get(one, &kept);
  CHECK(computed == 1);
  CHECK(kept.found);
  CHECK(again.bands == 2);
  CHECK(again.radiance == some(1.0 / 3).radiance);
  CHECK(again.half == some(1.0 / 3).half);
  get(two);
  CHECK(computed == 2);

  const std::string file = folder.path.string() + "/" + one + ".ref";
  const auto size = std::filesystem::file_size(file);
  const auto change = [&](const std::function<void()>& harm, const char* says) {
    harm();
    study::Kept now;
    const int before = computed;
    CHECK(get(one, &now).radiance == some(1.0 / 3).radiance);
    CHECK(computed == before + 1);
    CHECK_FALSE(now.found);
    CHECK(now.warning.find(says) != std::string::npos);
    study::Kept after;
    get(one, &after);
    CHECK(after.found);  // replaced by a whole one
  };
  for (const std::streamoff at : {std::streamoff{3}, std::streamoff{50}, static_cast<std::streamoff>(size) - 40})
    change(
        [&] {
          std::fstream bytes(file, std::ios::in | std::ios::out | std::ios::binary);
          bytes.seekg(at);
          const char old = static_cast<char>(bytes.get());
          bytes.seekp(at);
          bytes.put(static_cast<char>(old ^ 1));
        },
        "is damaged");
  change([&] { std::filesystem::resize_file(file, size - 8); }, "is damaged");
  change([&] { std::filesystem::resize_file(file, 10); }, "is cut short");
  change(
      [&] {
        std::filesystem::copy_file(folder.path.string() + "/" + two + ".ref", file,
                                   std::filesystem::copy_options::overwrite_existing);
      },
      "is of something else");
}

TEST_CASE("S64 nothing is kept without a folder or a key") {
  int computed = 0;
  for (int i = 0; i < 2; ++i) {
    study::kept_or("", std::string(64, 'a'), [&] { return ++computed, some(1); });
    study::kept_or("/nowhere", "", [&] { return ++computed, some(1); });
  }
  CHECK(computed == 4);
}

TEST_CASE("S64 the key follows scene, instrument, air, pixels and settings, and nothing of a plan's nodes") {
  scene::Simulation simulation;
  simulation.scene.content_hash = "one";
  scene::Instrument camera;
  camera.pixels = 8, camera.lines = 8;
  camera.poses.resize(1);
  plan::Plan plan;
  plan.wavelength_um = {0.5, 0.6};
  plan.bands = {{0, {0.5, 0.5}}};
  atmos::RenderTable table;
  table.rows["solar_irradiance"].values = {1, 2};
  std::vector<render::Tile> tiles = {{0, 1, 0, 4}};
  study::ConvergedSettings settings;
  const auto key = [&] { return study::key_of(simulation, camera, plan, table, tiles, settings); };
  const std::string first = key();
  CHECK(first.size() == 64);
  CHECK(key() == first);
  const auto differs = [&](auto& value, auto other) {
    const auto old = value;
    value = other;
    CHECK(key() != first);
    value = old;
    CHECK(key() == first);
  };
  differs(simulation.scene.content_hash, std::string("two"));
  differs(simulation.seed, std::uint64_t{2});
  differs(camera.poses[0].z_m, 5.0);
  differs(camera.psf_sigma_px, 0.5);
  differs(camera.ifov_along_rad, 1e-3);
  differs(table.rows["solar_irradiance"].values[1], 2.5f);
  differs(table.sun_zenith_deg, 30.0);
  differs(plan.bands[0].weight[0], 0.4);
  differs(plan.sun_up, false);
  differs(tiles[0].first_line, 1);
  differs(settings.grid, 5);
  differs(settings.per_sample, 5);
  settings.threads = 3;  // changes no result
  camera.samples_u = 3, camera.sampler = scene::SamplerKind::lattice;
  plan.height.count = 5, plan.sky_components = 3;
  CHECK(key() == first);
  simulation.scene.content_hash.clear();
  CHECK(key().empty());
}
