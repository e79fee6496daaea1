#include "host/cl/program.h"

#include <cstdlib>
#include <fstream>
#include <new>

#include "host/base/doing.h"
#include "host/base/error.h"
#include "host/base/interrupt.h"
#include "host/base/memory.h"
#include "host/cl/status.h"

namespace raycube::cl {

namespace {

/// Its programs are built of the intermediate code of their first build.
constexpr const char* kPocl = "Portable Computing Language";

/// One line for a program in the file that RAYCUBE_PROGRAM_LOG names, if it names one: name, hash, whether it is
/// compiled or was kept by an earlier run, options. Lines of processes side by side do not mix.
void log_program(const std::string& name, const KeptKernels& kept, const std::string& options) {
  const char* const file = std::getenv("RAYCUBE_PROGRAM_LOG");
  if (!file || !*file) return;
  std::ofstream(file, std::ios::app) << name + "\t" + kept.hash() + "\t" + (kept.found() ? "kept" : "compiled") + "\t" +
                                            options + "\n"
                                     << std::flush;
}

/// A call of the driver's compiler. What it throws for want of memory comes through the driver, whose locks stay held:
/// nothing of it can be given back, and the process ends here.
template <class Call>
cl_int with_memory(const std::string& name, const Call& call) {
  try {
    return call();
  } catch (const std::bad_alloc&) {
    base::leave_at_once(
        "the OpenCL driver ran out of memory while it built '" + name + "'" + base::address_space_text(),
        base::Fault::environment);
  }
}

}  // namespace

Program::Program(const Context& context, const std::string& name, std::string_view source, const std::string& options)
    : name_(name),
      options_(options),
      device_name_(context.device().name()),
      device_(context.device()()),
      most_local_(context.device().info().max_work_items) {
  const base::Doing doing("building program", name);
  require_room_for_kernels();
  const DeviceInfo& on = context.device().info();
  const std::string asked = options + (on.rounds_on_demand ? " -cl-fp32-correctly-rounded-divide-sqrt" : "");
  std::string key;
  for (const std::string_view part :
       {std::string_view(on.platform), std::string_view(on.name), std::string_view(on.version),
        std::string_view(on.driver), std::string_view(asked), source, std::string_view("built of code")})
    (key += part) += '\0';
  kept_ = std::make_unique<KeptKernels>(key);
  log_program(name, *kept_, asked);
  const DriverWork work;
  build_any(context, source, asked);
}

void Program::build_any(const Context& context, std::string_view source, const std::string& asked) {
  const DeviceInfo& on = context.device().info();
  bool of_code = build(created_of_code(context), asked) == CL_SUCCESS;
  if (!of_code && on.platform == kPocl && kept_->can_take_code()) {
    const Built front = created_of_source(context, source);
    const auto compile = [&] {
      return clCompileProgram(front(), 1, &device_, asked.c_str(), 0, nullptr, nullptr, nullptr, nullptr);
    };
    if (with_memory(name_, compile) == CL_SUCCESS) kept_->take_code();
    of_code = build(created_of_code(context), asked) == CL_SUCCESS;
  }
  if (!of_code) {
    const cl_int status = build(created_of_source(context, source), asked);
    if (status != CL_SUCCESS) blame_full_disk();
    if (status != CL_SUCCESS) {
      const std::string limit = base::address_space_text();
      throw base::Error(limit.empty() ? base::Fault::device : base::Fault::environment,
                        "OpenCL: clBuildProgram of '" + name_ + "' failed with " + status_name(status) +
                            " on device '" + device_name_ + "', options '" + asked + "'" + limit + ":\n" + log_);
    }
  }
  kept_->built(of_code);
}

Program::Built Program::created_of_source(const Context& context, std::string_view source) const {
  cl_int status = CL_SUCCESS;
  const char* text = source.data();
  const std::size_t length = source.size();
  Built made(clCreateProgramWithSource(context(), 1, &text, &length, &status));
  check(status, "clCreateProgramWithSource of '" + name_ + "'", device_name_);
  return made;
}

Program::Built Program::created_of_code(const Context& context) const {
  const std::string& code = kept_->code();
  if (code.empty()) return {};
  const auto* bytes = reinterpret_cast<const unsigned char*>(code.data());
  const std::size_t length = code.size();
  cl_int status = CL_SUCCESS;
  Built made(clCreateProgramWithBinary(context(), 1, &device_, &length, &bytes, nullptr, &status));
  return status == CL_SUCCESS ? std::move(made) : Built();
}

cl_int Program::build(Built made, const std::string& asked) {
  if (!made) return CL_INVALID_PROGRAM;
  const cl_int status =
      with_memory(name_, [&] { return clBuildProgram(made(), 1, &device_, asked.c_str(), nullptr, nullptr); });
  std::size_t size = 0;
  if (clGetProgramBuildInfo(made(), device_, CL_PROGRAM_BUILD_LOG, 0, nullptr, &size) == CL_SUCCESS && size > 1) {
    log_.resize(size);
    clGetProgramBuildInfo(made(), device_, CL_PROGRAM_BUILD_LOG, size, log_.data(), nullptr);
    log_.resize(size - 1);
  }
  if (status == CL_SUCCESS) program_ = std::move(made);
  return status;
}

}  // namespace raycube::cl
