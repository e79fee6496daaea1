// [atmosphere] adjacency in a simulation file.
#include "tests/unit/scene_files.h"

using namespace raycube;
using namespace raycube::scene;
using namespace raycube::scene::testing;

TEST_CASE("S4.9 atmosphere.adjacency: local, mean, off; the table decides where it is not given; else refused") {
  const Folder folder;
  LoadOptions options;
  options.need_instruments = false;
  const auto mode = [&](const std::string& line) {
    return load(folder,
                std::string(kHead) + kGrey + "[[plane]]\nmaterial = \"grey\"\nsize_m = [5, 5]\n[atmosphere]\n" + line +
                    "\n",
                options)
        .atmosphere.adjacency;
  };
  CHECK(mode("") == Adjacency::automatic);
  CHECK(mode("adjacency = \"local\"") == Adjacency::local);
  CHECK(mode("adjacency = \"mean\"") == Adjacency::mean);
  CHECK(mode("adjacency = \"off\"") == Adjacency::off);
  CHECK_SAYS(refusal(folder, std::string(kHead) + "[atmosphere]\nadjacency = \"far\"\n"),
             "'adjacency' wants one of local, mean, off (found text \"far\")");
}
