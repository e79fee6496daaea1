// What the verbs of `raycube analyze` share: the cube and its bands, regions, the folder of results.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include "host/analysis/cube.h"
#include "host/analysis/map_files.h"
#include "host/analysis/regions.h"
#include "host/base/output_file.h"
#include "host/cli/verb.h"
#include "host/products/csv_writer.h"
#include "host/run/services.h"

namespace raycube::cli {

/// What every verb takes.
struct AnalyzeRequest {
  std::string cube, classes;
  analysis::BandChoice bands;
  std::vector<std::string> regions;
  bool no_picture = false;
};

/// Adds CUBE, --bands, --wavelengths and --no-picture.
void add_cube_options(base::OptionTable& table, AnalyzeRequest& request);
/// The cube, and a warning of each thing that its header says and that is left out.
analysis::Cube open_cube(const Invocation& invocation, const std::string& path, const analysis::BandChoice& bands);
/// Adds --region and --classes; what: "whose statistics are taken".
void add_region_options(base::OptionTable& table, AnalyzeRequest& request, const std::string& what);

/// A pass over a cube that is shown as `what`.
class ShownPass {
 public:
  ShownPass(const run::Services& services, const std::string& what, const analysis::Cube& cube, int times = 1);
  operator const analysis::Pass&() const { return pass_; }

 private:
  run::Step step_;
  analysis::Pass pass_;
};

/// Regions that are asked for, then those of the classes; Error(input) where two have one name.
std::vector<analysis::Region> regions_of(const AnalyzeRequest& request, const analysis::Cube& cube);

/// The folder of results: VERB.json with all numbers, VERB.png, tables and maps, all at once. To be made before the
/// work: it refuses at once what is there already.
class AnalysisFolder {
 public:
  AnalysisFolder(const Invocation& invocation, const AnalyzeRequest& request, const std::string& verb);

  base::OutputSet& set() { return set_; }
  base::OutputFile& table(const std::string& name) { return set_.add(name); }
  /// All numbers; "cube", "bands", "wavelength_um" and "command" come by themselves.
  nlohmann::ordered_json& numbers() { return numbers_; }
  /// Draws, publishes and tells: `text`, or the numbers with --json.
  int finish(const analysis::Cube& cube, const std::string& text);

 private:
  const Invocation& invocation_;
  const AnalyzeRequest& request_;
  std::string verb_;
  base::OutputSet set_;
  base::OutputFile* picture_ = nullptr;
  base::OutputFile* figures_ = nullptr;
  nlohmann::ordered_json numbers_;
};

/// A column a spectrum: wavelength (or band number) first.
void write_spectra_table(base::OutputFile& file, const analysis::Cube& cube, const std::vector<std::string>& columns,
                         const std::vector<std::vector<double>>& values);

inline std::vector<double> list_of(const Eigen::VectorXd& v) { return {v.data(), v.data() + v.size()}; }

}  // namespace raycube::cli
