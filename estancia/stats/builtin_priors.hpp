// Builtin label priors: the files in models/priors, compiled in. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace estancia {

extern const std::string imagenetPrior, cocoPrior, places365Prior;

}  // namespace estancia
