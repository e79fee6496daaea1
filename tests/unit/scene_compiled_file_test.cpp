// Compiled scenes on disk, their hash, and what instancing costs (S3, S4).
#include <cmath>
#include <cstring>
#include <fstream>
#include <sstream>

#include "host/base/sha256.h"
#include "scene_compiler/compiled_file.h"
#include "scene_compiler/scene_info.h"
#include "tests/unit/scene_files.h"
#include "tests/support/same_bytes.h"

using namespace raycube;
using namespace raycube::scene;
using namespace raycube::scene::testing;
using raycube::test::same_bytes;

namespace {

std::string scene_text(const Folder& folder) {
  folder.write("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 4 2\n");
  return std::string(kHead) + kGrey +
         "source = \"by definition\"\n[[mesh]]\nname = \"m\"\nfile = \"m.obj\"\nmaterial = "
         "\"grey\"\n[[instance]]\nmesh = \"m\"\nposition_m = [1, 2, 3]\nyaw_deg = 10\n[[plane]]\nmaterial = "
         "\"grey\"\nsize_m = [5, 5]\n";
}

std::string slurp(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream out;
  out << stream.rdbuf();
  return out.str();
}

std::string load_error(const std::string& file) {
  try {
    load_compiled(file);
  } catch (const base::Error& error) {
    CHECK(error.fault() == base::Fault::input);
    return error.what();
  }
  return "";
}

long peak_kib() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with("VmHWM:")) return std::stol(line.substr(6));
  return -1;
}

}  // namespace

TEST_CASE("S4 compiled scene: saved and loaded, every array is the same to the byte") {
  const Folder folder;
  const auto scene = load(folder, scene_text(folder)).scene;
  save_compiled(scene, folder.at("s.rcs"));
  const auto back = load_compiled(folder.at("s.rcs"));
  CHECK(back.content_hash == scene.content_hash);
  CHECK(scene.content_hash.size() == 64);
  CHECK(same_bytes(back.nodes, scene.nodes));
  CHECK(same_bytes(back.blocks, scene.blocks));
  CHECK(same_bytes(back.instances, scene.instances));
  CHECK(same_bytes(back.surfaces, scene.surfaces));
  REQUIRE(back.meshes.size() == scene.meshes.size());
  for (std::size_t i = 0; i < back.meshes.size(); ++i) {
    CHECK(back.meshes[i].name == scene.meshes[i].name);
    CHECK(back.meshes[i].user_face == scene.meshes[i].user_face);
    CHECK(back.meshes[i].tree == scene.meshes[i].tree);
    CHECK(back.meshes[i].placed_after == scene.meshes[i].placed_after);
  }
  REQUIRE(back.trees.size() == scene.trees.size());
  for (std::size_t i = 0; i < back.trees.size(); ++i) {
    CHECK(back.trees[i].meshes == scene.trees[i].meshes);
    CHECK(back.trees[i].root == scene.trees[i].root);
    CHECK(back.trees[i].triangle_count == scene.trees[i].triangle_count);
  }
  REQUIRE(back.materials.size() == 1);
  CHECK(back.materials[0].reflectance.value == scene.materials[0].reflectance.value);
  CHECK(back.materials[0].source == "by definition");
  CHECK(back.stack_bound() == scene.stack_bound());
  // Saving again gives the same file, and overwriting is refused unless asked for.
  save_compiled(back, folder.at("t.rcs"));
  CHECK(slurp(folder.at("t.rcs")) == slurp(folder.at("s.rcs")));
  CHECK_THROWS_AS(save_compiled(back, folder.at("t.rcs")), base::Error);
}

TEST_CASE("S4 compiled scene: matter that is a sum of lobes is the same, with its nodes and its index") {
  const Folder folder;
  folder.write("index.csv", "wavelength_nm,n,k\n400,1.4,2\n800,0.9,3\n");
  folder.write("albedo.csv", "wavelength_nm,reflectance\n400,0.2\n800,0.9\n");
  const std::string text =
      scene_text(folder) +
      "[[material]]\nname = \"wet\"\nreflectance = 0.2\ngloss = { at_nm = [450, 650], roughness = 0.3, f0 = [0, 0.3] "
      "}\n"
      "[[material]]\nname = \"metal\"\nreflectance = 0.01\nfresnel = { roughness = 0.2, file = \"index.csv\" }\n"
      "[[material]]\nname = \"soil\"\nfile = \"albedo.csv\"\n"
      "hapke = { b = 0.3, c = 0.1, slope_deg = 10, b0 = 0.5, h = 0.1 }\n"
      "[[material]]\nname = \"grass\"\nreflectance = 0.3\nrpv = { at_nm = [450, 650], k = [0.8, 0.9], theta = -0.1, "
      "rho_c = [1, 0.9] }\n";
  const auto scene = load(folder, text).scene;
  save_compiled(scene, folder.at("s.rcs"));
  const auto back = load_compiled(folder.at("s.rcs"));
  CHECK(back.content_hash == scene.content_hash);
  REQUIRE(back.materials.size() == scene.materials.size());
  std::size_t lobes = 0;
  for (std::size_t m = 0; m < scene.materials.size(); ++m) {
    const Material &was = scene.materials[m], &is = back.materials[m];
    CHECK(is.front == was.front);
    CHECK(is.gloss == was.gloss);
    CHECK(is.front_nodes == was.front_nodes);
    CHECK(is.gloss_nodes == was.gloss_nodes);
    CHECK(is.index_k.value == was.index_k.value);
    CHECK(is.front_curve.value == was.front_curve.value);
    CHECK(is.gloss_curve.value == was.gloss_curve.value);
    REQUIRE(is.further.size() == was.further.size());
    for (std::size_t i = 0; i < is.further.size(); ++i) {
      CHECK(is.further[i].shape == was.further[i].shape);
      CHECK(is.further[i].curve.value == was.further[i].curve.value);
    }
    lobes += is.further.size();
  }
  CHECK(lobes >= 1 + 3 + 3 + 1);  // of the wet, the metal, the soil and the grass
}

TEST_CASE("S4 content hash: changes with whatever changes a result, not with the text of a source") {
  const Folder folder;
  const std::string text = scene_text(folder);
  const auto hash = [&](const std::string& from, const std::string& to) {
    std::string changed = text;
    if (!from.empty()) changed.replace(changed.find(from), from.size(), to);
    return load(folder, changed).scene.content_hash;
  };
  const std::string original = hash("", "");
  CHECK(hash("", "") == original);
  CHECK(hash("by definition", "measured") == original);
  CHECK(hash("reflectance = 0.5", "reflectance = 0.50000001") != original);
  CHECK(hash("yaw_deg = 10", "yaw_deg = 11") != original);
  CHECK(hash("size_m = [5, 5]", "size_m = [5, 5.1]") != original);
  CHECK(hash("format = 1\n", "format = 1\nscene = { origin = { height_m = 1 } }\n") != original);
}

TEST_CASE(
    "bad input S4: compiled scene missing, empty, foreign, of another version, truncated anywhere, damaged "
    "anywhere") {
  const Folder folder;
  save_compiled(load(folder, scene_text(folder)).scene, folder.at("s.rcs"));
  const std::string good = slurp(folder.at("s.rcs"));
  CHECK_SAYS(load_error(folder.at("none.rcs")), "none.rcs: cannot read compiled scene");
  CHECK_SAYS(load_error(folder.write("e.rcs", "")), "e.rcs: file is empty (0 bytes)");
  CHECK_SAYS(load_error(folder.write("f.rcs", "PNG and so on, more than sixteen bytes")),
             "f.rcs: not a compiled scene");
  std::string version = good;
  version[16] = static_cast<char>(kCompiledFileVersion + 1);
  CHECK_SAYS(load_error(folder.write("v.rcs", version)),
             "compiled scene has version " + std::to_string(kCompiledFileVersion + 1) + ", this program reads " +
                 std::to_string(kCompiledFileVersion));
  for (const std::size_t bytes :
       {std::size_t{20}, std::size_t{31}, std::size_t{40}, good.size() / 2, good.size() - 1}) {
    CAPTURE(bytes);
    CHECK_SAYS(load_error(folder.write("t.rcs", good.substr(0, bytes))), "compiled scene is damaged");
  }
  CHECK_SAYS(load_error(folder.write("l.rcs", good + "x")), "compiled scene is damaged");
  for (std::size_t at = 24; at < good.size(); at += good.size() / 37) {
    CAPTURE(at);
    std::string bad = good;
    bad[at] = static_cast<char>(bad[at] ^ 4);
    CHECK_SAYS(load_error(folder.write("d.rcs", bad)), "compiled scene is damaged");
  }
}

TEST_CASE("bad input S4: a count of 2^60 with a right checksum is refused before anything is allocated") {
  const Folder folder;
  save_compiled(load(folder, scene_text(folder)).scene, folder.at("s.rcs"));
  std::string bad = slurp(folder.at("s.rcs"));
  // Header 32 bytes; then materials, meshes and trees (u64 each), epsg (4), three doubles, and the length of the first
  // name (u64).
  for (const std::size_t at : {std::size_t{32}, std::size_t{40}, std::size_t{48}, std::size_t{32 + 24 + 4 + 24}}) {
    std::string forged = bad;
    const std::uint64_t huge = std::uint64_t{1} << 60;
    std::memcpy(forged.data() + at, &huge, sizeof huge);
    const auto digest = base::Sha256().add(forged.data(), forged.size() - 32).digest();
    std::memcpy(forged.data() + forged.size() - 32, digest.data(), 32);
    CAPTURE(at);
    CHECK_SAYS(load_error(folder.write("h.rcs", forged)), "compiled scene is damaged: it has ");
  }
}

TEST_CASE("S3 instancing costs one mesh: 1e5 instances of a tree of 20 000 triangles compile under 1 GiB") {
  const Folder folder;
  // A tree-like cloud of 20 000 leaf triangles on a spiral, no two alike.
  std::string obj;
  char line[96];
  for (int i = 0; i < 20000; ++i) {
    const double a = i * 2.399963229728653, r = 3 * std::sqrt((i + 0.5) / 20000), z = 2 + 8.0 * i / 20000;
    for (int k = 0; k < 3; ++k) {
      std::snprintf(line, sizeof line, "v %.5f %.5f %.5f\n", r * std::cos(a) + 0.05 * k,
                    r * std::sin(a) + 0.03 * (k % 2), z + 0.02 * (k / 2));
      obj += line;
    }
  }
  for (int i = 0; i < 20000; ++i) {
    std::snprintf(line, sizeof line, "f %d %d %d\n", 3 * i + 1, 3 * i + 2, 3 * i + 3);
    obj += line;
  }
  folder.write("tree.obj", obj);
  const auto simulation =
      load(folder, std::string(kHead) + kGrey +
                       "[[mesh]]\nname = \"tree\"\nfile = \"tree.obj\"\nmaterial = \"grey\"\n[[scatter]]\nmesh = "
                       "\"tree\"\ndensity_per_m2 = 0.01\nrectangle_m = [0, 0, 5000, 2000]\nscale_range = [0.8, 1.2]\n");
  const auto info = scene_info(simulation.scene);
  CHECK(info.instances == 100000);
  CHECK(info.triangles == 20000);
  CHECK(info.placed_triangles == 2000000000ull);
  const long peak = peak_kib();
  MESSAGE("peak memory " << peak / 1024 << " MiB; " << info.bytes_per_triangle << " bytes per triangle, "
                         << info.bytes_per_instance << " bytes per instance");
  CHECK(peak > 0);
  CHECK(peak < 1024 * 1024);
}
