// Sub-rays of a pulse: equal energy, evenly spread.
#pragma once

#include <array>

#include "host/lidar/lidar_plan.h"

namespace raycube::lidar {

/// Golden-angle spiral (LIDAR specification, 2.1): u = (i + 1/2) / N, radius sqrt(-ln(1 - u) / 2) (gaussian) or sqrt(u)
/// (uniform), so that no tail is cut and every sub-ray carries 1/N; one sub-ray lies on the axis. Share of energy on
/// one side of a straight edge: rms error 1.5 % at 64, 0.5 % at 256, 0.16 % at 1024. With `distributed` each sub-ray
/// leaves from a point of the exit of its own, an independent spiral (gaussian: radius^2 of the spot = exit^2 +
/// (divergence range)^2 then holds by construction; uniform: the place it goes to, a disc of radius exit + divergence
/// range), else all leave from the middle. receiver sampling: an R2 lattice over the pixel's square, sides 1, moved by
/// `shift` (in sides, around at the edges): for references that have nothing in common with it.
Footprint make_footprint(const scene::Lidar& lidar, bool distributed, std::array<double, 2> shift = {0, 0});

/// Whether the exit's size matters: its radius is above 2 % of the spot's at the nearest range the gate records (0.02 %
/// of the spot's radius left out below that).
bool exit_matters(const scene::Lidar& lidar);

}  // namespace raycube::lidar
