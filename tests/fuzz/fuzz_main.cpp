// libFuzzer's entry points. RAYCUBE_FUZZ_TARGET names the target (targets.cpp); without it the list is printed.
#include <cstdio>
#include <cstdlib>

#include "tests/fuzz/targets.h"

namespace {
const raycube::fuzz::Target* chosen = nullptr;
}

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  const char* name = std::getenv("RAYCUBE_FUZZ_TARGET");
  chosen = name ? raycube::fuzz::find_target(name) : nullptr;
  if (chosen) return 0;
  std::fprintf(stderr, "fuzz: set RAYCUBE_FUZZ_TARGET to one of:\n");
  for (const auto& target : raycube::fuzz::targets())
    if (!target.by_others) std::printf("%s\n", target.name);
  std::exit(name ? 2 : 0);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t bytes) {
  raycube::fuzz::feed(*chosen, data, bytes);
  return 0;
}
