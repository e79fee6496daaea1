raycube_test(atmos_physics SOURCES oracle/atmos_scatter_test.cpp oracle/bird_riordan_test.cpp LIBS raycube::atmos_tables
  LABELS fast)
raycube_test(atmos_interpolate SOURCES unit/atmos_interpolate_test.cpp LIBS raycube::atmos_tables LABELS fast)
raycube_test(atmos_clear_sky SOURCES oracle/clear_sky_test.cpp oracle/clear_sky_anchor_test.cpp LIBS
  raycube_anchor_rows raycube::atmos_tables LABELS fast)
raycube_test(solar_choice SOURCES oracle/solar_choice_test.cpp LIBS raycube::atmos_compiler
  nlohmann_json::nlohmann_json LABELS fast)
raycube_test(view_zenith SOURCES oracle/view_zenith_test.cpp LIBS raycube::atmos_compiler LABELS fast)
raycube_test(atmos_rct_file SOURCES unit/rct_file_test.cpp LIBS raycube::atmos_tables nlohmann_json::nlohmann_json
  LABELS fast)
add_test(NAME cli_atmos COMMAND /usr/bin/python3 ${CMAKE_CURRENT_SOURCE_DIR}/cli/atmos_cli_test.py
  $<TARGET_FILE:raycube>
                                ${CMAKE_BINARY_DIR}/tests/cli_atmos)
set_tests_properties(cli_atmos PROPERTIES LABELS fast)
