#include "estancia/objects/predict.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <map>
#include <opencv2/core.hpp>
#include <utility>

#include "estancia/core/cores.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/frame_failure.hpp"
#include "estancia/core/log_opinion_pool.hpp"
#include "estancia/core/parallel.hpp"
#include "estancia/core/progress.hpp"

namespace estancia {
namespace {

class Watch {
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

/// What all views of a thing say together.
struct Thing {
  explicit Thing(std::size_t words) : seen(words), shape(words) {}

  LogOpinionPool seen, shape;
  std::size_t views = 0, flat = 0, answered = 0;
  double mass = 0, brightness = 0;  ///< sums
};

std::vector<float> asFloats(const std::vector<double>& values) {
  return {values.begin(), values.end()};
}

std::vector<float> copyOf(DescriptorView row) {
  return {row.begin(), row.end()};
}

bool saysNothing(DescriptorView row) {
  return std::ranges::all_of(row, [](float p) { return p <= 0; });
}

/// Mean gray, 0 … 1.
double brightnessOf(const cv::Mat& bgr) {
  const cv::Scalar mean = cv::mean(bgr);
  return (0.114 * mean[0] + 0.587 * mean[1] + 0.299 * mean[2]) / 255;
}

}  // namespace

struct ObjectPredictor::State {
  ObjectModel model;
  Labeler* labeler;
  PredictOptions options;
  Tracks tracks;
  std::optional<VocabularyMapping> restriction = {};  ///< where there is a labeler
  bool corrects = false;
  std::map<std::size_t, Thing> things;

  std::size_t words() const { return model.study().words.size(); }

  void inEach(std::size_t count, const std::function<void(std::size_t)>& work) const {
    inParallel(count, static_cast<std::size_t>(options.threads > 0 ? options.threads : usableCores()), work);
  }

  /// Asks the labeler about all patches at once, as many as it likes. Which of them have an answer.
  std::vector<char> askLabeler(const std::vector<cv::Mat>& patches, std::vector<PredictedObject>& objects) {
    std::vector<Prepared> prepared(patches.size());
    inEach(patches.size(), [&](std::size_t i) {
      try {
        prepared[i] = labeler->prepare(patches[i]);
      } catch (...) {
        objects[i].problem = frameFailure(fmt::format("object {}", i)).what();
      }
    });
    std::vector<std::size_t> asked;
    std::vector<Prepared> batch;
    DescriptorMatrix answers(labeler->vocabulary().size());
    std::vector<std::size_t> answered;
    for (std::size_t i = 0; i < prepared.size(); ++i) {
      if (objects[i].problem.empty()) asked.push_back(i);
      if (asked.size() == labeler->batchSize() || (i + 1 == prepared.size() && !asked.empty())) {
        for (const std::size_t a : asked) batch.push_back(std::move(prepared[a]));
        if (interrupted()) throw Interrupted("stopped while things were labeled");
        const auto results = labeler->inferBatch(batch);
        for (std::size_t k = 0; k < asked.size(); ++k) {
          objects[asked[k]].problem = results[k].problem;
          if (!results[k].problem.empty()) continue;
          answers.append(results[k].descriptor);
          answered.push_back(asked[k]);
        }
        asked.clear();
        batch.clear();
      }
    }
    std::vector<char> answersOf(patches.size());
    for (const std::size_t a : answered) answersOf[a] = 1;
    ClassProbabilities shares = restriction->apply(answers);
    if (corrects) shares = corrected(shares, model.prior());
    for (std::size_t k = 0; k < answered.size(); ++k) {
      PredictedObject& object = objects[answered[k]];
      object.mass = shares.mass[k];
      if (!saysNothing(shares.shares.row(k))) object.seen = copyOf(shares.shares.row(k));
    }
    return answersOf;
  }

  /// The shapes of all clusters, and of which they are; what cannot be described is left out.
  Features describe(const ClusteredFrame& frame, std::vector<std::size_t>& described,
                    std::vector<PredictedObject>& objects) const {
    std::vector<std::vector<float>> rows(objects.size());
    ShapeOptions shape = model.shape();
    shape.threads = 1;
    inEach(objects.size(), [&](std::size_t i) {
      try {
        rows[i] = describeShape(cloudOf(frame, i), shape);
      } catch (...) {
        const Error failure = frameFailure(fmt::format("object {}", i));
        if (objects[i].problem.empty()) objects[i].problem = failure.what();
      }
    });
    Features features{shapeParts(shape), {}, DescriptorMatrix(0)};
    std::size_t columns = 0;
    for (const DescriptorPart& part : features.parts) columns += part.size();
    features.values = DescriptorMatrix(columns);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (rows[i].empty()) continue;
      features.values.append(rows[i]);
      features.frames.emplace_back();
      described.push_back(i);
    }
    return features;
  }

  FusedAnswer believed(const PredictedObject& object, bool flat, double brightness, bool answered) {
    Thing& thing = things.try_emplace(object.thing, words()).first->second;
    ++thing.views;
    thing.flat += flat ? 1 : 0;
    thing.answered += answered ? 1 : 0;
    thing.mass += object.mass;
    thing.brightness += brightness;
    if (!object.seen.empty()) thing.seen.add(object.seen);
    if (!object.shape.empty()) thing.shape.add(object.shape);
    auto seen = asFloats(thing.seen.pooled());
    const auto shape = asFloats(thing.shape.pooled());
    if (thing.answered > 0) seen.resize(words(), 0);  // it may have said nothing of the words
    const auto views = static_cast<double>(thing.views);
    return fuseAnswers(
        model, {.seen = seen,
                .mass = static_cast<float>(thing.mass /
                                           static_cast<double>(std::max<std::size_t>(thing.answered, 1))),
                .brightness = thing.brightness / views,
                .shape = shape,
                .flat = 2 * thing.flat > thing.views});
  }

  /// A sequence may have no end; what will not be seen again is not kept.
  void forgetTheLost() {
    const auto followed = tracks.followed();
    std::erase_if(things,
                  [&](const auto& thing) { return !std::ranges::binary_search(followed, thing.first); });
  }
};

ObjectPredictor::ObjectPredictor(const ObjectModel& model, Labeler* labeler, const PredictOptions& options)
    : state_(new State{model, labeler, options, Tracks(options.tracks), {}, false, {}}) {
  if (labeler == nullptr) return;
  if (labeler->discovers())
    throw Error(
        "this labeler discovers its words on the way, so that its answers cannot be told in those of the "
        "study "
        "while a sequence runs; collect and label samples with it instead");
  state_->restriction.emplace(model.study(), labeler->vocabulary());
  state_->corrects = !model.prior().empty() && model.labeler() == labeler->identity();
}

ObjectPredictor::~ObjectPredictor() = default;

bool ObjectPredictor::corrects() const {
  return state_->corrects;
}

std::vector<PredictedObject> ObjectPredictor::predict(const ClusteredFrame& frame,
                                                      const std::optional<Pose>& pose,
                                                      PredictSeconds* seconds) {
  State& s = *state_;
  const auto& clusters = frame.clusters.clusters;
  const auto numbers = s.tracks.follow(frame.clusters, frame.camera, pose);
  std::vector<PredictedObject> objects(clusters.size());
  PredictSeconds took;
  Watch watch;

  std::vector<double> brightness(clusters.size());
  std::vector<cv::Mat> patches(clusters.size());
  s.inEach(clusters.size(), [&](std::size_t i) {
    objects[i].thing = numbers[i];
    objects[i].box = boxOf(frame, i);
    brightness[i] = brightnessOf(frame.image(objects[i].box));
    if (s.labeler != nullptr) patches[i] = cropObject(frame, i, s.options.patches);
  });
  took.patches = watch.lap();
  std::vector<char> answered(clusters.size());
  if (s.labeler != nullptr && !clusters.empty()) answered = s.askLabeler(patches, objects);
  took.labeler = watch.lap();
  std::vector<std::size_t> described;
  const Features features = s.describe(frame, described, objects);
  took.shapes = watch.lap();
  if (!described.empty()) {
    const DescriptorMatrix said = s.model.predict(features, s.options.threads);
    for (std::size_t k = 0; k < described.size(); ++k) objects[described[k]].shape = copyOf(said.row(k));
  }
  for (std::size_t i = 0; i < objects.size(); ++i) {
    objects[i].belief = s.believed(objects[i], clusters[i].flat, brightness[i], answered[i] != 0);
    objects[i].views = s.things.at(objects[i].thing).views;
  }
  s.forgetTheLost();
  took.classifier = watch.lap();
  if (seconds != nullptr) *seconds = took;
  return objects;
}

}  // namespace estancia
