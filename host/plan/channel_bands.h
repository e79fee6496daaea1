// Tables of channels: where another code has averaged over an instrument's bands already (MODTRAN .chn), a
// second convolution is one too many.
#pragma once

#include <string>
#include <vector>

#include "atmos_tables/render_table.h"
#include "scene_compiler/simulation.h"

namespace raycube::plan {

struct ChannelBands {
  /// The instrument's bands. One that is a channel of the table stands for the channel's node alone (a
  /// response 2 fm wide), so that its light is the channel's, and the reflectance that at the channel's first
  /// moment: off by rho'' FWHM^2 / 11.
  std::vector<scene::Band> bands;
  std::size_t channels = 0;          ///< how many bands are channels
  std::vector<std::string> notices;  ///< what is convolved again
};

/// A band is a channel when centre and FWHM agree to 2 % of the FWHM. Others are read from the channels as
/// from a spectrum, which is said; those narrower than half a channel cannot be, and are an Error(input) that
/// names them. Tables that are no channel output (whose provenance has no `channels`) leave the bands as they
/// are.
ChannelBands channel_bands(const scene::Instrument& instrument, const atmos::RenderTable& table);

}  // namespace raycube::plan
