// OpenCV engine: runs networks with OpenCV's dnn module, on the CPU.
#pragma once

#include <memory>
#include <string>

#include "estancia/label/labeler.hpp"
#include "estancia/label/model_spec.hpp"

namespace estancia {

/// Opens the network of `spec` (ONNX, Caffe, TensorFlow) and labels one gray image with it,
/// so that what does not fit shows at once. OpenCV gets `threads` threads (cv::setNumThreads, of the whole
/// process), 0 gives it as many as there are free cores: another number changes no more than the last bits
/// (10⁻⁶), the same number nothing. Throws Error on missing or damaged files, wrong digests, unsupported
/// operators (named), an input of another size, and outputs that are not as many as labels, not finite or not
/// probabilities.
std::unique_ptr<Labeler> openWithOpencv(const ModelSpec& spec, int threads = 0);

/// Its name and version, which a cache tells answers apart by.
std::string opencvVersion();

}  // namespace estancia
