// SPDX-License-Identifier: Apache-2.0
#include "estancia/labelers/model_files.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>

#include "estancia/core/ascii.hpp"
#include "estancia/core/digest.hpp"
#include "estancia/core/fail.hpp"

namespace estancia {
namespace fs = std::filesystem;

bool isNetworkType(std::string_view type) {
  return type == "network" || type == "opencv" || type == "onnxruntime";
}

bool isSafeName(std::string_view name) {
  return !name.empty() && name.size() <= 100 && name[0] != '.' &&
         std::all_of(name.begin(), name.end(),
                     [](char c) { return isLetterOrDigit(c) || c == '.' || c == '_' || c == '-'; });
}

std::string hexDigits(std::string text, std::size_t digits) {
  text = lowerCase(std::move(text));
  const bool hex = text.size() == digits && text.find_first_not_of("0123456789abcdef") == std::string::npos;
  return hex ? text : "";
}

std::vector<fs::path> networkFiles(const ModelSpec& spec) {
  std::vector<fs::path> files;
  for (const auto& file : {spec.file, spec.config, spec.embeddings})
    if (!file.empty()) files.push_back(file);
  return files;
}

void requireKnownFormat(const ModelSpec& spec) {
  const std::string extension = spec.file.extension().string();
  if (extension == ".onnx" || extension == ".caffemodel" || extension == ".pb") return;
  const std::string file = (spec.folder / spec.file).string();
  if (extension == ".tflite" || extension == ".lite" || extension == ".json")
    fail(ErrorCode::unsupportedFile,
         "{} must be converted to ONNX first; run `estancia models add {}`, or `estancia models convert` for "
         "the network alone",
         file, spec.folder.string());
  fail(ErrorCode::unsupportedFile, "{} is no known kind of network; known are .onnx, .caffemodel and .pb",
       file);
}

bool isInt8(const ModelSpec& spec) {
  return !spec.int8.empty() && spec.file == spec.int8;
}

ModelSpec inPrecision(ModelSpec spec, Precision precision) {
  const bool wanted = precision == Precision::int8;
  if (wanted && spec.int8.empty())
    fail(ErrorCode::unsupportedFile,
         "model {} has no network of 8 bits; make it with `estancia models quantize {} IMAGES`, or leave out "
         "--precision int8",
         spec.name, spec.folder.string());
  spec.sha256.erase(wanted ? spec.file.string() : spec.int8.string());
  if (wanted)
    spec.file = spec.int8;
  else
    spec.int8.clear();
  return spec;
}

fs::path modelFile(const ModelSpec& spec, const fs::path& relative) {
  const fs::path path = spec.folder / relative;
  if (!fs::is_regular_file(path))
    fail(ErrorCode::fileNotFound, "model {}: {} is missing; fetch it or correct model.toml", spec.name,
         path.string());
  const fs::path real = fs::canonical(path), home = fs::canonical(spec.folder);
  if (std::mismatch(home.begin(), home.end(), real.begin(), real.end()).first != home.end())
    fail(ErrorCode::unsafePath, "model {}: {} leads out of the model's folder; copy the file there",
         spec.name, path.string());
  return path;
}

std::string modelDigest(const ModelSpec& spec, const std::string& settings) {
  std::map<std::string, std::string> files = spec.sha256;  // file → the digest it should have, "" = any
  if (!isInt8(spec)) files.erase(spec.int8.string());      // another network
  for (const auto& file : networkFiles(spec)) files.try_emplace(file.string());
  if (!spec.labels.empty()) files.try_emplace(spec.labels.string());
  const Preprocessing& how = spec.preprocessing;
  std::string all =
      fmt::format("{}x{} {} {} {} {} {} {} {} {}\n{}", how.width, how.height, static_cast<int>(how.region),
                  how.crop, static_cast<int>(how.resize), static_cast<int>(how.color),
                  fmt::join(how.mean, ","), fmt::join(how.scale, ","), spec.softmax, spec.output, settings);
  if (spec.sigmoid || spec.reduce != ModelSpec::Reduce::none || !spec.unused.empty())
    all += fmt::format("{} {} [{}] \n", spec.sigmoid, static_cast<int>(spec.reduce),
                       fmt::join(spec.unused, ","));
  if (spec.features > 0) all += "shares\n";
  if (!spec.embeddings.empty()) all += fmt::format("logit_scale {}\n", spec.logitScale);
  // Which of the files plays which part: another one of them may be the network tomorrow.
  for (const auto& file : {spec.file, spec.config, spec.labels, spec.embeddings})
    all += fmt::format("\"{}\"\n", file.string());
  for (const auto& [file, expected] : files) {
    const fs::path path = modelFile(spec, file);
    const std::string actual = sha256OfFile(path);
    if (!expected.empty() && actual != expected)
      fail(ErrorCode::corruptFile, "{} has SHA-256 {} where model.toml says {}; fetch it again",
           path.string(), actual, expected);
    all += fmt::format("{} {}\n", file, actual);
  }
  return sha256(all);
}

}  // namespace estancia
