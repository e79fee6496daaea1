// Bad input of REQUIREMENTS section 4, S1-S4: one test per fault, each asserting place, value and way out.
#include <algorithm>

#include "tests/unit/scene_files.h"

using namespace raycube::scene;
using namespace raycube::scene::testing;

namespace {

std::string material_from(const Folder& folder, const std::string& csv) {
  folder.write("m.csv", csv);
  return refusal(folder, std::string(kHead) + "[[material]]\nname = \"m\"\nfile = \"m.csv\"\n");
}

std::string mesh_from(const Folder& folder, const std::string& name, const std::string& text,
                      const std::string& head = "") {
  folder.write(name, text);
  return refusal(folder, std::string(kHead) + head + kGrey + "[[mesh]]\nname = \"m\"\nfile = \"" + name +
                             "\"\nmaterial = \"grey\"\n[[instance]]\nmesh = \"m\"\n");
}

std::string bands_from(const Folder& folder, const std::string& csv) {
  folder.write("b.csv", csv);
  return refusal(folder,
                 std::string(kHead) +
                     "time = { sun = { zenith_deg = 30 } }\n[[instrument]]\nname = \"i\"\nkind = \"framing\"\npixels = "
                     "2\nlines = 2\nposition_m = [0,0,100]\nifov_mrad = 1\nbands = \"b.csv\"\n");
}

}  // namespace

TEST_CASE("bad input: unknown key, with the nearest one, file:line:column") {
  const Folder folder;
  const std::string message = refusal(folder, "format = 1\ntolerence = 0.1\n");
  CHECK_SAYS(message, "scene.toml:2:1");
  CHECK_SAYS(message, "unknown key at top level (found 'tolerence'); did you mean 'tolerance'?");
  CHECK(line_count(message) == 1);
}

TEST_CASE("bad input: a key without its unit is matched to the one that carries it") {
  const Folder folder;
  CHECK_SAYS(refusal(folder, "format = 1\n[[instrument]]\nname = \"a\"\naltitude = 3\n"),
             "scene.toml:4:1: unknown key in [instrument] (found 'altitude'); did you mean 'altitude_agl_m'?");
}

TEST_CASE("bad input: every problem of one file is reported in one run") {
  const Folder folder;
  const std::string message =
      refusal(folder,
              "format = 1\ntolerance = 7\nseed = \"x\"\n[[material]]\nname = \"a\"\nreflectance = "
              "1.5\n[[plane]]\nmaterial = \"b\"\nsize_m = [1, 1]\n");
  CHECK_SAYS(message, "scene.toml:2:13: 'tolerance' is out of range (found 7); give a number > 0 and <= 1");
  CHECK_SAYS(message, "scene.toml:3:8: 'seed' wants an integer (found text \"x\")");
  CHECK_SAYS(message, "scene.toml:6:15: 'reflectance' is out of range (found 1.5); give a number 0 .. 1");
  CHECK_SAYS(message, "scene.toml:8:1: unknown material (found 'b')");
  CHECK(line_count(message) == 4);
}

TEST_CASE("bad input: NaN and infinity in the simulation file") {
  const Folder folder;
  CHECK_SAYS(refusal(folder, "format = 1\ntolerance = nan\n"),
             "scene.toml:2:13: 'tolerance' is not a finite number (found nan)");
  CHECK_SAYS(
      refusal(folder, std::string("format = 1\n") + kGrey + "[[plane]]\nmaterial = \"grey\"\nsize_m = [1.0, inf]\n"),
      "scene.toml:7:16: 'size_m' is not a finite number (found inf)");
}

TEST_CASE("bad input: wrong types and lengths") {
  const Folder folder;
  CHECK_SAYS(refusal(folder, "format = 1\nscene = 3\n"), "scene.toml:2:1: 'scene' wants a table (found integer 3)");
  CHECK_SAYS(refusal(folder, "format = 1\n[material]\nname = \"a\"\n"),
             "'material' wants an array of tables (found a table); write [[material]]");
  CHECK_SAYS(
      refusal(folder, std::string("format = 1\n") + kGrey + "[[plane]]\nmaterial = \"grey\"\nsize_m = [1, 2, 3]\n"),
      "'size_m' has the wrong length (found 3 values); give 2 values");
  CHECK_SAYS(refusal(folder, "format = 1\n[[instrument]]\nname = \"a\"\nkind = \"lidar2\"\n"),
             "'kind' wants one of framing, whiskbroom, pushbroom (found text \"lidar2\")");
}

TEST_CASE("bad input: missing required key") {
  const Folder folder;
  CHECK_SAYS(refusal(folder, "format = 1\n[[material]]\nreflectance = 0.5\n"),
             "scene.toml:2:1: 'name' is missing in [material]");
}

TEST_CASE("bad input: format is missing, late, or of another version") {
  const Folder folder;
  CHECK_SAYS(refusal(folder, "tolerance = 0.01\n"),
             "scene.toml:1:1: format is missing; begin the file with format = 1");
  CHECK_SAYS(refusal(folder, "tolerance = 0.01\nformat = 1\n"),
             "format is not the first key (found 'tolerance' before it)");
  CHECK_SAYS(refusal(folder, "format = 2\n"), "scene.toml:1:10: 'format' is out of range (found 2); give a number 1");
}

TEST_CASE("bad input: TOML syntax") {
  const Folder folder;
  CHECK_SAYS(refusal(folder, "format = 1\nseed = = 3\n"), "scene.toml:2:8: TOML syntax");
}

TEST_CASE("bad input: missing simulation file, 0-byte file") {
  const Folder folder;
  CHECK_THROWS_WITH_AS(load_simulation("/nonexistent/x.toml"),
                       doctest::Contains("/nonexistent/x.toml: cannot read simulation file"), raycube::base::Error);
  CHECK_SAYS(refusal(folder, ""), "scene.toml:1:1: file is empty (found 0 bytes)");
}

TEST_CASE("bad input: cyclic include") {
  const Folder folder;
  folder.write("a.toml", "format = 1\n[scene]\ninclude = [\"b.toml\"]\n");
  folder.write("b.toml", "format = 1\n[scene]\ninclude = [\"a.toml\"]\n");
  const std::string message = refusal(folder, "format = 1\n[scene]\ninclude = [\"a.toml\"]\n");
  CHECK_SAYS(message, "b.toml:3:12: include runs in a circle (found a.toml -> b.toml -> a.toml)");
}

TEST_CASE("bad input: missing include, file included twice, key given twice") {
  const Folder folder;
  CHECK_SAYS(refusal(folder, "format = 1\n[scene]\ninclude = [\"no.toml\"]\n"),
             "scene.toml:3:12: cannot read simulation file");
  folder.write("a.toml", "format = 1\ntolerance = 0.1\n");
  CHECK_SAYS(refusal(folder, "format = 1\n[scene]\ninclude = [\"a.toml\", \"a.toml\"]\n"),
             "scene.toml:3:22: file is included twice");
  CHECK_SAYS(refusal(folder, "format = 1\ntolerance = 0.2\n[scene]\ninclude = [\"a.toml\"]\n"),
             "a.toml:2:1: 'tolerance' is given twice (found first in scene.toml:2:1)");
}

TEST_CASE("bad input: spectrum file missing or 0 bytes") {
  const Folder folder;
  CHECK_SAYS(refusal(folder, "format = 1\n[[material]]\nname = \"m\"\nfile = \"no.csv\"\n"),
             "scene.toml:4:1: cannot read file (found no.csv)");
  CHECK_SAYS(material_from(folder, ""), "m.csv: file is empty (found 0 bytes)");
  CHECK_SAYS(material_from(folder, "wavelength_nm,reflectance\n"), "m.csv: file has no rows");
}

TEST_CASE("bad input: text, asterisks and nothing in a spectrum, told once; NaN is no data") {
  const Folder folder;
  const std::string message =
      material_from(folder, "wavelength_nm,reflectance\n400,nan\n500,******\n600,\n700,1e-3x\n800,0.5\n");
  CHECK_SAYS(message,
             "m.csv:3: column 'reflectance': not a number (found '******', and in 2 more cells); give a number like "
             "0.25, nan where there is none");
  CHECK(line_count(message) == 1);
  CHECK_SAYS(material_from(folder, "wavelength_nm,reflectance\nnan,0.1\n500,0.2\n600,0.3\n"),
             "m.csv:2: column 'wavelength_nm': not a number (found 'nan')");
  CHECK_SAYS(material_from(folder, "wavelength_nm,reflectance\n400,nan\n500,0.2\n600,-1.23e34\n"),
             "m.csv: a spectrum needs at least two points (found 1)");
}

TEST_CASE("bad input: unsorted and duplicate wavelengths") {
  const Folder folder;
  const std::string message =
      material_from(folder, "# source: x\nwavelength_um,reflectance\n0.5,0.1\n0.4,0.1\n0.6,0.1\n0.6,0.2\n");
  CHECK_SAYS(message, "m.csv:4: wavelengths are not ascending (found 0.4 um after 0.5 um)");
  CHECK_SAYS(message, "m.csv:6: wavelength is given twice (found 0.6 um)");
}

TEST_CASE("bad input: wavelengths in the wrong unit") {
  const Folder folder;
  CHECK_SAYS(material_from(folder, "wavelength_um,reflectance\n4000,0.1\n5000,0.1\n"),
             "m.csv:2: wavelength outside 0.05 .. 1000 um (found 4000 um, and at 1 more point); check the unit");
  CHECK_SAYS(material_from(folder, "wavelength_nm,reflectance\n0.4,0.1\n0.5,0.1\n"), "m.csv:2: wavelength outside");
}

TEST_CASE("bad input: reflectance outside 0 .. 1 and reflectance + transmittance above 1") {
  const Folder folder;
  const std::string message = material_from(
      folder, "wavelength_um,reflectance,transmittance\n0.4,-0.1,0\n0.5,1.01,0\n0.6,0.7,0.4\n0.7,0.5,0.5\n");
  CHECK_SAYS(message, "m.csv:2: reflectance outside 0 .. 1 (found -0.1, and at 1 more point)");
  CHECK_SAYS(message, "m.csv:4: reflectance + transmittance above 1 (found 0.7 + 0.4)");
  CHECK(line_count(message) == 2);
}

TEST_CASE("bad input: spectrum columns") {
  const Folder folder;
  CHECK_SAYS(material_from(folder, "lambda,reflectance\n0.4,0.1\n"),
             "m.csv:1: no wavelength column (found lambda,reflectance)");
  CHECK_SAYS(material_from(folder, "wavelength_um,r\n0.4,0.1\n"), "m.csv:1: no column 'reflectance'");
  CHECK_SAYS(material_from(folder, "wavelength_um,reflectance\n0.4,0.1\n0.5\n"), "m.csv:3: row has 1 cell");
}

TEST_CASE("bad input: a flood of bad points is one line with a count, and says what scale it looks like") {
  const Folder folder;
  std::string csv = "wavelength_um,reflectance\n";
  for (int i = 0; i < 500; ++i) csv += std::to_string(0.4 + 0.001 * i) + ",2\n";
  const std::string message = material_from(folder, csv);
  CHECK(line_count(message) == 1);
  CHECK_SAYS(message, "(found 2, and at 499 more points)");
  const auto scaled = [&](const std::string& value) {
    return material_from(folder, "wavelength_um,reflectance\n0.4,0.1\n0.5," + value + "\n");
  };
  CHECK_SAYS(scaled("45"), "give scale = 0.01 if the file is in percent");
  CHECK_SAYS(scaled("4500"), "give scale = 1e-4 if its values are 10 000 times reflectance");
  CHECK_SAYS(scaled("1.1"), "correct it, or give `scale`");
}

TEST_CASE("bad input: a raw raster that ends before its header says") {
  const Folder folder;
  folder.write("dem.img.hdr",
               "ENVI\nsamples = 20\nlines = 20\nbands = 1\nheader offset = 0\nfile type = ENVI Standard\n"
               "data type = 4\ninterleave = bsq\nbyte order = 0\n");
  const std::string field = "[[terrain]]\nraster = \"dem.img\"\ncell_m = 1.0\nmaterial = \"grey\"\n";
  for (const std::size_t bytes : {50u, 1200u, 1599u}) {
    folder.write("dem.img", std::string(bytes, '\0'));
    CHECK_SAYS(refusal(folder, std::string(kHead) + kGrey + field),
               "ends after " + std::to_string(bytes) + " of 1600 bytes");
  }
  folder.write("dem.img", std::string(1600, '\0'));
  CHECK(refusal(folder, std::string(kHead) + kGrey + field).empty());
}

TEST_CASE("bad input: a plane and a box of a material that is not there, in a file without any") {
  const Folder folder;
  CHECK_SAYS(refusal(folder, "format = 1\n[[plane]]\nmaterial = \"lawn\"\nsize_m = [1, 1]\n"),
             "unknown material (found 'lawn'); define it with [[material]]");
  CHECK_SAYS(refusal(folder, "format = 1\n[[box]]\nmaterial = \"lawn\"\nsize_m = [1, 1, 1]\n"),
             "unknown material (found 'lawn'); define it with [[material]]");
}

TEST_CASE("bad input: material with neither or both sources, defined twice") {
  const Folder folder;
  CHECK_SAYS(refusal(folder, "format = 1\n[[material]]\nname = \"m\"\n"),
             "scene.toml:2:1: material 'm' needs exactly one of file, family, reflectance and leaf (found none)");
  CHECK_SAYS(refusal(folder, std::string(kHead) + kGrey + kGrey),
             "scene.toml:5:1: material 'grey' is defined twice (found first in scene.toml:2:1)");
}

TEST_CASE("bad input: band list with a width of 0, NaN, a wrong unit") {
  const Folder folder;
  const std::string message = bands_from(folder, "center_nm,fwhm_nm\n500,10\n600,0\n700,-3\n800,nan\n0.9,10\n");
  CHECK_SAYS(message, "b.csv:3: column 'fwhm_nm': band width must be above 0 (found 0)");
  CHECK_SAYS(message, "b.csv:4: column 'fwhm_nm': band width must be above 0 (found -3)");
  CHECK_SAYS(message, "b.csv:5: column 'fwhm_nm': not a finite number (found 'nan')");
  CHECK_SAYS(message, "b.csv:6: column 'center_nm': wavelength outside 0.05 .. 1000 um");
  CHECK(line_count(message) == 4);
}

TEST_CASE("bad input: tabulated response negative, unsorted, empty") {
  const Folder folder;
  CHECK_SAYS(bands_from(folder, "wavelength_nm,red\n600,0\n610,-1\n620,0\n"),
             "b.csv:3: column 'red': response of band 'red' is negative (found -1)");
  CHECK_SAYS(bands_from(folder, "wavelength_nm,red\n600,0\n590,1\n620,0\n"),
             "b.csv:3: column 'red': wavelengths of band 'red' are not ascending");
  CHECK_SAYS(bands_from(folder, "wavelength_nm,red\n600,0\n610,0\n"), "band 'red' has no response");
}

TEST_CASE("bad input S1: OBJ vertex not finite or not a number, by line") {
  const Folder folder;
  CHECK_SAYS(mesh_from(folder, "m.obj", "v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n"),
             "m.obj:2: vertex is not finite (found nan)");
  CHECK_SAYS(mesh_from(folder, "m.obj", "v 0 0 0\nv 1 0 0\nv 0 inf 0\nf 1 2 3\n"),
             "m.obj:3: vertex is not finite (found inf)");
  CHECK_SAYS(mesh_from(folder, "m.obj", "v 0 0 0\nv 3.1+e2 0 0\nv 0 1 0\nf 1 2 3\n"),
             "m.obj:2: vertex coordinate is not a number (found '3.1+e2')");
}

TEST_CASE("bad input S1: OBJ face out of range, by line") {
  const Folder folder;
  CHECK_SAYS(mesh_from(folder, "m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 4\n"),
             "m.obj:5: face index out of range (found '4' with 3 vertices)");
  CHECK_SAYS(mesh_from(folder, "m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n"),
             "m.obj:4: face index out of range (found '0' with 3 vertices)");
  CHECK_SAYS(mesh_from(folder, "m.obj", "v 0 0 0\nv 1 0 0\nf -1 -2 -3\nv 0 1 0\n"),
             "m.obj:3: face index out of range (found '-3' after 2 vertices)");
}

TEST_CASE("bad input S1: PLY vertex not finite, by vertex number") {
  const Folder folder;
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float "
      "z\nelement face 1\nproperty list uchar int vertex_index\nend_header\n";
  const std::string message = mesh_from(folder, "m.ply", head + "0 0 0\n1 nan 0\n0 1 0\n3 0 1 2\n");
  CHECK_SAYS(message, "m.ply: vertex 1: vertex is not finite");
}

TEST_CASE("bad input S1: PLY face out of range") {
  const Folder folder;
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float "
      "z\nelement face 1\nproperty list uchar int vertex_index\nend_header\n";
  const std::string message = mesh_from(folder, "m.ply", head + "0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n");
  CHECK_SAYS(message, "m.ply: face 0: face index out of range (found 7 of 3 vertices)");
}

TEST_CASE("bad input S1: zero-area faces are dropped with a count, refused when strict") {
  const Folder folder;
  const std::string obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 2 0 0\nf 1 2 3\nf 1 2 4\nf 1 1 3\n";
  const std::string message = mesh_from(folder, "m.obj", obj, "scene.strict = true\n");
  CHECK_SAYS(message, "m.obj: face 1: face has no area");
  CHECK_SAYS(message, "m.obj: face 2: face has no area");
  CHECK(mesh_from(folder, "m.obj", obj) == "");
  const auto simulation =
      load(folder, std::string(kHead) + kGrey +
                       "[[mesh]]\nname = \"m\"\nfile = \"m.obj\"\nmaterial = \"grey\"\n[[instance]]\nmesh = \"m\"\n");
  CHECK(simulation.scene.meshes.at(0).triangle_count() == 1);
  REQUIRE(simulation.notices.size() == 1);
  CHECK_SAYS(simulation.notices[0], "dropped 2 of 3 faces without area (first: face 1)");
}

TEST_CASE("bad input S1: mesh file missing, empty, of points, not a mesh") {
  const Folder folder;
  CHECK_SAYS(
      refusal(folder, std::string(kHead) + kGrey + "[[mesh]]\nname = \"m\"\nfile = \"no.obj\"\nmaterial = \"grey\"\n"),
      "scene.toml:7:1: cannot read file (found no.obj)");
  CHECK_SAYS(mesh_from(folder, "m.obj", ""), "m.obj: file is empty (found 0 bytes)");
  CHECK_SAYS(mesh_from(folder, "m.ply",
                       "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float "
                       "y\nproperty float z\nend_header\n0 0 0\n"),
             "m.ply");
  CHECK_SAYS(mesh_from(folder, "m.bin", "this is no mesh"), "m.bin: Assimp cannot read the mesh");
}

TEST_CASE("bad input S1: faces without material, and a map that names nothing in the file") {
  const Folder folder;
  folder.write("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl leaf\nf 1 2 3\nusemtl bark\nf 3 2 1\n");
  const std::string message =
      refusal(folder, std::string(kHead) + kGrey +
                          "[[mesh]]\nname = \"m\"\nfile = \"m.obj\"\nmaterials = { leaf = \"grey\", twig = "
                          "\"grey\" }\n[[instance]]\nmesh = \"m\"\n");
  CHECK_SAYS(message, "have no material (found 'bark')");
  CHECK_SAYS(message, "mesh file has no material, group or node of that name (found 'twig'); m.obj has: bark, ");
}

TEST_CASE("bad input S3: instance of an unknown mesh, singular matrix, not affine") {
  const Folder folder;
  CHECK_SAYS(refusal(folder, "format = 1\n[[instance]]\nmesh = \"tree\"\n"),
             "scene.toml:3:1: unknown mesh (found 'tree')");
  folder.write("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const std::string head =
      std::string(kHead) + kGrey +
      "[[mesh]]\nname = \"m\"\nfile = \"m.obj\"\nmaterial = \"grey\"\n[[instance]]\nmesh = \"m\"\n";
  CHECK_SAYS(refusal(folder, head + "matrix = [1,0,0,0, 0,1,0,0, 0,0,0,0]\n"),
             "scene.toml:11:1: matrix cannot be inverted (found determinant 0)");
  CHECK_SAYS(refusal(folder, head + "matrix = [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,2]\n"),
             "last row of the matrix is not 0, 0, 0, 1 (found 0, 0, 0, 2)");
}

TEST_CASE("bad input: scatter CSV with NaN, scale 0, unknown column, by line") {
  const Folder folder;
  folder.write("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const std::string head = std::string(kHead) + kGrey +
                           "[[mesh]]\nname = \"m\"\nfile = \"m.obj\"\nmaterial = \"grey\"\n[[scatter]]\nmesh "
                           "= \"m\"\npositions = \"p.csv\"\n";
  folder.write("p.csv", "x_m,y_m,scale\n0,nan,1\n1,1,0\n");
  const std::string message = refusal(folder, head);
  CHECK_SAYS(message, "p.csv:2: column 'y_m': not a finite number (found 'nan')");
  CHECK_SAYS(message, "p.csv:3: column 'scale': scale must be above 0 (found 0)");
  folder.write("p.csv", "x_m,y_m,yaw\n0,0,1\n");
  CHECK_SAYS(refusal(folder, head), "p.csv:1: unknown column (found 'yaw')");
}

TEST_CASE("bad input: instrument with no or two positions, no scale, a bad name") {
  const Folder folder;
  const std::string head =
      "format = 1\ntime = { sun = { zenith_deg = 30 } }\n[[instrument]]\nkind = \"framing\"\npixels = "
      "2\nlines = 2\nbands = { first_nm = 400, step_nm = 10, count = 3, fwhm_nm = 10 }\n";
  const std::string message = refusal(folder, head + "name = \"a/b\"\n");
  CHECK_SAYS(message, "an instrument's name is a folder's (found 'a/b')");
  CHECK_SAYS(message, "scene.toml:3:1: instrument needs exactly one of altitude_agl_m, position_m, poses (found 0)");
  CHECK_SAYS(refusal(folder, head + "name = \"a\"\naltitude_agl_m = 10\n"),
             "instrument needs exactly one of gsd_m, ifov_mrad, focal_length_mm with pitch_um (found 0)");
  CHECK_SAYS(refusal(folder, head + "name = \"a\"\naltitude_agl_m = 10\nfocal_length_mm = 3\n"),
             "focal_length_mm and pitch_um go together (found focal_length_mm alone)");
}

TEST_CASE("bad input: pose file with too few rows and a bad cell") {
  const Folder folder;
  const std::string text =
      "format = 1\ntime = { sun = { zenith_deg = 30 } }\n[[instrument]]\nname = \"a\"\nkind = "
      "\"pushbroom\"\npixels = 2\nlines = 3\nifov_mrad = 1\nposes = \"p.csv\"\nbands = { first_nm = 400, "
      "step_nm = 10, count = 3, fwhm_nm = 10 }\n";
  folder.write("p.csv", "x_m,y_m,z_m\n0,0,100\n0,1,100\n");
  CHECK_SAYS(refusal(folder, text),
             "scene.toml:9:1: number of poses does not fit the image (found 2 poses, 3 lines of 2 pixels)");
  folder.write("p.csv", "x_m,y_m,z_m\n0,0,100\n0,--,100\n0,2,100\n");
  CHECK_SAYS(refusal(folder, text), "p.csv:3: column 'y_m': not a finite number (found '--')");
}

TEST_CASE("bad input: time missing, double, malformed, without a place") {
  const Folder folder;
  const std::string instrument =
      "[[instrument]]\nname = \"a\"\nkind = \"framing\"\npixels = 2\nlines = 2\nifov_mrad = 1\nposition_m = "
      "[0,0,9]\nbands = { first_nm = 400, step_nm = 10, count = 3, fwhm_nm = 10 }\n";
  CHECK_SAYS(refusal(folder, kHead + instrument), "[time] is missing");
  CHECK_SAYS(refusal(folder, std::string(kHead) +
                                 "time = { utc = \"2012-09-20T15:30:00Z\", sun = { zenith_deg = 3 } }\n" + instrument),
             "scene.toml:2:8: [time] needs exactly one of utc, sun and moon (found more than one)");
  CHECK_SAYS(refusal(folder, std::string(kHead) + "time = { utc = \"2012-09-20T15:30:00Z\" }\n" + instrument),
             "the sun at a time needs a place on earth");
  CHECK_SAYS(refusal(folder, std::string(kHead) +
                                 "time = { utc = \"yesterday\" }\nscene = { origin = { latitude_deg = 0, "
                                 "longitude_deg = 0 } }\n" +
                                 instrument),
             "scene.toml:2:10: time utc = \"yesterday\" is no date");
}

TEST_CASE("bad input: EPSG code that is no projected system") {
  const Folder folder;
  CHECK_SAYS(refusal(folder, "format = 1\nscene = { origin = { epsg = 4326, easting_m = 1, northing_m = 2 } }\n"),
             "scene.toml:2:22: not a projected system in metres in which the origin lies (found EPSG:4326");
}

TEST_CASE("bad input: objects so far from the origin that single precision loses them, by their own size") {
  const Folder folder;
  const auto box_at = [](const std::string& place, double size) {
    return std::string(kHead) + kGrey +
           "[[plane]]\nmaterial = \"grey\"\nsize_m = [40, 40]\n[[box]]\nname = \"hut\"\nmaterial = "
           "\"grey\"\nposition_m = " +
           place + "\nsize_m = [" + std::to_string(size) + ", 1.0, 1.0]\n";
  };
  // A float's spacing: 1 m above 2^23 = 8.4e6, 1/128 m above 65536, 1/1024 m above 8192.
  for (const char* place : {"[1e7, 0, 0]", "[0, -1e7, 0]"}) {
    const std::string message = refusal(folder, box_at(place, 2));
    CHECK_SAYS(message, "single precision does not resolve 'hut' so far from the scene's origin");
    CHECK_SAYS(message, "coordinates are 1 m apart");
    CHECK_SAYS(message, "scene.origin");
    CHECK(line_count(message) == 1);
  }
  const auto notices = [&](const std::string& place, double size) { return load(folder, box_at(place, size)).notices; };
  REQUIRE(notices("[1e5, 0, 0]", 2).size() == 1);
  CHECK_SAYS(notices("[1e5, 0, 0]", 2).front(), "1 object or terrain lies so far");
  CHECK_SAYS(notices("[1e5, 0, 0]", 2).front(), "worst 'hut': 2 m at 100000, 0, ");
  CHECK(notices("[1e5, 0, 0]", 40).empty());
  CHECK(notices("[8e3, 0, 0]", 2).empty());
  // A mesh in map coordinates that its placement moves back has lost its digits where it is read in single precision.
  std::string map = "solid shed\nfacet normal 0 0 1\nouter loop\n", obj;
  for (const char* corner : {"276000 4753000 0", "276002 4753000 0", "276002 4753002 1"})
    map += std::string("vertex ") + corner + "\n", obj += std::string("v ") + corner + "\n";
  folder.write("map.stl", map + "endloop\nendfacet\nendsolid shed\n");
  folder.write("map.obj", obj + "f 1 2 3\n");
  const auto shed = [&](const std::string& file) {
    return std::string(kHead) + kGrey + "[[mesh]]\nname = \"shed\"\nfile = \"" + file +
           "\"\nmaterial = \"grey\"\n[[instance]]\nmesh = \"shed\"\nposition_m = [-276000, -4753000, 0]\n";
  };
  const std::string lost = refusal(folder, shed("map.stl"));
  CHECK(load(folder, shed("map.obj")).notices.empty());  // counted from its middle
  CHECK_SAYS(lost, "single precision does not resolve 'shed'");
  CHECK_SAYS(lost, "0.5 m apart in its own file");
  // What single precision makes a point of is no smaller thing that it resolves.
  for (const char* size : {"0.6", "0.2"})
    CHECK_SAYS(refusal(folder, std::string(kHead) + kGrey +
                                   "[[plane]]\nname = \"plate\"\nmaterial = \"grey\"\nposition_m = [5e6, 5e6, "
                                   "0]\nsize_m = [" +
                                   size + ", " + size + "]\n"),
               "single precision does not resolve");
  // Terrain is as coarse as its cells, not as it is wide.
  folder.write("dem.asc", "ncols 3\nnrows 3\nxllcorner 90000\nyllcorner 0\ncellsize 0.0625\n1 1 1\n1 1 1\n1 1 1\n");
  CHECK_SAYS(refusal(folder, std::string(kHead) + kGrey +
                                 "[[terrain]]\nname = \"field\"\nraster = \"dem.asc\"\nmaterial = \"grey\"\n"),
             "cells of 0.0625 m");
}
