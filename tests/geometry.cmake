# Kernels that tests alone launch, as kernels/CMakeLists.txt embeds the others.
set(probes ${CMAKE_CURRENT_BINARY_DIR}/probe_source.cpp)
file(GLOB_RECURSE kernel_headers CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/kernels/*.h
  ${PROJECT_SOURCE_DIR}/kernels/*.def)
add_custom_command(OUTPUT ${probes}
  COMMAND ${CMAKE_COMMAND} -DROOT=${PROJECT_SOURCE_DIR} -DENTRIES=tests/support/probes.cl -DPREFIX=probe
          -DOUTPUT=${probes} -P ${PROJECT_SOURCE_DIR}/cmake/EmbedKernels.cmake
  DEPENDS ${PROJECT_SOURCE_DIR}/cmake/EmbedKernels.cmake ${CMAKE_CURRENT_LIST_DIR}/support/probes.cl ${kernel_headers}
  VERBATIM COMMENT "Embedding the tests' kernels")
add_library(raycube_probes STATIC support/probes.cpp ${probes})
target_link_libraries(raycube_probes PUBLIC raycube_warnings raycube::cl PRIVATE raycube::kernels)
add_library(raycube_trace_support STATIC support/trace_chain.cpp support/double_trace.cpp support/brute_trace.cpp
  support/any_hits.cpp support/judge_hits.cpp)
target_link_libraries(raycube_trace_support PUBLIC raycube_warnings raycube_probes raycube_test_scenes raycube::render
  raycube::cl raycube::kernels raycube::scene_bvh)

raycube_test(shared_structs SOURCES unit/shared_structs_test.cpp LIBS raycube_trace_support LABELS fast)
raycube_test(block_order SOURCES unit/block_order_test.cpp LIBS raycube::scene_bvh LABELS fast)
raycube_test(tile_layout SOURCES unit/tile_layout_test.cpp LIBS raycube_trace_support LABELS fast)
raycube_test(trace_hits SOURCES oracle/trace_hits_test.cpp LIBS raycube_trace_support LABELS fast)
raycube_test(trace_leaks SOURCES oracle/trace_leaks_test.cpp LIBS raycube_trace_support LABELS slow)
raycube_full_test(trace_leaks "1e7 rays at edges and as many over terrain: half a minute")
raycube_test(trace_ties SOURCES oracle/trace_ties_test.cpp LIBS raycube_trace_support LABELS fast)
raycube_test(trace_sun SOURCES oracle/trace_sun_test.cpp LIBS raycube_trace_support LABELS fast)
raycube_test(skyline SOURCES oracle/skyline_test.cpp LIBS raycube_trace_support raycube::reference LABELS fast)
raycube_test(trace_sky SOURCES oracle/trace_sky_test.cpp LIBS raycube_trace_support raycube::reference LABELS fast)

add_test(NAME kernel_parse COMMAND ${CMAKE_COMMAND} -DROOT=${PROJECT_SOURCE_DIR} -P
  ${PROJECT_SOURCE_DIR}/tests/unit/kernel_parse_test.cmake
  WORKING_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR})
set_tests_properties(kernel_parse PROPERTIES LABELS fast SKIP_REGULAR_EXPRESSION "SKIPPED")

raycube_test(scene_fit SOURCES unit/scene_fit_test.cpp LIBS raycube::render LABELS fast)
raycube_test(scene_pages SOURCES oracle/scene_pages_test.cpp LIBS raycube::render raycube_probes LABELS fast)
