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

set(rows -DRC_CHUNK_SAMPLES=121 -DRC_COMPONENTS=4 -DRC_HEIGHTS=2 -DRC_VIEWS=2 -DRC_PATH_X=2 -DRC_PATH_Y=2
  -DRC_CHANNELS=9 -DRC_PIXELS_PER_GROUP=4)
set(failures "")
foreach(packed IN ITEMS
    "rows.cl 0" "rows.cl 1" "rows.cl 0 -DRC_SUN=0 -DRC_THERMAL_COMPONENTS=2 -DRC_TEMPERATURES=3" "trace_light.cl
      -DRC_SKY_PLANES=8"
    "trace_light.cl -DRC_SKY_PLANES=8 -DRC_BUNDLE=0" "probe_structs.cl -" "trace_primary.cl -DRC_SCATTER=0"
    "trace_primary.cl -DRC_SCATTER=1"
    "trace_primary.cl -DRC_SCATTER=1 -DRC_SUPPORT=1.5f" "trace_primary.cl -DRC_MOVING=1 -DRC_PIXELS_PER_GROUP=1"
    "trace_primary.cl -DRC_BUNDLE=0" "trace_light.cl -DRC_MOVING=1 -DRC_PIXELS_PER_GROUP=1" "trace_light.cl
      -DRC_BUNDLE=0"
    "trace_primary.cl -DRC_NODE_PAGES=2 -DRC_NODE_SHIFT=12 -DRC_BLOCK_PAGES=8 -DRC_BLOCK_SHIFT=10
      -DRC_INSTANCE_PAGES=3 -DRC_INSTANCE_SHIFT=0"
    "trace_primary.cl -DRC_SCATTER=1 -DRC_NODE_PAGES=2 -DRC_NODE_SHIFT=12"
    "trace_light.cl -DRC_THROUGH=1 -DRC_NODE_PAGES=2 -DRC_NODE_SHIFT=12 -DRC_BLOCK_PAGES=8 -DRC_BLOCK_SHIFT=10"
    "trace_light.cl -DRC_SHAPED=1" "trace_light.cl -DRC_BUNDLE=0 -DRC_SHAPED=1" "rows.cl 0 -DRC_SHAPED=1"
    "trace_light.cl -DRC_THROUGH=1"
    "rows.cl 0 -DRC_THROUGH=1 -DRC_MATERIALS=7" "rows.cl 1 -DRC_THROUGH=1 -DRC_MATERIALS=7 -DRC_SHAPED=1"
    "trace_light.cl -DRC_GLOSSY=1 -DRC_SHAPED=1" "trace_light.cl -DRC_GLOSSY=1 -DRC_SHAPED=1 -DRC_THROUGH=1"
    "trace_light.cl -DRC_THROUGH=1 -DRC_FIRST_OPAQUE=1"
    "rows.cl 0 -DRC_GLOSSY=1 -DRC_SHAPED=1 -DRC_THROUGH=1 -DRC_MATERIALS=7"
    "trace_bounce.cl -DRC_SKELETON=32 -DRC_SUN=1 -DRC_MATERIALS=7"
    "trace_bounce.cl -DRC_SKELETON=16 -DRC_SUN=0 -DRC_MATERIALS=7 -DRC_GLOSSY=1 -DRC_SHAPED=1 -DRC_THROUGH=1"
    "trace_light.cl -DRC_LAMPS=2 -DRC_THROUGH=1 -DRC_SKY_PLANES=8"
    "trace_light.cl -DRC_LAMPS=1 -DRC_GLOSSY=1 -DRC_SHAPED=1"
    "trace_bounce.cl -DRC_LAMPS=1 -DRC_SKELETON=16 -DRC_MATERIALS=7 -DRC_GLOSSY=1 -DRC_SHAPED=1"
    "trace_light.cl -DRC_FURTHER=2 -DRC_FURTHER_RECORDS=2 -DRC_SHAPED=1"
    "trace_light.cl -DRC_BUNDLE=0 -DRC_FURTHER=1 -DRC_SHAPED=1"
    "trace_light.cl -DRC_FURTHER=3 -DRC_FURTHER_RECORDS=3 -DRC_SHAPED=1 -DRC_GLOSSY=1 -DRC_THROUGH=1 -DRC_LAMPS=1"
    "trace_bounce.cl -DRC_FURTHER=3 -DRC_FURTHER_RECORDS=3 -DRC_SHAPED=1 -DRC_GLOSSY=1 -DRC_THROUGH=1 -DRC_LAMPS=1
      -DRC_SKELETON=16 -DRC_MATERIALS=7 -DRC_PATH_LOG=1"
    "trace_light.cl -DRC_FURTHER_RECORDS=2 -DRC_THROUGH=1"
    "rows.cl 0 -DRC_FURTHER=3 -DRC_FURTHER_RECORDS=3 -DRC_SHAPED=1 -DRC_GLOSSY=1 -DRC_THROUGH=1 -DRC_MATERIALS=7"
    "rows.cl 0 -DRC_LAMPS=2 -DRC_SKY_PLANES=8 -DRC_SKELETON=32 -DRC_MATERIALS=7"
    "trace_photons.cl -DRC_STACK=96"
    "trace_photons.cl -DRC_STACK=96 -DRC_SHAPED=1 -DRC_THROUGH=1 -DRC_NODE_PAGES=2 -DRC_NODE_SHIFT=12"
    "lidar_shots.cl -" "lidar_shots.cl -DRC_FEATURES=RC_FEATURES_PLAIN -DRC_ROW_WINDOW=4096"
    "lidar_shots.cl -DRC_FEATURES=RC_FEATURES_SURVEY -DRC_NODE_PAGES=2 -DRC_NODE_SHIFT=4"
    "lidar_shots.cl -DRC_FEATURES=RC_FEATURES_ALL -DRC_MOST_LINES=16"
    "lidar_air.cl -" "lidar_air.cl -DRC_FEATURES=RC_FEATURES_ALL -DRC_MOST_LINES=16" "lidar_beam.cl -"
    "lidar_beam.cl -DRC_FEATURES=RC_FEATURES_ALL"
    "rows.cl 0 -DRC_BLOCK_PAGES=7 -DRC_BLOCK_SHIFT=28 -DRC_SURFACE_PAGES=8 -DRC_SURFACE_SHIFT=15")
  separate_arguments(words UNIX_COMMAND "${packed}")
  list(POP_FRONT words entry)
  if(entry STREQUAL "rows.cl")
    list(POP_FRONT words chunked)
    list(APPEND words ${rows} -DRC_CHUNKED=${chunked})
  elseif(entry MATCHES "^trace_(primary|light|bounce)")
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
