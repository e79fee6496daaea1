#include "host/cl/driver_search.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <dlfcn.h>

#include "host/base/input_file.h"
#include "host/base/memory.h"

namespace raycube::cl {
namespace {

namespace fs = std::filesystem;
using base::Error;
using base::Fault;

/// A driver's library and the file or variable that names it.
struct Driver {
  std::string named_by, library;
};

std::vector<fs::path> sorted_files(const fs::path& folder, const std::string& begin, const std::string& end) {
  std::vector<fs::path> out;
  std::error_code code;
  for (const auto& entry : fs::directory_iterator(folder, code)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with(begin) && name.ends_with(end)) out.push_back(entry.path());
  }
  std::sort(out.begin(), out.end());
  return out;
}

void add_icd_file(const fs::path& file, std::vector<Driver>& out) {
  if (!base::why_no_plain_file(file.string()).empty()) return;
  std::ifstream in(file);
  Driver driver{file.string(), ""};
  if (std::getline(in, driver.library) && !driver.library.empty()) out.push_back(driver);
}

std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> out;
  std::istringstream in(text);
  for (std::string part; std::getline(in, part, ':');)
    if (!part.empty()) out.push_back(part);
  return out;
}

/// As ocl-icd and the Khronos loader find them: folders of .icd files, such a file, or libraries.
std::vector<Driver> named_drivers(std::string& looked_in) {
  std::vector<Driver> out;
  looked_in = "/etc/OpenCL/vendors";
  for (const char* variable : {"OCL_ICD_VENDORS", "OPENCL_VENDOR_PATH", "OCL_ICD_FILENAMES"}) {
    const char* const value = std::getenv(variable);
    if (!value || !*value) continue;
    looked_in = std::string(variable) + " = " + value;
    for (const std::string& part : split(value)) {
      std::error_code code;
      if (fs::is_directory(part, code))
        for (const fs::path& file : sorted_files(part, "", ".icd")) add_icd_file(file, out);
      else if (part.ends_with(".icd"))
        add_icd_file(part, out);
      else if (part.find(".so") != std::string::npos)
        out.push_back({variable, part});
    }
    return out;
  }
  for (const fs::path& file : sorted_files(looked_in, "", ".icd")) add_icd_file(file, out);
  return out;
}

/// What the loader says of a library; empty: it can be loaded. It stays loaded, as the program is about to end.
std::string why_not_loaded(const std::string& library) {
  if (::dlopen(library.c_str(), RTLD_NOW | RTLD_LOCAL)) return "";
  const char* const said = ::dlerror();
  return said ? said : "the loader gave no reason";
}

/// PoCL has a library for each kind of device, in a folder beside its own.
std::string why_no_devices(const std::string& library) {
  void* const loaded = ::dlopen(library.c_str(), RTLD_NOW | RTLD_LOCAL);
  Dl_info where{};
  void* const known = loaded ? ::dlsym(loaded, "clGetExtensionFunctionAddress") : nullptr;
  if (!known || !::dladdr(known, &where) || !where.dli_fname) return "";
  for (const fs::path& part : sorted_files(fs::path(where.dli_fname).parent_path() / "pocl", "libpocl-devices-", ".so"))
    if (const std::string said = why_not_loaded(part.string()); !said.empty())
      return "its " + part.string() + " cannot be loaded: " + said;
  return "";
}

}  // namespace

Error no_device_error() {
  std::string looked_in, said;
  const std::vector<Driver> drivers = named_drivers(looked_in);
  for (const Driver& driver : drivers) {
    std::string why = why_not_loaded(driver.library);
    why = why.empty() ? why_no_devices(driver.library) : "it cannot be loaded: " + why;
    if (!why.empty()) said += "\n  " + driver.named_by + " names " + driver.library + "; " + why;
  }
  const std::string limit = base::address_space_text();
  if (!said.empty()) return {Fault::environment, "no OpenCL device: a driver could not be loaded" + limit + said};
  if (!drivers.empty() && !limit.empty())
    return {Fault::environment, "no OpenCL device: the driver " + drivers.front().library + " offers none" + limit};
  if (!drivers.empty())
    return {Fault::device, "no OpenCL device found: the driver " + drivers.front().library + ", named by " +
                               drivers.front().named_by + ", is loaded and offers none; look at clinfo"};
  return {Fault::device, "no OpenCL device found, and no driver in " + looked_in +
                             "; install one (on Debian: apt-get install pocl-opencl-icd) and look at clinfo"};
}

}  // namespace raycube::cl
