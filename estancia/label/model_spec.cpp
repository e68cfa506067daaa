#include "estancia/label/model_spec.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>
#include <vector>

#include "estancia/core/digest.hpp"
#include "estancia/core/error.hpp"

namespace estancia {
namespace fs = std::filesystem;
namespace {

/// Reads one model.toml. Every complaint names file and line.
class SpecReader {
 public:
  explicit SpecReader(const fs::path& folder) : path_(folder / "model.toml") { spec_.folder = folder; }

  ModelSpec read() {
    if (!fs::is_regular_file(path_))
      throw Error(fmt::format("{} is missing; a model is a folder with a model.toml", path_.string()));
    try {
      const toml::table table = toml::parse_file(path_.string());
      for (const auto& [key, value] : table) readKey(std::string(key.str()), value);
      for (const auto& key : keys())
        if (key.required && !table.contains(key.name))
          throw Error(fmt::format("{}: the key `{}` is missing: {}", path_.string(), key.name, key.meaning));
    } catch (const toml::parse_error& e) {
      throw Error(
          fmt::format("{}:{}: {}", path_.string(), e.source().begin.line, std::string(e.description())));
    }
    return spec_;
  }

 private:
  struct Key {
    std::string name;
    bool required;
    std::string meaning;
    std::function<void(const toml::node&)> use;
  };

  /// All keys of model.toml: the one place that knows them.
  std::vector<Key> keys() {
    auto& pre = spec_.preprocessing;
    using P = Preprocessing;
    return {
        {"name", true, "the model's name", [this](auto& n) { spec_.name = nameOf(n); }},
        {"type", false, "the engine", [this](auto& n) { spec_.type = text(n); }},
        {"file", true, "the network's file", [this](auto& n) { spec_.file = inside(n); }},
        {"config", false, "the file of the network's layers", [this](auto& n) { spec_.config = inside(n); }},
        {"labels", true, "the label file", [this](auto& n) { spec_.labels = inside(n); }},
        {"output", false, "the output to read", [this](auto& n) { spec_.output = text(n); }},
        {"input", true, "the input's size, 224 or [width, height]", [this](auto& n) { readInput(n); }},
        {"region", false, "what is cut out",
         [&](auto& n) {
           pre.region =
               choice<P::Region>(n, {{"square", P::Region::square}, {"stretch", P::Region::stretch}});
         }},
        {"crop", false, "how much is cut out", [&](auto& n) { pre.crop = number(n, 0.01, 1); }},
        {"resize", false, "how pixels are resized",
         [&](auto& n) {
           pre.resize = choice<P::Resize>(
               n, {{"area", P::Resize::area}, {"linear", P::Resize::linear}, {"cubic", P::Resize::cubic}});
         }},
        {"colour", true, "\"RGB\" or \"BGR\"",
         [&](auto& n) {
           pre.colour = choice<P::Colour>(n, {{"RGB", P::Colour::rgb}, {"BGR", P::Colour::bgr}});
         }},
        {"mean", false, "what is subtracted", [&](auto& n) { pre.mean = numbers(n, -1e6, 1e6); }},
        {"scale", false, "the factor after it", [&](auto& n) { pre.scale = numbers(n, 1e-9, 1e6); }},
        {"softmax", false, "true when the network gives logits",
         [this](auto& n) { spec_.softmax = get<bool>(n, "true or false"); }},
        {"licence", false, "the network's licence", [this](auto& n) { spec_.licence = text(n); }},
        {"source", false, "where the network comes from", [this](auto& n) { spec_.source = text(n); }},
        {"sha256", false, "the files' digests", [this](auto& n) { readDigests(n); }},
    };
  }

  [[noreturn]] void fail(const toml::node& at, const std::string& what) const {
    throw Error(fmt::format("{}:{}: {}", path_.string(), at.source().begin.line, what));
  }

  void readKey(const std::string& name, const toml::node& value) {
    const auto all = keys();
    const auto found = std::find_if(all.begin(), all.end(), [&](const Key& k) { return k.name == name; });
    if (found == all.end()) {
      std::vector<std::string> names;
      for (const auto& key : all) names.push_back(key.name);
      fail(value, fmt::format("unknown key `{}`; known keys are {}", name, fmt::join(names, ", ")));
    }
    key_ = name;
    found->use(value);
  }

  template <class Value>
  Value get(const toml::node& node, const char* expected) const {
    const auto value = node.value_exact<Value>();
    if (!value) fail(node, fmt::format("`{}` must be {}", key_, expected));
    return *value;
  }

  std::string text(const toml::node& node) const { return get<std::string>(node, "a text in quotes"); }

  std::string nameOf(const toml::node& node) const {
    const std::string name = text(node);
    const auto allowed = [](unsigned char c) { return std::isalnum(c) || c == '.' || c == '_' || c == '-'; };
    if (name.empty() || name.size() > 100 || name[0] == '.' ||
        !std::all_of(name.begin(), name.end(), allowed))
      fail(node, fmt::format("`{}` must be made of letters, digits, `_`, `-` and `.`, and not start with `.`",
                             key_));
    return name;
  }

  fs::path inside(const toml::node& node) const { return inside(node, text(node)); }

  fs::path inside(const toml::node& node, const fs::path& path) const {
    if (path.empty() || path.is_absolute() ||
        std::any_of(path.begin(), path.end(), [](auto& p) { return p == ".."; }))
      fail(node,
           fmt::format("`{}` must be a file in the model's own folder, not \"{}\"", key_, path.string()));
    return path;
  }

  double number(const toml::node& node, double least, double most) const {
    const auto value = node.value<double>();
    if (!value || node.is_boolean() || !std::isfinite(*value) || *value < least || *value > most)
      fail(node, fmt::format("`{}` must be a number from {} to {}", key_, least, most));
    return *value;
  }

  /// One number for all channels, or one a channel.
  std::array<double, 3> numbers(const toml::node& node, double least, double most) const {
    const auto* list = node.as_array();
    if (list == nullptr) {
      const double all = number(node, least, most);
      return {all, all, all};
    }
    if (list->size() != 3)
      fail(node, fmt::format("`{}` must be one number or three, in the order of `colour`", key_));
    return {number(*list->get(0), least, most), number(*list->get(1), least, most),
            number(*list->get(2), least, most)};
  }

  template <class Value>
  Value choice(const toml::node& node, const std::vector<std::pair<std::string, Value>>& choices) const {
    const std::string chosen = text(node);
    std::string known;
    for (const auto& [name, value] : choices) {
      if (name == chosen) return value;
      known += fmt::format("{}\"{}\"", known.empty() ? "" : ", ", name);
    }
    fail(node, fmt::format("`{}` must be one of {}, not \"{}\"", key_, known, chosen));
  }

  void readInput(const toml::node& node) {
    const auto side = [this](const toml::node& n) {
      const auto value = n.value_exact<std::int64_t>();
      if (!value || *value < 1 || *value > 4096) fail(n, "`input` must be whole pixels from 1 to 4096");
      return static_cast<int>(*value);
    };
    auto& pre = spec_.preprocessing;
    if (const auto* list = node.as_array()) {
      if (list->size() != 2) fail(node, "`input` must be one side of a square or [width, height]");
      pre.width = side(*list->get(0));
      pre.height = side(*list->get(1));
    } else {
      pre.width = pre.height = side(node);
    }
  }

  void readDigests(const toml::node& node) {
    const auto* table = node.as_table();
    if (table == nullptr) fail(node, "`sha256` must be a table: file = \"64 hex digits\"");
    for (const auto& [file, digest] : *table) {
      key_ = fmt::format("sha256.{}", std::string(file.str()));
      std::string hex = text(digest);
      std::transform(hex.begin(), hex.end(), hex.begin(), [](unsigned char c) { return std::tolower(c); });
      if (hex.size() != 64 || hex.find_first_not_of("0123456789abcdef") != std::string::npos)
        fail(digest, fmt::format("`{}` must be 64 hex digits", key_));
      spec_.sha256[inside(digest, file.str()).string()] = hex;
    }
  }

  fs::path path_;
  ModelSpec spec_;
  std::string key_;  ///< being read
};

std::string preprocessingText(const Preprocessing& how) {
  return fmt::format("{}x{} {} {} {} {} {} {}", how.width, how.height, static_cast<int>(how.region), how.crop,
                     static_cast<int>(how.resize), static_cast<int>(how.colour), fmt::join(how.mean, ","),
                     fmt::join(how.scale, ","));
}

}  // namespace

ModelSpec readModelSpec(const fs::path& folder) {
  return SpecReader(folder).read();
}

fs::path modelFile(const ModelSpec& spec, const fs::path& relative) {
  const fs::path path = spec.folder / relative;
  if (!fs::is_regular_file(path))
    throw Error(
        fmt::format("model {}: {} is missing; fetch it or correct model.toml", spec.name, path.string()));
  const fs::path real = fs::canonical(path), home = fs::canonical(spec.folder);
  if (std::mismatch(home.begin(), home.end(), real.begin(), real.end()).first != home.end())
    throw Error(fmt::format("model {}: {} leads out of the model's folder; copy the file there", spec.name,
                            path.string()));
  return path;
}

std::string modelDigest(const ModelSpec& spec) {
  std::map<std::string, std::string> files = spec.sha256;  // file → the digest it should have, "" = any
  for (const auto& file : {spec.file, spec.config, spec.labels})
    if (!file.empty()) files.try_emplace(file.string());
  std::string all =
      fmt::format("{} {} {}\n", preprocessingText(spec.preprocessing), spec.softmax, spec.output);
  for (const auto& [file, expected] : files) {
    const fs::path path = modelFile(spec, file);
    const std::string actual = sha256OfFile(path);
    if (!expected.empty() && actual != expected)
      throw Error(fmt::format("{} has SHA-256 {} where model.toml says {}; fetch it again", path.string(),
                              actual, expected));
    all += fmt::format("{} {}\n", file, actual);
  }
  return sha256(all);
}

}  // namespace estancia
