// SPDX-License-Identifier: Apache-2.0
#include "estancia/classify/room_classifier.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <mutex>
#include <utility>

#include "estancia/classify/embedding.hpp"
#include "estancia/classify/model_file.hpp"
#include "estancia/classify/predict_rooms.hpp"
#include "estancia/classify/trainers.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/describe/table_features.hpp"

namespace estancia {
namespace fs = std::filesystem;
namespace {

std::vector<std::string> roomNames(const std::vector<Frame>& frames) {
  std::map<std::string, std::size_t> images;
  for (const Frame& frame : frames) ++images[frame.room];
  std::vector<std::string> rooms;
  for (const auto& [room, count] : images) {
    if (count < 2)
      fail(ErrorCode::insufficientData, "room \"{}\" has one image only, {}; give it more, or leave it out",
           room,
           std::ranges::find_if(frames, [&r = room](const Frame& frame) { return frame.room == r; })->name);
    rooms.push_back(room);
  }
  if (rooms.size() < 2)
    throw Error(ErrorCode::insufficientData,
                rooms.empty() ? "no image has a known room; give a table of rooms (--rooms), or a folder of "
                                "images per room (--type classes)"
                              : fmt::format("all images are of one room, \"{}\"; give images of two or more",
                                            rooms.front()));
  return rooms;
}

/// "a, b, c …": those of `columns` that `others` lacks.
std::string lackingOf(const std::vector<std::string>& columns, const std::vector<std::string>& others) {
  constexpr std::size_t shown = 3;
  std::vector<std::string> lacking;
  for (const std::string& column : columns)
    if (std::ranges::find(others, column) == others.end()) lacking.push_back(column);
  const bool more = lacking.size() > shown;
  if (more) lacking.resize(shown);
  return lacking.empty() ? "none" : fmt::format("{}{}", fmt::join(lacking, ", "), more ? " …" : "");
}

/// For tables: names the columns that differ, which helps more than two digests.
void requireSameColumns(const DescriptorPart& learned, const std::vector<DescriptorPart>& parts) {
  const auto found = std::ranges::find(parts, learned.name, &DescriptorPart::name);
  if (found == parts.end() || !isOfTable(learned) || !isOfTable(*found) || found->columns == learned.columns)
    return;
  fail(ErrorCode::mismatch,
       "this room classifier was trained on a table whose part {} has {} columns, but this one has {} "
       "(missing: {}; new: {}); give the same columns in the same order, or train again",
       learned.name, learned.size(), found->size(), lackingOf(learned.columns, found->columns),
       lackingOf(found->columns, learned.columns));
}

}  // namespace

struct RoomClassifier::Learned {
  Learned(std::vector<std::string> names, std::uint64_t count, FeatureEmbedding words,
          std::shared_ptr<const Classifier> chosen)
      : rooms(std::move(names)), images(count), embedding(std::move(words)), classifier(std::move(chosen)) {}

  std::vector<std::string> rooms;
  std::uint64_t images;
  FeatureEmbedding embedding;
  std::shared_ptr<const Classifier> classifier;
  mutable std::once_flag loading;
  mutable std::unique_ptr<Descriptor> descriptor;
};

const std::vector<std::string>& RoomClassifier::rooms() const {
  return learned_->rooms;
}

std::size_t RoomClassifier::trainingImages() const {
  return learned_->images;
}

const FeatureEmbedding& RoomClassifier::embedding() const {
  return learned_->embedding;
}

const Classifier& RoomClassifier::classifier() const {
  return *learned_->classifier;
}

std::vector<RoomProbability> RoomClassifier::predict(const cv::Mat& image) const {
  std::call_once(learned_->loading, [this] {
    requireDescribable(*this);
    learned_->descriptor = loadDescriptor(descriptorOf(*this));
  });
  const Features features = featuresOf(*learned_->descriptor, {.image = image});
  return rankedRooms({.classifier = "", .rooms = rooms(), .probabilities = predict(features, 1)}, 0);
}

DescriptorMatrix RoomClassifier::predict(const Features& features, int threads) const {
  for (const PartEmbedding& learned : embedding().parts()) requireSameColumns(learned.part, features.parts);
  return classifier().predict(embedding().apply(features), threads);
}

RoomClassifier trainRoomClassifier(const Features& features, const ClassifierOptions& options,
                                   Progress& progress) {
  std::vector<std::size_t> rows;
  for (std::size_t i = 0; i < features.frames.size(); ++i)
    if (!features.frames[i].room.empty()) rows.push_back(i);
  const Features known = withRows(features, rows);
  std::vector<std::string> rooms = roomNames(known.frames);
  FeatureEmbedding embedding = FeatureEmbedding::learn(known);
  Samples samples{
      embedding.apply(known), {}, segmentGroups(known.frames, options.folds), static_cast<int>(rooms.size())};
  for (const Frame& frame : known.frames)
    samples.classes.push_back(
        static_cast<int>(std::lower_bound(rooms.begin(), rooms.end(), frame.room) - rooms.begin()));
  return RoomClassifier(
      std::make_shared<RoomClassifier::Learned>(std::move(rooms), known.frames.size(), std::move(embedding),
                                                trainClassifier(samples, options, progress)));
}

RoomClassifier readRoomClassifier(const fs::path& file) {
  ModelFileReader model(file, roomClassifierKind);
  ByteReader& in = model.content();
  const std::size_t count = in.count(sizeof(std::uint32_t));
  std::vector<std::string> rooms;
  for (std::size_t i = 0; i < count; ++i) rooms.push_back(in.text());
  model.requirePrintable(rooms);
  const auto images = in.number<std::uint64_t>();
  auto [embedding, classifier] = model.classifier(count);
  return RoomClassifier(std::make_shared<RoomClassifier::Learned>(
      std::move(rooms), images, std::move(embedding), std::move(classifier)));
}

void writeRoomClassifier(const RoomClassifier& classifier, const fs::path& file) {
  ByteWriter content;
  content.number(static_cast<std::uint64_t>(classifier.rooms().size()));
  for (const std::string& room : classifier.rooms()) content.text(room);
  content.number(static_cast<std::uint64_t>(classifier.trainingImages()));
  classifier.embedding().write(content);
  classifier.classifier().write(content);
  writeModelFile(file, roomClassifierKind, content.bytes());
}

bool isRoomClassifier(const fs::path& file) {
  return isModelFile(file, roomClassifierKind);
}

}  // namespace estancia
