// SPDX-License-Identifier: Apache-2.0
#include "estancia/label/engines.hpp"

#include "estancia/core/fail.hpp"
#include "estancia/core/frame_failure.hpp"
#include "estancia/label/model_files.hpp"
#include "estancia/label/onnxruntime_library.hpp"

#ifdef ESTANCIA_ONNXRUNTIME_LIBRARY  // cmake/EstanciaOnnxruntime.cmake

#define ORT_API_MANUAL_INIT  // the library is opened when it is first needed
#include <fmt/format.h>
#include <onnxruntime_cxx_api.h>

#include <algorithm>
#include <chrono>
#include <limits>
#include <regex>
#include <span>
#include <string_view>
#include <type_traits>

#include "estancia/core/cores.hpp"
#include "estancia/core/parallel.hpp"
#include "estancia/label/network_labeler.hpp"

namespace estancia {
namespace {

/// The one environment of the process; never destroyed, since labelers may outlive what is static here.
Ort::Env& environment() {
  static Ort::Env& env = [&]() -> Ort::Env& {
    Ort::InitApi(onnxruntime::library().api);
    // Complaints to stderr say nothing that its exceptions do not.
    const auto silent = [](void*, OrtLoggingLevel, const char*, const char*, const char*, const char*) {};
    return *new Ort::Env(ORT_LOGGING_LEVEL_FATAL, "estancia", silent, nullptr);
  }();
  return env;
}

/// What an exception of ONNX Runtime says, in one line; the operator that it does not know by its name.
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

/// One network with its threads.
class Session {
 public:
  Session(const ModelSpec& spec, const std::string& onnx, int threads) {
    Ort::Env& env = environment();
    Ort::SessionOptions options;
    options.SetIntraOpNumThreads(threads);
    options.SetInterOpNumThreads(1);
    options.SetGraphOptimizationLevel(ORT_ENABLE_ALL);
    // Threads that spin while they wait take the cores from whoever decodes the next images.
    options.AddConfigEntry("session.intra_op.allow_spinning", "0");
    try {
      session_ = Ort::Session(env, onnx.data(), onnx.size(), options);
      const Ort::AllocatorWithDefaultOptions allocator;
      if (session_.GetInputCount() != 1)
        fail(ErrorCode::unsupportedFile, "model {} takes {} inputs; only networks of one image can label",
             spec.name, session_.GetInputCount());
      input_ = session_.GetInputNameAllocated(0, allocator).get();
      for (std::size_t i = 0; i < session_.GetOutputCount(); ++i)
        outputs_.emplace_back(session_.GetOutputNameAllocated(i, allocator).get());
    } catch (const Ort::Exception& e) {
      fail(ErrorCode::unsupportedFile, "cannot open the network {}: {}", (spec.folder / spec.file).string(),
           reasonOf(e));
    }
  }

  const std::vector<std::string>& outputs() const { return outputs_; }

  /// The values of one output for the image, 1×3×H×W. Safe to call from several threads. Throws
  /// Ort::Exception.
  Ort::Value run(const cv::Mat& image, const std::string& output) {
    std::array<std::int64_t, 4> shape{};
    std::copy_n(image.size.p, 4, shape.begin());
    const auto memory = Ort::MemoryInfo::CreateCpu(OrtDeviceAllocator, OrtMemTypeCPU);
    const auto input = Ort::Value::CreateTensor<float>(memory, const_cast<float*>(image.ptr<float>()),
                                                       image.total(), shape.data(), shape.size());
    const char* const inputName = input_.c_str();
    const char* const outputName = output.c_str();
    auto results = session_.Run(Ort::RunOptions(), &inputName, &input, 1, &outputName, 1);
    return std::move(results.front());
  }

 private:
  Ort::Session session_{nullptr};
  std::string input_;
  std::vector<std::string> outputs_;
};

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
    if (!alone_ && threads_ > 1) alone_ = std::make_unique<Session>(spec(), readAgain(), 1);
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
        together_(spec, onnx, threads_),
        output_(chooseOutput(together_.outputs())) {
    tryOut();
    if (threads_ == 1) return;
    const double took = millisecondsAnImage();
    if (threads == 0 && took < 1) {
      threads_ = 1;
      together_ = Session(spec, onnx, threads_);
    } else {
      // So many images that starting the threads, some 30 µs, costs little; few of a slow network, since who
      // waits for the first must wait for all.
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
      const Ort::Value result = session.run(image, output_);
      if (!result.IsTensor() ||
          result.GetTensorTypeAndShapeInfo().GetElementType() != ONNX_TENSOR_ELEMENT_DATA_TYPE_FLOAT)
        fail(ErrorCode::unsupportedFile, "model {} gives no real numbers", spec().name);
      return use(std::span<const float>(result.GetTensorData<float>(),
                                        result.GetTensorTypeAndShapeInfo().GetElementCount()));
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

}  // namespace estancia

#else

namespace estancia {

std::string onnxruntimeVersion() {
  return "no onnxruntime";
}

std::unique_ptr<Labeler> openWithOnnxruntime(const ModelSpec&, int) {
  throw Error(ErrorCode::missingDependency, onnxruntime::library().problem);
}

}  // namespace estancia

#endif
