// SPDX-License-Identifier: Apache-2.0
#include "convert/quantize_model.hpp"

#include <fmt/format.h>
#include <google/protobuf/stubs/logging.h>

#include <regex>

#include "convert/to_onnx.hpp"
#include "estancia/core/config.hpp"
#include "estancia/core/digest.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/output_file.hpp"
#include "estancia/files/files.hpp"
#include "estancia/labelers/model.hpp"
#include "estancia/labelers/model_files.hpp"

namespace estancia::convert {
namespace fs = std::filesystem;
namespace {

/// Removes the files it was given unless they are kept.
class Unfinished {
 public:
  explicit Unfinished(fs::path file) : file_(std::move(file)) {}
  ~Unfinished() {
    std::error_code ignored;
    fs::remove(file_, ignored);
  }
  Unfinished(const Unfinished&) = delete;
  Unfinished& operator=(const Unfinished&) = delete;
  const fs::path& path() const { return file_; }

 private:
  fs::path file_;
};

void requireQuantizable(const ModelSpec& spec, const QuantizeOptions& options) {
  if (!isNetworkType(spec.type) || !isOnnx(spec))
    throw Error(ErrorCode::unsupportedFile,
                fmt::format("model {} is no ONNX network; only these can be quantized", spec.name));
  if (!spec.int8.empty() && !options.overwrite)
    throw Error(ErrorCode::fileExists,
                fmt::format("model {} has a network of 8 bits; replace it with --overwrite", spec.name));
  if (!options.ranges.empty() && fs::exists(options.ranges) && !options.overwrite)
    throw Error(ErrorCode::fileExists,
                fmt::format("{} exists; replace it with --overwrite", options.ranges.string()));
  modelDigest(spec);  // fails if the files do not match model.toml
}

/// Throws Error unless ONNX Runtime opens the network and labels an image with it.
void tryOut(ModelSpec spec, const fs::path& file, int threads) try {
  spec.file = file;
  spec.int8.clear();
  spec.sha256.clear();
  LabelerOptions options;
  options.engine = "onnxruntime";
  options.threads = threads;
  loadModel(spec, options);
} catch (const Error& e) {
  throw Error(e.code(), fmt::format("model {} does not work in 8 bits, and was left as it is: {}", spec.name,
                                    e.what()));
}

std::vector<std::string> linesOf(const std::string& text) {
  std::vector<std::string> lines;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    lines.push_back(text.substr(at, end - at));
    at = end + 1;
  }
  return lines;
}

}  // namespace

std::string withInt8(const std::string& toml, const std::string& file, const std::string& digest,
                     const fs::path& name) {
  const std::string ours = fmt::format("int8 = \"{}\"", file),
                    sum = fmt::format("\"{}\" = \"{}\"", file, digest);
  const std::regex fileLine(R"(^\s*file\s*=.*)"), int8Line(R"(^\s*int8\s*=.*)"), tableLine(R"(^\s*\[.*)"),
      digestsLine(R"(^\s*\[\s*sha256\s*\].*)");
  std::string text;
  bool isTop = true, isNamed = false, hasDigest = false;
  for (const std::string& line : linesOf(toml)) {
    if (std::regex_match(line, tableLine)) isTop = false;
    if (isTop && std::regex_match(line, int8Line)) continue;
    if (line.find('"' + file + '"') != std::string::npos && !isTop) continue;  // the old one's digest
    text += line + '\n';
    if (isTop && !isNamed && std::regex_match(line, fileLine)) {
      text += ours + '\n';
      isNamed = true;
    }
    if (std::regex_match(line, digestsLine)) {
      text += sum + '\n';
      hasDigest = true;
    }
  }
  if (!hasDigest) text += "\n[sha256]\n" + sum + '\n';
  const ConfigFile changed(name, text);
  if (changed.table()["int8"].value_or(std::string()) != file ||
      changed.table()["sha256"][file].value_or(std::string()) != digest)
    throw Error(ErrorCode::malformedFile,
                fmt::format("{}: put `{}` below a line `file = …`, and `{}` into [sha256]", name.string(),
                            ours, sum));
  return text;
}

QuantizedModel quantizeModel(const fs::path& folder, const Sequence& images, const QuantizeOptions& options,
                             Progress& progress) {
  const google::protobuf::LogSilencer quiet;
  const ModelSpec spec = readModelSpec(folder);
  requireQuantizable(spec, options);
  ModelSpec whole = spec;
  whole.output.clear();  // an inner value is none of the network's own outputs
  const std::string onnx = readOnnx(whole);
  MeasuredRanges measured = measureRanges(spec, onnx, images, options.calibration, options.threads, progress);
  QuantizedModel result;
  const std::string name = (spec.file.parent_path() / spec.file.stem()).string() + "-int8.onnx";
  result.file = folder / name;
  result.values = measured.ranges.size();
  result.images = measured.images;
  result.problems = std::move(measured.problems);
  const Unfinished fresh(folder / (name.substr(0, name.size() - 5) + ".new.onnx"));
  writeQuantized(onnx, (folder / spec.file).string(), measured.ranges, fresh.path());
  tryOut(spec, fresh.path().lexically_relative(folder), options.threads);
  result.sha256 = sha256OfFile(fresh.path());
  const std::string toml =
      withInt8(io::readBytes(folder / "model.toml", 1 << 20), name, result.sha256, folder / "model.toml");
  if (!options.ranges.empty())
    writeWhole(options.ranges,
               rangesText(measured.ranges, fmt::format("Ranges of the values of {}, measured on {} "
                                                       "images: low, high, value",
                                                       spec.name, result.images)));
  fs::rename(fresh.path(), result.file);
  writeWhole(folder / "model.toml", toml);
  return result;
}

}  // namespace estancia::convert
