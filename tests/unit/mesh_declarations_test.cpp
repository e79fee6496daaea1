// Units, axes and counts that formats of meshes declare, by one pyramid in each: its box and its four triangles.
#include <array>

#include "scene_compiler/mesh_declared.h"
#include "scene_compiler/mesh_file.h"
#include "tests/unit/scene_files.h"

using namespace raycube;
using namespace raycube::scene;
using namespace raycube::scene::testing;

namespace {

using Point = std::array<double, 3>;
const std::array<Point, 5> kPoints = {{{-8, -6, 0}, {8, -6, 0}, {8, 6, 0}, {-8, 6, 0}, {3, -2, 5}}};
const std::array<std::array<int, 3>, 4> kFaces = {{{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}}};

Point y_up(const Point& p) { return {p[0], p[2], -p[1]}; }

/// Every point by `row`, times `factor`.
template <class Row>
std::string points(double factor, bool turned, Row row) {
  std::string out;
  for (Point p : kPoints) {
    if (turned) p = y_up(p);
    out += row(factor * p[0], factor * p[1], factor * p[2]);
  }
  return out;
}

std::string words(double x, double y, double z) {
  return std::to_string(x) + " " + std::to_string(y) + " " + std::to_string(z);
}

struct Read {
  std::optional<MeshFile> mesh;
  std::string refused, told;
};

class Meshes {
 public:
  Read read(const std::string& name, const std::string& text, const MeshRequest& request = {}) {
    folder_.write(name, text);
    base::Problems problems;
    Read out{read_mesh_file(folder_.at(name), request, {"scene.toml", 1, 0, ""}, problems), "", ""};
    for (const std::string& line : problems.lines()) out.refused += line + "\n";
    for (const std::string& line : problems.notices()) out.told += line + "\n";
    return out;
  }
  /// That the file is the pyramid; what was told of it.
  std::string same(const std::string& name, const std::string& text) {
    const Read read = this->read(name, text);
    REQUIRE_MESSAGE(read.mesh, read.refused);
    CHECK(read.mesh->mesh.triangles.size() == 4);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      float low = 1e9f, high = -1e9f;
      for (const auto& v : read.mesh->mesh.vertices) low = std::min(low, v[axis]), high = std::max(high, v[axis]);
      CHECK_MESSAGE(std::abs(low - std::array{-8.0, -6.0, 0.0}[axis]) < 1e-3, text);
      CHECK_MESSAGE(std::abs(high - std::array{8.0, 6.0, 5.0}[axis]) < 1e-3, text);
    }
    return read.told;
  }

 private:
  Folder folder_;
};

std::string dxf(int unit, double factor) {
  std::string out = "0\nSECTION\n2\nHEADER\n";
  if (unit >= 0) out += "9\n$INSUNITS\n70\n" + std::to_string(unit) + "\n";
  out += "0\nENDSEC\n0\nSECTION\n2\nENTITIES\n";
  for (const auto& face : kFaces) {
    out += "0\n3DFACE\n8\nlayer\n";
    for (int corner = 0; corner < 4; ++corner) {
      const Point& p = kPoints[static_cast<std::size_t>(face[static_cast<std::size_t>(std::min(corner, 2))])];
      for (std::size_t axis = 0; axis < 3; ++axis)
        out += std::to_string(10 * (axis + 1) + static_cast<std::size_t>(corner)) + "\n" +
               std::to_string(factor * p[axis]) + "\n";
    }
  }
  return out + "0\nENDSEC\n0\nEOF\n";
}

std::string x3d(const std::string& head, double factor) {
  std::string index;
  for (const auto& f : kFaces) index += words(f[0], f[1], f[2]) + " -1 ";
  for (std::size_t at; (at = index.find(".000000")) != std::string::npos;) index.erase(at, 7);
  return "<?xml version=\"1.0\"?><X3D version=\"3.3\" profile=\"Interchange\"><head>" + head +
         "</head><Scene><Shape><IndexedFaceSet coordIndex=\"" + index + "\"><Coordinate point=\"" +
         points(factor, true, [](double x, double y, double z) { return words(x, y, z) + " "; }) +
         "\"/></IndexedFaceSet></Shape></Scene></X3D>";
}

std::string amf(const std::string& unit, double factor) {
  std::string out = "<?xml version=\"1.0\"?><amf" + unit + "><object id=\"0\"><mesh><vertices>";
  out += points(factor, false, [](double x, double y, double z) {
    return "<vertex><coordinates><x>" + std::to_string(x) + "</x><y>" + std::to_string(y) + "</y><z>" +
           std::to_string(z) + "</z></coordinates></vertex>";
  });
  out += "</vertices><volume>";
  for (const auto& f : kFaces)
    out += "<triangle><v1>" + std::to_string(f[0]) + "</v1><v2>" + std::to_string(f[1]) + "</v2><v3>" +
           std::to_string(f[2]) + "</v3></triangle>";
  return out + "</volume></mesh></object></amf>";
}

std::string fbx(int sign, double centimetres, double factor) {
  std::string numbers = points(factor, false, [](double x, double y, double z) {
    return std::to_string(x) + "," + std::to_string(y) + "," + std::to_string(z) + ",";
  });
  numbers.pop_back();
  return "; FBX 7.3.0 project file\nFBXHeaderExtension:  {\n\tFBXHeaderVersion: 1003\n\tFBXVersion: "
         "7300\n}\nGlobalSettings:  {\n\tVersion: 1000\n\tProperties70:  {\n\t\tP: \"UpAxis\", \"int\", "
         "\"Integer\", \"\",2\n\t\tP: \"UpAxisSign\", \"int\", \"Integer\", \"\"," +
         std::to_string(sign) + "\n\t\tP: \"UnitScaleFactor\", \"double\", \"Number\", \"\"," +
         std::to_string(centimetres) +
         "\n\t}\n}\nDefinitions:  {\n\tVersion: 100\n\tCount: 0\n}\nObjects:  {\n\tGeometry: 1, \"Geometry::g\", "
         "\"Mesh\" {\n\t\tVertices: *15 {\n\t\t\ta: " +
         numbers +
         "\n\t\t} \n\t\tPolygonVertexIndex: *12 {\n\t\t\ta: 0,1,-5,1,2,-5,2,3,-5,3,0,-5\n\t\t} "
         "\n\t\tGeometryVersion: 124\n\t}\n\tModel: 2, \"Model::m\", \"Mesh\" {\n\t\tVersion: 232\n\t}\n}\n"
         "Connections:  {\n\tC: \"OO\",2,0\n\tC: \"OO\",1,2\n}\n";
}

std::string base64(const std::string& bytes) {
  static const char* const kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t three = 0;
    for (std::size_t k = 0; k < 3; ++k)
      three = three << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k) out += i + k > bytes.size() ? '=' : kDigits[three >> (18 - 6 * k) & 63];
  }
  return out;
}

/// The last corner of the last face is `last`.
std::string gltf(std::uint16_t last, const std::string& primitive = "") {
  std::string bytes;
  for (const Point& p : kPoints)
    for (const double value : y_up(p)) {
      const auto number = static_cast<float>(value);
      bytes.append(reinterpret_cast<const char*>(&number), 4);
    }
  for (const auto& f : kFaces)
    for (std::size_t k = 0; k < 3; ++k) {
      const auto number = &f == &kFaces.back() && k == 2 ? last : static_cast<std::uint16_t>(f[k]);
      bytes.append(reinterpret_cast<const char*>(&number), 2);
    }
  return "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}],"
         "\"meshes\":[{"
         "\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1" +
         primitive +
         "}]}],\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":5,\"type\":\"VEC3\",\"min\":[-8,0,-6],"
         "\"max\":[8,5,6]},{\"bufferView\":1,\"componentType\":5123,\"count\":12,\"type\":\"SCALAR\"}],\"bufferViews\":"
         "[{"
         "\"buffer\":0,\"byteLength\":60},{\"buffer\":0,\"byteOffset\":60,\"byteLength\":24}],\"buffers\":[{"
         "\"byteLength\":84,\"uri\":\"data:application/octet-stream;base64," +
         base64(bytes) + "\"}]}";
}

}  // namespace

TEST_CASE("meshes: units that DXF, X3D, AMF and FBX declare are applied") {
  Meshes meshes;
  CHECK(meshes.same("a.dxf", dxf(-1, 1)) == "");
  CHECK(meshes.same("a.dxf", dxf(0, 1)) == "");
  CHECK(meshes.same("a.dxf", dxf(6, 1)) == "");
  meshes.same("a.dxf", dxf(4, 1000));
  meshes.same("a.dxf", dxf(2, 1 / 0.3048));
  meshes.same("a.dxf", dxf(21, 3937.0 / 1200));
  meshes.same("a.x3d", x3d("", 1));
  meshes.same("a.x3d", x3d("<unit category='angle' name='deg' conversionFactor='0.017'/><unit category='length' "
                           "name='cm' conversionFactor='0.01'/>",
                           100));
  constexpr double kSurveyFoot = 1200.0 / 3937;
  meshes.same("a.dxf", dxf(22, 12 / kSurveyFoot));
  meshes.same("a.dxf", dxf(23, 1 / (3 * kSurveyFoot)));
  meshes.same("a.dxf", dxf(6, 1) + "\x1a\r\n\x1a");  // as DOS ended texts
  for (const int unknown : {25, 2995})
    CHECK_SAYS(meshes.read("a.dxf", dxf(unknown, 1)).refused, "(found $INSUNITS = " + std::to_string(unknown) + ")");
  // Comments hold no unit, and any white space of XML parts attributes.
  const std::string none = "<!-- <unit category='length' conversionFactor='5'/> unit=\"inch\" -->";
  for (const char* space : {" ", "\t", "\n", "\r\n "}) {
    meshes.same("a.x3d", x3d(none + "<unit" + space + "conversionFactor = \"0.01\"" + space + "name='>'" + space +
                                 "category='length'/>",
                             100));
    meshes.same("a.amf", amf(std::string(space) + "version='1.1'" + space + "unit = 'meter'", 1));
  }
  const std::string whole_amf = amf(" unit=\"meter\"", 1);
  meshes.same("a.amf", std::string(whole_amf).insert(whole_amf.find("<amf"), "<!-- <amf unit=\"inch\"> -->"));
  CHECK_SAYS(meshes.read("a.amf", amf(" unit='furlong'", 1)).refused, "not known (found unit = 'furlong'");
  CHECK_SAYS(meshes.read("a.x3d", x3d("<unit category='length' conversionFactor='-1'/>", 1)).refused,
             "not known (found conversionFactor = '-1'");
  // ISO/ASTM 52915, 7.1.
  for (const auto& [unit, metres] :
       {std::pair{"millimeter", 1e-3}, {"inch", 0.0254}, {"feet", 0.3048}, {"meter", 1.0}, {"micron", 1e-6}})
    meshes.same("a.amf", amf(std::string(" unit=\"") + unit + "\"", 1 / metres));
  meshes.same("a.amf", amf("", 1000));
  meshes.same("a.fbx", fbx(1, 100, 1));
  meshes.same("a.fbx", fbx(1, 1, 100));
  meshes.same("a.fbx", fbx(1, 2.54, 1 / 0.0254));
  CHECK_SAYS(meshes.read("a.fbx", fbx(-1, 100, 1)).refused, "points down (found UpAxisSign = -1)");
  CHECK_SAYS(meshes.read("a.dxf", dxf(4, 1000), {.up = {}, .unit_m = 1.0}).told, "the scene's 'unit_m' is not used");
}

TEST_CASE("meshes: faces of a glTF are counted by its kind of primitive") {
  // glTF 2.0, 3.7.2.1: 12 corners are 4 triangles, or a strip or fan of 10; points and lines have no face.
  const std::array<std::size_t, 7> faces = {0, 0, 0, 0, 4, 10, 10};
  for (std::size_t mode = 0; mode < faces.size(); ++mode)
    CHECK(declared_faces(gltf(4, ",\"mode\":" + std::to_string(mode)), ".gltf") == faces[mode]);
}

TEST_CASE("meshes: a long XML is looked through once") {
  // Two million beginnings of elements without an end, which each copied the rest: hours.
  std::string open;
  for (int i = 0; i < 2000000; ++i) open += "<unit ";
  CHECK(!declared_unit_m("<X3D><!--" + open, ".x3d"));
  CHECK(!declared_unit_m("<X3D>" + open, ".x3d"));
}

TEST_CASE("meshes: what a text counts and does not hold is refused or told") {
  Meshes meshes;
  const std::string whole = dxf(6, 1);
  CHECK_SAYS(meshes.read("a.dxf", whole.substr(0, whole.size() - 120)).refused, "a DXF ends before its end");
  const std::string rows = points(1, false, [](double x, double y, double z) { return words(x, y, z) + "\n"; }) +
                           "3 0 1 4\n3 1 2 4\n3 2 3 4\n";
  CHECK(meshes.same("a.off", "OFF # kind\n# a comment\n5 4 0\n\n" + rows + "3 3 0 4\n") == "");
  for (const char* counts : {"5 3 0\n", "5 5 0\n", "4 4 0\n"})
    CHECK_SAYS(meshes.read("a.off", std::string("OFF\n") + counts + rows + "3 3 0 4\n").refused,
               "another number of rows than the file counts (found 9 for");
  for (const char* kind : {"COFF", "STOFF", "4OFF", "NOFF"})
    CHECK_SAYS(meshes.read("a.off", std::string(kind) + "\n5 5 0\n" + rows + "3 3 0 4\n").refused,
               "another number of rows than the file counts (found 9 for 10");
  for (const char* counts : {"-5 14 0", "5e12 4 0", "5.5 3.5 0"})
    CHECK_SAYS(meshes.read("a.off", std::string("OFF\n") + counts + "\n" + rows + "3 3 0 4\n").refused,
               "a count of vertices or faces that is none");
  meshes.same("a.off", "OFF\n5 4 0\n" + rows + "3 3 0 4\n\x1a");
  CHECK(meshes.same("a.gltf", gltf(4)) == "");
  CHECK_SAYS(meshes.read("a.gltf", gltf(9)).told, "of 4 lost by Assimp");
  CHECK_SAYS(meshes.same("a.gltf", gltf(4, ",\"targets\":[{\"POSITION\":0}]")), "morph targets are left out");
  const std::string obj = "v -8 -6 0\nv 8 -6 0\nv 8 6 0\nv -8 6 0\nv 3 -2 5\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n";
  CHECK_SAYS(meshes.same("a.obj", obj + "cstype bezier\ndeg 1 1\nsurf 0 1 0 1 1 2 3 4\nend\n"),
             "1 free-form shape left out");
}
