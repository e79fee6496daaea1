# A relocatable installation: the program (kernels inside), its man page, the pages that these name, and plots, scenes
# and the compiled kernels of a first scene under share/raycube, found relative to the executable
# (host/base/data_folder.h). `cpack -G DEB` makes a Debian package of the same files.
include(GNUInstallDirs)
install(TARGETS raycube RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(FILES ${CMAKE_BINARY_DIR}/raycube.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
install(FILES LICENSE README.md CHANGELOG.md CONTRIBUTING.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(FILES bench/RESULTS.md DESTINATION ${CMAKE_INSTALL_DOCDIR}/bench)
install(DIRECTORY docs DESTINATION ${CMAKE_INSTALL_DOCDIR} PATTERN "*.py" EXCLUDE PATTERN "__pycache__" EXCLUDE)
install(DIRECTORY scenes DESTINATION ${CMAKE_INSTALL_DATADIR}/raycube USE_SOURCE_PERMISSIONS
        PATTERN "__pycache__" EXCLUDE PATTERN "*.pyc" EXCLUDE)
install(DIRECTORY ${CMAKE_BINARY_DIR}/share/raycube/kernels DESTINATION ${CMAKE_INSTALL_DATADIR}/raycube OPTIONAL)
if(EXISTS ${PROJECT_SOURCE_DIR}/host/plots)
  install(DIRECTORY host/plots DESTINATION ${CMAKE_INSTALL_DATADIR}/raycube USE_SOURCE_PERMISSIONS
          PATTERN "__pycache__" EXCLUDE PATTERN "*.pyc" EXCLUDE)
endif()

set(CPACK_PACKAGE_NAME raycube)
set(CPACK_PACKAGE_VENDOR raycube)
set(CPACK_PACKAGE_CONTACT "raycube maintainers <raycube@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_RESOURCE_FILE_LICENSE ${PROJECT_SOURCE_DIR}/LICENSE)
set(CPACK_GENERATOR DEB)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
# Any OpenCL driver, and GDAL, which is loaded when a raster is read; libraries that are linked come from shlibdeps.
get_property(gdal_package GLOBAL PROPERTY RAYCUBE_GDAL_PACKAGE)
set(CPACK_DEBIAN_PACKAGE_DEPENDS "pocl-opencl-icd | opencl-icd, ${gdal_package}")
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "python3, python3-numpy, python3-matplotlib")
include(CPack)
