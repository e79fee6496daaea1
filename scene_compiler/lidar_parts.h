// The tables of a [[lidar]], one function each. Internal to the builder.
#pragma once

#include <initializer_list>
#include <string>
#include <vector>

#include "host/base/units.h"
#include "scene_compiler/lidar_builder.h"
#include "scene_compiler/placed_box.h"

namespace raycube::scene::detail {

/// Where problems and remarks on one LIDAR go.
struct LidarReport {
  std::string name;
  std::vector<std::string>& notices;
  base::Problems& problems;
  void notice(const base::Where& where, const std::string& text) const {
    notices.push_back(where.text() + ": LIDAR '" + name + "': " + text);
  }
};

int count_given(const Record& record, std::initializer_list<const char*> keys);
/// Keys that the choice `because` ("pattern = \"line\"") cannot do without, and those it would ignore.
void want_keys(const Record& record, std::initializer_list<const char*> keys, const std::string& because,
               const LidarReport& report);
void refuse_keys(const Record& record, std::initializer_list<const char*> keys, const std::string& because,
                 const LidarReport& report);

void read_platform(const Record& lidar, const SceneParts& parts, Lidar& out, const LidarReport& report);
void read_pulse(const Record& pulse, Lidar& out, const LidarReport& report);
void read_scan(const Record& scan, Lidar& out, const LidarReport& report);
void read_mount(const Record& mount, LidarMount& out, const LidarReport& report);
void read_receiver(const Record& receiver, Lidar& out, const LidarReport& report);
void read_gate(const Record& gate, Lidar& out, const LidarReport& report);
void read_sampling(const Record& sampling, Lidar& out, const LidarReport& report);
void read_turbulence(const Record& turbulence, Lidar& out, const LidarReport& report);
void read_detector(const Record& detector, bool has_sun, Lidar& out, const LidarReport& report);
/// After the detector.
void read_echoes(const Record& echoes, Lidar& out, const LidarReport& report);
void read_outputs(const Record* speckle, const Record* products, Lidar& out, const LidarReport& report);

/// `box`: around all that is placed.
/// What is known before the first pulse to leave records empty or turbulence unsure of its ground: notices,
/// and errors where nothing can be meant by it.
void check_before_first_pulse(const Record& record, const SceneParts& parts, const PlacedBox& box, const Lidar& lidar,
                              const LidarReport& report);

}  // namespace raycube::scene::detail
