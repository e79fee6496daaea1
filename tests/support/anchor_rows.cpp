#include "tests/support/anchor_rows.h"
#include "tests/support/skipped.h"

#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace raycube::testing {

std::vector<AnchorCells> anchor_cells(const std::string& name, const std::string& not_shown) {
  const char* shared = std::getenv("RAYCUBE_SHARED");
  if (!shared) {
    skip_part(not_shown);
    return {};
  }
  std::ifstream file(std::string(shared) + "/reference/atmosphere/" + name);
  std::vector<std::string> labels;
  std::vector<AnchorCells> rows;
  for (std::string text; std::getline(file, text);) {
    if (text.empty() || text[0] == '#') continue;
    std::istringstream in(text);
    std::vector<std::string> cells;
    for (std::string cell; std::getline(in, cell, ',');) cells.push_back(cell);
    if (labels.empty()) {
      labels = cells;
      continue;
    }
    AnchorCells& row = rows.emplace_back();
    for (std::size_t i = 0; i < cells.size() && i < labels.size(); ++i) row[labels[i]] = cells[i];
  }
  if (rows.empty()) throw std::runtime_error(name + " is not there or has no rows");
  return rows;
}

std::vector<AnchorRow> anchor_rows(const std::string& name, const std::string& not_shown) {
  std::vector<AnchorRow> rows;
  for (const AnchorCells& cells : anchor_cells(name, not_shown)) {
    AnchorRow& row = rows.emplace_back();
    for (const auto& [label, text] : cells)
      if (!text.empty()) row[label] = std::strtod(text.c_str(), nullptr);
  }
  return rows;
}

}  // namespace raycube::testing
