raycube_test(planner_law SOURCES unit/planner_law_test.cpp LIBS raycube::planner LABELS fast)
raycube_test(bounce_choice SOURCES oracle/bounce_choice_test.cpp LIBS raycube_render_support raycube::planner LABELS
  fast device)
raycube_test(open_share SOURCES oracle/open_share_test.cpp LIBS raycube_render_support raycube::planner LABELS fast)
raycube_test(planner_trial SOURCES oracle/planner_trial_test.cpp LIBS raycube_render_support raycube::planner
  nlohmann_json::nlohmann_json LABELS slow)
raycube_full_test(planner_trial "a point spread to a tolerance of 1 %: four times the samples")
raycube_test(planner_measure SOURCES oracle/planner_measure_test.cpp LIBS raycube_render_support raycube::planner
  LABELS slow)
raycube_full_test(planner_measure "twice the pixels, and the third figure of chosen materials")
raycube_test(planner_honest SOURCES oracle/planner_honest_test.cpp LIBS raycube_render_support raycube::planner LABELS
  slow)
raycube_cli_test(plan_cli)
raycube_test(model_trial SOURCES oracle/model_trial_test.cpp LIBS raycube_test_scenes raycube_render_support
  raycube::planner LABELS fast device)
raycube_test(lidar_slopes SOURCES oracle/lidar_slopes_test.cpp LIBS raycube_lidar_support raycube::planner LABELS
  fast device)
raycube_test(planner_pulses SOURCES oracle/planner_pulses_test.cpp LIBS raycube_lidar_support raycube::planner LABELS
  fast device)
