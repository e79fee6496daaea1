// Two programs of one line each, built and launched as a render's are and kept in the same cache; their sums go to
// stdout. Tests of the cache run this where a render would compile for ten seconds.
#include <cstdio>
#include <iostream>
#include <string>
#include <vector>

#include "host/base/crash_report.h"
#include "host/base/error.h"
#include "host/cl/context.h"
#include "host/cl/kernel.h"

using namespace raycube;

namespace {

float sum_of(const cl::Context& context, const std::string& name, const std::string& statement) {
  const cl::Program program(context, name, "kernel void " + name + "(global float* x) { " + statement + " }\n", "");
  cl::Kernel kernel(program, name);
  cl::Buffer<float> values(context, std::vector<float>(64, 0.5f), cl::Access::read_write, "values");
  kernel.arguments(values);
  context.launch(kernel, 64);
  context.finish();
  float out = 0;
  for (const float value : values.read_all()) out += value;
  return out;
}

}  // namespace

int main() {
  base::install_crash_report();
  try {
    const cl::Context context(cl::find_device(""));
    std::printf("%g", sum_of(context, "add_one", "x[get_global_id(0)] += 1.0f;"));
    std::printf(" %g\n", sum_of(context, "double_and_add", "x[get_global_id(0)] = 2.0f * x[get_global_id(0)] + 3.0f;"));
    return 0;
  } catch (const base::Error& error) {
    std::cerr << "raycube: error: " << error.what() << std::endl;
    return error.exit_status();
  }
}
