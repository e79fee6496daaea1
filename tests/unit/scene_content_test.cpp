// What a scene is made of: meshes, panels, terrain, placements, instruments (S1-S4).
#include <cmath>
#include <set>

#include "scene_compiler/ground.h"
#include "scene_compiler/option_table.h"
#include "scene_compiler/panels.h"
#include "scene_compiler/polygon.h"
#include "scene_compiler/raster.h"
#include "scene_compiler/terrain.h"
#include "scene_files.h"

using namespace raycube;
using namespace raycube::scene;
using namespace raycube::scene::testing;

namespace {

using Vector = std::array<double, 3>;

struct Triangle {
  std::array<Vector, 3> v;
  std::uint32_t surface = 0;
  std::uint32_t face = 0;
};

/// Every placed triangle in the scene frame, from the compiled buffers in double.
std::vector<Triangle> placed_triangles(const CompiledScene& scene) {
  std::vector<Triangle> out;
  for (const auto& instance : scene.instances) {
    const auto& mesh = scene.meshes[instance.mesh];
    const auto place = [&](float x, float y, float z) {
      const auto row = [&](const shared::rc_float4& r) {
        return double(r.x) * x + double(r.y) * y + double(r.z) * z + double(r.w);
      };
      return Vector{row(instance.world_from_local_0), row(instance.world_from_local_1),
                    row(instance.world_from_local_2)};
    };
    for (std::uint32_t b = 0; b < mesh.block_count; ++b)
      for (int lane = 0; lane < RC_BLOCK; ++lane) {
        const auto& block = scene.blocks[mesh.first_block + b];
        if (block.surface[lane] == RC_NONE) continue;
        out.push_back({{place(block.v0_x[lane], block.v0_y[lane], block.v0_z[lane]),
                        place(block.v1_x[lane], block.v1_y[lane], block.v1_z[lane]),
                        place(block.v2_x[lane], block.v2_y[lane], block.v2_z[lane])},
                       block.surface[lane],
                       mesh.user_face[b * RC_BLOCK + static_cast<std::uint32_t>(lane)]});
      }
  }
  return out;
}

Vector cross_of(const Triangle& t) {
  Vector e, f;
  for (int k = 0; k < 3; ++k) e[k] = t.v[1][k] - t.v[0][k], f[k] = t.v[2][k] - t.v[0][k];
  return {e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]};
}
double area(const Triangle& t) {
  const auto n = cross_of(t);
  return 0.5 * std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
}
/// Signed volume by the divergence theorem: positive when faces look outward.
double volume(const std::vector<Triangle>& triangles) {
  double sum = 0;
  for (const auto& t : triangles) {
    const auto n = cross_of(t);
    sum += (t.v[0][0] * n[0] + t.v[0][1] * n[1] + t.v[0][2] * n[2]) / 6.0;
  }
  return sum;
}
double total_area(const std::vector<Triangle>& triangles) {
  double sum = 0;
  for (const auto& t : triangles) sum += area(t);
  return sum;
}

Vector lowest(const std::vector<Triangle>& triangles) {
  Vector out = triangles.at(0).v[0];
  for (const auto& t : triangles)
    for (const auto& v : t.v)
      for (int k = 0; k < 3; ++k) out[k] = std::min(out[k], v[k]);
  return out;
}
Vector highest(const std::vector<Triangle>& triangles) {
  Vector out = triangles.at(0).v[0];
  for (const auto& t : triangles)
    for (const auto& v : t.v)
      for (int k = 0; k < 3; ++k) out[k] = std::max(out[k], v[k]);
  return out;
}

constexpr const char* kTwo =
    "[[material]]\nname = \"dark\"\nreflectance = 0.1\n[[material]]\nname = \"light\"\nreflectance = 0.8\n";

/// ESRI ASCII grid, row 0 north; corner of the lower left pixel at (x, y).
std::string ascii_grid(int columns, int rows, double x, double y, double cell, const std::vector<double>& values) {
  std::string out = "ncols " + std::to_string(columns) + "\nnrows " + std::to_string(rows) + "\nxllcorner " +
                    std::to_string(x) + "\nyllcorner " + std::to_string(y) + "\ncellsize " + std::to_string(cell) +
                    "\nNODATA_value -9999\n";
  for (int r = 0; r < rows; ++r, out += "\n")
    for (int c = 0; c < columns; ++c) out += std::to_string(values[static_cast<std::size_t>(r * columns + c)]) + " ";
  return out;
}

std::string camera(const std::string& more) {
  return "time = { sun = { zenith_deg = 30 } }\n[[instrument]]\nname = \"i\"\nbands = { first_nm = 500, "
         "step_nm = 10, count = 3, fwhm_nm = 10 }\n" +
         more;
}

}  // namespace

TEST_CASE("S1 polygons: convex, concave and tilted ones keep area and orientation") {
  // An L of area 3, counter-clockwise, in a plane tilted about x by atan(0.75): its area grows by 1.25.
  const std::vector<std::array<double, 2>> flat{{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};
  std::vector<Vector> corners;
  for (const auto& p : flat) corners.push_back({p[0], p[1], 0.75 * p[1]});
  const auto triangles = triangulate_polygon(corners);
  REQUIRE(triangles.size() == 4);
  double sum = 0;
  for (const auto& index : triangles) {
    const Triangle t{{corners[index[0]], corners[index[1]], corners[index[2]]}};
    CHECK(cross_of(t)[2] > 0);
    sum += area(t);
  }
  CHECK(sum == doctest::Approx(3 * 1.25).epsilon(1e-14));
}

TEST_CASE("S1 mesh: material goes before group, face numbers are the file's, up axis and unit are applied") {
  const Folder folder;
  folder.write("m.obj",
               "o crown\nv 0 0 0\nv 100 0 0\nv 100 0 -100\nv 0 0 -100\nv 0 50 0\nusemtl leaf\nf 1 2 3 "
               "4\nusemtl bark\nf 1 2 5\n");
  const auto simulation =
      load(folder, std::string(kHead) + kTwo +
                       "[[mesh]]\nname = \"m\"\nfile = \"m.obj\"\nunit_m = 0.01\nup = \"y\"\nmaterials = { "
                       "leaf = \"light\", bark = \"dark\", crown = \"dark\" }\n[[instance]]\nmesh = \"m\"\n");
  const auto triangles = placed_triangles(simulation.scene);
  REQUIRE(triangles.size() == 3);
  std::multiset<std::uint32_t> faces;
  for (const auto& t : triangles) {
    faces.insert(t.face);
    // (x, y, z) -> (x, -z, y): the quad lies on the ground facing up, the triangle stands in the plane y = 0.
    if (t.surface == 1) CHECK(cross_of(t)[2] == doctest::Approx(1.0).epsilon(1e-6));
    if (t.surface == 0) CHECK(std::abs(cross_of(t)[1]) == doctest::Approx(0.5).epsilon(1e-6));
  }
  CHECK(faces == std::multiset<std::uint32_t>{0, 0, 1});
}

TEST_CASE("S1 plane: size, turn and tilt; its normal leans towards the given azimuth") {
  const Folder folder;
  const auto simulation = load(folder, std::string(kHead) + kGrey +
                                           "[[plane]]\nmaterial = \"grey\"\nsize_m = [2, 3]\nposition_m = "
                                           "[10, 20, 5]\nyaw_deg = 90\ntilt_deg = 30\n");
  const auto triangles = placed_triangles(simulation.scene);
  REQUIRE(triangles.size() == 2);
  CHECK(total_area(triangles) == doctest::Approx(6).epsilon(1e-6));
  for (const auto& t : triangles) {
    const auto n = cross_of(t);
    const double length = 2 * area(t);
    CHECK(n[0] / length == doctest::Approx(0.5).epsilon(1e-6));  // leans east
    CHECK(n[1] / length == doctest::Approx(0).epsilon(1e-6));
    CHECK(n[2] / length == doctest::Approx(std::sqrt(0.75)).epsilon(1e-6));
  }
}

TEST_CASE("S2 checkerboard: squares are geometry, areas alternate exactly, cut squares at the far edges") {
  const Folder folder;
  const auto simulation =
      load(folder, std::string(kHead) + kTwo +
                       "[[plane]]\nsize_m = [2.5, 2]\nchecker = { materials = [\"dark\", \"light\"], cell_m = 1 }\n");
  const auto triangles = placed_triangles(simulation.scene);
  CHECK(triangles.size() == 12);
  double dark = 0;
  for (const auto& t : triangles) {
    if (t.surface == 0) dark += area(t);
    const double x = (t.v[0][0] + t.v[1][0] + t.v[2][0]) / 3 + 1.25, y = (t.v[0][1] + t.v[1][1] + t.v[2][1]) / 3 + 1;
    CHECK(t.surface == static_cast<std::uint32_t>((int(x) + int(y)) % 2));
  }
  CHECK(total_area(triangles) == doctest::Approx(5).epsilon(1e-6));
  CHECK(dark == doctest::Approx(2.5).epsilon(1e-6));
}

TEST_CASE("S1 box: closed, faces outward, one material per face, north before turning") {
  const Folder folder;
  const auto simulation = load(folder, std::string(kHead) + kTwo +
                                           "[[box]]\nmaterial = \"dark\"\nmaterials = { north = \"light\" "
                                           "}\nsize_m = [2, 3, 4]\nposition_m = [1, 1, 0]\nyaw_deg = 90\n");
  const auto triangles = placed_triangles(simulation.scene);
  CHECK(triangles.size() == 12);
  CHECK(volume(triangles) == doctest::Approx(24).epsilon(1e-6));
  double light = 0;
  for (const auto& t : triangles)
    if (t.surface == 1) {
      light += area(t);
      CHECK(cross_of(t)[0] / (2 * area(t)) == doctest::Approx(1).epsilon(1e-6));  // local north turned to the east
    }
  CHECK(light == doctest::Approx(8).epsilon(1e-6));
}

TEST_CASE("S3 transforms: scale, turn, move equals its matrix; 16 numbers equal 12") {
  const Folder folder;
  folder.write("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const std::string head =
      std::string(kHead) + kGrey + "[[mesh]]\nname = \"m\"\nfile = \"m.obj\"\nmaterial = \"grey\"\n";
  const auto turned_scene =
      load(folder, head + "[[instance]]\nmesh = \"m\"\nposition_m = [5, 6, 7]\nyaw_deg = 90\nscale = 2\n").scene;
  const auto matrix =
      load(folder, head +
                       "[[instance]]\nmesh = \"m\"\nmatrix = [0,2,0,5, -2,0,0,6, 0,0,2,7]\n[[instance]]\nmesh = "
                       "\"m\"\nmatrix = [0,2,0,5, -2,0,0,6, 0,0,2,7, 0,0,0,1]\n")
          .scene;
  const auto a = placed_triangles(turned_scene), b = placed_triangles(matrix);
  REQUIRE(b.size() == 2);
  for (int k = 0; k < 3; ++k)
    for (int c = 0; c < 3; ++c) {
      CHECK(a[0].v[k][c] == doctest::Approx(b[0].v[k][c]).epsilon(1e-6));
      CHECK(b[0].v[k][c] == b[1].v[k][c]);
    }
  // Clockwise from north: +y of the mesh points east.
  CHECK(a[0].v[2][0] == doctest::Approx(7).epsilon(1e-6));
  CHECK(a[0].v[2][1] == doctest::Approx(6).epsilon(1e-6));
  // The stored inverse takes world points back.
  const auto& i = turned_scene.instances[0];
  const auto back = [&](const shared::rc_float4& r) {
    return r.x * a[0].v[2][0] + r.y * a[0].v[2][1] + r.z * a[0].v[2][2] + r.w;
  };
  CHECK(back(i.local_from_world_0) == doctest::Approx(0).epsilon(1e-6));
  CHECK(back(i.local_from_world_1) == doctest::Approx(1).epsilon(1e-6));
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
             "class.asc: row 0, column 1: class has no material (found 7 on 1 cells)");
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

TEST_CASE("S2 gate: linear and stochastic mixtures have the same mean within 3 standard errors") {
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
  double last = 0;
  for (const char* seed : {"1", "2", "3"}) {
    const double stochastic = mean(load(folder, head + "mixture = \"stochastic\"\nseed = " + seed + "\n").scene);
    CAPTURE(seed);
    CHECK(std::abs(stochastic - expected) < 3 * standard_error);
    CHECK(stochastic != last);
    last = stochastic;
  }
  CHECK(load(folder, head + "mixture = \"stochastic\"\n").scene.content_hash ==
        load(folder, head + "mixture = \"stochastic\"\nseed = 1\n").scene.content_hash);
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

TEST_CASE("S3 scatter: CSV places, drop on the terrain, off the terrain refused with its line") {
  const Folder folder;
  folder.write("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  folder.write("dem.asc", ascii_grid(3, 3, 0, 0, 10, {30, 30, 30, 20, 20, 20, 10, 10, 10}));
  folder.write("p.csv", "x_m,y_m,yaw_deg,scale\n10,10,0,1\n20,20,90,2\n");
  const std::string head = std::string(kHead) + kGrey +
                           "[[terrain]]\nraster = \"dem.asc\"\nmaterial = \"grey\"\n[[mesh]]\nname = \"m\"\nfile = "
                           "\"m.obj\"\nmaterial = \"grey\"\n[[scatter]]\nmesh = \"m\"\npositions = \"p.csv\"\n";
  const auto scene = load(folder, head).scene;
  REQUIRE(scene.instances.size() == 3);
  CHECK(scene.instances[1].world_from_local_2.w == doctest::Approx(15));
  CHECK(scene.instances[2].world_from_local_2.w == doctest::Approx(25));
  CHECK(scene.instances[2].world_from_local_2.z == 2.0f);
  folder.write("p.csv", "x_m,y_m\n10,10\n500,0\n");
  CHECK_SAYS(refusal(folder, head), "p.csv:3: place is off the terrain (found x 500, y 0)");
}

TEST_CASE("S3 scatter by density: count, region, class, seed") {
  const Folder folder;
  folder.write("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  std::vector<double> classes;
  for (int i = 0; i < 100; ++i) classes.push_back(i % 10 < 5 ? 1 : 2);  // west half class 1
  folder.write("dem.asc", ascii_grid(11, 11, -5, -5, 10, std::vector<double>(121, 0)));
  folder.write("class.asc", ascii_grid(10, 10, 0, 0, 10, classes));
  const std::string head = std::string(kHead) + kGrey +
                           "[[terrain]]\nraster = \"dem.asc\"\nclass_map = \"class.asc\"\nmaterials = { 1 = "
                           "\"grey\", 2 = \"grey\" }\n[[mesh]]\nname = \"m\"\nfile = \"m.obj\"\nmaterial = "
                           "\"grey\"\n[[scatter]]\nmesh = \"m\"\ndensity_per_m2 = 0.5\n";
  const auto count = [&](const std::string& more, auto&& inside) {
    const auto scene = load(folder, head + more).scene;
    for (std::size_t i = 1; i < scene.instances.size(); ++i)
      CHECK(inside(scene.instances[i].world_from_local_0.w, scene.instances[i].world_from_local_1.w));
    return static_cast<double>(scene.instances.size() - 1);
  };
  CHECK(count("rectangle_m = [10, 10, 90, 60]\n",
              [](float x, float y) { return x >= 10 && x <= 90 && y >= 10 && y <= 60; }) == 2000);
  // A triangle of half the rectangle, and the class's half of the terrain: binomial, 4 standard deviations.
  const double triangle = count("polygon_m = [[10, 10], [90, 10], [10, 60]]\n",
                                [](float x, float y) { return (x - 10) / 80 + (y - 10) / 50 <= 1.0001f; });
  CHECK(std::abs(triangle - 1000) < 4 * std::sqrt(2000 * 0.25));
  const double west = count("class = 1\n", [](float x, float) { return x <= 50; });
  CHECK(std::abs(west - 2500) < 4 * std::sqrt(5000 * 0.25));
  const auto hash = [&](const std::string& more) { return load(folder, head + more).scene.content_hash; };
  CHECK(hash("class = 1\n") == hash("class = 1\nseed = 1\n"));
  CHECK(hash("class = 1\n") != hash("class = 1\nseed = 2\n"));
}

TEST_CASE("includes: entries add up, paths are relative to the file that names them") {
  const Folder folder;
  folder.write("lib/materials.toml", "format = 1\n[[material]]\nname = \"m\"\nfile = \"m.csv\"\n");
  folder.write("lib/m.csv", "wavelength_um,reflectance\n0.4,0.25\n0.8,0.5\n");
  const auto simulation =
      load(folder, std::string(kHead) + kGrey +
                       "[scene]\ninclude = [\"lib/materials.toml\"]\n[[plane]]\nmaterial = \"m\"\nsize_m = [1, 1]\n");
  REQUIRE(simulation.scene.materials.size() == 2);
  CHECK(simulation.scene.materials[1].reflectance.value[0] == 0.25);
}

TEST_CASE("an empty scene and a scene of one triangle compile") {
  const Folder folder;
  const auto empty = load(folder, kHead).scene;
  CHECK(empty.instances.empty());
  REQUIRE(!empty.nodes.empty());
  CHECK(empty.nodes[0].count == 0);
  folder.write("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const auto one =
      load(folder, std::string(kHead) + kGrey +
                       "[[mesh]]\nname = \"m\"\nfile = \"m.obj\"\nmaterial = \"grey\"\n[[instance]]\nmesh = \"m\"\n")
          .scene;
  CHECK(placed_triangles(one).size() == 1);
}

TEST_CASE("a mesh that is never placed gives a notice") {
  const Folder folder;
  folder.write("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const auto simulation =
      load(folder, std::string(kHead) + kGrey + "[[mesh]]\nname = \"m\"\nfile = \"m.obj\"\nmaterial = \"grey\"\n");
  REQUIRE(simulation.notices.size() == 1);
  CHECK_SAYS(simulation.notices[0], "mesh 'm' is never placed");
}

TEST_CASE("instruments: altitude above terrain, scale three ways, defaults") {
  const Folder folder;
  folder.write("dem.asc", ascii_grid(3, 3, -15, -15, 10, std::vector<double>(9, 50)));
  const std::string terrain = std::string(kGrey) + "[[terrain]]\nraster = \"dem.asc\"\nmaterial = \"grey\"\n";
  const auto read = [&](const std::string& more) {
    return load(folder, kHead + camera("kind = \"framing\"\npixels = 4\nlines = 3\n" + more) + terrain)
        .instruments.at(0);
  };
  const auto a = read("altitude_agl_m = 100\ngsd_m = 0.5\n");
  REQUIRE(a.poses.size() == 1);
  CHECK(a.poses[0].z_m == 150.0);
  CHECK(a.nominal_agl_m == 100.0);
  CHECK(a.ifov_across_rad == doctest::Approx(0.005).epsilon(1e-15));
  CHECK(a.samples_u == 11);
  CHECK(a.sampler == SamplerKind::grid);
  CHECK(a.psf_support_px == 1.0);
  CHECK(read("position_m = [0, 0, 150]\nfocal_length_mm = 50\npitch_um = 250\n").ifov_along_rad ==
        doctest::Approx(0.005).epsilon(1e-15));
  CHECK(read("position_m = [0, 0, 150]\nifov_mrad = 5\n").ifov_along_rad == doctest::Approx(0.005).epsilon(1e-15));
  // Off the terrain the height counts from z = 0.
  CHECK(read("altitude_agl_m = 100\ncenter_m = [1000, 0]\ngsd_m = 1\n").poses[0].z_m == 100.0);
  const auto psf = read("altitude_agl_m = 100\ngsd_m = 1\nsamples = { jittered = [4, 5] }\npsf = { sigma_px = 0.5 }\n");
  CHECK(psf.sampler == SamplerKind::jittered);
  CHECK(psf.samples_v == 5);
  CHECK(psf.psf_support_px == doctest::Approx(4));
  CHECK_SAYS(refusal(folder, kHead +
                                 camera("kind = \"framing\"\npixels = 4\nlines = 3\naltitude_agl_m = 1\ngsd_m "
                                        "= 1\nsamples = { lattice = 100 }\npsf = { sigma_px = 0.5 }\n") +
                                 terrain),
             "a point spread needs the grid or jittered sampler");
  CHECK_SAYS(refusal(folder,
                     kHead + camera("kind = \"framing\"\npixels = 4\nlines = 3\nposition_m = [0, 0, 20]\ngsd_m = 1\n") +
                         terrain),
             "gsd_m needs the instrument above the ground (found -30 m above it)");
}

TEST_CASE(
    "instruments: a straight flight has one pose per line or per sample, in time order, spaced by the ground "
    "distance") {
  const Folder folder;
  const auto read = [&](const std::string& more) {
    return load(folder,
                kHead + camera("pixels = 4\nlines = 3\naltitude_agl_m = 100\ngsd_m = 2\nheading_deg = 90\n" + more))
        .instruments.at(0);
  };
  const auto push = read("kind = \"pushbroom\"\n");
  REQUIRE(push.poses.size() == 3);
  for (int line = 0; line < 3; ++line) {
    CHECK(push.poses[line].x_m == doctest::Approx(2.0 * (line - 1)).epsilon(1e-14));
    CHECK(push.poses[line].y_m == doctest::Approx(0).epsilon(1e-14));
    CHECK(push.poses[line].heading_deg == 90);
  }
  CHECK(read("kind = \"pushbroom\"\nline_spacing_m = 5\n").poses[2].x_m == doctest::Approx(5));
  const auto whisk = read("kind = \"whiskbroom\"\n");
  REQUIRE(whisk.poses.size() == 12);
  for (int i = 0; i < 12; ++i) CHECK(whisk.poses[i].x_m == doctest::Approx(2.0 * ((i + 0.5) / 4 - 1.5)).epsilon(1e-14));
  // Poses of lines give those of pixels, linear in time: the straight flight again.
  folder.write("p.csv", "x_m,y_m,z_m,heading_deg\n-2,0,100,350\n0,0,100,0\n2,0,100,10\n");
  const auto listed =
      load(folder, kHead + camera("pixels = 4\nlines = 3\nkind = \"whiskbroom\"\nposes = \"p.csv\"\nifov_mrad = 20\n"))
          .instruments.at(0);
  REQUIRE(listed.poses.size() == 12);
  for (int i = 0; i < 12; ++i) {
    CHECK(listed.poses[i].x_m == doctest::Approx(whisk.poses[i].x_m).epsilon(1e-14));
    CHECK(std::remainder(listed.poses[i].heading_deg, 360.0) ==
          doctest::Approx(10.0 * ((i + 0.5) / 4 - 1.5)).epsilon(1e-12));
  }
}

TEST_CASE("sun: from utc and the origin's place, its azimuth turned from true to grid north") {
  const Folder folder;
  const auto sun = [&](const std::string& origin) {
    return load(folder, std::string(kHead) + "scene = { origin = { " + origin +
                            " } }\ntime = { utc = \"2003-10-17T19:30:30Z\" }\n")
        .sun;
  };
  // Reda & Andreas 2008 (NREL/TP-560-34302), table A5.1: zenith 50.1279 degrees without refraction, azimuth
  // 194.34024, at 39.742476 N, 105.1786 W. 0.01 degree is what the sun's own test promises.
  const auto place = sun("latitude_deg = 39.742476, longitude_deg = -105.1786");
  CHECK(place.zenith_deg == doctest::Approx(50.1279).epsilon(2e-4));
  CHECK(place.azimuth_deg == doctest::Approx(194.34024).epsilon(5e-5));
  CHECK(place.day_of_year == 290);
  // The same place in UTM 13N (its central meridian is 105 W): easting 484699.8, northing 4399279.6 to a
  // metre or so by the projection's own series; convergence = (lon + 105) sin(lat) = -0.11419 degrees, so
  // grid azimuth = true + 0.11419.
  const auto grid = sun("epsg = 32613, easting_m = 484699.8, northing_m = 4399279.6");
  CHECK(grid.zenith_deg == doctest::Approx(place.zenith_deg).epsilon(2e-5));
  CHECK(grid.azimuth_deg - place.azimuth_deg ==
        doctest::Approx(0.1786 * std::sin(39.742476 * M_PI / 180)).epsilon(0.01));
}

TEST_CASE("atmosphere: pressure from the ground height, model none, tables must exist") {
  const Folder folder;
  CHECK(load(folder, kHead).atmosphere.pressure_hPa == doctest::Approx(1013.25));
  // US Standard Atmosphere 1976: 898.76 hPa at 1000 m, 540.48 hPa at 5000 m (tables I, geopotential heights
  // agree to 0.1 %).
  CHECK(standard_pressure_hPa(1000) == doctest::Approx(898.76).epsilon(2e-4));
  CHECK(standard_pressure_hPa(5000) == doctest::Approx(540.48).epsilon(1e-3));
  CHECK(load(folder, std::string(kHead) + "atmosphere = { model = \"none\" }\n").atmosphere.none);
  CHECK_SAYS(refusal(folder, std::string(kHead) + "atmosphere = { tables = \"x.rct\" }\n"),
             "scene.toml:2:16: cannot read file (found x.rct)");
}
