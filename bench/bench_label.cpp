// How fast images become words: engine beside engine, 8 bits beside real numbers, the whole labeling beside
// the network alone, and whether two models or engines agree.
//   bench_label engines SEQ MODEL…      ONNX Runtime beside OpenCV at 1 and 2 threads
//   bench_label precisions SEQ MODEL…   8 bits beside real numbers at 1 and 2 threads
//   bench_label reduced SEQ MODEL…      the labels of reduced images beside those of whole ones
//   bench_label stream SEQ MODEL…       decode, prepare, infer (of an ensemble: the sum) beside inference
//   bench_label compare SEQ A B
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <functional>
#include <numeric>

#include "estancia/core/error.hpp"
#include "estancia/label/label_stream.hpp"
#include "estancia/labelers/model.hpp"
#include "estancia/readers/open_sequence.hpp"

namespace {

using namespace estancia;

struct Arguments {
  std::string sequence;
  std::vector<std::string> models;
  LabelerOptions options;
  std::size_t frames = 500;
  int rounds = 5;
};

double secondsOf(const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                   values.end());
  return values[values.size() / 2];
}

std::vector<Labeler*> partsOf(Labeler& labeler) {
  auto parts = labeler.members();
  return parts.empty() ? std::vector<Labeler*>{&labeler} : parts;
}

/// Evenly spread over the sequence.
std::vector<cv::Mat> images(const Sequence& sequence, std::size_t count) {
  std::vector<cv::Mat> result;
  count = std::min(count, sequence.size());
  for (std::size_t i = 0; i < count; ++i) result.push_back(sequence.image(i * sequence.size() / count));
  return result;
}

std::vector<Prepared> prepare(const Labeler& labeler, const std::vector<cv::Mat>& images) {
  std::vector<Prepared> prepared;
  for (const auto& image : images) prepared.push_back(labeler.prepare(image));
  return prepared;
}

struct Agreement {
  double difference = 0;     ///< largest of any probability
  double hellinger = 0;      ///< sum of the images' distances
  std::size_t sameBest = 0;  ///< images with the same best word
  void add(const LexicalDescriptor& a, const LexicalDescriptor& b) {
    if (a.size() != b.size()) throw Error(ErrorCode::invalidInput, "the two models have different words");
    double overlap = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
      difference = std::max(difference, std::abs(static_cast<double>(a[i]) - b[i]));
      overlap += std::sqrt(static_cast<double>(a[i]) * b[i]);
    }
    hellinger += std::sqrt(std::max(0.0, 1 - overlap));
    sameBest +=
        std::max_element(a.begin(), a.end()) - a.begin() == std::max_element(b.begin(), b.end()) - b.begin();
  }
};

/// Seconds to infer `frames` prepared images in the batches that the labeler likes best.
double inferAll(Labeler& labeler, const std::vector<Prepared>& prepared, std::size_t frames) {
  return secondsOf([&] {
    for (std::size_t done = 0; done < frames;) {
      const std::size_t start = done % prepared.size();
      const std::size_t count = std::min({labeler.batchSize(), prepared.size() - start, frames - done});
      labeler.inferBatch(std::span(prepared).subspan(start, count));
      done += count;
    }
  });
}

void compareEngines(const Arguments& arguments) {
  const auto sequence = openSequence(arguments.sequence);
  for (const auto& model : arguments.models)
    for (const int threads : {1, 2}) {
      const auto opencv = loadModel(model, {"opencv", threads});
      const auto onnxruntime = loadModel(model, {"onnxruntime", threads});
      const auto prepared = prepare(*opencv, images(*sequence, arguments.frames));
      std::vector<double> slow, fast, batched, ratios, batchRatios;
      Agreement agreement;
      onnxruntime->inferBatch(std::span(prepared).first(2));  // warm up
      for (int round = 0; round < arguments.rounds; ++round) {
        std::vector<LexicalDescriptor> a, b;
        slow.push_back(secondsOf([&] {
          for (const auto& image : prepared) a.push_back(opencv->infer(image));
        }));
        fast.push_back(secondsOf([&] {
          for (const auto& image : prepared) b.push_back(onnxruntime->infer(image));
        }));
        batched.push_back(inferAll(*onnxruntime, prepared, prepared.size()));
        ratios.push_back(slow.back() / fast.back());
        batchRatios.push_back(slow.back() / batched.back());
        if (round == 0)
          for (std::size_t i = 0; i < a.size(); ++i) agreement.add(a[i], b[i]);
      }
      const double ms = 1000 / static_cast<double>(prepared.size());
      fmt::print(
          "{} with {} threads: OpenCV {:.2f} ms, ONNX Runtime {:.2f} ms, {:.2f} times as fast; in batches "
          "{:.2f} ms, "
          "{:.2f} times; largest difference {:.1e}, same best word for {} of {}\n",
          model, threads, ms * median(slow), ms * median(fast), median(ratios), ms * median(batched),
          median(batchRatios), agreement.difference, agreement.sameBest, prepared.size());
      std::fflush(stdout);
    }
}

std::vector<LexicalDescriptor> labelsOf(Labeler& labeler, const std::vector<Prepared>& prepared) {
  std::vector<LexicalDescriptor> labels;
  for (LabelResult& result : labeler.inferBatch(prepared)) labels.push_back(std::move(result.descriptor));
  return labels;
}

void comparePrecisions(const Arguments& arguments) {
  const auto sequence = openSequence(arguments.sequence);
  for (const auto& model : arguments.models)
    for (const int threads : {1, 2}) {
      LabelerOptions options = arguments.options;
      options.threads = threads;
      const auto real = loadModel(model, options);
      options.precision = Precision::int8;
      const auto bytes = loadModel(model, options);
      const auto prepared = prepare(*real, images(*sequence, arguments.frames));
      Agreement agreement;
      const auto a = labelsOf(*real, prepared), b = labelsOf(*bytes, prepared);  // warms up, too
      for (std::size_t i = 0; i < a.size(); ++i) agreement.add(a[i], b[i]);
      std::vector<double> slow, fast, ratios;
      for (int round = 0; round < arguments.rounds; ++round) {
        slow.push_back(inferAll(*real, prepared, prepared.size()));
        fast.push_back(inferAll(*bytes, prepared, prepared.size()));
        ratios.push_back(slow.back() / fast.back());
      }
      const auto count = static_cast<double>(prepared.size());
      fmt::print(
          "{} with {} threads: float32 {:.1f} /s, int8 {:.1f} /s, {:.2f} times as fast; Hellinger distance "
          "{:.4f}, "
          "same best word for {} of {}\n",
          model, threads, count / median(slow), count / median(fast), median(ratios),
          agreement.hellinger / count, agreement.sameBest, prepared.size());
      std::fflush(stdout);
    }
}

std::vector<LexicalDescriptor> streamed(const Sequence& sequence, const std::string& model,
                                        const LabelerOptions& options, std::size_t frames) {
  const auto labeler = loadModel(model, options);
  LabelStream stream(sequence, *labeler);
  std::vector<LexicalDescriptor> labels;
  while (labels.size() < frames)
    if (auto frame = stream.next())
      labels.push_back(std::move(frame->descriptor));
    else
      break;
  return labels;
}

void compareReduced(const Arguments& arguments) {
  const auto sequence = openSequence(arguments.sequence);
  LabelerOptions reduced = arguments.options;
  reduced.reducedImages = true;
  for (const auto& model : arguments.models) {
    const auto a = streamed(*sequence, model, arguments.options, arguments.frames);
    const auto b = streamed(*sequence, model, reduced, arguments.frames);
    Agreement agreement;
    for (std::size_t i = 0; i < a.size(); ++i) agreement.add(a[i], b[i]);
    fmt::print("{}: Hellinger distance {:.4f}, same best word for {} of {}\n", model,
               agreement.hellinger / static_cast<double>(a.size()), agreement.sameBest, a.size());
  }
}

void compareModels(const Arguments& arguments) {
  if (arguments.models.size() != 2) throw Error(ErrorCode::invalidInput, "compare takes two models");
  const auto sequence = openSequence(arguments.sequence);
  const auto first = loadModel(arguments.models[0], arguments.options);
  const auto second = loadModel(arguments.models[1], arguments.options);
  Agreement agreement;
  const auto looked = images(*sequence, arguments.frames);
  for (const auto& image : looked) agreement.add(first->label(image), second->label(image));
  fmt::print("{} and {}: largest difference {:.1e}, same best word for {} of {}\n", arguments.models[0],
             arguments.models[1], agreement.difference, agreement.sameBest, looked.size());
}

void stream(const Arguments& arguments) {
  const auto sequence = openSequence(arguments.sequence);
  for (const auto& model : arguments.models) {
    const auto labeler = loadModel(model, arguments.options);
    const auto parts = partsOf(*labeler);
    const auto looked = images(*sequence, 64);  // prepared images of all frames would fill the memory
    std::vector<std::vector<Prepared>> prepared;
    for (const Labeler* part : parts) prepared.push_back(prepare(*part, looked));
    const std::size_t frames = std::min(arguments.frames, sequence->size());
    std::vector<double> ratios;
    for (int round = 0; round <= arguments.rounds; ++round) {
      double forward = 0;
      for (std::size_t p = 0; p < parts.size(); ++p) forward += inferAll(*parts[p], prepared[p], frames);
      const double whole = secondsOf([&] {
        LabelStream labels(*sequence, *labeler);
        for (std::size_t i = 0; i < frames; ++i) labels.next();
      });
      if (round == 0) continue;  // warms up
      ratios.push_back(forward / whole);
      const double n = static_cast<double>(frames);
      fmt::print("{}: forward alone {:.1f} /s, whole {:.1f} /s, ratio {:.3f}\n", model, n / forward,
                 n / whole, ratios.back());
      std::fflush(stdout);
    }
    fmt::print("{}: {} frames, median ratio {:.3f}\n", model, frames, median(ratios));
  }
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("How fast images become words", "bench_label");
  app.require_subcommand(1);
  Arguments arguments;
  const auto add = [&](const char* name, const char* what, void (*run)(const Arguments&)) {
    CLI::App* mode = app.add_subcommand(name, what);
    mode->add_option("SEQ", arguments.sequence, "Images")->required();
    mode->add_option("MODEL", arguments.models, "Models")->required();
    mode->add_option("--frames", arguments.frames, "Frames a round")->capture_default_str();
    mode->add_option("--rounds", arguments.rounds, "Rounds; the median counts")->capture_default_str();
    mode->add_option("--engine", arguments.options.engine, "Engine (stream, compare)");
    mode->add_option("--threads", arguments.options.threads, "Threads (stream, compare)");
    mode->add_flag("--reduced-images", arguments.options.reducedImages, "Decode JPEG files smaller (stream)");
    mode->callback([run, &arguments] { run(arguments); });
  };
  add("engines", "ONNX Runtime beside OpenCV", compareEngines);
  add("precisions", "8 bits beside real numbers", comparePrecisions);
  add("reduced", "The labels of reduced images beside those of whole ones", compareReduced);
  add("stream", "Decode, prepare and infer beside inference alone", stream);
  add("compare", "Two models on the same images", compareModels);
  try {
    app.parse(argc, argv);
    return 0;
  } catch (const CLI::ParseError& e) {
    return app.exit(e);
  } catch (const std::exception& e) {
    fmt::print(stderr, "error: {}\n", e.what());
    return 2;
  }
}
