// Whose a triangle is: which meshes share a tree, and the table that says whose each of its triangles is.
#include <doctest/doctest.h>

#include <numeric>

#include "scene_compiler/owner.h"
#include "scene_compiler/placed_together.h"
#include "tests/support/test_scenes.h"
#include "tests/unit/scene_triangles.h"

using namespace raycube;
using scene::placed_together;
using scene::testing::Folder;

namespace {

using Matrix = std::array<double, 12>;
using Groups = std::vector<std::vector<std::uint32_t>>;

constexpr Matrix kHere = scene::kIdentity;

Matrix moved(double x_m) { return {1, 0, 0, x_m, 0, 1, 0, 0, 0, 0, 1, 0}; }

/// Scatters of bark and leaves at the same places, one plane below, one panel that stands where the plane does.
std::string trees_on_planes(const Folder& folder) {
  folder.write("bark.obj", "v 0 0 0\nv 1 0 0\nv 1 0 2\nv 0 0 2\nf 1 2 3 4\n");
  folder.write("leaves.obj", "v 0 0 2\nv 1 0 2\nv 1 1 2\nv 0 1 3\nf 1 2 3\nf 1 3 4\n");
  folder.write("places.csv", "x_m,y_m,yaw_deg,scale\n10,10,0,1\n20,20,90,2\n30,5,10,1\n");
  return std::string(scene::testing::kHead) + scene::testing::kTwo +
         "[[plane]]\nname = \"lawn\"\nmaterial = \"dark\"\nsize_m = [60, 60]\n"
         "[[box]]\nname = \"house\"\nmaterial = \"light\"\nsize_m = [6, 5, 4]\nposition_m = [3, 4, 0]\n"
         "[[mesh]]\nname = \"bark\"\nfile = \"bark.obj\"\nmaterial = \"dark\"\n"
         "[[mesh]]\nname = \"leaves\"\nfile = \"leaves.obj\"\nmaterial = \"light\"\n"
         "[[mesh]]\nname = \"stored\"\nfile = \"bark.obj\"\nmaterial = \"light\"\n"
         "[[scatter]]\nmesh = \"bark\"\npositions = \"places.csv\"\non_terrain = false\n"
         "[[scatter]]\nmesh = \"leaves\"\npositions = \"places.csv\"\non_terrain = false\n";
}

}  // namespace

TEST_CASE("meshes share a tree that are placed equally often, by the same matrices, equally far apart in the list") {
  CHECK(placed_together({}, 0).empty());
  // Placed once and unmoved, whatever stands between them; what is never placed is alone, one and another.
  CHECK(placed_together({{0, kHere}, {3, moved(1)}, {1, kHere}, {4, kHere}}, 6) == Groups{{0, 1, 4}, {2}, {3}, {5}});
  // Bark, then leaves; in turns; and in an order of their own, in which the first to be placed comes first.
  CHECK(placed_together({{0, kHere}, {0, moved(1)}, {1, kHere}, {1, moved(1)}}, 2) == Groups{{0, 1}});
  CHECK(placed_together({{0, kHere}, {1, kHere}, {0, moved(1)}, {1, moved(1)}}, 2) == Groups{{0, 1}});
  CHECK(placed_together({{1, kHere}, {0, kHere}, {1, moved(1)}, {0, moved(1)}}, 2) == Groups{{1, 0}});
  // Once more, elsewhere, in another order, or not always equally far apart.
  CHECK(placed_together({{0, kHere}, {0, moved(1)}, {1, kHere}}, 2) == Groups{{0}, {1}});
  CHECK(placed_together({{0, kHere}, {0, moved(1)}, {1, kHere}, {1, moved(2)}}, 2) == Groups{{0}, {1}});
  CHECK(placed_together({{0, kHere}, {0, moved(1)}, {1, moved(1)}, {1, kHere}}, 2) == Groups{{0}, {1}});
  CHECK(placed_together({{0, kHere}, {1, kHere}, {1, moved(1)}, {0, moved(1)}}, 2) == Groups{{0}, {1}});
}

TEST_CASE("shared trees and trees of one mesh hold the same triangles of the same owners, bit by bit") {
  const Folder folder;
  const std::string text = trees_on_planes(folder);
  const auto shared = load(folder, text).scene;
  const auto alone = load(folder, text, {.trees = scene::TreeSharing::none}).scene;
  CHECK(alone.trees.size() == 5);
  CHECK(alone.instances.size() == 8);
  REQUIRE(shared.trees.size() == 3);  // lawn and house; bark and leaves; what is never placed
  CHECK(shared.instances.size() == 4);
  CHECK(shared.trees[0].meshes == std::vector<std::uint32_t>{0, 1});
  CHECK(shared.trees[1].meshes == std::vector<std::uint32_t>{2, 3});
  CHECK(shared.lo == alone.lo);
  CHECK(shared.hi == alone.hi);
  const auto a = scene::testing::placed_triangles(shared), b = scene::testing::placed_triangles(alone);
  REQUIRE(a.size() == 2 + 12 + 3 * 2 + 3 * 2);
  REQUIRE(b.size() == a.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    CHECK(a[i].v == b[i].v);
    CHECK(a[i].surface == b[i].surface);
    CHECK(a[i].face == b[i].face);
  }
  const auto placed = scene::placements(shared);
  REQUIRE(placed.size() == 8);
  const std::uint32_t meshes[] = {0, 1, 2, 2, 2, 3, 3, 3};
  for (std::uint32_t i = 0; i < placed.size(); ++i) {
    CHECK(placed[i].number == i);
    CHECK(placed[i].mesh == meshes[i]);
  }
}

TEST_CASE("a triangle's owner is the placement, mesh, triangle and face that the user gave it") {
  const Folder folder;
  const auto scene = load(folder, trees_on_planes(folder)).scene;
  const scene::MeshTriangles triangles(scene);
  std::size_t seen = 0;
  for (const auto& placement : scene::placements(scene))
    for (std::uint32_t t = 0; t < triangles.of(placement.mesh).size(); ++t, ++seen) {
      const auto owner = scene::owner_of(scene, placement.instance, triangles.of(placement.mesh)[t]);
      CHECK(owner.placement == placement.number);
      CHECK(owner.mesh == placement.mesh);
      CHECK(owner.triangle == t);
      CHECK(owner.face == scene.meshes[placement.mesh].user_face[t]);
    }
  CHECK(seen == 26);
  CHECK(scene.meshes[2].user_face == std::vector<std::uint32_t>{0, 0});  // a square is one face, two triangles
  CHECK(scene.meshes[3].user_face == std::vector<std::uint32_t>{0, 1});
}

TEST_CASE("ties go by the user's placement, then by the triangle's place in its mesh, never by the trees") {
  const Folder folder;
  const auto scene = load(folder, trees_on_planes(folder)).scene;
  const scene::MeshTriangles triangles(scene);
  struct Listed {
    std::uint32_t instance, primitive;
  };
  std::vector<Listed> listed;  // as the user lists them
  for (const auto& placement : scene::placements(scene))
    for (const std::uint32_t primitive : triangles.of(placement.mesh))
      listed.push_back({placement.instance, primitive});
  for (std::size_t i = 0; i < listed.size(); ++i)
    for (std::size_t j = 0; j < listed.size(); ++j)
      CHECK(user_before(scene, listed[i].instance, listed[i].primitive, listed[j].instance, listed[j].primitive) ==
            (i < j));
  CHECK(user_before(scene, 0, 0, RC_NONE, RC_NONE));
  CHECK_FALSE(user_before(scene, RC_NONE, RC_NONE, 0, 0));
  // Bark at the third place goes before leaves at the first, though its tree is placed later.
  CHECK(scene.instances[3].placement > scene.instances[1].placement);
  CHECK(user_before(scene, 3, triangles.of(2)[1], 1, triangles.of(3)[0]));
}
