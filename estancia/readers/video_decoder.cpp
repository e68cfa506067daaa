// SPDX-License-Identifier: Apache-2.0
#include "estancia/readers/video_decoder.hpp"

#include "estancia/core/module_function.hpp"

namespace estancia::io {

std::unique_ptr<VideoDecoder> makeVideoDecoder() {
  // After an exception the next call tries again.
  static const auto make = reinterpret_cast<VideoDecoder* (*)()>(getModuleFunction(
      ESTANCIA_VIDEO_MODULE, ESTANCIA_VIDEO_FROM_BIN, "estanciaMakeVideoDecoder", "videos cannot be read"));
  return std::unique_ptr<VideoDecoder>(make());
}

}  // namespace estancia::io
