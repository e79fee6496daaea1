// Bidirectional reflectance factors of a level area of the scene, as `raycube measure` finds them.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "host/render/renderer.h"
#include "host/run/services.h"
#include "scene_compiler/simulation.h"

namespace raycube::run {

/// Batches of each direction, with draws of their own; their spread is the error.
inline constexpr int kMeasureBatches = 16;

/// A direction to look from.
struct MeasureView {
  double zenith_deg = 0;   ///< in a plane of sight negative on its far side: away from the sun, or on its right
  double azimuth_deg = 0;  ///< of the place to look from, clockwise from north
  double relative_azimuth_deg = 0;  ///< of that less the sun's, folded to 0..180: 0 where the sun stands behind one
  double weight = 0;                ///< of a hemisphere's: its share of the albedo; all sum to 1
};

/// A mean and the standard error of it.
struct Measured {
  double mean = 0, error = 0;
};

/// Of batches.
Measured measured(const std::vector<double>& batches);

/// What an area sends in one direction, or, of a hemisphere, in all: over what an ideal white panel there would send.
struct ReflectanceFactor {
  Measured all;
  Measured multiple;  ///< of light that met more than one surface
};

struct MeasureResult {
  std::vector<MeasureView> views;
  std::vector<double> wavelength_um;                   ///< [band]
  std::vector<std::vector<ReflectanceFactor>> factor;  ///< [view][band]
  std::vector<ReflectanceFactor> albedo;               ///< [band]; of a hemisphere alone
};

/// The bands of a measure's or budget's instrument.
const std::vector<scene::Band>& bands_of(const scene::Simulation& simulation, const std::string& instrument);

/// Throw Error(input) of `who` ("measure 'albedo'"): no sun above the horizon; bands where surfaces shine by
/// themselves.
void check_sun(const scene::Simulation& simulation, const std::string& who);
void check_sunlit_bands(const scene::Simulation& simulation, const std::string& who, const std::string& instrument);

/// Throws Error(input): a sun that is down, bands where surfaces shine by themselves, views past the scene's edge.
void check_measure(const scene::Simulation& simulation, const scene::Measure& measure);

/// Directions of a measure under this sun. Hemisphere: rings at the Gauss-Legendre nodes of sin^2 of the zenith angle,
/// which weigh the cosine's share of a hemisphere evenly, of directions evenly apart: n rings are exact for reflectance
/// factors that go with sin^2 as polynomials of degree 2 n - 1 and with azimuth slower than a ring's directions.
std::vector<MeasureView> measure_views(const scene::Measure& measure, const scene::Sun& sun);

/// By a camera so far away that its rays are parallel to 1 / 2000, over the area as seen from there; the renderer's
/// scene is the simulation's. The air is left out of the simulation. Throws what check_measure does.
MeasureResult measure(render::Renderer& renderer, const render::RenderOptions& options, scene::Simulation& simulation,
                      const scene::Measure& measure, Services& services);

/// Rows view by view, band by band.
std::string measure_csv(const scene::Measure& measure, const MeasureResult& result);
/// One band in the form in which the RAMI exercises exchange results: angles in radians, azimuth from the sun's. part:
/// which of a factor.
std::string measure_mes(const MeasureResult& result, const scene::Sun& sun, std::size_t band,
                        Measured ReflectanceFactor::*part);
nlohmann::ordered_json measure_json(const scene::Measure& measure, const MeasureResult& result);

}  // namespace raycube::run
