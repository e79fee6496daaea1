# The list of faults stays true: run.py itself takes ten minutes and is started by hand (tests/mutation/caught.md).
if(NOT RAYCUBE_MUTATION)
  add_test(NAME mutation_list COMMAND /usr/bin/python3 ${CMAKE_CURRENT_LIST_DIR}/mutation/list_test.py
    ${PROJECT_SOURCE_DIR})
  set_tests_properties(mutation_list PROPERTIES LABELS fast)
endif()
