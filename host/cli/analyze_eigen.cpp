// raycube analyze eigen: eigenvalues and eigenvectors of a cube's covariance, beside another cube's.
#include <algorithm>
#include <memory>
#include <ostream>

#include <fmt/format.h>

#include "host/analysis/eigen_structure.h"
#include "host/analysis/moments.h"
#include "host/base/error.h"
#include "host/base/text.h"
#include "host/cli/analyze_kit.h"
#include "host/cli/analyze_verbs.h"
#include "host/cli/services.h"

namespace raycube::cli {
namespace {

struct EigenRequest : AnalyzeRequest {
  std::string other;
  int count = 4;
};

struct FoundStructure {
  std::uint64_t pixels = 0;
  analysis::EigenStructure structure;
};

FoundStructure structure_of(const analysis::Cube& cube, const EigenRequest& request, const run::Services& services) {
  const std::vector<analysis::Region> regions = regions_of(request, cube);
  analysis::Chooses chooses;
  if (!regions.empty())
    chooses = [&](std::int64_t line, std::int64_t sample) {
      return std::any_of(regions.begin(), regions.end(), [&](const auto& r) { return r.holds(line, sample); });
    };
  const analysis::Moments moments = analysis::moments_of(cube, ShownPass(services, "covariance", cube), chooses);
  if (moments.count() < 2)
    throw base::Error(base::Fault::input, fmt::format("{}: a covariance needs two pixels or more (found {})",
                                                      cube.path(), moments.count()));
  FoundStructure out{moments.count(), analysis::eigen_structure(moments.covariance())};
  if (!(out.structure.values[0] > 0))
    throw base::Error(base::Fault::input, cube.path() + ": all pixels are alike; there is no direction to find");
  return out;
}

nlohmann::ordered_json json_of(const analysis::Cube& cube, const FoundStructure& found, std::size_t count) {
  const Eigen::VectorXd& values = found.structure.values;
  nlohmann::ordered_json out = {{"cube", cube.path()}, {"pixels", found.pixels}, {"eigenvalues", list_of(values)}};
  out["over_the_first"] = list_of(values / std::max(values[0], 1e-300));
  out["share_of_variance"] = list_of(values / std::max(values.sum(), 1e-300));
  for (std::size_t k = 0; k < count; ++k)
    out["eigenvectors"].push_back(list_of(found.structure.vectors.col(static_cast<Eigen::Index>(k))));
  return out;
}

int eigen(const EigenRequest& request, Invocation& invocation) {
  const run::Services services = services_of(invocation);
  const analysis::Cube cube = open_cube(invocation, request.cube, request.bands);
  const std::size_t count = std::min<std::size_t>(static_cast<std::size_t>(request.count), cube.bands());
  AnalysisFolder folder(invocation, request, "eigen");
  const FoundStructure found = structure_of(cube, request, services);
  folder.numbers()["structures"].push_back(json_of(cube, found, count));
  std::vector<std::string> columns;
  std::vector<std::vector<double>> vectors;
  const auto add_columns = [&](const FoundStructure& of, const std::string& head) {
    for (std::size_t k = 0; k < count; ++k)
      columns.push_back(fmt::format("{}{}", head, k + 1)),
          vectors.push_back(list_of(of.structure.vectors.col(static_cast<Eigen::Index>(k))));
  };
  add_columns(found, "eigenvector_");
  std::string text = fmt::format("{}, {}\n", base::counted(found.pixels, "pixel"),
                                 base::counted(static_cast<std::size_t>(cube.bands()), "band"));
  const auto line = [&](std::size_t k) {
    const auto i = static_cast<Eigen::Index>(k);
    return fmt::format("eigenvalue {}: {:.6g}, {:.4g} of the first, {:.4f} of the variance", k + 1,
                       found.structure.values[i], found.structure.values[i] / found.structure.values[0],
                       found.structure.values[i] / found.structure.values.sum());
  };
  if (request.other.empty()) {
    for (std::size_t k = 0; k < count; ++k) text += line(k) + "\n";
  } else {
    const analysis::Cube other = open_cube(invocation, request.other, request.bands);
    analysis::require_same_bands(cube, other);
    const FoundStructure second = structure_of(other, request, services);
    folder.numbers()["structures"].push_back(json_of(other, second, count));
    add_columns(second, "other_eigenvector_");
    const std::vector<double> alike = analysis::alignments(found.structure, second.structure, count);
    folder.numbers()["alignment"] = alike;
    for (std::size_t k = 1; k <= count; ++k) {
      const auto angles = analysis::principal_angles_deg(found.structure, second.structure, k);
      folder.numbers()["principal_angles_deg"].push_back(angles);
      text += line(k - 1) + fmt::format("; |v.w| {:.4f}; largest angle between the first {}: {:.3f} deg\n",
                                        alike[k - 1], k, angles.back());
    }
  }
  write_spectra_table(folder.table("eigenvectors.csv"), cube, columns, vectors);
  return folder.finish(cube, text);
}

}  // namespace

Verb verb_analyze_eigen() {
  auto o = std::make_shared<EigenRequest>();
  Verb verb("eigen", "Eigenvalues and eigenvectors of a cube's covariance, beside another cube's");
  verb.description =
      "Of the covariance over N - 1 of all pixels, or of regions. Eigenvectors have length 1 and their entry of "
      "largest "
      "size is positive. With --other: |v.w| of each pair of eigenvectors, and the principal angles between the spaces "
      "of the first 1, 2, ... of them, which do not depend on how eigenvectors of close eigenvalues are turned.";
  verb.examples = {"raycube analyze eigen real.img --other simulated.img --count 4"};
  verb.common = kOutput | kThreads;
  verb.output_default = "eigen";
  verb.add_options = [o](base::OptionTable& table) {
    add_cube_options(table, *o);
    table.text("--other", "CUBE", "A second cube of the same bands", o->other);
    table.integer("--count", "", 1, 100, "Eigenvectors that are told", o->count);
    add_region_options(table, *o, "whose pixels take part");
  };
  verb.run = [o](Invocation& invocation) { return eigen(*o, invocation); };
  return verb;
}

}  // namespace raycube::cli
