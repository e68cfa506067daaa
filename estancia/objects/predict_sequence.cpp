// SPDX-License-Identifier: Apache-2.0
#include "estancia/objects/predict_sequence.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <string_view>

#include "estancia/core/fail.hpp"
#include "estancia/core/frame_failure.hpp"
#include "estancia/core/progress.hpp"

namespace estancia {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view sourceNames[] = {"none", "image", "shape", "both"};  // by FusedAnswer::Source

Json answerJson(const std::vector<float>& probabilities, const std::vector<std::string>& classes) {
  if (probabilities.empty()) return nullptr;
  const auto best = static_cast<std::size_t>(std::ranges::max_element(probabilities) - probabilities.begin());
  Json all;
  for (std::size_t c = 0; c < classes.size(); ++c) all[classes[c]] = probabilities[c];
  return {{"class", classes[best]}, {"probability", probabilities[best]}, {"classes", all}};
}

Json objectJson(const PredictedObject& object, const Cluster& cluster,
                const std::vector<std::string>& classes) {
  const FusedAnswer& answer = object.answer;
  Json json{{"object", object.instance},
            {"views", object.views},
            {"box", {object.box.x, object.box.y, object.box.width, object.box.height}},
            {"center", {cluster.center.x, cluster.center.y, cluster.center.z}},
            {"flat", cluster.flat},
            {"at_border", cluster.atBorder},
            {"image", answerJson(object.image, classes)},
            {"coverage", object.coverage},
            {"shape", answerJson(object.shape, classes)},
            {"answer",
             {{"class",
               answer.classIndex < 0 ? Json() : Json(classes[static_cast<std::size_t>(answer.classIndex)])},
              {"probability", answer.probability},
              {"source", sourceNames[static_cast<std::size_t>(answer.source)]},
              {"why", answer.why}}}};
  if (!object.problem.empty()) json["problem"] = object.problem;
  return json;
}

}  // namespace

OptionGroup declare(PredictSequenceOptions& options) {
  OptionGroup group = declare(options.objects);
  group.add("first", &options.first, "First frame.").range(0);
  group.add("every", &options.every, "Use every N-th frame.").range(1);
  group.add("max-frames", &options.maxFrames, "Number of frames; 0: all.").range(0);
  group.add("strict", &options.strict, "Fail at a frame that cannot be read instead of skipping it.");
  return group;
}

std::size_t predictSequence(const Sequence& sequence, ObjectPredictor& predictor,
                            const PredictSequenceOptions& options,
                            const std::function<void(const PredictedFrame&)>& use,
                            const std::function<void(const std::string&)>& skipped) {
  validate(options);
  requireClusterable(sequence);
  if (options.first >= sequence.size())
    fail(ErrorCode::invalidOption, "the first frame is {}, but {} has {}; give a smaller number",
         options.first, sequence.name(), sequence.size());
  std::size_t count = 0;
  for (std::size_t i = options.first;
       i < sequence.size() && (options.maxFrames == 0 || count < options.maxFrames) && !interrupted();
       i += std::min(options.every, sequence.size())) {
    const Frame& about = sequence.frame(i);
    PredictedFrame frame;
    frame.name = about.name;
    try {
      const ImageAndDepth read = readImageAndDepth(sequence, i);
      const auto begin = std::chrono::steady_clock::now();
      frame.frame = clusteredFrame(read.image, read.depth, *sequence.intrinsics(), options.objects.clusters);
      frame.clusterSeconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    } catch (...) {
      const Error failure = frameFailure(about.name);
      if (options.strict) throw failure;
      if (skipped) skipped(fmt::format("{}: {}", about.name, failure.what()));
      continue;
    }
    try {
      frame.objects = predictor.predict(frame.frame, about.pose, &frame.seconds);
    } catch (const Interrupted&) {
      break;
    }
    ++count;
    use(frame);
  }
  if (count == 0 && !interrupted())
    fail(ErrorCode::fileUnreadable, "{}: no frame can be read with its depth", sequence.name());
  return count;
}

Json toJson(const PredictedFrame& frame, const std::vector<std::string>& classes) {
  Json objects = Json::array();
  for (std::size_t i = 0; i < frame.objects.size(); ++i)
    objects.push_back(objectJson(frame.objects[i], frame.frame.clusters.clusters[i], classes));
  return {{"frame", frame.name},
          {"objects", objects},
          {"seconds",
           {{"clusters", frame.clusterSeconds},
            {"images", frame.seconds.crops},
            {"labeler", frame.seconds.labeler},
            {"shapes", frame.seconds.shapes},
            {"classifier", frame.seconds.classifier}}}};
}

}  // namespace estancia
