// SPDX-License-Identifier: Apache-2.0
#include "estancia/sequences/sequence.hpp"

#include "estancia/core/fail.hpp"

namespace estancia {

cv::Mat Sequence::depth(std::size_t i) const {
  fail(ErrorCode::insufficientData, "{}: {} has no depth image", name(), frame(i).name);
}

bool hasPoses(const Sequence& sequence) {
  for (std::size_t i = 0; i < sequence.size(); ++i)
    if (sequence.frame(i).pose) return true;
  return false;
}

}  // namespace estancia
