#include "host/render/row_stages.h"

#include <algorithm>
#include <utility>

#include "host/render/camera_arguments.h"
#include "host/render/standard_error.h"
#include "kernels/kernel_source.h"
#include "kernels/sampling/sky_rays.h"

namespace raycube::render {

static_assert(RC_PATH_PARTS == sensors::kSampleSubsets, "paths are summed by the parts of the samples");

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
      met_sky(context, pixels * elements.met_sky, cl::Access::read_write, "met sky"),
      glow(context, pixels * elements.glow, cl::Access::read_write, "light between surfaces"),
      path_log(context, std::max<std::size_t>(1, pixels * shape.path_steps), cl::Access::read_write, "steps of paths") {
}

std::vector<float> open_shares(const SceneBuffers& scene, const plan::Plan& plan, const StageShape& shape) {
  std::size_t surfaces = 0;
  for (const auto& page : scene.surfaces.pages) surfaces += page.size();
  std::vector<float> out(surfaces, 1.0f);
  for (std::size_t surface = 0; shape.sky_shadows && surface < out.size(); ++surface)
    out[surface] = plan.sky.known(surface);
  return out;
}

RowStages::RowStages(const cl::Context& context, const SceneBuffers& scene, const plan::Plan& plan,
                     const StageShape& shape, sensors::SampleWeights weights)
    : context_(context),
      scene_(scene),
      plan_(plan),
      shape_(shape),
      tile_(shape.arguments()),
      options_(program_options(shape, 0, context.device().info().is_cpu).rows + scene.options),
      identity_("rows\n" + options_ + "\n" + std::string(kernels::kernel_source("rows"))),
      program_(context.program("rows", kernels::kernel_source("rows"), options_)),
      shade_(*program_, "shade"),
      resolve_(*program_, "resolve"),
      integrate_(*program_, "integrate_bands"),
      weights_(std::move(weights)),
      sample_weight_(context, shape.tile().near, cl::Access::read_only, "sample weights"),
      irradiance_(context, plan.irradiance.value, cl::Access::read_only, "irradiance map"),
      tilt_irradiance_(context, plan.thermal.tilt_irradiance, cl::Access::read_only, "irradiance by tilt"),
      surface_node_(context, plan.thermal.surface_node, cl::Access::read_only, "temperatures of surfaces"),
      albedo_at_(context, plan.thermal.albedo_at, cl::Access::read_only, "albedo tables of lobes"),
      albedo_(context, plan.thermal.albedo, cl::Access::read_only, "albedos of lobes"),
      open_share_(context, open_shares(scene, plan, shape), cl::Access::read_only, "open share of surfaces"),
      no_list_(context, 1, cl::Access::read_only, "empty pixel list") {}

void RowStages::shade(const PixelSelection& pixels, const TileLayout& layout, const TraceBuffers& traced, int chunk,
                      int subset, bool fresh, RowBuffers& rows) {
  if (chunk != loaded_chunk_ || subset != loaded_subset_) {
    const std::size_t first = static_cast<std::size_t>(chunk) * shape_.chunk_samples;
    std::vector<float> padded =
        weights_.stretch(first, std::min<std::size_t>(shape_.chunk_samples, weights_.count() - first), subset);
    padded.resize(shape_.tile().near, 0.0f);
    context_.finish();  // a launch may still read the chunk before
    sample_weight_.write(padded);
    loaded_chunk_ = chunk, loaded_subset_ = subset;
  }
  const auto& s = plan_.sun_direction;
  shade_.arguments(ShadeArguments{.tile = tile_,
                                  .item_count = pixels.count,
                                  .pixel_list = pixels.list ? *pixels.list : no_list_,
                                  .use_list = cl_uint{pixels.list != nullptr},
                                  .capacity = static_cast<cl_uint>(rows.capacity),
                                  .fresh = cl_uint{fresh},
                                  .groups = traced.groups,
                                  .columns = layout.columns,
                                  .hits = traced.hits,
                                  .surface = traced.surface,
                                  .lift = traced.lift,
                                  .sun = traced.sun,
                                  .met_sky = traced.met_sky,
                                  .open_share = open_share_,
                                  .blocks = scene_.blocks,
                                  .surfaces = scene_.surfaces,
                                  .lobes = scene_.lobes,
                                  .chunk_weight = sample_weight_,
                                  .sample_total = static_cast<float>(weights_.count()),
                                  .sun_direction = shared::rc_float4{s[0], s[1], s[2], 0},
                                  .irradiance_map = irradiance_,
                                  .map_size = static_cast<cl_uint>(plan_.irradiance.size),
                                  .tilt_irradiance = tilt_irradiance_,
                                  .surface_node = surface_node_,
                                  .albedo_at = albedo_at_,
                                  .albedo = albedo_,
                                  .height_first = plan_.height.first,
                                  .height_step = plan_.height.step,
                                  .row_count = rows.count,
                                  .row_keys = rows.keys,
                                  .row_sums = rows.sums,
                                  .path_sums = rows.path,
                                  .truth = rows.truth});
  context_.launch(shade_, pixels.count);
  rows.subset = subset;
}

void RowStages::resolve(std::uint32_t first_item, std::uint32_t item_count, const PixelSelection& pixels,
                        const TileLayout& layout, const TraceBuffers& traced, const BandTable& table,
                        RowBuffers& rows) {
  // A pixel of few samples or paths has one part.
  const bool parts = rc_sky_parts(static_cast<rc_u32>(shape_.samples), static_cast<rc_u32>(plan_.paths())) > 1;
  resolve_.arguments(ResolveArguments{
      .tile = tile_,
      .first_item = first_item,
      .item_count = item_count,
      .pixel_list = pixels.list ? *pixels.list : no_list_,
      .use_list = cl_uint{pixels.list != nullptr},
      .capacity = static_cast<cl_uint>(rows.capacity),
      .term_capacity = static_cast<cl_uint>(rows.term_capacity),
      .groups = traced.groups,
      .columns = layout.columns,
      .row_count = rows.count,
      .row_keys = rows.keys,
      .row_sums = rows.sums,
      .path_sums = rows.path,
      .baked_keys = table.keys(),
      .baked_rows = table.rows(),
      .baked_count = table.count(),
      .view_first = plan_.view.first,
      .view_step = plan_.view.step,
      .path_x_first = plan_.path_x.first,
      .path_x_step = plan_.path_x.step,
      .path_y_first = plan_.path_y.first,
      .path_y_step = plan_.path_y.step,
      .environment_nodes = shape_.environment ? cl_uint{RC_ENVIRONMENT_NODES} : 0u,
      .environment_row = rows.environment_row,
      .environment_weight = rows.environment_weight,
      .glow = traced.glow,
      .glow_part =
          cl_uint{parts && rows.subset != sensors::kAllSamples ? static_cast<cl_uint>(rows.subset) : RC_PATH_PARTS},
      .glow_scale = parts ? static_cast<float>(1 / weights_.share_of(rows.subset)) : 1.0f,
      .glow_spread = static_cast<float>(spread_of_draws(shape_.sampler)),
      .skeleton_row = table.skeleton_row(),
      .skeleton_rows = shape_.bounces ? static_cast<cl_uint>(plan_.bounces.skeleton.size()) : 0u,
      .term_count = rows.term_count,
      .term_row = rows.term_row,
      .term_weight = rows.term_weight});
  context_.launch(resolve_, item_count);
}

void RowStages::integrate(std::uint32_t first_item, std::uint32_t item_count, const PixelSelection& pixels,
                          const BandTable& table, const RowBuffers& rows, cl::Buffer<float>& radiance) {
  integrate_.arguments(IntegrateBandsArguments{.first_item = first_item,
                                               .item_count = item_count,
                                               .pixel_list = pixels.list ? *pixels.list : no_list_,
                                               .use_list = cl_uint{pixels.list != nullptr},
                                               .term_capacity = static_cast<cl_uint>(rows.term_capacity),
                                               .term_count = rows.term_count,
                                               .term_row = rows.term_row,
                                               .term_weight = rows.term_weight,
                                               .words = static_cast<cl_uint>(shape_.bands_padded / RC_WORD),
                                               .table = table.values(),
                                               .radiance = radiance});
  context_.launch(integrate_, item_count);
}

}  // namespace raycube::render
