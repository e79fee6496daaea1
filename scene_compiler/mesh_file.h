// Mesh files through Assimp, which works in a child process under a limit; checked and triangulated.
#pragma once

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
};

/// Whether a triangle's area is below 1e-12 of its squared longest edge.
bool zero_area(const std::array<float, 3>& a, const std::array<float, 3>& b, const std::array<float, 3>& c);

/// Reads every mesh of the file with its node transforms applied. unit_m scales; y_up turns (x, y, z) into
/// (x, -z, y). Refused, with the face or vertex number (OBJ: the line): vertices that are not finite, face
/// indices out of range, files without faces. Zero-area faces (area below 1e-12 of the squared longest edge)
/// are dropped and counted, refused when strict. user_face = polygon number from 0, counted part by part as
/// Assimp delivers them.
std::optional<MeshFile> read_mesh_file(const std::string& file, double unit_m, bool y_up, bool strict,
                                       const base::Where& asked_by, base::Problems& problems);

/// Reports numbers that do not parse and face indices out of range in an OBJ text, by line. Assimp reads past
/// some of these silently ("3.1+e2" becomes 3.1).
void check_obj_text(const std::string& text, const std::string& file, base::Problems& problems);

/// Whether every texture coordinate of an OBJ text is a finite number. Assimp reads others as 0; meshes without images
/// do not need them.
bool sound_obj_places(const std::string& text);

/// Reports a PLY header that is cut short, misspelt, or counts more elements than the file has bytes for, by
/// line. Assimp runs in a circle on the first and takes memory for the last.
void check_ply_header(const std::string& text, const std::string& file, base::Problems& problems);

/// A binary PLY text as Assimp reads it right, where it would not as it stands: after the header it drops one line
/// feed, which it takes for the end of a line ended by \r\n, though the first vertex may begin with such a byte (Assimp
/// 5.2.5; all that follows is then read one byte off).
std::optional<std::string> ply_for_assimp(const std::string& text);

}  // namespace raycube::scene
