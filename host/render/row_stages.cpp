#include "host/render/row_stages.h"

#include <algorithm>
#include <utility>

#include "kernels/kernel_source.h"

namespace raycube::render {

RowBuffers::RowBuffers(const cl::Context& context, const StageShape& shape, std::size_t items_, std::size_t capacity_)
    : items(items_),
      capacity(capacity_),
      term_capacity(shape.term_capacity(capacity_)),
      elements(shape.rows(capacity_)),
      count(context, items_, cl::Access::read_write, "key counts"),
      keys(context, items_ * elements.keys, cl::Access::read_write, "product keys"),
      sums(context, items_ * elements.sums, cl::Access::read_write, "row sums"),
      path(context, items_ * elements.path, cl::Access::read_write, "path sums"),
      truth(context, items_ * elements.truth, cl::Access::read_write, "truth sums"),
      environment_row(context, shape.environment ? items_ * RC_ENVIRONMENT_NODES : 1, cl::Access::read_only,
                      "rows of the environment"),
      environment_weight(context, shape.environment ? items_ * RC_ENVIRONMENT_NODES : 1, cl::Access::read_only,
                         "weights of the environment"),
      term_count(context, items_, cl::Access::read_write, "term counts"),
      term_row(context, items_ * term_capacity, cl::Access::read_write, "term rows"),
      term_weight(context, items_ * term_capacity, cl::Access::read_write, "term weights") {}

TraceBuffers::TraceBuffers(const cl::Context& context, const StageShape& shape, std::size_t pixels,
                           std::size_t group_count)
    : elements(shape.tile()),
      groups(context, group_count, cl::Access::read_only, "ray groups"),
      hits(context, pixels * elements.hits, cl::Access::read_write, "hits"),
      surface(context, pixels * elements.surface, cl::Access::read_write, "surface points"),
      lift(context, pixels * elements.lift, cl::Access::read_write, "lifts of surface points"),
      sun(context, pixels * elements.sun, cl::Access::read_write, "sun visibility"),
      sky(context, pixels * elements.sky, cl::Access::read_write, "blocked sky") {}

RowStages::RowStages(const cl::Context& context, const SceneBuffers& scene, const plan::Plan& plan,
                     const StageShape& shape, sensors::SampleWeights weights)
    : context_(context),
      scene_(scene),
      plan_(plan),
      shape_(shape),
      options_(program_options(shape, 0).rows + scene.options),
      identity_("rows\n" + options_ + "\n" + std::string(kernels::kernel_source("rows"))),
      program_(context, "rows", kernels::kernel_source("rows"), options_),
      shade_(program_, "shade"),
      resolve_(program_, "resolve"),
      integrate_(program_, "integrate_bands"),
      weights_(std::move(weights)),
      sample_weight_(context, shape.tile().padded, cl::Access::read_only, "sample weights"),
      irradiance_(context, plan.irradiance.value, cl::Access::read_only, "irradiance map"),
      tilt_irradiance_(context, plan.thermal.tilt_irradiance, cl::Access::read_only, "irradiance by tilt"),
      surface_node_(context, plan.thermal.surface_node, cl::Access::read_only, "temperatures of surfaces"),
      no_list_(context, 1, cl::Access::read_only, "empty pixel list") {}

void RowStages::shade(const PixelSelection& pixels, const TileLayout& layout, const TraceBuffers& traced, int chunk,
                      int subset, bool fresh, RowBuffers& rows) {
  if (chunk != loaded_chunk_ || subset != loaded_subset_) {
    const std::size_t first = static_cast<std::size_t>(chunk) * shape_.chunk_samples;
    std::vector<float> padded =
        weights_.stretch(first, std::min<std::size_t>(shape_.chunk_samples, weights_.count() - first), subset);
    padded.resize(shape_.tile().padded, 0.0f);
    context_.finish();  // a launch may still read the chunk before
    sample_weight_.write(padded);
    loaded_chunk_ = chunk, loaded_subset_ = subset;
  }
  const auto& s = plan_.sun_direction;
  shade_.arguments(pixels.count, pixels.list ? *pixels.list : no_list_, cl_uint{pixels.list != nullptr},
                   static_cast<cl_uint>(rows.capacity), static_cast<cl_uint>(fresh), traced.groups, layout.columns,
                   traced.hits, traced.surface, traced.lift, traced.sun, traced.sky, scene_.blocks, scene_.surfaces,
                   sample_weight_, static_cast<float>(weights_.count()), shared::rc_float4{s[0], s[1], s[2], 0},
                   irradiance_, static_cast<cl_uint>(plan_.irradiance.size), tilt_irradiance_, surface_node_,
                   plan_.height.first, plan_.height.step, rows.count, rows.keys, rows.sums, rows.path, rows.truth);
  context_.launch(shade_, pixels.count);
}

void RowStages::resolve(std::uint32_t first_item, std::uint32_t item_count, const PixelSelection& pixels,
                        const TileLayout& layout, const TraceBuffers& traced, const BandTable& table,
                        RowBuffers& rows) {
  resolve_.arguments(first_item, item_count, pixels.list ? *pixels.list : no_list_, cl_uint{pixels.list != nullptr},
                     static_cast<cl_uint>(rows.capacity), static_cast<cl_uint>(rows.term_capacity), traced.groups,
                     layout.columns, rows.count, rows.keys, rows.sums, rows.path, table.keys(), table.rows(),
                     cl_uint{table.count()}, plan_.view.first, plan_.view.step, plan_.path_x.first, plan_.path_x.step,
                     plan_.path_y.first, plan_.path_y.step, rows.environment_row, rows.environment_weight,
                     rows.term_count, rows.term_row, rows.term_weight);
  context_.launch(resolve_, item_count);
}

void RowStages::integrate(std::uint32_t first_item, std::uint32_t item_count, const PixelSelection& pixels,
                          const BandTable& table, const RowBuffers& rows, cl::Buffer<float>& radiance) {
  integrate_.arguments(first_item, item_count, pixels.list ? *pixels.list : no_list_, cl_uint{pixels.list != nullptr},
                       static_cast<cl_uint>(rows.term_capacity), rows.term_count, rows.term_row, rows.term_weight,
                       table.values(), radiance);
  context_.launch(integrate_, item_count);
}

}  // namespace raycube::render
