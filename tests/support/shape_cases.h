// What tests that go through every scattering shape (kernels/materials) share: the ends of a parameter's range, and a
// table for the shape that needs one.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "kernels/materials/shapes.h"
#include "scene_compiler/compiled_scene.h"
#include "scene_compiler/shape_list.h"

namespace raycube::test {

/// A parameter's end as kernels/materials states it: ">0" is 0.
inline double parameter_end(std::string_view text) {
  return std::stod(std::string(text.substr(text.starts_with('>') ? 1 : 0)));
}

/// A table of two angles each that grows with all three, as kernels/materials/measured.h has it.
inline std::shared_ptr<const std::vector<float>> measured_table() {
  static const auto table = std::make_shared<const std::vector<float>>(
      std::vector<float>{2, 2, 2, 0, 1.4f, 0, 1.4f, 0, 3, 0.3f, 0.4f, 0.5f, 0.5f, 0.4f, 0.6f, 0.7f, 0.9f});
  return table;
}

/// A shape whose parameters stand `part` of the way through their ranges, with a table where it needs one.
inline scene::Shape shape_at(const scene::ShapeEntry& entry, double part) {
  scene::Shape shape{entry.number};
  for (std::size_t i = 0; i < entry.parameters.size(); ++i) {
    const double low = parameter_end(entry.parameters[i].low), high = parameter_end(entry.parameters[i].high);
    shape.parameter[i] = low + part * (high - low);
  }
  if (entry.number == RC_SHAPE_measured) shape.table = measured_table();
  return shape;
}

}  // namespace raycube::test
