// What every shot of a LIDAR shares on the device: build options and tables.
#pragma once

#include <string>
#include <vector>

#include "host/lidar/lidar_plan.h"
#include "host/lidar/volumes.h"
#include "kernels/shared/structs.h"

namespace raycube::render {

struct LidarTables {
  std::uint32_t features = 0;       ///< RC_FEATURE_* of kernels/lidar/layout.h
  std::vector<std::uint32_t> plan;  ///< RC_PLAN_*
  std::vector<shared::Lobe> lobes;
  std::vector<float> samples, exits, photons, node_weight, taps, settings, backscatter, volume_depth;
  int cells = 0;  ///< of a bin, for moments (taps holds those behind its phases); 0: none
  std::vector<std::uint32_t> first_node;
  std::vector<shared::rc_float4> optics;
  std::vector<float> air;  ///< pairs
  lidar::FlatVolumes volumes;
  bool way = false;  ///< air or particles send light back on the way: lidar_air runs
  bool air_rows = false;
  std::size_t way_rows = 1;                             ///< air, and with volumes particles
  std::string shot_options, air_options, beam_options;  ///< of lidar_shots, lidar_air and lidar_beam
  std::size_t row_floats = 0, row_pad = 0;              ///< of a padded row
  std::size_t owner_rows = 0;                           ///< of one order of scattering
  std::size_t stopped_floats = 0;                       ///< of an owner: rows of rays stopped, rays of every pixel
  std::size_t scratch_floats = 0;  ///< of an owner: impulses of the air's return, shares of the pulse
  std::size_t floats_of_sum = 1;   ///< a bin of an owner of several pixels may be a sum of two floats
  bool multiple = false;           ///< rows of light scattered more than once
};

/// apart: some shot's exit and pupil are two places; hits: first hits are asked for. Throws Error(input) when the plan
/// asks what no device can do (receiver sampling without pixels).
LidarTables make_lidar_tables(const lidar::LidarPlan& plan, const scene::CompiledScene& scene, bool apart, bool hits);

}  // namespace raycube::render
