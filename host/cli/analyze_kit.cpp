#include "host/cli/analyze_kit.h"

#include <ostream>

#include <fmt/format.h>

#include "host/base/error.h"
#include "host/base/version.h"
#include "host/cli/services.h"
#include "host/run/python_chart.h"

namespace raycube::cli {

void add_cube_options(base::OptionTable& table, AnalyzeRequest& request) {
  table.argument("CUBE", "An ENVI cube: its data file or its header", request.cube);
  table.text("--bands", "LIST", "Bands by number, from 1, as in 1:50,60", request.bands.numbers).default_text =
      "all that the header does not call bad";
  table.text("--wavelengths", "LIST", "Bands whose centres lie between these, nm, as in 418:643,900:1300",
             request.bands.wavelengths_nm);
  table.flag("--no-picture", "Draw no picture", request.no_picture);
}

analysis::Cube open_cube(const Invocation& invocation, const std::string& path, const analysis::BandChoice& bands) {
  analysis::Cube cube(path, bands);
  for (const std::string& warning : cube.header().warnings) invocation.log.warning(warning);
  return cube;
}

void add_region_options(base::OptionTable& table, AnalyzeRequest& request, const std::string& what) {
  table.texts("--region", "NAME=WHAT",
              "Region " + what +
                  ": X0:X1,Y0:Y1 (samples and lines from 0, ends included), FILE (a mask, or outlines), "
                  "FILE@VALUE, FILE@LAYER>=VALUE, FILE@FIELD=TEXT",
              request.regions);
  table.text("--classes", "FILE", "A raster of classes: a region for each, by its name", request.classes);
}

ShownPass::ShownPass(const run::Services& services, const std::string& what, const analysis::Cube& cube, int times)
    : step_(services, what, static_cast<std::uint64_t>(cube.lines()) * static_cast<std::uint64_t>(times), "lines"),
      pass_{services.threads, [this](std::int64_t lines) { step_.advance(static_cast<std::uint64_t>(lines)); }} {}

std::vector<analysis::Region> regions_of(const AnalyzeRequest& request, const analysis::Cube& cube) {
  std::vector<analysis::Region> out;
  for (const std::string& text : request.regions) out.push_back(analysis::read_region(text, cube));
  if (!request.classes.empty())
    for (analysis::Region& region : analysis::read_classes(request.classes, cube)) out.push_back(std::move(region));
  for (std::size_t i = 0; i < out.size(); ++i)
    for (std::size_t k = 0; k < i; ++k)
      if (out[i].name() == out[k].name())
        throw base::Error(base::Fault::input, fmt::format("two regions are called \"{}\"", out[i].name()));
  return out;
}

AnalysisFolder::AnalysisFolder(const Invocation& invocation, const AnalyzeRequest& request, const std::string& verb)
    : invocation_(invocation),
      request_(request),
      verb_(verb),
      set_(invocation.common.output.empty() ? verb : invocation.common.output, if_exists(invocation.common)) {
  if (invocation.common.overwrite) {
    std::vector<std::string> earlier;  // what this verb may have left there, with other options
    for (const char* end : {".json", ".png", ".csv", ".img", ".hdr", ".tif"}) earlier.push_back(verb + end);
    for (const char* table : {"endmembers.csv", "centers.csv", "eigenvectors.csv", "line.csv", "mtf.csv"})
      earlier.push_back(table);
    set_.replaces(earlier);
  }
  if (!request.no_picture) picture_ = &set_.add(verb + ".png");
  figures_ = &set_.add(verb + ".json");
  numbers_["analysis"] = verb, numbers_["command"] = invocation.command_line;
  numbers_["version"] = base::kVersion;
}

int AnalysisFolder::finish(const analysis::Cube& cube, const std::string& text) {
  std::vector<std::size_t> bands;
  for (const std::size_t b : cube.chosen()) bands.push_back(b + 1);
  numbers_["cube"] = request_.cube, numbers_["bands"] = bands;
  if (!cube.wavelength_um().empty()) numbers_["wavelength_um"] = cube.wavelength_um();
  if (!cube.header().data_units.empty()) numbers_["data_units"] = cube.header().data_units;
  figures_->append(numbers_.dump(1) + "\n");
  if (picture_) run::draw_into("analyze.py", *figures_, *picture_);
  set_.publish();
  if (invocation_.common.json)
    invocation_.out << numbers_.dump(2) << "\n";
  else
    invocation_.out << text << set_.folder() << "/" << verb_ << ".json\n";
  return 0;
}

void write_spectra_table(base::OutputFile& file, const analysis::Cube& cube, const std::vector<std::string>& columns,
                         const std::vector<std::vector<double>>& values) {
  const std::vector<double> um = cube.wavelength_um();
  std::vector<std::string> names = {"band"};
  if (!um.empty()) names.push_back("wavelength_nm");
  names.insert(names.end(), columns.begin(), columns.end());
  products::CsvWriter writer(file, names);
  for (std::size_t b = 0; b < cube.bands(); ++b) {
    writer.add(static_cast<std::int64_t>(cube.chosen()[b] + 1));
    if (!um.empty()) writer.add(1e3 * um[b]);
    for (const auto& column : values) writer.add(column[b]);
    writer.end_row();
  }
  writer.finish();
}

}  // namespace raycube::cli
