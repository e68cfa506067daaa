// Model files: where the files of a model are, their formats and digests.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "estancia/labelers/model_spec.hpp"

namespace estancia {

/// Whether `type` is a network, whose keys readModelSpec() reads; any other type reads its own.
bool isNetworkType(std::string_view type);

/// Whether `name` is safe as that of a file and of a folder: letters, digits, `_`, `-` and `.`, no `.` first.
bool isSafeName(std::string_view name);

/// `text` in lower case if it is so many hex digits, else "".
std::string hexDigits(std::string text, std::size_t digits);

/// All files of the network, relative to the model's folder: itself, its config, text embeddings.
std::vector<std::filesystem::path> networkFiles(const ModelSpec& spec);

/// Throws Error (unsupportedFile) unless the network is of a format that an engine opens. For TensorFlow Lite
/// and TensorFlow.js the message names the command that converts them.
void requireKnownFormat(const ModelSpec& spec);

/// The model as one that computes so: with `int8` the file of 8 bits is its network, and the float file no
/// longer belongs to it; with `float32` the file of 8 bits does not. Throws Error (unsupportedFile), saying
/// which command makes it, when there is no file of 8 bits.
ModelSpec inPrecision(ModelSpec spec, Precision precision);

/// Whether it is a model that inPrecision() made one of 8 bits.
bool isInt8(const ModelSpec& spec);

/// Where the files of the spec are. Throws Error when one is missing or leaves the folder through a link.
std::filesystem::path modelFile(const ModelSpec& spec, const std::filesystem::path& relative);

/// SHA-256 over the model's files, its preprocessing, and the `settings` of other types that change their
/// answers: the same for models that label alike. Throws Error on files missing or not as in spec.sha256.
std::string modelDigest(const ModelSpec& spec, const std::string& settings = "");

/// Whether the network's file is ONNX, which every engine opens; Caffe and TensorFlow are OpenCV's alone.
bool isOnnx(const ModelSpec& spec);

/// The serialized ONNX model of spec.file. An input of any size is fixed to that of the preprocessing (a
/// width of 0 leaves it as it is), and spec.output is made an output where it is a value inside of the
/// network. Throws Error when the file is missing, damaged, made for another input, or keeps weights in other
/// files, which engines would look for in the process's working folder.
std::string readOnnx(const ModelSpec& spec);

}  // namespace estancia
