#include "atmos_tables/aerosol/aerosol_spec.h"

#include <algorithm>

#include "host/base/error.h"

namespace raycube::atmos {

namespace {

template <class Kind, class Names>
Kind parse(const std::string& name, const Names& names, const char* what) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found != names.end()) return static_cast<Kind>(found - names.begin());
  std::string list;
  for (const char* known : names) list += (list.empty() ? "" : ", ") + std::string(known);
  throw base::Error(base::Fault::input,
                    std::string(what) + ": no such model (found \"" + name + "\"); use one of " + list);
}

}  // namespace

AerosolModel parse_aerosol(const std::string& name) { return parse<AerosolModel>(name, kAerosolNames, "aerosol"); }
StratosphereModel parse_stratosphere(const std::string& name) {
  return parse<StratosphereModel>(name, kStratosphereNames, "stratosphere");
}
CloudKind parse_cloud(const std::string& name) { return parse<CloudKind>(name, kCloudNames, "cloud"); }

}  // namespace raycube::atmos
