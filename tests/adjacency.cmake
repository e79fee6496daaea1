# Light between ground and air: environment functions, the map of the environment, and the whole chain.
raycube_test(environment_function SOURCES oracle/environment_function_test.cpp LIBS raycube_atmos_tables LABELS fast)
raycube_test(environment_map SOURCES unit/environment_map_test.cpp LIBS raycube_render_support LABELS fast)
raycube_test(render_adjacency SOURCES oracle/render_adjacency_test.cpp LIBS raycube_render_support LABELS fast)
if(TARGET raycube_reference)
  raycube_test(adjacency_reference SOURCES cross/adjacency_reference_test.cpp
               LIBS raycube::run raycube_test_scenes raycube_reference raycube_render_support LABELS fast device)
endif()
raycube_test(render_adjacency_solver SOURCES oracle/render_adjacency_solver_test.cpp LIBS raycube_render_support
  raycube::atmos_solver LABELS fast)
raycube_test(adjacency_option SOURCES unit/adjacency_option_test.cpp LIBS raycube::scene_compiler LABELS fast)
