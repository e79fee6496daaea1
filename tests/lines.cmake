raycube_test(lines_voigt SOURCES oracle/lines_voigt_test.cpp LIBS raycube::atmos_lines LABELS fast)
raycube_test(lines_hitran_par SOURCES unit/hitran_par_test.cpp unit/tabulated_absorber_test.cpp LIBS
  raycube::atmos_lines LABELS fast)
raycube_test(lines_methane SOURCES oracle/lines_methane_test.cpp LIBS raycube_anchor_support raycube::atmos_lines LABELS
  fast)
raycube_test(lines_sums SOURCES oracle/lines_sums_test.cpp LIBS raycube::atmos_lines LABELS fast)
raycube_test(lidar_profiles SOURCES oracle/lidar_profiles_test.cpp LIBS raycube_anchor_support raycube::atmos_compiler
  LABELS fast)
raycube_test(layered_lines SOURCES oracle/layered_lines_test.cpp LIBS raycube::atmos_compiler LABELS fast)
add_test(NAME cli_lidar COMMAND /usr/bin/python3 ${CMAKE_CURRENT_LIST_DIR}/cli/lidar_cli_test.py $<TARGET_FILE:raycube>
                                ${CMAKE_BINARY_DIR}/tests/cli_lidar)
set_tests_properties(cli_lidar PROPERTIES LABELS fast)
