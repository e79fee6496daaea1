#include "host/base/symmetric_modes.h"

namespace raycube::base {

void SymmetricModes::compute(const Eigen::Ref<const Eigen::MatrixXd>& symmetric) { solver_.compute(symmetric); }

}  // namespace raycube::base
