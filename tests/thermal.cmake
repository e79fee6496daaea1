# Light that surfaces, sky and air emit.
raycube_test(thermal_tables SOURCES oracle/thermal_tables_test.cpp LIBS raycube::atmos_tables LABELS fast)
raycube_test(thermal_scene SOURCES unit/thermal_scene_test.cpp LIBS raycube::scene_compiler LABELS fast)
raycube_test(render_thermal SOURCES oracle/render_thermal_test.cpp LIBS raycube_render_support LABELS fast device)
if(TARGET raycube_reference)
  raycube_test(thermal_reference SOURCES cross/thermal_reference_test.cpp ../host/cli/check_instrument.cpp support/test_scenes.cpp
               LIBS raycube_reference raycube_render_support LABELS fast device)
endif()
