#include "host/run/lidar_products.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <limits>
#include <optional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/base/error.h"
#include "host/base/interrupt.h"
#include "host/base/sha256.h"
#include "host/base/version.h"
#include "host/base/units.h"
#include "host/run/laz.h"
#include "host/run/lidar_csv.h"
#include "host/run/python_chart.h"
#include "host/lidar/return_truth.h"
#include "host/lidar/scan_line.h"
#include "host/lidar/shot.h"
#include "host/products/las_writer.h"
#include "host/products/map_grid.h"
#include "host/products/time_cube.h"
#include "scene_compiler/matter.h"

namespace raycube::run {
namespace {

using Json = nlohmann::ordered_json;
constexpr const char* kPictures[] = {"waveforms.png", "ranges.png", "points.png"};
constexpr int kDescriptorRoom = 255;  ///< all LAS has; full scales are powers of two, so that no run needs more

/// Bin width in whole picoseconds, which is all LAS can say; 0: it is not whole.
std::uint32_t spacing_ps(const scene::LidarGate& gate) {
  const double ps = gate.bin_s * 1e12, whole = std::round(ps);
  return whole >= 1 && whole < 4294967296.0 && std::abs(ps - whole) < 1e-6 * whole ? static_cast<std::uint32_t>(whole)
                                                                                   : 0;
}

/// Step of coordinates that holds whatever a gate may hold: 0.1 mm, or as much coarser by powers of ten as it takes. By
/// ends of the gate as pulses all along the survey have them, and a twentieth more; by a sphere about the flight where
/// most of these are not fired.
double las_scale_m(const lidar::LidarPlan& plan, std::uint64_t seed) {
  const scene::Lidar& lidar = plan.lidar;
  constexpr std::int64_t kPulses = 512;
  const double per_s = 0.5 * base::kLightSpeed_m_s / lidar.transport.group_index,
               begin_m = std::max(0.0, per_s * lidar.gate.start_s),
               end_m = per_s * (lidar.gate.start_s + lidar.gate.bins * lidar.gate.bin_s);
  double farthest_m = 0;
  std::int64_t seen = 0;
  for (std::int64_t i = 0; i < std::min(kPulses, lidar.pulses); ++i) {
    const std::int64_t pulse =
        std::llround(static_cast<double>(i) * static_cast<double>(lidar.pulses - 1) /
                     static_cast<double>(std::max<std::int64_t>(1, std::min(kPulses, lidar.pulses) - 1)));
    for (const auto& shot : lidar::make_shots(lidar, pulse, 1, seed)) {
      ++seen;
      for (const int pixel : {0, plan.pixels() - 1})
        for (const double range_m : {begin_m, end_m})
          for (const double at : lidar::apparent_point(plan, shot, pixel, range_m))
            if (std::isfinite(at)) farthest_m = std::max(farthest_m, std::abs(at));
    }
  }
  if (2 * seen < std::min(kPulses, lidar.pulses))
    for (const auto& pose : lidar.trajectory)
      farthest_m = std::max(farthest_m, std::hypot(pose.x_m, pose.y_m, pose.z_m) + end_m);
  double scale_m = 1e-4;
  while (1.05 * farthest_m > 2147483647.0 * scale_m) scale_m *= 10;
  return scale_m;
}

/// Unit vector along which a pixel's returns move away.
lidar::Vec3 sight(const lidar::LidarPlan& plan, const lidar::Shot& shot, int pixel, double range_m) {
  const lidar::Vec3 near = lidar::apparent_point(plan, shot, pixel, range_m),
                    far = lidar::apparent_point(plan, shot, pixel, range_m + 1);
  lidar::Vec3 d = {far[0] - near[0], far[1] - near[1], far[2] - near[2]};
  const double length = std::hypot(d[0], d[1], d[2]);
  for (double& c : d) c /= length;
  return d;
}

}  // namespace

struct LidarProducts::State {
  State(const std::string& folder_, base::IfExists if_exists_, const scene::Simulation& simulation_,
        const lidar::LidarPlan& plan_)
      : folder(folder_),
        if_exists(if_exists_),
        simulation(simulation_),
        plan(plan_),
        lidar(plan_.lidar),
        volumes(lidar::flatten_volumes(simulation_.scene.volumes)),
        set(folder_, if_exists) {
    set.hash_blocks();
    const auto& wanted = lidar.products;
    if (wanted.cube) cube_data = &set.add("waveforms.img"), cube_text = &set.add("waveforms.hdr");
    if (wanted.laz) python = laz_python();
    if (wanted.las || wanted.laz) begin_las();
    if (wanted.laz) refuse_early("returns.laz");
    if (wanted.csv) tables.emplace(set, simulation, plan);
    if (wanted.png)
      for (const char* name : kPictures) refuse_early(name);
  }

  /// A file that is begun after the run: refused now where it exists.
  void refuse_early(const char* name) const {
    base::OutputFile((std::filesystem::path(folder) / name).string(), if_exists);
  }

  void begin_las() {
    bool waveforms = lidar.products.waveforms;
    if (waveforms && spacing_ps(lidar.gate) == 0) {
      warnings.push_back(fmt::format(
          "the points have no waveforms: LAS wants bins of whole picoseconds (found {:.9g} ps); the time cube has them",
          lidar.gate.bin_s * 1e12));
      waveforms = false;
    }
    const auto scratch = [this](std::unique_ptr<base::OutputFile>& file, const char* name) {
      file =
          std::make_unique<base::OutputFile>((std::filesystem::path(folder) / name).string(), base::IfExists::replace);
      return file.get();
    };
    las_file = lidar.products.las ? &set.add("returns.las") : scratch(scratch_points, ".returns.las");
    base::OutputFile& points = *las_file;
    base::OutputFile* packets = nullptr;
    if (waveforms && lidar.products.internal_waveforms)
      packets = scratch(scratch_packets, ".returns.packets");
    else if (waveforms)
      packets = waveform_file = &set.add("returns.wdp");
    const auto& origin = simulation.scene.origin;
    products::LasOptions options;
    options.scale_m = las_scale_m(plan, simulation.seed);
    options.source_id = static_cast<std::uint16_t>(lidar.strip);
    options.offset_m = {origin.easting_m, origin.northing_m, origin.height_m};
    if (origin.epsg != 0) options.wkt = products::projected_wkt(origin.epsg);
    options.descriptor_room = waveforms ? kDescriptorRoom : 0;
    options.internal_packets = lidar.products.internal_waveforms;
    options.system_id = "simulated " + lidar.name;
    options.software = std::string("raycube ") + base::kVersion;
    const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
    std::tm utc{};
    gmtime_r(&now, &utc);
    options.creation_day = utc.tm_yday + 1;
    options.creation_year = utc.tm_year + 1900;
    options.intensity_from_energy = true;
    las.emplace(points, packets, options);
    las_waveforms = waveforms;
  }

  void begin_cube(const lidar::ShotResult& result) {
    std::vector<products::TimeCubeBand> bands;
    for (std::size_t l = 0; l < lidar.pulse.lines.size(); ++l) {
      const std::string name = line_name(lidar, static_cast<int>(l));
      const double um = lidar.pulse.lines[l].wavelength_um;
      if (lidar.products.orders) {
        bands.push_back({name + " once scattered [photons]", um});
        if (!result.multiple.empty()) bands.push_back({name + " scattered more often [photons]", um});
        if (!result.air.empty()) bands.push_back({name + " air [photons]", um});
      } else {
        bands.push_back({name + " expected [photons]", um});
      }
      if (detected) bands.push_back({name + " recorded [photo-electrons]", um});
    }
    cube.emplace(*cube_data, *cube_text,
                 products::TimeCubeAxis{lidar.gate.start_s, lidar.gate.bin_s, lidar.gate.bins,
                                        lidar.transport.group_index, plan.pixels()},
                 bands);
  }

  /// A pixel's bands, line by line, into `values`.
  void collect(const lidar::ShotResult& r, const std::vector<lidar::Detection>& detections, int pixel) {
    const auto bins = static_cast<std::size_t>(lidar.gate.bins), lines = static_cast<std::size_t>(plan.lines());
    values.clear();
    for (std::size_t l = 0; l < lines; ++l) {
      const std::size_t record = static_cast<std::size_t>(pixel) * lines + l, at = record * bins;
      const auto append = [&](const std::vector<float>& row) {
        if (!row.empty())
          values.insert(values.end(), row.begin() + static_cast<std::ptrdiff_t>(at),
                        row.begin() + static_cast<std::ptrdiff_t>(at + bins));
      };
      append(r.first);
      if (lidar.products.orders) {
        append(r.multiple);
        append(r.air);
      } else {
        float* const sum = values.data() + values.size() - bins;
        for (const auto* more : {&r.multiple, &r.air})
          if (!more->empty())
            for (std::size_t i = 0; i < bins; ++i) sum[i] += (*more)[at + i];
      }
      if (detected) {
        const auto& recorded = detections[record].waveform_pe;
        if (recorded.size() != bins)
          throw base::Error(base::Fault::bug,
                            fmt::format("a record of {} bins in a gate of {}", recorded.size(), bins));
        values.insert(values.end(), recorded.begin(), recorded.end());
      }
    }
  }

  void add_record(const lidar::ShotResult& result, const lidar::Detection& d,
                  const std::vector<lidar::ReturnTruth>& truth) {
    products::LasPacket packet;
    if (las_waveforms) {
      const int kind =
          las->descriptor({16, static_cast<std::uint32_t>(lidar.gate.bins), spacing_ps(lidar.gate), d.gain, d.offset});
      packet = las->add_packet(kind, d.samples);
    }
    lidar::ReturnTruth unknown;
    unknown.range_m = std::numeric_limits<double>::quiet_NaN();
    for (std::size_t i = 0; i < d.echoes.size(); ++i) {
      const auto& behind = truth.empty() ? unknown : truth[i];
      const auto at = lidar::apparent_point(plan, result.shot, d.pixel, d.echoes[i].range_m);
      if (las) add_point(result.shot, d, d.echoes[i], at, behind, packet);
      if (tables) tables->add_return(result.shot, d, d.echoes[i], at, behind);
      const double hashed[] = {d.echoes[i].time_s, d.echoes[i].energy_pe};
      digest.add(hashed, sizeof hashed);
      ++returns;
    }
    const double steps[] = {d.gain, d.offset};
    digest.add(steps, sizeof steps);
    if (!waveform_file) digest.add(d.samples.data(), d.samples.size() * sizeof(std::uint16_t));
    if (tables) tables->add_photons(d);
    record_count += 1;
    empty_records += d.echoes.empty();
  }

  void add_point(const lidar::Shot& shot, const lidar::Detection& d, const lidar::Echo& echo, const lidar::Vec3& at,
                 const lidar::ReturnTruth& behind, const products::LasPacket& packet) {
    const auto& origin = simulation.scene.origin;
    products::LasPoint p;
    p.x_m = origin.easting_m + at[0], p.y_m = origin.northing_m + at[1], p.z_m = origin.height_m + at[2];
    p.number_of_returns = std::clamp(echo.of, 1, 15);
    p.return_number = std::clamp(echo.number, 1, p.number_of_returns);
    p.scanner_channel = std::min(d.line, 3);
    p.user_data = static_cast<std::uint8_t>(std::min(d.line, 255));
    p.classification = static_cast<std::uint8_t>(las_class_of(simulation, lidar, echo, behind));
    p.withheld = echo.cut;
    p.scan_to_right = line.to_right();
    p.scan_angle_deg = std::remainder(base::deg_from_rad(shot.scan_angle_rad), 360.0);
    p.source_id = static_cast<std::uint16_t>(lidar.strip);
    p.gps_time_s = lidar.gps_start_s + shot.time_s;
    p.packet = packet;
    // Samples stand for the middles of their bins.
    p.return_location_ps = static_cast<float>((echo.time_s - lidar.gate.start_s - 0.5 * lidar.gate.bin_s) * 1e12);
    p.direction_m_per_ps =
        products::las_direction(sight(plan, shot, d.pixel, echo.range_m), lidar.transport.group_index);
    auto& t = p.truth;
    t.pulse_id = static_cast<std::uint64_t>(shot.pulse);
    t.range_m = echo.range_m;
    t.range_true_m = behind.range_m;
    t.expected_pe = behind.expected_pe;
    t.echo_fwhm_ns = echo.fwhm_s * 1e9f;
    t.detection_probability = echo.detection_probability;
    t.bounce_order = static_cast<std::uint8_t>(behind.order);
    t.object_id = behind.object;
    t.material_id = behind.material == RC_NONE ? products::LasTruth::kNoMaterial
                                               : static_cast<std::uint16_t>(named[behind.material]);
    t.incidence_deg = behind.incidence_deg;
    t.gff = behind.overlap;
    t.transmission_2way = behind.transmission_2way;
    t.subray_fraction = behind.subray_share;
    t.pixel = static_cast<std::uint32_t>(d.pixel);
    t.energy_pe = echo.energy_pe;
    t.pulses_back = static_cast<std::int16_t>(behind.pulses_back);
    last_points.push_back(p);
  }

  /// Points wait for the next pulse that has some: it tells whether they end a line of the scan.
  void flush_points(bool end_of_line) {
    for (products::LasPoint& p : last_points) {
      p.edge_of_line = end_of_line;
      las->add_point(p);
    }
    last_points.clear();
  }

  void add(const lidar::ShotResult& result, const std::vector<lidar::Detection>& detections,
           const std::vector<std::vector<lidar::ReturnTruth>>& truth) {
    static const std::vector<lidar::ReturnTruth> kNone;
    const std::size_t records = static_cast<std::size_t>(plan.pixels()) * static_cast<std::size_t>(plan.lines());
    if (!detections.empty() && detections.size() != records)
      throw base::Error(base::Fault::bug, fmt::format("{} records came of a shot with {}", detections.size(), records));
    if (shots == 0) {
      detected = !detections.empty();
      if (cube_data) begin_cube(result);
    } else if (detected == detections.empty()) {
      throw base::Error(base::Fault::bug, "shots with and without records in one run");
    }
    const std::uint64_t before = returns;
    if (line.next(result.shot.pulse)) flush_points(true);
    const std::size_t waiting = last_points.size();
    for (int pixel = 0; pixel < plan.pixels(); ++pixel) {
      if (cube || !detected) collect(result, detections, pixel);
      if (!detected) digest.add(values.data(), values.size() * sizeof(float));
      if (cube) cube->add(values);
      for (int l = 0; detected && l < plan.lines(); ++l) {
        const auto record = static_cast<std::size_t>(pixel * plan.lines() + l);
        add_record(result, detections[record], truth.empty() ? kNone : truth[record]);
      }
    }
    if (tables) tables->add_shot(result, detections, static_cast<std::int64_t>(shots) * plan.pixels());
    without_return += returns == before;
    if (last_points.size() > waiting && waiting > 0) {  // the pulse before ends no line
      std::vector<products::LasPoint> own(last_points.begin() + static_cast<std::ptrdiff_t>(waiting),
                                          last_points.end());
      last_points.resize(waiting);
      flush_points(false);
      last_points = std::move(own);
    }
    ++shots;
    rays += static_cast<std::uint64_t>(result.rays);
  }

  /// The points as they are now, compressed. Where that fails (a full disk) a warning: a run that is whole is not lost,
  /// and its points are there uncompressed.
  void compress(products::RunRecord& record, const std::string& what) {
    const std::string packed = las_file->temporary_path() + ".laz";
    struct Remove {
      const std::string& path;
      ~Remove() { std::remove(path.c_str()); }
    } remove{packed};
    las_file->sync();
    try {
      write_laz(python, las_file->temporary_path(), packed);
    } catch (const base::Error& error) {
      base::throw_if_interrupted();
      record.warnings.push_back(std::string("no returns.laz: ") + error.what());
      if (lidar.products.las) return;
      append_drawn(set.add("returns.las"), las_file->temporary_path());
      record.files.emplace_back("returns.las", what);
      return;
    }
    append_drawn(set.add("returns.laz"), packed);
    record.files.emplace_back("returns.laz", what + ", compressed (LAZ)");
  }

  /// What the pictures need to know besides the files.
  Json picture_facts() const {
    Json j = {{"title", lidar.name},
              {"pixels", plan.pixels()},
              {"columns", lidar.receiver.columns},
              {"rows", lidar.receiver.rows},
              {"quantum_efficiency", lidar.receiver.quantum_efficiency},
              {"prf_hz", lidar.prf_hz},
              {"scan_rate_hz", lidar.scan.scan_rate_hz},
              {"first_pulse_s", lidar.first_pulse_s}};
    static const char* const patterns[] = {"fixed", "line", "oscillating", "rotating", "palmer", "raster"};
    j["pattern"] = patterns[static_cast<int>(lidar.scan.pattern)];
    j["scan_columns"] = lidar.scan.columns;
    j["scan_rows"] = lidar.scan.rows;
    j["georeferenced"] = simulation.scene.origin.epsg != 0;
    return j;
  }

  std::string figures_json(const std::string& stem) const {
    Json j = picture_facts();
    if (cube) j["cube"] = cube_data->temporary_path(), j["cube_header"] = cube_text->temporary_path();
    if (las) j["las"] = las_file->temporary_path();
    for (const char* name : kPictures) j["pictures"][name] = stem + "." + name;
    return j.dump();
  }

  /// The pictures that could be drawn, read from the files as they are; without matplotlib a warning, the data are what
  /// counts.
  void draw(products::RunRecord& record) {
    base::OutputFile figures((std::filesystem::path(folder) / ".pictures.json").string(), base::IfExists::replace);
    const std::string stem = figures.temporary_path();
    struct Remove {
      const std::string& stem;
      ~Remove() {
        for (const char* name : kPictures) std::remove((stem + "." + name).c_str());
      }
    } remove{stem};
    figures.append(figures_json(stem));
    try {
      run_plot("lidar_pictures.py", stem);
    } catch (const base::Error& error) {
      record.warnings.push_back(std::string("no pictures: ") + error.what());
      return;
    }
    static const char* const what[] = {"waveforms of some pulses", "ranges of first strong returns", "point cloud"};
    for (std::size_t i = 0; i < std::size(kPictures); ++i) {
      const std::string drawn = stem + "." + kPictures[i];
      if (!std::filesystem::exists(drawn)) continue;  // nothing to show: no returns
      append_drawn(set.add(kPictures[i]), drawn);
      record.files.emplace_back(kPictures[i], what[i]);
    }
  }

  std::string folder;
  base::IfExists if_exists;
  const scene::Simulation& simulation;
  const std::vector<std::uint32_t> named{scene::named_materials(simulation.scene)};  ///< of each of the materials
  const lidar::LidarPlan& plan;
  const scene::Lidar& lidar;
  const lidar::FlatVolumes volumes;
  base::OutputSet set;
  base::OutputFile* cube_data = nullptr;
  base::OutputFile* cube_text = nullptr;
  std::unique_ptr<base::OutputFile> scratch_points, scratch_packets;
  std::optional<products::TimeCubeWriter> cube;
  std::optional<products::LasWriter> las;
  std::optional<LidarCsv> tables;
  base::OutputFile* las_file = nullptr;
  std::string python;                         ///< for LAZ
  base::OutputFile* waveform_file = nullptr;  ///< beside the points: its hashes are in the digest
  base::Sha256 digest;
  std::vector<float> values;
  std::vector<std::string> warnings;
  bool detected = false, las_waveforms = false;
  lidar::ScanLine line{lidar};
  std::vector<products::LasPoint> last_points;  ///< of the last pulse that had some
  std::uint64_t shots = 0, returns = 0, without_return = 0, record_count = 0, empty_records = 0, rays = 0;
};

LidarProducts::LidarProducts(const std::string& folder, base::IfExists if_exists, const scene::Simulation& simulation,
                             const lidar::LidarPlan& plan)
    : state_(std::make_unique<State>(folder, if_exists, simulation, plan)) {}
LidarProducts::~LidarProducts() = default;

bool LidarProducts::wants_truth() const { return state_->las || state_->tables; }

void LidarProducts::truth(const lidar::ShotResult& result, const std::vector<lidar::Detection>& detections,
                          std::vector<std::vector<lidar::ReturnTruth>>& out) const {
  out.resize(wants_truth() && !result.hits.empty() ? detections.size() : 0);
  for (std::size_t i = 0; i < out.size(); ++i) {
    const auto& d = detections[i];
    out[i].clear();
    if (!d.echoes.empty())
      out[i] = lidar::return_truth(state_->simulation.scene, state_->volumes, state_->plan, result, d.pixel, d.line,
                                   d.echoes);
  }
}

void LidarProducts::add(const lidar::ShotResult& result, const std::vector<lidar::Detection>& detections,
                        const std::vector<std::vector<lidar::ReturnTruth>>& truth) {
  state_->add(result, detections, truth);
}

void LidarProducts::publish(products::RunRecord& record) {
  State& s = *state_;
  const auto& origin = s.simulation.scene.origin;
  const std::string where = origin.epsg ? fmt::format("EPSG:{}", origin.epsg)
                                        : fmt::format("the scene's metres from ({}, {}, {})", origin.easting_m,
                                                      origin.northing_m, origin.height_m);
  if (s.shots == 0)
    throw base::Error(base::Fault::input,
                      s.lidar.name + ": the scan fires no pulse; widen its half_angle_deg or give more pulses");
  if (s.cube) {
    s.cube->finish(fmt::format("waveforms, photons at the detector per bin; samples: range bins, lines: pulses in the "
                               "order of pulses.csv, {} pixels each",
                               s.plan.pixels()),
                   "raycube " + s.lidar.name, s.simulation.sun.utc);
    record.files.emplace_back("waveforms.img", "waveforms of every pulse, ENVI");
    record.samples = s.lidar.gate.bins;
    record.lines = s.cube->lines();
    record.bands = static_cast<std::int64_t>(s.cube->bands());
  }
  if (s.las) {
    s.flush_points(s.line.scans());
    s.las->finish(s.shots, s.without_return);
    const std::string what = fmt::format("returns, LAS 1.4 format {}, {}", s.las->format(), where);
    if (s.lidar.products.las) record.files.emplace_back("returns.las", what);
    if (s.lidar.products.laz) s.compress(record, what);
    if (s.las_waveforms && !s.lidar.products.internal_waveforms)
      record.files.emplace_back("returns.wdp", "waveforms of the returns");
  }
  if (s.tables) s.tables->finish(record);
  if (s.waveform_file) {
    const std::string list = s.waveform_file->hashes().list;
    s.digest.add(list.data(), list.size());
  }
  record.digest = s.digest.hex();
  record.rays += s.rays;
  record.warnings.insert(record.warnings.end(), s.warnings.begin(), s.warnings.end());
  Json figures = {{"pulses", s.shots},
                  {"pulses_without_return", s.without_return},
                  {"records", s.record_count},
                  {"records_without_return", s.empty_records},
                  {"returns", s.returns},
                  {"bin_s", s.lidar.gate.bin_s},
                  {"gate_start_s", s.lidar.gate.start_s}};
  if (s.las) figures["las_intensity_unit_pe"] = s.las->intensity_unit_pe(), figures["las_scale_m"] = s.las->scale_m();
  figures["pictures"] = s.picture_facts();
  record.more_json.emplace_back("lidar", figures.dump());
  if (s.lidar.products.png) s.draw(record);
  products::publish_run(s.set, record);
}

}  // namespace raycube::run
