#include "scene_compiler/mesh_file.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <iterator>
#include <limits>
#include <sstream>

#include "host/base/gdal_library.h"
#include "host/base/input_file.h"
#include "host/base/limited_child.h"
#include "host/base/memory.h"
#include "host/base/text.h"
#include "scene_compiler/assimp_child.h"
#include "scene_compiler/csv_file.h"
#include "scene_compiler/document_values.h"
#include "scene_compiler/mesh_declared.h"
#include "scene_compiler/memory_sum.h"
#include "scene_compiler/ply_file.h"
#include "scene_compiler/polygon.h"

namespace raycube::scene {
namespace {

using base::counted;
using base::Problems;
using base::Where;

constexpr std::size_t kMaxReports = 20;
/// Numbers farther from zero than this are counted from the mesh's middle: a float of them steps by a millimetre.
constexpr double kFar_m = 1e4;
// What reading may take. Assimp needs about 1 us and 10 to 60 bytes for each byte of OBJ or PLY text; formats
// that compress more.
constexpr double kBase_s = 20, kPerByte_s = 20e-6;
constexpr std::uint64_t kBase_bytes = 2ull << 30, kPerByte_bytes = 200;

template <class Real>
std::string vertex_text(const std::array<Real, 3>& v) {
  return "(" + number_text(v[0]) + ", " + number_text(v[1]) + ", " + number_text(v[2]) + ")";
}

/// Formats that Assimp turns to be y up, whatever they are.
bool assimp_turns(const std::string& ending) {
  return ending == ".dae" || ending == ".3ds" || ending == ".dxf" || ending == ".ase";
}

class Importer {
 public:
  Importer(std::string file, const MeshRequest& request, const Where& asked_by, Problems& problems)
      : file_(std::move(file)), request_(request), asked_by_(asked_by), problems_(problems) {
    set_frame({}, false);
  }

  /// Before the first mesh. `turned`: its numbers have come y up, whatever the file says.
  void set_frame(const MeshFrame& declared, bool turned) {
    out.declared = declared;
    out.up = declared.up.value_or(request_.up.value_or('z'));
    out.unit_m = declared.unit_m.value_or(request_.unit_m.value_or(1));
    up_ = turned ? 'y' : out.up;
    if (request_.up && *request_.up != out.up)
      problems_.tell(asked_by_,
                     file_ + " is " + out.up + " up by its format or its own word; the scene's 'up' is not used");
    if (request_.unit_m && std::abs(*request_.unit_m - out.unit_m) > 1e-9 * out.unit_m)
      problems_.tell(asked_by_, file_ + " is in units of " + number_text(out.unit_m) +
                                    " m by its format or its own word; the scene's 'unit_m' is not used");
  }

  /// Before the first mesh: numbers of the file count from here.
  void set_centre(const std::array<double, 3>& of_file) { centre_ = of_file, out.centre_m = in_metres({0, 0, 0}); }

  /// Of a reader that keeps single precision.
  void tell_of_rounding() {
    float most = 0;
    for (const auto& v : out.mesh.vertices)
      for (const float value : v) most = std::max(most, std::abs(value));
    if (most > kFar_m)
      problems_.tell({file_, 0, 0, ""}, "vertices lie up to " + short_text(double(most)) +
                                            " m from the file's zero and are rounded to " +
                                            short_text(double(most) * 6e-8) + " m; move it to an origin of its own");
  }

  /// Before the first mesh: what comes, so that lists do not grow beyond it.
  void expect(const ShownByNodes& shown) {
    out.mesh.vertices.reserve(static_cast<std::size_t>(shown.vertices));
    out.in_image.reserve(static_cast<std::size_t>(shown.vertices));
    const auto triangles = static_cast<std::size_t>(shown.triangles());
    out.mesh.triangles.reserve(triangles), out.mesh.surface.reserve(triangles), out.mesh.user_face.reserve(triangles);
  }

  /// A mesh where a node puts it: place(vertex) is a vertex in the file's frame, in single precision of Assimp.
  template <class Mesh, class Place>
  void add_mesh(const Mesh& mesh, MeshPart names, Place place) {
    const auto part = static_cast<std::uint32_t>(out.parts.size());
    out.parts.push_back(std::move(names));
    const auto first = static_cast<std::uint32_t>(out.mesh.vertices.size());
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
      const auto v = place(mesh.vertices[i]);
      if (!std::isfinite(v[0]) || !std::isfinite(v[1]) || !std::isfinite(v[2]))
        report("vertex " + std::to_string(first + i), "vertex is not finite", vertex_text(v), "correct the file");
      const auto at = in_metres({double(v[0]), double(v[1]), double(v[2])});
      out.mesh.vertices.push_back(
          {float(at[0] - out.centre_m[0]), float(at[1] - out.centre_m[1]), float(at[2] - out.centre_m[2])});
    }
    out.in_image.insert(out.in_image.end(), mesh.in_image.begin(), mesh.in_image.end());
    const std::uint32_t* corner = mesh.corners.data();
    for (const std::uint32_t corners : mesh.face_corners) {
      add_face(corner, corners, static_cast<std::uint32_t>(mesh.vertices.size()), first, part);
      corner += corners;
    }
  }

  MeshFile out;

 private:
  /// Of numbers that come.
  std::array<double, 3> in_metres(const std::array<double, 3>& v) const {
    double x = (v[0] + centre_[0]) * out.unit_m, y = (v[1] + centre_[1]) * out.unit_m,
           z = (v[2] + centre_[2]) * out.unit_m;
    if (up_ == 'x') std::swap(x, y), x = -x;
    if (up_ != 'z') std::swap(y, z), y = -y;
    return {x, y, z};
  }

  void report(const std::string& element, const std::string& what, const std::string& found,
              const std::string& way_out) {
    if (++reports_ <= kMaxReports) problems_.add({file_, 0, 0, element}, what, found, way_out);
  }

  void add_face(const std::uint32_t* corner, std::uint32_t corner_count, std::uint32_t vertex_count,
                std::uint32_t first, std::uint32_t part) {
    const auto number = static_cast<std::uint32_t>(out.faces++);
    const std::string element = "face " + std::to_string(number);
    for (std::uint32_t k = 0; k < corner_count; ++k)
      if (corner[k] >= vertex_count) {
        report(element, "face index out of range",
               std::to_string(corner[k]) + " of " + std::to_string(vertex_count) + " vertices", "correct the file");
        return;
      }
    if (corner_count < 3) {
      ++out.no_surfaces;
      return;
    }
    corners_.clear();
    for (std::uint32_t k = 0; k < corner_count; ++k) {
      const auto& v = out.mesh.vertices[first + corner[k]];
      corners_.push_back({v[0], v[1], v[2]});
    }
    bool kept = false;
    for (const auto& triangle : triangulate_polygon(corners_)) {
      const std::array<std::uint32_t, 3> index{first + corner[triangle[0]], first + corner[triangle[1]],
                                               first + corner[triangle[2]]};
      const auto& v = out.mesh.vertices;
      if (zero_area(v[index[0]], v[index[1]], v[index[2]])) continue;
      out.mesh.triangles.push_back(index);
      out.mesh.surface.push_back(part);
      out.mesh.user_face.push_back(number);
      kept = true;
    }
    if (kept) return;
    if (request_.strict)
      report(element, "face has no area", base::counted(corner_count, "corner"),
             "remove it, or set scene.strict = false to drop such faces");
    if (out.dropped_faces++ == 0) out.first_dropped = element;
  }

  std::string file_;
  MeshRequest request_;
  Where asked_by_;
  Problems& problems_;
  char up_ = 'z';  ///< of the numbers that come
  std::array<double, 3> centre_{};
  std::size_t reports_ = 0;
  std::vector<std::array<double, 3>> corners_;
};

/// The whole number in the middle of vertices that lie far from zero.
std::optional<std::array<double, 3>> far_centre(const std::vector<std::array<double, 3>>& vertices, double unit_m) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  std::array<double, 3> low{infinity, infinity, infinity}, high{-infinity, -infinity, -infinity};
  for (const auto& v : vertices)
    for (std::size_t axis = 0; axis < 3; ++axis)
      low[axis] = std::min(low[axis], v[axis]), high[axis] = std::max(high[axis], v[axis]);
  std::array<double, 3> out{};
  bool far = false;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    out[axis] = std::round(0.5 * (low[axis] + high[axis]));
    if (!std::isfinite(out[axis])) return std::nullopt;
    far = far || std::max(std::abs(low[axis]), std::abs(high[axis])) * unit_m > kFar_m;
  }
  return far ? std::optional(out) : std::nullopt;
}

/// The words of a text.
std::vector<std::string> words_of(const std::string& text) {
  std::istringstream in(text);
  return {std::istream_iterator<std::string>(in), {}};
}

/// A part's names; the groups of an OBJ's face stand in one name, apart by spaces.
MeshPart names_of(const AssimpMesh& mesh, const AssimpNode& node, bool obj) {
  MeshPart out{mesh.material, mesh.name, {}};
  if (obj) out.others = words_of(out.group);
  out.others.insert(out.others.end(), node.names.begin(), node.names.end());
  return out;
}

/// Of formats that may define axis and unit, which is not known here.
void tell_of_silence(const MeshFrame& declared, const std::string& ending, const MeshRequest& request,
                     const std::string& file, Problems& problems) {
  for (const char* silent : {".obj", ".stl", ".off", ".3ds", ".dxf", ".ase", ".fbx"})
    if (ending == silent) return;
  if (!declared.up && !request.up)
    problems.tell({file, 0, 0, ""},
                  "what is up in the format '" + ending + "' is not known here: z, unless 'up' says other");
  if (!declared.unit_m && !request.unit_m)
    problems.tell({file, 0, 0, ""},
                  "the unit of the format '" + ending + "' is not known here: m, unless 'unit_m' says other");
}

/// Damaged files hang, crash or bloat Assimp (5.2.5). Whole ones take microseconds a byte.
bool add_by_assimp(Importer& reader, const std::string& file, const std::string& text, bool obj,
                   const MeshRequest& request, const Where& asked_by, Problems& problems) {
  // Of an OBJ, whose unit is the scene's: numbers far from zero are moved in its text, before they become floats.
  const auto centre = obj ? far_centre(obj_vertices(text), reader.out.unit_m) : std::nullopt;
  const base::AvailableMemory available = base::available_memory();
  const double room_bytes = std::min(request.room_bytes, static_cast<double>(available.bytes));
  const std::string ending = lower_case(std::filesystem::path(file).extension().string());
  if (ending == ".3mf") base::gdal();  // by which the child opens the package
  base::ChildLimits limits;
  limits.cpu_s = kBase_s + kPerByte_s * static_cast<double>(text.size());
  limits.memory_bytes = kBase_bytes + kPerByte_bytes * text.size();
  base::Unpacked read = base::in_limited_child(
      limits, [&](base::Parcel& parcel) { send_by_assimp(file, text, centre, room_bytes, parcel); });
  const std::string said = read.end == base::ChildEnd::done ? read.text() : "it " + read.why;
  if (!said.empty()) {
    problems.add({file, 0, 0, ""}, "Assimp cannot read the mesh", said,
                 "correct or convert the file; " + asked_by.text() + " names it");
    return false;
  }
  const auto shown = read.value<ShownByNodes>();
  if (shown.bytes() > room_bytes) {
    const auto bytes_text = [](double bytes) { return base::format_bytes(static_cast<std::uint64_t>(bytes)); };
    problems.add({file, 0, 0, ""}, "the mesh needs more memory than there is",
                 number_text(shown.faces) + " faces, a mesh counted for each node that names it: about " +
                     bytes_text(shown.bytes()) + ", of " + bytes_text(room_bytes) + " " + available.by,
                 "write a mesh that is repeated into a file of its own and place it by [[instance]], which costs its "
                 "triangles once");
    return false;
  }
  MeshFrame declared;
  if (const char up = read.value<char>(); up != '\0') declared.up = up;
  if (const double unit_m = read.value<double>(); unit_m > 0) declared.unit_m = unit_m;
  if (read.value<bool>()) {
    problems.add({file, 0, 0, ""}, "the file's axis that is up points down", "UpAxisSign = -1",
                 "write it with an axis that points up, for instance by Blender");
    return false;
  }
  if (const std::string wrong = read.text(); !wrong.empty()) {
    problems.add({file, 0, 0, ""}, "the file's unit of lengths is not known", wrong, "write the mesh in metres");
    return false;
  }
  if (const auto unit_m = declared_unit_m(text, ending)) declared.unit_m = unit_m;
  tell_of_silence(declared, ending, request, file, problems);
  reader.set_frame(declared, assimp_turns(ending));
  if (centre) reader.set_centre(*centre);
  reader.expect(shown);
  const std::vector<AssimpMesh> meshes = take_meshes(read);
  while (const auto node = take_node(read)) {
    const AssimpMesh& mesh = meshes.at(node->mesh);
    reader.add_mesh(mesh, names_of(mesh, *node, obj), [&](const auto& vertex) { return node->placed(vertex); });
  }
  if (!centre) reader.tell_of_rounding();
  return true;
}

}  // namespace

std::vector<std::string> MeshPart::names() const {
  std::vector<std::string> out;
  const auto add = [&](const std::string& name) {
    if (!name.empty() && std::find(out.begin(), out.end(), name) == out.end()) out.push_back(name);
  };
  add(material), add(group);
  for (const std::string& name : others) add(name);
  return out;
}

bool zero_area(const std::array<float, 3>& a, const std::array<float, 3>& b, const std::array<float, 3>& c) {
  const std::array<double, 3> e{double(b[0]) - a[0], double(b[1]) - a[1], double(b[2]) - a[2]};
  const std::array<double, 3> f{double(c[0]) - a[0], double(c[1]) - a[1], double(c[2]) - a[2]};
  const std::array<double, 3> g{double(c[0]) - b[0], double(c[1]) - b[1], double(c[2]) - b[2]};
  const double nx = e[1] * f[2] - e[2] * f[1], ny = e[2] * f[0] - e[0] * f[2], nz = e[0] * f[1] - e[1] * f[0];
  const auto square = [](const std::array<double, 3>& v) { return v[0] * v[0] + v[1] * v[1] + v[2] * v[2]; };
  const double longest2 = std::max({square(e), square(f), square(g)});
  return !(nx * nx + ny * ny + nz * nz > 4e-24 * longest2 * longest2);
}

std::optional<MeshFile> read_mesh_file(const std::string& file, const MeshRequest& request, const Where& asked_by,
                                       Problems& problems) {
  const std::size_t before = problems.count();
  const auto text = read_whole_file(file, asked_by, problems);
  if (!text) return std::nullopt;
  const bool obj = is_obj(file);
  const std::string ending = lower_case(std::filesystem::path(file).extension().string());
  check_mesh_text(*text, ending, file, problems);
  if (obj) check_obj_text(obj_for_assimp(*text).value_or(*text), file, problems);
  if (problems.count() != before) return std::nullopt;
  Importer reader(file, request, asked_by, problems);
  if (text->starts_with("ply")) {
    auto ply = read_ply(*text, file, problems);
    if (!ply) return std::nullopt;
    if (const auto centre = far_centre(ply->vertices, reader.out.unit_m)) {
      for (auto& v : ply->vertices)
        for (std::size_t axis = 0; axis < 3; ++axis) v[axis] -= (*centre)[axis];
      reader.set_centre(*centre);
    }
    reader.add_mesh(*ply, {"DefaultMaterial", "", {}}, [](const auto& vertex) { return vertex; });
  } else if (!add_by_assimp(reader, file, *text, obj, request, asked_by, problems)) {
    return std::nullopt;
  }
  if (problems.count() != before) return std::nullopt;
  if (obj && !sound_obj_places(*text))
    for (auto& place : reader.out.in_image) place.fill(std::numeric_limits<float>::quiet_NaN());
  if (reader.out.no_surfaces > 0)
    problems.tell({file, 0, 0, ""}, counted(reader.out.no_surfaces, "face") + " of fewer than three corners left out");
  if (const std::size_t wanted = declared_faces(*text, ending); wanted > reader.out.faces)
    problems.tell({file, 0, 0, ""},
                  counted(wanted - reader.out.faces, "face") + " of " + std::to_string(wanted) + " lost by Assimp");
  if (reader.out.mesh.triangles.empty()) {
    problems.add({file, 0, 0, ""}, "mesh has no faces with area",
                 std::to_string(reader.out.mesh.vertices.size()) + " vertices, " +
                     base::counted(reader.out.faces, "face") + ", " + std::to_string(reader.out.dropped_faces) +
                     " of them without area",
                 "give a surface mesh; point clouds and lines have nothing to hit");
    return std::nullopt;
  }
  return std::move(reader.out);
}

}  // namespace raycube::scene
