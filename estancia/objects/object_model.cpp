#include "estancia/objects/object_model.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "estancia/classify/model_file.hpp"
#include "estancia/core/error.hpp"
#include "estancia/objects/learning.hpp"

namespace estancia {
namespace fs = std::filesystem;
namespace {

constexpr ModelFileKind kind{"ESTOBJCT", 1, "model of objects", "estancia objects train"};

void requireTwoWords(const ObjectTraining& training) {
  std::vector<std::string> learned;
  for (std::size_t w = 0; w < training.study.words.size(); ++w)
    if (std::ranges::count(training.words, static_cast<int>(w)) > 0)
      learned.push_back(training.study.words[w].name);
  if (learned.size() >= 2) return;
  throw Error(learned.empty()
                  ? fmt::format("not one of {} samples is named by a word of the study; there is nothing to "
                                "learn",
                                training.words.size())
                  : fmt::format("all samples that are named are called \"{}\"; a model needs two words or "
                                "more to tell apart",
                                learned.front()));
}

/// By word; see ObjectModel::agreement().
std::vector<float> scorePose(const Samples& samples, const DescriptorMatrix& held) {
  std::vector<float> taken(held.labels(), 0), right(held.labels(), 0), agreement(held.labels(), -1);
  for (std::size_t i = 0; i < held.size(); ++i) {
    const auto best = std::ranges::max_element(held.row(i));
    if (!(*best > 0)) continue;
    const auto word = static_cast<std::size_t>(best - held.row(i).begin());
    ++taken[word];
    right[word] += samples.classes[i] == static_cast<int>(word) ? 1 : 0;
  }
  for (std::size_t w = 0; w < agreement.size(); ++w)
    if (taken[w] > 0) agreement[w] = right[w] / taken[w];
  return agreement;
}

void writeTexts(ByteWriter& out, const std::vector<std::string>& texts) {
  out.number(static_cast<std::uint64_t>(texts.size()));
  for (const std::string& text : texts) out.text(text);
}

std::vector<std::string> readTexts(ModelFileReader& model) {
  ByteReader& in = model.content();
  std::vector<std::string> texts(in.count(sizeof(std::uint32_t)));
  for (std::string& text : texts) text = in.text();
  model.requirePrintable(texts);
  return texts;
}

/// One a word, or none where `optional`, each from `least` to 1.
std::vector<float> readShares(ByteReader& in, std::size_t words, float least, bool optional) {
  std::vector<float> shares = in.numbers<float>();
  if ((shares.size() != words && !(optional && shares.empty())) ||
      !std::ranges::all_of(shares, [least](float s) { return s >= least && s <= 1; }))
    in.fail("it is damaged (its shares of words)");
  return shares;
}

}  // namespace

struct ObjectModel::Learned {
  TargetClasses study;
  ShapeOptions shape;
  std::string labeler;
  std::vector<float> prior, agreement;
  FeatureEmbedding embedding;
  std::shared_ptr<const Classifier> classifier;
};

ObjectModel::ObjectModel(std::shared_ptr<const Learned> learned) : learned_(std::move(learned)) {}

ObjectModel ObjectModel::train(const ObjectTraining& training, const ClassifierOptions& options,
                               Progress& progress) {
  const std::size_t words = training.study.words.size();
  if (const std::string flaw = flawOf(training.study); !flaw.empty()) throw Error(flaw);
  if (!training.prior.empty() &&
      (training.prior.size() != words ||
       !std::ranges::all_of(training.prior, [](float p) { return p >= 0 && p <= 1; })))
    throw Error(fmt::format("the prior of a study of {} words must be as many numbers from 0 to 1", words));
  requireTwoWords(training);
  NamedShapes named = namedShapes(training.shapes, training.words, training.instances, words, options.folds);
  std::shared_ptr<const Classifier> classifier = trainClassifier(named.samples, options, progress);
  std::vector<float> agreement = scorePose(named.samples, heldOut(named.samples, options, progress));
  return ObjectModel(std::make_shared<const Learned>(
      Learned{training.study, training.shape, training.labeler, training.prior, std::move(agreement),
              std::move(named.embedding), std::move(classifier)}));
}

const TargetClasses& ObjectModel::study() const {
  return learned_->study;
}

const ShapeOptions& ObjectModel::shape() const {
  return learned_->shape;
}

const std::string& ObjectModel::labeler() const {
  return learned_->labeler;
}

const std::vector<float>& ObjectModel::prior() const {
  return learned_->prior;
}

const std::vector<float>& ObjectModel::agreement() const {
  return learned_->agreement;
}

std::string ObjectModel::choice() const {
  return learned_->classifier->choice();
}

DescriptorMatrix ObjectModel::predict(const Features& shapes, int threads) const {
  return learned_->classifier->predict(learned_->embedding.apply(shapes), threads);
}

void ObjectModel::save(const fs::path& file) const {
  ByteWriter content;
  content.number(static_cast<std::uint64_t>(study().words.size()));
  for (const TargetClasses::Word& word : study().words) {
    content.text(word.name);
    writeTexts(content, word.labels);
    writeTexts(content, word.categories);
  }
  content.number(static_cast<std::int32_t>(shape().samples));
  content.number(static_cast<std::uint8_t>(shape().size ? 1 : 0));
  content.number(shape().seed);
  content.text(labeler());
  content.numbers(prior());
  content.numbers(agreement());
  learned_->embedding.write(content);
  learned_->classifier->write(content);
  writeModelFile(file, kind, content.bytes());
}

ObjectModel ObjectModel::load(const fs::path& file) {
  ModelFileReader model(file, kind);
  ByteReader& in = model.content();
  Learned learned;
  const std::size_t words = in.count(sizeof(std::uint32_t));
  for (std::size_t w = 0; w < words; ++w) {
    TargetClasses::Word word;
    word.name = in.text();
    word.labels = readTexts(model);
    word.categories = readTexts(model);
    model.requirePrintable({word.name});
    learned.study.words.push_back(std::move(word));
  }
  if (const std::string flaw = flawOf(learned.study); !flaw.empty())
    in.fail(fmt::format("it is damaged ({})", flaw));
  learned.shape.samples = in.number<std::int32_t>();
  learned.shape.size = in.number<std::uint8_t>() != 0;
  learned.shape.seed = in.number<std::uint64_t>();
  try {
    shapeParts(learned.shape);
  } catch (const Error& e) {
    in.fail(fmt::format("it is damaged ({})", e.what()));
  }
  learned.labeler = in.text();
  model.requirePrintable({learned.labeler});
  learned.prior = readShares(in, words, 0, true);
  learned.agreement = readShares(in, words, -1, false);
  std::tie(learned.embedding, learned.classifier) = model.classifier(words);
  return ObjectModel(std::make_shared<const Learned>(std::move(learned)));
}

bool isObjectModel(const fs::path& file) {
  return isModelFile(file, kind);
}

}  // namespace estancia
