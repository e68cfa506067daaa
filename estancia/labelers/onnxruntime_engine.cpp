// ONNX Runtime: the library, found and opened at run time, and the engine.
// SPDX-License-Identifier: Apache-2.0
#include "estancia/labelers/engines.hpp"

#include "estancia/core/fail.hpp"
#include "estancia/core/frame_failure.hpp"
#include "estancia/labelers/model_files.hpp"

#ifdef ESTANCIA_ONNXRUNTIME_LIBRARY  // cmake/EstanciaOnnxruntime.cmake

#define ORT_API_MANUAL_INIT  // the library is opened when it is first needed
#include <dlfcn.h>
#include <fmt/format.h>
#include <onnxruntime_cxx_api.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <new>
#include <regex>
#include <span>
#include <string_view>
#include <system_error>
#include <type_traits>
#include <vector>

#include "estancia/core/cores.hpp"
#include "estancia/core/parallel.hpp"
#include "estancia/labelers/model.hpp"
#include "estancia/labelers/network_labeler.hpp"

namespace estancia {
namespace fs = std::filesystem;
namespace onnxruntime {
namespace {

constexpr auto fileName = "libonnxruntime.so";

/// Opens one file. It stays open until the process ends, as its threads may.
Library open(const fs::path& file) {
  Library library;
  void* handle = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (handle == nullptr) {
    library.problem = dlerror();
    return library;
  }
  const auto getBase = reinterpret_cast<const OrtApiBase* (*)()>(dlsym(handle, "OrtGetApiBase"));
  if (getBase == nullptr) {
    library.problem = fmt::format("{} is no ONNX Runtime", file.string());
    return library;
  }
  library.version = getBase()->GetVersionString();
  // A version that it does not know makes ONNX Runtime write to stderr; it knows those up to its own.
  int major = 0, minor = 0;
  std::sscanf(library.version.c_str(), "%d.%d", &major, &minor);
  if (major == 1 && minor >= ORT_API_VERSION) library.api = getBase()->GetApi(ORT_API_VERSION);
  if (library.api == nullptr)
    library.problem = fmt::format("{} is ONNX Runtime {}, where 1.{} or a later 1.x is needed", file.string(),
                                  library.version, ORT_API_VERSION);
  return library;
}

std::vector<fs::path> candidates() {
  std::error_code unreadable;  // another user's home: as if it were not there
  if (const char* given = std::getenv("ESTANCIA_ONNXRUNTIME"); given != nullptr && *given != '\0') {
    const fs::path path = given;
    if (!fs::is_directory(path, unreadable)) return {path};
    return {fs::is_directory(path / "lib", unreadable) ? path / "lib" / fileName : path / fileName};
  }
  std::vector<fs::path> files;
  for (const fs::path& file :
       {fs::path(ESTANCIA_ONNXRUNTIME_LIBRARY), modelHome().parent_path() / "onnxruntime/lib" / fileName})
    if (fs::is_regular_file(file, unreadable)) files.push_back(file);
  files.emplace_back("libonnxruntime.so.1");
  files.emplace_back(fileName);
  return files;
}

Library find() {
  std::string problem;
  for (const fs::path& file : candidates()) {
    Library library = open(file);
    if (library.api != nullptr) return library;
    if (problem.empty()) problem = library.problem;
  }
  return {nullptr, "",
          fmt::format("ONNX Runtime cannot be used: {}; run estancia-fetch (script/bootstrap in the source), "
                      "or name the library in ESTANCIA_ONNXRUNTIME",
                      problem)};
}

}  // namespace

const Library& library() {
  static const Library found = find();
  return found;
}

}  // namespace onnxruntime

namespace {

/// The one environment of the process; never destroyed, since labelers may outlive what is static here.
Ort::Env& environment() {
  static Ort::Env& env = [&]() -> Ort::Env& {
    Ort::InitApi(onnxruntime::library().api);
    // Messages on stderr add nothing to its exceptions.
    const auto silent = [](void*, OrtLoggingLevel, const char*, const char*, const char*, const char*) {};
    return *new Ort::Env(ORT_LOGGING_LEVEL_FATAL, "estancia", silent, nullptr);
  }();
  return env;
}

/// Message of an ONNX Runtime exception in one line; an unknown operator is given by name.
std::string reasonOf(const Ort::Exception& e) {
  const std::string text = e.what();
  std::smatch match;
  if (std::regex_search(text, match, std::regex(R"(No Op registered for (\w+))")) ||
      std::regex_search(text, match, std::regex(R"((\w+) is not a registered function/op)")) ||
      std::regex_search(text, match, std::regex(R"(Could not find an implementation for (\w+))")))
    return fmt::format("ONNX Runtime cannot run its operator {}", match[1].str());
  std::string line = text.substr(0, 200);
  std::replace(line.begin(), line.end(), '\n', ' ');
  return line;
}

std::string pathOf(const ModelSpec& spec) {
  return (spec.folder / spec.file).string();
}

/// Whether the quick kernels for bytes add up exactly. On x86-64 only those of AVX VNNI do; on ARM all do,
/// with SDOT or without, and ONNX Runtime chooses by itself.
bool hasByteProducts() {
#if defined(__x86_64__) && defined(__clang__)
  return __builtin_cpu_supports("avx512vnni") != 0;  // Clang 14 does not know the other
#elif defined(__x86_64__)
  return __builtin_cpu_supports("avx512vnni") != 0 || __builtin_cpu_supports("avxvnni") != 0;
#else
  return true;
#endif
}

/// One network with its threads.
class Session {
 public:
  /// `source` names the network in messages.
  Session(const std::string& source, const std::string& onnx, int threads) {
    Ort::Env& env = environment();
    Ort::SessionOptions options;
    options.SetIntraOpNumThreads(threads);
    options.SetInterOpNumThreads(1);
    options.SetGraphOptimizationLevel(ORT_ENABLE_ALL);
    // Threads that spin while they wait would take the cores from the decoding of the next images.
    options.AddConfigEntry("session.intra_op.allow_spinning", "0");
    // 8 bits without VNNI: the exact kernels (slower with it), not the quick ones whose sums saturate.
    if (!hasByteProducts()) options.AddConfigEntry("session.x64quantprecision", "1");
    try {
      session_ = Ort::Session(env, onnx.data(), onnx.size(), options);
      const Ort::AllocatorWithDefaultOptions allocator;
      if (session_.GetInputCount() != 1)
        fail(ErrorCode::unsupportedFile, "{} takes {} inputs; only networks of one image can label", source,
             session_.GetInputCount());
      input_ = session_.GetInputNameAllocated(0, allocator).get();
      for (std::size_t i = 0; i < session_.GetOutputCount(); ++i)
        outputs_.emplace_back(session_.GetOutputNameAllocated(i, allocator).get());
    } catch (const Ort::Exception& e) {
      if (std::string_view(e.what()).find("bad_alloc") != std::string_view::npos) throw std::bad_alloc();
      fail(ErrorCode::unsupportedFile, "cannot open the network {}: {}", source, reasonOf(e));
    }
  }

  const std::vector<std::string>& outputs() const { return outputs_; }

  /// The values of these outputs for the image, 1×3×H×W. Thread-safe. Throws Ort::Exception.
  std::vector<Ort::Value> run(const cv::Mat& image, std::span<const std::string> outputs) {
    std::array<std::int64_t, 4> shape{};
    std::copy_n(image.size.p, 4, shape.begin());
    const auto memory = Ort::MemoryInfo::CreateCpu(OrtDeviceAllocator, OrtMemTypeCPU);
    const auto input = Ort::Value::CreateTensor<float>(memory, const_cast<float*>(image.ptr<float>()),
                                                       image.total(), shape.data(), shape.size());
    const char* const inputName = input_.c_str();
    std::vector<const char*> names;
    for (const std::string& output : outputs) names.push_back(output.c_str());
    return session_.Run(Ort::RunOptions(), &inputName, &input, 1, names.data(), names.size());
  }

 private:
  Ort::Session session_{nullptr};
  std::string input_;
  std::vector<std::string> outputs_;
};

/// The numbers of an output. Throws Error when they are no floats.
std::span<const float> floatsOf(const Ort::Value& value, const std::string& source) {
  if (!value.IsTensor() ||
      value.GetTensorTypeAndShapeInfo().GetElementType() != ONNX_TENSOR_ELEMENT_DATA_TYPE_FLOAT)
    fail(ErrorCode::unsupportedFile, "{} gives no real numbers", source);
  return {value.GetTensorData<float>(), value.GetTensorTypeAndShapeInfo().GetElementCount()};
}

class OnnxruntimeValues final : public NetworkValues {
 public:
  OnnxruntimeValues(const std::string& onnx, std::string source, int threads)
      : source_(std::move(source)), session_(source_, onnx, threads > 0 ? threads : freeCores()) {}

  const std::vector<std::string>& names() const override { return session_.outputs(); }

  void run(const cv::Mat& blob,
           const std::function<void(std::size_t, std::span<const float>)>& use) override {
    if (blob.type() != CV_32F || blob.dims != 4 || !blob.isContinuous())
      fail(ErrorCode::invalidInput, "{} takes an image as preprocess() makes it", source_);
    try {
      const std::vector<Ort::Value> values = session_.run(blob, names());
      for (std::size_t i = 0; i < values.size(); ++i) use(i, floatsOf(values[i], source_));
    } catch (const Ort::Exception& e) {
      fail(ErrorCode::mismatch, "{} does not work on the image: {}", source_, reasonOf(e));
    }
  }

 private:
  std::string source_;
  Session session_;
};

/// ONNX Runtime engine. Invariant: `together_` always runs; `alone_`, with one thread an image, is made with
/// the first batch and reads the network file again, whose hash must still be `onnxHash_`. Life cycle: the
/// constructor measures one image to choose threads and batch size.
class OnnxruntimeEngine final : public NetworkLabeler {
 public:
  OnnxruntimeEngine(const ModelSpec& spec, int threads) : OnnxruntimeEngine(spec, threads, readOnnx(spec)) {}

  LexicalDescriptor infer(const Prepared& prepared) override { return infer(together_, prepared); }

  std::vector<LexicalDescriptor> labelRegions(const cv::Mat& bgr,
                                              std::span<const cv::Rect2d> regions) override {
    return withOutput(together_, prepare(bgr, ""),
                      [&](std::span<const float> output) { return toWordsOfRegions(output, regions); });
  }

  std::vector<LabelResult> inferBatch(std::span<const Prepared> batch) override {
    std::vector<LabelResult> results(batch.size());
    if (!alone_ && threads_ > 1) alone_ = std::make_unique<Session>(pathOf(spec()), readAgain(), 1);
    Session& session = alone_ ? *alone_ : together_;
    inParallel(batch.size(), static_cast<std::size_t>(threads_), [&](std::size_t i) {
      try {
        results[i].descriptor = infer(session, batch[i]);
      } catch (const FrameError& e) {
        results[i].problem = e.what();
      } catch (const Error&) {
        throw;
      } catch (...) {
        results[i].problem = frameFailure(batch[i].frame).what();
      }
    });
    return results;
  }

  std::size_t batchSize() const override { return batchSize_; }

 private:
  OnnxruntimeEngine(const ModelSpec& spec, int threads, const std::string& onnx)
      : NetworkLabeler(spec, onnxruntimeVersion()),
        threads_(threads > 0 ? threads : freeCores()),
        onnxHash_(std::hash<std::string_view>{}(onnx)),
        together_(pathOf(spec), onnx, threads_),
        output_(chooseOutput(together_.outputs())) {
    tryOut();
    if (threads_ == 1) return;
    const double took = millisecondsAnImage();
    if (threads == 0 && took < 1) {
      threads_ = 1;
      together_ = Session(pathOf(spec), onnx, threads_);
    } else {
      // Enough that starting the threads (30 µs) costs little; few where slow: the first comes with the last.
      batchSize_ = static_cast<std::size_t>(threads_ * std::clamp(8 / took, 1.0, 16.0));
    }
  }

  LexicalDescriptor infer(Session& session, const Prepared& prepared) {
    return withOutput(session, prepared, [this](std::span<const float> output) { return toWords(output); });
  }

  template <class Use>
  std::invoke_result_t<Use, std::span<const float>> withOutput(Session& session, const Prepared& prepared,
                                                               const Use& use) {
    const cv::Mat& image = prepared.input;
    const auto& pre = spec().preprocessing;
    if (image.type() != CV_32F || image.dims != 4 || !image.isContinuous() || image.size[2] != pre.height ||
        image.size[3] != pre.width)
      fail(ErrorCode::mismatch, "model {} got an image that another labeler prepared", spec().name);
    try {
      const std::vector<Ort::Value> results = session.run(image, {&output_, 1});
      return use(floatsOf(results.front(), pathOf(spec())));
    } catch (const Ort::Exception& e) {
      failOnInput(reasonOf(e));
    }
  }

  double millisecondsAnImage() {
    const Prepared gray = prepare(cv::Mat(64, 64, CV_8UC3, cv::Scalar::all(128)), "");
    double best = std::numeric_limits<double>::max();
    for (int i = 0; i < 3; ++i) {
      const auto start = std::chrono::steady_clock::now();
      infer(gray);
      const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - start;
      best = std::min(best, took.count());
    }
    return best;
  }

  /// The network once more, for a second session: keeping it would double what it takes of the memory.
  std::string readAgain() const {
    std::string onnx = readOnnx(spec());
    if (std::hash<std::string_view>{}(onnx) != onnxHash_)
      fail(ErrorCode::corruptFile, "{} was changed while it was used; start again",
           modelFile(spec(), spec().file).string());
    return onnx;
  }

  int threads_;
  std::size_t onnxHash_;
  Session together_;                ///< all threads work on one image
  std::unique_ptr<Session> alone_;  ///< each thread works on an image of its own
  std::string output_;
  std::size_t batchSize_ = 1;
};

}  // namespace

std::string onnxruntimeVersion() {
  return "onnxruntime " + onnxruntime::library().version;
}

std::unique_ptr<Labeler> openWithOnnxruntime(const ModelSpec& spec, int threads) {
  const auto& library = onnxruntime::library();
  if (library.api == nullptr) throw Error(ErrorCode::missingDependency, library.problem);
  if (!isOnnx(spec))
    fail(ErrorCode::unsupportedFile, "model {}: ONNX Runtime reads .onnx, not {}; take the engine opencv",
         spec.name, spec.file.string());
  return std::make_unique<OnnxruntimeEngine>(spec, threads);
}

std::unique_ptr<NetworkValues> openNetworkValues(const std::string& onnx, const std::string& source,
                                                 int threads) {
  const auto& library = onnxruntime::library();
  if (library.api == nullptr) throw Error(ErrorCode::missingDependency, library.problem);
  return std::make_unique<OnnxruntimeValues>(onnx, source, threads);
}

}  // namespace estancia

#else

namespace estancia {

const onnxruntime::Library& onnxruntime::library() {
  static const Library none{
      nullptr, "", "this Estancia was built without ONNX Runtime; run script/bootstrap and build it again"};
  return none;
}

std::string onnxruntimeVersion() {
  return "no onnxruntime";
}

std::unique_ptr<Labeler> openWithOnnxruntime(const ModelSpec&, int) {
  throw Error(ErrorCode::missingDependency, onnxruntime::library().problem);
}

std::unique_ptr<NetworkValues> openNetworkValues(const std::string&, const std::string&, int) {
  throw Error(ErrorCode::missingDependency, onnxruntime::library().problem);
}

}  // namespace estancia

#endif
