// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/image_codecs.hpp"

#include <cstdlib>

#include "estancia/core/module_function.hpp"

namespace estancia {
namespace {

// OpenCV reads OpenEXR only when this is set before its first image of any kind. A user's value is kept.
[[maybe_unused]] const int openExrEnabled = setenv("OPENCV_IO_ENABLE_OPENEXR", "1", 0);

}  // namespace

const ImageCodecs& imageCodecs() {
  // After an exception the next call tries again.
  static const ImageCodecs& codecs = *reinterpret_cast<const ImageCodecs* (*)()>(getModuleFunction(
      ESTANCIA_IMAGES_MODULE, ESTANCIA_IMAGES_FROM_BIN, "estanciaImageCodecs", "images cannot be decoded"))();
  return codecs;
}

}  // namespace estancia
