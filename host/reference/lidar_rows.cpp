#include "host/reference/lidar_rows.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace raycube::reference {

LidarGate::LidarGate(const lidar::LidarPlan& plan, double slope_s)
    : shape_(plan.lidar.pulse),
      start_s_(plan.lidar.gate.start_s),
      bin_s_(plan.lidar.gate.bin_s),
      end_s_(start_s_ + plan.lidar.gate.bins * bin_s_),
      slope_s_(slope_s),
      bins_(plan.lidar.gate.bins),
      emitted_(plan.photons) {}

void LidarGate::deposit(std::vector<double>& rows, int pixel, int line, double time_s, double photons,
                        lidar::Ledger& ledger) const {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const double share =
      emitted_[static_cast<std::size_t>(line)] > 0 ? photons / emitted_[static_cast<std::size_t>(line)] : 0;
  // Times from the gate's start in units of bins keep their digits far away.
  const double offset_s = time_s - start_s_;
  ledger.collected += share;
  ledger.early += share * shape_.share(-kInfinity, -offset_s);
  ledger.late += share * shape_.share(bins_ * bin_s_ - offset_s, kInfinity);
  const double first = std::floor((offset_s + shape_.first_s()) / bin_s_) - 1,
               last = std::floor((offset_s + shape_.last_s()) / bin_s_) + 1;
  const int from = static_cast<int>(std::clamp(first, 0.0, static_cast<double>(bins_)));
  const int to = static_cast<int>(std::clamp(last, -1.0, bins_ - 1.0));
  const std::size_t row = (static_cast<std::size_t>(pixel) * emitted_.size() + static_cast<std::size_t>(line)) *
                          static_cast<std::size_t>(bins_);
  for (int bin = from; bin <= to; ++bin) {
    const double begin_s = bin * bin_s_ - offset_s, until_s = (bin + 1) * bin_s_ - offset_s;
    double part = shape_.share(begin_s, until_s);
    if (slope_s_ > 0) part = std::abs(part - shape_.share(begin_s - slope_s_, until_s - slope_s_));
    rows[row + static_cast<std::size_t>(bin)] += photons * part;
  }
}

}  // namespace raycube::reference
