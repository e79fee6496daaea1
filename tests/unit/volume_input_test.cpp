// [[volume]] tables and what pulses see of a material: loaded, refused, hashed and stored.
#include <cmath>
#include <vector>

#include "scene_compiler/compiled_file.h"
#include "scene_compiler/option_table.h"
#include "scene_compiler/scene_info.h"
#include "scene_compiler/volume_spectrum.h"
#include "tests/unit/scene_files.h"

using namespace raycube::scene;
using namespace raycube::scene::testing;

namespace {

/// Keys of the tables under `top` that no test file of `source` sets: each line "key =" or "key =" inside a line
/// counts.
std::vector<std::string> untested_keys(const std::string& top, const std::vector<std::string>& sources) {
  std::string text;
  for (const auto& source : sources) {
    std::ifstream stream(RAYCUBE_SOURCE_DIR "/tests/unit/" + source);
    text.append(std::istreambuf_iterator<char>(stream), {});
  }
  std::vector<std::string> out;
  for (const auto& spec : option_keys()) {
    const bool inside = spec.table == top || spec.table.starts_with(top + ".");
    const bool table = spec.type == KeyType::table || spec.type == KeyType::tables;
    const std::string key(spec.key);
    const bool set =
        has(text, key + " = ") || (table && (has(text, "[" + sub_path(spec) + "]") || has(text, "{\"" + key + "\"")));
    if (inside && !set) out.push_back(std::string(spec.table) + "." + key);
  }
  return out;
}

double linear(const Volume& v, double um) {
  const auto after = std::upper_bound(v.wavelength_um.begin(), v.wavelength_um.end(), um);
  if (after == v.wavelength_um.begin() || after == v.wavelength_um.end()) return 0;
  const auto i = static_cast<std::size_t>(after - v.wavelength_um.begin());
  const double share = (um - v.wavelength_um[i - 1]) / (v.wavelength_um[i] - v.wavelength_um[i - 1]);
  return v.cross_section_cm2[i - 1] + share * (v.cross_section_cm2[i] - v.cross_section_cm2[i - 1]);
}

const char* kLine = "[[volume.line]]\nstrength_cm = 2.0e-19\nhalf_width_per_cm = 0.06\ncenter_per_cm = 3038.5\n";

std::string volume(const std::string& lines) { return std::string(kHead) + "[[volume]]\nname = \"v\"\n" + lines; }

const char* kBox = "shape = \"box\"\nsize_m = [10, 20, 30]\n";
const char* kPlume = "shape = \"plume\"\nsource_g_s = 1\nwind_m_s = 3\n";
const char* kDust = "particles = { extinction_per_m = 0.01 }\n";

}  // namespace

TEST_CASE("volumes: a box, a grid from a CSV and a plume, each with every key") {
  const Folder folder;
  folder.write("sigma.csv", "wavenumber_per_cm,cross_section_cm2\n3000,1e-20\n3100,3e-20\n");
  folder.write("grid.csv", "i,j,k,value\n1,2,0,5\n0,0,1,7\n");
  const auto scene = load(folder, std::string(kHead) + R"(
[[terrain]]
raster = "t.asc"
material = "grey"
[[volume]]
name = "cloud"
shape = "box"
position_m = [10, 12, 3]
on_terrain = true
size_m = [10, 20, 30]
yaw_deg = 15
gas = "ch4"
concentration_ppm = 40
cross_section = "sigma.csv"
[volume.particles]
extinction_per_m = 0.02
lidar_ratio_sr = 30
[[volume]]
name = "tank"
shape = "grid"
size_m = [4, 6, 2]
cells = [2, 3, 2]
values = "grid.csv"
gas = "ch4"
cross_section = "sigma.csv"
[[volume]]
name = "leak"
shape = "plume"
position_m = [-5, 0, 0]
yaw_deg = 90
gas = "ch4"
source_g_s = 1.5
wind_m_s = 3
release_height_m = 2
molar_mass_g_mol = 30
stability = "B"
sigma_z_law = [0.05, 0.001]
length_m = 400
[[volume.line]]
strength_cm = 2.0e-19
half_width_per_cm = 0.06
center_per_cm = 3038.5
wing_per_cm = 10
)" + kGrey,
                          (folder.write("t.asc", "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 10\n7 7\n7 7\n"),
                           LoadOptions{}))
                         .scene;
  REQUIRE(scene.volumes.size() == 3);
  const Volume &box = scene.volumes[0], &grid = scene.volumes[1], &plume = scene.volumes[2];
  CHECK(box.shape == Volume::Shape::box);
  CHECK(box.position_m == std::array<double, 3>{10, 12, 10});
  CHECK(box.size_m == std::array<double, 3>{10, 20, 30});
  CHECK(box.yaw_deg == 15);
  CHECK(box.concentration_ppm == 40);
  CHECK(box.extinction_per_m == 0.02);
  CHECK(box.lidar_ratio_sr == 30);
  REQUIRE(box.wavelength_um.size() == 2);  // ascending wavelengths from ascending wavenumbers
  CHECK(box.wavelength_um[0] == doctest::Approx(1e4 / 3100).epsilon(1e-14));
  CHECK(box.cross_section_cm2[0] == 3e-20);
  CHECK(grid.cells == std::array<int, 3>{2, 3, 2});
  CHECK(grid.concentration_ppm == 1);
  CHECK(grid.values == std::vector<float>{0, 0, 0, 0, 0, 5, 7, 0, 0, 0, 0, 0});
  CHECK(plume.shape == Volume::Shape::plume);
  CHECK(plume.source_g_s == 1.5);
  CHECK(plume.molar_mass_g == 30);
  CHECK(plume.sigma_y_a == 0.16);
  CHECK(plume.sigma_y_b == 1e-4);
  CHECK(plume.sigma_z_a == 0.05);
  CHECK(plume.sigma_z_b == 0.001);
  CHECK(plume.sigma_y_m == 0);
  CHECK(plume.length_m == 400);
  const std::string info = scene_info_text(scene_info(scene));
  CHECK_SAYS(info, "box, ch4 3.2258 .. 3.3333 um, particles");
  CHECK_SAYS(info, "plume, ch4 3.28");
  CHECK(plume.extinction_per_m == 0);
}

TEST_CASE("volumes: a plume of constant widths, and the classes of Briggs' widths") {
  const Folder folder;
  const Volume v =
      load(folder, volume(std::string(kPlume) + kDust + "sigma_y_m = 10\nsigma_z_m = 5\n")).scene.volumes.at(0);
  CHECK(v.sigma_y_m == 10);
  CHECK(v.sigma_z_m == 5);
  // Open country, 1 km downwind (Briggs 1973): 0.22 / sqrt(1.1) km across for class A, 60 m / sqrt(2.5) up for D.
  const auto at_km = [&](const std::string& stability) {
    const Volume p =
        load(folder, volume(std::string(kPlume) + kDust + "stability = \"" + stability + "\"\n")).scene.volumes.at(0);
    return std::pair{p.sigma_y_a * 1000 / std::sqrt(1 + p.sigma_y_b * 1000),
                     p.sigma_z_a * 1000 / std::sqrt(1 + p.sigma_z_b * 1000)};
  };
  CHECK(at_km("A").first == doctest::Approx(209.762).epsilon(1e-5));
  CHECK(at_km("A").second == doctest::Approx(200).epsilon(1e-12));
  CHECK(at_km("C").second == doctest::Approx(80 / std::sqrt(1.2)).epsilon(1e-12));
  CHECK(at_km("D").second == doctest::Approx(60 / std::sqrt(2.5)).epsilon(1e-12));
}

TEST_CASE("option table: every key of LIDARs and volumes is set by a test") {
  for (const auto& key :
       untested_keys("lidar", {"lidar_options_test.cpp", "lidar_bad_input_test.cpp", "lidar_files.h"}))
    FAIL_CHECK("no test sets " << key);
  for (const auto& key : untested_keys("volume", {"volume_input_test.cpp"})) FAIL_CHECK("no test sets " << key);
  CHECK(untested_keys("terrain", {"volume_input_test.cpp"}).size() > 5);  // the search finds what is not there
}

TEST_CASE("volumes: a raster gives a layer per band from below, its last row first") {
  const Folder folder;
  folder.write("g.asc", "ncols 3\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2 3\n4 5 6\n");
  const Volume grid =
      load(folder, volume("shape = \"grid\"\nsize_m = [3, 2, 1]\nvalues = \"g.asc\"\n" + std::string(kDust)))
          .scene.volumes.at(0);
  CHECK(grid.cells == std::array<int, 3>{3, 2, 1});
  CHECK(grid.values == std::vector<float>{4, 5, 6, 1, 2, 3});
  // Where its map coordinates say that the first row is the southern one, that is in the -y end.
  folder.write("s.vrt",
               "<VRTDataset rasterXSize=\"3\" rasterYSize=\"2\"><SRS>EPSG:32632</SRS><GeoTransform>0, 1, 0, 0, 0, "
               "1</GeoTransform><VRTRasterBand dataType=\"Float32\" band=\"1\"><SimpleSource><SourceFilename "
               "relativeToVRT=\"1\">g.asc</SourceFilename><SourceBand>1</SourceBand></SimpleSource></VRTRasterBand>"
               "</VRTDataset>");
  const auto south =
      load(folder, volume("shape = \"grid\"\nsize_m = [3, 2, 1]\nvalues = \"s.vrt\"\n" + std::string(kDust)));
  CHECK(south.scene.volumes.at(0).values == std::vector<float>{1, 2, 3, 4, 5, 6});
  CHECK(south.notices.size() == 1);
}

TEST_CASE("L-09: a Lorentz line in numbers: peak, wing and everything between, to 1e-7") {
  Volume v;
  tabulate_lines({{2.0e-19, 0.06, 3038.5, 25}}, v);
  const auto lorentz = [](double d) { return 2.0e-19 * 0.06 / (M_PI * (d * d + 0.06 * 0.06)); };
  CHECK(linear(v, 1e4 / 3038.5) == doctest::Approx(1.061032954e-18).epsilon(1e-9));
  CHECK(linear(v, 1e4 / 3040.0) == doctest::Approx(1.694941e-21).epsilon(1e-6));
  double worst = 0;
  for (int i = 0; i < 20000; ++i) {
    const double d = std::sinh((i - 10000 + 0.37) / 10000 * 6.7) * 0.06;
    if (std::abs(d) < 25) worst = std::max(worst, std::abs(linear(v, 1e4 / (3038.5 + d)) / lorentz(d) - 1));
  }
  CHECK(worst < 1e-7);
  CHECK(linear(v, 1e4 / (3038.5 + 25.1)) == 0);
  // Two lines add up.
  Volume two;
  tabulate_lines({{2.0e-19, 0.06, 3038.5, 25}, {1.0e-19, 0.06, 3039.0, 25}}, two);
  CHECK(linear(two, 1e4 / 3038.6) == doctest::Approx(lorentz(0.1) + 0.5 * lorentz(0.4)).epsilon(1e-7));
  for (std::size_t i = 1; i < two.wavelength_um.size(); ++i) REQUIRE(two.wavelength_um[i] > two.wavelength_um[i - 1]);
}

TEST_CASE("a list of tables inside another table takes a single one too") {
  const Folder folder;
  const std::string line = "strength_cm = 2.0e-19, half_width_per_cm = 0.06, center_per_cm = 3038.5";
  const auto hash = [&](const std::string& lines) {
    return load(folder, volume(std::string(kPlume) + "gas = \"ch4\"\n" + lines)).scene.content_hash;
  };
  CHECK(hash("line = { " + line + " }\n") == hash("line = [{ " + line + " }]\n"));
  CHECK(hash("line = { " + line + " }\n") == hash(kLine));
}

TEST_CASE("bad input, volumes: one message per fault") {
  const Folder folder;
  folder.write("c.csv", "wavelength_um,cross_section_cm2\n3.3,1e-20\n3.4,2e-20\n");
  folder.write("unit.csv", "wavelength_um,cross_section_cm2\n3300,1e-20\n3400,2e-20\n");
  folder.write("order.csv", "wavelength_um,cross_section_cm2\n3.4,1e-20\n3.3,2e-20\n");
  folder.write("name.csv", "wavelength,sigma\n3.4,1e-20\n3.3,2e-20\n");
  folder.write("cell.csv", "i,j,k,value\n0,0,9,1\n");
  folder.write("minus.csv", "i,j,k,value\n0,0,0,-1\n");
  const std::string box(kBox), plume(kPlume), gas = "gas = \"ch4\"\n", ppm = "concentration_ppm = 5\n",
                                              file = "cross_section = \"c.csv\"\n", dust(kDust);
  const std::string grid = "shape = \"grid\"\nsize_m = [1, 1, 1]\n" + dust;
  const std::vector<std::pair<std::string, std::string>> faults = {
      {box, "a volume needs gas or particles"},
      {"shape = \"ball\"\n" + dust, "'shape' wants one of box, grid, plume"},
      {"shape = \"box\"\n" + dust, "'size_m' is missing for shape = \"box\""},
      {box + dust + "wind_m_s = 3\n", "'wind_m_s' means nothing for shape = \"box\""},
      {box + gas + ppm, "a gas needs exactly one of cross_section and [[volume.line]] (found neither)"},
      {box + gas + ppm + file + kLine, "a gas needs exactly one of cross_section and [[volume.line]] (found both)"},
      {box + gas + file, "'concentration_ppm' is missing for shape = \"box\""},
      {box + dust + ppm, "'concentration_ppm' goes with a gas"},
      {box + gas + ppm + "cross_section = \"unit.csv\"\n", "wavelength outside 0.05 to 1000 um"},
      {box + gas + ppm + "cross_section = \"order.csv\"\n", "rows must ascend (found 3.3 after 3.4)"},
      {box + gas + ppm + "cross_section = \"name.csv\"\n", "cross sections have the columns"},
      {grid, "'values' is missing for shape = \"grid\""},
      {grid + "values = \"cell.csv\"\n", "a grid from a CSV needs 'cells'"},
      {"cells = [1, 1, 1]\n" + grid + "values = \"cell.csv\"\n",
       "cell.csv:2: column 'k': no such cell (found 9); give 0 to 0"},
      {"cells = [1, 1, 1]\n" + grid + "values = \"minus.csv\"\n", "a value is negative (found -1)"},
      {"shape = \"plume\"\nwind_m_s = 3\n" + dust, "'source_g_s' is missing for shape = \"plume\""},
      {plume + dust + "sigma_y_m = 4\nsigma_y_law = [0.1, 0]\n", "'sigma_y_law' and 'sigma_y_m' exclude each other"},
      {plume + dust + "sigma_z_law = [0, 0]\n", "a plume widens"},
      {plume + gas + "[[volume.line]]\nstrength_cm = 1e-19\nhalf_width_per_cm = 0.1\ncenter_per_cm = 20\n",
       "the line's wing reaches below wavenumber 0"},
      {box + dust + "on_terrain = true\n", "on_terrain, but no terrain lies there"},
      {box + dust + "[[volume]]\nname = \"v\"\n" + box + dust, "volume 'v' is defined twice"},
  };
  for (const auto& [lines, says] : faults) {
    const std::string message = refusal(folder, volume(lines));
    CHECK_SAYS(message, says);
    const std::size_t expected = says.find("rows must ascend") != std::string::npos ? 1
                                 : says.find("outside 0.05") != std::string::npos   ? 2
                                                                                    : 1;
    CHECK_MESSAGE(line_count(message) == expected, message);
  }
}

TEST_CASE("materials: leaves and plates, gloss and its limits") {
  const Folder folder;
  const std::string leaf = "[[material]]\nname = \"m\"\nreflectance = 0.5\ntransmittance = 0.25\n";
  const Material plain = load(folder, kHead + leaf).scene.materials.at(0);
  CHECK(plain.behind.number == RC_SHAPE_leaf);
  CHECK(plain.front.number == RC_SHAPE_lambert);
  CHECK(plain.gloss.number == RC_SHAPE_none);
  const Material plate =
      load(folder, kHead + leaf + "transmission = \"plate\"\ngloss = { roughness = 0.3, f0 = 0.04 }\n")
          .scene.materials.at(0);
  CHECK(plate.behind.number == RC_SHAPE_plate);
  CHECK(plate.gloss == Shape{RC_SHAPE_gloss, {0.3, 0.04}});
  CHECK_SAYS(refusal(folder, std::string(kHead) + kGrey + "transmission = \"plate\"\n"),
             "'transmission' needs a transmittance");
  CHECK_SAYS(refusal(folder, kHead + leaf + "gloss = { roughness = 0.3, f0 = 0.3 }\n"),
             "reflectance + transmittance + f0 above 1 (found 0.75 + 0.3)");
  CHECK_SAYS(refusal(folder, kHead + leaf + "gloss = { roughness = 0 , f0 = 0.1 }\n"),
             "'roughness' is out of range (found 0)");
  CHECK_SAYS(refusal(folder, kHead + leaf + "gloss = { roughness = 0.1 }\n"), "'f0' is missing in [material.gloss]");
}

TEST_CASE("compiled scenes: volumes, plates and gloss are stored and hashed; a scene without them keeps its hash") {
  const Folder folder;
  const std::string plain = std::string(kHead) +
                            "[[material]]\nname = \"m\"\nreflectance = 0.45\ntransmittance = 0.4\n[[plane]]\nmaterial "
                            "= \"m\"\nsize_m = [5, 5]\n";
  const auto with = [&](const std::string& text) { return load(folder, text).scene; };
  const auto base = with(plain);
  // Since version 7 of compiled scenes: what only instruments see has this hash.
  CHECK(base.content_hash == "123056c24068db6622fa83b889947a7a502b808116a7c293dd5e72f9c6e546bb");
  std::string plate = plain, gloss = plain;
  plate.insert(plate.find("[[plane]]"), "transmission = \"plate\"\n");
  gloss.insert(gloss.find("[[plane]]"), "gloss = { roughness = 0.3, f0 = 0.04 }\n");
  std::string classed = plain;
  classed.insert(classed.find("[[plane]]"), "las_class = 6\n");
  const std::string gas = plain + "[[volume]]\nname = \"v\"\n" + kPlume + "gas = \"ch4\"\n" + kLine;
  std::string wind = gas;
  wind.replace(wind.find("wind_m_s = 3"), 12, "wind_m_s = 4");
  folder.write("grid.csv", "i,j,k,value\n1,2,0,5\n0,0,1,7\n");
  const std::string grid =
      plain +
      "[[volume]]\nname = \"g\"\nshape = \"grid\"\nsize_m = [4, 6, 2]\ncells = [2, 3, 2]\nvalues = \"grid.csv\"\n" +
      kDust;
  std::vector<std::string> hashes = {base.content_hash};
  for (const auto& text : {plate, gloss, gas, wind, grid, classed}) {
    const auto scene = with(text);
    CHECK(std::find(hashes.begin(), hashes.end(), scene.content_hash) == hashes.end());
    hashes.push_back(scene.content_hash);
    save_compiled(scene, folder.at("s.rcs"), true);
    const auto back = load_compiled(folder.at("s.rcs"));
    CHECK(back.content_hash == scene.content_hash);
    CHECK(back.materials[0].behind == scene.materials[0].behind);
    CHECK(back.materials[0].gloss == scene.materials[0].gloss);
    CHECK(back.materials[0].las_class == scene.materials[0].las_class);
    REQUIRE(back.volumes.size() == scene.volumes.size());
    for (std::size_t i = 0; i < back.volumes.size(); ++i) {
      CHECK(back.volumes[i].name == scene.volumes[i].name);
      CHECK(back.volumes[i].values == scene.volumes[i].values);
      CHECK(back.volumes[i].cells == scene.volumes[i].cells);
      CHECK(back.volumes[i].wind_m_s == scene.volumes[i].wind_m_s);
      CHECK(back.volumes[i].extinction_per_m == scene.volumes[i].extinction_per_m);
      CHECK(back.volumes[i].cross_section_cm2 == scene.volumes[i].cross_section_cm2);
    }
  }
}
