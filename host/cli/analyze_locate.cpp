// raycube analyze locate: where the pixels of one image lie in another, by the truth of both.
#include <array>
#include <cmath>
#include <memory>
#include <mutex>
#include <vector>

#include <Eigen/Dense>
#include <fmt/format.h>

#include "host/analysis/ground_match.h"
#include "host/analysis/impossible_places.h"
#include "host/base/error.h"
#include "host/base/text.h"
#include "host/cli/analyze_kit.h"
#include "host/cli/analyze_verbs.h"
#include "host/cli/services.h"

namespace raycube::cli {
namespace {

struct LocateRequest : AnalyzeRequest {
  std::string other;
};

analysis::Cube places_of(const Invocation& invocation, const std::string& path) {
  const auto layers = analysis::place_layers(products::read_envi_header(products::find_envi_pair(path).header), path);
  std::string numbers;
  for (const std::size_t layer : layers) numbers += (numbers.empty() ? "" : ",") + std::to_string(layer + 1);
  analysis::Cube cube = open_cube(invocation, path, {numbers, ""});
  analysis::Pixels one;
  analysis::refuse_places_off_earth(path, cube.lines(), [&](std::int64_t l, std::vector<std::array<double, 2>>& out) {
    cube.read(l, 1, one);
    out.clear();
    for (std::size_t p = 0; p < one.count(); ++p) out.push_back({one.at(p)[0], one.at(p)[1]});
  });
  return cube;
}

/// Way on the ground from a pixel to the next of its line; 0: not known.
double size_of(const analysis::Pixels& pixels, std::size_t p) {
  const auto width = static_cast<std::size_t>(pixels.samples);
  if (width < 2) return 0;
  const std::size_t next = p % width + 1 < width ? p + 1 : p - 1;
  if (!pixels.counts[next]) return 0;
  const double *a = pixels.at(p), *b = pixels.at(next);
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

/// The other's places as a linear function of the first's, by least squares over all pixels found.
struct LinearFit {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Matrix<double, 3, 2> right = Eigen::Matrix<double, 3, 2>::Zero();
  double squares = 0;
  std::uint64_t count = 0;

  void add(double sample, double line, const analysis::ImagePlace& there) {
    const Eigen::Vector3d x(1, sample, line);
    const Eigen::RowVector2d y(there.sample, there.line);
    normal += x * x.transpose(), right += x * y, squares += y.squaredNorm(), ++count;
  }
  void add(const LinearFit& other) {
    normal += other.normal, right += other.right, squares += other.squares, count += other.count;
  }
};

int locate(const LocateRequest& request, Invocation& invocation) {
  if (request.other.empty()) throw base::Error(base::Fault::input, "give the second image's truth: --other CUBE");
  const run::Services services = services_of(invocation);
  const analysis::Cube cube = places_of(invocation, request.cube), other = places_of(invocation, request.other);
  if (cube.header().band_names[cube.chosen()[0]] != other.header().band_names[other.chosen()[0]])
    throw base::Error(base::Fault::input, cube.path() + " and " + other.path() +
                                              ": one has places in the scene, the other on the map; give truth.img of "
                                              "both, or location.img of both");
  AnalysisFolder folder(invocation, request, "locate");
  const analysis::GroundMatch match(other, ShownPass(services, "second", other));
  analysis::MapFiles map(folder.set(), "locate", cube, {"sample [pixel]", "line [pixel]"},
                         "where each pixel's ground lies in " + other.path() +
                             ", pixels from the middle of its first; not a number: not there, or hidden there");
  std::vector<LinearFit> parts(analysis::kMostParts);
  analysis::for_each_part(
      cube, ShownPass(services, "first", cube), [&](std::size_t part, const analysis::Pixels& pixels) {
        std::vector<double> values(2 * pixels.count(), NAN);
        for (std::size_t p = 0; p < pixels.count(); ++p) {
          if (!pixels.counts[p]) continue;
          const auto there = match.find(pixels.at(p), size_of(pixels, p));
          if (!there) continue;
          values[2 * p] = there->sample, values[2 * p + 1] = there->line;
          const auto width = static_cast<std::size_t>(pixels.samples);
          parts[part].add(static_cast<double>(p % width),
                          static_cast<double>(pixels.first_line) + static_cast<double>(p / width), *there);
        }
        map.write(pixels, values);
      });
  map.finish();
  LinearFit fit;
  for (const LinearFit& part : parts) fit.add(part);
  folder.numbers()["other"] = other.path();
  folder.numbers()["found"] = fit.count, folder.numbers()["of"] = cube.pixels();
  std::string text = fmt::format("{} of {} in the second image\n", fit.count, base::counted(cube.pixels(), "pixel"));
  if (fit.count >= 3) {
    const Eigen::Matrix<double, 3, 2> slope = fit.normal.colPivHouseholderQr().solve(fit.right);
    const double rest = std::sqrt(std::max(0.0, fit.squares - (slope.transpose() * fit.right).trace()) /
                                  static_cast<double>(fit.count));
    for (const auto& [name, column] : {std::pair{"sample", 0}, std::pair{"line", 1}}) {
      folder.numbers()[name] = {
          {"at_first", slope(0, column)}, {"per_sample", slope(1, column)}, {"per_line", slope(2, column)}};
      text += fmt::format("{} = {:.4f} {:+.6f} sample {:+.6f} line\n", name, slope(0, column), slope(1, column),
                          slope(2, column));
    }
    folder.numbers()["rms_px"] = rest;
    text += fmt::format("but for {:.4f} pixels (rms)\n", rest);
  }
  return folder.finish(cube, text);
}

}  // namespace

Verb verb_analyze_locate() {
  auto o = std::make_shared<LocateRequest>();
  Verb verb("locate", "Where each pixel of a render lies in another render of the scene, by their truth");
  verb.description =
      "CUBE and --other are truth.img (or location.img) of two renders of one scene, of any sensors, scales and "
      "places: for each pixel of the first the map has the sample and line of the second that look at the same ground, "
      "from 0 in the middle of the first pixel, to parts of a pixel by the slope of the second's places about the "
      "nearest. Pixels whose ground the second does not see are not a number. The numbers have the linear function "
      "that "
      "fits best.";
  verb.examples = {"raycube analyze locate out/spectir/truth.img --other out/wasp/truth.img"};
  verb.common = kOutput | kThreads;
  verb.output_default = "locate";
  verb.add_options = [o](base::OptionTable& table) {
    table.argument("CUBE", "The first image's truth: truth.img or location.img", o->cube);
    table.text("--other", "CUBE", "The second image's", o->other);
    o->no_picture = true;
  };
  verb.run = [o](Invocation& invocation) { return locate(*o, invocation); };
  return verb;
}

}  // namespace raycube::cli
