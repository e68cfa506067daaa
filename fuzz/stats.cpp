// SPDX-License-Identifier: Apache-2.0
#include "estancia/stats/label_prior.hpp"
#include "estancia/stats/moments.hpp"
#include "fuzz/fuzz_target.hpp"

namespace estancia::fuzz {

FUZZ_TARGET(stats, label_prior_file) {
  parseLabelPrior(std::string(bytes), "input.prior");
}

FUZZ_TARGET(stats, label_prior_bytes) {
  LabelPrior::fromBytes(std::string(bytes), 3);
}

FUZZ_TARGET(stats, moments) {
  for (const bool spread : {false, true}) Moments::fromBytes(bytes, 3, spread);
}

}  // namespace estancia::fuzz
