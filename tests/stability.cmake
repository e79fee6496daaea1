# Where methods fail (docs/stability.md): named cases on every device found, and the list that keeps them named.
raycube_test(stability_geometry SOURCES oracle/stability_geometry_test.cpp LIBS raycube_trace_support
  raycube_render_support LABELS fast)
raycube_test(stability_lidar SOURCES oracle/stability_lidar_test.cpp LIBS raycube_lidar_support raycube::lidar
  raycube::render LABELS fast)
raycube_test(stability_render SOURCES oracle/stability_render_test.cpp LIBS raycube_render_support LABELS fast)
raycube_cli_test(stability_machine)
raycube_full_cli_test(stability_machine "a device of 256 MB, which is oclgrind's: ci/setup --full")
add_test(NAME stability_list COMMAND /usr/bin/python3 ${CMAKE_CURRENT_LIST_DIR}/unit/stability_list_test.py
  ${PROJECT_SOURCE_DIR})
set_tests_properties(stability_list PROPERTIES LABELS fast)
raycube_cli_test(oclgrind)
