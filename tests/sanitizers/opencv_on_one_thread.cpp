// OpenCV on one thread, for the thread sanitizer: it sees neither how TBB's threads wait for each other nor
// what they share. (OpenCV with TBB ignores OPENCV_FOR_THREADS_NUM.)
//
// SPDX-License-Identifier: Apache-2.0
#include <opencv2/core/utility.hpp>

namespace {
[[gnu::constructor]] void keepOpenCvOnOneThread() {
  cv::setNumThreads(1);
}
}  // namespace
