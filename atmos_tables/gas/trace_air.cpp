#include "atmos_tables/gas/trace_air.h"

#include <algorithm>
#include <iterator>

#include "atmos_tables/optics/air_profile.h"

namespace raycube::atmos {

namespace {

struct TraceRow {
  double height_km, no, so2, no2, nh3, hno3;
};
#include "atmos_tables/gas/data/trace_gases.inc"

}  // namespace

TraceAir trace_air(double height_km) {
  const TraceRow* high = std::upper_bound(std::begin(kTrace) + 1, std::end(kTrace) - 1, height_km,
                                          [](double h, const TraceRow& row) { return h < row.height_km; });
  const TraceRow& low = high[-1];
  const double f = std::clamp((height_km - low.height_km) / (high->height_km - low.height_km), 0.0, 1.0);
  return {between(low.no, high->no, f), between(low.so2, high->so2, f), between(low.no2, high->no2, f),
          between(low.nh3, high->nh3, f), between(low.hno3, high->hno3, f)};
}

}  // namespace raycube::atmos
