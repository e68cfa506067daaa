// ONNX Runtime engine: runs ONNX networks on the CPU, two to four times as fast as OpenCV.
#pragma once

#include <memory>
#include <string>

#include "estancia/label/labeler.hpp"
#include "estancia/label/model_spec.hpp"

namespace estancia {

/// Opens the network of `spec` (ONNX) and labels one gray image with it, so that what does
/// not fit shows at once. `threads` = 0 takes as many as there are free cores, but one for a network of less
/// than a millisecond, beside which decoding the images takes the other cores. One image is shared between
/// the threads; of a batch each thread takes whole images, which is quicker. The probabilities are the same
/// to the bit whatever the threads and batches. Throws Error when ONNX Runtime is not at hand, and on all
/// that openWithOpencv() refuses.
std::unique_ptr<Labeler> openWithOnnxruntime(const ModelSpec& spec, int threads = 0);

/// Its name and version, which a cache tells answers apart by.
std::string onnxruntimeVersion();

}  // namespace estancia
