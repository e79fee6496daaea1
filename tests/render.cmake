add_library(raycube_render_support STATIC support/render_kit.cpp)
target_link_libraries(raycube_render_support PUBLIC raycube_warnings raycube::render raycube::sensors raycube::plan
                      raycube::scene_bvh raycube::atmos_tables)
raycube_test(render_plane SOURCES oracle/render_plane_test.cpp LIBS raycube_render_support LABELS fast)
raycube_test(render_wall SOURCES oracle/render_wall_test.cpp LIBS raycube_render_support LABELS fast)
raycube_test(render_invariance SOURCES oracle/render_invariance_test.cpp support/test_scenes.cpp LIBS raycube_render_support LABELS fast)
raycube_test(render_overflow SOURCES oracle/render_overflow_test.cpp LIBS raycube_render_support LABELS fast)
raycube_test(render_furnace SOURCES oracle/render_furnace_test.cpp LIBS raycube_render_support LABELS fast)
raycube_test(render_checkerboard SOURCES oracle/render_checkerboard_test.cpp LIBS raycube_render_support LABELS fast)
