add_library(raycube_render_support STATIC support/render_kit.cpp)
target_link_libraries(raycube_render_support PUBLIC raycube_warnings raycube::render raycube::sensors raycube::plan
                      raycube::scene_bvh raycube::atmos_tables)
raycube_test(render_shapes SOURCES oracle/render_shapes_test.cpp LIBS raycube_render_support LABELS fast LOOPS)
raycube_test(render_spectral_shapes SOURCES oracle/render_spectral_shapes_test.cpp LIBS raycube_render_support LABELS
  fast LOOPS)
raycube_test(render_gloss SOURCES oracle/render_gloss_test.cpp LIBS raycube_render_support LABELS fast)
raycube_test(render_lamps SOURCES oracle/render_lamps_test.cpp LIBS raycube_render_support LABELS fast)
raycube_test(render_leaves SOURCES oracle/render_leaves_test.cpp LIBS raycube_render_support LABELS fast)
raycube_test(render_plates SOURCES oracle/render_plates_test.cpp LIBS raycube_render_support LABELS fast)
raycube_test(render_bounces SOURCES oracle/render_bounces_test.cpp LIBS raycube_render_support raycube_test_scenes
  LABELS fast)
raycube_test(photons SOURCES oracle/photons_test.cpp LIBS raycube::run raycube_render_support LABELS fast)
if(TARGET raycube_reference)
  raycube_test(bounces_reference SOURCES cross/bounces_reference_test.cpp
               LIBS raycube::run raycube_test_scenes raycube_reference raycube_render_support LABELS fast device)
  raycube_full_test(bounces_reference "three woods more, and four times the paths of mirrors and panes")
endif()
# Without a device: what takes the strips.
raycube_test(any_order SOURCES unit/any_order_test.cpp LIBS raycube::run raycube_render_support LABELS fast)
raycube_test(render_plane SOURCES oracle/render_plane_test.cpp LIBS raycube_render_support LABELS fast)
raycube_test(render_instance SOURCES oracle/render_instance_test.cpp LIBS raycube_render_support LABELS fast)
raycube_test(render_wall SOURCES oracle/render_wall_test.cpp LIBS raycube_render_support LABELS fast)
raycube_test(render_sky_error SOURCES oracle/render_sky_error_test.cpp LIBS raycube_render_support raycube_test_scenes
  LABELS slow)
raycube_test(render_invariance SOURCES oracle/render_invariance_test.cpp LIBS raycube_test_scenes raycube_render_support
  LABELS fast)
raycube_test(render_pages SOURCES oracle/render_pages_test.cpp LIBS raycube_render_support raycube_trace_support LABELS
  fast)
raycube_test(render_overflow SOURCES oracle/render_overflow_test.cpp LIBS raycube_render_support LABELS fast)
raycube_test(render_furnace SOURCES oracle/render_furnace_test.cpp LIBS raycube_render_support LABELS slow)
raycube_full_test(render_furnace "1e8 samples: a minute")
raycube_test(render_checkerboard SOURCES oracle/render_checkerboard_test.cpp LIBS raycube_render_support LABELS fast)
raycube_test(render_spectral SOURCES oracle/render_spectral_test.cpp LIBS raycube_test_scenes raycube_render_support
  LABELS fast)
raycube_test(render_shadow SOURCES oracle/render_shadow_test.cpp LIBS raycube_render_support LABELS fast)
raycube_test(render_psf SOURCES oracle/render_psf_test.cpp LIBS raycube_render_support LABELS fast)
raycube_test(render_adaptive SOURCES oracle/render_adaptive_test.cpp LIBS raycube_render_support LABELS fast)
raycube_test(replicates SOURCES unit/replicates_test.cpp LIBS raycube::render LABELS fast)
raycube_test(render_small_objects SOURCES oracle/render_small_objects_test.cpp LIBS raycube_render_support LABELS fast)
raycube_test(group_finder SOURCES oracle/group_finder_test.cpp LIBS raycube_render_support
  raycube::scene_compiler LABELS fast)
raycube_test(render_edge_cases SOURCES oracle/render_edge_cases_test.cpp LIBS raycube_render_support
  raycube::scene_compiler LABELS fast)
raycube_test(tuner SOURCES unit/tuner_test.cpp LIBS raycube::render LABELS fast)
raycube_test(device_parts SOURCES unit/device_parts_test.cpp LIBS raycube::cl LABELS fast)
set_tests_properties(device_parts PROPERTIES ENVIRONMENT MALLOC_PERTURB_=165)
