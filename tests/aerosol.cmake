raycube_test(aerosol_column SOURCES unit/aerosol_column_test.cpp LIBS raycube::atmos_tables LABELS fast)
