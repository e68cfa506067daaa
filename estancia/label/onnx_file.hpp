// ONNX file: checked before an engine opens it, its input fixed to the size that the preprocessing makes.
#pragma once

#include <string>

#include "estancia/label/model_spec.hpp"

namespace estancia {

/// Whether the network's file is ONNX, which every engine opens; Caffe and TensorFlow files are OpenCV's
/// alone.
bool isOnnx(const ModelSpec& spec);

/// The serialized ONNX model of spec.file. An input of any size is fixed to that of the preprocessing (a
/// width of 0 leaves it as it is). Throws Error when the file is missing, damaged, made for another input, or
/// keeps weights in other files, which engines would look for in the process's working folder.
std::string readOnnx(const ModelSpec& spec);

}  // namespace estancia
