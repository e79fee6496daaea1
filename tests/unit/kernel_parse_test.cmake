# Parses every kernel entry with each clang that is installed: no warning, no double (a device without fp64 must build
# them), nothing promoted.
#   cmake -DROOT=repository -P kernel_parse_test.cmake
cmake_policy(VERSION 3.23)
set(flags -x cl -cl-std=CL1.2 -Xclang -cl-ext=-cl_khr_fp64 -Xclang -finclude-default-header -fsyntax-only
  -Wall -Wextra -Wno-unused-parameter -Wdouble-promotion -Werror -I${ROOT})

function(parse_text clang text result log)
  set(file ${CMAKE_CURRENT_BINARY_DIR}/kernel_parse_probe.cl)
  file(WRITE ${file} "${text}")
  execute_process(COMMAND ${clang} ${flags} ${file} RESULT_VARIABLE status ERROR_VARIABLE errors)
  file(REMOVE ${file})
  set(${result} "${status}" PARENT_SCOPE)
  set(${log} "${errors}" PARENT_SCOPE)
endfunction()

set(clangs "")
set(versions "")
set(why "")
foreach(name IN ITEMS clang clang-14 clang-15 clang-16 clang-17 clang-18 clang-19)
  find_program(found_${name} NAMES ${name})
  if(NOT found_${name})
    continue()
  endif()
  parse_text(${found_${name}} "kernel void k(global float* a) { a[0] = fma(a[1], 2.0f, a[2]); }\n" plain plain_log)
  if(plain)
    string(APPEND why "${plain_log}")
    continue()
  endif()
  parse_text(${found_${name}} "kernel void k(global float* a) { a[0] = a[1] * 2.0; }\n" doubled doubled_log)
  if(NOT doubled)
    message(FATAL_ERROR "${found_${name}} took a double constant: the flags of this test show nothing")
  endif()
  execute_process(COMMAND ${found_${name}} --version OUTPUT_VARIABLE version)
  if(NOT version IN_LIST versions)
    list(APPEND versions "${version}")
    list(APPEND clangs ${found_${name}})
  endif()
endforeach()
if(NOT clangs)
  message("SKIPPED: kernel_parse needs clang with its OpenCL header (apt-get install clang). ${why}")
  return()
endif()
message("parsing with ${clangs}")

set(matter -DRC_SHAPED=1 -DRC_THROUGH=1 -DRC_PLATES=1 -DRC_GLOSSY=1)
set(further ${matter} -DRC_FURTHER=8 -DRC_FURTHER_RECORDS=8)
string(REPLACE ";" " " matter "${matter}")
string(REPLACE ";" " " further "${further}")
set(failures "")
foreach(packed IN ITEMS
    "probe_structs.cl -"
    "trace_primary.cl -" "trace_primary.cl -DRC_GRID=1" "trace_primary.cl -DRC_PAGED=1"
    "trace_primary.cl -DRC_GRID=1 -DRC_PAGED=1"
    "trace_primary.cl -DRC_CHUNK_SAMPLES=48"
    "trace_light.cl -" "trace_light.cl -DRC_THROUGH=1" "trace_light.cl ${matter}" "trace_light.cl ${further}"
    "trace_light.cl -DRC_FURTHER_RECORDS=8 -DRC_THROUGH=1" "trace_light.cl -DRC_THROUGH=1 -DRC_PAGED=1"
    "trace_light.cl -DRC_CHUNK_SAMPLES=48 -DRC_MOST_LIGHTS=3"
    "trace_bounce.cl -" "trace_bounce.cl -DRC_SKELETON=32" "trace_bounce.cl -DRC_THROUGH=1" "trace_bounce.cl ${matter}"
    "trace_bounce.cl ${further} -DRC_SKELETON=32"
    "rows.cl -" "rows.cl -DRC_THROUGH=1" "rows.cl ${matter}" "rows.cl ${further}"
    "rows.cl -DRC_FURTHER_RECORDS=8 -DRC_THROUGH=1" "rows.cl -DRC_CHUNK_SAMPLES=48 -DRC_MOST_LIGHTS=3"
    "rows.cl -DRC_PAGED=1"
    "trace_photons.cl -DRC_STACK=96"
    "trace_photons.cl -DRC_STACK=96 -DRC_SHAPED=1 -DRC_THROUGH=1 -DRC_PAGED=1"
    "lidar_shots.cl -" "lidar_shots.cl -DRC_FEATURES=RC_FEATURES_PLAIN -DRC_ROW_WINDOW=4096"
    "lidar_shots.cl -DRC_FEATURES=RC_FEATURES_SURVEY -DRC_PAGED=1"
    "lidar_shots.cl -DRC_FEATURES=RC_FEATURES_ALL -DRC_MOST_LINES=16"
    "lidar_air.cl -" "lidar_air.cl -DRC_FEATURES=RC_FEATURES_ALL -DRC_MOST_LINES=16" "lidar_beam.cl -"
    "lidar_beam.cl -DRC_FEATURES=RC_FEATURES_ALL")
  separate_arguments(words UNIX_COMMAND "${packed}")
  list(POP_FRONT words entry)
  if(entry MATCHES "^trace_(primary|light|bounce)")
    list(APPEND words -DRC_STACK=92)
  elseif(entry STREQUAL "lidar_shots.cl")
    list(APPEND words -DRC_STACK=96)
  endif()
  list(REMOVE_ITEM words "-")
  foreach(clang IN LISTS clangs)
    execute_process(COMMAND ${clang} ${flags} ${words} ${ROOT}/kernels/entry/${entry} RESULT_VARIABLE status
      ERROR_VARIABLE errors)
    if(status)
      string(APPEND failures "${clang} ${entry} ${words}:\n${errors}\n")
    endif()
  endforeach()
endforeach()
if(failures)
  message(FATAL_ERROR "${failures}")
endif()
