// The double traversal against brute force, its explanations on constructed cases, and Embree against it.
#include <doctest/doctest.h>

#include <map>

#include "host/reference/double_trace.h"
#include "host/reference/embree_scene.h"
#include "scene_compiler/bvh_builder.h"
#include "tests/oracle/reference_scene.h"

using namespace raycube;
using namespace raycube::reference;
using namespace raycube::test;

namespace {

glm::vec3 random_point(std::mt19937& random, float size) {
  std::uniform_real_distribution<float> u(-size, size);
  const float x = u(random), y = u(random);
  return {x, y, u(random)};
}

/// Random soup with slivers and coincident faces, placed several times, turned and scaled; a terrain and a box below
/// it.
scene::CompiledScene mixed_scene(std::vector<glm::vec3>& vertices) {
  std::mt19937 random(7);
  SceneBuilder builder;
  std::vector<Triangle> soup;
  for (int i = 0; i < 300; ++i) {
    const glm::vec3 p = random_point(random, 5);
    soup.push_back({p, p + random_point(random, 1), p + random_point(random, 1), 0});
    if (i % 10 == 0) soup.push_back(soup.back());                                                 // coincident
    if (i % 15 == 0) soup.push_back({p, p + glm::vec3(2, 0, 0), p + glm::vec3(1, 1e-6f, 0), 0});  // sliver
  }
  const std::uint32_t cloud = builder.mesh(soup);
  std::vector<Triangle> ground = terrain(16, 2.5f, 0, &vertices);
  add_box(ground, {-3, -3, -1}, {3, 3, 4});
  builder.instance(builder.mesh(ground));
  for (int i = 0; i < 5; ++i)
    builder.instance(cloud, rotation(1.1 * i, 0.4 * i, 0.5 + 0.3 * i), {7.3 * i - 15, 5.1 * (i % 3) - 5, 8 + i});
  return builder.finish();
}

/// Random rays, rays aimed at vertices and edge interiors, axis-parallel rays on box planes.
std::vector<Ray> mixed_rays(int count, const std::vector<glm::vec3>& vertices) {
  std::mt19937 random(11);
  std::vector<Ray> rays;
  for (int i = 0; i < count; ++i) {
    const glm::vec3 from = random_point(random, 10) + glm::vec3(0, 0, 40);
    const glm::vec3 &a = vertices[random() % vertices.size()], &b = vertices[random() % vertices.size()];
    switch (i % 4) {
      case 0:
        rays.push_back(ray_between(from, random_point(random, 18)));
        break;
      case 1:
        rays.push_back(ray_between(from, a));
        break;
      case 2:
        rays.push_back(ray_between(from, a + 0.37f * glm::vec3(2.5f, 0, 0)));
        break;
      default:
        rays.push_back({{b.x, b.y, 40}, {0, 0, -1}});
        break;
    }
  }
  rays.push_back({{-3, -20, 2}, {0, 1, 0}});  // within a face's plane: 0 * inf in naive slabs
  rays.push_back({{3, 0, 40}, {0, 0, -1}});
  rays.push_back({{-20, 0, 4}, {1, 0, 0}});
  return rays;
}

}  // namespace

TEST_CASE("S7: the double walk finds what brute force over every triangle finds") {
  std::vector<glm::vec3> vertices;
  const scene::CompiledScene scene = mixed_scene(vertices);
  const DoubleTracer tracer(scene);
  int different = 0, hits = 0;
  for (const Ray& ray : mixed_rays(4000, vertices)) {
    const Trace walk = tracer.trace(ray), all = tracer.trace_brute_force(ray);
    different += walk.hit != all.hit || walk.t != all.t || walk.certain_t != all.certain_t;
    hits += !walk.hit.miss();
  }
  CHECK(different == 0);
  CHECK(hits > 3000);
}

TEST_CASE("S7 S61: Embree in robust mode differs from double only within the stated bounds") {
  std::vector<glm::vec3> vertices;
  const scene::CompiledScene scene = mixed_scene(vertices);
  const DoubleTracer tracer(scene);
  const EmbreeScene embree(scene);
  std::map<Cause, int> count;
  for (const Ray& ray : mixed_rays(100000, vertices))
    ++count[tracer.explain(ray, embree.intersect(ray), tracer.trace(ray).hit)];
  for (const auto& [cause, n] : count) MESSAGE(std::string(cause_name(cause)) << ": " << n);
  CHECK(count[Cause::unexplained] == 0);
  CHECK(count[Cause::agree] > 50000);
  CHECK(count[Cause::edge_tie] > 0);  // half of the rays aim at edges and vertices
}

TEST_CASE("S8 S61: a closed box leaks no ray aimed at its edges or vertices") {
  SceneBuilder builder;
  std::vector<Triangle> box;
  add_box(box, {-1, -2, -3}, {1.1f, 2.3f, 3.7f});
  builder.instance(builder.mesh(box), rotation(0.3, 0.2, 1.7), {100, -30, 5});
  const scene::CompiledScene scene = builder.finish();
  const DoubleTracer tracer(scene);
  std::mt19937 random(3);
  int leaks = 0;
  for (int i = 0; i < 20000; ++i) {  // from inside: every direction must hit
    const glm::vec3 to =
        i % 2 ? box[random() % box.size()].a : 0.5f * (box[random() % box.size()].a + box[random() % box.size()].c);
    const glm::dvec3 inside = rotation(0.3, 0.2, 1.7) * glm::dvec3(0.05) + glm::dvec3(100, -30, 5);
    const glm::dvec3 target = rotation(0.3, 0.2, 1.7) * glm::dvec3(to) + glm::dvec3(100, -30, 5);
    leaks += tracer.trace(ray_between(glm::vec3(inside), glm::vec3(target))).hit.miss();
  }
  CHECK(leaks == 0);
}

TEST_CASE("S61: explain names exact tie, edge tie, depth tie, grazing, and leaves real differences unexplained") {
  SceneBuilder builder;
  std::vector<Triangle> list;
  add_quad(list, {0, 0, 0}, {1, 0, 0}, {0, 1, 0});                      // primitives 0, 1: diagonal x = y
  add_quad(list, {0, 0, -1}, {1, 0, 0}, {0, 1, 0});                     // 2, 3: one metre below
  add_quad(list, {2, 0, 0}, {1, 0, 0}, {0, 1, 0});                      // 4, 5
  add_quad(list, {2, 0, 0}, {1, 0, 0}, {0, 1, 0});                      // 6, 7: coincident with 4, 5
  list.push_back({{5, 0, 0}, {5, 1, 0}, {5, 0.5f, 1}, 0});              // 8: vertical, edge-on from above
  list.push_back({{0.4f, -5, 1}, {0.6f, -5, 1}, {0.5f, 0.25f, 1}, 0});  // 9: tip at (0.5, 0.25), one metre above
  add_quad(list, {7, 0, 0}, {1, 0, 0}, {0, 1, 0});                      // 10, 11
  add_quad(list, {7, 0, -1e-5f}, {1, 0, 0}, {0, 1, 0});  // 12, 13: 10 um below, a third of one ulp of 610 m
  builder.instance(builder.mesh(list));
  const scene::CompiledScene scene = builder.finish();
  const DoubleTracer tracer(scene);
  const auto hit = [](std::uint32_t p) { return Hit{0, p}; };
  const auto down = [](float x, float y) { return Ray{{x, y, 610}, {0, 0, -1}}; };
  const Hit miss;

  SUBCASE("edge between two faces of one surface") {
    CHECK(tracer.explain(down(0.5f, 0.5f), hit(0), hit(1)) == Cause::exact_tie);
    CHECK(tracer.explain(down(0.5f, 0.5f), hit(2), hit(3)) ==
          Cause::edge_tie);  // within the bounds, but 0 and 1 lie before
    CHECK(tracer.explain(down(0.5f, 0.5f + 1e-5f), hit(0), hit(1)) == Cause::edge_tie);
    CHECK(tracer.explain(down(0.5f, 0.51f), hit(0), hit(1)) == Cause::unexplained);  // 1 cm off: 270 ulp of 610 m
  }
  SUBCASE("vertex and silhouette") {
    CHECK(tracer.explain(down(0, 0), hit(0), miss) == Cause::edge_tie);     // both layers have a corner here
    CHECK(tracer.explain(down(1, 0.4f), hit(0), miss) == Cause::edge_tie);  // both layers end here
    CHECK(tracer.explain(down(0.99f, 0.4f), hit(0), miss) == Cause::unexplained);
    CHECK(tracer.explain(down(1.01f, 0.4f), hit(0), miss) == Cause::unexplained);
    CHECK(tracer.explain(down(0.5f, 0.25f), hit(9), hit(0)) == Cause::edge_tie);
  }
  SUBCASE("depth") {
    CHECK(tracer.explain(down(2.7f, 0.3f), hit(4), hit(6)) == Cause::exact_tie);
    CHECK(tracer.explain(down(7.7f, 0.3f), hit(10), hit(12)) == Cause::depth_tie);
    CHECK(tracer.explain(down(0.7f, 0.3f), hit(0), hit(2)) == Cause::unexplained);
    // Two uncertain answers do not excuse a hit behind a certain one between them.
    CHECK(tracer.explain(down(0.5f, 0.25f), hit(9), hit(2)) == Cause::unexplained);
  }
  SUBCASE("grazing") {
    CHECK(tracer.explain(down(5, 0.5f), hit(8), miss) == Cause::grazing);
    CHECK(tracer.explain(down(5.01f, 0.5f), hit(8), miss) == Cause::unexplained);
  }
  SUBCASE("whether anything is hit, whatever is guessed") {
    CHECK(tracer.hits_anything(down(0.7f, 0.3f), hit(0)));
    CHECK(tracer.hits_anything(down(0.7f, 0.3f), hit(8)));
    CHECK(tracer.hits_anything(down(0.7f, 0.3f), miss));
    CHECK(tracer.hits_anything(down(0.7f, 0.3f), Hit{7, 1u << 20}));
    CHECK(!tracer.hits_anything(down(1.5f, 0.3f), hit(0)));
    CHECK(!tracer.hits_anything(down(1.5f, 0.3f), miss));
  }
  SUBCASE("names that no triangle has") {
    CHECK(tracer.explain(down(0.7f, 0.3f), hit(0), hit(15)) == Cause::unexplained);
    CHECK(tracer.explain(down(0.7f, 0.3f), hit(0), hit(1u << 20)) == Cause::unexplained);
    CHECK(tracer.explain(down(0.7f, 0.3f), hit(0), Hit{7, 0}) == Cause::unexplained);
  }
}

TEST_CASE("S61: shadow rays: certain, clear and tied") {
  SceneBuilder builder;
  std::vector<Triangle> list;
  add_quad(list, {-10, -10, 0}, {20, 0, 0}, {0, 20, 0});
  add_quad(list, {0, -1, 5}, {2, 0, 0}, {0, 2, 0});
  builder.instance(builder.mesh(list));
  const scene::CompiledScene scene = builder.finish();
  const DoubleTracer tracer(scene);
  const auto up = [](double x) { return DoubleRay{{x, 0.3, 1e-5}, {0, 0, 1}, 1e-4}; };
  CHECK(tracer.visibility(up(1), {0, 0}) == Visibility::blocked);
  CHECK(tracer.visibility(up(-1), {0, 1}) == Visibility::visible);
  CHECK(tracer.visibility(up(5e-5), {0, 0}) == Visibility::uncertain);
  CHECK(tracer.visibility(up(-5e-5), {0, 1}) == Visibility::uncertain);
  CHECK(tracer.visibility(up(-2e-3), {0, 1}) == Visibility::visible);
  CHECK(tracer.visibility(up(2e-3), {0, 0}) == Visibility::blocked);
}

TEST_CASE("S4 S7: on a scene of the compiler's own trees the walk equals brute force and Embree differs by ties only") {
  scene::CompiledScene scene;
  std::vector<glm::vec3> vertices;
  const auto mesh_of = [](const std::vector<Triangle>& triangles) {
    scene::TriangleMesh mesh;
    for (const Triangle& t : triangles) {
      const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
      for (const glm::vec3& p : {t.a, t.b, t.c}) mesh.vertices.push_back({p.x, p.y, p.z});
      mesh.triangles.push_back({first, first + 1, first + 2});
      mesh.surface.push_back(0);
      mesh.user_face.push_back(first / 3);
    }
    return mesh;
  };
  std::mt19937 random(17);
  std::vector<Triangle> leaves;
  for (int i = 0; i < 400; ++i) {
    const glm::vec3 p = random_point(random, 2);
    leaves.push_back({p, p + random_point(random, 0.2f), p + random_point(random, 0.2f), 0});
  }
  scene.surfaces.emplace_back();
  const std::uint32_t ground = scene::append_mesh(scene, "ground", mesh_of(terrain(16, 2.5f, 0, &vertices)));
  const std::uint32_t tree = scene::append_mesh(scene, "tree", mesh_of(leaves));
  scene::append_instance(scene, ground, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}, 0);
  for (int i = 0; i < 20; ++i) {
    const glm::dmat3 m = rotation(0.7 * i, 0.1 * i, 0.6 + 0.05 * i);
    scene::append_instance(scene, tree,
                           {m[0][0], m[1][0], m[2][0], 3.1 * (i % 5) - 8, m[0][1], m[1][1], m[2][1], 4.7 * (i / 5) - 8,
                            m[0][2], m[1][2], m[2][2], 4},
                           static_cast<std::uint32_t>(i + 1));
  }
  scene::finish_top_tree(scene);
  const DoubleTracer tracer(scene);
  const EmbreeScene embree(scene);
  int different = 0;
  std::map<Cause, int> count;
  const std::vector<Ray> rays = mixed_rays(40000, vertices);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const Trace walk = tracer.trace(rays[i]);
    if (i % 20 == 0) {
      const Trace all = tracer.trace_brute_force(rays[i]);
      different += walk.hit != all.hit || walk.t != all.t || walk.certain_t != all.certain_t;
    }
    ++count[tracer.explain(rays[i], embree.intersect(rays[i]), walk.hit)];
  }
  CHECK(different == 0);
  CHECK(count[Cause::unexplained] == 0);
  CHECK(count[Cause::agree] > 20000);
}
