// The layout of a tile's buffers as kernels compute it from their arguments, against the host's own sizes; and what
// argument lists refuse.
#include <doctest/doctest.h>

#include <cstdint>
#include <string>
#include <type_traits>
#include <vector>

#include "host/base/error.h"
#include "host/cl/kernel.h"
#include "host/render/camera_arguments.h"
#include "host/render/tile_shape.h"
#include "kernels/kernel_source.h"
#include "tests/support/probes.h"

namespace {

using namespace raycube;

render::StageShape shape_of(int chunk_samples, int chunks, int components, int thermal, int heights) {
  render::StageShape shape;
  shape.samples_u = chunk_samples, shape.samples_v = chunks, shape.samples = chunk_samples * chunks;
  shape.chunk_samples = chunk_samples, shape.chunks = chunks;
  shape.components = components, shape.thermal_components = thermal, shape.temperatures = thermal ? 3 : 0;
  shape.heights = heights;
  shape.bands = 7, shape.bands_padded = 16;
  return shape;
}

render::StageShape two_sided(render::StageShape shape) {
  shape.matter.through = true;
  shape.matter.shaped = true;
  return shape;
}

}  // namespace

TEST_CASE("tile layout: kernels and host agree on planes, strides and sizes, whatever the shape") {
  for (cl::Device& device : cl::list_devices()) {
    const cl::Context context(std::move(device));
    for (const render::StageShape& shape :
         {shape_of(121, 1, 4, 0, 2), two_sided(shape_of(121, 1, 4, 0, 2)), shape_of(16, 3, 0, 0, 1),
          shape_of(7, 1, 5, 1, 3), shape_of(1000, 2, 8, 4, 5)}) {
      CAPTURE(shape.chunk_samples);
      const auto program = test::probes(context, render::matter_options(shape.matter));
      cl::Kernel kernel(*program, "probe_layout");
      cl::Buffer<std::uint64_t> found(context, 19, cl::Access::read_write, "layout");
      kernel.arguments(shape.arguments(), found);
      context.launch(kernel, 1);
      const shared::TileElements tile = shape.tile();
      const shared::RowElements rows = shape.rows(16);
      const std::size_t slot = tile.padded - 3;
      const std::vector<std::uint64_t> expected{
          tile.padded,
          tile.near / 16,
          3 * tile.hits,
          3 * tile.surface,
          3 * tile.lift,
          3 * tile.sun,
          3 * tile.met_sky,
          rows.sums_of_key,
          3 * rows.sums,
          3 * rows.path,
          3 * rows.truth,
          static_cast<std::uint64_t>((3 * RC_PATH_PARTS + 2) * (1 + shape.lamps) * shape.skeleton_padded()),
          3 * 3 + 7 / 4,  // pixel 7 of line 3, three groups a line
          tile.hits_at(RC_HIT_PRIMITIVE, 5),
          tile.surface_at(RC_NORMAL_Z, slot),
          tile.met_sky_at(1, slot),
          slot % tile.near,
          shape.matter.through ? RC_FAR_SIDE : RC_NEAR_SIDE,
          slot};
      CHECK(found.read_all() == expected);
    }
  }
}

TEST_CASE("tile layout: bytes of a pixel are those of its buffers") {
  const shared::TileElements tile(121, RC_SKY_PLANES_OF(5));
  CHECK(tile.padded == 128);
  const shared::TileElements sides(121, RC_SKY_PLANES_OF(5), false, 2);
  CHECK(sides.near == 128);
  CHECK(sides.bytes() == 2 * tile.bytes() - 128 * 2 * 4);  // hits are of the near side alone
  CHECK(tile.bytes() == 128 * (2 + 6 + 1 + 8) * 4 + 128 / 16 * 2);
  const shared::RowElements plain(16, 11, 2, false), carried(16, 11, 2, true);
  CHECK(plain.row_bytes() == 4 + 16 * (8 + 11 * 4));
  CHECK(carried.row_bytes() == 4 + 16 * (8 + 2 * 11 * 4));
  CHECK(carried.pixel_bytes() == 2 * (2 + 8) * 4);
}

TEST_CASE("argument lists: another type, a constant buffer to write, or nothing at all does not compile") {
  static_assert(std::is_constructible_v<cl::Value<shared::rc_uint>, std::uint32_t>);
  static_assert(!std::is_constructible_v<cl::Value<shared::rc_uint>, float>);
  static_assert(!std::is_constructible_v<cl::Value<shared::rc_uint>, std::int32_t>);
  static_assert(!std::is_constructible_v<cl::Value<shared::rc_uint>, bool>);
  static_assert(!std::is_constructible_v<cl::Value<shared::rc_float>, double>);
  static_assert(std::is_constructible_v<cl::Read<shared::rc_float>, const cl::Buffer<float>&>);
  static_assert(!std::is_constructible_v<cl::Read<shared::rc_float>, const cl::Buffer<std::uint32_t>&>);
  static_assert(!std::is_constructible_v<cl::Write<shared::rc_float>, const cl::Buffer<float>&>);
  static_assert(!std::is_default_constructible_v<cl::Value<shared::rc_uint>>);
  static_assert(!std::is_default_constructible_v<render::ShadeArguments>);
  static_assert(std::is_aggregate_v<render::ShadeArguments>);  // given by name, in the list's order
}

TEST_CASE("argument lists: those of another kernel are refused") {
  for (cl::Device& device : cl::list_devices()) {
    const cl::Context context(std::move(device));
    const cl::Program program(
        context, "rows", kernels::kernel_source("rows"),
        render::program_options(shape_of(16, 1, 0, 0, 1), 92, context.device().info().is_cpu).rows);
    cl::Kernel kernel(program, "resolve");
    const cl::Buffer<float> numbers(context, 1, cl::Access::read_only, "numbers");
    const cl::Buffer<std::uint32_t> counts(context, 1, cl::Access::read_only, "counts");
    cl::Buffer<float> radiance(context, 1, cl::Access::read_write, "radiance");
    const render::IntegrateBandsArguments other{.first_item = 0u,
                                                .item_count = 1u,
                                                .pixel_list = counts,
                                                .use_list = 0u,
                                                .term_capacity = 1u,
                                                .term_count = counts,
                                                .term_row = counts,
                                                .term_weight = numbers,
                                                .words = 1u,
                                                .table = numbers,
                                                .radiance = radiance};
    CHECK_THROWS_WITH_AS(kernel.arguments(other),
                         doctest::Contains("'resolve' is given arguments of 'integrate_bands'"), base::Error);
  }
}
