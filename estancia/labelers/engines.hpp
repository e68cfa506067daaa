// Network engines: OpenCV, and ONNX Runtime, which runs ONNX networks two to four times as fast; on the CPU.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <span>
#include <string>
#include <vector>

#include "estancia/labelers/labeler.hpp"
#include "estancia/labelers/model_spec.hpp"

struct OrtApi;

namespace estancia {

/// Opens the network of `spec` (ONNX, Caffe, TensorFlow) and labels one gray image with it, so that what does
/// not fit shows at once. OpenCV gets `threads` threads (cv::setNumThreads, of the whole process), 0 gives it
/// as many as there are free cores: another number changes no more than the last bits (10⁻⁶), the same number
/// nothing. Throws Error on missing or damaged files, wrong digests, unsupported operators (named), an input
/// of another size, and outputs that are not as many as labels, not finite or not probabilities.
std::unique_ptr<Labeler> openWithOpencv(const ModelSpec& spec, int threads = 0);

/// Opens the network of `spec` (ONNX) as openWithOpencv() does. `threads` = 0 takes as many as there are free
/// cores, but one for a network of less than a millisecond, beside which decoding the images takes the other
/// cores. One image is shared between the threads; of a batch each takes whole images, which is quicker.
/// Probabilities do not depend on threads and batches, to the bit. Throws Error without ONNX Runtime, too.
std::unique_ptr<Labeler> openWithOnnxruntime(const ModelSpec& spec, int threads = 0);

/// Their names and versions, by which a cache distinguishes answers.
std::string opencvVersion();
std::string onnxruntimeVersion();

/// A network in ONNX Runtime of which all outputs are wanted.
class NetworkValues {
 public:
  virtual ~NetworkValues() = default;
  /// The names of the outputs.
  virtual const std::vector<std::string>& names() const = 0;
  /// Runs the network on an image as preprocess() makes it and gives each output's numbers to `use`, by its
  /// position in names(). Throws Error when the image does not fit, or an output holds no floats.
  virtual void run(const cv::Mat& blob,
                   const std::function<void(std::size_t, std::span<const float>)>& use) = 0;
};

/// Opens a serialized ONNX network; `source` names it in messages. `threads` (0: free cores) change no bit.
/// Throws Error when ONNX Runtime is not at hand or cannot open the network.
std::unique_ptr<NetworkValues> openNetworkValues(const std::string& onnx, const std::string& source,
                                                 int threads = 0);

namespace onnxruntime {

/// ONNX Runtime, opened when first asked for: Estancia, and what links it, runs without.
struct Library {
  const OrtApi* api = nullptr;
  /// "1.28.2".
  std::string version;
  /// Why there is none, one sentence with advice; "" when there is.
  std::string problem;
};

/// Looks for it in $ESTANCIA_ONNXRUNTIME (the library or its folder, and nowhere else when that is set),
/// where CMake found it, in $ESTANCIA_HOME/onnxruntime (script/bootstrap), and among the system's libraries.
const Library& library();

}  // namespace onnxruntime
}  // namespace estancia
