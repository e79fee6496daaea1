# The BVH builder alone, so that kernels and their tests need neither GDAL nor Assimp.
add_library(raycube_scene_bvh STATIC ${CMAKE_CURRENT_LIST_DIR}/block_order.cpp ${CMAKE_CURRENT_LIST_DIR}/bvh_builder.cpp
  ${CMAKE_CURRENT_LIST_DIR}/bvh_tree.cpp ${CMAKE_CURRENT_LIST_DIR}/skyline.cpp)
target_link_libraries(raycube_scene_bvh PUBLIC raycube_warnings raycube::base PRIVATE embree)
add_library(raycube::scene_bvh ALIAS raycube_scene_bvh)
# What triangles are made of and whose they are, for all who read compiled scenes.
add_library(raycube_scene_matter STATIC ${CMAKE_CURRENT_LIST_DIR}/lamp.cpp ${CMAKE_CURRENT_LIST_DIR}/matter.cpp
  ${CMAKE_CURRENT_LIST_DIR}/owner.cpp ${CMAKE_CURRENT_LIST_DIR}/shape_energy.cpp
  ${CMAKE_CURRENT_LIST_DIR}/lobe_albedo.cpp
  ${CMAKE_CURRENT_LIST_DIR}/spectral_shape.cpp ${CMAKE_CURRENT_LIST_DIR}/fresnel.cpp
  ${CMAKE_CURRENT_LIST_DIR}/shape_list.cpp)
target_link_libraries(raycube_scene_matter PUBLIC raycube_warnings raycube::base)
add_library(raycube::scene_matter ALIAS raycube_scene_matter)
