# raycube_test(name SOURCES a.cpp LIBS lib... LABELS fast|slow|device): one doctest executable that is one ctest test.
# tests/test_main.cpp supplies main(), compiled once for all. Names of doctest cases carry the S-numbers they show.
add_library(raycube_test_main OBJECT ${PROJECT_SOURCE_DIR}/tests/test_main.cpp)
target_link_libraries(raycube_test_main PRIVATE raycube_warnings raycube_base)
# A test's own code runs for moments and is compiled each time, so it is not optimised; what it tests is. Checks that
# throw end their case instead of being counted. -pthread: some libraries ask for it, and headers that are compiled once
# want the same options everywhere.
set(raycube_test_options -O0 -pthread -DDOCTEST_CONFIG_SUPER_FAST_ASSERTS)
if(RAYCUBE_UNITY)  # g++ 12 takes what those headers inline for the test's own, and warns of copies that cannot be
  list(APPEND raycube_test_options -Wno-array-bounds -Wno-stringop-overflow)
endif()
target_compile_options(raycube_test_main PRIVATE ${raycube_test_options})
if(RAYCUBE_UNITY)
  target_precompile_headers(raycube_test_main PRIVATE <doctest/doctest.h> <algorithm> <array> <cmath> <filesystem>
    <fstream> <functional> <map> <memory> <numbers> <optional> <random> <set> <sstream> <string> <vector>)
endif()
find_program(RAYCUBE_GOLD ld.gold)  # of Debian's binutils: links these in half the time of ld.bfd
# raycube_test_code(target): the program's own code is a test's, or makes what tests read.
function(raycube_test_code target)
  target_link_libraries(${target} PRIVATE raycube_warnings)
  target_compile_options(${target} PRIVATE ${raycube_test_options})
  if(RAYCUBE_GOLD AND NOT RAYCUBE_SANITIZE)
    target_link_options(${target} PRIVATE -fuse-ld=gold)
  endif()
  set_target_properties(${target} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
endfunction()
function(raycube_test name)
  cmake_parse_arguments(T "" "" "SOURCES;LIBS;LABELS" ${ARGN})
  add_executable(test_${name} ${T_SOURCES} $<TARGET_OBJECTS:raycube_test_main>)
  raycube_test_code(test_${name})
  if(RAYCUBE_UNITY)
    target_precompile_headers(test_${name} REUSE_FROM raycube_test_main)
  endif()
  target_link_libraries(test_${name} PRIVATE ${T_LIBS} raycube_base)
  target_link_options(test_${name} PRIVATE LINKER:--export-dynamic-symbol=abort)
  add_test(NAME ${name} COMMAND test_${name})
  set_tests_properties(${name} PROPERTIES LABELS "${T_LABELS}" SKIP_RETURN_CODE 77)
endfunction()
