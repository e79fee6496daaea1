// The message with which a call refuses its input.
#pragma once

#include <doctest/doctest.h>

#include <string>

#include "host/base/error.h"

namespace raycube::testing {

/// The message of the Error of this fault that `act` throws; empty when it throws none.
template <class Act>
std::string refusal(const Act& act, base::Fault fault = base::Fault::input) {
  try {
    act();
  } catch (const base::Error& error) {
    CHECK(error.fault() == fault);
    return error.what();
  }
  return {};
}

}  // namespace raycube::testing
