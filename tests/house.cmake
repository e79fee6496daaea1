# How the sources and pages themselves are kept: what a reader may rely on in all of them.
add_test(NAME line_width COMMAND /usr/bin/python3 ${CMAKE_CURRENT_LIST_DIR}/unit/line_width_test.py
  ${PROJECT_SOURCE_DIR})
set_tests_properties(line_width PROPERTIES LABELS fast)
add_test(NAME function_length COMMAND /usr/bin/python3 ${CMAKE_CURRENT_LIST_DIR}/unit/function_length_test.py
  ${PROJECT_SOURCE_DIR})
set_tests_properties(function_length PROPERTIES LABELS fast)
add_test(NAME requirement_list COMMAND /usr/bin/python3 ${CMAKE_CURRENT_LIST_DIR}/unit/requirement_list_test.py
  ${PROJECT_SOURCE_DIR})
set_tests_properties(requirement_list PROPERTIES LABELS fast)
# docs/tutorial.md as a reader types it.
add_test(NAME tutorial COMMAND ${RAYCUBE_TEST_PYTHON} ${CMAKE_CURRENT_LIST_DIR}/cli/tutorial_test.py
  $<TARGET_FILE:raycube> ${PROJECT_SOURCE_DIR}/docs/tutorial.md)
set_tests_properties(tutorial PROPERTIES LABELS "slow;device")
add_test(NAME page_paths COMMAND /usr/bin/python3 ${CMAKE_CURRENT_LIST_DIR}/unit/page_paths_test.py
  ${PROJECT_SOURCE_DIR})
set_tests_properties(page_paths PROPERTIES LABELS fast)
