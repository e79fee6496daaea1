// raycube analyze VERB CUBE: what users compute from cubes, real or simulated.
#include "host/cli/analyze_verbs.h"

namespace raycube::cli {

Verb verb_analyze() {
  Verb verb("analyze", "Statistics, detection, unmixing, classes and resolution of any ENVI cube");
  verb.verbs = {verb_analyze_statistics(), verb_analyze_reflectance(), verb_analyze_edge(),   verb_analyze_eigen(),
                verb_analyze_kmeans(),     verb_analyze_classify(),    verb_analyze_unmix(),  verb_analyze_detect(),
                verb_analyze_roc(),        verb_analyze_register(),    verb_analyze_locate(), verb_analyze_scorecard()};
  return verb;
}

}  // namespace raycube::cli
