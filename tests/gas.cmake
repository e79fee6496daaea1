raycube_test(gas_bands SOURCES oracle/gas_bands_test.cpp LIBS raycube::atmos_tables LABELS fast)
raycube_test(gas_lowtran SOURCES oracle/gas_lowtran_test.cpp LIBS raycube_anchor_support raycube::atmos_tables LABELS
  fast)
raycube_test(gas_modtran SOURCES oracle/gas_modtran_test.cpp LIBS raycube_anchor_support raycube::atmos_tables LABELS
  fast)
raycube_test(gas_k_terms SOURCES oracle/gas_k_terms_test.cpp LIBS raycube::atmos_tables LABELS fast)
add_test(NAME gas_restate COMMAND /usr/bin/python3 ${CMAKE_CURRENT_LIST_DIR}/cli/restate_gases_test.py
  ${PROJECT_SOURCE_DIR})
set_tests_properties(gas_restate PROPERTIES LABELS fast SKIP_RETURN_CODE 77)
raycube_test(gas_paths SOURCES oracle/gas_paths_test.cpp LIBS raycube_anchor_support raycube::atmos_tables LABELS fast)
