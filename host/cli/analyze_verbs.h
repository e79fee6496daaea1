// Verbs of `raycube analyze`, one file each: analyze_NAME.cpp.
#pragma once

#include "host/cli/verb.h"

namespace raycube::cli {

Verb verb_analyze_statistics();
Verb verb_analyze_reflectance();
Verb verb_analyze_edge();
Verb verb_analyze_eigen();
Verb verb_analyze_kmeans();
Verb verb_analyze_classify();
Verb verb_analyze_unmix();
Verb verb_analyze_detect();
Verb verb_analyze_roc();
Verb verb_analyze_register();
Verb verb_analyze_locate();
Verb verb_analyze_scorecard();

}  // namespace raycube::cli
