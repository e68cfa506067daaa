// SPDX-License-Identifier: Apache-2.0
#include "estancia/labelers/model_spec.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "estancia/core/config.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/labelers/model_files.hpp"

namespace estancia {
namespace fs = std::filesystem;
namespace {

/// Reads one model.toml.
class SpecReader {
 public:
  explicit SpecReader(const fs::path& folder) : file_(folder / "model.toml") { spec_.folder = folder; }

  ModelSpec read() {
    const bool network = isNetworkType(file_.table()["type"].value_or(std::string("network")));
    // Further keys of a black box are read by its own type.
    if (!network)
      file_.read(commonKeys(false), ConfigFile::Others::skip);
    else
      file_.read(networkKeys());
    return spec_;
  }

 private:
  std::vector<ConfigFile::Key> commonKeys(bool labelsRequired) {
    return {
        {"name", true, "the model's name", [this](auto& n) { spec_.name = nameOf(n); }},
        {"type", false, "what kind of labeler it is", [this](auto& n) { spec_.type = file_.text(n); }},
        {"labels", labelsRequired, "the label file", [this](auto& n) { spec_.labels = file_.inside(n); }},
        {"license", false, "the model's license", [this](auto& n) { spec_.license = file_.text(n); }},
        {"source", false, "where the model comes from", [this](auto& n) { spec_.source = file_.text(n); }},
        {"sha256", false, "the files' digests", [this](auto& n) { readDigests(n); }},
    };
  }

  std::vector<ConfigFile::Key> networkKeys() {
    auto& pre = spec_.preprocessing;
    using P = Preprocessing;
    auto keys = commonKeys(!file_.table().contains("features"));
    const std::vector<ConfigFile::Key> own{
        {"file", true, "the network's file", [this](auto& n) { readFile(n); }},
        {"int8", false, "the file of the network in 8 bits", [this](auto& n) { readInt8(n); }},
        {"config", false, "the file of the network's layers",
         [this](auto& n) { spec_.config = file_.inside(n); }},
        {"output", false, "the output to read", [this](auto& n) { spec_.output = file_.text(n); }},
        {"input", true, "the input's size, 224 or [width, height]", [this](auto& n) { readInput(n); }},
        {"region", false, "what is cut out",
         [&](auto& n) {
           pre.region =
               file_.choice<P::Region>(n, {{"square", P::Region::square}, {"stretch", P::Region::stretch}});
         }},
        {"crop", false, "how much is cut out", [&](auto& n) { pre.crop = file_.number(n, 0.01, 1); }},
        {"resize", false, "how pixels are resized",
         [&](auto& n) {
           pre.resize = file_.choice<P::Resize>(
               n, {{"area", P::Resize::area}, {"linear", P::Resize::linear}, {"cubic", P::Resize::cubic}});
         }},
        {"color", true, "\"RGB\" or \"BGR\"",
         [&](auto& n) {
           pre.color = file_.choice<P::Color>(n, {{"RGB", P::Color::rgb}, {"BGR", P::Color::bgr}});
         }},
        {"mean", false, "what is subtracted", [&](auto& n) { pre.mean = numbers(n, -1e6, 1e6); }},
        {"scale", false, "the factor after it", [&](auto& n) { pre.scale = numbers(n, 1e-9, 1e6); }},
        {"softmax", false, "true when the network gives logits",
         [this](auto& n) { spec_.softmax = file_.flag(n); }},
        {"embeddings", false, "the file of the words' text embeddings",
         [this](auto& n) { spec_.embeddings = file_.inside(n); }},
        {"logit_scale", false, "the factor of the cosines with them",
         [this](auto& n) { spec_.logitScale = file_.number(n, 1e-3, 1e6); }},
        {"sigmoid", false, "true when the network gives logits of labels that do not exclude each other",
         [this](auto& n) { readSigmoid(n); }},
        {"reduce", false, "how many rows of outputs become one",
         [this](auto& n) {
           using R = ModelSpec::Reduce;
           spec_.reduce = file_.choice<R>(n, {{"none", R::none}, {"max", R::max}});
         }},
        {"anchors", false, "cells a side of the grids of a detector's default boxes",
         [this](auto& n) { readAnchors(n); }},
        {"unused", false, "outputs without a label", [this](auto& n) { readUnused(n); }},
        {"features", false, "how many outputs there are, when they have no names",
         [this](auto& n) { spec_.features = static_cast<std::size_t>(file_.integer(n, 2, 1'000'000)); }},
    };
    keys.insert(keys.end(), own.begin(), own.end());
    return keys;
  }

  std::string nameOf(const toml::node& node) const {
    const std::string name = file_.text(node);
    if (!isSafeName(name))
      file_.fail(node, "`name` must be made of letters, digits, `_`, `-` and `.`, and not start with `.`");
    return name;
  }

  /// One number for all channels, or one a channel.
  std::array<double, 3> numbers(const toml::node& node, double min, double max) const {
    const auto* list = node.as_array();
    if (list == nullptr) {
      const double all = file_.number(node, min, max);
      return {all, all, all};
    }
    if (list->size() != 3)
      file_.fail(node, fmt::format("`{}` must be one number or three, in the order of `color`", file_.key()));
    return {file_.number(*list->get(0), min, max), file_.number(*list->get(1), min, max),
            file_.number(*list->get(2), min, max)};
  }

  void readFile(const toml::node& node) {
    spec_.file = file_.inside(node);
    requireKnownFormat(spec_);
  }

  void readInt8(const toml::node& node) {
    spec_.int8 = file_.inside(node);
    if (spec_.int8.extension() != ".onnx" || spec_.int8 == spec_.file)
      file_.fail(node, "`int8` must name an .onnx file beside `file`, as `estancia models quantize` makes");
  }

  void readInput(const toml::node& node) {
    const auto side = [this](const toml::node& n) {
      const auto value = n.value_exact<std::int64_t>();
      if (!value || *value < 1 || *value > 4096) file_.fail(n, "`input` must be whole pixels from 1 to 4096");
      return static_cast<int>(*value);
    };
    auto& pre = spec_.preprocessing;
    if (const auto* list = node.as_array()) {
      if (list->size() != 2) file_.fail(node, "`input` must be one side of a square or [width, height]");
      pre.width = side(*list->get(0));
      pre.height = side(*list->get(1));
    } else {
      pre.width = pre.height = side(node);
    }
  }

  void readSigmoid(const toml::node& node) {
    spec_.sigmoid = file_.flag(node);
    if (spec_.sigmoid && file_.table()["softmax"].value_or(false))
      file_.fail(node, "`sigmoid` and `softmax` exclude each other");
  }

  void readAnchors(const toml::node& node) {
    constexpr std::size_t maxGrids = 16;
    for (const auto& grid : file_.list(node))
      spec_.anchors.push_back(static_cast<int>(file_.integer(grid, 1, 256)));
    if (spec_.anchors.empty() || spec_.anchors.size() > maxGrids)
      file_.fail(node, fmt::format("`anchors` must name 1 to {} grids", maxGrids));
  }

  void readUnused(const toml::node& node) {
    for (const auto& output : file_.list(node))
      spec_.unused.push_back(static_cast<std::size_t>(file_.integer(output, 0, 1'000'000)));
    std::sort(spec_.unused.begin(), spec_.unused.end());
    if (std::adjacent_find(spec_.unused.begin(), spec_.unused.end()) != spec_.unused.end())
      file_.fail(node, "`unused` names an output twice");
  }

  void readDigests(const toml::node& node) {
    const auto* table = node.as_table();
    if (table == nullptr) file_.fail(node, "`sha256` must be a table: file = \"64 hex digits\"");
    for (const auto& [file, digest] : *table) {
      const std::string hex = hexDigits(file_.text(digest), 64);
      if (hex.empty())
        file_.fail(digest, fmt::format("`sha256.{}` must be 64 hex digits", std::string(file.str())));
      spec_.sha256[file_.inside(digest, file.str()).string()] = hex;
    }
  }

  ConfigFile file_;
  ModelSpec spec_;
};

}  // namespace

ModelSpec readModelSpec(const fs::path& folder) {
  if (!fs::is_regular_file(folder / "model.toml"))
    fail(ErrorCode::fileNotFound, "{} is missing; a model is a folder with a model.toml",
         (folder / "model.toml").string());
  return SpecReader(folder).read();
}

}  // namespace estancia
