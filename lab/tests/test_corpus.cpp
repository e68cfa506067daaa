// SPDX-License-Identifier: Apache-2.0
#include "experiments/src/runner/experiment.hpp"
#include "fuzz/fuzz_target.hpp"

namespace estancia::fuzz {

FUZZ_TARGET(experiments, config) {
  experiments::checkExperiments({inputFile("experiment.toml", bytes)});
}

}  // namespace estancia::fuzz
