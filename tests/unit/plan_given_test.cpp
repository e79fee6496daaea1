// [plan] in a simulation file: counts fixed by hand.
#include "tests/unit/scene_files.h"

using namespace raycube;
using namespace raycube::scene;
using namespace raycube::scene::testing;

TEST_CASE("S64 [plan]: absent keys are the plan's choice, given ones are read, 6 nodes do not exist") {
  const Folder folder;
  LoadOptions options;
  options.need_instruments = false;
  const auto plan = [&](const std::string& lines) {
    return load(folder, std::string(kHead) + kGrey + "[[plane]]\nmaterial = \"grey\"\nsize_m = [5, 5]\n" + lines + "\n",
                options)
        .plan;
  };
  CHECK_FALSE(plan("").any());
  CHECK_FALSE(plan("[plan]").any());
  const PlanOverrides given = plan("[plan]\nsky_rank = 2\nheight_nodes = 3\nview_nodes = 5\npath_nodes = 7");
  CHECK(given.sky_rank == 2);
  CHECK(given.height_nodes == 3);
  CHECK(given.view_nodes == 5);
  CHECK(given.path_nodes == 7);
  CHECK(given.any());
  CHECK_SAYS(refusal(folder, std::string(kHead) + "[plan]\nview_nodes = 6\n"),
             "nodes come in 1, 2, 3, 4, 5 and 7 (found 6)");
  CHECK_SAYS(refusal(folder, std::string(kHead) + "[plan]\nsky_rank = 5\n"), "sky_rank");
}
