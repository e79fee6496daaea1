// The explicit list of verbs comes from RAYCUBE_VERBS in CMakeLists.txt, as RAYCUBE_EACH_VERB(x) with one x(name) each.
#include "host/cli/verb.h"
#include "raycube_verbs.h"

namespace raycube::cli {

#define RAYCUBE_DECLARE(name) Verb verb_##name();
RAYCUBE_EACH_VERB(RAYCUBE_DECLARE)
#undef RAYCUBE_DECLARE

std::vector<Verb> all_verbs() {
  return {
#define RAYCUBE_CALL(name) verb_##name(),
      RAYCUBE_EACH_VERB(RAYCUBE_CALL)
#undef RAYCUBE_CALL
  };
}

}  // namespace raycube::cli
