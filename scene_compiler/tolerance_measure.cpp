#include "scene_compiler/tolerance_measure.h"

#include <array>
#include <cstddef>
#include <stdexcept>

namespace raycube::scene {

namespace {

struct FigureNames {
  ErrorFigure figure;
  const char *name, *text;
};
constexpr std::array<FigureNames, 3> kFigures = {
    FigureNames{ErrorFigure::rms, "rms", "rms over pixels"},
    {ErrorFigure::p99, "p99", "99th percentile over pixels"},
    {ErrorFigure::worst, "worst", "worst of the pixels"},
};

}  // namespace

const char* figure_name(ErrorFigure figure) { return kFigures[static_cast<std::size_t>(figure)].name; }

ErrorFigure figure_named(const std::string& name) {
  for (const FigureNames& each : kFigures)
    if (name == each.name) return each.figure;
  throw std::invalid_argument("no figure of errors is named '" + name + "'");
}

std::string measure_text(const ToleranceMeasure& measure) {
  std::string out = kFigures[static_cast<std::size_t>(measure.figure)].text;
  for (const std::string& name : measure.materials) out += (&name == measure.materials.data() ? " of " : ", ") + name;
  return out;
}

}  // namespace raycube::scene
