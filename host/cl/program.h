// An OpenCL program built from embedded source.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "host/cl/context.h"
#include "host/cl/kernel_cache.h"

namespace raycube::cl {

/// The build option that gives a program a number by name.
std::string define(const char* name, auto value) { return " -D" + std::string(name) + "=" + std::to_string(value); }

class Program {
 public:
  /// Builds `source` with `options`, and with exactly rounded quotients and roots on devices other than CPUs, which
  /// must be asked for them: rays are then those of the host. A failed build throws Error(device) with name, device,
  /// options and the log, whose lines name the kernel files. Kernels that an earlier run compiled of the same come from
  /// the cache (kernel_cache.h); throws Error(environment) when that has no room. PoCL reads a source of 10 000 lines
  /// anew even where it has its kernels, so it is given the intermediate code of the first build instead.
  Program(const Context& context, const std::string& name, std::string_view source, const std::string& options);
  const std::string& name() const { return name_; }
  const std::string& options() const { return options_; }
  const std::string& device_name() const { return device_name_; }
  cl_device_id device() const { return device_; }
  /// Largest work-group along a line that the device takes at all.
  std::size_t most_local() const { return most_local_; }
  /// What the compiler said; empty when it was silent.
  const std::string& log() const { return log_; }
  cl_program operator()() const { return program_(); }

 private:
  using Built = Handle<cl_program, clReleaseProgram>;
  Built created_of_source(const Context& context, std::string_view source) const;
  /// Of the intermediate code that is kept; empty where there is none or the device does not take it.
  Built created_of_code(const Context& context) const;
  /// Of the intermediate code where there is some or some can be made, else of the source.
  void build_any(const Context& context, std::string_view source, const std::string& asked);
  /// Builds `made` and, if that succeeds, makes it the program. What the compiler said is in the log.
  cl_int build(Built made, const std::string& asked);

  std::string name_, options_, device_name_, log_;
  cl_device_id device_ = nullptr;  ///< the context's
  std::size_t most_local_ = 1;
  std::unique_ptr<KeptKernels> kept_;  ///< goes after the program, whose kernels are all compiled by then
  Built program_;
};

}  // namespace raycube::cl
