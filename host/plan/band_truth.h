// Truth per band (scene_compiler/band_truth.def): cubes that are summed from the same terms as the radiance, by other
// values of the band table, as further columns of its rows.
#pragma once

#include <cstdint>
#include <vector>

#include "host/plan/plan.h"

namespace raycube::plan {

class BandSpace;
class TableSpectra;
struct SkyFactors;
struct SpectralPlan;

/// Which part of the radiance a term belongs to: what lies in a row's channel.
scene::BandTruth light_kind(const Plan& plan, std::uint64_t key, int channel);

/// Whether light of this plan can have such a part.
bool has_part(const Plan& plan, scene::BandTruth part);

/// The cubes that an instrument asks for, ascending; transmission, which is no sum of terms, is not among them.
std::vector<scene::BandTruth> truth_columns(const Plan& plan, const scene::Instrument& instrument);

/// The skies of a plan.
struct PlannedSkies {
  const SkyFactors &solar, &thermal;
};

/// What falls onto a surface of each source that lights it, at the nodes of height: Plan::incident. threads: 0: as many
/// as the machine has.
void fill_incident(Plan& plan, const TableSpectra& air, const BandSpace& bands, const PlannedSkies& skies,
                   const SpectralPlan& spectral, int threads);

/// Tells that the cubes which an instrument asks for will lack light that is too faint to be seen beside thermal light;
/// shares of the radiance, 0: it is there.
void tell_of_missing_truth(Plan& plan, const scene::Instrument& instrument, double sun, double sky);

/// The plan that renders with such cubes; its rows are wider than those of the plan it comes of.
Plan with_truth(const Plan& plan, const std::vector<scene::BandTruth>& cubes);

/// Fills the columns of truth of a row whose bands are filled: row[channel * padded + column].
void bake_truth(const Plan& plan, const scene::CompiledScene& scene, std::uint64_t key, std::size_t padded,
                std::vector<float>& row);

}  // namespace raycube::plan
