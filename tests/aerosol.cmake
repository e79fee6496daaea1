raycube_test(aerosol_column SOURCES unit/aerosol_column_test.cpp unit/phase_function_test.cpp
             unit/aerosol_droplets_test.cpp LIBS raycube::atmos_tables LABELS fast)
raycube_test(own_aerosol SOURCES unit/own_aerosol_test.cpp oracle/own_aerosol_table_test.cpp LIBS
  raycube::atmos_compiler nlohmann_json::nlohmann_json LABELS fast)
raycube_test(aerosol_lowtran SOURCES oracle/aerosol_lowtran_test.cpp oracle/moon_test.cpp LIBS raycube_anchor_rows
  raycube::atmos_tables   LABELS fast)
add_test(NAME restate COMMAND /usr/bin/python3 ${CMAKE_CURRENT_LIST_DIR}/cli/restate_test.py ${PROJECT_SOURCE_DIR})
set_tests_properties(restate PROPERTIES LABELS fast SKIP_RETURN_CODE 77)
