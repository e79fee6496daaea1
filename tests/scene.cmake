# From simulation files to compiled scenes.
raycube_test(scene_bad_input SOURCES unit/scene_bad_input_test.cpp LIBS raycube::scene_compiler LABELS fast)
raycube_test(sun_position SOURCES oracle/sun_position_test.cpp LIBS raycube::scene_compiler raycube::atmos_tables LABELS
  fast)
raycube_test(scene_spectra SOURCES unit/scene_spectra_test.cpp LIBS raycube::scene_compiler LABELS fast)
raycube_test(mesh_declarations SOURCES unit/mesh_declarations_test.cpp LIBS raycube::scene_compiler LABELS fast)
raycube_test(spectral_library SOURCES unit/spectral_library_test.cpp LIBS raycube::scene_compiler raycube_products
  LABELS fast)
raycube_test(texture_choice SOURCES unit/texture_choice_test.cpp LIBS raycube::scene_compiler LABELS fast)
raycube_test(texel_cut SOURCES unit/texel_cut_test.cpp LIBS raycube::scene_compiler LABELS fast)
raycube_test(leaf_optics SOURCES oracle/leaf_optics_test.cpp LIBS raycube::scene_compiler LABELS fast)
raycube_test(scene_terrain SOURCES unit/scene_terrain_test.cpp LIBS raycube::scene_compiler LABELS fast)
raycube_test(scene_content SOURCES unit/scene_content_test.cpp LIBS raycube::scene_compiler LABELS fast)
raycube_test(owner SOURCES unit/owner_test.cpp LIBS raycube::scene_compiler raycube_test_scenes LABELS fast)
raycube_test(scene_compiled_file SOURCES unit/scene_compiled_file_test.cpp LIBS raycube::scene_compiler LABELS fast)
raycube_test(scene_real_input SOURCES unit/scene_real_input_test.cpp LIBS raycube::scene_compiler LABELS fast)
raycube_test(scene_options SOURCES unit/scene_options_test.cpp LIBS raycube::scene_compiler nlohmann_json::nlohmann_json
  LABELS fast)
add_test(NAME scene_verb COMMAND ${PROJECT_SOURCE_DIR}/tests/cli/scene_verb_test.sh $<TARGET_FILE:raycube>
  ${PROJECT_SOURCE_DIR}/scenes ${CMAKE_BINARY_DIR}/tests/scene_verb)
set_tests_properties(scene_verb PROPERTIES LABELS fast)

# The shipped park: its generator against the required numbers, then through the compiler. Needs Debian's python3 with
# numpy.
set(RAYCUBE_PYTHON /usr/bin/python3 CACHE FILEPATH "Python with numpy that runs the scene generators")
add_test(NAME park_generator COMMAND ${RAYCUBE_PYTHON} ${PROJECT_SOURCE_DIR}/tests/cli/park_generator_test.py
  ${PROJECT_SOURCE_DIR}/scenes ${CMAKE_BINARY_DIR}/tests/park)
set_tests_properties(park_generator PROPERTIES LABELS slow FIXTURES_SETUP park)
# The park twice, whose files must be the same: 13 s each.
add_test(NAME park_generator_full COMMAND ${RAYCUBE_PYTHON} ${PROJECT_SOURCE_DIR}/tests/cli/park_generator_test.py
  ${PROJECT_SOURCE_DIR}/scenes ${CMAKE_BINARY_DIR}/tests/park_full --full)
set_tests_properties(park_generator_full PROPERTIES LABELS "slow;full")
raycube_test(park_scene SOURCES unit/park_scene_test.cpp LIBS raycube::scene_compiler LABELS slow)
set_tests_properties(park_scene PROPERTIES FIXTURES_REQUIRED park ENVIRONMENT
  "RAYCUBE_PARK=${CMAKE_BINARY_DIR}/tests/park/a")
