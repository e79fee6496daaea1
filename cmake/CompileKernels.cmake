# Run by the target raycube_first_kernels: renders the scene of `raycube new` once, so that its first render in an
# installation or in the build tree finds its kernels compiled (12 s of a processor with PoCL 3.1). Cameras over most
# scenes of meshes use the same programs. Without an OpenCL device here, or with another one than at the build, kernels
# are compiled when they are first needed, as those of other scenes are.
# usage: cmake -DPROGRAM=RAYCUBE -DWORK=FOLDER -DKERNELS=FOLDER -P CompileKernels.cmake
# WORK keeps compiled kernels from build to build; those of the scene are left in KERNELS.
set(log ${WORK}/build.tsv)
file(REMOVE_RECURSE ${log} ${WORK}/scene ${WORK}/out ${KERNELS})
file(MAKE_DIRECTORY ${WORK})
execute_process(COMMAND ${PROGRAM} new ${WORK}/scene --quiet RESULT_VARIABLE status ERROR_VARIABLE said OUTPUT_QUIET)
if(status EQUAL 0)
  # A data folder without kernels: what is compiled here is kept in WORK.
  execute_process(COMMAND ${CMAKE_COMMAND} -E env --unset=POCL_CACHE_DIR XDG_CACHE_HOME=${WORK} RAYCUBE_DATA=${WORK}
                          RAYCUBE_PROGRAM_LOG=${log} ${PROGRAM} render ${WORK}/scene/scene.toml -o ${WORK}/out --quiet
                  RESULT_VARIABLE status ERROR_VARIABLE said OUTPUT_QUIET TIMEOUT 300)
endif()
file(REMOVE_RECURSE ${WORK}/scene ${WORK}/out)
if(NOT status EQUAL 0 OR NOT EXISTS ${log})
  message("No kernels were compiled with the program; they are when they are first needed (${status}): ${said}")
  return()
endif()
file(STRINGS ${log} programs)
foreach(line IN LISTS programs)
  string(REGEX MATCH "\t([0-9a-f]+)\t" found "${line}")
  file(COPY ${WORK}/raycube/kernels/${CMAKE_MATCH_1}.kernels DESTINATION ${KERNELS}
       FILE_PERMISSIONS OWNER_READ OWNER_WRITE GROUP_READ WORLD_READ)
endforeach()
