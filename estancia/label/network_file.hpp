// Networks that any engine can run: whatever the file's format, as ONNX.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "estancia/label/model_spec.hpp"

namespace estancia {

/// All files of the network, relative to the model's folder: itself, its config, the weights that it
/// names, and text embeddings. Throws Error when such a name cannot be read, or leads out of the folder.
std::vector<std::filesystem::path> networkFiles(const ModelSpec& spec);

/// Whether the network's file is ONNX or can be turned into it (TensorFlow Lite, TensorFlow.js); Caffe and
/// TensorFlow files are OpenCV's alone.
bool isOnnxOrConvertible(const ModelSpec& spec);

/// The network as a serialized ONNX model whose input has the size that the preprocessing makes (a width of 0
/// leaves it as it is); of a TensorFlow.js file the part between spec.inputNode and spec.output. Throws Error
/// when the file is missing, damaged, or made for another input.
std::string readAsOnnx(const ModelSpec& spec);

}  // namespace estancia
