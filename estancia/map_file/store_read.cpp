// SPDX-License-Identifier: Apache-2.0
#include "estancia/map_file/store_read.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "estancia/core/printable.hpp"
#include "estancia/core/printable_labels.hpp"

namespace estancia {
namespace {

using sqlite::Database;
using sqlite::Statement;

static_assert(std::endian::native == std::endian::little, "map files hold little-endian float32");

std::size_t countIn(const Statement& row, int column, std::int64_t lowest, const char* what,
                    std::size_t highest = maxFramesOfMap) {
  return static_cast<std::size_t>(row.number(column, lowest, static_cast<std::int64_t>(highest), what));
}

/// The number of a frame that was mapped.
std::size_t frameIn(const Statement& row, int column, std::size_t frames, const char* what) {
  return static_cast<std::size_t>(row.number(column, 0, static_cast<std::int64_t>(frames) - 1, what));
}

std::string readMeta(const Database& database, std::string_view key) {
  Statement statement(database, "SELECT value FROM meta WHERE key = ?1", key);
  if (!statement.next()) database.failDamaged("its {} is missing", key);
  return statement.text(0);
}

void readNodes(const Database& database, TopologicalMap& map) {
  const std::size_t frames = frameCountOf(database);
  Statement rows(database, "SELECT id, frames, mean, sigma FROM nodes ORDER BY id");
  while (rows.next()) {
    Node node;
    node.id = rows.node(0, 0, "a node's number");
    node.frames = countIn(rows, 1, 1, "a node's image count", frames);
    const std::string name = fmt::format("node {}", node.id);
    readValues(database, rows.bytes(2), map.vocabulary.size(), name + "'s mean", node.mean);
    readValues(database, rows.bytes(3), map.vocabulary.size(), name + "'s deviation", node.sigma);
    map.nodes.push_back(std::move(node));
  }
}

/// The numbers of each n-th frame, at most `most`, and of those in `also`; nothing where all are read.
std::optional<std::vector<std::size_t>> numbersToRead(const Database& database, std::size_t most,
                                                      const std::vector<std::size_t>& also) {
  Statement count(database, "SELECT count(*) FROM frames");
  const std::size_t all = count.next() ? countIn(count, 0, 0, "the number of frames") : 0;
  const std::size_t mapped = frameCountOf(database), leftOut = leftOutOf(database);
  if (all + leftOut != mapped)
    database.failDamaged("it has {} of {} frames, and {} were left out of it", all, mapped, leftOut);
  if (most >= all) return std::nullopt;
  const std::size_t stride = (all - 1) / std::max<std::size_t>(1, most) + 1;
  const std::vector<std::size_t> kept =
      leftOut == 0 ? std::vector<std::size_t>() : database.numbers("SELECT id FROM frames ORDER BY id");
  std::vector<std::size_t> numbers = also;
  for (std::size_t row = 0; row < all; row += stride) numbers.push_back(kept.empty() ? row : kept.at(row));
  std::ranges::sort(numbers);
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
  return numbers;
}

void readFrames(const Database& database, TopologicalMap& map, const FrameRows& which) {
  Statement rows =
      which.select(database, "id, name, timestamp, x, y, z, qx, qy, qz, qw, room, node", "frames", "id");
  while (rows.next()) {
    MappedFrame frame;
    frame.number = countIn(rows, 0, 0, "a frame's number");
    frame.name = printable(rows.text(1));
    if (const double timestamp = rows.real(2); std::isfinite(timestamp)) frame.timestamp = timestamp;
    frame.pose = rows.pose(3);
    frame.room = printable(rows.text(10));
    frame.node = rows.node(11, map.nodes.empty() ? -1 : 0, "a frame's node");  // -1: to be mapped again
    if (frame.node >= 0 && map.findNode(frame.node) == nullptr)
      database.failDamaged("frame {} is in node {}, which is missing", frame.number, frame.node);
    map.frames.push_back(std::move(frame));
  }
}

/// Maps of older programs have none.
void addDrives(const Database& database, TopologicalMap& map) {
  if (map.frames.empty()) return;
  const std::size_t last = frameCountOf(database) - 1;
  for (Drive& drive : readDrives(database)) {
    if (drive.firstFrame > last + 1)
      database.failDamaged("a drive begins at frame {}, which is missing", drive.firstFrame);
    const auto first = std::ranges::lower_bound(map.frames, drive.firstFrame, {}, &MappedFrame::number);
    drive.firstFrame = static_cast<std::size_t>(first - map.frames.begin());
    if (drive.firstFrame < map.frames.size()) map.drives.push_back(std::move(drive));
  }
  if (map.drives.empty() || map.drives.front().firstFrame > 0) map.drives.insert(map.drives.begin(), Drive{});
}

void addTransitions(const Database& database, TopologicalMap& map) {
  for (Transition& transition : readTransitions(database)) {
    for (const int node : {transition.from, transition.to})
      if (map.findNode(node) == nullptr)
        database.failDamaged("a transition touches node {}, which is missing", node);
    transition.firstFrame = map.indexOf(transition.firstFrame);
    map.transitions.push_back(transition);
  }
}

void readDecisions(const Database& database, TopologicalMap& map) {
  const std::size_t frames = frameCountOf(database);
  Statement rows(database,
                 "SELECT frame, kind, node, current, to_current, other, to_other, tau_join, tau_revisit "
                 "FROM decisions ORDER BY frame");
  while (rows.next()) {
    const auto frame = map.findFrame(frameIn(rows, 0, frames, "a decision's frame"));
    if (!frame) continue;
    const auto kind = rows.number(1, 0, static_cast<int>(DecisionKind::localize), "the kind of a decision");
    const Decision decision{*frame,
                            static_cast<DecisionKind>(kind),
                            rows.node(2, 0, "a decision's node"),
                            rows.node(3, -1, "a decision's current node"),
                            rows.real(4),
                            rows.node(5, -1, "a decision's other node"),
                            rows.real(6),
                            rows.real(7),
                            rows.real(8)};
    if (decision.kind == DecisionKind::join && decision.current < 0)
      database.failDamaged("frame {} joined node {}", decision.frame, decision.current);
    map.decisions.push_back(decision);
  }
}

void readMerges(const Database& database, TopologicalMap& map) {
  const std::size_t frames = frameCountOf(database);
  Statement rows(database, "SELECT frame, kept, absorbed, distance, threshold FROM merges ORDER BY id");
  while (rows.next()) {
    const std::size_t frame = map.indexOf(frameIn(rows, 0, frames, "a merge's frame"));
    const int kept = rows.node(1, 0, "a merge's node"), absorbed = rows.node(2, 0, "a merge's node");
    map.merges.push_back({frame, kept, absorbed, rows.real(3), rows.real(4)});
  }
}

/// Reads what only predictions by the rooms' names have.
void readRoomsByName(const Database& database, RoomPredictions& predictions) {
  Statement query(database, "SELECT value FROM meta WHERE key = 'rooms_by_name'");
  if (!query.next()) return;
  try {
    const auto json = nlohmann::json::parse(query.text(0));
    predictions.prior = json.at("prior").get<std::vector<double>>();
    predictions.areListed = json.at("listed").get<bool>();
    predictions.areByName = true;
    const auto isShare = [](double share) { return share > 0 && share <= 1; };
    if (predictions.prior.size() == predictions.rooms.size() &&
        std::ranges::all_of(predictions.prior, isShare))
      return;
  } catch (const nlohmann::json::exception&) {
    // as wrong as shares of other rooms
  }
  database.failDamaged("what it says of rooms by name is wrong");
}

void readRoomEvidence(const Database& database, const TopologicalMap& map, const FrameRows& which,
                      RoomPredictions& predictions) {
  if (!sqlite::hasTable(database, "room_evidence")) return;
  Statement rows = which.select(database, "frame, label, log_odds", "room_evidence", "frame");
  const std::size_t rooms = predictions.rooms.size(), frames = frameCountOf(database);
  while (rows.next()) {
    const auto frame = map.findFrame(frameIn(rows, 0, frames, "the frame of room evidence"));
    if (!frame) continue;
    RoomEvidence told;
    told.image = *frame;
    told.label = static_cast<std::size_t>(rows.number(
        1, 0, static_cast<std::int64_t>(map.vocabulary.size()) - 1, "the label of room evidence"));
    const std::span<const std::byte> bytes = rows.bytes(2);
    told.logOdds.resize(rooms);
    if (bytes.size() != rooms * sizeof(float))
      database.failDamaged("the room evidence of frame {} does not fit {} rooms", told.image, rooms);
    std::memcpy(told.logOdds.data(), bytes.data(), bytes.size());  // the blob need not be aligned
    if (!std::ranges::all_of(told.logOdds, [](float value) { return std::isfinite(value); }))
      database.failDamaged("the room evidence of frame {} is no number", told.image);
    predictions.evidence.push_back(std::move(told));
  }
}

void readPredictions(const Database& database, TopologicalMap& map, const FrameRows& which) {
  if (!sqlite::hasTable(database, "predicted_rooms")) return;
  std::vector<std::string> rooms;
  Statement names(database, "SELECT id, name FROM predicted_rooms ORDER BY id");
  while (names.next()) {
    rooms.push_back(printable(names.text(1)));
    if (names.integer(0) != static_cast<std::int64_t>(rooms.size()) - 1 || rooms.back().empty())
      database.failDamaged("its predicted rooms have gaps");
  }
  if (rooms.empty()) database.failDamaged("it has no predicted rooms");
  const std::size_t labels = rooms.size(), count = frameCountOf(database);
  RoomPredictions predictions{printable(readMeta(database, "classifier")), std::move(rooms),
                              DescriptorMatrix(labels)};
  readRoomsByName(database, predictions);
  // Predictions by names exist for few frames, those of a classifier for each frame.
  const FrameRows few = predictions.areByName ? FrameRows() : which;
  Statement rows = few.select(database, "frame, probabilities", "predictions", "frame");
  const std::vector<float> none(labels, 0);
  std::vector<float> row;
  while (rows.next()) {
    const std::size_t number = countIn(rows, 0, 0, "the frame of a room prediction");
    const std::string name = fmt::format("the room prediction of frame {}", number);
    if (number >= count) database.failDamaged("{} is of no frame", name);
    const auto frame = map.findFrame(number);
    if (!frame) continue;  // it was not read
    while (predictions.probabilities.size() < *frame) predictions.probabilities.append(none);
    readValues(database, rows.bytes(1), labels, name, row);
    predictions.probabilities.append(row);
  }
  readRoomEvidence(database, map, few, predictions);
  map.predictions = std::move(predictions);
}

/// `labels` in the parts that the map names, if any.
Vocabulary readVocabulary(const Database& database, std::vector<std::string> labels) {
  Statement query(database, "SELECT value FROM meta WHERE key = 'parts'");
  if (!query.next()) return Vocabulary(std::move(labels));
  try {
    std::vector<LabelPart> parts;
    for (const auto& part : nlohmann::json::parse(query.text(0)))
      parts.push_back({part.at(0).get<std::size_t>(), part.at(1).get<float>()});
    return Vocabulary(std::move(labels), std::move(parts));
  } catch (const std::exception&) {
    database.failDamaged("the parts of its vocabulary are wrong");
  }
}

/// The settings' "distance", "" when they name none.
std::string distanceOf(const std::string& settings) {
  const auto parsed = nlohmann::json::parse(settings, nullptr, false);
  if (!parsed.is_object()) return "";
  const auto found = parsed.find("distance");
  return found != parsed.end() && found->is_string() ? printable(found->get<std::string>()) : "";
}

}  // namespace

std::size_t leftOutOf(const Database& database) {
  Statement row(database, "SELECT value FROM meta WHERE key = ?1", leftOutKey);
  if (!row.next()) return 0;
  const std::string text = row.text(0);
  std::size_t count = 0;
  if (std::from_chars(text.data(), text.data() + text.size(), count).ptr != text.data() + text.size())
    database.failDamaged("the number of frames that were left out of it is none");
  return count;
}

std::size_t frameCountOf(const Database& database) {
  const std::int64_t count = database.number("SELECT ifnull(max(id) + 1, 0) FROM frames");
  if (count < 0 || database.number("SELECT ifnull(min(id), 0) FROM frames") < 0)
    database.failDamaged("its frames have negative numbers");
  if (static_cast<std::size_t>(count) > maxFramesOfMap)
    database.failDamaged("its frames are numbered up to {}", count - 1);
  return static_cast<std::size_t>(count);
}

std::vector<Transition> readTransitions(const Database& database) {
  const std::size_t frames = frameCountOf(database);
  Statement rows(database,
                 "SELECT source, target, count, first_frame FROM transitions ORDER BY first_frame, source");
  std::vector<Transition> transitions;
  while (rows.next())
    transitions.push_back({rows.node(0, 0, "a transition's start"), rows.node(1, 0, "a transition's end"),
                           countIn(rows, 2, 0, "a transition's count", frames),
                           countIn(rows, 3, 0, "a transition's first frame")});
  return transitions;
}

std::vector<Drive> readDrives(const Database& database) {
  std::vector<Drive> drives;
  if (!sqlite::hasTable(database, "drives")) return drives;
  Statement rows(database,
                 "SELECT first_frame, name, fingerprint, aligned, x, y, z, qx, qy, qz, qw FROM drives "
                 "ORDER BY first_frame");
  while (rows.next()) {
    drives.push_back({countIn(rows, 0, 0, "a drive's first frame"), printable(rows.text(1)), rows.text(2),
                      rows.number(3, 0, 1, "whether a drive is aligned") == 1, rows.pose(4)});
    if (!std::isnan(rows.real(4)) && !drives.back().alignment)
      database.failDamaged("the alignment of drive {} is no pose", drives.size() - 1);
  }
  return drives;
}

void readValues(const Database& database, std::span<const std::byte> bytes, std::size_t labels,
                const std::string& what, std::vector<float>& values) {
  if (bytes.size() != labels * sizeof(float))
    database.failDamaged("{} has {} bytes for {} labels", what, bytes.size(), labels);
  values.resize(labels);
  std::memcpy(values.data(), bytes.data(), bytes.size());  // the blob need not be aligned
  for (const float value : values)
    if (!(value >= -0.001F && value <= 1.001F))  // what is stored may be a rounding beyond 0 … 1
      database.failDamaged("{} holds {}", what, value);
}

MapStore::Identity readIdentity(const Database& database) {
  std::vector<std::string> labels;
  {
    Statement rows(database, "SELECT id, label FROM labels ORDER BY id");
    while (rows.next()) {
      labels.push_back(rows.text(1));
      if (rows.integer(0) != static_cast<std::int64_t>(labels.size()) - 1 || labels.back().empty())
        database.failDamaged("its labels have gaps");
    }
  }
  if (labels.empty()) database.failDamaged("it has no labels");
  MapStore::Identity identity{readVocabulary(database, std::move(labels)),
                              printable(readMeta(database, "model")), readMeta(database, "settings")};
  if (identity.vocabulary.digest() != readMeta(database, "vocabulary"))
    database.failDamaged("its labels do not match their digest");
  identity.vocabulary = printableLabels(identity.vocabulary);
  return identity;
}

TopologicalMap readContent(const Database& database, const MapStore::Identity& identity,
                           std::size_t maxFrames, const std::vector<std::size_t>& also) {
  TopologicalMap map{
      .vocabulary = identity.vocabulary, .model = identity.model, .distance = distanceOf(identity.settings)};
  const std::optional<std::vector<std::size_t>> numbers = numbersToRead(database, maxFrames, also);
  const FrameRows which = numbers ? FrameRows(*numbers) : FrameRows();
  readNodes(database, map);
  readFrames(database, map, which);
  addDrives(database, map);
  addTransitions(database, map);
  if (!numbers) readDecisions(database, map);
  readMerges(database, map);
  readPredictions(database, map, which);
  return map;
}

FrameRows::FrameRows(std::span<const std::size_t> numbers)
    : numbers_(fmt::format("[{}]", fmt::join(numbers, ","))) {}

Statement FrameRows::select(const Database& database, std::string_view columns, std::string_view table,
                            std::string_view frame) const {
  if (!numbers_) return {database, fmt::format("SELECT {} FROM {} ORDER BY {}", columns, table, frame)};
  const std::string sql = fmt::format(
      "SELECT {} FROM (SELECT value AS number_read FROM json_each(?1)) CROSS JOIN {} ON {} = number_read",
      columns, table, frame);
  return {database, sql, std::string_view(*numbers_)};
}

FrameRows::FrameRows(const Database& database, const TopologicalMap& map) {
  if (map.frames.size() + leftOutOf(database) >= frameCountOf(database)) return;
  std::vector<std::size_t> numbers;
  for (const MappedFrame& frame : map.frames) numbers.push_back(frame.number);
  *this = FrameRows(numbers);
}

std::vector<Visit> readVisits(const Database& database) {
  Statement rows(database, "SELECT id, node FROM frames ORDER BY node, id");  // by the index, which is small
  std::vector<Visit> runs;  // runs of frames without gaps in their numbers; those of one node are contiguous
  while (rows.next()) {
    const std::size_t frame = countIn(rows, 0, 0, "a frame's number");
    const int node = rows.node(1, -1, "a frame's node");
    if (!runs.empty() && runs.back().node == node && runs.back().lastFrame + 1 == frame)
      runs.back().lastFrame = frame;
    else
      runs.push_back({node, frame, frame});
  }
  std::ranges::sort(runs, {}, &Visit::firstFrame);
  std::vector<Visit> visits;
  for (const Visit& run : runs) {
    addFrame(visits, run.node, run.firstFrame);
    visits.back().lastFrame = run.lastFrame;
  }
  return visits;
}

}  // namespace estancia
