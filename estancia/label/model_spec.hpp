// What a model folder says about its model.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "estancia/label/preprocess.hpp"

namespace estancia {

/// A model as `model.toml` in its folder describes it. Keys of the file stand in brackets where their names
/// differ.
struct ModelSpec {
  std::filesystem::path folder;  ///< where model.toml lies; the other paths are relative to it
  std::string name;              ///< letters, digits, `.`, `_`, `-`; the folder's name in the model home
  /// One of labelerTypes(). "network" is run by the best engine at hand that can open its file, or the one
  /// that the user names; "opencv" and "onnxruntime" are networks for that engine only.
  std::string type = "network";
  /// The network: .onnx, .caffemodel or .pb.
  std::filesystem::path file;
  std::filesystem::path config;  ///< its .prototxt (Caffe, required) or .pbtxt (TensorFlow)
  std::filesystem::path labels;  ///< one label a line, in the order of the outputs
  /// The output to read, where a network has several.
  std::string output;
  Preprocessing preprocessing;  ///< [input, region, crop, resize, color, mean, scale]

  // What the outputs mean; see toProbabilities() in scores.hpp.
  enum class Reduce { none, max };
  Reduce reduce = Reduce::none;  ///< max: a row of outputs for each of many places (anchors) in the image
  bool softmax = false;          ///< the outputs are logits of labels that exclude each other
  bool sigmoid = false;          ///< the outputs are logits of labels that do not
  /// Outputs that have no label (background, numbers never given), ascending.
  std::vector<std::size_t> unused;
  std::filesystem::path embeddings;  ///< .npy, labels×D: the network embeds images (CLIP), see scores.hpp
  double logitScale = 100;           ///< [logit_scale] of their cosines with the embeddings

  std::string license, source;                ///< for people
  std::map<std::string, std::string> sha256;  ///< file → 64 hex digits, verified whenever the model is loaded
};

/// Whether `type` is a network, whose model.toml holds all the keys above; the settings of any other type
/// are read by that type itself.
bool isNetworkType(std::string_view type);

/// Reads FOLDER/model.toml. Throws Error `…/model.toml:LINE: …` on unknown, missing or wrong keys, and when a
/// path leaves the folder. Of a type that is no network only the common keys are read: name, type, labels,
/// license, source, sha256.
ModelSpec readModelSpec(const std::filesystem::path& folder);

/// All files of the network, relative to the model's folder: itself, its config, text embeddings.
std::vector<std::filesystem::path> networkFiles(const ModelSpec& spec);

/// Throws Error (unsupportedFile) unless the network is of a format that an engine opens. Of TensorFlow Lite
/// and TensorFlow.js it says which command converts them.
void requireKnownFormat(const ModelSpec& spec);

/// Where the files of the spec are. Throws Error when one is missing or leaves the folder through a link.
std::filesystem::path modelFile(const ModelSpec& spec, const std::filesystem::path& relative);

/// SHA-256 over the model's files, its preprocessing, and the `settings` of other types that change what they
/// say: two models that label alike have the same. Throws Error when a file is missing or is not what
/// spec.sha256 says.
std::string modelDigest(const ModelSpec& spec, const std::string& settings = "");

}  // namespace estancia
