#include "host/reference/bounced_report.h"

#include <algorithm>
#include <cmath>

#include "host/base/text.h"
#include "host/reference/report_text.h"

namespace raycube::reference {

double BouncedReport::apart(const Band& band) const {
  const double off = std::abs(band.device - band.reference) - skeleton_error * band.size;
  // Bands that hold no such light on either side agree.
  return off <= 0 ? 0 : band.error > 0 ? off / band.error : INFINITY;
}

std::size_t BouncedReport::worst() const {
  const auto less = [&](const Band& a, const Band& b) { return apart(a) < apart(b); };
  return static_cast<std::size_t>(std::max_element(bands.begin(), bands.end(), less) - bands.begin());
}

std::vector<std::string> BouncedReport::failures() const {
  if (bands.empty()) return {};
  const Band& band = bands[worst()];
  if (apart(band) <= kApart) return {};
  return {"light between surfaces lies " + three_digits(apart(band)) +
          " standard errors from the reference's in band " + std::to_string(worst() + 1) + ": " +
          three_digits(band.device) + " for " + three_digits(band.reference) + " +- " + three_digits(band.error) +
          " W m-2 sr-1 um-1"};
}

std::string BouncedReport::text() const {
  if (bands.empty()) return "";
  double device = 0, reference = 0;
  for (const Band& band : bands) device += band.device, reference += band.reference;
  const Band& band = bands[worst()];
  return "\nlight between surfaces (" + base::counted(pixels, "pixel") + ", " + base::counted(paths, "path") +
         " of the reference): all bands " + three_digits(reference != 0 ? device / reference : 1) +
         " of the reference; the worst, " + std::to_string(worst() + 1) + ", " +
         three_digits(band.reference != 0 ? band.device / band.reference : 1) + " +- " +
         three_digits(band.reference != 0 ? band.error / std::abs(band.reference) : 0) + ", " +
         three_digits(apart(band)) + " standard errors apart (limit " + three_digits(kApart) + ", beside " +
         three_digits(skeleton_error) + " that the plan allows)";
}

}  // namespace raycube::reference
