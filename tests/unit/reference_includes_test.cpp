// The reference is an oracle only while it shares nothing with what it judges: its include graph, walked.
#include <doctest/doctest.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;

const std::vector<std::string> kAllowed = {"host/reference/",
                                           "host/base/",
                                           "host/products/",
                                           "host/plan/plan.h",
                                           "host/plan/plan_report.h",
                                           "kernels/shared/",
                                           "kernels/materials/",
                                           "kernels/sampling/sampler.h",
                                           "kernels/sampling/sky_rays.h",
                                           "kernels/sampling/lidar_draws.h",
                                           "kernels/sampling/lamp_draws.h",
                                           "scene_compiler/lamp.h",
                                           "scene_compiler/compiled_scene.h",
                                           "scene_compiler/matter.h",
                                           "scene_compiler/owner.h",
                                           "scene_compiler/simulation.h",
                                           "scene_compiler/air_spec.def",
                                           "scene_compiler/band_truth.",
                                           "scene_compiler/lobe_albedo.h",
                                           "scene_compiler/shape_energy.h",
                                           "scene_compiler/spectral_shape.h",
                                           "scene_compiler/detector_spec.h",
                                           "scene_compiler/focal_plane_spec.h",
                                           "scene_compiler/lidar_spec.h",
                                           "scene_compiler/tolerance_measure.h",
                                           "host/lidar/lidar_plan.h",
                                           "host/lidar/pulse_lobes.h",
                                           "host/lidar/shot.h",
                                           "atmos_tables/render_table.h",
                                           "atmos_tables/interpolate.h",
                                           "atmos_tables/environment_function.h"};

std::string text_of(const fs::path& path) {
  std::ostringstream out;
  out << std::ifstream(path).rdbuf();
  return out.str();
}

/// Includes of our own tree, as written between quotes.
std::vector<std::string> own_includes(const std::string& text) {
  static const std::regex pattern("^[ \t]*#[ \t]*include[ \t]*\"([^\"]+)\"", std::regex::multiline);
  std::vector<std::string> out;
  for (std::sregex_iterator i(text.begin(), text.end(), pattern), end; i != end; ++i) out.push_back((*i)[1]);
  return out;
}

/// sky_basis.h and plan_report.h are part of the plan's data, vec3.h of a shot's; the reference itself has no use for
/// what they declare.
bool allowed(const std::string& include, const std::string& from = "") {
  if (include == "host/lidar/vec3.h") return from == "host/lidar/shot.h";
  if (include == "host/plan/sky_basis.h" || include == "host/plan/plan_report.h") return from == "host/plan/plan.h";
  for (const std::string& prefix : kAllowed)
    if (include.rfind(prefix, 0) == 0) return true;
  return false;
}

}  // namespace

TEST_CASE("S61: the reference includes the scene, the tables, the plan's data and named scalar headers only") {
  const fs::path root = RAYCUBE_SOURCE_DIR;
  std::vector<std::string> queue;
  for (const auto& entry : fs::directory_iterator(root / "host/reference"))
    if (entry.path().extension() == ".h" || entry.path().extension() == ".cpp")
      queue.push_back("host/reference/" + entry.path().filename().string());
  REQUIRE(queue.size() >= 6);
  std::set<std::string> seen(queue.begin(), queue.end());
  while (!queue.empty()) {
    const std::string file = queue.back();
    queue.pop_back();
    for (std::string include : own_includes(text_of(root / file))) {
      if (!fs::exists(root / include)) include = (fs::path(file).parent_path() / include).lexically_normal();
      CHECK_MESSAGE(fs::exists(root / include), file << " includes " << include << ", which is no file of ours");
      CHECK_MESSAGE(allowed(include, file), file << " includes " << include);
      if (seen.insert(include).second) queue.push_back(include);
    }
  }
  CHECK(seen.count("scene_compiler/compiled_scene.h") == 1);
}

TEST_CASE("S61: the walk would see a forbidden include") {
  const auto found = own_includes(
      "#include <vector>\n  #  include \"host/render/stage_graph.h\"\n#include \"kernels/geometry/edge.h\"\n");
  REQUIRE(found.size() == 2);
  CHECK(!allowed(found[0]));
  CHECK(!allowed(found[1]));
  CHECK(!allowed("host/cl/buffer.h"));
  CHECK(!allowed("host/plan/sky_basis.h", "host/reference/radiance.h"));
  CHECK(!allowed("host/plan/plan_report.h", "host/reference/compare.h"));
  CHECK(!allowed("kernels/entry/trace.h"));
}
