raycube_test(gas_bands SOURCES oracle/gas_bands_test.cpp LIBS raycube::atmos_tables LABELS fast)
raycube_test(gas_lowtran SOURCES oracle/gas_lowtran_test.cpp support/anchor_rows.cpp LIBS raycube::atmos_tables LABELS fast)
