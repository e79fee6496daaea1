#include "host/run/services.h"

#include <memory>

#include "host/base/interrupt.h"
#include "host/base/progress.h"

namespace raycube::run {

void Services::warn_once(const std::string& notice) {
  if (said.insert(notice).second) log.warning(notice);
}

Services watched_services(base::Log& log, int threads) {
  const auto progress = [&log](const std::string& what, std::uint64_t total, const std::string& unit) {
    // Shared, since a function object must be copyable; there is one bar all the same.
    const auto bar = std::make_shared<base::Progress>(log, what, total, unit);
    return Services::Advance([bar](std::uint64_t more) { bar->advance(more); });
  };
  return {log, progress, base::throw_if_interrupted, threads};
}

Step::Step(const Services& services, const std::string& what, std::uint64_t total, const std::string& unit)
    : services_(services), advance_(services.progress ? services.progress(what, total, unit) : Services::Advance{}) {}

void Step::advance(std::uint64_t more) const {
  if (services_.stop) services_.stop();
  if (advance_) advance_(more);
}

}  // namespace raycube::run
