// Temperatures in a simulation file: fixed per material, with a default, and what is refused (S14).
#include "scene_compiler/compiled_file.h"
#include "tests/unit/scene_files.h"

using namespace raycube;
using namespace raycube::scene;
using namespace raycube::scene::testing;

TEST_CASE("S14 temperature_K of a material, the default of the others, 0 where neither is given") {
  const Folder folder;
  const std::string materials =
      std::string(kGrey) + "[[material]]\nname = \"roof\"\nreflectance = 0.1\ntemperature_K = 315.5\n";
  const std::string plane = "[[plane]]\nmaterial = \"grey\"\nsize_m = [5, 5]\n";
  const LoadOptions no_instruments = [] {
    LoadOptions o;
    o.need_instruments = false;
    return o;
  }();
  const auto with =
      load(folder, std::string(kHead) + materials + plane + "[thermal]\ndefault_temperature_K = 290\n", no_instruments);
  REQUIRE(with.scene.materials.size() == 2);
  CHECK(with.scene.materials[0].temperature_K == 290);
  CHECK(with.scene.materials[1].temperature_K == 315.5);
  const auto without = load(folder, std::string(kHead) + materials + plane, no_instruments);
  CHECK(without.scene.materials[0].temperature_K == 0);
  CHECK(without.scene.materials[1].temperature_K == 315.5);
  CHECK(with.scene.content_hash != without.scene.content_hash);
  save_compiled(with.scene, folder.at("a.rcs"), false);
  const auto back = load_compiled(folder.at("a.rcs"));
  CHECK(back.materials[1].temperature_K == 315.5);
  CHECK(back.content_hash == with.scene.content_hash);
}

TEST_CASE("bad input: 0 K, a negative temperature, one beyond 6000 K, a temperature without unit") {
  const Folder folder;
  const auto material = [&](const std::string& line) {
    return refusal(folder, std::string(kHead) + "[[material]]\nname = \"m\"\nreflectance = 0.5\n" + line + "\n");
  };
  CHECK_SAYS(material("temperature_K = 0"),
             "scene.toml:5:17: 'temperature_K' is out of range (found 0); give a number > 0 and <= 6000");
  CHECK_SAYS(material("temperature_K = -5"), "found -5");
  CHECK_SAYS(material("temperature_K = 6001"), "found 6001");
  CHECK_SAYS(material("temperature = 300"), "did you mean 'temperature_K'?");
  CHECK_SAYS(refusal(folder, std::string(kHead) + "[thermal]\ndefault_temperature_K = 0\n"),
             "'default_temperature_K' is out of range (found 0)");
}
