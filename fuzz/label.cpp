// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <opencv2/core/mat.hpp>

#include "estancia/core/home.hpp"
#include "estancia/label/catalog.hpp"
#include "estancia/label/label_stream.hpp"
#include "estancia/labelers/http_settings.hpp"
#include "estancia/labelers/model.hpp"
#include "estancia/labelers/model_files.hpp"
#include "estancia/labelers/recorded_labeler.hpp"
#include "fuzz/answering_server.hpp"
#include "fuzz/fuzz_target.hpp"

namespace estancia::fuzz {

/// model.toml of a network, and a file of labels.
FUZZ_TARGET(label, model_spec) {
  const auto files = parts(bytes, 2);
  inputFile("labels.txt", files[1]);
  inputFile("model.toml", files[0]);
  readModelSpec(folder());
}

/// model.toml of a labeling service.
FUZZ_TARGET(label, http_model) {
  inputFile("model.toml", bytes);
  const ModelSpec spec = readModelSpec(folder());
  if (spec.type == "http") readHttpSettings(spec);
}

/// What a labeling service answers. It has a vocabulary: new words would stay.
FUZZ_TARGET(label, http_answer) {
  static AnsweringServer server;
  static const std::unique_ptr<Labeler> labeler = [] {
    inputFile("labels.txt", "mug\nsofa\n");
    inputFile("model.toml", fmt::format("name = 'x'\ntype = 'http'\nlabels = 'labels.txt'\nattempts = 1\n"
                                        "url = '{}/label'\n",
                                        server.url()));
    return loadModel(readModelSpec(folder()));
  }();
  static const Prepared image = labeler->prepare(cv::Mat(8, 8, CV_8UC3, cv::Scalar(1, 2, 3)), "1.png");
  server.answerWith(bytes);
  labeler->infer(image);
}

FUZZ_TARGET(label, onnx) {
  ModelSpec spec;
  spec.folder = folder();
  spec.name = "input";
  spec.file = inputFile("input.onnx", bytes).filename();
  readOnnx(spec);
}

/// The name of an output inside of the network, and the network.
FUZZ_TARGET(label, onnx_output) {
  const auto files = parts(bytes, 2);
  ModelSpec spec;
  spec.folder = folder();
  spec.name = "input";
  spec.output = std::string(files[0]);
  spec.file = inputFile("input.onnx", files[1]).filename();
  readOnnx(spec);
}

FUZZ_TARGET(label, catalog) {
  Catalog catalog;
  catalog.add("catalog.toml", std::string(bytes));
}

FUZZ_TARGET(label, human_labels) {
  readHumanLabels(inputFile("input.csv", bytes));
}

/// A file of the cache of answers, as another process has left it.
FUZZ_TARGET(label, cache_file) {
  const std::filesystem::path home = folder() / "cache";
  std::filesystem::create_directories(home);
  LabelCache(home).put("model", "image", "answer");
  for (const auto& entry : std::filesystem::directory_iterator(home))
    if (entry.is_regular_file()) inputFile("cache/" + entry.path().filename().string(), bytes);
  LabelCache cache(home);
  cache.find("model", "image");
  cache.put("model", "other", "answer");
  cache.usage();
  cache.clear();
}

}  // namespace estancia::fuzz
