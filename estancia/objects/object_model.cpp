// SPDX-License-Identifier: Apache-2.0
#include "estancia/objects/object_model.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <tuple>
#include <utility>

#include "estancia/classify/embedding.hpp"
#include "estancia/classify/model_file.hpp"
#include "estancia/core/config.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/files/files.hpp"
#include "estancia/objects/pseudo_labels.hpp"
#include "estancia/objects/training.hpp"

namespace estancia {
namespace fs = std::filesystem;
namespace {

std::vector<std::string> texts(ConfigFile& config, const toml::node& node) {
  std::vector<std::string> all;
  for (const toml::node& element : config.list(node)) all.push_back(config.text(element));
  if (all.empty())
    config.fail(node,
                fmt::format("`{}` is empty; leave it out if it is the name of the class", config.key()));
  return all;
}

TargetClasses::Class readClass(ConfigFile& config, const std::string& name, const toml::node& node) {
  const auto* table = node.as_table();
  if (table == nullptr) config.fail(node, fmt::format("`classes.{}` must be a table", name));
  TargetClasses::Class read{name, {name}, {name}};
  config.read(*table, {{"labels", false, "", [&](auto& n) { read.labels = texts(config, n); }},
                       {"categories", false, "", [&](auto& n) { read.categories = texts(config, n); }}});
  return read;
}

void requirePrintable(const TargetClasses::Class& target) {
  const std::string name = io::printable(target.name);
  if (target.name.empty()) throw Error(ErrorCode::invalidInput, "a target class has no name; give it one");
  if (name != target.name)
    fail(ErrorCode::invalidInput, "the name \"{}\" has control characters; remove them", name);
  if (target.labels.empty()) fail(ErrorCode::invalidInput, "\"{}\" has no label; give one", name);
  for (const auto* texts : {&target.labels, &target.categories})
    for (const std::string& text : *texts)
      if (text.empty() || io::printable(text) != text)
        fail(ErrorCode::invalidInput,
             "\"{}\" has a label or category that is empty or has control characters", name);
}

void requireTwoClasses(const ObjectTraining& training) {
  std::vector<std::string> learned;
  for (std::size_t c = 0; c < training.targets.classes.size(); ++c)
    if (std::ranges::count(training.classes, static_cast<int>(c)) > 0)
      learned.push_back(training.targets.classes[c].name);
  if (learned.size() >= 2) return;
  throw Error(
      ErrorCode::insufficientData,
      learned.empty()
          ? fmt::format("none of {} samples has a target class; label them", training.classes.size())
          : fmt::format("all samples are of class \"{}\"; give samples of two or more", learned.front()));
}

/// Held-out accuracy of each class; see ObjectModel::heldOutAccuracy().
std::vector<float> accuracies(const Samples& samples, const DescriptorMatrix& heldOut) {
  std::vector<float> predicted(heldOut.labels(), 0), correct(heldOut.labels(), 0),
      accuracy(heldOut.labels(), -1);
  for (std::size_t i = 0; i < heldOut.size(); ++i) {
    const auto best = std::ranges::max_element(heldOut.row(i));
    if (!(*best > 0)) continue;
    const auto c = static_cast<std::size_t>(best - heldOut.row(i).begin());
    ++predicted[c];
    correct[c] += samples.classes[i] == static_cast<int>(c) ? 1 : 0;
  }
  for (std::size_t c = 0; c < accuracy.size(); ++c)
    if (predicted[c] > 0) accuracy[c] = correct[c] / predicted[c];
  return accuracy;
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

/// One a class, or none if `optional`, each from `min` to 1.
std::vector<float> readShares(ByteReader& in, std::size_t classes, float min, bool optional) {
  std::vector<float> shares = in.numbers<float>();
  if ((shares.size() != classes && !(optional && shares.empty())) ||
      !std::ranges::all_of(shares, [min](float s) { return s >= min && s <= 1; }))
    in.fail("it is damaged (its shares of classes)");
  return shares;
}

}  // namespace

void validate(const TargetClasses& targets) {
  if (targets.classes.empty())
    throw Error(ErrorCode::invalidInput, "there are no target classes; give at least one");
  std::set<std::string> names;
  std::set<std::pair<std::string, std::string>> owners;  // owners of categories
  for (const TargetClasses::Class& target : targets.classes) {
    requirePrintable(target);
    if (!names.insert(target.name).second)
      fail(ErrorCode::invalidInput, "two target classes are called \"{}\"; rename one", target.name);
    for (const std::string& category : target.categories) {
      const auto found = owners.lower_bound({category, ""});
      if (found != owners.end() && found->first == category && found->second != target.name)
        fail(ErrorCode::invalidInput, "the category \"{}\" belongs to both \"{}\" and \"{}\"; give it to one",
             category, found->second, target.name);
      owners.emplace(category, target.name);
    }
  }
}

TargetClasses readTargetClasses(const fs::path& file) {
  ConfigFile config(file);
  const toml::table* tables = nullptr;
  config.read({{"classes", true, "a table [classes.NAME] for each class",
                [&](auto& n) { tables = &config.subtable(n); }}});
  // The parser sorts by name; people expect the order of the file.
  std::vector<std::pair<std::string, const toml::node*>> inOrder;
  for (const auto& [name, node] : *tables) inOrder.emplace_back(name.str(), &node);
  std::ranges::stable_sort(inOrder, {}, [](const auto& entry) {
    const auto& begin = entry.second->source().begin;
    return std::pair(begin.line, begin.column);
  });
  TargetClasses targets;
  const auto requireValid = [&](const toml::node& node) {
    try {
      validate(targets);
    } catch (const Error& error) {
      config.fail(node, error.what());
    }
  };
  for (const auto& [name, node] : inOrder) {
    targets.classes.push_back(readClass(config, name, *node));
    requireValid(*node);
  }
  requireValid(*tables);
  return targets;
}

TargetClasses targetClassesOf(const std::vector<std::string>& categories) {
  TargetClasses targets;
  for (const std::string& category : categories)
    if (targets.classOf(category) < 0) targets.classes.push_back({category, {category}, {category}});
  validate(targets);
  return targets;
}

std::vector<std::string> TargetClasses::names() const {
  std::vector<std::string> all;
  for (const Class& target : classes) all.push_back(target.name);
  return all;
}

int TargetClasses::classOf(const std::string& category) const {
  for (std::size_t c = 0; c < classes.size(); ++c)
    if (std::ranges::find(classes[c].categories, category) != classes[c].categories.end())
      return static_cast<int>(c);
  return -1;
}

struct ObjectModel::Learned {
  TargetClasses targets = {};
  ShapeOptions shape = {};
  std::string labeler = {};
  std::vector<float> prior = {}, heldOutAccuracy = {};
  FeatureEmbedding embedding = {};
  std::shared_ptr<const Classifier> classifier = {};
};

ObjectModel trainObjectModel(const ObjectTraining& training, const ClassifierOptions& options,
                             Progress& progress) {
  const std::size_t classes = training.targets.classes.size();
  validate(training.targets);
  if (!training.prior.empty() &&
      (training.prior.size() != classes ||
       !std::ranges::all_of(training.prior, [](float p) { return p >= 0 && p <= 1; })))
    fail(ErrorCode::invalidInput, "the prior has {} numbers; give one from 0 to 1 for each of {} classes",
         training.prior.size(), classes);
  requireTwoClasses(training);
  LabeledShapes labeled =
      labeledShapes(training.shapes, training.classes, training.instances, classes, options.folds);
  std::shared_ptr<const Classifier> classifier = trainClassifier(labeled.samples, options, progress);
  std::vector<float> accuracy = accuracies(labeled.samples, heldOut(labeled.samples, options, progress));
  return ObjectModel(std::make_shared<const ObjectModel::Learned>(
      ObjectModel::Learned{training.targets, training.shape, training.labeler, training.prior,
                           std::move(accuracy), std::move(labeled.embedding), std::move(classifier)}));
}

const TargetClasses& ObjectModel::targets() const {
  return learned_->targets;
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

const std::vector<float>& ObjectModel::heldOutAccuracy() const {
  return learned_->heldOutAccuracy;
}

std::string ObjectModel::choice() const {
  return learned_->classifier->choice();
}

DescriptorMatrix ObjectModel::predict(const Features& shapes, int threads) const {
  return learned_->classifier->predict(learned_->embedding.apply(shapes), threads);
}

void writeObjectModel(const ObjectModel& model, const fs::path& file) {
  const ObjectModel::Learned& learned = *model.learned_;
  ByteWriter content;
  content.number(static_cast<std::uint64_t>(learned.targets.classes.size()));
  for (const TargetClasses::Class& target : learned.targets.classes) {
    content.text(target.name);
    writeTexts(content, target.labels);
    writeTexts(content, target.categories);
  }
  content.number(static_cast<std::int32_t>(learned.shape.samples));
  content.number(static_cast<std::uint8_t>(learned.shape.size ? 1 : 0));
  content.number(learned.shape.seed);
  content.text(learned.labeler);
  content.numbers(learned.prior);
  content.numbers(learned.heldOutAccuracy);
  learned.embedding.write(content);
  learned.classifier->write(content);
  writeModelFile(file, objectModelKind, content.bytes());
}

ObjectModel readObjectModel(const fs::path& file) {
  ModelFileReader model(file, objectModelKind);
  ByteReader& in = model.content();
  ObjectModel::Learned learned;
  const std::size_t classes = in.count(sizeof(std::uint32_t));
  for (std::size_t c = 0; c < classes; ++c) {
    TargetClasses::Class target;
    target.name = in.text();
    target.labels = readTexts(model);
    target.categories = readTexts(model);
    model.requirePrintable({target.name});
    learned.targets.classes.push_back(std::move(target));
  }
  learned.shape.samples = in.number<std::int32_t>();
  learned.shape.size = in.number<std::uint8_t>() != 0;
  learned.shape.seed = in.number<std::uint64_t>();
  try {
    validate(learned.targets);
    validate(learned.shape);
  } catch (const Error& e) {
    in.fail(fmt::format("it is damaged ({})", e.what()));
  }
  learned.labeler = in.text();
  model.requirePrintable({learned.labeler});
  learned.prior = readShares(in, classes, 0, true);
  learned.heldOutAccuracy = readShares(in, classes, -1, false);
  std::tie(learned.embedding, learned.classifier) = model.classifier(classes);
  return ObjectModel(std::make_shared<const ObjectModel::Learned>(std::move(learned)));
}

bool isObjectModel(const fs::path& file) {
  return isModelFile(file, objectModelKind);
}

}  // namespace estancia
