add_library(raycube_lidar_support STATIC support/lidar_kit.cpp)
target_link_libraries(raycube_lidar_support PUBLIC raycube_warnings raycube::lidar raycube::scene_bvh)
raycube_test(lidar_link SOURCES oracle/lidar_link_test.cpp LIBS raycube_lidar_support raycube::render LABELS fast)
raycube_test(lidar_surfaces SOURCES oracle/lidar_surfaces_test.cpp LIBS raycube_lidar_support raycube::render LABELS
  fast)
raycube_test(lidar_lobes SOURCES oracle/lidar_lobes_test.cpp LIBS raycube_lidar_support raycube::render LABELS fast)
raycube_test(lobe_forms SOURCES oracle/lobe_forms_test.cpp LIBS raycube_scene_compiler LABELS fast)
raycube_test(materials SOURCES oracle/materials_test.cpp LIBS raycube_probes raycube_scene_compiler LABELS
  fast LOOPS)
raycube_full_test(materials "twice the draws of every shape")
raycube_test(lidar_bounce SOURCES oracle/lidar_bounce_test.cpp LIBS raycube_lidar_support raycube::render LABELS fast)
raycube_test(lidar_air_return SOURCES oracle/lidar_air_return_test.cpp LIBS raycube_lidar_support raycube::render LABELS
  fast)
raycube_test(lidar_media SOURCES oracle/lidar_media_test.cpp LIBS raycube_lidar_support raycube::render raycube::lidar
  LABELS fast)
raycube_test(lidar_air_limits SOURCES oracle/lidar_air_limits_test.cpp LIBS raycube_reference raycube_lidar_support
  raycube::render LABELS fast)
