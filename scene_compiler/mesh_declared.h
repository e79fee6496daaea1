// What texts of mesh files declare and Assimp passes over: units, counts, extensions.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "host/base/error.h"

namespace raycube::scene {

/// Metres of one of the file's numbers: $INSUNITS of DXF, `unit` of X3D and of AMF, whose own is the millimetre.
/// ending: ".dxf". nullopt: the text declares none.
std::optional<double> declared_unit_m(const std::string& text, const std::string& ending);

/// The same of a 3MF, whose package names its model. Called in a child process.
struct DeclaredUnit {
  std::optional<double> metres;  ///< none where it is wrong
  std::string wrong;             ///< what stands in its place, or why none is found
};
DeclaredUnit package_unit(const std::string& file);

/// Reports a text that is not all of what it declares: a DXF without its end, an OFF of another number of rows than it
/// counts, a glTF with required extensions that would change its surfaces, a unit that is not known. Told: what a
/// format may hold that is left out.
void check_mesh_text(const std::string& text, const std::string& ending, const std::string& file,
                     base::Problems& problems);

/// Faces that a text counts, of OBJ and glTF; 0: it does not say.
std::size_t declared_faces(const std::string& text, const std::string& ending);

}  // namespace raycube::scene
