#include "host/analysis/empirical_line.h"

#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "host/base/error.h"

namespace raycube::analysis {

EmpiricalLine empirical_line(const std::vector<Panel>& panels) {
  constexpr double kLeastApart = 1e-9;
  if (panels.size() < 2)
    throw base::Error(
        base::Fault::input,
        fmt::format("an empirical line needs two panels or more (found {}); give --panel NAME=X0:X1,Y0:Y1 "
                    "--reflectance NAME=0.1 for each",
                    panels.size()));
  const Eigen::Index bands = panels.front().radiance.size();
  const double count = static_cast<double>(panels.size());
  EmpiricalLine out{Eigen::VectorXd(bands), Eigen::VectorXd(bands), Eigen::VectorXd(bands), {}};
  for (Eigen::Index b = 0; b < bands; ++b) {
    double x = 0, y = 0, xx = 0, xy = 0, size = 0;
    for (const Panel& p : panels) {
      x += p.radiance[b] / count, y += p.reflectance[b] / count;
      size = std::max(size, std::abs(p.radiance[b]));
    }
    for (const Panel& p : panels) {
      xx += (p.radiance[b] - x) * (p.radiance[b] - x);
      xy += (p.radiance[b] - x) * (p.reflectance[b] - y);
    }
    if (!(std::sqrt(xx) > kLeastApart * size)) {
      out.gain[b] = out.offset[b] = out.rms[b] = std::numeric_limits<double>::quiet_NaN();
      out.dark.push_back(static_cast<std::size_t>(b));
      continue;
    }
    out.gain[b] = xy / xx, out.offset[b] = y - out.gain[b] * x;
    double squares = 0;
    for (const Panel& p : panels) {
      const double off = out.gain[b] * p.radiance[b] + out.offset[b] - p.reflectance[b];
      squares += off * off;
    }
    out.rms[b] = std::sqrt(squares / count);
  }
  if (out.dark.size() == static_cast<std::size_t>(bands))
    throw base::Error(base::Fault::input, "the panels' radiances are the same in every band");
  return out;
}

}  // namespace raycube::analysis
