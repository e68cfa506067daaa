// Networks that any engine can run: whatever the file's format, as ONNX.
#pragma once

#include <string>

#include "estancia/label/model_spec.hpp"

namespace estancia {

/// Whether the network's file is ONNX or can be turned into it (TensorFlow Lite); Caffe and TensorFlow files
/// are OpenCV's alone.
bool isOnnxOrConvertible(const ModelSpec& spec);

/// The network as a serialised ONNX model whose input has the size that the preprocessing makes. Throws Error
/// when the file is missing, damaged, or made for another input.
std::string readAsOnnx(const ModelSpec& spec);

}  // namespace estancia
