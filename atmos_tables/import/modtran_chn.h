// MODTRAN .chn: channel-integrated output after a filter file.
//
// A header of label lines closed by a line of dashes whose groups mark the columns; one row per line of sight and
// channel; a description with CENTER and FWHM. Radiances and irradiances are integrals over the channel, W sr-1 cm-2
// and W cm-2: divided by the equivalent width in nm they are means, W cm-2 sr-1 nm-1. One run per line of sight,
// channels in the file's order. Here thermal scatter stands beside thermal emission (unlike tape7's PTH_THRML);
// path_radiance_thermal is their sum.
#pragma once

#include <string>
#include <vector>

#include "atmos_tables/import/imported.h"

namespace raycube::atmos::imported {

Imported read_chn(const std::string& path);

/// Transmittance sun to ground to sensor of each channel: the transmitted sun over TOA sun, for the sun's zenith of the
/// run (a .chn does not name it): col 20 / (col 19 pi / cos sun).
std::vector<double> sun_ground_sensor_transmittance(const Run& channels, double sun_zenith_deg);

}  // namespace raycube::atmos::imported
