// SPDX-License-Identifier: Apache-2.0
#include "convert/tfjs_weights.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <utility>

#include "convert/tfjs_json.hpp"
#include "convert/tflite_graph.hpp"
#include "estancia/core/error.hpp"

namespace estancia::tfjs {
namespace fs = std::filesystem;
namespace {

using Json = nlohmann::json;

constexpr std::size_t maxRank = 8;
constexpr std::size_t largest = std::size_t{1} << 31;  // limit of all weights [bytes]

fs::path shardPath(const Json& path) {
  fs::path relative = path.get<std::string>();
  if (relative.empty() || relative.is_absolute() ||
      std::any_of(relative.begin(), relative.end(), [](const fs::path& part) { return part == ".."; }))
    throw Error(ErrorCode::unsafePath, fmt::format("names the weight file {}; it must lie in the same folder",
                                                   inQuotes(relative.string())));
  return relative;
}

/// Where a shard is, after all links.
fs::path shardIn(const fs::path& folder, const fs::path& relative) {
  const fs::path shard = folder / relative;
  if (!fs::is_regular_file(shard))
    throw Error(ErrorCode::fileNotFound,
                fmt::format("lacks its weight file {}; fetch it again", inQuotes(relative.string())));
  fs::path real = fs::canonical(shard);
  const fs::path home = fs::canonical(folder);
  if (std::mismatch(home.begin(), home.end(), real.begin(), real.end()).first != home.end())
    throw Error(ErrorCode::unsafePath,
                fmt::format("has the weight file {}, which leads out of the folder; copy the file there",
                            inQuotes(relative.string())));
  return real;
}

void append(const fs::path& shard, std::size_t size, std::vector<std::uint8_t>& bytes) {
  const std::size_t start = bytes.size();
  bytes.resize(start + size);
  std::ifstream file(shard, std::ios::binary);
  if (!file.read(reinterpret_cast<char*>(bytes.data() + start), static_cast<std::streamsize>(size)))
    throw Error(ErrorCode::fileUnreadable, fmt::format("cannot read its weight file {}", shard.string()));
}

}  // namespace

std::vector<fs::path> weightFiles(const fs::path& modelJson) {
  return readJson(modelJson, [&](const Json& model) {
    std::vector<fs::path> files;
    for (const auto& group : model.at("weightsManifest"))
      for (const auto& path : group.at("paths")) files.push_back(shardPath(path));
    return files;
  });
}

std::size_t Weights::bytesOf(Stored stored) {
  switch (stored) {
    case Stored::float32:
    case Stored::int32:
      return 4;
    case Stored::float16:
    case Stored::uint16:
      return 2;
    case Stored::boolean:
    case Stored::uint8:
      break;
  }
  return 1;
}

Weights::Entry Weights::readEntry(const Json& weight, const std::string& name) {
  Entry entry;
  for (const auto& size : weight.at("shape")) {
    const auto value = size.get<std::int64_t>();
    if (entry.shape.size() == maxRank || value < 1 ||
        static_cast<std::uint64_t>(value) > maxElements / entry.elements)
      throw Error(ErrorCode::malformedFile,
                  fmt::format("has a weight of impossible shape: {} {}", inQuotes(name),
                              weight.at("shape").dump().substr(0, 100)));
    entry.shape.push_back(static_cast<int>(value));
    entry.elements *= static_cast<std::size_t>(value);
  }
  const auto quantization = weight.find("quantization");
  const bool quantized = quantization != weight.end();
  entry.type = weight.at("dtype").get<std::string>();
  const std::string stored = quantized ? quantization->at("dtype").get<std::string>() : entry.type;
  const std::map<std::string, Stored> known =
      quantized ? std::map<std::string, Stored>{{"float16", Stored::float16},
                                                {"uint8", Stored::uint8},
                                                {"uint16", Stored::uint16}}
                : std::map<std::string, Stored>{
                      {"float32", Stored::float32}, {"int32", Stored::int32}, {"bool", Stored::boolean}};
  if (!known.contains(stored))
    throw Error(ErrorCode::unsupportedFile,
                fmt::format("stores {} in the unsupported type {}", inQuotes(name), inQuotes(stored)));
  entry.stored = known.at(stored);
  if (quantized && entry.stored != Stored::float16) {
    entry.scale = quantization->at("scale").get<double>();
    entry.least = quantization->at("min").get<double>();
    if (!std::isfinite(entry.scale) || !std::isfinite(entry.least))
      throw Error(ErrorCode::malformedFile, fmt::format("has a scale that is no number: {}", inQuotes(name)));
  }
  return entry;
}

Weights::Weights(const Json& manifest, const fs::path& folder) {
  std::map<fs::path, std::size_t> sizes;  // sizes of all shards; each is read once
  for (const auto& group : manifest) {
    std::size_t needed = 0;
    const std::size_t start = bytes_.size();
    for (const auto& weight : group.at("weights")) {
      const auto name = weight.at("name").get<std::string>();
      Entry entry = readEntry(weight, name);
      entry.start = start + needed;
      needed += entry.elements * bytesOf(entry.stored);
      if (!entries_.emplace(name, std::move(entry)).second)
        throw Error(ErrorCode::malformedFile, fmt::format("has two weights of the name {}", inQuotes(name)));
    }
    std::vector<fs::path> shards;
    std::size_t stored = 0;
    for (const auto& path : group.at("paths")) {
      shards.push_back(shardIn(folder, shardPath(path)));
      const auto [shard, isNew] = sizes.emplace(shards.back(), fs::file_size(shards.back()));
      if (!isNew)
        throw Error(ErrorCode::malformedFile, fmt::format("names the weight file {} twice",
                                                          inQuotes(shard->first.filename().string())));
      stored += shard->second;
    }
    if (stored != needed)
      throw Error(
          ErrorCode::truncatedFile,
          fmt::format("needs {} bytes of weights where its files hold {}; fetch them again", needed, stored));
    if (bytes_.size() + needed > largest)
      throw Error(ErrorCode::tooLarge, "holds more than the 2 GiB that an ONNX file can");
    for (const auto& shard : shards) append(shard, sizes.at(shard), bytes_);
  }
}

const Weights::Entry& Weights::entry(const std::string& name) const {
  const auto found = entries_.find(name);
  if (found == entries_.end())
    throw Error(ErrorCode::malformedFile, fmt::format("has no weight {}", inQuotes(name)));
  return found->second;
}

double Weights::value(const Entry& entry, std::size_t i) const {
  const std::uint8_t* at = bytes_.data() + entry.start + i * bytesOf(entry.stored);
  const auto load = [at](auto stored) {
    std::memcpy(&stored, at, sizeof(stored));
    return static_cast<double>(stored);
  };
  switch (entry.stored) {
    case Stored::float32:
      return load(float{});
    case Stored::int32:
      return load(std::int32_t{});
    case Stored::float16:
      return tflite::halfToFloat(static_cast<std::uint16_t>(load(std::uint16_t{})));
    case Stored::uint16:
      return load(std::uint16_t{}) * entry.scale + entry.least;
    case Stored::boolean:
    case Stored::uint8:
      break;
  }
  return load(std::uint8_t{}) * entry.scale + entry.least;
}

std::vector<float> Weights::reals(const std::string& name) const {
  const Entry& from = entry(name);
  if (from.type != "float32")
    throw Error(ErrorCode::malformedFile, fmt::format("stores {} as {} where real numbers are needed",
                                                      inQuotes(name), inQuotes(from.type)));
  std::vector<float> values(from.elements);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<float>(value(from, i));
  return values;
}

std::vector<std::int64_t> Weights::integers(const std::string& name) const {
  const Entry& from = entry(name);
  if (from.stored != Stored::int32 || from.elements > 1024)
    throw Error(ErrorCode::malformedFile,
                fmt::format("stores {} as {} of shape [{}] where a few integers are needed", inQuotes(name),
                            inQuotes(from.type), fmt::join(from.shape, "×")));
  std::vector<std::int64_t> values(from.elements);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = std::llround(value(from, i));
  return values;
}

}  // namespace estancia::tfjs
