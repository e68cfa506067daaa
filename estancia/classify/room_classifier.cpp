#include "estancia/classify/room_classifier.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <utility>

#include "estancia/classify/folds.hpp"
#include "estancia/classify/model_file.hpp"
#include "estancia/core/error.hpp"
#include "estancia/describe/table_features.hpp"

namespace estancia {
namespace fs = std::filesystem;
namespace {

constexpr ModelFileKind kind{"ESTROOMS", 1, "room classifier", "estancia classify train"};

/// The frames whose room is known.
Features withRooms(const Features& features) {
  std::vector<std::size_t> rows;
  for (std::size_t i = 0; i < features.frames.size(); ++i)
    if (!features.frames[i].room.empty()) rows.push_back(i);
  return withRows(features, rows);
}

std::vector<std::string> roomsOf(const std::vector<Frame>& frames) {
  std::map<std::string, std::size_t> images;
  for (const Frame& frame : frames) ++images[frame.room];
  std::vector<std::string> rooms;
  for (const auto& [room, count] : images) {
    if (count < 2)
      throw Error(fmt::format("room \"{}\" has one image only, {}; give it more, or leave it out", room,
                              std::find_if(frames.begin(), frames.end(), [&r = room](const Frame& frame) {
                                return frame.room == r;
                              })->name));
    rooms.push_back(room);
  }
  if (rooms.size() < 2)
    throw Error(rooms.empty()
                    ? "no image has a room to learn; give a table of rooms (--rooms)"
                    : fmt::format("all images are of one room, \"{}\"; a classifier needs two or more "
                                  "to tell apart",
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

/// Of tables: what differs tells more than two digests.
void requireSameColumns(const DescriptorPart& learned, const std::vector<DescriptorPart>& parts) {
  const auto found = std::ranges::find(parts, learned.name, &DescriptorPart::name);
  if (found == parts.end() || !isOfTable(learned) || !isOfTable(*found) || found->columns == learned.columns)
    return;
  throw Error(
      fmt::format("this room classifier has learned from a table whose part {} has {} columns, but here it "
                  "has {} (only there: {}; only here: {}); give the same columns in the same order, or train "
                  "anew",
                  learned.name, learned.size(), found->size(), lackingOf(learned.columns, found->columns),
                  lackingOf(found->columns, learned.columns)));
}

}  // namespace

RoomClassifier::RoomClassifier(std::vector<std::string> rooms, FeatureEmbedding embedding,
                               std::shared_ptr<const Classifier> classifier)
    : rooms_(std::move(rooms)), embedding_(std::move(embedding)), classifier_(std::move(classifier)) {}

RoomClassifier RoomClassifier::train(const Features& features, const ClassifierOptions& options,
                                     Progress& progress) {
  const Features known = withRooms(features);
  std::vector<std::string> rooms = roomsOf(known.frames);
  FeatureEmbedding embedding = FeatureEmbedding::learn(known);
  Samples samples{
      embedding.apply(known), {}, runsOfRooms(known.frames, options.folds), static_cast<int>(rooms.size())};
  for (const Frame& frame : known.frames)
    samples.classes.push_back(
        static_cast<int>(std::lower_bound(rooms.begin(), rooms.end(), frame.room) - rooms.begin()));
  return {std::move(rooms), std::move(embedding), trainClassifier(samples, options, progress)};
}

DescriptorMatrix RoomClassifier::predict(const Features& features, int threads) const {
  for (const PartEmbedding& learned : embedding_.parts()) requireSameColumns(learned.part, features.parts);
  return classifier_->predict(embedding_.apply(features), threads);
}

void RoomClassifier::save(const fs::path& file) const {
  ByteWriter content;
  content.number(static_cast<std::uint64_t>(rooms_.size()));
  for (const std::string& room : rooms_) content.text(room);
  embedding_.write(content);
  classifier_->write(content);
  writeModelFile(file, kind, content.bytes());
}

RoomClassifier RoomClassifier::load(const fs::path& file) {
  ModelFileReader model(file, kind);
  ByteReader& in = model.content();
  const std::size_t count = in.count(sizeof(std::uint32_t));
  std::vector<std::string> rooms;
  for (std::size_t i = 0; i < count; ++i) rooms.push_back(in.text());
  model.requirePrintable(rooms);
  auto [embedding, classifier] = model.classifier(count);
  return {std::move(rooms), std::move(embedding), std::move(classifier)};
}

bool isRoomClassifier(const fs::path& file) {
  return isModelFile(file, kind);
}

}  // namespace estancia
