# Light that surfaces, sky and air emit.
raycube_test(thermal_tables SOURCES oracle/thermal_tables_test.cpp LIBS raycube::atmos_tables LABELS fast)
raycube_test(thermal_scene SOURCES unit/thermal_scene_test.cpp LIBS raycube::scene_compiler LABELS fast)
raycube_test(render_thermal SOURCES oracle/render_thermal_test.cpp LIBS raycube_render_support LABELS fast device)
raycube_test(render_warm_bounces SOURCES oracle/render_warm_bounces_test.cpp
             LIBS raycube::run raycube_test_scenes raycube_render_support LABELS device)
raycube_test(render_lobe_heat SOURCES oracle/render_lobe_heat_test.cpp LIBS raycube_render_support LABELS fast
  device LOOPS)
raycube_test(lobe_albedo SOURCES oracle/lobe_albedo_test.cpp LIBS raycube::scene_matter LABELS fast LOOPS)
raycube_full_test(lobe_albedo "every shape in the middle of its parameters' ranges too")
raycube_test(render_heat SOURCES oracle/render_heat_test.cpp LIBS raycube_render_support LABELS fast device)
if(TARGET raycube_reference)
  raycube_test(thermal_reference SOURCES cross/thermal_reference_test.cpp
               LIBS raycube::run raycube_test_scenes raycube_reference raycube_render_support LABELS fast device)
  raycube_full_test(thermal_reference "a village's paths five times, of four times the directions: two minutes")
endif()
add_test(NAME thermal_cli COMMAND /usr/bin/python3 ${CMAKE_CURRENT_LIST_DIR}/cli/thermal_cli_test.py
  $<TARGET_FILE:raycube>)
set_tests_properties(thermal_cli PROPERTIES LABELS device SKIP_RETURN_CODE 77)
