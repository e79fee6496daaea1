#include "host/render/lidar_renderer.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <map>
#include <memory>
#include <optional>

#include "host/base/doing.h"
#include "host/base/error.h"
#include "host/base/interrupt.h"
#include "host/base/memory.h"
#include "host/base/sha256.h"
#include "host/cl/kernel.h"
#include "host/lidar/apply_turbulence.h"
#include "host/render/lidar_arguments.h"
#include "host/render/lidar_beams.h"
#include "host/render/lidar_owners.h"
#include "host/render/lidar_tables.h"
#include "host/render/mapped.h"
#include "host/render/scene_on_device.h"
#include "kernels/kernel_source.h"
#include "kernels/lidar/layout.h"
#include "kernels/shared/tile_layout.h"

namespace raycube::render {

namespace {

/// More owners at once gain nothing: a launch of this size keeps every core busy for long.
constexpr std::size_t kMostBatchBytes = 96u << 20;

template <class T>
cl::Buffer<T> upload(const cl::Context& context, const std::vector<T>& from, const char* what) {
  if (from.empty()) return cl::Buffer<T>(context, std::vector<T>(4), cl::Access::read_only, what);
  return cl::Buffer<T>(context, from, cl::Access::read_only, what);
}

/// Tables on the device.
struct DeviceTables {
  DeviceTables(const cl::Context& context, const LidarTables& t)
      : samples(upload(context, t.samples, "sub-rays")),
        exits(upload(context, t.exits, "exits of sub-rays")),
        lobes(upload(context, t.lobes, "lobes")),
        photons(upload(context, t.photons, "photons")),
        node_weight(upload(context, t.node_weight, "nodes")),
        taps(upload(context, t.taps, "pulse")),
        settings(upload(context, t.settings, "settings")),
        plan(upload(context, t.plan, "counts")),
        air(upload(context, t.air, "air")),
        first_node(upload(context, t.first_node, "first nodes")),
        backscatter(upload(context, t.backscatter, "backscatter of the air")),
        volume_values(upload(context, t.volumes.values, "grids of volumes")),
        volume_depth(upload(context, t.volume_depth, "depths of gases")),
        volumes(upload(context, t.volumes.volumes, "volumes")),
        optics(upload(context, t.optics, "matter")) {}
  cl::Buffer<float> samples, exits;
  cl::Buffer<shared::Lobe> lobes;
  cl::Buffer<float> photons, node_weight, taps, settings;
  cl::Buffer<std::uint32_t> plan;
  cl::Buffer<float> air;
  cl::Buffer<std::uint32_t> first_node;
  cl::Buffer<float> backscatter, volume_values, volume_depth;
  cl::Buffer<shared::LidarVolume> volumes;
  cl::Buffer<shared::rc_float4> optics;
};

/// What a batch of owners leaves.
struct BatchBuffers {
  BatchBuffers(const cl::Context& context, const LidarTables& t, std::size_t owners, std::size_t lines,
               std::size_t padded_rays, bool with_hits)
      : shots(context, owners * RC_SHOT_FLOAT4S, cl::Access::read_only, "records of shots"),
        first(context, owners * t.floats_of_sum * t.owner_rows * t.row_floats, cl::Access::read_write, "rows of shots"),
        multiple(context, t.multiple ? owners * t.floats_of_sum * t.owner_rows * t.row_floats : 16,
                 cl::Access::read_write, "rows of shots, multiple scattering"),
        stopped(context, t.way ? owners * t.stopped_floats : 16, cl::Access::read_write, "shares of rays stopped"),
        scratch(context, t.way ? owners * t.scratch_floats : 16, cl::Access::read_write, "impulses of air"),
        way(context, t.way ? t.way_rows * owners * t.owner_rows * t.row_floats : 16, cl::Access::read_write,
            "rows of air and particles"),
        beams(context, t.way ? owners * RC_SHOT_FLOAT4S : 1, cl::Access::read_only, "records of beams"),
        beam_tables(context, t.way ? owners * (t.owner_rows / lines) * RC_BEAM_FLOATS : 16, cl::Access::read_write,
                    "tables of beams"),
        beam_of(context, t.way ? owners : 1, cl::Access::read_only, "beams of shots"),
        way_sums(context, t.way ? owners * lines * RC_SUM_COUNT * 2 : 2, cl::Access::read_write,
                 "sums of air and particles"),
        ledger(context, owners * lines * RC_LEDGER_COUNT, cl::Access::read_write, "ledger of shots"),
        sums(context, owners * lines * RC_SUM_COUNT * 2, cl::Access::read_write, "sums of shots"),
        counts(context, owners, cl::Access::read_write, "ray counts"),
        hits(context, with_hits ? owners * padded_rays * 2 : 2, cl::Access::read_write, "first hits") {}
  cl::Buffer<shared::rc_float4> shots;
  cl::Buffer<float> first, multiple, stopped, scratch, way;
  cl::Buffer<shared::rc_float4> beams;
  cl::Buffer<float> beam_tables;
  cl::Buffer<std::uint32_t> beam_of;
  cl::Buffer<float> way_sums;
  cl::Buffer<std::int64_t> ledger;
  cl::Buffer<float> sums;
  cl::Buffer<std::uint32_t> counts, hits;
};

LidarShotsArguments shots_arguments(const SceneBuffers& scene, const DeviceTables& device, const lidar::LidarPlan& plan,
                                    int cells, BatchBuffers& batch) {
  return {.nodes = scene.nodes,
          .blocks = scene.blocks,
          .instances = scene.instances,
          .shots = batch.shots,
          .samples = device.samples,
          .exits = device.exits,
          .optics = device.optics,
          .lobes = device.lobes,
          .photons = device.photons,
          .node_weight = device.node_weight,
          .first_node = device.first_node,
          .air = device.air,
          .volumes = device.volumes,
          .volume_values = device.volume_values,
          .volume_depth = device.volume_depth,
          .taps = device.taps,
          .settings = device.settings,
          .plan = device.plan,
          .bins = plan.lidar.gate.bins,
          .taps_used = plan.taps.taps,
          .first_tap = plan.taps.first,
          .phases = plan.taps.phases,
          .cells = cells,
          .first = batch.first,
          .multiple = batch.multiple,
          .stopped = batch.stopped,
          .ledger = batch.ledger,
          .sums = batch.sums,
          .counts = batch.counts,
          .first_hits = batch.hits,
          .seed = static_cast<std::uint32_t>(plan.seed)};
}

LidarBeamArguments beam_arguments(const DeviceTables& device, const lidar::LidarPlan& plan, BatchBuffers& batch) {
  return {.beams = batch.beams,
          .samples = device.samples,
          .exits = device.exits,
          .settings = device.settings,
          .plan = device.plan,
          .tables = batch.beam_tables,
          .bins = plan.lidar.gate.bins};
}

LidarAirArguments air_arguments(const DeviceTables& device, const lidar::LidarPlan& plan, BatchBuffers& batch) {
  return {.shots = batch.shots,
          .beam_of = batch.beam_of,
          .tables = batch.beam_tables,
          .backscatter = device.backscatter,
          .photons = device.photons,
          .node_weight = device.node_weight,
          .first_node = device.first_node,
          .air = device.air,
          .volumes = device.volumes,
          .volume_values = device.volume_values,
          .volume_depth = device.volume_depth,
          .taps = device.taps,
          .settings = device.settings,
          .plan = device.plan,
          .bins = plan.lidar.gate.bins,
          .taps_used = plan.taps.taps,
          .first_tap = plan.taps.first,
          .phases = plan.taps.phases,
          .cells = 0,
          .stopped = batch.stopped,
          .rows = batch.way,
          .scratch = batch.scratch,
          .sums = batch.way_sums};
}

/// One kernel, its own program.
struct Stage {
  Stage(const cl::Context& context, const std::string& name, const std::string& options)
      : program(context.program(name, kernels::kernel_source(name), options)), kernel(*program, name) {}
  std::shared_ptr<const cl::Program> program;
  cl::Kernel kernel;
};

}  // namespace

struct LidarRenderer::State : SceneOnDevice {
  using SceneOnDevice::SceneOnDevice;

  Stage& stage(const std::string& name, const std::string& build_options) {
    auto& entry = programs[name + build_options];
    if (!entry) entry = std::make_unique<Stage>(context, name, build_options);
    identity += name + build_options + "\n" + std::string(kernels::kernel_source(name));
    return *entry;
  }

  std::map<std::string, std::unique_ptr<Stage>> programs;
  std::string identity;
  double launch_s = 0;
  std::unique_ptr<BatchBuffers> batch;  ///< of the last render: fresh memory costs a page fault every 4 KiB
  std::vector<std::size_t> batch_shape;
};

namespace {

/// One launch: owners first .. first + count - 1, counted through all shots and pixels.
struct Batch {
  std::size_t first = 0, count = 0;
};

/// Shots in the making: an owner's rows are copied to their place when its batch is done.
class Collector {
 public:
  Collector(const lidar::LidarPlan& plan, const LidarTables& tables, const std::vector<lidar::Shot>& shots,
            const ShotSink& sink, bool hits)
      : plan_(plan),
        tables_(tables),
        shots_(shots),
        sink_(sink),
        hits_(hits),
        receiver_(plan.lidar.transport.sampling == scene::LidarSampling::receiver),
        owners_of_shot_(receiver_ ? static_cast<std::size_t>(plan.pixels()) : 1) {}
  std::size_t owners() const { return shots_.size() * owners_of_shot_; }
  std::size_t owners_of_shot() const { return owners_of_shot_; }

  void take(const cl::Context& context, const Batch& batch, BatchBuffers& from) {
    const Settled settled{context};
    const Mapped first(from.first), sums(from.sums);
    const Mapped ledger(from.ledger);
    const Mapped counts(from.counts);
    // A command to a device costs: nothing is asked for that is not there.
    std::optional<Mapped<float>> multiple, way, way_sums;
    std::optional<Mapped<std::uint32_t>> hits;
    if (tables_.multiple) multiple.emplace(from.multiple);
    if (tables_.way) way.emplace(from.way), way_sums.emplace(from.way_sums);
    if (hits_) hits.emplace(from.hits);
    for (std::size_t i = 0; i < batch.count; ++i) {
      const std::size_t owner = batch.first + i, shot = owner / owners_of_shot_, pixel = owner % owners_of_shot_;
      if (pixel == 0) begin(shots_[shot]);
      copy_rows(first.data(), tables_.floats_of_sum * i, result_.first);
      if (tables_.multiple) copy_rows(multiple->data(), tables_.floats_of_sum * i, result_.multiple);
      if (tables_.way) {
        if (tables_.air_rows) copy_rows(way->data(), tables_.way_rows * i, result_.air);
        if (tables_.way_rows > 1) {
          add_rows(way->data(), 2 * i + 1, pixel, result_.first);
          copy_rows(way->data(), 2 * i + 1, result_.particles);
        }
        add_sums(way_sums->data(), i);
      }
      add_ledger(ledger.data(), i);
      add_sums(sums.data(), i);
      result_.rays += counts.data()[i];
      if (hits_) copy_hits(hits->data(), i);
      if (pixel + 1 == owners_of_shot_) finish();
    }
  }

 private:
  void begin(const lidar::Shot& shot) {
    // What a sink leaves in its place is used again.
    result_.shot = shot;
    result_.first.clear(), result_.multiple.clear(), result_.air.clear(), result_.hits.clear();
    result_.particles.clear();
    result_.background_hz.clear();
    result_.rays = 0;
    const std::size_t floats = owners_of_shot_ * tables_.owner_rows * static_cast<std::size_t>(plan_.lidar.gate.bins);
    result_.first.reserve(floats);
    if (tables_.multiple) result_.multiple.reserve(floats);
    if (tables_.air_rows) result_.air.reserve(floats);
    if (tables_.way && tables_.way_rows > 1) result_.particles.reserve(floats);
    result_.ledger.assign(static_cast<std::size_t>(plan_.lines()), {});
  }
  /// Those of the next pixel.
  void copy_rows(const float* from, std::size_t owner, std::vector<float>& to) const {
    const auto bins = static_cast<std::ptrdiff_t>(plan_.lidar.gate.bins);
    for (std::size_t row = 0; row < tables_.owner_rows; ++row) {
      const float* const at = from + (owner * tables_.owner_rows + row) * tables_.row_floats + tables_.row_pad;
      to.insert(to.end(), at, at + bins);
    }
  }
  void add_rows(const float* from, std::size_t owner, std::size_t pixel, std::vector<float>& to) const {
    const auto bins = static_cast<std::size_t>(plan_.lidar.gate.bins);
    for (std::size_t row = 0; row < tables_.owner_rows; ++row) {
      const float* at = from + (owner * tables_.owner_rows + row) * tables_.row_floats + tables_.row_pad;
      for (std::size_t bin = 0; bin < bins; ++bin) to[(pixel * tables_.owner_rows + row) * bins + bin] += at[bin];
    }
  }
  void add_ledger(const std::int64_t* ledger, std::size_t owner) {
    const double unit = std::ldexp(1.0, -RC_LEDGER_BITS) / static_cast<double>(owners_of_shot_);
    for (std::size_t line = 0; line < result_.ledger.size(); ++line) {
      const std::int64_t* at = ledger + (owner * result_.ledger.size() + line) * RC_LEDGER_COUNT;
      lidar::Ledger& to = result_.ledger[line];
      to.absorbed += unit * static_cast<double>(at[RC_LEDGER_ABSORBED]);
      to.air += unit * static_cast<double>(at[RC_LEDGER_AIR]);
      to.volumes += unit * static_cast<double>(at[RC_LEDGER_VOLUMES]);
      to.escaped += unit * static_cast<double>(at[RC_LEDGER_ESCAPED]);
      to.truncated += unit * static_cast<double>(at[RC_LEDGER_TRUNCATED]);
    }
  }
  void add_sums(const float* sums, std::size_t owner) {
    for (std::size_t line = 0; line < result_.ledger.size(); ++line) {
      const float* at = sums + 2 * (owner * result_.ledger.size() + line) * RC_SUM_COUNT;
      const auto share = [&](int entry) {
        return plan_.photons[line] > 0 ? (static_cast<double>(at[2 * entry]) + at[2 * entry + 1]) / plan_.photons[line]
                                       : 0.0;
      };
      lidar::Ledger& to = result_.ledger[line];
      to.collected += share(RC_SUM_COLLECTED);
      to.early += share(RC_SUM_EARLY);
      to.late += share(RC_SUM_LATE);
      to.near += share(RC_SUM_NEAR);
    }
  }
  void copy_hits(const std::uint32_t* hits, std::size_t owner) {
    const std::size_t rays = plan_.footprint.a.size(), padded = RC_PADDED(rays);
    result_.hits.reserve(rays * owners_of_shot_);
    for (std::size_t k = 0; k < rays; ++k) {
      const std::uint32_t* at = hits + 2 * (owner * padded + k);
      result_.hits.push_back({at[0], at[1]});
    }
  }
  void finish() {
    lidar::apply_line_gain(plan_, result_);
    sink_(std::move(result_));
  }

  const lidar::LidarPlan& plan_;
  const LidarTables& tables_;
  const std::vector<lidar::Shot>& shots_;
  const ShotSink& sink_;
  bool hits_, receiver_;
  std::size_t owners_of_shot_;
  lidar::ShotResult result_;
};

std::size_t owner_bytes(const LidarTables& tables, std::size_t lines, std::size_t padded_rays, bool hits) {
  return tables.owner_rows * tables.row_floats * sizeof(float) *
             (tables.floats_of_sum * (tables.multiple ? 2 : 1) + (tables.way ? tables.way_rows : 0)) +
         (tables.way ? (tables.stopped_floats + tables.scratch_floats) * sizeof(float) +
                           tables.owner_rows / lines * RC_BEAM_FLOATS * sizeof(float) + RC_SHOT_FLOAT4S * 16
                     : 0) +
         RC_SHOT_FLOAT4S * sizeof(shared::rc_float4) + lines * (RC_LEDGER_COUNT * 8 + RC_SUM_COUNT * 8) +
         sizeof(std::uint32_t) + (hits ? padded_rays * 8 : 0);
}

}  // namespace

LidarRenderer::LidarRenderer(const scene::CompiledScene& scene, const RenderOptions& options)
    : state_(std::make_unique<State>(scene, options)) {}
LidarRenderer::~LidarRenderer() = default;
LidarRenderer::LidarRenderer(LidarRenderer&&) noexcept = default;

std::string LidarRenderer::device_name() const { return state_->context.device().name(); }
DeviceTuning LidarRenderer::tuning() const { return state_->used_tuning(); }
cl::Context& LidarRenderer::context() { return state_->context; }
std::string LidarRenderer::program_hash() const { return base::sha256_hex(state_->identity); }
double LidarRenderer::launch_s() const { return state_->launch_s; }

void LidarRenderer::render(const lidar::LidarPlan& plan, const std::vector<lidar::Shot>& shots, const ShotSink& sink,
                           bool hits) {
  const base::Doing doing("rendering LIDAR", plan.lidar.name);
  State& s = *state_;
  s.launch_s = 0;
  if (shots.empty()) return;
  const bool apart =
      std::any_of(shots.begin(), shots.end(), [](const lidar::Shot& shot) { return shot.exit_m != shot.pupil_m; });
  const LidarTables tables = make_lidar_tables(plan, s.scene, apart, hits);
  s.identity.clear();
  Stage& stage = s.stage("lidar_shots", tables.shot_options + s.buffers.options);
  Stage* air_stage = tables.way ? &s.stage("lidar_air", tables.air_options) : nullptr;
  Stage* beam_stage = tables.way ? &s.stage("lidar_beam", tables.beam_options) : nullptr;
  LidarBeams beams(plan);
  std::vector<shared::rc_float4> tabulated;  ///< beams whose tables are on the device
  std::vector<std::uint32_t> beam_of;
  const DeviceTables device(s.context, tables);
  Collector collector(plan, tables, shots, sink, hits);

  const auto lines = static_cast<std::size_t>(plan.lines());
  const std::size_t padded_rays = RC_PADDED(plan.footprint.a.size()),
                    bytes = owner_bytes(tables, lines, padded_rays, hits);
  const auto& info = s.context.device().info();
  const std::size_t row_bytes = tables.floats_of_sum * tables.owner_rows * tables.row_floats * sizeof(float);
  const std::size_t budget = std::min<std::size_t>(s.tile_budget(), info.max_alloc_bytes * (bytes / row_bytes));
  if (bytes > budget)
    throw base::Error(base::Fault::input,
                      "LIDAR '" + plan.lidar.name + "': one shot needs " + base::format_bytes(bytes) +
                          " on the device for its rows (" + std::to_string(plan.pixels()) + " pixels, " +
                          std::to_string(plan.lines()) + " lines, " + std::to_string(plan.lidar.gate.bins) +
                          " bins), found " + base::format_bytes(budget) +
                          "; give more --memory, a shorter gate, or sampling = \"receiver\" for arrays");
  const std::size_t owners =
      std::min(collector.owners(), std::max<std::size_t>(1, std::min(budget, kMostBatchBytes) / bytes));
  const std::vector<std::size_t> shape{owners,
                                       tables.owner_rows,
                                       tables.row_floats,
                                       tables.multiple ? tables.floats_of_sum : 0,
                                       tables.floats_of_sum,
                                       tables.way ? tables.way_rows : 0,
                                       lines,
                                       hits ? padded_rays : 0,
                                       tables.scratch_floats};
  if (!s.batch || s.batch_shape != shape) {
    s.batch.reset();
    s.batch = std::make_unique<BatchBuffers>(s.context, tables, owners, lines, padded_rays, hits);
    s.batch_shape = shape;
  }
  BatchBuffers& batch_buffers = *s.batch;

  std::vector<shared::rc_float4> records;
  for (Batch batch{0, 0}; batch.first < collector.owners(); batch.first += batch.count) {
    base::throw_if_interrupted();
    batch.count = std::min(owners, collector.owners() - batch.first);
    records.clear();
    for (std::size_t i = batch.first; i < batch.first + batch.count; ++i)
      append_owner(plan, s.scene, shots[i / collector.owners_of_shot()],
                   static_cast<int>(i % collector.owners_of_shot()), records);
    batch_buffers.shots.write(records);
    if (tables.way) {
      beams.clear();
      beam_of.clear();
      for (std::size_t i = batch.first; i < batch.first + batch.count; ++i)
        beam_of.push_back(
            beams.number(shots[i / collector.owners_of_shot()], static_cast<int>(i % collector.owners_of_shot())));
      batch_buffers.beam_of.write(beam_of);
      batch_buffers.beams.write(beams.records());
    }
    stage.kernel.arguments(shots_arguments(s.buffers, device, plan, tables.cells, batch_buffers));
    s.context.finish();
    const auto start = std::chrono::steady_clock::now();
    s.context.launch(stage.kernel, batch.count);
    if (air_stage) {
      if (tabulated.size() != beams.records().size() ||
          std::memcmp(tabulated.data(), beams.records().data(), tabulated.size() * sizeof tabulated[0]) != 0) {
        beam_stage->kernel.arguments(beam_arguments(device, plan, batch_buffers));
        s.context.launch(beam_stage->kernel, beams.size());
        tabulated = beams.records();
      }
      air_stage->kernel.arguments(air_arguments(device, plan, batch_buffers));
      s.context.launch(air_stage->kernel, batch.count);
    }
    s.context.finish();
    s.launch_s += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    collector.take(s.context, batch, batch_buffers);
  }
}

}  // namespace raycube::render
