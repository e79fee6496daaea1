# The reference path, alone: no device is needed.
raycube_test(double_trace SOURCES oracle/double_trace_test.cpp LIBS raycube_reference raycube_scene_bvh LABELS fast)
raycube_test(reference_includes SOURCES unit/reference_includes_test.cpp LIBS LABELS fast)
raycube_test(reference_radiance SOURCES oracle/reference_radiance_test.cpp LIBS raycube_reference raycube_sensors LABELS
  fast)
raycube_test(table_model SOURCES oracle/table_model_test.cpp LIBS raycube_reference raycube_atmos_tables LABELS fast)
raycube_test(compare SOURCES unit/compare_test.cpp LIBS raycube_reference nlohmann_json::nlohmann_json LABELS fast)
raycube_test(tie_search SOURCES unit/tie_search_test.cpp LIBS raycube_reference LABELS fast)
raycube_test(difference_chart SOURCES unit/difference_chart_test.cpp
             LIBS raycube::run LABELS fast)
if(TARGET raycube_render AND TARGET raycube_plan)
  raycube_test(render_reference SOURCES cross/render_reference_test.cpp
               LIBS raycube::run raycube_reference raycube_render raycube_plan raycube_sensors raycube_scene_bvh LABELS
                 fast device)
  raycube_test(shared_trees SOURCES oracle/shared_trees_test.cpp
               LIBS raycube::run raycube_reference raycube_trace_support LABELS fast device)
  raycube_test(terrain_hits SOURCES cross/terrain_hits_test.cpp
               LIBS raycube::run raycube_bench_scenes raycube_reference raycube_render raycube_scene_bvh LABELS fast
                 device)
  raycube_test(render_relief SOURCES cross/render_relief_test.cpp
               LIBS raycube::run raycube_reference raycube_render_support LABELS fast device)
endif()
