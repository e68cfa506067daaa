// Model specification: the content of a model folder's model.toml.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace estancia {

/// How an image becomes a network's input, in this order: the region is cut out of the image's center,
/// resized to width × height, its colors are put in order, and every value v becomes (v − mean) · scale.
struct Preprocessing {
  enum class Region {
    /// A square, `crop` of the image's shorter side: keeps shapes, drops the ends of the longer side.
    square,
    /// `crop` of the width by `crop` of the height: sees more, but squeezes (Caffe's habit).
    stretch,
  };
  enum class Resize { area, linear, cubic };
  enum class Color { rgb, bgr };

  /// Size of the input [pixels].
  int width = 224, height = 224;
  Region region = Region::square;
  /// In (0, 1]; "resize to 256, cut 224" is 224 / 256 = 0.875.
  double crop = 0.875;
  /// How to shrink (area averages all pixels); `area` enlarges linearly.
  Resize resize = Resize::area;
  /// Order of the input's channels, also of `mean` and `scale`.
  Color color = Color::rgb;
  /// Subtracted from values of 0 … 255.
  std::array<double, 3> mean{0, 0, 0};
  /// Multiplied afterwards, e.g. 1 / 127.5.
  std::array<double, 3> scale{1, 1, 1};
};

/// A model as its folder's `model.toml` describes it. Keys stand in brackets where their names differ.
struct ModelSpec {
  /// Where model.toml lies; the other paths are relative to it.
  std::filesystem::path folder;
  /// Letters, digits, `.`, `_`, `-`; the folder's name in the model home.
  std::string name;
  /// One of labelerTypes(). "network" is run by the best engine at hand that can open its file, or the one
  /// that the user names; "opencv" and "onnxruntime" are networks for that engine only.
  std::string type = "network";
  /// The network: .onnx, .caffemodel or .pb.
  std::filesystem::path file;
  /// Network in 8 bits (.onnx); "" if there is none.
  std::filesystem::path int8;
  /// Its .prototxt (Caffe, required) or .pbtxt (TensorFlow).
  std::filesystem::path config;
  /// One label a line, in the order of the outputs.
  std::filesystem::path labels;
  /// The output to read, where a network has several; of an ONNX network any value inside of it, too.
  std::string output;
  /// [input, region, crop, resize, color, mean, scale].
  Preprocessing preprocessing;

  // What the outputs mean; see toProbabilities() in network_labeler.hpp.
  enum class Reduce { none, max };
  /// max: a row of outputs for each of many anchors in the image.
  Reduce reduce = Reduce::none;
  /// With reduce: cells a side of the grids of the rows' default boxes (defaultBoxes()); empty where unknown.
  std::vector<int> anchors;
  /// The outputs are logits of labels that exclude each other.
  bool softmax = false;
  /// The outputs are logits of labels that do not.
  bool sigmoid = false;
  /// Outputs that have no label (background, numbers never given), ascending.
  std::vector<std::size_t> unused;
  /// .npy, labels×D: the network embeds images (CLIP), see network_labeler.hpp.
  std::filesystem::path embeddings;
  /// [logit_scale] of their cosines with the embeddings.
  double logitScale = 100;

  /// The outputs are so many features without names, all ≥ 0, as of an inner layer after its ReLU: each one
  /// counts as its share of their sum, and is called NAME 0, NAME 1 …; 0: the outputs have labels.
  std::size_t features = 0;

  /// LabelerOptions::reducedImages; not of model.toml.
  bool reducedImages = false;

  /// For people.
  std::string license, source;
  /// File → 64 hex digits, verified whenever the model is loaded.
  std::map<std::string, std::string> sha256;
};

/// How exactly a network computes.
enum class Precision {
  float32,
  /// 8 bits, by ModelSpec::int8.
  int8,
};

/// Reads FOLDER/model.toml. Throws Error `…/model.toml:LINE: …` on unknown, missing or wrong keys, and when a
/// path leaves the folder. For a type that is no network only the common keys are read: name, type, labels,
/// license, source, sha256.
ModelSpec readModelSpec(const std::filesystem::path& folder);

}  // namespace estancia
