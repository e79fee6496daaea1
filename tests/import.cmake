raycube_test(atmos_import SOURCES unit/import_acd_test.cpp unit/import_chn_test.cpp unit/import_modtran6_test.cpp
                                  unit/import_plain_csv_test.cpp unit/import_samples_test.cpp unit/import_sixs_test.cpp
                                  unit/import_tape7_test.cpp unit/import_text_test.cpp unit/import_told_test.cpp
                                  unit/import_uvspec_input_test.cpp unit/import_uvspec_test.cpp
             LIBS raycube::atmos_import nlohmann_json::nlohmann_json LABELS fast)
