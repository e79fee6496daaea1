// Every OpenCL device of the machine, for tests that must hold on each.
#pragma once

#include <doctest/doctest.h>

#include <string>
#include <utility>
#include <vector>

#include "host/cl/context.h"
#include "tests/support/kept_programs.h"

namespace raycube::test {

/// Calls f(context) for every device found, its name in what a failed check prints.
template <typename F>
void on_every_device(const F& f) {
  for (cl::Device& device : cl::list_devices()) {
    const std::string name = device.name();
    INFO("device " << name);
    const cl::Context context(std::move(device));
    f(context);
  }
}

/// The first device found, for tests of the kernels themselves; one for the whole program.
inline const cl::Context& first_context() {
  static const cl::Context instance{cl::Device(cl::list_devices().front()())};
  return instance;
}

/// Numbers of the devices found, as RenderOptions::device takes them.
inline std::vector<std::string> device_numbers() {
  std::vector<std::string> numbers;
  for (std::size_t i = 0; i < cl::list_devices().size(); ++i) numbers.push_back(std::to_string(i));
  return numbers;
}

}  // namespace raycube::test
