// For the thread sanitizer, which is not built into OpenCV and TBB and so cannot see how their threads wait
// for each other: OpenCV works on one thread. (OPENCV_FOR_THREADS_NUM is not heard where OpenCV is built with
// TBB.) SPDX-License-Identifier: Apache-2.0
#include <opencv2/core/utility.hpp>

namespace {
[[gnu::constructor]] void keepOpenCvOnOneThread() {
  cv::setNumThreads(1);
}
}  // namespace
