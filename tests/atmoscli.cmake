raycube_test(table_difference SOURCES unit/table_difference_test.cpp LIBS raycube::atmos_tables LABELS fast)
raycube_test(table_of_runs SOURCES unit/sixs_table_test.cpp unit/table_of_runs_test.cpp LIBS raycube::atmos_import
  nlohmann_json::nlohmann_json LABELS fast)
foreach(name atmos_compare atmos_build atmos_table atmos_export)
  add_test(NAME ${name} COMMAND /usr/bin/python3 ${CMAKE_CURRENT_LIST_DIR}/cli/${name}_test.py $<TARGET_FILE:raycube>)
  set_tests_properties(${name} PROPERTIES LABELS fast SKIP_RETURN_CODE 77)
endforeach()
