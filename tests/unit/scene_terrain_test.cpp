// Terrain from rasters: heights, class maps and mixtures of materials (S2).
#include <cmath>
#include <fstream>
#include <sstream>

#include "scene_compiler/document_values.h"
#include "scene_compiler/ground.h"
#include "scene_compiler/raster.h"
#include "scene_compiler/terrain.h"
#include "tests/support/chance_checks.h"
#include "tests/unit/scene_triangles.h"

using namespace raycube;
using namespace raycube::scene;
using namespace raycube::scene::testing;

// The first here: others leave GDAL behind by filling in posts.
TEST_CASE("a raster is read by a child that has GDAL from this process, which loads it once for all of them") {
  const Folder folder;
  const std::string file = folder.write("dem.asc", ascii_grid(2, 2, 0, 0, 1, {1, 2, 3, 4}));
  base::Problems problems;
  const auto raster = read_raster(file, {}, {}, problems);
  REQUIRE(raster);
  REQUIRE(raster->bands.size() == 1);
  REQUIRE(raster->bands[0].size() == 4);
  for (std::size_t i = 0; i < 4; ++i) CHECK(raster->bands[0][i] == double(i + 1));
  std::ostringstream libraries;
  libraries << std::ifstream("/proc/self/maps").rdbuf();
  CHECK(libraries.str().find("/libgdal.so") != std::string::npos);
}

TEST_CASE("S2 terrain: row 0 is north, class map aligned cell by cell, heights are the triangles' own") {
  const Folder folder;
  // Posts 10 m apart; z = east index + 10 x north index, so that the plane is known everywhere.
  std::vector<double> z, classes;
  for (int r = 0; r < 4; ++r)
    for (int c = 0; c < 5; ++c) z.push_back(c + 10 * (3 - r));
  folder.write("dem.asc", ascii_grid(5, 4, 100, 200, 10, z));
  // 4 x 3 cells: class 2 only in the north-west cell.
  for (int i = 0; i < 12; ++i) classes.push_back(i == 0 ? 2 : 1);
  folder.write("class.asc", ascii_grid(4, 3, 105, 205, 10, classes));
  const auto scene = load(folder, std::string(kHead) + kTwo +
                                      "[[terrain]]\nraster = \"dem.asc\"\nclass_map = \"class.asc\"\nmaterials = { 1 = "
                                      "\"dark\", 2 = \"light\" }\n[[plane]]\nmaterial = \"dark\"\nsize_m = [1, "
                                      "1]\nposition_m = [112.5, 221, 0]\non_terrain = true\n")
                         .scene;
  const auto triangles = placed_triangles(scene);
  REQUIRE(triangles.size() == 26);
  CHECK(lowest(triangles) == Vector{105, 205, 0});
  CHECK(highest(triangles) == Vector{145, 235, 34});
  double panel_z = 0;
  for (const auto& t : triangles) {
    CHECK(cross_of(t)[2] > 0);
    const double x = (t.v[0][0] + t.v[1][0] + t.v[2][0]) / 3, y = (t.v[0][1] + t.v[1][1] + t.v[2][1]) / 3,
                 h = (t.v[0][2] + t.v[1][2] + t.v[2][2]) / 3;
    if (area(t) < 1) {
      panel_z = h;
      continue;
    }
    CHECK(h == doctest::Approx((x - 105) / 10 + (y - 205)).epsilon(1e-6));
    CHECK(t.surface == (x < 115 && y > 225 ? 1u : 0u));
  }
  CHECK(panel_z == doctest::Approx(0.75 + 16).epsilon(1e-6));
}

TEST_CASE(
    "S2 terrain height inside a cell is that of the triangle under the point, on both sides of the "
    "diagonal") {
  // One cell of 1 m, posts nw 0, ne 0, sw 0, se 1: below the diagonal z = u - ... from the three corners of
  // each triangle.
  const TerrainGrid grid(2, 2, {-0.5, 1, 0, 1.5, 0, -1}, {0, 0, 0, 1});
  // Triangle nw, sw, se: z = u (from sw to se). Triangle nw, se, ne: z = v (from ne to se).
  CHECK(*grid.height_m(0.25, 1 - 0.75) == doctest::Approx(0.25).epsilon(1e-14));
  CHECK(*grid.height_m(0.75, 1 - 0.25) == doctest::Approx(0.25).epsilon(1e-14));
  CHECK(*grid.height_m(0.5, 0.5) == doctest::Approx(0.5).epsilon(1e-14));
  CHECK(!grid.height_m(1.001, 0.5));
  CHECK(!grid.height_m(0.5, -0.001));
}

TEST_CASE("ground: the highest terrain below a place, off all of them the edge of the nearest, z = 0 without any") {
  // Rows from north: 0 1 / 2 3 over x 0..1, y 0..1; a raster turned by 90 degrees, all 7, over x 10..11, y
  // 0..1.
  const Ground ground({TerrainGrid(2, 2, {-0.5, 1, 0, 1.5, 0, -1}, {0, 1, 2, 3}),
                       TerrainGrid(2, 2, {9.5, 0, 1, -0.5, 1, 0}, {7, 7, 7, 7})});
  CHECK(ground.z_m(0, 1) == doctest::Approx(0));
  CHECK(ground.z_m(0.5, 0) == doctest::Approx(2.5));
  CHECK(ground.z_m(0.5, -30) == doctest::Approx(2.5));
  CHECK(ground.z_m(-4, 9) == doctest::Approx(0));
  CHECK(ground.z_m(4, 0) == doctest::Approx(3));
  CHECK(ground.z_m(8, 0.5) == doctest::Approx(7));
  CHECK(ground.z_m(10.5, 0.5) == doctest::Approx(7));
  CHECK(Ground({}).z_m(3, 4) == 0);
}

TEST_CASE(
    "S2 class map of the terrain's own size without georeferencing lies on its pixels: a cell takes its "
    "north-western one") {
  const Folder folder;
  folder.write("dem.asc", ascii_grid(3, 3, 0, 0, 1, std::vector<double>(9, 5)));
  // GDAL reads a PGM without georeferencing.
  folder.write("class.pgm", "P5\n3 3\n255\n" + std::string("\1\2\1\1\1\1\1\1\1", 9));
  const auto scene = load(folder, std::string(kHead) + kTwo +
                                      "[[terrain]]\nraster = \"dem.asc\"\nclass_map = "
                                      "\"class.pgm\"\nmaterials = { 1 = \"dark\", 2 = \"light\" }\n")
                         .scene;
  for (const auto& t : placed_triangles(scene)) {
    const double x = (t.v[0][0] + t.v[1][0] + t.v[2][0]) / 3, y = (t.v[0][1] + t.v[1][1] + t.v[2][1]) / 3;
    CHECK(t.surface == (x > 1.5 && y > 1.5 ? 1u : 0u));
  }
  folder.write("class.pgm", "P5\n5 5\n255\n" + std::string(25, '\1'));
  CHECK_SAYS(
      refusal(folder,
              std::string(kHead) + kTwo +
                  "[[terrain]]\nraster = \"dem.asc\"\nclass_map = \"class.pgm\"\nmaterials = { 1 = \"dark\" }\n"),
      "map without georeferencing does not fit the terrain (found 5 x 5 pixels in class.pgm); it needs the "
      "terrain's 3 x 3 pixels or its 2 x 2 cells");
}

TEST_CASE(
    "bad input S2: terrain without data, class without material, no georeferencing, other system, missing "
    "raster") {
  const Folder folder;
  folder.write("dem.asc", ascii_grid(3, 2, 0, 0, 1, {1, 2, -9999, 4, 5, 6}));
  const std::string head = std::string(kHead) + kTwo + "[[terrain]]\nraster = \"dem.asc\"\n";
  CHECK_SAYS(refusal(folder, head + "material = \"dark\"\n"),
             "dem.asc: row 0, column 2: terrain has posts without data (found 1 of 6); set nodata = "
             "\"interpolate\" or \"constant\" in scene.toml:8:1");
  CHECK(refusal(folder, head + "material = \"dark\"\nnodata = \"interpolate\"\n") == "");
  const auto filled = load(folder, head + "material = \"dark\"\nnodata = \"constant\"\nnodata_height_m = -7\n").scene;
  CHECK(lowest(placed_triangles(filled))[2] == -7.0);
  const auto smooth = load(folder, head + "material = \"dark\"\nnodata = \"interpolate\"\n").scene;
  // Inverse-distance weights: inside the range of the valid posts.
  CHECK(lowest(placed_triangles(smooth))[2] == 1.0);
  CHECK(highest(placed_triangles(smooth))[2] == 6.0);
  folder.write("dem.asc", ascii_grid(3, 2, 0, 0, 1, {1, 2, 3, 4, 5, 6}));
  folder.write("class.asc", ascii_grid(2, 1, 0.5, 0.5, 1, {1, 7}));
  CHECK_SAYS(refusal(folder, head + "class_map = \"class.asc\"\nmaterials = { 1 = \"dark\" }\n"),
             "class.asc: row 0, column 1: class has no material (found 7 on 1 cell)");
  CHECK_SAYS(refusal(folder, head), "a terrain needs exactly one of material, class_map, mixture_map (found 0)");
  folder.write("no.pgm", "P5\n2 2\n255\n" + std::string(4, '\1'));
  CHECK_SAYS(refusal(folder, std::string(kHead) + kTwo + "[[terrain]]\nraster = \"no.pgm\"\nmaterial = \"dark\"\n"),
             "scene.toml:9:1: raster has no georeferencing (found no.pgm); give cell_m");
  CHECK_SAYS(refusal(folder, std::string(kHead) + kTwo + "[[terrain]]\nraster = \"none.tif\"\nmaterial = \"dark\"\n"),
             "scene.toml:9:1: cannot read file (found none.tif)");
  folder.write("text.tif", "not a raster");
  CHECK_SAYS(refusal(folder, std::string(kHead) + kTwo + "[[terrain]]\nraster = \"text.tif\"\nmaterial = \"dark\"\n"),
             "text.tif: GDAL cannot read the raster");
  folder.write("far.asc", ascii_grid(2, 2, 500000, 4750000, 1, {1, 2, 3, 4}));
  CHECK_SAYS(refusal(folder, std::string(kHead) + kTwo + "[[terrain]]\nraster = \"far.asc\"\nmaterial = \"dark\"\n"),
             "raster lies more than 100 km from scene.origin (found centre at 500001, 4750001)");
}

TEST_CASE("bad input S2: a 10 GB dimension in a small raster header is refused before anything is allocated") {
  const Folder folder;
  const std::string head = std::string(kHead) + kGrey + "[[terrain]]\ncell_m = 1\nmaterial = \"grey\"\n";
  folder.write("dem.img", std::string(16, '\0'));
  folder.write("dem.hdr",
               "ENVI\nsamples = 100000\nlines = 100000\nbands = 1\nheader offset = 0\nfile type = ENVI Standard\n"
               "data type = 4\ninterleave = bsq\nbyte order = 0\n");
  CHECK_SAYS(refusal(folder, head + "raster = \"dem.img\"\n"),
             "dem.img: GDAL cannot read the raster (found Image file is too small)");
  // A format whose size GDAL does not check against the file.
  folder.write("dem.vrt",
               "<VRTDataset rasterXSize=\"100000\" rasterYSize=\"100000\"><VRTRasterBand "
               "dataType=\"Float32\" band=\"1\"/></VRTDataset>");
  CHECK_SAYS(refusal(folder, head + "raster = \"dem.vrt\"\n"),
             "dem.vrt: raster is too large (found 100000 x 100000 pixels)");
}

TEST_CASE("S2 UTM-sized origin: georeferenced doubles are subtracted before they are rounded to float") {
  const Folder folder;
  // Posts 0.25 m apart at UTM offsets, where a float steps by 0.5 m in northing.
  std::vector<double> z{180.125, 180.25, 180.375, 180.5};
  folder.write("dem.asc", ascii_grid(2, 2, 276000.125, 4753000.125, 0.25, z));
  const auto scene =
      load(folder, std::string(kHead) + kGrey +
                       "[scene]\norigin = { epsg = 32618, easting_m = 276000, northing_m = 4753000, height_m "
                       "= 180 }\n[[terrain]]\nraster = \"dem.asc\"\nmaterial = \"grey\"\n")
          .scene;
  CHECK(scene.origin.northing_m == 4753000.0);
  CHECK(lowest(placed_triangles(scene)) == Vector{0.25, 0.25, 0.125});
  CHECK(highest(placed_triangles(scene)) == Vector{0.5, 0.5, 0.5});
}

TEST_CASE(
    "S2 gate: linear and stochastic mixtures have the same mean, that of sixteen seeds within 4 standard errors") {
  const Folder folder;
  // 60 x 60 cells, three materials; fractions vary over the map. The PPM's bands sum to 255 = 1, unsigned
  // bytes scaled by a VRT, which is what a user's GDAL would read.
  const int n = 60;
  std::string pixels;
  std::vector<std::array<double, 3>> fractions;
  for (int i = 0; i < n * n; ++i) {
    const int a = (i * 37) % 200, b = (i * 91) % (255 - a), c = 255 - a - b;
    pixels += {static_cast<char>(a), static_cast<char>(b), static_cast<char>(c)};
    fractions.push_back({a / 255.0, b / 255.0, c / 255.0});
  }
  std::string mixture =
      "ENVI\nsamples = 60\nlines = 60\nbands = 3\nheader offset = 0\nfile type = ENVI Standard\ndata type = "
      "4\ninterleave = bip\nbyte order = 0\n";
  std::vector<float> values;
  for (const auto& f : fractions)
    for (const double one : f) values.push_back(static_cast<float>(one));
  folder.write("mix.img", std::string(reinterpret_cast<const char*>(values.data()), values.size() * 4));
  folder.write("mix.hdr", mixture);
  folder.write("dem.asc", ascii_grid(n + 1, n + 1, 0, 0, 1, std::vector<double>((n + 1) * (n + 1), 0)));
  const std::string head = std::string(kHead) +
                           "[[material]]\nname = \"a\"\nreflectance = 0.05\n[[material]]\nname = "
                           "\"b\"\nreflectance = 0.9\n[[material]]\nname = \"c\"\nreflectance = 0.4\n" +
                           "[[terrain]]\nraster = \"dem.asc\"\nmixture_map = \"mix.img\"\nmaterials = { 1 = "
                           "\"a\", 2 = \"b\", 3 = \"c\" }\n";
  const double r[3] = {0.05, 0.9, 0.4};
  const auto mean = [&](const CompiledScene& scene) {
    double sum = 0, weight = 0;
    for (const auto& t : placed_triangles(scene)) {
      const auto& s = scene.surfaces[t.surface];
      double reflectance = 0;
      for (int k = 0; k < 4; ++k)
        if (s.material[k])
          reflectance += double(s.fraction[k]) * scene.materials[s.material[k] - 1].reflectance.value[0];
      sum += area(t) * reflectance, weight += area(t);
    }
    return sum / weight;
  };
  double expected = 0, variance = 0;
  for (const auto& f : fractions) {
    double m = 0, m2 = 0;
    for (int k = 0; k < 3; ++k) m += f[k] * r[k], m2 += f[k] * r[k] * r[k];
    expected += m, variance += m2 - m * m;
  }
  expected /= n * n;
  const double standard_error = std::sqrt(variance) / (n * n);
  // Fractions are stored in float: 6e-8 each.
  CHECK(mean(load(folder, head).scene) == doctest::Approx(expected).epsilon(1e-6));
  // One draw scatters by the standard error; the mean of sixteen by a quarter of it, and four of those are held.
  constexpr int kSeeds = 16;
  double last = 0, drawn = 0;
  for (int own = 1; own <= kSeeds; ++own) {
    const std::string seed = std::to_string(raycube::testing::seed(static_cast<std::uint64_t>(own)));
    const double stochastic = mean(load(folder, head + "mixture = \"stochastic\"\nseed = " + seed + "\n").scene);
    CAPTURE(seed);
    CHECK(stochastic != last);
    last = stochastic, drawn += stochastic / kSeeds;
  }
  CHECK_WITHIN(drawn - expected, 4 * standard_error / std::sqrt(double{kSeeds}));
  CHECK(load(folder, head + "mixture = \"stochastic\"\n").scene.content_hash ==
        load(folder, head + "mixture = \"stochastic\"\nseed = 1\n").scene.content_hash);
}

TEST_CASE("one post, one number and one cell are told as one; large counts in digits") {
  const Folder folder;
  const std::string head = std::string(kHead) + kTwo + "[[terrain]]\nraster = \"dem.asc\"\nmaterial = \"dark\"\n";
  const auto told = [&](const std::string& text) {
    std::string all;
    for (const auto& notice : load(folder, text).notices) all += notice + "\n";
    return all;
  };
  folder.write("dem.asc", ascii_grid(4, 4, 0, 0, 1, {1, 2, 1, 2, 1, 600, 1, 2, 2, 1, 2, 1, 1, 2, 1, 2}));
  CHECK_SAYS(told(head), "1 post of height 600 stands alone, more than 100 m from all its neighbours");
  folder.write("dem.asc", ascii_grid(4, 4, 0, 0, 1, {1, 600, 1, 2, 1, 2, 1, 2, 2, 1, 2, 1, 1, 600, 1, 2}));
  CHECK_SAYS(told(head), "2 posts of height 600 stand alone, more than 100 m from all their neighbours");
  folder.write("bands.csv", "center_nm;fwhm_nm\n500,5;20\n");
  const std::string camera =
      "[[instrument]]\nname = \"c\"\nkind = \"framing\"\npixels = 1\nlines = 1\nposition_m = [0, 0, 900]\n"
      "ifov_mrad = 1.0\nbands = { file = \"bands.csv\" }\n";
  const std::string sun = "[time]\nsun = { zenith_deg = 40, azimuth_deg = 0 }\n";
  CHECK_SAYS(told(std::string(kHead) + kTwo + sun + camera), "1 number with decimal commas read as such");
  CHECK(number_text(5e7) == "50000000");
  CHECK(number_text(-100000.0) == "-100000");
  CHECK(number_text(1e-20) == "1e-20");
  CHECK(number_text(2e15) == "2e+15");
}

TEST_CASE("bad input S2: fractions that do not sum to 1 within 1e-3, or lie outside 0 .. 1") {
  const Folder folder;
  folder.write("dem.asc", ascii_grid(3, 2, 0, 0, 1, std::vector<double>(6, 0)));
  folder.write("mix.hdr",
               "ENVI\nsamples = 2\nlines = 1\nbands = 2\nheader offset = 0\nfile type = ENVI Standard\ndata "
               "type = 4\ninterleave = bip\nbyte order = 0\n");
  const auto mix = [&](std::vector<float> values) {
    folder.write("mix.img", std::string(reinterpret_cast<const char*>(values.data()), values.size() * 4));
    return refusal(folder, std::string(kHead) + kTwo +
                               "[[terrain]]\nraster = \"dem.asc\"\nmixture_map = \"mix.img\"\nmaterials = { "
                               "1 = \"dark\", 2 = \"light\" }\n");
  };
  CHECK(mix({0.5f, 0.5005f, 1, 0}) == "");
  CHECK_SAYS(mix({0.5f, 0.5f, 0.5f, 0.52f}),
             "mix.img: row 0, column 1: fractions do not sum to 1 within 1e-3 (found 1.0199");
  CHECK_SAYS(mix({1.5f, -0.5f, 1, 0}), "mix.img: row 0, column 0: fraction outside 0 .. 1");
}
