// SPDX-License-Identifier: Apache-2.0
#include "convert/model_folder.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <set>
#include <sstream>

#include "convert/tfjs_weights.hpp"
#include "estancia/core/config.hpp"
#include "estancia/core/digest.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/output_file.hpp"
#include "estancia/labelers/model_files.hpp"

namespace estancia::convert {
namespace fs = std::filesystem;
namespace {

constexpr int maxSide = 4096;  // side of an image [pixels]

/// model.toml, as far as a conversion needs it.
class ModelToml {
 public:
  explicit ModelToml(const fs::path& folder) : config_(folder / "model.toml") {
    spec_.folder = folder;
    config_.read(
        {
            {"name", true, "the model's name", [this](auto& n) { spec_.name = config_.text(n); }},
            {"file", true, "the network's file", [this](auto& n) { spec_.file = config_.inside(n); }},
            {"labels", false, "the label file", [this](auto& n) { others_.insert(config_.inside(n)); }},
            {"embeddings", false, "text embeddings", [this](auto& n) { others_.insert(config_.inside(n)); }},
            {"input_node", false, "the node that takes the image",
             [this](auto& n) { source_.inputNode = config_.text(n); }},
            {"output", false, "the output to read",
             [this](auto& n) { source_.outputNode = config_.text(n); }},
            {"input", true, "the input's size", [this](auto& n) { readInput(n); }},
            {"sha256", false, "the files' digests", [this](auto& n) { readDigests(n); }},
        },
        ConfigFile::Others::skip);
    source_.file = modelFile(spec_, spec_.file);
    networkFiles_.insert(spec_.file);
    if (spec_.file.extension() == ".json")
      for (const fs::path& shard : tfjs::weightFiles(source_.file))
        networkFiles_.insert(spec_.file.parent_path() / shard);
  }

  const NetworkSource& source() const { return source_; }

  void requireDigests() const {
    for (const auto& [file, expected] : spec_.sha256) {
      const fs::path path = modelFile(spec_, file);
      if (const std::string actual = sha256OfFile(path); actual != expected)
        throw Error(ErrorCode::corruptFile,
                    fmt::format("{} has SHA-256 {} where model.toml says {}; fetch it again", path.string(),
                                actual, expected));
    }
  }

  /// Copies the files that are not the network.
  void copyOthers(const fs::path& target) const {
    std::set<fs::path> files = others_;
    for (const auto& [file, digest] : spec_.sha256) files.insert(file);
    for (const fs::path& file : files) {
      if (networkFiles_.contains(file)) continue;
      fs::create_directories((target / file).parent_path());
      fs::copy_file(modelFile(spec_, file), target / file, fs::copy_options::overwrite_existing);
    }
  }

  /// The text of the new model.toml.
  std::string withNetwork(const std::string& file, const std::string& digest) const {
    toml::table table = config_.table();
    table.insert_or_assign("file", file);
    table.erase("input_node");
    table.erase("output");
    if (toml::table* digests = table["sha256"].as_table()) {
      for (const fs::path& old : networkFiles_) digests->erase(old.string());
      digests->insert_or_assign(file, digest);
    }
    std::ostringstream text;
    text << table << '\n';
    return text.str();
  }

 private:
  void readInput(const toml::node& node) {
    const auto side = [this](const toml::node& n) {
      return static_cast<int>(config_.integer(n, 1, maxSide));
    };
    const toml::array* sides = node.as_array();
    if (sides != nullptr && sides->size() != 2)
      config_.fail(node, "`input` must be one side of a square or [width, height]");
    source_.width = side(sides == nullptr ? node : *sides->get(0));
    source_.height = sides == nullptr ? source_.width : side(*sides->get(1));
  }

  void readDigests(const toml::node& node) {
    for (const auto& [file, digest] : config_.subtable(node))
      spec_.sha256[config_.inside(digest, fs::path(file.str())).string()] = config_.text(digest);
  }

  ConfigFile config_;
  ModelSpec spec_;
  NetworkSource source_;
  std::set<fs::path> others_, networkFiles_;
};

}  // namespace

NetworkSource networkOf(const fs::path& folder) {
  const ModelToml model(folder);
  model.requireDigests();
  return model.source();
}

void convertModel(const fs::path& folder, const fs::path& target) {
  const ModelToml model(folder);
  model.requireDigests();
  fs::create_directories(target);
  model.copyOthers(target);
  const std::string file = model.source().file.stem().string() + ".onnx";
  writeOnnx(model.source(), target / file, true);
  writeWhole(target / "model.toml", model.withNetwork(file, sha256OfFile(target / file)));
}

ConvertedModel::ConvertedModel(const fs::path& folder) : original_(folder) {
  if (!fs::is_regular_file(folder / "model.toml")) return;
  const ConfigFile config(folder / "model.toml");
  if (!needsConversion(config.table()["file"].value_or(std::string()))) return;
  copy_ = fs::temp_directory_path() / fmt::format("estancia-convert-{}", getpid());
  try {
    convertModel(folder, copy_);
  } catch (...) {
    std::error_code ignored;
    fs::remove_all(copy_, ignored);
    throw;
  }
}

ConvertedModel::~ConvertedModel() {
  std::error_code ignored;
  if (!copy_.empty()) fs::remove_all(copy_, ignored);
}

}  // namespace estancia::convert
