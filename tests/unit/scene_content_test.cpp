// What a scene is made of: meshes, panels, placements, instruments (S1, S2's checkerboard, S3, S4).
#include <cmath>
#include <set>

#include "scene_compiler/panels.h"
#include "scene_compiler/polygon.h"
#include "tests/support/chance_checks.h"
#include "tests/unit/scene_triangles.h"

using namespace raycube;
using namespace raycube::scene;
using namespace raycube::scene::testing;

namespace {

/// Signed volume by the divergence theorem: positive when faces look outward.
double volume(const std::vector<Triangle>& triangles) {
  double sum = 0;
  for (const auto& t : triangles) {
    const auto n = cross_of(t);
    sum += (t.v[0][0] * n[0] + t.v[0][1] * n[1] + t.v[0][2] * n[2]) / 6.0;
  }
  return sum;
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
    const std::string seed = std::to_string(raycube::testing::seed(1));
    const auto scene = load(folder, head + "seed = " + seed + "\n" + more).scene;
    for (std::size_t i = 1; i < scene.instances.size(); ++i)
      CHECK(inside(scene.instances[i].world_from_local_0.w, scene.instances[i].world_from_local_1.w));
    return static_cast<double>(scene.instances.size() - 1);
  };
  CHECK(count("rectangle_m = [10, 10, 90, 60]\n",
              [](float x, float y) { return x >= 10 && x <= 90 && y >= 10 && y <= 60; }) == 2000);
  // A triangle of half the rectangle, and the class's half of the terrain: binomial, 4 standard deviations.
  const double triangle = count("polygon_m = [[10, 10], [90, 10], [10, 60]]\n",
                                [](float x, float y) { return (x - 10) / 80 + (y - 10) / 50 <= 1.0001f; });
  CHECK_WITHIN(triangle - 1000, 4 * std::sqrt(2000 * 0.25));
  const double west = count("class = 1\n", [](float x, float) { return x <= 50; });
  CHECK_WITHIN(west - 2500, 4 * std::sqrt(5000 * 0.25));
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
