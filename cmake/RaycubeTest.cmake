# raycube_test(name SOURCES a.cpp LIBS lib... LABELS fast|slow|device [ALONE] [LOOPS]): doctest cases that are one test
# and a target test_<name> that makes the command build/tests/test_<name>, which runs them alone. tests/test_main.cpp
# supplies main(), compiled once for all. Names of doctest cases carry the S-numbers they show.
# With RAYCUBE_UNITY the tests of a group (the variable RAYCUBE_TEST_GROUP) are one executable whose sources are
# compiled 24 at a time (TestUnit.cmake): half of the time of small sources is the same headers over again. ALONE:
# a test that replaces functions of the C library, or reads its own program's name, has an executable of its own.
# LOOPS: its own code loops over millions of samples, and is optimised like a library.
# raycube_full_test(name reason): all cases of a test whose short form (tests/support/full.h) runs with the others: with
# ci/test --full alone.
add_library(raycube_test_main OBJECT ${PROJECT_SOURCE_DIR}/tests/test_main.cpp)
target_link_libraries(raycube_test_main PRIVATE raycube_warnings raycube_base)
# A test's own code runs for moments and is compiled each time, so it is hardly optimised; what it tests is. -Og takes
# as long as -O0, and templates that a test and a library both use stay quick: the linker takes the test's copy. Checks
# that throw end their case instead of being counted. -pthread: some libraries ask for it, and headers that are compiled
# once want the same options everywhere.
set(raycube_test_options -Og -pthread -DDOCTEST_CONFIG_SUPER_FAST_ASSERTS
  -DRAYCUBE_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
set(raycube_test_loops COMPILE_OPTIONS -O2 SKIP_PRECOMPILE_HEADERS ON)
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
function(raycube_test_program target sources libs)
  add_executable(${target} ${sources} $<TARGET_OBJECTS:raycube_test_main>)
  raycube_test_code(${target})
  if(RAYCUBE_UNITY)
    target_precompile_headers(${target} REUSE_FROM raycube_test_main)
  endif()
  target_link_libraries(${target} PRIVATE ${libs} raycube_base)
  target_link_options(${target} PRIVATE LINKER:--export-dynamic-symbol=abort)
endfunction()
function(raycube_test name)
  cmake_parse_arguments(T "ALONE;LOOPS" "" "SOURCES;LIBS;LABELS" ${ARGN})
  if(T_LOOPS)
    set_source_files_properties(${T_SOURCES} PROPERTIES ${raycube_test_loops})
  endif()
  if(T_ALONE OR NOT RAYCUBE_UNITY)
    raycube_test_program(test_${name} "${T_SOURCES}" "${T_LIBS}")
    add_test(NAME ${name} COMMAND test_${name})
  else()
    set(group tests_of_${RAYCUBE_TEST_GROUP})
    list(TRANSFORM T_SOURCES PREPEND "*/" OUTPUT_VARIABLE cases)
    list(JOIN cases "," cases)
    list(TRANSFORM T_SOURCES PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/)
    set_property(GLOBAL APPEND PROPERTY raycube_test_groups ${group})
    if(T_LOOPS)
      set_property(GLOBAL APPEND PROPERTY ${group}_loops ${T_SOURCES})
    else()
      set_property(GLOBAL APPEND PROPERTY ${group}_sources ${T_SOURCES})
    endif()
    set_property(GLOBAL APPEND PROPERTY ${group}_libs ${T_LIBS})
    add_test(NAME ${name} COMMAND ${group} --source-file=${cases})
    add_custom_target(test_${name} DEPENDS ${group})
    file(GENERATE OUTPUT ${CMAKE_BINARY_DIR}/tests/test_${name}
      CONTENT "#!/bin/sh\nexec '$<TARGET_FILE:${group}>' '--source-file=${cases}' \"$@\"\n"
      FILE_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
  endif()
  set_tests_properties(${name} PROPERTIES LABELS "${T_LABELS}" SKIP_RETURN_CODE 77)
endfunction()
function(raycube_full_test name reason)
  add_test(NAME ${name}_full COMMAND ${CMAKE_BINARY_DIR}/tests/test_${name})
  set_tests_properties(${name}_full PROPERTIES LABELS full ENVIRONMENT RAYCUBE_FULL=1 SKIP_RETURN_CODE 77)
endfunction()
# raycube_test_groups(): the executables of all groups, once every test is named.
function(raycube_test_groups)
  get_property(groups GLOBAL PROPERTY raycube_test_groups)
  list(REMOVE_DUPLICATES groups)
  set(script ${PROJECT_SOURCE_DIR}/cmake/TestUnit.cmake)
  foreach(group IN LISTS groups)
    get_property(libs GLOBAL PROPERTY ${group}_libs)
    list(REMOVE_DUPLICATES libs)
    set(units "")
    foreach(kind IN ITEMS loops sources)
      get_property(sources GLOBAL PROPERTY ${group}_${kind})
      while(sources)
        list(SUBLIST sources 0 24 some)
        list(REMOVE_ITEM sources ${some})
        list(LENGTH units number)
        set(unit ${CMAKE_CURRENT_BINARY_DIR}/units/${group}_${number}.cpp)
        list(JOIN some "|" joined)
        add_custom_command(OUTPUT ${unit} COMMAND ${CMAKE_COMMAND} "-DSOURCES=${joined}" -DOUTPUT=${unit} -P ${script}
          DEPENDS ${some} ${script} VERBATIM)
        if(kind STREQUAL loops)
          set_source_files_properties(${unit} PROPERTIES ${raycube_test_loops})
        endif()
        list(APPEND units ${unit})
      endwhile()
    endforeach()
    raycube_test_program(${group} "${units}" "${libs}")
  endforeach()
endfunction()
