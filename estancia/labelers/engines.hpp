// Network engines: OpenCV, and ONNX Runtime, which runs ONNX networks two to four times as fast; on the CPU.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "estancia/labelers/labeler.hpp"
#include "estancia/labelers/model_spec.hpp"

namespace estancia {

/// Opens the network of `spec` (ONNX, Caffe, TensorFlow) and labels one gray image with it,
/// so that what does not fit shows at once. OpenCV gets `threads` threads (cv::setNumThreads, of the whole
/// process), 0 gives it as many as there are free cores: another number changes no more than the last bits
/// (10⁻⁶), the same number nothing. Throws Error on missing or damaged files, wrong digests, unsupported
/// operators (named), an input of another size, and outputs that are not as many as labels, not finite or not
/// probabilities.
std::unique_ptr<Labeler> openWithOpencv(const ModelSpec& spec, int threads = 0);

/// Opens the network of `spec` (ONNX) and labels one gray image with it, so that what does
/// not fit shows at once. `threads` = 0 takes as many as there are free cores, but one for a network of less
/// than a millisecond, beside which decoding the images takes the other cores. One image is shared between
/// the threads; of a batch each thread takes whole images, which is quicker. The probabilities are the same
/// to the bit whatever the threads and batches. Throws Error when ONNX Runtime is not at hand, and on all
/// that openWithOpencv() refuses.
std::unique_ptr<Labeler> openWithOnnxruntime(const ModelSpec& spec, int threads = 0);

/// Their names and versions, by which a cache distinguishes answers.
std::string opencvVersion();
std::string onnxruntimeVersion();

}  // namespace estancia
