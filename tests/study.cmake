raycube_test(study_figures SOURCES unit/study_figures_test.cpp LIBS raycube::study LABELS fast)
raycube_test(study_kept SOURCES unit/study_kept_test.cpp LIBS raycube::study LABELS fast)
raycube_test(study_converged SOURCES oracle/study_converged_test.cpp LIBS raycube::study raycube_render_support LABELS
  fast)
add_test(NAME chart_cli COMMAND /usr/bin/python3 ${PROJECT_SOURCE_DIR}/tests/cli/chart_test.py $<TARGET_FILE:raycube>
  ${CMAKE_BINARY_DIR}/tests/chart)
set_tests_properties(chart_cli PROPERTIES LABELS "slow;device")
raycube_full_cli_test(chart "two charts more against a reference that is kept" ${CMAKE_BINARY_DIR}/tests/chart_full)
