// A scene that the device cannot hold is refused before tracing, in one message.
#include <doctest/doctest.h>

#include <string>

#include "host/base/error.h"
#include "host/render/scene_buffers.h"

namespace {

using namespace raycube;

std::string refusal(const scene::CompiledScene& scene, const cl::DeviceInfo& device) {
  try {
    render::check_fits(scene, device);
  } catch (const base::Error& error) {
    return error.what();
  }
  return {};
}

/// 6 MiB of triangles (768 bytes a block) and 1 MiB of nodes (256 bytes each).
scene::CompiledScene some_scene() {
  scene::CompiledScene scene;
  scene.blocks.resize(8192);
  scene.nodes.resize(4096);
  return scene;
}

cl::DeviceInfo some_device(std::size_t largest_kib, std::size_t memory_mib) {
  cl::DeviceInfo device;
  device.name = "a device";
  device.max_alloc_bytes = largest_kib << 10;
  device.global_memory_bytes = memory_mib << 20;
  return device;
}

std::string cut(std::uint64_t count, std::size_t element_bytes, std::uint64_t largest_bytes,
                std::uint64_t page_bytes = 0) {
  const auto paging = render::cut_into_pages(count, element_bytes, largest_bytes, page_bytes);
  if (!paging) return "too large";
  return paging->pages == 1 ? "one page" : std::to_string(paging->pages) + " of 2^" + std::to_string(paging->shift);
}

TEST_CASE("S60 an array is cut into pages of a power of two of elements that fit half of the largest buffer") {
  CHECK(cut(0, 100, 1600) == "one page");
  CHECK(cut(8, 100, 1600) == "one page");
  CHECK(cut(9, 100, 1600) == "2 of 2^3");
  CHECK(cut(16, 100, 1600) == "2 of 2^3");
  CHECK(cut(17, 100, 1600) == "3 of 2^3");
  CHECK(cut(64, 100, 1600) == "8 of 2^3");
  CHECK(cut(9, 100, 1700) == "2 of 2^3");
  CHECK(cut(9, 100, 1599) == "3 of 2^2");  // half a buffer: 7 elements
  CHECK(cut(12, 100, 2399) == "2 of 2^3");
}

TEST_CASE(
    "S60 where 8 pages of half a buffer are too few, pages take up to a whole one; past that the array is too large") {
  CHECK(cut(65, 100, 1600) == "5 of 2^4");
  CHECK(cut(128, 100, 1600) == "8 of 2^4");
  CHECK(cut(129, 100, 1600) == "too large");
  CHECK(cut(33, 100, 1599) == "5 of 2^3");
  CHECK(cut(65, 100, 1599) == "too large");
  CHECK(cut(32, 100, 1599) == "8 of 2^2");
  CHECK(cut(8, 100, 199) == "8 of 2^0");
  CHECK(cut(9, 100, 199) == "too large");
  CHECK(cut(1, 100, 99) == "too large");
  // Page sizes of a test allow no larger pages, and never more than the device does.
  CHECK(cut(64, 100, 1600, 800) == "8 of 2^3");
  CHECK(cut(65, 100, 1600, 800) == "too large");
  CHECK(cut(16, 100, 1600, 9000) == "one page");
  CHECK(cut(17, 100, 1600, 9000) == "2 of 2^4");
}

TEST_CASE(
    "S60 for every count and limit: pages hold the array, are in use, fit, and nothing is refused that they could "
    "hold") {
  for (std::uint64_t largest = 1; largest < 200; ++largest)
    for (std::uint64_t count = 1; count < 300; ++count) {
      const auto paging = render::cut_into_pages(count, 3, largest);
      if (!paging) {
        std::uint64_t page = 0;  // the largest power of two of elements that a buffer takes
        for (std::uint64_t power = 1; power * 3 <= largest; power *= 2) page = power;
        REQUIRE(count > 8 * page);
        continue;
      }
      REQUIRE(paging->pages <= 8);
      if (paging->pages == 1) {
        REQUIRE(count * 3 <= largest);
        continue;
      }
      REQUIRE(count * 3 > largest / 2);
      REQUIRE((std::uint64_t{3} << paging->shift) <= largest);
      REQUIRE((std::uint64_t{paging->pages} << paging->shift) >= count);
      REQUIRE((std::uint64_t{paging->pages - 1} << paging->shift) < count);
    }
}

TEST_CASE("S60 numbers of triangles have 32 bits, so an array ends at 2^28 elements whatever the device") {
  constexpr std::uint64_t kMost = std::uint64_t{1} << 28, kHuge = std::uint64_t{1} << 50;
  CHECK(cut(kMost, 768, kHuge) == "one page");
  CHECK(cut(kMost, 768, std::uint64_t{1} << 36) == "8 of 2^25");
  CHECK(cut(kMost + 1, 768, kHuge) == "too large");
}

TEST_CASE("S60 a scene that fits the device to the byte is taken, in pages or not") {
  CHECK(refusal(some_scene(), some_device(6 << 10, 7)).empty());
  CHECK(refusal(some_scene(), some_device(768, 7)).empty());
}

TEST_CASE("S60 an array that 8 buffers do not hold: one error with need, limit and ways out") {
  const std::string text = refusal(some_scene(), some_device(767, 16));
  CHECK(text.find("needs 7 MiB") != std::string::npos);
  CHECK(text.find("takes 1 MiB in one buffer") != std::string::npos);
  CHECK(text.find("too large even in 8 buffers: triangles 6 MiB of at most 3 MiB") != std::string::npos);
  CHECK(text.find("nodes") == std::string::npos);
  CHECK(text.find("--device") != std::string::npos);
}

TEST_CASE("S60 arrays that fit one by one but not together are refused too") {
  const std::string text = refusal(some_scene(), some_device(6 << 10, 6));
  CHECK(text.find("needs 7 MiB") != std::string::npos);
  CHECK(text.find("which has 6 MiB") != std::string::npos);
  CHECK(text.find("too large even") == std::string::npos);
}

}  // namespace
