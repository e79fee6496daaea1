# The command line: its frame, and the program itself driven as users drive it.
raycube_test(cli_frame SOURCES unit/cli_frame_test.cpp LIBS raycube_cli_frame nlohmann_json::nlohmann_json LABELS fast)
raycube_test(air_request SOURCES unit/air_request_test.cpp LIBS raycube::run raycube::scene_compiler
  nlohmann_json::nlohmann_json LABELS fast)
find_package(Python3 COMPONENTS Interpreter REQUIRED)
add_test(NAME cli COMMAND ${Python3_EXECUTABLE} ${CMAKE_CURRENT_LIST_DIR}/cli/cli_test.py $<TARGET_FILE:raycube>)
add_test(NAME install COMMAND ${Python3_EXECUTABLE} ${CMAKE_CURRENT_LIST_DIR}/cli/install_test.py ${CMAKE_BINARY_DIR}
  ${CMAKE_COMMAND}
                              ${CMAKE_CPACK_COMMAND})
add_test(NAME soak COMMAND ${Python3_EXECUTABLE} ${CMAKE_CURRENT_LIST_DIR}/cli/soak_test.py ${PROJECT_SOURCE_DIR})
set_tests_properties(cli install soak PROPERTIES LABELS fast)
# These read what the program writes with Debian's numpy, which another python3 in the PATH need not have.
set(RAYCUBE_TEST_PYTHON /usr/bin/python3)
function(raycube_cli_test name)
  add_test(NAME ${name} COMMAND ${RAYCUBE_TEST_PYTHON} ${PROJECT_SOURCE_DIR}/tests/cli/${name}_test.py
    $<TARGET_FILE:raycube> ${ARGN})
  set_tests_properties(${name} PROPERTIES LABELS device SKIP_RETURN_CODE 77)
endfunction()
add_test(NAME digests COMMAND ${RAYCUBE_TEST_PYTHON} ${CMAKE_CURRENT_LIST_DIR}/golden/digests_test.py
  $<TARGET_FILE:raycube>
                              ${CMAKE_CURRENT_LIST_DIR}/golden/digests)
set_tests_properties(digests PROPERTIES LABELS device SKIP_RETURN_CODE 77)
raycube_cli_test(render_cli ${PROJECT_SOURCE_DIR}/scenes)
raycube_cli_test(shapes)
raycube_cli_test(preview)
raycube_cli_test(check_cli ${PROJECT_SOURCE_DIR}/scenes)
raycube_cli_test(explain)
raycube_cli_test(import_limits)
raycube_cli_test(low_sun)
raycube_cli_test(render_failures)
raycube_cli_test(kernel_cache)
raycube_cli_test(input_check)
raycube_cli_test(run_files)
raycube_cli_test(input_limits)
raycube_cli_test(memory_bound)
raycube_cli_test(bad_input)
raycube_cli_test(air_input)
raycube_cli_test(real_input)
raycube_cli_test(real_air)
raycube_cli_test(render_memory)
raycube_cli_test(newcomer)
raycube_cli_test(standard_error)
raycube_cli_test(small_objects)
raycube_cli_test(tune_cli)
if(RAYCUBE_BENCH)
  raycube_cli_test(bench_programs $<TARGET_FILE_DIR:raycube>/raycube_bench)
endif()
# What verbs call, called by a program that is none.
raycube_test(run_library SOURCES unit/run_library_test.cpp LIBS raycube::run LABELS fast device)
