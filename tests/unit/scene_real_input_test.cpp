// Meshes and terrain nobody here wrote (S1, S2). Figures: data/meshes/README.md and data/README.md of that
// folder, computed there by independent scripts.
#include <algorithm>
#include <cmath>

#include "scene_compiler/mesh_file.h"
#include "scene_compiler/owner.h"
#include "scene_compiler/raster.h"
#include "tests/unit/scene_files.h"

using namespace raycube;
using namespace raycube::scene;
using namespace raycube::scene::testing;

namespace {

struct Measures {
  std::size_t triangles = 0;
  double area = 0, volume = 0;
};

Measures measure(const TriangleMesh& mesh) {
  Measures out;
  out.triangles = mesh.triangles.size();
  for (const auto& t : mesh.triangles) {
    const auto &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    const double e[3] = {double(b[0]) - a[0], double(b[1]) - a[1], double(b[2]) - a[2]},
                 f[3] = {double(c[0]) - a[0], double(c[1]) - a[1], double(c[2]) - a[2]};
    const double n[3] = {e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]};
    out.area += 0.5 * std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    out.volume += (a[0] * n[0] + a[1] * n[1] + a[2] * n[2]) / 6;
  }
  return out;
}

}  // namespace

TEST_CASE("S1 real meshes: triangles, area and volume are those of an independent program") {
  const auto shared = shared_folder("real meshes");
  if (!shared) return;
  struct Expected {
    const char* file;
    std::size_t triangles;
    double area, volume;  // volume 0: open
  };
  // Areas and volumes are printed to 6 digits; vertices are floats.
  for (const Expected& expected :
       {Expected{"box100.obj", 12, 60000, 1e6}, Expected{"bunny_lowres.ply", 948, 0.0545925, 0},
        Expected{"fandisk_closed.obj", 12946, 60.6691, 20.2434}, Expected{"helios_tree1.obj", 6672, 0.719364, 0},
        Expected{"spot_cow_closed.obj", 5856, 5.70952, 0.718259}, Expected{"sphere.ply", 840, 200888, 8.42517e6},
        Expected{"suzanne_quads.obj", 968, 12.4685, 0}, Expected{"obj_edge_cases/box_mat_with_spaces.obj", 12, 6, 1},
        Expected{"obj_edge_cases/box_without_lineending.obj", 12, 6, 1},
        Expected{"obj_edge_cases/cube_usemtl.obj", 12, 6, 1}, Expected{"ply_edge_cases/cube_ascii.ply", 12, 6, 1},
        Expected{"ply_edge_cases/cube_binary.ply", 12, 6, 1},
        Expected{"ply_edge_cases/cube_binary_header_with_RN_newline.ply", 12, 6, 1},
        Expected{"ply_edge_cases/cube_uv.ply", 12, 24, 8}}) {
    CAPTURE(expected.file);
    base::Problems problems;
    const auto read = read_mesh_file(*shared + "/data/meshes/" + expected.file, {}, {}, problems);
    REQUIRE(read);
    const auto found = measure(read->mesh);
    CHECK(found.triangles + read->dropped_faces == expected.triangles);
    CHECK(found.area == doctest::Approx(expected.area).epsilon(1e-5));
    if (expected.volume > 0) CHECK(std::abs(found.volume) == doctest::Approx(expected.volume).epsilon(1e-5));
  }
}

TEST_CASE("S1 edge cases of OBJ and PLY: reported with their place, never a crash") {
  const auto shared = shared_folder("mesh edge cases");
  if (!shared) return;
  const auto message = [&](const std::string& file) {
    base::Problems problems;
    const auto read = read_mesh_file(*shared + "/data/meshes/" + file, {}, {}, problems);
    CHECK(!read);
    std::string out;
    for (const auto& line : problems.lines()) out += line + "\n";
    return out;
  };
  CHECK_SAYS(message("obj_edge_cases/malformed.obj"),
             "malformed.obj:23: face index out of range (found '12' with 8 vertices)");
  const std::string formats = message("obj_edge_cases/number_formats.obj");
  CHECK_SAYS(formats, "number_formats.obj:11: vertex coordinate is not a number (found '3.1+e2')");
  CHECK_SAYS(formats, "number_formats.obj:15: vertex coordinate is not a number (found '3.1-e2')");
  CHECK_SAYS(message("ply_edge_cases/points.ply"), "points.ply");
  // One concave polygon; a long line of 940 corners that revisits the same eight.
  base::Problems problems;
  const auto concave = read_mesh_file(*shared + "/data/meshes/obj_edge_cases/concave_polygon.obj", {}, {}, problems);
  REQUIRE(concave);
  const auto found = measure(concave->mesh);
  CHECK(concave->faces == 1);
  CHECK(found.triangles == 64);
  // 66 corners: a ring cut open. |Newell sum| / 2 over the file's corners is its area in closed form:
  // 0.2454967 (a fan, which ignores the concavity, would give 3.22). The file prints 7 digits.
  CHECK(found.area == doctest::Approx(0.2454967).epsilon(1e-5));
  const auto longline = read_mesh_file(*shared + "/data/meshes/obj_edge_cases/box_longline.obj", {}, {}, problems);
  REQUIRE(longline);
  CHECK(longline->faces == 6);
}

TEST_CASE(
    "S2 real DEM: five encodings of one terrain give the same posts, four the same compiled scene; row 0 is "
    "north") {
  const auto shared = shared_folder("real DEM");
  if (!shared) return;
  const Folder folder;
  std::string first;
  std::optional<Raster> first_raster;
  for (const char* file : {"heidelberg_dem_256_float32.tif", "heidelberg_dem_256_tiled_deflate.tif",
                           "heidelberg_dem_256_int16.tif", "heidelberg_dem_256_envi.dat", "heidelberg_dem_256.asc"}) {
    CAPTURE(file);
    const std::string path = *shared + "/data/dem/" + file;
    base::Problems problems;
    const auto raster = read_raster(path, {}, {}, problems);
    REQUIRE(raster);
    CHECK(raster->bands[0][0] == 109);
    CHECK(raster->bands[0][128 * 256 + 128] == 368);
    CHECK(raster->bands[0][255 * 256 + 255] == 461);
    CHECK(raster->system.epsg == 32632);
    const auto simulation =
        load(folder, std::string(kHead) + kGrey +
                         "[scene]\norigin = { epsg = 32632, easting_m = 475322, northing_m = 5477800 "
                         "}\n[[terrain]]\nraster = \"" +
                         path +
                         "\"\nmaterial = \"grey\"\n[[plane]]\nmaterial = \"grey\"\nsize_m = [1, "
                         "1]\nposition_m = [13.125829136, -12.109704260, 0]\non_terrain = true\n");
    CHECK(simulation.scene.meshes[0].triangle_count() == 2 * 255 * 255);
    if (first.empty()) first = simulation.scene.content_hash, first_raster = raster;
    // The int16 file rounds what the float files hold a float's last bits off whole metres (at most 2 ulp of
    // 256 m).
    const bool rounded = std::string(file).find("int16") != std::string::npos;
    double largest = 0;
    for (std::size_t i = 0; i < raster->bands[0].size(); ++i)
      largest = std::max(largest, std::abs(raster->bands[0][i] - first_raster->bands[0][i]));
    CHECK(largest <= (rounded ? 0x1p-15 : 0));
    if (!rounded) CHECK(simulation.scene.content_hash == first);
    // Upper left corner (gdalinfo) 475322.625829136, 5477800.390295740, posts 25 m apart: the first post
    // is 12.5 m in from it, its height 109 m.
    const std::uint32_t corner = MeshTriangles(simulation.scene).of(1)[0];
    CHECK(simulation.scene.blocks[corner / RC_BLOCK].v0_z[corner % RC_BLOCK] == doctest::Approx(109).epsilon(1e-3));
  }
  const std::string message = refusal(folder, std::string(kHead) + kGrey + "[[terrain]]\nraster = \"" + *shared +
                                                  "/data/dem/heidelberg_dem_256_float32.tif\"\nmaterial = \"grey\"\n");
  CHECK_SAYS(message,
             "raster and scene.origin are in different systems (found EPSG:32632 and no origin); write in "
             "[scene]: origin = { epsg = 32632, easting_m = ");
}
