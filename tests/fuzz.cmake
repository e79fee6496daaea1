# Readers of files that users bring: the corpora and mutations of them here, libFuzzer in a build of its own (ci/fuzz,
# docs/stability.md).
if(NOT RAYCUBE_FUZZ)
  add_library(raycube_fuzz_targets STATIC fuzz/targets.cpp)
  raycube_test_code(raycube_fuzz_targets)
  target_link_libraries(raycube_fuzz_targets PUBLIC raycube::scene_compiler raycube_products raycube::atmos_import
    raycube::atmos_lines)
  foreach(program IN ITEMS replay mutate)
    add_executable(fuzz_${program} fuzz/${program}_main.cpp)
    raycube_test_code(fuzz_${program})
    target_link_libraries(fuzz_${program} PRIVATE raycube_fuzz_targets)
  endforeach()
  add_test(NAME fuzz_mutations COMMAND fuzz_mutate ${CMAKE_CURRENT_LIST_DIR}/fuzz/corpus 30)
  add_test(NAME fuzz_mutations_full COMMAND fuzz_mutate ${CMAKE_CURRENT_LIST_DIR}/fuzz/corpus 2000)
  set_tests_properties(fuzz_mutations PROPERTIES LABELS fast)
  set_tests_properties(fuzz_mutations_full PROPERTIES LABELS full)
  add_test(NAME fuzz_corpora COMMAND fuzz_replay ${CMAKE_CURRENT_LIST_DIR}/fuzz/corpus)
  set_tests_properties(fuzz_corpora PROPERTIES LABELS fast)
  return()
endif()

# The readers alone are compiled with clang; all else comes from the libraries of the ordinary build, so that this takes
# a minute.
set(RAYCUBE_ORDINARY_BUILD ${PROJECT_SOURCE_DIR}/build CACHE PATH "Folder of an ordinary build, whose libraries
  fuzz_readers takes")
set(readers
  scene_compiler/band_list scene_compiler/compiled_file scene_compiler/csv_file scene_compiler/detector_joins
    scene_compiler/document scene_compiler/document_values
  scene_compiler/envi_library scene_compiler/instrument_poses scene_compiler/lidar_platform scene_compiler/lidar_pulse
  scene_compiler/load_simulation scene_compiler/obj_check scene_compiler/spectrum_file scene_compiler/volume_builder
  scene_compiler/volume_spectrum
  atmos_tables/rct_file atmos_tables/optics/profile_csv
  atmos_tables/import/acd atmos_tables/import/import_file atmos_tables/import/modtran_axis
    atmos_tables/import/modtran_cards
  atmos_tables/import/modtran_chn atmos_tables/import/modtran_csv atmos_tables/import/modtran_json
    atmos_tables/import/modtran_sun atmos_tables/import/modtran_tape6 atmos_tables/import/modtran_tape7
  atmos_tables/import/plain_csv atmos_tables/import/sixs atmos_tables/import/text_lines atmos_tables/import/uvspec
  atmos_tables/import/uvspec_input atmos_tables/import/uvspec_unit
  atmos_tables/lines/hitran_par atmos_tables/lines/molecules atmos_tables/lines/tabulated_absorber
  host/products/envi_header_parser host/products/envi_reader host/products/las_reader)
list(TRANSFORM readers PREPEND ${PROJECT_SOURCE_DIR}/)
list(TRANSFORM readers APPEND .cpp)
add_executable(fuzz_readers fuzz/fuzz_main.cpp fuzz/targets.cpp ${readers})
set(sanitizers -fsanitize=fuzzer,address,undefined -fno-sanitize-recover=undefined)
target_compile_options(fuzz_readers PRIVATE -O1 -gline-tables-only -fno-omit-frame-pointer ${sanitizers})
target_link_options(fuzz_readers PRIVATE ${sanitizers})
# All of an ordinary build's libraries that readers may call: what they do not call is not linked. Where those were
# compiled several sources at a time (RAYCUBE_UNITY), readers come with them a second time; the first, of here, is
# taken.
file(GLOB ordinary ${RAYCUBE_ORDINARY_BUILD}/scene_compiler/*.a ${RAYCUBE_ORDINARY_BUILD}/host/products/*.a
  ${RAYCUBE_ORDINARY_BUILD}/atmos_tables/*.a ${RAYCUBE_ORDINARY_BUILD}/atmos_tables/import/*.a
  ${RAYCUBE_ORDINARY_BUILD}/host/base/*.a)
target_link_options(fuzz_readers PRIVATE -Wl,--allow-multiple-definition)
target_include_directories(fuzz_readers PRIVATE ${PROJECT_SOURCE_DIR})
target_link_libraries(fuzz_readers PRIVATE -Wl,--start-group ${ordinary} -Wl,--end-group embree assimp::assimp
  tomlplusplus::tomlplusplus nlohmann_json::nlohmann_json fmt::fmt spdlog::spdlog PNG::PNG PkgConfig::OPENEXR
    Eigen3::Eigen OpenCL::OpenCL ${NOVA_LIBRARY} Threads::Threads)
