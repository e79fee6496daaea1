#include "scene_compiler/mesh_declared.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <sstream>

#include <nlohmann/json.hpp>

#include "host/base/json_text.h"
#include "host/base/text.h"
#include "scene_compiler/csv_file.h"
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

/// A DXF's unit (DXF reference, HEADER, $INSUNITS); nullopt: none.
std::optional<double> dxf_unit_m(const std::string& text) {
  // inches, feet, miles, mm, cm, m, km, microinches, mils, yards, angstroms, nm, um, dm, dam, hm, Gm, AU, light years,
  // parsecs, US survey feet
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
                                       1200.0 / 3937};
  const auto at = text.find("$INSUNITS");
  if (at == std::string::npos) return std::nullopt;
  std::istringstream in(text.substr(at, 200));
  std::string name;
  int code = 0, unit = 0;
  if (!(in >> name >> code >> unit) || code != 70 || unit < 1 || unit > 21) return std::nullopt;
  return kMetres[unit - 1];
}

/// The value of an attribute of the first element that begins so; empty: there is none.
std::string attribute(const std::string& text, const std::string& element, const std::string& name) {
  const auto from = text.find("<" + element);
  if (from == std::string::npos) return "";
  const std::string head = text.substr(from, text.find('>', from) - from);
  const auto at = head.find(" " + name);
  const auto quote = at == std::string::npos ? at : head.find_first_of("\"'", at);
  if (quote == std::string::npos) return "";
  return head.substr(quote + 1, head.find(head[quote], quote + 1) - quote - 1);
}

/// The unit of lengths of an X3D (ISO/IEC 19775-1, 7.2.5 UNIT).
std::optional<double> x3d_unit_m(const std::string& text) {
  for (auto at = text.find("<unit"); at != std::string::npos; at = text.find("<unit", at + 1)) {
    const std::string here = text.substr(at, text.find('>', at) - at + 1);
    if (lower_case(attribute(here, "unit", "category")) != "length") continue;
    const auto factor = parse_number(attribute(here, "unit", "conversionFactor"));
    if (factor && *factor > 0) return factor;
  }
  return std::nullopt;
}

/// Of AMF (ISO/ASTM 52915): millimetres where it says nothing.
double additive_unit_m(const std::string& name) {
  const std::string unit = lower_case(name);
  return unit == "inch"                     ? 0.0254
         : unit == "feet" || unit == "foot" ? 0.3048
         : unit == "meter"                  ? 1
         : unit == "centimeter"             ? 1e-2
         : unit == "micron"                 ? 1e-6
                                            : 1e-3;
}

/// An OFF's rows: as many as vertices and faces that it counts.
void check_off(const std::string& text, const std::string& file, Problems& problems) {
  std::istringstream in(text);
  std::vector<double> counts;
  std::size_t rows = 0;
  for (std::string line; std::getline(in, line);) {
    line = trimmed(line.substr(0, line.find('#')));
    if (counts.empty() && lower_case(line).starts_with("off")) line = trimmed(line.substr(3));
    if (line.empty()) continue;
    if (!counts.empty()) {
      ++rows;
      continue;
    }
    std::istringstream words(line);
    for (double count = 0; words >> count;) counts.push_back(count);
    if (counts.size() < 2) return;  // another kind of OFF, of which Assimp says what is wrong
  }
  if (counts.size() < 2 || static_cast<double>(rows) == counts[0] + counts[1]) return;
  problems.add({file, 0, 0, ""}, "another number of rows than the file counts",
               std::to_string(rows) + " for " + std::to_string(static_cast<std::uint64_t>(counts[0] + counts[1])) +
                   " vertices and faces",
               "restore the file, or correct its counts");
}

bool is_gltf(const std::string& ending) { return ending == ".gltf" || ending == ".glb"; }

}  // namespace

std::optional<double> declared_unit_m(const std::string& text, const std::string& ending) {
  if (ending == ".dxf") return dxf_unit_m(text);
  if (ending == ".x3d") return x3d_unit_m(text);
  if (ending == ".amf") return additive_unit_m(attribute(text, "amf", "unit"));
  return std::nullopt;
}

void check_mesh_text(const std::string& text, const std::string& ending, const std::string& file, Problems& problems) {
  const base::Where where{file, 0, 0, ""};
  if (is_gltf(ending)) check_extensions(text, file, problems);
  if (ending == ".off") check_off(text, file, problems);
  if (ending == ".3mf") problems.tell(where, "the unit that a 3MF declares is not read; it is taken as in millimetres");
  if (ending == ".dxf" && !text.starts_with("AutoCAD Binary") && !trimmed(text).ends_with("EOF"))
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
