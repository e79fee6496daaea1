// Mesh files: PLY by our own reader, others through Assimp, which works in a child process under a limit; checked and
// triangulated.
#pragma once

#include <array>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "host/base/error.h"
#include "scene_compiler/bvh_builder.h"

namespace raycube::scene {

/// Faces of one material and one group of a file.
struct MeshPart {
  std::string material;  ///< as the file names it; "" when it names none
  std::string group;     ///< the mesh (glTF), the object or the groups (OBJ: what follows o or g)
  /// Further names: of an OBJ's several groups each; the nodes of the file's scene that the faces hang from, the
  /// nearest first.
  std::vector<std::string> others;

  /// Every name that is not empty, those that go first before the others.
  std::vector<std::string> names() const;
};

/// What is up in a file's numbers, and how long one is, as its format defines or the file declares: glTF is y up and in
/// metres; Collada and FBX declare both; 3DS and DXF are z up, and DXF may declare a unit. Nothing: the format is
/// silent.
struct MeshFrame {
  std::optional<char> up;  ///< 'x', 'y' or 'z'
  std::optional<double> unit_m;
  bool upside_down = false;  ///< that axis points down, which is not read
  std::string wrong_unit{};  ///< what stands where a unit is due
};

/// How a mesh file is to be read. What the file or its format says of axis and unit goes first; these apply where it is
/// silent, z up in metres where neither says anything.
struct MeshRequest {
  std::optional<char> up;
  std::optional<double> unit_m;
  bool strict = false;                                          ///< refuse faces without area
  double room_bytes = std::numeric_limits<double>::infinity();  ///< memory for all that the file shows
};

/// A file's triangles. mesh.surface holds the index of the part until materials are assigned.
struct MeshFile {
  TriangleMesh mesh;
  /// Of each vertex its place in images, counted in images from their lower left corner: (1, 1) is the upper right one.
  /// NaN where the file gives none, of an OBJ everywhere when some are no numbers.
  std::vector<std::array<float, 2>> in_image;
  std::vector<MeshPart> parts;
  std::size_t faces = 0;          ///< polygons in the file
  std::size_t dropped_faces = 0;  ///< of zero area
  std::string first_dropped;      ///< "face 12"
  std::size_t no_surfaces = 0;    ///< of fewer than three corners: points and lines
  /// What the vertices count from, of a mesh that lies far from its own zero: map coordinates do not fit a float.
  std::array<double, 3> centre_m{};
  MeshFrame declared;
  char up = 'z';  ///< as it was read: in the file's own terms
  double unit_m = 1;
};

/// Whether a triangle's area is below 1e-12 of its squared longest edge.
bool zero_area(const std::array<float, 3>& a, const std::array<float, 3>& b, const std::array<float, 3>& c);

/// Reads every mesh of the file with its node transforms applied, in metres and z up: y up turns (x, y, z) into (x, -z,
/// y), x up into (-y, x, z) and then likewise. An axis or a unit that was asked for though the file says another is
/// told. Refused, with the face or vertex number (OBJ: the line): vertices that are not finite, face indices out of
/// range, files without faces. Zero-area faces (area below 1e-12 of the squared longest edge) are dropped and counted,
/// refused when strict. user_face = polygon number from 0, counted part by part as Assimp delivers them.
std::optional<MeshFile> read_mesh_file(const std::string& file, const MeshRequest& request, const base::Where& asked_by,
                                       base::Problems& problems);

/// An OBJ text as Assimp reads it right, where it would not as it stands: without a byte-order mark, blanks before and
/// comments behind what lines say; in UTF-8, other bytes taken as Latin-1; vertices counted from `centre`.
std::optional<std::string> obj_for_assimp(const std::string& text, const std::array<double, 3>& centre = {});
/// How many faces an OBJ text has.
std::size_t obj_faces(const std::string& text);
/// The vertices of an OBJ text that are numbers.
std::vector<std::array<double, 3>> obj_vertices(const std::string& text);

/// Reports numbers that do not parse and face indices out of range in an OBJ text, by line. Assimp reads past
/// some of these silently ("3.1+e2" becomes 3.1).
void check_obj_text(const std::string& text, const std::string& file, base::Problems& problems);

/// Whether every texture coordinate of an OBJ text is a finite number. Assimp reads others as 0; meshes without images
/// do not need them.
bool sound_obj_places(const std::string& text);

}  // namespace raycube::scene
