// Parts of a device come and go while the driver's threads still let go of what ran on them. CTest runs this
// with MALLOC_PERTURB_, which overwrites what is freed, so that a driver that reads it afterwards fails here
// and not once in a thousand renders.
#include <doctest/doctest.h>

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "host/base/error.h"
#include "host/cl/context.h"
#include "host/cl/kernel.h"
#include "tests/support/kept_programs.h"

using namespace raycube;

namespace {

constexpr const char* kSource = "kernel void add_one(global float* x) { x[get_global_id(0)] += 1.0f; }\n";
constexpr std::size_t kItems = 64;

/// What a renderer does to a device: context, program, launches, results, end.
float run_once(cl::Device device) {
  const cl::Context context(std::move(device));
  const cl::Program program(context, "add_one", kSource, "");
  cl::Kernel kernel(program, "add_one");
  cl::Buffer<float> values(context, std::vector<float>(kItems, 0.5f), cl::Access::read_write, "values");
  kernel.arguments(values);
  for (int i = 0; i < 12; ++i) context.launch(kernel, kItems);
  context.finish();
  return values.read_all().back();
}

/// What contexts share goes with the last of them, while this lives.
struct AsInProduct {
  AsInProduct() { cl::Context::keep_programs(0); }
  ~AsInProduct() { cl::Context::keep_programs(test::kKeptPrograms); }
};

/// Only CPUs are split (--threads).
bool can_be_split(const cl::Device& device) {
  const bool yes = device.info().is_cpu && device.info().compute_units > 1;
  if (!yes) MESSAGE("not looked at: device '" << device.name() << "' has no parts");
  return yes;
}

}  // namespace

TEST_CASE("a part of a device is one and the same whenever it is asked for, and has the units asked for") {
  const cl::Device whole = cl::find_device("");
  if (!can_be_split(whole)) return;
  const cl_device_id first = whole.with_compute_units(1)();
  const auto again = whole.with_compute_units(1);
  CHECK(again() == first);
  CHECK(again.info().compute_units == 1);
  CHECK(again() != whole());
  CHECK(whole.with_compute_units(whole.info().compute_units)() == whole());
  CHECK_THROWS_AS(whole.with_compute_units(0), base::Error);
  CHECK_THROWS_AS(whole.with_compute_units(whole.info().compute_units + 1), base::Error);
}

TEST_CASE("S63 a hundred contexts on a part of a device and on the whole, one after the other") {
  const cl::Device whole = cl::find_device("");
  const std::uint32_t units = whole.info().compute_units;
  if (!can_be_split(whole)) return;
  const AsInProduct as_in_product;
  for (int round = 0; round < 50; ++round) {
    CHECK(run_once(whole.with_compute_units(1)) == 12.5f);
    CHECK(run_once(whole.with_compute_units(units)) == 12.5f);
  }
}

TEST_CASE("a context builds a program of one name, source and options once") {
  const AsInProduct as_in_product;
  const cl::Context context(cl::find_device(""));
  const auto one = context.program("add_one", kSource, "");
  CHECK(context.program("add_one", kSource, "") == one);
  CHECK(context.program("add_one", kSource, "-DOTHER=1") != one);
  CHECK(context.program("add_one", std::string(kSource) + "\n", "") != one);
  for (int i = 0; i < 13; ++i) context.program("add_one", kSource, "-DOTHER=" + std::to_string(2 + i));
  CHECK(context.program("add_one", kSource, "") != one);  // others came after it, and this holds it still
  CHECK(cl::Kernel(*one, "add_one").name() == "add_one");
}

TEST_CASE("contexts of a device that live side by side share programs, those of its parts have their own") {
  const AsInProduct as_in_product;
  const cl::Device whole = cl::find_device("");
  const cl::Context one(whole);
  const auto program = one.program("add_one", kSource, "");
  {
    const cl::Context beside(whole);
    CHECK(beside() == one());
    CHECK(beside.queue() != one.queue());
    CHECK(beside.program("add_one", kSource, "") == program);
  }
  CHECK(one.program("add_one", kSource, "") == program);
  if (!can_be_split(whole)) return;
  const cl::Context part(whole.with_compute_units(1));
  CHECK(part() != one());
  CHECK(part.program("add_one", kSource, "") != program);
}
