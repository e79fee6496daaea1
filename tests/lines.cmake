raycube_test(lines_voigt SOURCES oracle/lines_voigt_test.cpp LIBS raycube::atmos_lines LABELS fast)
raycube_test(lines_hitran_par SOURCES unit/hitran_par_test.cpp unit/tabulated_absorber_test.cpp LIBS raycube::atmos_lines LABELS fast)
raycube_test(lines_methane SOURCES oracle/lines_methane_test.cpp support/anchor_rows.cpp LIBS raycube::atmos_lines LABELS fast)
raycube_test(lines_sums SOURCES oracle/lines_sums_test.cpp LIBS raycube::atmos_lines LABELS fast)
