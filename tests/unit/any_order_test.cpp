// The products of a cube take strips in any order and in pieces: the same bytes and hashes as in order, and nothing
// under a final name while a piece is missing. No device: the image is a formula.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <memory>
#include <random>
#include <sstream>

#include "atmos_tables/synthetic.h"
#include "host/base/error.h"
#include "host/products/coverage.h"
#include "host/render/truth.h"
#include "host/run/cube_products.h"
#include "host/sensors/view_bounds.h"
#include "tests/support/render_kit.h"
#include "tests/unit/test_folder.h"

using namespace raycube;
using raycube::testing::TestFolder;

namespace {

constexpr int kPixels = 150, kLines = 211, kBands = 40;  // 5 MB of radiance: two blocks of hashes

/// Bare ground under a uniform air, a camera with every product that there is.
scene::Simulation simulation_of(const std::string& interleave, std::optional<double> integer_scale) {
  scene::Simulation simulation;
  const auto surface = test::add_material(simulation.scene, "grey", 0.3);
  test::place(simulation.scene, test::rectangle({-500, -500, 0}, {1000, 0, 0}, {0, 1000, 0}, surface));
  finish_top_tree(simulation.scene);
  simulation.scene.origin = {32618, 500000, 4700000, 100};
  scene::Instrument camera = test::nadir_camera(kPixels, kLines, 1000, 1.0);
  camera.name = "camera";
  std::vector<double> centers;
  for (int b = 0; b < kBands; ++b) centers.push_back(0.45 + 0.01 * b);
  camera.bands = test::gaussian_bands(centers, 0.01);
  camera.interleave = interleave, camera.integer_scale = integer_scale;
  camera.write_exr = camera.write_png = true;
  camera.band_truth = {raycube::scene::BandTruth::transmission};
  camera.standard_error = scene::StandardError::bands;
  simulation.instruments = {camera};
  return simulation;
}

run::CameraJob job_of(const scene::Simulation& simulation) {
  atmos::UniformAir air;
  air.solar_irradiance = [](double) { return 1500.0; };
  air.sun_transmission = air.view_transmission = [](double) { return 0.8; };
  air.sky_radiance = [](double) { return 30.0; };
  run::CameraJob job;
  job.planned = std::make_shared<scene::Instrument>(simulation.instruments[0]);
  job.instrument = job.planned.get();
  job.table = atmos::uniform_table(air, atmos::wavelength_grid(0.3, 1.2, 0.01));
  job.plan = plan::make_plan(simulation, *job.instrument, job.table, sensors::view_bounds(*job.instrument));
  return job;
}

/// What the kernels would have left of a rectangle: a value for each place, so that no wrong order reproduces it.
struct Values {
  std::vector<float> radiance, truth, error;
  Values(const std::vector<render::LayerName>& layers, const products::Piece& piece) {
    for (std::int64_t line = piece.first_line; line < piece.first_line + piece.lines; ++line)
      for (std::int64_t x = piece.first_sample; x < piece.first_sample + piece.samples; ++x) {
        for (int b = 0; b < kBands; ++b) {
          radiance.push_back(10 + 0.1f * static_cast<float>((line * 31 + x * 17 + b * 7) % 997));
          error.push_back(0.01f * radiance.back());
        }
        const bool hit = (line * kPixels + x) % 13 != 5;
        for (std::size_t k = 0; k < layers.size(); ++k) {
          const std::string& name = layers[k].name;
          float value = static_cast<float>(line) + 0.001f * static_cast<float>(x) + static_cast<float>(k);
          if (name == "hit_fraction") value = hit ? 1.0f : 0.37f * static_cast<float>(x % 3);
          if (name == "view_zenith_deg") value = 0.01f * static_cast<float>(x);
          if (name == "z_m") value = hit ? 0.0f : NAN;
          truth.push_back(value);
        }
      }
  }
};

/// Strips of whole lines in order, or rectangles in any.
std::vector<products::Piece> in_order(int lines_each) {
  std::vector<products::Piece> out;
  for (int line = 0; line < kLines; line += lines_each)
    out.push_back({line, std::min(lines_each, kLines - line), 0, kPixels});
  return out;
}
std::vector<products::Piece> shuffled(unsigned seed) {
  std::vector<products::Piece> out;
  for (int line = 0; line < kLines; line += 24) {
    const int lines = std::min(24, kLines - line);
    if (line / 24 % 3 == 1) {  // now and then whole lines
      out.push_back({line, lines, 0, kPixels});
      continue;
    }
    for (int x = 0; x < kPixels; x += 64) out.push_back({line, lines, x, std::min(64, kPixels - x)});
  }
  std::shuffle(out.begin(), out.end(), std::mt19937(seed));
  return out;
}

std::string text_of(const std::filesystem::path& path) {
  std::ostringstream out;
  out << std::ifstream(path, std::ios::binary).rdbuf();
  return out.str();
}

/// Every file of a run whose pieces came in this order; warnings and counts are in run.json.
std::map<std::string, std::string> products_of(const scene::Simulation& simulation, const run::CameraJob& job,
                                               const std::vector<products::Piece>& pieces) {
  const TestFolder folder;
  const auto layers = render::truth_layer_names(simulation.scene, *job.instrument);
  run::CubeProducts output(folder.path.string(), base::IfExists::refuse, simulation, job);
  for (const auto& piece : pieces) {
    const Values values(layers, piece);
    render::Strip strip{static_cast<int>(piece.first_line), static_cast<int>(piece.lines), values.radiance.data(),
                        values.truth.data(), values.error.data()};
    strip.first_sample = static_cast<int>(piece.first_sample), strip.samples = static_cast<int>(piece.samples);
    output.add(strip);
  }
  output.complete();
  products::RunRecord record;
  record.more_json = {{"missed_samples", output.missed().json()}};
  if (const auto warning = output.warning()) record.warnings.push_back(*warning);
  base::Log log;
  output.publish(record, {.log = log});
  std::map<std::string, std::string> files;
  for (const auto& name : folder.names()) files[name] = text_of(folder.path / name);
  return files;
}

}  // namespace

TEST_CASE("strips in any order, in pieces: the same bytes, digest and hashes of every product") {
  for (const std::string interleave : {"bip", "bil", "bsq"})
    for (const std::optional<double> scale : {std::optional<double>{}, std::optional<double>{100.0}}) {
      CAPTURE(interleave);
      const scene::Simulation simulation = simulation_of(interleave, scale);
      const run::CameraJob job = job_of(simulation);
      const auto expected = products_of(simulation, job, in_order(10));
      for (const char* name : {"radiance.img", "radiance.hdr", "truth.img", "location.img", "transmission.img",
                               "standard_error.img", "preview.exr", "quicklook.png", "run.json"})
        CHECK_MESSAGE(expected.count(name) == 1, name);
      CHECK(expected.at("radiance.img").size() == std::size_t{kPixels} * kLines * kBands * (scale ? 2 : 4));
      CHECK(expected.at("run.json").find("pixels_partly_without") != std::string::npos);
      for (const unsigned seed : {1u, 2u}) {
        const auto found = products_of(simulation, job, shuffled(seed));
        CHECK(found.size() == expected.size());
        for (const auto& [name, bytes] : expected)
          CHECK_MESSAGE((found.count(name) == 1 && found.at(name) == bytes), name);
      }
    }
}

TEST_CASE("a missing piece is refused before anything is published, one that comes twice at once") {
  const scene::Simulation simulation = simulation_of("bip", {});
  const run::CameraJob job = job_of(simulation);
  const auto layers = render::truth_layer_names(simulation.scene, *job.instrument);
  const TestFolder folder;
  {
    run::CubeProducts output(folder.path.string(), base::IfExists::refuse, simulation, job);
    const auto add = [&](const products::Piece& piece) {
      const Values values(layers, piece);
      render::Strip strip{static_cast<int>(piece.first_line), static_cast<int>(piece.lines), values.radiance.data(),
                          values.truth.data(), values.error.data()};
      strip.first_sample = static_cast<int>(piece.first_sample), strip.samples = static_cast<int>(piece.samples);
      output.add(strip);
    };
    add({0, 100, 0, kPixels});
    add({100, kLines - 100, 0, 60});
    add({100, kLines - 100, 61, kPixels - 61});
    CHECK_THROWS_WITH_AS(output.complete(),
                         doctest::Contains("111 of 31650 pixels are missing, the first in line 100, "
                                           "sample 60"),
                         base::Error);
    CHECK_THROWS_WITH_AS(add({120, 1, 50, 20}), doctest::Contains("line 120 came twice"), base::Error);
    CHECK_THROWS_WITH_AS(add({kLines - 1, 2, 0, kPixels}), doctest::Contains("came for an image of 150 x 211"),
                         base::Error);
    products::RunRecord record;
    base::Log log;
    CHECK_THROWS_AS(output.publish(record, {.log = log}), base::Error);
  }
  CHECK(folder.names().empty());
}

TEST_CASE("coverage: whole when every pixel has come, in whatever pieces") {
  products::Coverage image("image", 5, 3);
  image.add({1, 1, 2, 1});
  image.add({1, 1, 4, 1});
  image.add({1, 1, 0, 2});
  image.add({0, 1, 0, 5});
  CHECK(image.has(0, 1));
  CHECK(!image.has(0, 2));
  image.add({1, 1, 3, 1});
  CHECK(image.has(0, 2));
  CHECK(!image.whole());
  CHECK_THROWS_AS(image.add({2, 1, 4, 2}), base::Error);
  CHECK_THROWS_AS(image.add({0, 3, 4, 1}), base::Error);
  image.add({2, 1, 0, 5});
  CHECK(image.whole());
  image.require_whole();
}
