#include "host/run/laz.h"

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <vector>

#include "host/base/error.h"
#include "host/run/python_script.h"

namespace raycube::run {
namespace {

constexpr const char* kLazNeeds =
    "products.laz needs a Python with laspy and lazrs: python3 -m venv V && V/bin/pip install laspy lazrs, then set "
    "RAYCUBE_PYTHON=V/bin/python; or leave laz out";

std::vector<std::string> candidates() {
  if (const char* named = std::getenv("RAYCUBE_PYTHON"); named && *named) return {named};
  std::error_code ignored;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", ignored).parent_path();
  return {(program / "venv/bin/python").string(), kSystemPython};
}

bool has_laz(const std::string& python) {
  return access(python.c_str(), X_OK) == 0 &&
         run_python(python, {"-c", "import sys\ntry:\n  import laspy, lazrs\nexcept ImportError:\n  sys.exit(1)"},
                    kLazNeeds);
}

}  // namespace

std::string laz_python() {
  std::string tried;
  for (const std::string& python : candidates()) {
    if (has_laz(python)) return python;
    tried += (tried.empty() ? "" : ", ") + python;
  }
  throw base::Error(base::Fault::environment, "no laspy with lazrs (looked in " + tried + "); " + kLazNeeds);
}

void write_laz(const std::string& python, const std::string& las, const std::string& laz) {
  const std::string script = script_path("las_to_laz.py");
  if (!run_python(python, {script, las, laz}, kLazNeeds))
    throw base::Error(base::Fault::environment, script + " failed (its message is above); " + kLazNeeds);
}

}  // namespace raycube::run
