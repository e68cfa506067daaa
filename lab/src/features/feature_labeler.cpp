// SPDX-License-Identifier: Apache-2.0
#include "features/feature_labeler.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <mutex>
#include <numeric>
#include <opencv2/core.hpp>
#include <utility>

#include "estancia/core/fail.hpp"

namespace estancia::experiments {
namespace {

// version of the numbers: cached ones of another version are computed anew
constexpr int featuresVersion = 1;

using Aggregate = std::vector<float> (*)(const VisualVocabulary&, const cv::Mat&);

std::vector<float> vladInUnitRange(const VisualVocabulary& vocabulary, const cv::Mat& features) {
  std::vector<float> values = vlad(vocabulary, features);
  for (float& value : values) value = std::clamp((1 + value) / 2, 0.0F, 1.0F);
  return values;
}

std::vector<float> wordsShown(const VisualVocabulary& vocabulary, const cv::Mat& features) {
  std::vector<float> shown(vocabulary.idf.size());
  for (const std::size_t word : wordsOf(vocabulary, features)) shown[word] = 1;
  return shown;
}

/// Descriptors that are made of local features and a vocabulary.
struct LocalType {
  const char *name, *explanation;
  LocalFeature feature;
  Aggregate aggregate;

  bool isVlad() const { return aggregate == vladInUnitRange; }
};

constexpr LocalType localTypes[] = {
    {"orb-words", "bag of visual words of ORB, tf-idf", LocalFeature::orb, bagOfWords},
    {"sift-words", "bag of visual words of SIFT, tf-idf", LocalFeature::sift, bagOfWords},
    {"orb-vlad", "ORB aggregated by VLAD", LocalFeature::orb, vladInUnitRange},
    {"sift-vlad", "SIFT aggregated by VLAD", LocalFeature::sift, vladInUnitRange},
};

const LocalType* findLocalType(const std::string& type) {
  const auto* found =
      std::ranges::find(localTypes, type, [](const LocalType& t) { return std::string(t.name); });
  return found == std::end(localTypes) ? nullptr : found;
}

/// Learns when it is asked first: where all values are in the cache, nothing is learned.
class LateVocabulary {
 public:
  LateVocabulary(LocalFeature feature, VocabularyImages images, const VisualVocabularyOptions& options)
      : feature_(feature), images_(std::move(images)), options_(options) {}

  const VisualVocabulary& get() {
    std::call_once(once_, [this] { learned_ = learnVisualVocabulary(images_.features(feature_), options_); });
    return learned_;
  }

 private:
  LocalFeature feature_;
  VocabularyImages images_;
  VisualVocabularyOptions options_;
  std::once_flag once_;
  VisualVocabulary learned_;
};

std::unique_ptr<Labeler> localLabeler(const LocalType& type, const VocabularyImages& images,
                                      const VocabularySizes& sizes) {
  VisualVocabularyOptions options;
  options.words = type.isVlad() ? sizes.vladWords : sizes.words;
  options.seed = sizes.seed;
  const std::size_t values = options.words * (type.isVlad() ? dimensionsOf(type.feature) : 1);
  const auto vocabulary = std::make_shared<LateVocabulary>(type.feature, images, options);
  const std::string identity =
      fmt::format("{} {} of {} words, {} features, seed {}, opencv " CV_VERSION ", {}", type.name,
                  featuresVersion, options.words, options.sampled, options.seed, images.digest);
  return std::make_unique<FeatureLabeler>(
      type.name, values, identity,
      [vocabulary, aggregate = type.aggregate, feature = type.feature](const cv::Mat& image) {
        return aggregate(vocabulary->get(), localFeatures(feature, image));
      });
}

/// Values ≥ 0 as shares of their sum; all alike where they are 0.
std::vector<float> sharesOf(std::vector<float> values) {
  const double sum = std::accumulate(values.begin(), values.end(), 0.0);
  for (float& value : values)
    value = static_cast<float>(sum > 0 ? value / sum : 1.0 / static_cast<double>(values.size()));
  return values;
}

}  // namespace

FeatureLabeler::FeatureLabeler(const std::string& name, std::size_t values, std::string identity,
                               Describe describe)
    : name_(name),
      identity_(std::move(identity)),
      vocabulary_([&] {
        std::vector<std::string> labels;
        for (std::size_t i = 0; i < values; ++i) labels.push_back(fmt::format("{} {}", name, i));
        return Vocabulary(std::move(labels));
      }()),
      describe_(std::move(describe)) {}

Prepared FeatureLabeler::prepare(const cv::Mat& bgr, const std::string& frame) const {
  return {cv::Mat(describe_(bgr), true).reshape(1, 1), frame, {}};
}

LexicalDescriptor FeatureLabeler::infer(const Prepared& prepared) {
  const cv::Mat& values = prepared.input;
  if (values.type() != CV_32F || values.rows != 1)
    fail(ErrorCode::mismatch, "{} got an image that another labeler prepared", name_);
  LexicalDescriptor descriptor(values.begin<float>(), values.end<float>());
  requireProbabilities(descriptor, vocabulary_.size(), name_);
  return descriptor;
}

Choices featureTypes() {
  Choices types;
  for (const LocalType& type : localTypes) types.push_back({type.name, type.explanation});
  for (const auto& [name, explanation] : descriptorTypes())
    if (!findDescriptor(name)->needsDepth()) types.push_back({name, explanation});
  return types;
}

bool needsVocabulary(const std::string& type) {
  return findLocalType(type) != nullptr;
}

PartKind kindOfFeature(const std::string& type) {
  if (const LocalType* local = findLocalType(type))
    return local->isVlad() ? PartKind::energies : PartKind::histogram;
  requireChoice("feature", type, featureTypes());
  return findDescriptor(type)->parts().front().kind;
}

std::unique_ptr<Labeler> makeFeatureLabeler(const std::string& type, const VocabularyImages& images,
                                            const VocabularySizes& sizes) {
  requireChoice("feature", type, featureTypes());
  if (const LocalType* local = findLocalType(type)) return localLabeler(*local, images, sizes);
  const std::shared_ptr<const Descriptor> descriptor = findDescriptor(type);
  const DescriptorPart part = descriptor->parts().front();
  return std::make_unique<FeatureLabeler>(
      type, part.size(), fmt::format("{} {} {}", type, featuresVersion, part.identity),
      [descriptor](const cv::Mat& image) { return sharesOf(descriptor->describe({.image = image})); });
}

std::unique_ptr<Labeler> makeShownWordLabeler(LocalFeature feature, const VocabularyImages& images,
                                              const VocabularySizes& sizes) {
  const char* name = feature == LocalFeature::orb ? "orb-words-shown" : "sift-words-shown";
  return localLabeler({name, "", feature, wordsShown}, images, sizes);
}

}  // namespace estancia::experiments
