# The command line: its frame, and the program itself driven as users drive it.
raycube_test(cli_frame SOURCES unit/cli_frame_test.cpp LIBS raycube_cli_frame nlohmann_json::nlohmann_json LABELS fast)
find_package(Python3 COMPONENTS Interpreter REQUIRED)
add_test(NAME cli COMMAND ${Python3_EXECUTABLE} ${CMAKE_CURRENT_LIST_DIR}/cli/cli_test.py $<TARGET_FILE:raycube>)
add_test(NAME install COMMAND ${Python3_EXECUTABLE} ${CMAKE_CURRENT_LIST_DIR}/cli/install_test.py ${CMAKE_BINARY_DIR} ${CMAKE_COMMAND}
                              ${CMAKE_CPACK_COMMAND})
set_tests_properties(cli install PROPERTIES LABELS fast)
# These read what the program writes with Debian's numpy, which another python3 in the PATH need not have.
set(RAYCUBE_TEST_PYTHON /usr/bin/python3)
function(raycube_cli_test name)
  add_test(NAME ${name} COMMAND ${RAYCUBE_TEST_PYTHON} ${PROJECT_SOURCE_DIR}/tests/cli/${name}_test.py $<TARGET_FILE:raycube> ${ARGN})
  set_tests_properties(${name} PROPERTIES LABELS device SKIP_RETURN_CODE 77)
endfunction()
raycube_cli_test(render_cli ${PROJECT_SOURCE_DIR}/scenes)
raycube_cli_test(render_failures)
raycube_cli_test(bad_input)
raycube_cli_test(real_input)
raycube_cli_test(render_memory)
