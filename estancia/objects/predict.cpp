// SPDX-License-Identifier: Apache-2.0
#include "estancia/objects/predict.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <opencv2/core.hpp>
#include <utility>

#include "estancia/core/cores.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/frame_failure.hpp"
#include "estancia/core/log_opinion_pool.hpp"
#include "estancia/core/parallel.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/label/label_stream.hpp"
#include "estancia/objects/class_probabilities.hpp"
#include "estancia/objects/clustered_frame.hpp"
#include "estancia/objects/late_fusion.hpp"
#include "estancia/objects/shape.hpp"
#include "estancia/objects/tracks.hpp"

namespace estancia {
namespace {

class StopWatch {
 public:
  /// Seconds since the last call.
  double lap() {
    const auto before = std::exchange(since_, Clock::now());
    return std::chrono::duration<double>(since_ - before).count();
  }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point since_ = Clock::now();
};

/// The fused answer of all views of an object.
struct FusedViews {
  explicit FusedViews(std::size_t classes) : image(classes), shape(classes) {}

  LogOpinionPool image, shape;
  std::size_t views = 0, flat = 0, labeled = 0;
  double coverage = 0, brightness = 0;  // sums
};

/// One object of the current frame on its way.
struct Candidate {
  PredictedObject object;
  cv::Mat crop;
  bool flat = false, labeled = false;
  double brightness = 0;
  std::vector<float> descriptor;  // descriptor of its shape
};

/// The crops of a frame for the label stream.
class CandidateCrops final : public Sequence {
 public:
  explicit CandidateCrops(const std::vector<Candidate>& candidates) : candidates_(candidates) {}
  std::string name() const override { return "crops"; }
  std::size_t size() const override { return candidates_.size(); }
  const Frame& frame(std::size_t) const override { return frame_; }
  cv::Mat image(std::size_t i) const override { return candidates_[i].crop; }

 private:
  const std::vector<Candidate>& candidates_;
  Frame frame_;
};

std::vector<float> floatsOf(const auto& values) {
  return {values.begin(), values.end()};
}

/// Mean gray, 0 … 1.
double brightnessOf(const cv::Mat& bgr) {
  const cv::Scalar mean = cv::mean(bgr);
  return (0.114 * mean[0] + 0.587 * mean[1] + 0.299 * mean[2]) / 255;
}

}  // namespace

OptionGroup declare(PredictOptions& options) {
  OptionGroup group("prediction", "Classification of the objects of a sequence.");
  group.add("threads", &options.threads, "Threads; 0: one a usable core. Answers do not depend on it.")
      .range(0);
  return group;
}

struct ObjectPredictor::State {
  ObjectModel model;
  Labeler* labeler;
  PredictOptions options;
  Tracks tracks = {};
  std::optional<VocabularyMapping> mapping = {};  // if there is a labeler
  bool correctsPrior = false;
  std::map<std::size_t, FusedViews> objects = {};

  std::size_t classes() const { return model.targets().classes.size(); }
  std::size_t threads() const {
    return static_cast<std::size_t>(options.threads > 0 ? options.threads : usableCores());
  }

  std::vector<Candidate> crop(const ClusteredFrame& frame, const std::vector<std::size_t>& instances) const {
    std::vector<Candidate> candidates(instances.size());
    inParallel(instances.size(), threads(), [&](std::size_t i) {
      Candidate& candidate = candidates[i];
      candidate.object.instance = instances[i];
      candidate.object.box = boxOf(frame, i);
      candidate.flat = frame.clusters.clusters[i].flat;
      candidate.brightness = brightnessOf(frame.image(candidate.object.box));
      if (labeler != nullptr) candidate.crop = cropObject(frame, i, options.crops);
    });
    return candidates;
  }

  /// Fills in `image`, `coverage` and `problem`.
  void label(std::vector<Candidate>& candidates) {
    if (labeler == nullptr || candidates.empty()) return;
    const CandidateCrops crops(candidates);
    LabelStream stream(crops, *labeler, {.ahead = candidates.size(), .readers = threads()});
    DescriptorMatrix answers(labeler->vocabulary().size());
    std::vector<std::size_t> answered;
    while (auto frame = stream.next()) {
      if (interrupted()) throw Interrupted("stopped while objects were labeled");
      Candidate& candidate = candidates[frame->index];
      candidate.object.problem = frame->problem;
      candidate.labeled = frame->labeled();
      if (!candidate.labeled) continue;
      answers.append(frame->descriptor);
      answered.push_back(frame->index);
    }
    ClassProbabilities p = mapping->apply(answers);
    if (correctsPrior) p = corrected(p, model.prior());
    for (std::size_t k = 0; k < answered.size(); ++k) {
      PredictedObject& object = candidates[answered[k]].object;
      object.coverage = p.coverage[k];
      const DescriptorView row = p.probabilities.row(k);
      if (std::ranges::any_of(row, [](float share) { return share > 0; })) object.image = floatsOf(row);
    }
  }

  /// Fills in `descriptor`, or `problem`.
  void describe(const ClusteredFrame& frame, std::vector<Candidate>& candidates) const {
    ShapeOptions shape = model.shape();
    shape.threads = 1;
    inParallel(candidates.size(), threads(), [&](std::size_t i) {
      try {
        candidates[i].descriptor = describeShape(cloudOf(frame, i), shape);
      } catch (...) {
        const Error failure = frameFailure(fmt::format("object {}", i));
        if (candidates[i].object.problem.empty()) candidates[i].object.problem = failure.what();
      }
    });
  }

  /// Fills in `shape`.
  void classify(std::vector<Candidate>& candidates) const {
    Features features = noShapes(model.shape());
    std::vector<std::size_t> described;
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      if (candidates[i].descriptor.empty()) continue;
      features.values.append(candidates[i].descriptor);
      features.frames.emplace_back();
      described.push_back(i);
    }
    if (described.empty()) return;
    const DescriptorMatrix p = model.predict(features, options.threads);
    for (std::size_t k = 0; k < described.size(); ++k)
      candidates[described[k]].object.shape = floatsOf(p.row(k));
  }

  /// Fills in `answer` and `views`.
  void fuse(Candidate& candidate) {
    PredictedObject& object = candidate.object;
    FusedViews& all = objects.try_emplace(object.instance, classes()).first->second;
    ++all.views;
    all.flat += candidate.flat ? 1 : 0;
    all.labeled += candidate.labeled ? 1 : 0;
    all.coverage += object.coverage;
    all.brightness += candidate.brightness;
    if (!object.image.empty()) all.image.add(object.image);
    if (!object.shape.empty()) all.shape.add(object.shape);
    auto image = floatsOf(all.image.pooled());
    const auto shape = floatsOf(all.shape.pooled());
    if (all.labeled > 0) image.resize(classes(), 0);  // the labeler may have given none of the classes
    const auto labeled = static_cast<double>(std::max<std::size_t>(all.labeled, 1));
    object.views = all.views;
    object.answer = fuseAnswers(model, {.image = image,
                                        .coverage = static_cast<float>(all.coverage / labeled),
                                        .brightness = all.brightness / static_cast<double>(all.views),
                                        .shape = shape,
                                        .flat = 2 * all.flat > all.views});
  }

  /// A sequence may have no end: forgets objects that are no longer tracked.
  void forgetLost() {
    const auto tracked = tracks.tracked();
    std::erase_if(objects,
                  [&](const auto& object) { return !std::ranges::binary_search(tracked, object.first); });
  }
};

ObjectPredictor::ObjectPredictor(const ObjectModel& model, Labeler* labeler, const PredictOptions& options)
    : state_(new State{.model = model, .labeler = labeler, .options = options}) {
  validate(options);
  if (labeler == nullptr) return;
  if (labeler->discovers())
    throw Error(ErrorCode::invalidInput,
                "this labeler discovers its labels on the way, so that they cannot be mapped to the target "
                "classes; collect and label samples with it instead");
  state_->mapping.emplace(model.targets(), labeler->vocabulary());
  state_->correctsPrior = !model.prior().empty() && model.labeler() == labeler->identity();
}

ObjectPredictor::~ObjectPredictor() = default;

bool ObjectPredictor::correctsPrior() const {
  return state_->correctsPrior;
}

std::vector<PredictedObject> ObjectPredictor::predict(const cv::Mat& image, const cv::Mat& depth,
                                                      const CameraIntrinsics& camera,
                                                      const std::optional<Pose>& pose) {
  return predict(clusteredFrame(image, depth, camera, state_->options.clusters), pose);
}

std::vector<PredictedObject> ObjectPredictor::predict(const ClusteredFrame& frame,
                                                      const std::optional<Pose>& pose,
                                                      PredictSeconds* seconds) {
  State& s = *state_;
  PredictSeconds took;
  StopWatch watch;
  std::vector<Candidate> candidates = s.crop(frame, s.tracks.follow(frame.clusters, frame.camera, pose));
  took.crops = watch.lap();
  s.label(candidates);
  took.labeler = watch.lap();
  s.describe(frame, candidates);
  took.shapes = watch.lap();
  s.classify(candidates);
  std::vector<PredictedObject> objects;
  for (Candidate& candidate : candidates) {
    s.fuse(candidate);
    objects.push_back(std::move(candidate.object));
  }
  s.forgetLost();
  took.classifier = watch.lap();
  if (seconds != nullptr) *seconds = took;
  return objects;
}

}  // namespace estancia
