raycube_test(knobs SOURCES unit/knobs_test.cpp LIBS raycube_render_support raycube::knobs nlohmann_json::nlohmann_json
  LABELS fast)
raycube_test(plan_given SOURCES unit/plan_given_test.cpp LIBS raycube::scene_compiler LABELS fast)
