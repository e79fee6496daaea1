#include "scene_compiler/mesh_declared.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>
#include <sstream>
#include <string_view>
#include <utility>

#include <nlohmann/json.hpp>

#include "host/base/gdal_library.h"
#include "host/base/json_text.h"
#include "host/base/text.h"
#include "scene_compiler/csv_file.h"
#include "scene_compiler/document_values.h"
#include "scene_compiler/mesh_file.h"

namespace raycube::scene {
namespace {

using base::Problems;

/// The JSON of a glTF: its text, or the first chunk of the binary form.
std::string gltf_json(const std::string& text) {
  if (!text.starts_with("glTF")) return text;
  constexpr std::size_t kHead = 20;  // magic, version, length; the chunk's length and type (glTF 2.0, 4.4)
  std::uint32_t bytes = 0;
  if (text.size() < kHead) return "";
  std::memcpy(&bytes, text.data() + 12, sizeof bytes);
  return text.substr(kHead, bytes);
}

nlohmann::json parsed_gltf(const std::string& text) {
  return nlohmann::json::parse(base::shallow_json(gltf_json(text)), nullptr, false);
}

/// The list at a key; an empty one where there is none.
nlohmann::json list_of(const nlohmann::json& json, const char* key) {
  return json.is_object() && json.contains(key) && json[key].is_array() ? json[key] : nlohmann::json::array();
}

/// The whole number at a key.
std::optional<std::size_t> index_of(const nlohmann::json& json, const char* key) {
  if (!json.is_object() || !json.contains(key) || !json[key].is_number_unsigned()) return std::nullopt;
  return json[key].get<std::size_t>();
}

/// Extensions that a glTF needs or uses and that would change its surfaces. What materials, lights and pictures gain by
/// others is none of a mesh's business here.
void check_extensions(const std::string& text, const std::string& file, Problems& problems) {
  const nlohmann::json json = parsed_gltf(text);
  if (!json.is_object()) return;  // Assimp says what is wrong
  const auto harmless = [](const std::string& name) {
    for (const char* part : {"_materials_", "_texture_", "_lights_", "_xmp", "_audio"})
      if (name.find(part) != std::string::npos) return true;
    return name.starts_with("MSFT_texture");
  };
  const auto listed = [&](const char* key) {
    std::vector<std::string> out;
    if (json.contains(key) && json[key].is_array())
      for (const auto& name : json[key])
        if (name.is_string() && !harmless(name.get<std::string>())) out.push_back(name.get<std::string>());
    return out;
  };
  const std::vector<std::string> required = listed("extensionsRequired");
  for (const std::string& name : required)
    problems.add({file, 0, 0, "extensionsRequired"}, "the file needs an extension that is not understood",
                 "'" + name + "'", "write it without, for instance by gltf-transform or Blender");
  if (required.empty())
    for (const std::string& name : listed("extensionsUsed"))
      problems.tell({file, 0, 0, "extensionsUsed"},
                    "the extension '" + name + "' is not read; its geometry is left out");
  for (const auto& mesh : list_of(json, "meshes"))
    for (const auto& primitive : list_of(mesh, "primitives"))
      if (!list_of(primitive, "targets").empty()) {
        problems.tell({file, 0, 0, "meshes"}, "morph targets are left out; the mesh has its first shape");
        return;
      }
}

/// Faces of a primitive by its mode (glTF 2.0, 3.7.2.1).
std::size_t faces_of(const nlohmann::json& primitive, const nlohmann::json& accessors) {
  const auto counted_by = index_of(primitive, "indices").has_value()
                              ? index_of(primitive, "indices")
                              : index_of(primitive.value("attributes", nlohmann::json::object()), "POSITION");
  if (!counted_by || *counted_by >= accessors.size()) return 0;
  const std::size_t corners = index_of(accessors[*counted_by], "count").value_or(0);
  const std::size_t mode = index_of(primitive, "mode").value_or(4);
  if (mode == 4) return corners / 3;
  return (mode == 5 || mode == 6) && corners > 2 ? corners - 2 : 0;
}

/// Faces of what hangs from the default scene's nodes.
std::size_t gltf_faces(const nlohmann::json& json) {
  constexpr std::size_t kMostNodes = 100000;
  const auto scenes = list_of(json, "scenes"), nodes = list_of(json, "nodes"), meshes = list_of(json, "meshes"),
             accessors = list_of(json, "accessors");
  const std::size_t scene = index_of(json, "scene").value_or(0);
  if (scene >= scenes.size()) return 0;
  std::vector<std::size_t> of_mesh;
  for (const auto& mesh : meshes) {
    std::size_t faces = 0;
    for (const auto& primitive : list_of(mesh, "primitives"))
      if (primitive.is_object()) faces += faces_of(primitive, accessors);
    of_mesh.push_back(faces);
  }
  std::vector<std::size_t> open;
  const auto add = [&](const nlohmann::json& list) {
    for (const auto& node : list)
      if (node.is_number_unsigned()) open.push_back(node.get<std::size_t>());
  };
  add(list_of(scenes[scene], "nodes"));
  std::size_t faces = 0;
  for (std::size_t done = 0; done < open.size() && done < kMostNodes; ++done) {
    if (open[done] >= nodes.size()) continue;
    const auto& node = nodes[open[done]];
    if (const auto mesh = index_of(node, "mesh"); mesh && *mesh < of_mesh.size()) faces += of_mesh[*mesh];
    add(list_of(node, "children"));
  }
  return faces;
}

/// A DXF's unit (DXF reference, HEADER, $INSUNITS).
DeclaredUnit dxf_unit(const std::string& text) {
  constexpr double kSurveyFoot = 1200.0 / 3937;
  // inches, feet, miles, mm, cm, m, km, microinches, mils, yards, angstroms, nm, um, dm, dam, hm, Gm, AU, light years,
  // parsecs, and of US surveys feet, inches, yards, miles
  static constexpr double kMetres[] = {0.0254,
                                       0.3048,
                                       1609.344,
                                       1e-3,
                                       1e-2,
                                       1,
                                       1e3,
                                       2.54e-8,
                                       2.54e-5,
                                       0.9144,
                                       1e-10,
                                       1e-9,
                                       1e-6,
                                       0.1,
                                       10,
                                       100,
                                       1e9,
                                       149597870700.0,
                                       9.4607304725808e15,
                                       3.0856775814913673e16,
                                       kSurveyFoot,
                                       kSurveyFoot / 12,
                                       3 * kSurveyFoot,
                                       5280 * kSurveyFoot};
  const auto at = text.find("$INSUNITS");
  if (at == std::string::npos) return {};
  std::istringstream in(text.substr(at, 200));
  std::string name, code, unit;
  in >> name >> code >> unit;
  const auto number = parse_number(unit);
  if (code == "70" && number && *number == 0) return {};
  for (std::size_t i = 0; code == "70" && number && i < std::size(kMetres); ++i)
    if (*number == static_cast<double>(i + 1)) return {kMetres[i], ""};
  return {{}, "$INSUNITS = " + unit.substr(0, 20)};
}

constexpr const char* kXmlSpace = " \t\r\n";

/// Calls `visit` with the name and the attributes of each element of an XML in turn, until it returns true; comments
/// and what is no element are passed over. Every character is looked at once.
template <class Visit>
void visit_elements(std::string_view text, Visit visit) {
  static constexpr std::pair<std::string_view, std::string_view> kOther[] = {
      {"<!--", "-->"}, {"<![CDATA[", "]]>"}, {"<?", "?>"}, {"</", ">"}, {"<!", ">"}};
  std::size_t at = text.find('<');
  while (at != std::string_view::npos) {
    const std::string_view rest = text.substr(at);
    const auto other = std::find_if(std::begin(kOther), std::end(kOther),
                                    [&](const auto& kind) { return rest.starts_with(kind.first); });
    if (other != std::end(kOther)) {
      at = text.find(other->second, at + other->first.size());
      if (at != std::string_view::npos) at = text.find('<', at + other->second.size());
      continue;
    }
    std::size_t end = at;
    for (char quote = '\0'; end < text.size() && (quote != '\0' || text[end] != '>'); ++end)
      if (quote != '\0')
        quote = text[end] == quote ? '\0' : quote;
      else if (text[end] == '"' || text[end] == '\'')
        quote = text[end];
    if (end == text.size()) return;
    std::string_view head = text.substr(at + 1, end - at - 1);
    const std::size_t after = std::min(head.find_first_of(std::string(kXmlSpace) + "/"), head.size());
    std::string_view name = head.substr(0, after);
    if (const std::size_t prefix = name.find(':'); prefix != std::string_view::npos) name.remove_prefix(prefix + 1);
    if (visit(name, head.substr(after))) return;
    at = text.find('<', end);
  }
}

/// The value of an attribute; empty: there is none.
std::string attribute(std::string_view attributes, std::string_view wanted) {
  std::size_t at = 0;
  while ((at = attributes.find_first_not_of(kXmlSpace, at)) != std::string_view::npos) {
    const std::size_t equals = attributes.find('=', at);
    const std::size_t open = equals == std::string_view::npos ? equals : attributes.find_first_of("\"'", equals);
    const std::size_t close = open == std::string_view::npos ? open : attributes.find(attributes[open], open + 1);
    if (close == std::string_view::npos) return "";
    if (trimmed(std::string(attributes.substr(at, equals - at))) == wanted)
      return trimmed(std::string(attributes.substr(open + 1, close - open - 1)));
    at = close + 1;
  }
  return "";
}

/// The unit of lengths of an X3D (ISO/IEC 19775-1, 7.2.5 UNIT), which stands before its scene.
DeclaredUnit x3d_unit(const std::string& text) {
  DeclaredUnit out;
  visit_elements(text, [&](std::string_view name, std::string_view attributes) {
    if (name != "unit" || lower_case(attribute(attributes, "category")) != "length") return name == "Scene";
    const std::string factor = attribute(attributes, "conversionFactor");
    const auto number = parse_number(factor);
    if (number && *number > 0 && std::isfinite(*number))
      out.metres = number;
    else
      out.wrong = "conversionFactor = '" + factor.substr(0, 40) + "'";
    return true;
  });
  return out;
}

/// Of AMF (ISO/ASTM 52915) and of a 3MF's model (3MF Core Specification, 3.4): millimetres where it says nothing.
DeclaredUnit additive_unit(const std::string& text, std::string_view element) {
  static const std::map<std::string, double> kMetres = {
      {"", 1e-3},           {"millimeter", 1e-3}, {"millimetre", 1e-3}, {"mm", 1e-3},
      {"inch", 0.0254},     {"in", 0.0254},       {"foot", 0.3048},     {"feet", 0.3048},
      {"ft", 0.3048},       {"meter", 1},         {"metre", 1},         {"m", 1},
      {"centimeter", 1e-2}, {"cm", 1e-2},         {"centimetre", 1e-2}, {"micrometer", 1e-6},
      {"micrometre", 1e-6}, {"micron", 1e-6},     {"microns", 1e-6}};
  DeclaredUnit out;
  visit_elements(text, [&](std::string_view name, std::string_view attributes) {
    if (name != element) return false;
    const std::string unit = lower_case(attribute(attributes, "unit"));
    if (const auto found = kMetres.find(unit); found != kMetres.end())
      out.metres = found->second;
    else
      out.wrong = "unit = '" + unit.substr(0, 40) + "'";
    return true;
  });
  return out;
}

DeclaredUnit declared_unit(const std::string& text, const std::string& ending) {
  if (ending == ".dxf") return text.starts_with("AutoCAD Binary") ? DeclaredUnit{} : dxf_unit(text);
  if (ending == ".x3d") return x3d_unit(text);
  if (ending == ".amf") return additive_unit(text, "amf");
  return {};
}

/// An OFF's rows: as many as vertices and faces that it counts. Its first word may say what stands beside a vertex'
/// coordinates (Geomview: [ST][C][N][4][n]OFF).
void check_off(const std::string& text, const std::string& file, Problems& problems) {
  constexpr double kMost = 4e9;
  std::istringstream in(text);
  std::vector<double> counts;
  std::size_t rows = 0;
  for (std::string line; std::getline(in, line);) {
    line = trimmed(line.substr(0, line.find('#')));
    if (const auto kind = lower_case(line).find("off");
        counts.empty() && kind <= 5 && lower_case(line).find_first_not_of("stcn4") >= kind)
      line = trimmed(line.substr(kind + 3));
    if (line.empty()) continue;
    if (!counts.empty()) {
      ++rows;
      continue;
    }
    std::istringstream words(line);
    for (double count = 0; words >> count;) counts.push_back(count);
    if (counts.size() < 2) return;  // another kind of OFF, of which Assimp says what is wrong
  }
  if (counts.size() < 2) return;
  for (const double count : {counts[0], counts[1]})
    if (!(count >= 0 && count <= kMost && count == std::floor(count)))
      return problems.add({file, 0, 0, ""}, "a count of vertices or faces that is none", number_text(count),
                          "correct the file's counts");
  if (static_cast<double>(rows) == counts[0] + counts[1]) return;
  problems.add({file, 0, 0, ""}, "another number of rows than the file counts",
               std::to_string(rows) + " for " + number_text(counts[0] + counts[1]) + " vertices and faces",
               "restore the file, or correct its counts");
}

bool is_gltf(const std::string& ending) { return ending == ".gltf" || ending == ".glb"; }

}  // namespace

std::optional<double> declared_unit_m(const std::string& text, const std::string& ending) {
  return declared_unit(text, ending).metres;
}

namespace {

/// The beginning of a part of a package (ISO/IEC 29500-2); none where it is not there.
std::optional<std::string> part_of(const std::string& package, const std::string& name) {
  constexpr std::size_t kHead = 1 << 16;
  VSILFILE* const part = base::gdal().VSIFOpenL(("/vsizip/{" + package + "}/" + name).c_str(), "rb");
  if (!part) return std::nullopt;
  std::string head(kHead, '\0');
  head.resize(base::gdal().VSIFReadL(head.data(), 1, kHead, part));
  base::gdal().VSIFCloseL(part);
  return head;
}

/// The package's model, by the relationship of its root that starts a 3MF (3MF Core Specification, 2.1).
std::string model_part(const std::string& relationships) {
  std::string out;
  visit_elements(relationships, [&](std::string_view name, std::string_view attributes) {
    if (name != "Relationship" || !lower_case(attribute(attributes, "Type")).ends_with("/3dmodel")) return false;
    out = attribute(attributes, "Target");
    return true;
  });
  return out.substr(std::min(out.find_first_not_of('/'), out.size()));
}

}  // namespace

DeclaredUnit package_unit(const std::string& file) {
  const base::QuietGdal quiet;
  const auto relationships = part_of(file, "_rels/.rels");
  const std::string name = relationships ? model_part(*relationships) : "";
  if (name.empty()) return {std::nullopt, "no relationship in _rels/.rels names a 3D model"};
  const auto model = part_of(file, name);
  if (!model) return {std::nullopt, "no part '" + name.substr(0, 80) + "', which _rels/.rels names"};
  return additive_unit(*model, "model");
}

void check_mesh_text(const std::string& text, const std::string& ending, const std::string& file, Problems& problems) {
  const base::Where where{file, 0, 0, ""};
  if (is_gltf(ending)) check_extensions(text, file, problems);
  if (ending == ".off") check_off(base::without_dos_end(text), file, problems);
  if (const std::string wrong = declared_unit(text, ending).wrong; !wrong.empty())
    problems.add(where, "the file's unit of lengths is not known", wrong, "write the mesh in metres");
  if (ending == ".dxf" && !text.starts_with("AutoCAD Binary") && !trimmed(base::without_dos_end(text)).ends_with("EOF"))
    problems.add(where, "a DXF ends before its end", "no EOF in its last line", "restore the file");
  if (ending != ".obj") return;
  std::istringstream in(text);
  std::size_t free_form = 0;
  for (std::string word, line; std::getline(in, line);) {
    std::istringstream words(line);
    free_form += words >> word && (word == "surf" || word == "curv" || word == "curv2");
  }
  if (free_form > 0) problems.tell(where, base::counted(free_form, "free-form shape") + " left out: polygons are read");
}

std::size_t declared_faces(const std::string& text, const std::string& ending) {
  if (ending == ".obj") return obj_faces(text);
  return is_gltf(ending) ? gltf_faces(parsed_gltf(text)) : 0;
}

}  // namespace raycube::scene
